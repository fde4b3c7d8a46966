//! `link`: joins separately exported files by portals into one world.

mod world;

use crate::Outcome;
use crate::args::LinkArgs;
use crate::json::Sink;
use crate::open::allow_threads;
use crate::out;
use crate::progress::Progress;
use crate::read::read_file;
use crate::run_files::RunFiles;
use crate::text::{bytes, count, plural};
use anyhow::{Context, Result, anyhow, bail};
use enfilade::{Aabb, Transform};
use enfilade_import::{Import, LinkError, Linked, Linker, NodeId, PartId, ReadOptions, Shape};
use serde::Serialize;
use std::path::Path;
use world::{EndPosition, EndSpec, Portal, World};

/// Maximum size of a WORLD.toml: tens of thousands of parts.
const MAX_WORLD_BYTES: u64 = 1 << 20;

/// The JSON report.
#[derive(Debug, Serialize)]
struct LinkReport {
    file: String,
    bytes: u64,
    parts: usize,
    rooms: usize,
    portals: usize,
    items: usize,
    warnings: Vec<String>,
}

/// Runs `link`.
pub(crate) fn run(args: &LinkArgs) -> Result<Outcome> {
    let output = &args.output;
    if !output
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("glb"))
    {
        bail!(
            "cannot write {}: a world is a .glb file, so the name must end in .glb",
            output.display()
        );
    }
    let mut files = RunFiles::default();
    files.reads(&args.world)?;
    let destination = files.writes(output)?;
    let sink = Sink::new(&args.json, &mut files)?;
    allow_threads(&args.limits)?;
    let name = args.world.display().to_string();
    let text = read_file(&args.world, MAX_WORLD_BYTES, "link some of its parts first")?;
    let text = String::from_utf8(text).with_context(|| format!("cannot read {name}"))?;
    let world = World::parse(&text).with_context(|| name.clone())?;
    let folder = args.world.parent().unwrap_or(Path::new(""));
    for part in &world.parts {
        files.reads(&folder.join(&part.file))?;
    }
    let progress = Progress::spinner("joining");
    let mut options = ReadOptions {
        textures: false,
        ..args.read.options()
    };
    options.limit_bytes = args.limits.memory();
    let Linked {
        glb,
        left_out,
        missing_images,
        files: side_files,
        import,
    } = join(&world, folder, options).with_context(|| name.clone())?;
    drop(progress);
    side_files
        .iter()
        .try_for_each(|side_file| files.reads(side_file))?;
    destination.write(&glb)?;
    let mut warnings = overlap_warnings(&world, &import);
    if !left_out.is_empty() {
        warnings.push(format!("unknown extensions are dropped: {}", left_out.join(", ")));
    }
    warnings.extend(
        missing_images
            .iter()
            .map(|why| format!("an image is replaced by grey: {why}")),
    );
    warnings
        .iter()
        .for_each(|warning| out::warn(format_args!("{name}: {warning}")));
    let made = LinkReport {
        file: output.display().to_string(),
        bytes: glb.len() as u64,
        parts: world.parts.len(),
        rooms: import.rooms.len(),
        portals: import.portals.len(),
        items: import.rooms.iter().map(|room| room.geometry.items().len()).sum(),
        warnings,
    };
    if !args.json.takes_stdout() {
        out::print(&format!(
            "{}: {}, {}, {}, {}, {}\n",
            made.file,
            plural(made.parts, "part"),
            plural(made.rooms, "room"),
            plural(made.portals, "portal"),
            plural(made.items, "item"),
            bytes(made.bytes)
        ))?;
    }
    sink.write(&made)?;
    Ok(Outcome::Done)
}

/// Places the parts and creates the portals between them.
fn join(world: &World, folder: &Path, options: ReadOptions) -> Result<Linked> {
    let mut linker = Linker::new(options);
    let mut parts = Vec::new();
    for part in &world.parts {
        let context = || format!("[[part]] {:?}", part.name);
        let path = folder.join(&part.file);
        let ending = path
            .extension()
            .and_then(|ending| ending.to_str())
            .unwrap_or_default();
        if ending.eq_ignore_ascii_case("toml") {
            return Err(anyhow!(
                "a part is a .glb or .gltf file; link {} first, and use the result as the part",
                path.display()
            ))
            .with_context(context);
        }
        let placing = part.placing().with_context(context)?;
        let id = linker.part(&part.name, &path, &placing).with_context(context)?;
        parts.push(id);
    }
    let mut named = Vec::new();
    for portal in &world.portals {
        let context = format!("[[portal]] {:?}", portal.name);
        let mut joiner = Joiner {
            world,
            parts: &parts,
            linker: &mut linker,
        };
        let nodes = joiner.join(portal).with_context(|| context.clone())?;
        named.extend(
            nodes
                .into_iter()
                .map(|node| (linker.name(node).to_owned(), context.clone())),
        );
    }
    linker.finish().map_err(|why| explained(why, world, &named))
}

/// Prefixes an error with the portal or part of the WORLD.toml that its node belongs to.
fn explained(why: LinkError, world: &World, named: &[(String, String)]) -> anyhow::Error {
    let text = why.to_string();
    let names = |name: &str| text.contains(&format!("\"{name}\""));
    if let Some((_, context)) = named.iter().find(|(name, _)| names(name)) {
        return anyhow!("{context}: {text}");
    }
    let part = world
        .parts
        .iter()
        .find(|part| text.contains(&format!("\"{}/", part.name)));
    match part {
        Some(part) => anyhow!(
            "[[part]] {:?}: {text}; or, if it leads to another part, name it in a [[portal]]",
            part.name
        ),
        None => anyhow!(text),
    }
}

