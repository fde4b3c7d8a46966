//! The aggregate: fragments joined by portals. Only this folder knows where openings lead.
//!
//! A scene can stand in another like a fragment: its fragments become the outer scene's when that is built, its
//! named exits become openings to join. So a look follows one flat graph, however deeply scenes are nested.
//! Source: Boreskov, Using portals to create aggregate scenes; RenderWare, Portal culling.

mod builder;
mod edit;
mod error;
mod light;
mod locate;
mod portal;

pub use builder::{End, NestedId, SceneBuilder};
pub use edit::{Edit, EditError};
pub use error::{SceneError, Way};
pub use light::{Light, LightId, LightShape};
pub use portal::{FragmentId, Portal, PortalId};

use crate::content::{Content, ItemId, OpeningId};
use crate::fragment::{Built, Fragment};
use crate::geom::{Aabb, Transform};
use crate::method::{Method, Ours, Unsuited};
use crate::threads;
use crate::view::View;
use locate::Boxes;
use std::collections::HashSet;
use std::sync::Arc;

/// Fragments, and portals that join them. Shared and immutable while looked at.
#[derive(Clone)]
pub struct Scene {
    fragments: Vec<Placed>,
    boxes: Boxes,
    portals: Vec<Portal>,
    /// The portal of each opening, fragment after fragment; `first_opening` says where a fragment's begin.
    portal_of: Vec<Option<PortalId>>,
    first_opening: Vec<u32>,
    flat: bool,
    lights: Vec<Light>,
    /// What one fragment's method may build, in bytes.
    limit_bytes: u64,
    /// Openings through which one leaves the scene, when it stands in another.
    exits: Vec<Exit>,
}

/// A fragment in a scene.
#[derive(Clone)]
struct Placed {
    name: String,
    body: Body,
    /// It has no top: its box goes up without end.
    open_above: bool,
    /// How often its method was built.
    builds: u64,
}

#[derive(Clone)]
enum Body {
    /// Content seen by a method of ours; the method can be exchanged.
    Ours { method: Method, fragment: Arc<dyn Ours> },
    /// A fragment of the user's own.
    Own(Arc<dyn Fragment>),
}

/// A named way out of a scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Exit {
    name: String,
    fragment: FragmentId,
    opening: OpeningId,
}

impl Scene {
    /// How many fragments there are.
    pub fn fragment_count(&self) -> usize {
        self.fragments.len()
    }

    /// The ids of all fragments.
    pub fn fragments(&self) -> impl Iterator<Item = FragmentId> + use<> {
        (0..self.fragments.len() as u32).map(FragmentId)
    }

    /// A fragment, as whatever sees it.
    pub fn fragment(&self, id: FragmentId) -> &dyn Fragment {
        self.fragments[id.0 as usize].fragment()
    }

    /// A fragment's name.
    pub fn fragment_name(&self, id: FragmentId) -> &str {
        &self.fragments[id.0 as usize].name
    }

    /// What a fragment is made of; `None` where it is one of the user's own.
    pub fn content(&self, id: FragmentId) -> Option<&Arc<Content>> {
        match &self.fragments[id.0 as usize].body {
            Body::Ours { fragment, .. } => Some(fragment.content()),
            Body::Own(_) => None,
        }
    }

    /// How a fragment is seen; `None` where it is one of the user's own.
    pub fn method(&self, id: FragmentId) -> Option<Method> {
        match &self.fragments[id.0 as usize].body {
            Body::Ours { method, .. } => Some(*method),
            Body::Own(_) => None,
        }
    }

    /// The portals, by [`PortalId`].
    pub fn portals(&self) -> &[Portal] {
        &self.portals
    }

    /// Where an opening leads; `None` where it leads nowhere.
    pub fn portal_of(&self, fragment: FragmentId, opening: OpeningId) -> Option<PortalId> {
        let [first, end] = [0, 1].map(|next| self.first_opening[fragment.0 as usize + next]);
        let index = first + u32::from(opening.0);
        if index < end {
            self.portal_of[index as usize]
        } else {
            None
        }
    }

    /// Opens or closes a portal, in O(1). The way back, if there is one, is a portal of its own.
    pub fn set_open(&mut self, portal: PortalId, open: bool) {
        self.portals[portal.0 as usize].open = open;
    }

