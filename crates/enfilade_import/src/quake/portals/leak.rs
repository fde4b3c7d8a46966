//! Finds the leak of a compiled map: a way from an entity to the void, as a line for map editors.
//!
//! Map compilers fill the outside of a sealed map with solid. If an entity can see the outside, they fill nothing and write no
//! portals, so the compiled map has open leafs around it.
//! Idea: open clusters that touch the end of the world are outside. The shortest way from there to a cluster with an entity,
//!     through the middles of rebuilt portals, passes the hole.
//! Source: the outside fill of id Software's qbsp; Dijkstra. A note on two problems in connexion with graphs. 1959.
//! Cost: that of rebuilding the portals, and O(portals · log portals).

use super::clusters::Clusters;
use super::polygon::{Corner, Side, sides_of};
use super::{Child, Map, Portals, SubtreeCluster, Tree, world};
use crate::budget::Budget;
use crate::quake::bsp::number;
use crate::quake::scene::entities::{self, Entity};
use crate::{BrokenRule, ImportError, ReadOptions};
use enfilade_bake::Portal;
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::fmt::Write;

/// A way from an entity of a map to the void, in the units and axes of the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Leak {
    /// The entity: its class, name and index, such as `light#3`.
    pub entity: String,
    /// The position of the entity.
    pub origin: [f64; 3],
    /// The way: from the entity through the middles of openings to the void, at least two points.
    pub line: Vec<[f64; 3]>,
}

impl Leak {
    /// Returns the line as map compilers write it into a `.pts` file, which map editors and engines load: `x y z` in each line,
    /// every two units, or further apart if it is very long.
    pub fn to_pts(&self) -> String {
        /// Distance of points, in units.
        const STEP: f64 = 2.0;
        /// Engines draw no more.
        const MOST: f64 = 8000.0;
        let legs = || {
            self.line
                .windows(2)
                .map(|ends| [ends[0], ends[1]].map(DVec3::from))
        };
        let length: f64 = legs().map(|[from, to]| from.distance(to)).sum();
        let step = STEP.max(length / MOST);
        let mut text = String::new();
        let mut point = |at: DVec3| {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{:.3} {:.3} {:.3}", at.x, at.y, at.z);
        };
        for [from, to] in legs() {
            let steps = (from.distance(to) / step).ceil().max(1.0) as u32;
            (0..steps).for_each(|nth| point(from.lerp(to, f64::from(nth) / f64::from(steps))));
        }
        self.line.last().into_iter().for_each(|&end| point(end.into()));
        text
    }
}

/// Returns the leak of a compiled map in memory: BSP29, BSP2 or IBSP46; `None` if no entity sees the void.
///
/// # Errors
/// The same as [`rebuild_portals_bytes`](crate::rebuild_portals_bytes), and those of entities.
pub fn find_leak(map: &[u8], options: &ReadOptions) -> Result<Option<Leak>, ImportError> {
    leak_of(map, Budget::new(options.limit_bytes)).map_err(|rule| ImportError {
        file: "the bytes given".to_owned(),
        rule,
    })
}

fn leak_of(bytes: &[u8], mut budget: Budget) -> Result<Option<Leak>, BrokenRule> {
    budget.take(bytes.len() as u64 * 6, || "its tree".to_owned())?;
    let map = Map::read(bytes)?;
    let tree = Tree::read(&map)?;
    let clusters = Clusters::of(&map, &tree)?;
    let text = entities::text(&map, &mut budget)?;
    let entities = entities::parse(&text)?;
    let portals = Portals::find_all(&map, &tree, &clusters, budget)?;
    let outside = outside(&portals, world(&map));
    let ways = Ways::from(&portals, &outside, &near(&map))?;
    let occupants = entities.iter().filter_map(|entity| occupant(entity, &portals));
    let nearest = occupants
        .filter_map(|(entity, origin, cluster)| {
            Some((ways.distance(cluster, origin)?, entity, origin, cluster))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0));
    Ok(nearest.map(|(_, entity, origin, cluster)| Leak {
        entity: entity.name(),
        origin: origin.into(),
        line: ways.line(cluster, origin, &portals),
    }))
}