/// Creates the nodes of one portal.
struct Joiner<'a> {
    world: &'a World,
    parts: &'a [PartId],
    linker: &'a mut Linker,
}

impl Joiner<'_> {
    /// Creates the portal, and returns the nodes of its openings.
    fn join(&mut self, portal: &Portal) -> Result<Vec<NodeId>> {
        portal.check()?;
        let from = self.part(&portal.from).context("from")?;
        let kind = if portal.mirror { "mirror" } else { "portal" };
        let name = format!("{}-{kind}", portal.name);
        let opening = self.opening(from, &portal.from, &name).context("from")?;
        if portal.mirror {
            self.linker.mirror(opening);
            return Ok(vec![opening]);
        }
        let Some(to) = &portal.to else {
            self.linker.door(opening, None, !portal.two_way())?;
            return Ok(vec![opening]);
        };
        let there = self.part(to).context("to")?;
        let room = (there, to.room.as_deref());
        if !portal.is_teleport() {
            to.position(false).context("to")?;
            self.linker
                .door(opening, Some(room), !portal.two_way())
                .context("to")?;
            return Ok(vec![opening]);
        }
        let (exit, back) = self.exit(portal, to, there).context("to")?;
        self.linker.teleport(opening, exit, room).context("to")?;
        let Some(back) = back else {
            return Ok(vec![opening]);
        };
        let out = self.linker.out_of(opening, &format!("{}-back-exit", portal.name));
        self.linker.teleport(back, out, (from, None))?;
        Ok(vec![opening, back])
    }

    fn part(&self, end: &EndSpec) -> Result<PartId> {
        Ok(self.parts[self.world.part(&end.part)?])
    }

    fn opening(&mut self, part: PartId, end: &EndSpec, name: &str) -> Result<NodeId> {
        match end.position(true)? {
            EndPosition::Node(node) => Ok(self.linker.node(part, &node)?),
            EndPosition::Shape(shape) => Ok(self.linker.shape(part, name, &shape)?),
            EndPosition::Unspecified => bail!(
                "it has no position; give a `node`, a `center` with `ahead` and `size`, or an `outline`"
            ),
        }
    }

    /// Returns the exit of a teleport and, if it is two-way, the opening of the way back.
    fn exit(&mut self, portal: &Portal, to: &EndSpec, part: PartId) -> Result<(NodeId, Option<NodeId>)> {
        let exit = format!("{}-exit", portal.name);
        let back = format!("{}-back-portal", portal.name);
        let two_way = portal.two_way();
        Ok(match to.position(two_way)? {
            EndPosition::Node(node) => {
                let node = self.linker.node(part, &node)?;
                if two_way {
                    (self.linker.out_of(node, &exit), Some(node))
                } else {
                    (node, None)
                }
            }
            EndPosition::Shape(shape) if two_way || matches!(shape, Shape::Outline(_)) => {
                // The exit is left along `ahead`, so the way back enters against it.
                let opening = self.linker.shape(part, &back, &reversed(shape))?;
                let exit = self.linker.out_of(opening, &exit);
                (exit, two_way.then_some(opening))
            }
            EndPosition::Shape(shape) => (self.linker.shape(part, &exit, &shape)?, None),
            EndPosition::Unspecified => bail!(
                "it has no position to come out at; give a `node`, a `center` with `ahead`, or an `outline`"
            ),
        })
    }
}

/// Returns the shape facing the other way.
fn reversed(shape: Shape) -> Shape {
    match shape {
        Shape::Rectangle {
            center,
            ahead,
            up,
            size,
        } => Shape::Rectangle {
            center,
            ahead: ahead.map(|part| -part),
            up,
            size,
        },
        // Its corners are already counter-clockwise from the side of entry.
        outline => outline,
    }
}

/// Returns warnings about parts that overlap without a door between them: an eye in one may be located in the other.
fn overlap_warnings(world: &World, import: &Import) -> Vec<String> {
    let part_of = |room: &str| {
        let is_of = |part: &&world::Part| {
            room.strip_prefix(&part.name)
                .is_some_and(|rest| rest.starts_with('/') || rest == "-room")
        };
        world.parts.iter().find(is_of).map(|part| part.name.as_str())
    };
    let bounds = |part: &str| {
        let rooms = import
            .rooms
            .iter()
            .filter(|room| part_of(&room.name) == Some(part));
        rooms.fold(Aabb::EMPTY, |sum, room| sum.union(&room.geometry.bounds()))
    };
    let door = |a: &str, b: &str| {
        import.portals.iter().any(|portal| {
            let ends = [portal.from, portal.to].map(|id| part_of(&import.rooms[id.0 as usize].name));
            portal.there_from_here == Transform::IDENTITY
                && (ends == [Some(a), Some(b)] || ends == [Some(b), Some(a)])
        })
    };
    let mut warnings = Vec::new();
    for (number, a) in world.parts.iter().enumerate() {
        for b in &world.parts[..number] {
            let [one, other] = [bounds(&a.name), bounds(&b.name)];
            let meet = (0..3).all(|axis| one.min[axis] < other.max[axis] && other.min[axis] < one.max[axis]);
            if meet && !door(&a.name, &b.name) {
                let beside = other.max[0] - one.min[0];
                warnings.push(format!(
                    "parts {:?} and {:?} overlap, and no door joins them: an eye in one may be located in the other; \
                     move one of them, such as {:?} by {} more along x",
                    b.name,
                    a.name,
                    a.name,
                    count(beside.ceil().max(1.0) as u64)
                ));
            }
        }
    }
    warnings
}
