//! Shadow casters: what may cast a shadow of a light on something that a camera sees.
//!
//! Idea: look from the light. What a camera sees, as boxes in the light's views, makes a mask of the farthest receiver in each
//!     cell; only what is before it in some cell can cast a shadow on it. Portals are followed from the light, so each
//!     passage of the light has its casters, and what is behind a closed door neither casts nor receives.
//! Source: Bittner, Mattausch, Silvennoinen, Wimmer, Shadow Caster Culling for Efficient Shadow Mapping, I3D 2011.
//! Cost: a look from each of the light's views, and O(receivers + casters) for each passage of it.
//! Conservative: boxes are rounded outward, and a cell holds the farthest of its receivers.

mod light_views;
mod mask;
mod receivers;

use crate::geom::Aabb;
use crate::ids::LightId;
use crate::look_many::{Task, look_each};
use crate::scene::{Light, LightShape, Scene};
use crate::view::View;
use crate::view::options::ViewerOptions;
use crate::view::passage::Passage;
use crate::view::region::{Clip, Region, Volume};
use crate::view::screen_map::ScreenMap;
use crate::view::viewer::Viewer;
use crate::view::viewers::KeptView;
use crate::view::visible::VisibleSet;
use glam::DVec3;
use mask::ReceiverMask;
use receivers::Receiver;

/// Finds the items that may cast a shadow of a light on something visible: what to draw into the light's shadow maps.
///
/// ```
/// # use enfilade::*;
/// let mut yard = GeometryBuilder::new([Material::opaque([0.6; 3])]);
/// let ground = yard.mesh(Mesh::cuboid([-50.0, -1.0, -50.0], [50.0, 0.0, 50.0], MaterialId(0))?);
/// let tower = yard.mesh(Mesh::cuboid([-1.0, 0.0, -1.0], [1.0, 9.0, 1.0], MaterialId(0))?);
/// yard.item("ground", ground, Transform::IDENTITY);
/// yard.item("tower behind the camera", tower, Transform::translation([0.0, 0.0, 6.0]));
/// yard.item("tower far behind it", tower, Transform::translation([0.0, 0.0, 40.0]));
/// let mut scene = Scene::single(yard.build()?, Method::Masked)?;
/// let shape = LightShape::Sun { direction: [0.0, -1.0, -1.0] };
/// let sun = Light { shape, ..Light::point(SectorId(0), [0.0; 3], [1.0; 3], f32::INFINITY) };
/// let sun = scene.add_light(sun)?;
///
/// let mut viewer = Viewer::new();
/// let set = viewer.look(&scene, &View::new([0.0, 2.0, 0.0], [0.0, 1.0, -9.0], [640, 360])?);
/// assert_eq!(set.names(&scene).collect::<Vec<_>>(), ["ground"]);
/// let mut shadows = ShadowCasters::new();
/// let maps = shadows.find(&scene, sun, set);
/// assert_eq!(maps[0].casters.names(&scene).collect::<Vec<_>>(), ["ground", "tower behind the camera"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias = "shadow map")]
#[doc(alias = "shadow culling")]
#[doc(alias = "cascaded shadow maps")]
pub struct ShadowCasters {
    /// Options of the looks from lights. [`ViewerOptions::occlusion`] is off: what is hidden from the light casts no shadow of
    /// its own, but a renderer with other samples than the look may need it. Turn it on for shadow maps of
    /// [`ShadowCasters::map_size`], with a [`ViewerOptions::growth_px`] of 1, where much is hidden.
    pub options: ViewerOptions,
    /// Width and height of the light's views, in pixels, 1 to [`View::MAX_PIXELS`]. Default 1024.
    pub map_size: u32,
    /// Where the cascades of a sun end: distances along the view direction of the camera, ascending. What is beyond the last
    /// receives no shadows. Default empty: one view of everything visible.
    pub cascades: Vec<f64>,
    maps: Vec<LightView>,
    kept: Vec<KeptView>,
    viewers: Vec<Viewer>,
    /// By cascade.
    receivers: Vec<Vec<Receiver>>,
    mask: ReceiverMask,
}

