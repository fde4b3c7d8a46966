//! Puts a scene together, and refuses one that cannot be.

use super::locate::Boxes;
use super::{Body, Exit, FragmentId, Light, LightId, Placed, Portal, PortalId, Scene, SceneError, Way};
use crate::content::{Content, Opening, OpeningId};
use crate::fragment::Fragment;
use crate::geom::{Transform, is_in_range};
use crate::method::Method;
use std::sync::Arc;

/// Gathers fragments and portals; [`SceneBuilder::build`] checks them.
#[derive(Default)]
pub struct SceneBuilder {
    fragments: Vec<Waiting>,
    nested: Vec<Scene>,
    portals: Vec<(End, End, Transform)>,
    exits: Vec<(String, End)>,
    lights: Vec<Light>,
    open_above: Vec<FragmentId>,
    limit_bytes: Option<u64>,
}

enum Waiting {
    Ours(String, Arc<Content>, Method),
    Own(String, Arc<dyn Fragment>),
}

/// A scene that stands in another, by the order of [`SceneBuilder::nest`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NestedId(u32);

/// One end of a portal: an opening of a fragment, a named exit of a nested scene, or anywhere in a fragment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// An opening of a fragment of this scene.
    Opening(FragmentId, OpeningId),
    /// An exit of a scene that stands in this one.
    Exit(NestedId, String),
    /// Anywhere in a fragment of this scene, as its portal's transform says: a portal may lead there, as a teleport does,
    /// but not out of it.
    Anywhere(FragmentId),
}

impl From<(FragmentId, OpeningId)> for End {
    fn from((fragment, opening): (FragmentId, OpeningId)) -> End {
        End::Opening(fragment, opening)
    }
}

impl From<FragmentId> for End {
    fn from(fragment: FragmentId) -> End {
        End::Anywhere(fragment)
    }
}

impl From<(NestedId, &str)> for End {
    fn from((scene, exit): (NestedId, &str)) -> End {
        End::Exit(scene, exit.to_owned())
    }
}

impl SceneBuilder {
    /// Starts with nothing.
    pub fn new() -> SceneBuilder {
        SceneBuilder::default()
    }

    /// What one fragment's method may build, in bytes; [`Method::DEFAULT_LIMIT`] unless told.
    pub fn limit_bytes(&mut self, limit: u64) {
        self.limit_bytes = Some(limit);
    }

    /// Adds content as a fragment that `method` sees.
    pub fn add(&mut self, name: &str, content: impl Into<Arc<Content>>, method: Method) -> FragmentId {
        self.fragments
            .push(Waiting::Ours(name.to_owned(), content.into(), method));
        FragmentId(self.fragments.len() as u32 - 1)
    }

    /// Adds a fragment of one's own.
    pub fn add_own(&mut self, name: &str, fragment: Arc<dyn Fragment>) -> FragmentId {
        self.fragments.push(Waiting::Own(name.to_owned(), fragment));
        FragmentId(self.fragments.len() as u32 - 1)
    }

    /// Lets a scene stand in this one. It is entered and left through its exits only.
    pub fn nest(&mut self, scene: &Scene) -> NestedId {
        self.nested.push(scene.clone());
        NestedId(self.nested.len() as u32 - 1)
    }

    /// One way out of `from`, into the fragment that `to` is an opening of.
    pub fn portal(
        &mut self,
        from: impl Into<End>,
        to: impl Into<End>,
        there_from_here: Transform,
    ) -> &mut Self {
        self.portals.push((from.into(), to.into(), there_from_here));
        self
    }

    /// Two portals between two openings at one place, in fragments that share their space.
    pub fn door(&mut self, a: impl Into<End>, b: impl Into<End>) -> &mut Self {
        let (a, b) = (a.into(), b.into());
        self.portal(a.clone(), b.clone(), Transform::IDENTITY)
            .portal(b, a, Transform::IDENTITY)
    }

    /// A portal back into the fragment of `opening` that reflects in the opening's plane. An opening that is not
    /// there is reported by [`SceneBuilder::build`].
    pub fn mirror(&mut self, fragment: FragmentId, opening: OpeningId) -> &mut Self {
        let outline = match self.fragments.get(fragment.0 as usize) {
            Some(Waiting::Ours(_, content, _)) => {
                content.openings().get(opening.0 as usize).map(|o| &o.outline)
            }
            Some(Waiting::Own(_, own)) => own.openings().get(opening.0 as usize).map(|o| &o.outline),
            None => None,
        };
        let reflection = outline.map_or(Transform::IDENTITY, |outline| {
            Transform::reflection(outline.corners()[0], outline.normal())
        });
        self.portal((fragment, opening), (fragment, opening), reflection)
    }

