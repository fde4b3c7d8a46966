//! Turns nodes and hints into rooms: assigns each node to a room, and decides whether it is an item or an opening.

use super::affected::Affected;
use super::below::{self, Below};
use super::document::{Animated, Document, Primitive, short};
use super::hints::{self, Hint, OpeningTarget};
use super::names::Names;
use super::nodes::{self, SceneNode};
use super::poses::PosedMesh;
use super::{Assets, PlacedMesh};
use crate::budget::Budget;
use crate::faults::{Faults, Subject};
use crate::rooms::{self, Frame, MarkedMesh, Shell, Teleport};
use crate::warning::{WarningKind, Warnings};
use crate::{AuthoringError, BrokenRule, NonOccluder, Room, SourceNodes};
use enfilade::{
    Alpha, GeometryBuilder, ItemIndex, ItemOptions, Material, Mesh, MeshId, Method, Portal, SectorId,
    Transform,
};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

/// The nodes of the scene and their roles.
pub(super) struct Plan<'d> {
    document: &'d Document<'d>,
    placed: Vec<SceneNode>,
    hints: BTreeMap<u32, Hint>,
    /// Meshes of marked nodes that are below them.
    below: Below,
    /// Indices of the room nodes, increasing; empty if none is marked or the file is read as flat.
    rooms: Vec<u32>,
    /// For each name that a portal uses as an exit, the positions in `placed` of the first two nodes with that name.
    exits: HashMap<&'d str, [Option<usize>; 2]>,
    flat: bool,
    /// Nodes that can move: leaves of doors, joints of skins, and what animations move, with all below them.
    movable: BTreeSet<u32>,
    /// Nodes that animations move, show or hide, with all below them.
    animated: BTreeSet<u32>,
    /// Joints of skins, with all below them: what a body holds in its hands.
    joints: BTreeSet<u32>,
    /// Materials that animations change.
    animated_materials: BTreeSet<u32>,
    /// Nodes that a renderer may replace by a level of detail, with all below them.
    levels: BTreeSet<u32>,
    /// Whether nodes hide others, by their authors.
    occluders: BTreeMap<u32, bool>,
    /// What unread extensions may change.
    affected: Affected,
    /// Method of the room for nodes outside every room, if the scene defines one.
    method_of_rest: Option<Method>,
}