/// A view of a light, and what may cast shadows there.
pub struct LightView {
    /// Number of the cascade of a sun, or of the face of the cube around a point light: +x, −x, +y, −y, +z, −z of its sector.
    pub number: u32,
    /// The view of a shadow map. It has one view direction, whatever portals its light passes: draw each passage by its own
    /// matrix, as those of a camera.
    pub view: View,
    /// The passages of the light, and the casters in each. Some may be missing if [`VisibleSet::complete`] is `false`: the light
    /// passes more portals than [`ShadowCasters::options`] allows.
    pub casters: VisibleSet,
}

impl Default for ShadowCasters {
    fn default() -> ShadowCasters {
        ShadowCasters {
            options: ViewerOptions {
                occlusion: false,
                ..ViewerOptions::default()
            },
            map_size: 1024,
            cascades: Vec::new(),
            maps: Vec::new(),
            kept: Vec::new(),
            viewers: Vec::new(),
            receivers: Vec::new(),
            mask: ReceiverMask::default(),
        }
    }
}

impl ShadowCasters {
    /// Creates an instance with default options and empty buffers.
    pub fn new() -> ShadowCasters {
        ShadowCasters::default()
    }

    /// Finds what casts shadows of a light on the items of a visible set: one view for each cascade of a sun, one for a spot
    /// light, up to six for a point light. A complete view without casters is left out, so the result is empty if the light
    /// reaches nothing visible.
    ///
    /// Limits of distance and size of items ([`ItemOptions`](crate::ItemOptions)) do not apply. The views are in the space of
    /// the light's sector.
    ///
    /// # Panics
    /// If the light is not of the scene, or the set was not looked at in it.
    pub fn find(&mut self, scene: &Scene, light: LightId, visible: &VisibleSet) -> &[LightView] {
        let lamp = &scene.lights()[light.0 as usize];
        let size = self.map_size.clamp(1, View::MAX_PIXELS);
        let ends = match lamp.shape {
            LightShape::Sun { .. } if !self.cascades.is_empty() => &self.cascades[..],
            _ => &[f64::INFINITY],
        };
        self.receivers.resize_with(ends.len(), Vec::new);
        let (mut views, mut start) = (Vec::new(), 0.0);
        for ((cascade, &end), receivers) in (0..).zip(ends).zip(&mut self.receivers) {
            receivers.clear();
            receivers::gather(scene, visible, [start, end], receivers);
            start = end;
            let of_light = light_views::of_light(scene, light, receivers, size, &self.options.limits);
            views.extend(of_light.into_iter().map(|(face, view)| Request {
                number: cascade as u32 + face,
                view,
                cascade,
            }));
        }
        self.look(scene, lamp, &views)
    }

    /// Finds what casts shadows of a light on the items of a visible set, in views that the renderer has chosen. They are taken
    /// as views from the light's sector. Those that are complete and without casters are left out;
    /// [`LightView::number`] is the index of a view in `views`.
    ///
    /// A parallel view should begin before everything that casts shadows.
    ///
    /// # Panics
    /// As [`ShadowCasters::find`].
    pub fn find_in(
        &mut self,
        scene: &Scene,
        light: LightId,
        views: &[View],
        visible: &VisibleSet,
    ) -> &[LightView] {
        let lamp = &scene.lights()[light.0 as usize];
        self.receivers.resize_with(1, Vec::new);
        self.receivers[0].clear();
        receivers::gather(scene, visible, [0.0, f64::INFINITY], &mut self.receivers[0]);
        let views = (0..).zip(views).map(|(number, view)| Request {
            number,
            view: view.of_light(lamp.sector),
            cascade: 0,
        });
        let views: Vec<Request> = views.collect();
        self.look(scene, lamp, &views)
    }