    /// Names an opening through which one leaves this scene when it stands in another.
    pub fn exit(&mut self, name: &str, from: impl Into<End>) -> &mut Self {
        self.exits.push((name.to_owned(), from.into()));
        self
    }

    /// Hangs up a lamp in a fragment of this scene.
    pub fn light(&mut self, light: Light) -> LightId {
        self.lights.push(light);
        LightId(self.lights.len() as u32 - 1)
    }

    /// States that a fragment has no top, as a garden or a courtyard: [`Scene::locate`] extends its box upwards (+Y) without end.
    /// Affects nothing else.
    pub fn open_above(&mut self, fragment: FragmentId) -> &mut Self {
        self.open_above.push(fragment);
        self
    }

    /// Builds every fragment's method and joins everything.
    ///
    /// # Errors
    /// One [`SceneError`] for the first broken rule.
    pub fn build(self) -> Result<Scene, SceneError> {
        let limit = self.limit_bytes.unwrap_or(Method::DEFAULT_LIMIT);
        let own_fragments = self.fragments.len();
        let mut fragments = Vec::with_capacity(own_fragments);
        for waiting in self.fragments {
            fragments.push(place(waiting, limit)?);
        }
        for id in self.open_above {
            let placed = fragments.get_mut(id.0 as usize);
            let placed = placed.ok_or(SceneError::NoSuchFragment {
                way: Way::OpenAbove,
                fragment: id.0,
                fragments: own_fragments,
            })?;
            placed.open_above = true;
        }
        let mut joined = Joined {
            own_fragments,
            fragments,
            portals: Vec::new(),
            lights: Vec::new(),
            scenes: Vec::new(),
        };
        for (number, light) in self.lights.into_iter().enumerate() {
            if !light.is_sound() || light.fragment.0 as usize >= own_fragments {
                return Err(SceneError::BadLight(number));
            }
            joined.lights.push(light);
        }
        for scene in self.nested {
            joined.take_in(scene);
        }
        let taken_in = joined.portals.len();
        for (number, (from, to, there_from_here)) in self.portals.into_iter().enumerate() {
            if !there_from_here.is_similarity() {
                return Err(SceneError::NotSimilar(number));
            }
            let way = Way::Portal(number);
            let (from, opening) = joined.resolve_opening(&way, &from)?;
            let (to, _) = joined.resolve(&way, &to)?;
            let portal = Portal {
                from,
                opening,
                to,
                there_from_here,
                open: true,
            };
            if !portal.leads_in_range(&joined.fragments[from.0 as usize].openings()[usize::from(opening.0)]) {
                return Err(SceneError::TooFar(number));
            }
            joined.portals.push(portal);
        }
        let mut exits = Vec::new();
        for (name, from) in self.exits {
            let way = Way::Exit(name.clone());
            if exits.iter().any(|exit: &Exit| exit.name == name) {
                return Err(SceneError::TwoExits(name));
            }
            let (fragment, opening) = joined.resolve_opening(&way, &from)?;
            exits.push(Exit {
                name,
                fragment,
                opening,
            });
        }
        joined.finish(taken_in, exits, limit)
    }
}

fn place(waiting: Waiting, limit: u64) -> Result<Placed, SceneError> {
    Ok(match waiting {
        Waiting::Own(name, fragment) => {
            let bounds = fragment.bounds();
            // A sky may reach to infinity.
            let is_sound = |side: f32| side.is_infinite() || is_in_range(side);
            if !bounds.min.into_iter().chain(bounds.max).all(is_sound) {
                return Err(SceneError::BadBounds(name));
            }
            Placed {
                name,
                body: Body::Own(fragment),
                open_above: false,
                builds: 0,
            }
        }
        Waiting::Ours(name, content, method) => {
            let built = method.build_ours(content, limit);
            let fragment = built.map_err(|why| SceneError::unsuited(&name, why))?;
            Placed {
                name,
                body: Body::Ours { method, fragment },
                open_above: false,
                builds: 1,
            }
        }
    })
}

