//! A walk through a scene: the camera, the visible set of each frame, and the frozen one.

use crate::explain::{Explanation, explain};
use crate::places::{SectorPlacement, placed_items, places};
use crate::walker::Walker;
use crate::world::World;
use enfilade::{
    Camera, Hit, ItemIndex, Method, PortalId, Ray, RayEnd, Scene, SectorId, Transform, View, Viewer,
};
use enfilade_wgpu::PlacedItem;
use glam::DVec3;
use web_time::Instant;

/// The scene, who walks through it, and what is seen.
pub struct Session {
    /// The scene.
    pub world: World,
    /// The camera, or the one above a frozen scene.
    pub walker: Walker,
    /// Holds the visible set: of this frame, or the frozen one.
    pub viewer: Viewer,
    /// The view of the last look.
    pub view: View,
    /// What was frozen, if anything is.
    pub frozen: Option<Frozen>,
    /// The item that was clicked.
    pub selected: Option<Selected>,
    /// Whether ghosts are drawn of what is not visible.
    pub ghosts: bool,
    /// Numbers of the last look.
    pub stats: LookStats,
    /// Number of changes of the scene and of the viewer's options.
    changes: u64,
    /// What the explanation of the selected item is of.
    explained: Option<LookKey>,
}

/// What a look depends on: the view, and the changes of the scene and the options before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookKey(View, u64);

/// A visible set that is looked at from outside.
pub struct Frozen {
    /// The camera to go back to.
    pub walker: Walker,
    /// Where sectors are.
    pub places: Vec<SectorPlacement>,
    /// What is drawn.
    pub items: Vec<PlacedItem>,
    /// Number of ghosts that are not drawn, because there are too many.
    pub left_out: usize,
}

/// An item that was clicked.
pub struct Selected {
    /// Its sector.
    pub sector: SectorId,
    /// The item.
    pub item: ItemIndex,
    /// Maps its sector to the space of the camera's.
    pub root_from_sector: Transform,
    /// Why it is drawn, or not.
    pub explanation: Explanation,
}

/// Numbers of one look.
#[derive(Clone, Copy, Debug, Default)]
pub struct LookStats {
    /// Time of the look, in milliseconds.
    pub look_ms: f64,
    /// Visible items.
    pub items: usize,
    /// Visible triangles.
    pub triangles: u64,
    /// Passages.
    pub passages: usize,
    /// Items that frustum culling alone would leave of the visible sectors.
    pub items_in_frustum: usize,
    /// Their triangles.
    pub triangles_in_frustum: u64,
    /// Whether every visible open portal was followed.
    pub complete: bool,
}

impl Session {
    /// Starts at the first camera of a scene.
    pub fn new(world: World) -> Session {
        let walker = Walker::new(&world.scene, &world.cameras[0], world.metre);
        let mut session = Session {
            view: walker
                .camera(&world.scene)
                .view([64, 64])
                .unwrap_or_else(|_| origin()),
            walker,
            world,
            viewer: Viewer::new(),
            frozen: None,
            selected: None,
            ghosts: true,
            stats: LookStats::default(),
            changes: 0,
            explained: None,
        };
        session.look([64, 64]);
        session
    }

    /// Looks, unless the set is frozen. Returns the view to draw, of this size.
    pub fn look(&mut self, size: [u32; 2]) -> View {
        let camera = self.walker.camera(&self.world.scene);
        let seen = camera.view(size).unwrap_or(self.view);
        if self.frozen.is_none() {
            self.view = seen;
            self.update();
        }
        seen
    }

    /// Returns what the last look depended on.
    pub fn key(&self) -> LookKey {
        LookKey(self.view, self.changes)
    }

    /// Looks with the view of the last look, after the scene or the options have changed.
    pub fn look_again(&mut self) {
        self.changes += 1;
        self.update();
    }

    fn update(&mut self) {
        let scene = &self.world.scene;
        let start = Instant::now();
        let set = self.viewer.look(scene, &self.view);
        let look_ms = start.elapsed().as_secs_f64() * 1e3;
        let (items_in_frustum, triangles_in_frustum) = set.in_frustum(scene);
        self.stats = LookStats {
            look_ms,
            items: set.items().len(),
            triangles: set.triangle_count(scene),
            passages: set.passages().len(),
            items_in_frustum,
            triangles_in_frustum,
            complete: set.complete(),
        };
        if self.frozen.is_some() {
            self.place();
        }
        // Rays are cast for an item that is hidden: not in each frame.
        if let Some(Selected { sector, item, .. }) = self.selected
            && self.explained != Some(self.key())
        {
            self.explain(sector, item);
        }
    }