/// Returns the sides of a box around everything that is drawn, so that lines do not go where nobody looks; no sides if the map
/// does not tell its size.
fn near(map: &Map) -> Vec<Side> {
    const MARGIN: f64 = 64.0;
    let world = map.lump(map.format.models).get(..24).unwrap_or(&[0; 24]);
    let corner = |at: usize| DVec3::from([0, 4, 8].map(|axis| f64::from(number(world, at + axis))));
    let [least, most] = [corner(0), corner(12)];
    if !least.cmplt(most).all() || !(most - least).is_finite() {
        return Vec::new();
    }
    sides_of([least - MARGIN, most + MARGIN]).to_vec()
}

/// Returns for each cluster a point where it touches the end of the world; `None` if it does not.
fn outside(portals: &Portals, world: [DVec3; 2]) -> Vec<Option<DVec3>> {
    let sides = sides_of(world);
    let mut touches = vec![None; portals.clusters.count() as usize];
    for side in sides {
        let face = cut(side.sheet(), &sides);
        for (cluster, piece) in portals.push_down(portals.tree.root, &face) {
            touches[cluster as usize].get_or_insert(middle(&piece));
        }
    }
    touches
}

fn cut(polygon: Vec<Corner>, sides: &[Side]) -> Vec<Corner> {
    sides.iter().fold(polygon, |polygon, side| {
        if polygon.is_empty() {
            polygon
        } else {
            side.cut(polygon)
        }
    })
}

fn middle(corners: &[Corner]) -> DVec3 {
    corners.iter().map(|corner| corner.at).sum::<DVec3>() / corners.len().max(1) as f64
}

/// An opening between two clusters.
#[derive(Clone, Copy, Debug)]
struct Hole {
    middle: DVec3,
    /// Across the opening, to either side.
    across: DVec3,
}

impl Hole {
    /// Returns the part of a portal that is near the map, or all of it if none is.
    fn of(portal: &Portal, near: &[Side]) -> Hole {
        let corners = portal.corners.iter().map(|&corner| DVec3::from(corner));
        let [a, b, c] = [0, 1, 2].map(|nth| DVec3::from(portal.corners[nth]));
        let across = (b - a).cross(c - a).normalize_or(DVec3::Z);
        let whole: Vec<Corner> = corners
            .map(|at| Corner {
                at,
                edge: Side::across(across, at),
            })
            .collect();
        let part = cut(whole.clone(), near);
        Hole {
            middle: middle(if part.is_empty() { &whole } else { &part }),
            across,
        }
    }
}

/// Returns the position of an entity that must not see the void, with its cluster; `None` if it is none, or in a wall.
fn occupant<'e, 't>(entity: &'e Entity<'t>, portals: &Portals) -> Option<(&'e Entity<'t>, DVec3, u32)> {
    let origin = DVec3::from(entity.three("origin")?.map(f64::from));
    // Brush entities have their origin anywhere.
    if entity.class() == "worldspawn" || entity.get("model").starts_with('*') {
        return None;
    }
    // One unit higher, as compilers do: things may stand exactly on a floor.
    let cluster = cluster_at(origin + DVec3::Z, portals)?;
    Some((entity, origin, cluster))
}

fn cluster_at(point: DVec3, portals: &Portals) -> Option<u32> {
    let mut child = portals.tree.root;
    loop {
        match (portals.clusters.part(child), child) {
            (SubtreeCluster::Cluster(cluster), _) => return Some(cluster),
            (SubtreeCluster::Mixed, Child::Node(node)) => {
                let node = portals.tree.nodes[node as usize];
                let side = portals.sides[node.plane as usize];
                child = node.children[usize::from(side.inside(point) < 0.0)];
            }
            (SubtreeCluster::Solid | SubtreeCluster::Mixed, _) => return None,
        }
    }
}