    /// Gives a fragment other content, seen by the same method: what moves every frame has a fragment of its own, and no
    /// other is touched. Its openings may move but not become more or fewer.
    ///
    /// Cost: that of building the method, which is next to nothing for [`Method::ZBuffer`] and [`Method::SBuffer`].
    ///
    /// # Errors
    /// [`SceneError::NotOurs`], [`SceneError::Openings`], [`SceneError::TooLarge`], [`SceneError::NotBaked`] or
    /// [`SceneError::NotConvex`], and then it stays as it was.
    pub fn set_content(
        &mut self,
        id: FragmentId,
        content: impl Into<Arc<Content>>,
    ) -> Result<(), SceneError> {
        let content = content.into();
        let (before, method) = self.ours(id)?;
        let [had, has] = [before, &content].map(|content| content.openings().len());
        if had != has {
            let fragment = self.fragment_name(id).to_owned();
            return Err(SceneError::Openings { fragment, had, has });
        }
        self.rebuild(id, content, method)?;
        let space = self.fragments[id.0 as usize].space();
        self.boxes.change(id, space);
        Ok(())
    }

    /// Has a fragment seen by another method; no other is touched.
    ///
    /// # Errors
    /// [`SceneError::NotOurs`], [`SceneError::TooLarge`], [`SceneError::NotBaked`], [`SceneError::NotConvex`] or [`SceneError::NoTerrain`], and then it
    /// stays as it was.
    pub fn set_method(&mut self, id: FragmentId, method: Method) -> Result<(), SceneError> {
        let (content, _) = self.ours(id)?;
        self.rebuild(id, Arc::clone(content), method)
    }

    fn ours(&self, id: FragmentId) -> Result<(&Arc<Content>, Method), SceneError> {
        match &self.fragments[id.0 as usize].body {
            Body::Ours { fragment, method } => Ok((fragment.content(), *method)),
            Body::Own(_) => Err(SceneError::NotOurs(self.fragment_name(id).to_owned())),
        }
    }

    fn rebuild(&mut self, id: FragmentId, content: Arc<Content>, method: Method) -> Result<(), SceneError> {
        let placed = &mut self.fragments[id.0 as usize];
        let built = placed.rebuild(content, method, self.limit_bytes);
        built.map_err(|why| SceneError::unsuited(&placed.name, why))
    }

    /// How often a fragment's method was built since the fragment was added; 0 of one of the user's own.
    pub fn builds(&self, id: FragmentId) -> u64 {
        self.fragments[id.0 as usize].builds
    }

    /// Moves where a portal leads, in O(1): the fragment behind it moves as a whole.
    ///
    /// # Errors
    /// [`SceneError::NotSimilar`] or [`SceneError::TooFar`], and then it stays as it was.
    pub fn set_portal(&mut self, portal: PortalId, there_from_here: Transform) -> Result<(), SceneError> {
        if !there_from_here.is_similarity() {
            return Err(SceneError::NotSimilar(portal.0 as usize));
        }
        let mut moved = self.portals[portal.0 as usize].clone();
        moved.there_from_here = there_from_here;
        let openings = self.fragment(moved.from).openings();
        if !moved.leads_in_range(&openings[usize::from(moved.opening.0)]) {
            return Err(SceneError::TooFar(portal.0 as usize));
        }
        self.portals[portal.0 as usize] = moved;
        Ok(())
    }

    /// The same scene with every fragment of ours seen by `method`. Contents are shared, not copied.
    ///
    /// # Errors
    /// [`Unsuited::TooLarge`] where a fragment would need more than `limit_bytes` for what the method builds,
    /// [`Unsuited::NotBaked`], [`Unsuited::NotConvex`] or [`Unsuited::NoTerrain`] where one has not what the method goes by.
    pub fn with_method(&self, method: Method, limit_bytes: u64) -> Result<Scene, Unsuited> {
        let mut scene = self.clone();
        scene.limit_bytes = limit_bytes;
        // Of fragments of one content the first builds what the others share: side by side each would build its own.
        let mut contents = HashSet::new();
        let is_first = |placed: &&mut Placed| match &placed.body {
            Body::Ours { fragment, .. } => contents.insert(Arc::as_ptr(fragment.content())),
            Body::Own(_) => false,
        };
        let (first, others): (Vec<_>, Vec<_>) = scene.fragments.iter_mut().partition(is_first);
        for fragments in [first, others] {
            let mut building: Vec<_> = fragments.into_iter().map(|placed| (placed, Ok(()))).collect();
            threads::for_each(&mut building, |_, (placed, built)| {
                if let Body::Ours { fragment, .. } = &placed.body {
                    *built = placed.rebuild(Arc::clone(fragment.content()), method, limit_bytes);
                }
            });
            building.into_iter().try_for_each(|(_, built)| built)?;
        }
        Ok(scene)
    }