    /// Freezes the visible set to look at it from outside, or goes back to where it was frozen.
    pub fn toggle_frozen(&mut self) {
        if let Some(frozen) = self.frozen.take() {
            self.walker = frozen.walker;
            return;
        }
        self.frozen = Some(Frozen {
            walker: self.walker.clone(),
            places: Vec::new(),
            items: Vec::new(),
            left_out: 0,
        });
        let scene = &self.world.scene;
        self.walker.set_walks(scene, false);
        self.walker.is_free = true;
        self.place();
    }

    /// Moves the camera above the frozen one, looking at what that sees.
    pub fn rise(&mut self) {
        let eye = DVec3::from(self.view.eye());
        let ahead = (DVec3::from(self.view.toward()) - eye).normalize_or(DVec3::NEG_Z);
        let up = DVec3::from(self.view.up()).normalize_or(DVec3::Y);
        let size = 12.0 * self.world.metre;
        let camera = Camera {
            eye: (eye - 0.5 * size * ahead + size * up).into(),
            toward: (eye + 0.6 * size * ahead).into(),
            up: up.into(),
            ..self.walker.camera(&self.world.scene)
        };
        self.walker = Walker::new(&self.world.scene, &camera, self.world.metre);
        self.walker.is_free = self.frozen.is_some();
    }

    /// Places the items of the frozen set.
    pub fn place(&mut self) {
        let scene = &self.world.scene;
        if let Some(frozen) = &mut self.frozen {
            frozen.places = places(scene, &self.viewer, &self.view);
            (frozen.items, frozen.left_out) = placed_items(scene, &self.viewer, &frozen.places, self.ghosts);
        }
    }

    /// Selects the item at a pixel of a view that [`Session::look`] returned.
    pub fn select(&mut self, view: &View, at: [f64; 2]) {
        self.selected = None;
        let [origin, direction] = view.ray(at);
        if let Some((sector, item, root_from_sector)) = self.hit(view, origin, direction) {
            self.selected = Some(Selected {
                sector,
                item,
                root_from_sector,
                explanation: Explanation::default(),
            });
            self.explain(sector, item);
        }
    }

    /// Returns the first items whose name contains a text, whatever its case, at most `most`.
    pub fn find(&self, text: &str, most: usize) -> Vec<(SectorId, ItemIndex, String)> {
        let (scene, text) = (&self.world.scene, text.to_lowercase());
        let geometries = scene.sectors().filter_map(|id| Some((id, scene.geometry(id)?)));
        let items = geometries.flat_map(|(sector, geometry)| {
            let items = (0..geometry.items().len() as u32).map(ItemIndex);
            items
                .filter(|&item| geometry.holds(item))
                .map(move |item| (sector, item, geometry.name(item)))
        });
        let found = items.filter(|(.., name)| name.to_lowercase().contains(&text));
        found
            .take(most)
            .map(|(sector, item, name)| (sector, item, name.to_owned()))
            .collect()
    }

    /// Selects an item.
    pub fn select_item(&mut self, sector: SectorId, item: ItemIndex) {
        let places = places(&self.world.scene, &self.viewer, &self.view);
        let place = places.iter().rev().find(|place| place.sector == sector);
        self.selected = Some(Selected {
            sector,
            item,
            root_from_sector: place.map_or(Transform::IDENTITY, |place| place.root_from_sector),
            explanation: Explanation::default(),
        });
        self.explain(sector, item);
    }

    fn explain(&mut self, sector: SectorId, item: ItemIndex) {
        let explanation = explain(&self.world.scene, &self.view, self.viewer.visible(), sector, item);
        if let Some(selected) = &mut self.selected {
            selected.explanation = explanation;
        }
        self.explained = Some(self.key());
    }