    /// Looks from a light, and keeps what is before a receiver of its cascade.
    fn look(&mut self, scene: &Scene, lamp: &Light, views: &[Request]) -> &[LightView] {
        let mut sets: Vec<VisibleSet> = self.maps.drain(..).map(|map| map.casters).collect();
        self.maps.extend(views.iter().map(|request| LightView {
            number: request.number,
            view: request.view,
            casters: sets.pop().unwrap_or_default(),
        }));
        self.kept.resize_with(self.maps.len(), KeptView::default);
        let each = self.maps.iter_mut().zip(&mut self.kept);
        let mut tasks: Vec<Task> = each
            .map(|(LightView { view, casters, .. }, kept)| Task {
                view,
                set: casters,
                kept,
            })
            .collect();
        look_each(&mut self.viewers, &self.options, scene, &mut tasks);
        for (map, request) in self.maps.iter_mut().zip(views) {
            let receivers = &self.receivers[request.cascade];
            keep_casters(scene, map, receivers, range_of(lamp), &mut self.mask);
        }
        self.maps
            .retain(|map| !(map.casters.items().is_empty() && map.casters.complete()));
        &self.maps
    }
}

/// A view to look from.
struct Request {
    /// [`LightView::number`].
    number: u32,
    view: View,
    /// Number of the list of receivers.
    cascade: usize,
}

/// Returns how far a light reaches, in units of its sector.
fn range_of(light: &Light) -> f64 {
    match light.shape {
        LightShape::Sun { .. } => f64::INFINITY,
        _ => f64::from(light.range),
    }
}

/// Removes from the set of a light's view what is before none of the receivers, which are sorted by sector.
fn keep_casters(
    scene: &Scene,
    map: &mut LightView,
    receivers: &[Receiver],
    range: f64,
    mask: &mut ReceiverMask,
) {
    mask.clear(map.view.size());
    for passage in map.casters.passages() {
        let first = receivers.partition_point(|receiver| receiver.sector < passage.sector);
        let here = receivers[first..].iter();
        for receiver in here.take_while(|receiver| receiver.sector == passage.sector) {
            if distance_to(passage, &receiver.bounds) > range {
                continue;
            }
            if let Some(region) = region(passage, &passage.screen_from_sector, &receiver.bounds) {
                mask.add(&region.rect, farthest(passage, &region.volume));
            }
        }
    }
    let VisibleSet { passages, items, .. } = &mut map.casters;
    items.retain(|seen| {
        let passage = &passages[seen.passage.0 as usize];
        let region = match scene.geometry(passage.sector) {
            Some(geometry) => {
                let screen_from_item = passage.screen_from(&geometry.item(seen.item.index).transform());
                region(
                    passage,
                    &screen_from_item,
                    &geometry.mesh_of(seen.item.index).bounds(),
                )
            }
            None => {
                let bounds = scene.sector(passage.sector).item_bounds(seen.item.index);
                if bounds.is_empty() {
                    return true;
                }
                region(passage, &passage.screen_from_sector, &bounds)
            }
        };
        region.is_some_and(|Region { rect, nearest, .. }| {
            mask.is_before_any(&rect, passage.distance_at(f64::from(nearest)))
        })
    });
}

/// Projects a box to a light's view, for any sample position.
fn region(passage: &Passage, screen_from_local: &ScreenMap, bounds: &Aabb) -> Option<Region> {
    let clip = Clip {
        spread: 0.5,
        ..passage.into()
    };
    Region::of(clip, screen_from_local, bounds)
}

/// Returns the greatest distance along the view direction of any point of a volume.
fn farthest(passage: &Passage, volume: &Volume) -> f64 {
    let sides = volume.sides.iter().map(|side| side.z);
    if passage.is_parallel() {
        return passage.distance_at(volume.origin.z + sides.map(|side| side.min(0.0)).sum::<f64>());
    }
    volume.origin.z + sides.map(|side| side.max(0.0)).sum::<f64>()
}

/// Returns the distance of a box from the light, in units of the light's sector.
fn distance_to(passage: &Passage, bounds: &Aabb) -> f64 {
    let light = DVec3::from(passage.eye());
    let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
    (min - light).max(light - max).max(DVec3::ZERO).length() * passage.eye_scale()
}