    /// Has every fragment of ours what a method goes by ([`Method::suits`])?
    pub fn suits(&self, method: Method) -> bool {
        let mut contents = self.fragments().filter_map(|id| self.content(id));
        contents.all(|content| method.suits(content))
    }

    /// The same scene with its openings as plain holes: no portal is followed.
    #[must_use]
    pub fn without_portals(&self) -> Scene {
        Scene {
            flat: true,
            ..self.clone()
        }
    }

    pub(crate) fn is_flat(&self) -> bool {
        self.flat
    }

    /// The fragment that a point stands in: of those whose boxes hold it, the smallest; else the one whose box is
    /// nearest. `None` only where the scene has no fragment.
    ///
    /// The box of a fragment that is [open above](SceneBuilder::open_above) has no top: whoever is on a roof or a balcony is in
    /// the garden. Of several such boxes, the smallest is the one that covers the least ground.
    ///
    /// Boxes that end in a doorway both hold an eye that stands in it: then the one whose middle is nearer to where
    /// the eye looks (`toward`) is taken, so that the doorway is behind the eye.
    ///
    /// Cost: O(log fragments) where few boxes overlap.
    pub fn locate(&self, point: [f32; 3], toward: [f32; 3]) -> Option<FragmentId> {
        self.boxes.locate(point, toward)
    }

    /// The fragment that a view's eye stands in; `None` where the scene has none, or not the one that the view names.
    pub fn fragment_of(&self, view: &View) -> Option<FragmentId> {
        match view.fragment {
            Some(id) => ((id.0 as usize) < self.fragments.len()).then_some(id),
            None => self.locate(view.eye, view.toward),
        }
    }

    /// Whether [`SceneBuilder::open_above`] was called for a fragment.
    pub fn is_open_above(&self, id: FragmentId) -> bool {
        self.fragments[id.0 as usize].open_above
    }

    /// The smallest box around a fragment's content, in the fragment's own space.
    pub fn bounds(&self, id: FragmentId) -> Aabb {
        self.fragment(id).bounds()
    }

    /// Items of all fragments; one that stands in two is counted twice. Of the user's own, as many as they say.
    pub fn item_count(&self) -> usize {
        let items = |id| match self.content(id) {
            Some(content) => content.item_count(),
            None => self.fragment(id).item_count() as usize,
        };
        self.fragments().map(items).sum()
    }

    /// Triangles of all fragments, each copy counted. Of the user's own, as many as they [say](Fragment::item_triangles).
    pub fn triangle_count(&self) -> u64 {
        self.fragments().map(|id| self.triangles_of(id)).sum()
    }

    /// The same of one fragment.
    pub fn triangles_of(&self, id: FragmentId) -> u64 {
        let own = self.fragment(id);
        match self.content(id) {
            Some(content) => content.triangle_count(),
            None => (0..own.item_count())
                .map(|item| own.item_triangles(ItemId(item), &[]))
                .sum(),
        }
    }

    /// Memory in bytes, of contents and of what methods built over them.
    pub fn bytes(&self) -> u64 {
        let fragments = self.fragments().map(|id| self.fragment(id).bytes()).sum::<u64>();
        let portals = size_of_val(&*self.portals) + size_of_val(&*self.portal_of);
        fragments + self.boxes.bytes() + portals as u64
    }

    /// What methods built, over all fragments: sums, and the depth of the deepest tree.
    pub fn built(&self) -> Built {
        self.fragments()
            .map(|id| self.fragment(id).built())
            .fold(Built::default(), |sum, built| Built {
                faces: sum.faces + built.faces,
                splits: sum.splits + built.splits,
                depth: sum.depth.max(built.depth),
            })
    }
}

impl Placed {
    fn fragment(&self) -> &dyn Fragment {
        match &self.body {
            Body::Ours { fragment, .. } => &**fragment,
            Body::Own(fragment) => &**fragment,
        }
    }

    /// The box by which an eye is located.
    fn space(&self) -> Aabb {
        let mut space = self.fragment().bounds();
        if self.open_above && !space.is_empty() {
            space.max[1] = f32::INFINITY;
        }
        space
    }

    /// Has this content seen by this method, or stays as it was.
    fn rebuild(&mut self, content: Arc<Content>, method: Method, limit_bytes: u64) -> Result<(), Unsuited> {
        let fragment = method.build_ours(content, limit_bytes)?;
        self.body = Body::Ours { method, fragment };
        self.builds += 1;
        Ok(())
    }
}