    fn hit(
        &self,
        view: &View,
        origin: [f64; 3],
        direction: [f64; 3],
    ) -> Option<(SectorId, ItemIndex, Transform)> {
        let scene = &self.world.scene;
        let Some(frozen) = &self.frozen else {
            let ray = ray(DVec3::from(origin), DVec3::from(direction));
            let cast = scene.cast(scene.sector_of(view)?, &ray);
            let RayEnd::Face(hit) = cast.end else { return None };
            let root_from_sector = cast.there_from_here.inverse()?;
            let ray = through(&cast.there_from_here, origin, direction);
            let item = match is_drawn(scene, cast.sector, &hit) {
                true => hit.item.index,
                false => first_drawn(scene, cast.sector, &ray, |_| true)?.item.index,
            };
            return Some((cast.sector, item, root_from_sector));
        };
        // The nearest of all places.
        let mut nearest: Option<(f64, SectorId, ItemIndex, Transform)> = None;
        for place in &frozen.places {
            let Some(sector_from_root) = place.root_from_sector.inverse() else {
                continue;
            };
            let ray = through(&sector_from_root, origin, direction);
            let shows = |item| {
                self.ghosts
                    || frozen.items.iter().any(|placed| {
                        placed.visible.is_some() && (placed.sector, placed.item) == (place.sector, item)
                    })
            };
            if let Some(hit) = first_drawn(scene, place.sector, &ray, shows)
                && nearest.is_none_or(|(distance, ..)| hit.distance < distance)
            {
                nearest = Some((hit.distance, place.sector, hit.item.index, place.root_from_sector));
            }
        }
        nearest.map(|(_, sector, item, root_from_sector)| (sector, item, root_from_sector))
    }

    /// Opens or closes the nearest portal at a pixel, and the one that leads back. Returns its name.
    pub fn toggle_portal(&mut self, view: &View, at: [f64; 2]) -> Option<String> {
        let scene = &self.world.scene;
        let [origin, direction] = view.ray(at).map(DVec3::from);
        let sector = scene.sector_of(view).filter(|_| self.frozen.is_none())?;
        let cast = scene.cast(sector, &ray(origin, direction));
        let portal = match (cast.crossed.first(), cast.end) {
            (Some(&first), _) => first,
            (None, RayEnd::Closed(opening)) => scene.portal_of(cast.sector, opening)?,
            _ => return None,
        };
        let open = !scene.portals()[portal.0 as usize].open;
        let back = (0..scene.portals().len() as u32)
            .map(PortalId)
            .find(|&other| other != portal && scene.has_portal(other) && scene.leads_back(portal, other));
        let name = opening_name(scene, portal).to_owned();
        self.world.scene.set_open(portal, open);
        if let Some(back) = back {
            self.world.scene.set_open(back, open);
        }
        self.look_again();
        Some(format!("{} `{name}`", if open { "opened" } else { "closed" }))
    }

    /// Uses a method in one sector, or in all that can use it.
    ///
    /// # Errors
    /// If the method does not suit the sector, or none.
    pub fn set_method(&mut self, method: Method, only: Option<SectorId>) -> Result<(), String> {
        let scene = &mut self.world.scene;
        let sectors: Vec<SectorId> = scene
            .sectors()
            .filter(|id| only.is_none_or(|only| only == *id))
            .collect();
        let (mut done, mut error) = (0, String::new());
        for sector in sectors {
            if scene.geometry(sector).is_none() || scene.method(sector) == Some(method) {
                continue;
            }
            match scene.set_method(sector, method) {
                Ok(()) => done += 1,
                Err(why) => error = why.to_string(),
            }
        }
        self.look_again();
        if done == 0 && !error.is_empty() {
            Err(error)
        } else {
            Ok(())
        }
    }
}

/// Returns the name of the opening of a portal.
pub fn opening_name(scene: &Scene, portal: PortalId) -> &str {
    let portal = &scene.portals()[portal.0 as usize];
    &scene.sector(portal.from).openings()[usize::from(portal.opening.0)].name
}

fn ray(origin: DVec3, direction: DVec3) -> Ray {
    Ray {
        origin: origin.as_vec3().into(),
        direction: direction.as_vec3().into(),
    }
}

/// Returns a ray of the camera's sector in another sector.
fn through(there_from_here: &Transform, origin: [f64; 3], direction: [f64; 3]) -> Ray {
    let [from, to] = [DVec3::from(origin), DVec3::from(origin) + DVec3::from(direction)]
        .map(|at| DVec3::from(there_from_here.point(at.as_vec3().into()).map(f64::from)));
    ray(from, to - from)
}

/// Returns whether a picture has a face that was hit: backs of one-sided faces are not drawn.
fn is_drawn(scene: &Scene, sector: SectorId, hit: &Hit) -> bool {
    let Some(geometry) = scene.geometry(sector).filter(|_| hit.from_behind) else {
        return true;
    };
    let (item, mesh) = (hit.item.index, geometry.mesh_of(hit.item.index));
    let cluster = &mesh.clusters()[mesh.cluster_of(hit.face)];
    geometry.material_of(item, cluster).double_sided
}