/// The flat graph that nested scenes are taken into.
struct Joined {
    own_fragments: usize,
    fragments: Vec<Placed>,
    portals: Vec<Portal>,
    lights: Vec<Light>,
    scenes: Vec<Vec<Exit>>,
}

impl Joined {
    fn take_in(&mut self, scene: Scene) {
        let shift = self.fragments.len() as u32;
        let moved = |id: FragmentId| FragmentId(id.0 + shift);
        self.portals.extend(scene.portals.into_iter().map(|p| Portal {
            from: moved(p.from),
            to: moved(p.to),
            ..p
        }));
        self.scenes.push(
            scene
                .exits
                .into_iter()
                .map(|exit| Exit {
                    fragment: moved(exit.fragment),
                    ..exit
                })
                .collect(),
        );
        self.lights.extend(scene.lights.into_iter().map(|light| Light {
            fragment: moved(light.fragment),
            ..light
        }));
        self.fragments.extend(scene.fragments);
    }

    fn resolve_opening(&self, way: &Way, end: &End) -> Result<(FragmentId, OpeningId), SceneError> {
        let (fragment, opening) = self.resolve(way, end)?;
        let opening = opening.ok_or_else(|| SceneError::NoOpening(way.clone()))?;
        Ok((fragment, opening))
    }

    fn resolve(&self, way: &Way, end: &End) -> Result<(FragmentId, Option<OpeningId>), SceneError> {
        let (fragment, opening) = match end {
            End::Anywhere(fragment) => (*fragment, None),
            End::Opening(fragment, opening) => (*fragment, Some(*opening)),
            End::Exit(scene, name) => {
                let exits = self.scenes.get(scene.0 as usize).map_or(&[][..], Vec::as_slice);
                let found = exits.iter().find(|exit| exit.name == *name);
                let exit = found.ok_or_else(|| SceneError::NoSuchExit {
                    way: way.clone(),
                    exit: name.clone(),
                    exits: exits.iter().map(|exit| exit.name.clone()).collect(),
                })?;
                return Ok((exit.fragment, Some(exit.opening)));
            }
        };
        if fragment.0 as usize >= self.own_fragments {
            return Err(SceneError::NoSuchFragment {
                way: way.clone(),
                fragment: fragment.0,
                fragments: self.own_fragments,
            });
        }
        let placed = &self.fragments[fragment.0 as usize];
        let openings = placed.openings().len();
        if let Some(opening) = opening.filter(|opening| usize::from(opening.0) >= openings) {
            let fragment = placed.name.clone();
            return Err(SceneError::NoSuchOpening {
                way: way.clone(),
                fragment,
                opening: opening.0,
                openings,
            });
        }
        Ok((fragment, opening))
    }

    fn finish(self, taken_in: usize, exits: Vec<Exit>, limit_bytes: u64) -> Result<Scene, SceneError> {
        let mut first_opening = vec![0];
        for placed in &self.fragments {
            first_opening.push(first_opening[first_opening.len() - 1] + placed.openings().len() as u32);
        }
        let mut portal_of: Vec<Option<PortalId>> = vec![None; first_opening[self.fragments.len()] as usize];
        let way = |number: usize| {
            number
                .checked_sub(taken_in)
                .map_or(Way::PortalWithin, Way::Portal)
        };
        for (number, portal) in self.portals.iter().enumerate() {
            let slot = first_opening[portal.from.0 as usize] as usize + usize::from(portal.opening.0);
            if let Some(first) = portal_of[slot].replace(PortalId(number as u32)) {
                let placed = &self.fragments[portal.from.0 as usize];
                return Err(SceneError::TwoPortals {
                    first: way(first.0 as usize),
                    second: way(number),
                    opening: placed.openings()[usize::from(portal.opening.0)].name.clone(),
                    fragment: placed.name.clone(),
                });
            }
        }
        let boxes = self.fragments.iter().map(Placed::space).collect();
        Ok(Scene {
            boxes: Boxes::new(boxes),
            fragments: self.fragments,
            portals: self.portals,
            portal_of,
            first_opening,
            flat: false,
            lights: self.lights,
            limit_bytes,
            exits,
        })
    }
}

impl Placed {
    fn openings(&self) -> &[Opening] {
        self.fragment().openings()
    }
}