/// The shortest ways from all clusters to the void, through the middles of portals.
struct Ways {
    /// For each cluster that the void reaches: where its way leaves it, and the length from there.
    exits: Vec<Option<Exit>>,
}

#[derive(Clone, Copy, Debug)]
struct Exit {
    hole: Hole,
    length: f64,
    /// The next cluster on the way; `None` if this one is in the void, where the hole is a point at the end of the world.
    next: Option<u32>,
}

/// Clusters to be visited, nearest first: the bits of the length of their ways, and their index.
type Waiting = BinaryHeap<Reverse<(u64, u32)>>;

impl Ways {
    fn from(portals: &Portals, outside: &[Option<DVec3>], near: &[Side]) -> Result<Ways, BrokenRule> {
        let mut budget = portals.budget.clone();
        let bytes =
            portals.found.len() * 4 * size_of::<(u32, Hole)>() + outside.len() * 2 * size_of::<Exit>();
        budget.take(bytes as u64, || "the ways to the void".to_owned())?;
        let mut holes: Vec<Vec<(u32, Hole)>> = vec![Vec::new(); outside.len()];
        for portal in &portals.found {
            let hole = Hole::of(portal, near);
            let [a, b] = portal.cells;
            holes[a as usize].push((b, hole));
            holes[b as usize].push((a, hole));
        }
        let mut exits: Vec<Option<Exit>> = vec![None; outside.len()];
        let mut waiting = Waiting::new();
        for (cluster, touch) in (0..).zip(outside) {
            let Some(middle) = *touch else { continue };
            exits[cluster as usize] = Some(Exit {
                hole: Hole {
                    middle,
                    across: DVec3::Z,
                },
                length: 0.0,
                next: None,
            });
            waiting.push(Reverse((0, cluster)));
        }
        while let Some(Reverse((length, cluster))) = waiting.pop() {
            let Some(exit) = exits[cluster as usize].filter(|exit| exit.length.to_bits() == length) else {
                continue;
            };
            for &(next, hole) in &holes[cluster as usize] {
                let length = match exit.next {
                    None => 0.0,
                    Some(_) => exit.length + hole.middle.distance(exit.hole.middle),
                };
                if exits[next as usize].is_none_or(|known| length < known.length) {
                    exits[next as usize] = Some(Exit {
                        hole,
                        length,
                        next: Some(cluster),
                    });
                    // Lengths are not negative, so their bits are in the same order.
                    waiting.push(Reverse((length.to_bits(), next)));
                }
            }
        }
        Ok(Ways { exits })
    }

    /// Returns the length of the way from a point of a cluster to the void.
    fn distance(&self, cluster: u32, from: DVec3) -> Option<f64> {
        let exit = self.exits[cluster as usize]?;
        Some(exit.length + from.distance(exit.hole.middle))
    }

    /// Returns the way from a point of a cluster to the void.
    fn line(&self, cluster: u32, from: DVec3, portals: &Portals) -> Vec<[f64; 3]> {
        let mut line = vec![from];
        let mut at = self.exits[cluster as usize];
        while let Some(exit) = at {
            line.push(exit.hole.middle);
            let Some(next) = exit.next else { break };
            at = self.exits[next as usize];
            if at.is_some_and(|exit| exit.next.is_none()) {
                // The end of the world is far away; a little behind the last opening is void as well.
                line.extend(behind(&exit.hole, next, portals));
                break;
            }
        }
        line.into_iter().map(Into::into).collect()
    }
}

/// Returns a point of a cluster a little behind an opening into it.
fn behind(hole: &Hole, cluster: u32, portals: &Portals) -> Option<DVec3> {
    /// Units.
    const DISTANCES: [f64; 3] = [32.0, 8.0, 1.0];
    let points = DISTANCES.into_iter().flat_map(|distance| [distance, -distance]);
    let mut points = points.map(|distance| hole.middle + hole.across * distance);
    points.find(|&point| cluster_at(point, portals) == Some(cluster))
}