/// Returns the first face along a ray in a sector that a picture with some of its items has.
fn first_drawn(scene: &Scene, sector: SectorId, ray: &Ray, shows: impl Fn(ItemIndex) -> bool) -> Option<Hit> {
    let is_shown = |hit: &Hit| is_drawn(scene, sector, hit) && shows(hit.item.index);
    let Some(geometry) = scene.geometry(sector) else {
        return scene.sector(sector).cast(ray).filter(is_shown);
    };
    let mut hits = Vec::new();
    geometry.cast_all(ray, f64::INFINITY, &mut hits);
    hits.into_iter().find(is_shown)
}

/// Returns a view of a scene whose cameras are all invalid.
fn origin() -> View {
    View::new([0.0; 3], [0.0, 0.0, -1.0], [64, 64]).expect("a valid view")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn palace() -> Session {
        Session::new(World::open("@enfilade").expect("a built-in scene"))
    }

    #[test]
    fn a_frozen_palace_shows_every_item_at_its_place_or_as_a_ghost() {
        let mut session = palace();
        session.look([320, 240]);
        session.toggle_frozen();
        let frozen = session.frozen.as_ref().expect("it is frozen");
        let visible = frozen.items.iter().filter(|item| item.visible.is_some()).count();
        assert_eq!(visible, session.stats.items);
        let ghosts = frozen.items.iter().filter(|item| item.ghost.is_some()).count();
        assert!(ghosts > session.world.scene.item_count() / 2, "{ghosts}");
        // Flying does not change the set.
        let before = session.view;
        session.walker.step(&session.world.scene, [0.0, 1.0, 0.0], 5.0);
        session.look([320, 240]);
        assert_eq!(session.view, before);
        session.toggle_frozen();
        assert_eq!(session.look([320, 240]).eye(), before.eye());
    }

    #[test]
    fn a_click_says_why_an_item_is_visible_and_why_one_behind_a_wall_is_not() {
        let mut session = palace();
        let view = session.look([320, 240]);
        session.select(&view, [30.0, 200.0]);
        let selected = session.selected.as_ref().expect("the floor");
        assert!(selected.explanation.is_visible);
        let scene = &session.world.scene;
        assert!(session.find("STATUE", 100).len() > 10);
        let set = session.viewer.visible();
        // Items of the camera's own sector that are not in the set.
        let sector = set.passages()[0].sector;
        let geometry = scene.geometry(sector).expect("no custom sector");
        let mut said = 0;
        for item in (0..geometry.items().len() as u32).map(ItemIndex) {
            if !set.sees(sector, geometry.id_of(item)) {
                let why = explain(scene, &session.view, set, sector, item);
                assert!(!why.is_visible && !why.reasons.is_empty());
                said += usize::from(why.reasons[0].contains("frustum"));
            }
        }
        assert!(said > 10, "{said}");
    }

    #[test]
    fn a_click_from_above_selects_the_floor_and_not_the_backs_of_the_walls_before_it() {
        let mut session = palace();
        session.look([320, 240]);
        session.toggle_frozen();
        session.ghosts = false;
        session.place();
        session.rise();
        let view = session.look([320, 240]);
        let (mut hits, mut hidden) = (0, Vec::new());
        for number in 0..12 * 9 {
            session.select(
                &view,
                [
                    f64::from(number % 12) * 26.0 + 17.0,
                    f64::from(number / 12) * 26.0 + 16.0,
                ],
            );
            if let Some(selected) = &session.selected {
                hits += 1;
                if !selected.explanation.is_visible {
                    hidden.push(selected.explanation.name.clone());
                }
            }
        }
        assert!(hits > 20, "{hits}");
        assert_eq!(hidden, [""; 0], "these are not in the picture");
    }

    #[test]
    fn a_portal_that_is_clicked_closes_and_opens_again() {
        let mut session = palace();
        let view = session.look([320, 240]);
        let open = |session: &Session| {
            session
                .world
                .scene
                .portals()
                .iter()
                .filter(|portal| portal.open)
                .count()
        };
        let before = open(&session);
        let key = session.key();
        let said = session.toggle_portal(&view, [160.0, 130.0]).expect("a door");
        assert!(said.starts_with("closed"), "{said}");
        assert_ne!(session.key(), key, "diagnostic pictures are made again");
        assert_eq!(open(&session), before - 2);
        let said = session.toggle_portal(&view, [160.0, 130.0]).expect("a door");
        assert!(said.starts_with("opened"), "{said}");
        assert_eq!(open(&session), before);
    }
}