impl<'d> Plan<'d> {
    /// Computes the transforms of all nodes and checks the marks of rooms and portals.
    pub(super) fn new(
        document: &'d Document<'d>,
        flat: bool,
        affected: Affected,
        faults: &mut Faults,
        warnings: &mut Warnings,
    ) -> Result<Plan<'d>, BrokenRule> {
        let hints = hints::read(document, faults, warnings);
        let exits: BTreeSet<&str> = hints.values().filter_map(exit).collect();
        let is_room = |node: u32| matches!(hints.get(&node), Some(Hint::Room { .. }));
        let wanted =
            |node: u32| hints.contains_key(&node) || exits.contains(&*document.nodes[node as usize].name);
        let placed = nodes::place(document, is_room, wanted, warnings)?;
        let rooms = placed
            .iter()
            .map(|placed| placed.node)
            .filter(|&node| is_room(node));
        let rooms: Vec<u32> = rooms.collect();
        let method_of_rest = hints::method_of_scene(document).unwrap_or_else(|why| {
            faults.report(Subject::Room, why, warnings);
            None
        });
        let mut called: HashMap<&'d str, [Option<usize>; 2]> = HashMap::new();
        for (place, placed) in placed.iter().enumerate() {
            let name = &*document.nodes[placed.node as usize].name;
            if exits.contains(name) {
                let two = called.entry(name).or_default();
                *two = [two[0].or(Some(place)), two[0].and(two[1].or(Some(place)))];
            }
        }
        let doors = hints
            .iter()
            .filter(|(_, hint)| **hint == Hint::Door)
            .map(|(&node, _)| node);
        let Animated { nodes, materials } = document.animated();
        let animated = with_all_below(document, nodes);
        let joints = with_all_below(document, document.joints());
        let mut movable = with_all_below(document, doors.collect());
        movable.extend(animated.iter().chain(&joints));
        let levels = (0..).zip(&document.nodes).filter(|(_, node)| node.has_levels());
        let levels = with_all_below(document, levels.map(|(number, _)| number).collect());
        let occluders = hints::occluders(document, faults, warnings);
        let mut plan = Plan {
            document,
            below: Below::new(document, &hints),
            exits: called,
            placed,
            hints,
            rooms,
            flat,
            movable,
            animated,
            joints,
            animated_materials: materials.into_iter().collect(),
            levels,
            occluders,
            affected,
            method_of_rest,
        };
        plan.check_rooms(faults, warnings);
        for (&node, hint) in plan.hints.iter().filter(|_| !flat) {
            if matches!(hint, Hint::Opening { .. }) && plan.animated.contains(&node) {
                warnings.name(WarningKind::AnimatedOpenings, || document.node_name(node));
            }
        }
        for placed in plan.placed.iter().filter(|placed| plan.is_item(placed)) {
            let is_skinned = document.nodes[placed.node as usize].skin.is_some();
            if !is_skinned && placed.world.inverse().is_none() {
                warnings.name(WarningKind::Flattened, || document.node_name(placed.node));
            }
        }
        Ok(plan)
    }

    /// Returns the nodes that are visible or that are exits of portals, by node index.
    pub(super) fn shown(&self) -> &[SceneNode] {
        &self.placed
    }

    /// Returns `true` if an animation changes a material.
    pub(super) fn animates_material(&self, material: u32) -> bool {
        self.animated_materials.contains(&material)
    }

    /// Returns the room nodes, in room order.
    pub(super) fn room_nodes(&self) -> &[u32] {
        &self.rooms
    }

    /// Returns the terrain nodes, by node index.
    pub(super) fn terrains(&self) -> impl Iterator<Item = u32> {
        let nodes = self.placed.iter().map(|placed| placed.node);
        nodes.filter(|node| self.hints.get(node) == Some(&Hint::Terrain))
    }

    /// Returns what unread extensions may change.
    pub(super) fn affected(&self) -> &Affected {
        &self.affected
    }

    /// Returns the nodes whose meshes are terrain, for a terrain node.
    pub(super) fn terrain_meshes<'p>(&'p self, terrain: &'p u32) -> &'p [u32] {
        self.below.holders(terrain)
    }

    /// Returns the meshes that belong to a marked node, in words.
    pub(super) fn found_below(&self, marked: u32) -> String {
        self.below.found(self.document, &self.hints, marked)
    }

    /// Returns `true` if items or openings may be named after a node: it has a mesh, or meshes below it.
    pub(super) fn names_meshes(&self, node: u32) -> bool {
        self.document.nodes[node as usize].mesh.is_some() || self.below.lends_to(node)
    }

    /// Checks that room names are unique; if there are no rooms, removes all openings.
    fn check_rooms(&mut self, faults: &mut Faults, warnings: &mut Warnings) {
        let document = self.document;
        let mut named: HashMap<&str, u32> = HashMap::new();
        let named_rooms = self.rooms.iter().filter(|_| !self.flat);
        for &room in named_rooms {
            let name = &*document.nodes[room as usize].name;
            if !name.is_empty()
                && let Some(first) = named.insert(name, room)
            {
                let [first, second] = [first, room].map(|node| document.node_name(node));
                faults.report(
                    Subject::Room,
                    AuthoringError::RoomsShareName { first, second },
                    warnings,
                );
            }
        }
        if !self.rooms.is_empty() {
            return;
        }
        for placed in &self.placed {
            match self.hints.get(&placed.node) {
                Some(Hint::Opening { by_name: false, .. }) if !self.flat => {
                    let node = document.node_name(placed.node);
                    faults.report(Subject::Portal, AuthoringError::NoRooms { node }, warnings);
                    self.hints.insert(placed.node, Hint::Hole);
                }
                Some(Hint::Opening { by_name: true, .. }) => {
                    warnings.name(WarningKind::OpeningsWithoutRooms, || {
                        document.node_name(placed.node)
                    });
                }
                _ => {}
            }
        }
        self.hints
            .retain(|_, hint| !matches!(hint, Hint::Opening { by_name: true, .. }));
    }

    /// Builds the rooms; `name` is the name of the room for nodes outside every room.
    pub(super) fn rooms(
        &self,
        name: &str,
        assets: &Assets,
        names: &Names<'d>,
        faults: &mut Faults,
        budget: &mut Budget,
        warnings: &mut Warnings,
    ) -> Result<(Vec<Room>, Vec<Portal>), BrokenRule> {
        let (items, stray): (Vec<&SceneNode>, Vec<&SceneNode>) = self
            .placed
            .iter()
            .filter(|placed| self.is_item(placed))
            .partition(|placed| self.room(placed).is_some());
        let mut shells: Vec<Shell> = Vec::new();
        if !self.flat {
            shells.extend(self.rooms.iter().map(|&room| self.shell(room, assets)));
        }
        let marked_rooms = shells.len();
        let has_rest = marked_rooms == 0 || !stray.is_empty();
        if has_rest {
            shells.push(Shell {
                name: name.to_owned(),
                spoken: "the space outside every room".to_owned(),
                builder: assets.builder(),
                method: self.method_of_rest,
                nodes: SourceNodes::default(),
                non_occluders: assets.non_occluders.clone(),
            });
        }
        let mut held: Vec<Vec<&SceneNode>> = vec![Vec::new(); shells.len()];
        for placed in &items {
            held[self.room(placed).unwrap_or(marked_rooms)].push(placed);
        }
        for placed in &stray {
            held[marked_rooms].push(placed);
        }
        for ((number, shell), held) in shells.iter_mut().enumerate().zip(held) {
            if held.is_empty() && number < marked_rooms {
                warnings.name(WarningKind::EmptyRooms, || shell.spoken.clone());
            }
            self.fill(shell, &held, assets, names)?;
        }
        let marked = if self.flat {
            Vec::new()
        } else {
            self.marked(assets, names, faults, warnings)
        };
        let (rooms, portals) = rooms::join(shells, marked, faults, budget, warnings)?;
        let is_seen = portals.iter().any(|portal| portal.to.0 as usize == marked_rooms);
        if marked_rooms > 0 && !is_seen {
            for placed in stray {
                warnings.name(WarningKind::InNoRoom, || self.document.node_name(placed.node));
            }
        }
        Ok((rooms, portals))
    }

    /// Returns the number of marked rooms.
    pub(super) fn room_count(&self) -> usize {
        self.rooms.len()
    }

    /// Returns the index of a node's room.
    fn room(&self, placed: &SceneNode) -> Option<usize> {
        let room = placed.room.filter(|_| !self.flat)?;
        self.rooms.binary_search(&room).ok()
    }

    /// Returns the room above a node, and the room for nodes outside every room; `rooms` is the number of rooms that
    /// [`Plan::rooms`] built.
    pub(super) fn homes(&self, placed: &SceneNode, rooms: usize) -> [Option<SectorId>; 2] {
        let marked = if self.flat { 0 } else { self.rooms.len() };
        let rest = (rooms > marked).then_some(marked);
        [self.room(placed), rest].map(|room| room.map(|room| SectorId(room as u32)))
    }

    /// Returns `true` if the node's mesh is drawn: a portal's is not, a mirror's only if everything is one room.
    pub(super) fn is_item(&self, placed: &SceneNode) -> bool {
        let has_mesh = self.document.nodes[placed.node as usize].mesh.is_some();
        has_mesh
            && placed.is_visible
            && match self.hints.get(&self.below.marked(placed.node)) {
                Some(Hint::Opening { way, .. }) => self.flat && *way == OpeningTarget::Mirror,
                Some(Hint::Hole) => false,
                _ => true,
            }
    }

    fn has_morph_targets(&self, mesh: u32) -> bool {
        let primitives = &self.document.meshes[mesh as usize].primitives;
        primitives.iter().any(|primitive| !primitive.targets.is_empty())
    }

    /// Returns why a node's mesh hides nothing; `None` if it certainly is where the file has it, with the faces that it has.
    fn why_no_occluder(&self, placed: &SceneNode, mesh: u32, materials: &[Material]) -> Option<NonOccluder> {
        let node = &self.document.nodes[placed.node as usize];
        let by_author = self.occluders.get(&placed.node).copied();
        let primitives = &self.document.meshes[mesh as usize].primitives;
        let is_opaque = |material: u32| {
            let material = materials.get(material as usize);
            material.is_some_and(|material| material.alpha == Alpha::Opaque)
        };
        let mut variants = primitives.iter().flat_map(Primitive::variants);
        // An author knows the pose better, but not what the reasons before it say.
        let mut reasons = [
            (by_author == Some(false), NonOccluder::Author),
            (!variants.all(is_opaque), NonOccluder::MaterialVariant),
            (self.levels.contains(&placed.node), NonOccluder::LevelOfDetail),
            (self.affected.has(placed.node, mesh), NonOccluder::ExtensionUnread),
            (
                node.skin.is_some() || self.joints.contains(&placed.node),
                NonOccluder::Skinned,
            ),
            (self.has_morph_targets(mesh), NonOccluder::Morphed),
            (self.animated.contains(&placed.node), NonOccluder::Animated),
        ]
        .into_iter();
        reasons
            .find(|&(holds, why)| holds && (by_author != Some(true) || !why.is_of_pose()))
            .map(|(_, why)| why)
    }

    /// Creates an empty room for a room node.
    fn shell(&self, room: u32, assets: &Assets) -> Shell {
        let name = &*self.document.nodes[room as usize].name;
        let method = match self.hints.get(&room) {
            Some(Hint::Room { method }) => *method,
            _ => None,
        };
        Shell {
            name: if name.is_empty() {
                format!("node#{room}")
            } else {
                name.to_owned()
            },
            spoken: self.document.node_name(room),
            builder: assets.builder(),
            method,
            nodes: SourceNodes::default(),
            non_occluders: assets.non_occluders.clone(),
        }
    }

    /// Adds items to a room, and each mesh that they use once.
    fn fill(
        &self,
        shell: &mut Shell,
        held: &[&SceneNode],
        assets: &Assets,
        names: &Names<'d>,
    ) -> Result<(), BrokenRule> {
        let Shell {
            builder,
            nodes,
            non_occluders,
            ..
        } = shell;
        let node = |placed: &SceneNode| &self.document.nodes[placed.node as usize];
        let terrain = |placed: &SceneNode| assets.terrains.of(placed.node);
        let copies = held.iter().filter(|placed| terrain(placed).is_none());
        let own: BTreeSet<PosedMesh> = copies
            .filter_map(|placed| assets.meshes.of(placed.node))
            .collect();
        let own: BTreeMap<PosedMesh, MeshId> = own
            .into_iter()
            .map(|posed| (posed, builder.mesh(Arc::clone(&assets.meshes.get(posed).mesh))))
            .collect();
        for placed in held {
            let marked = self.below.marked(placed.node);
            let id = assets.ids.get(&placed.node).or_else(|| assets.ids.get(&marked));
            let id = id.map(String::as_str);
            if self.movable.contains(&placed.node) {
                nodes.add_movable(placed.node);
            }
            let node = node(placed);
            let posed = assets.meshes.of(placed.node);
            if let (Some(field), Some(posed)) = (terrain(placed), posed) {
                let name = names.name(marked, &self.document.nodes[marked as usize]);
                let name = names.terrain(&name, marked);
                let material = assets.meshes.get(posed).mesh.clusters()[0].material;
                let blocks = builder
                    .terrain(&name, Arc::clone(field), material, placed.world)
                    .map_err(BrokenRule::Geometry)?;
                nodes.add(blocks.start, placed.node, id);
                if let Some(why) = self.why_no_occluder(placed, posed.mesh, &assets.materials) {
                    let options = ItemOptions {
                        is_occluder: false,
                        ..ItemOptions::default()
                    };
                    for block in (blocks.start.0..blocks.end.0).map(ItemIndex) {
                        builder.set_options(block.into(), options);
                        non_occluders.add(block, why);
                    }
                }
                continue;
            }
            let Some((posed, mesh)) = posed.and_then(|posed| Some((posed, own.get(&posed)?))) else {
                continue;
            };
            let why = self.why_no_occluder(placed, posed.mesh, &assets.materials);
            let options = ItemOptions {
                is_occluder: why.is_none(),
                ..ItemOptions::default()
            };
            let mut add = |name: &str, world: Transform| {
                let item = builder.item(name, *mesh, world);
                builder.set_options(item, options);
                nodes.add(item.index, placed.node, id);
                if let Some(why) = why {
                    non_occluders.add(item.index, why);
                }
            };
            let world = assets.meshes.get(posed).world.unwrap_or(placed.world);
            let name = names.name(placed.node, node);
            match assets.instances.of(placed.node) {
                None => add(&name, world),
                Some(instances) => {
                    for (number, &node_from_instance) in instances.iter().enumerate() {
                        let name = names.instance(&name, placed.node, number);
                        add(&name, placed.world * node_from_instance);
                    }
                }
            }
        }
        Ok(())
    }

    /// Returns every valid opening with its target; reports the others.
    fn marked(
        &self,
        assets: &Assets,
        names: &Names<'d>,
        faults: &mut Faults,
        warnings: &mut Warnings,
    ) -> Vec<MarkedMesh> {
        let mut all = Vec::new();
        for placed in &self.placed {
            let Some(Hint::Opening { way, .. }) = self.hints.get(&placed.node) else {
                continue;
            };
            match self.marked_at(placed, way, assets, names) {
                Ok(marked) => all.push(marked),
                Err(why) => faults.report(Subject::Portal, why, warnings),
            }
        }
        all
    }

    fn marked_at(
        &self,
        placed: &SceneNode,
        way: &OpeningTarget,
        assets: &Assets,
        names: &Names<'d>,
    ) -> Result<MarkedMesh, AuthoringError> {
        let node = &self.document.nodes[placed.node as usize];
        let mut spoken = self.document.node_name(placed.node);
        let holders = self.below.holders(&placed.node);
        let faces: Vec<_> = holders
            .iter()
            .filter_map(|&holder| self.faces(holder, assets))
            .collect();
        if faces.iter().all(|(mesh, _)| mesh.face_count() == 0) {
            return Err(AuthoringError::NoMesh {
                node: spoken,
                found: self.found_below(placed.node),
            });
        }
        let way = self.way(placed, way, &spoken)?;
        if self.below.lends_to(placed.node) {
            spoken += &format!(" (with the mesh of {})", below::named(self.document, holders));
        }
        Ok(MarkedMesh {
            name: names.name(placed.node, node).into_owned(),
            faces,
            owner: self.room(placed),
            way,
            spoken,
        })
    }

    /// Returns the mesh of a node and its transform.
    fn faces(&self, node: u32, assets: &Assets) -> Option<(Arc<Mesh>, Transform)> {
        let PlacedMesh { mesh, world } = assets.meshes.get(assets.meshes.of(node)?);
        let at = self.placed.binary_search_by_key(&node, |placed| placed.node);
        let world = world.unwrap_or(self.placed[at.ok()?].world);
        Some((Arc::clone(mesh), world))
    }

    /// Resolves the target of an opening.
    fn way(
        &self,
        placed: &SceneNode,
        way: &OpeningTarget,
        spoken: &str,
    ) -> Result<rooms::OpeningTarget, AuthoringError> {
        let OpeningTarget::Portal { to, one_way, exit } = way else {
            return Ok(rooms::OpeningTarget::Mirror);
        };
        let to = match to {
            Some(to) => Some(self.room_called(to, spoken)?),
            None => None,
        };
        let Some(exit) = exit else {
            return Ok(rooms::OpeningTarget::Door {
                to,
                one_way: *one_way,
            });
        };
        let out = self.node_called(&exit.node, spoken)?;
        let frame = |placed: &SceneNode| {
            Frame::of(&placed.world).ok_or_else(|| AuthoringError::NoFrame {
                node: self.document.node_name(placed.node),
            })
        };
        Ok(rooms::OpeningTarget::Teleport(Box::new(Teleport {
            from: frame(placed)?,
            exit: frame(out)?,
            exit_name: short(&exit.node),
            scale: exit.scale,
            to: to.or_else(|| self.room(out)),
        })))
    }

    fn room_called(&self, name: &str, spoken: &str) -> Result<usize, AuthoringError> {
        const FEW: usize = 24;
        let name_of = |&room: &u32| &*self.document.nodes[room as usize].name;
        let found = self.rooms.iter().position(|room| name_of(room) == name);
        found.ok_or_else(|| {
            let mut rooms: Vec<String> = self.rooms.iter().map(name_of).take(FEW).map(short).collect();
            if self.rooms.len() > FEW {
                rooms.push(format!("and {} more", self.rooms.len() - FEW));
            }
            AuthoringError::NoSuchRoom {
                node: spoken.to_owned(),
                to: short(name),
                rooms: rooms.join(", "),
            }
        })
    }

    fn node_called(&self, name: &str, spoken: &str) -> Result<&SceneNode, AuthoringError> {
        let called = self.exits.get(name).copied().unwrap_or_default();
        let [first, second] = called.map(|place| place.map(|place| &self.placed[place]));
        let (node, exit) = (|| spoken.to_owned(), || short(name));
        match (first, second) {
            (Some(only), None) => Ok(only),
            (None, _) => Err(AuthoringError::NoSuchExit {
                node: node(),
                exit: exit(),
            }),
            (Some(first), Some(second)) => Err(AuthoringError::ManyExits {
                node: node(),
                exit: exit(),
                first: self.document.node_name(first.node),
                second: self.document.node_name(second.node),
            }),
        }
    }
}

impl Assets {
    /// Creates the builder of a room, with the shared materials and textures.
    fn builder(&self) -> GeometryBuilder {
        let mut builder = GeometryBuilder::new(Arc::clone(&self.materials));
        builder.textures(Arc::clone(&self.textures));
        builder
    }
}

fn exit(hint: &Hint) -> Option<&str> {
    match hint {
        Hint::Opening {
            way: OpeningTarget::Portal { exit, .. },
            ..
        } => exit.as_ref().map(|exit| &*exit.node),
        _ => None,
    }
}

/// Returns some nodes with all below them. Indices that are out of range are ignored.
pub(super) fn with_all_below(document: &Document, mut waiting: Vec<u32>) -> BTreeSet<u32> {
    let mut all = BTreeSet::new();
    while let Some(number) = waiting.pop() {
        if let Some(node) = document.nodes.get(number as usize)
            && all.insert(number)
        {
            waiting.extend(&node.children);
        }
    }
    all
}
