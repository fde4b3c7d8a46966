//! Whether portals are those of a map: by what they count, and by where they stand.

use super::BspError;
use super::lumps::Map;
use super::tree::{Child, Tree, int};
use crate::quake::PortalFile;
use enfilade_bake::Portal;
use glam::DVec3;

/// How far before and behind a portal its two clusters are looked for, in units of the map: thin leafs are few.
const ASIDE: f64 = 0.5;

/// Portals as they stand in a map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlacedPortals {
    /// By cluster, how many leafs of the map it is.
    pub leafs: Vec<u32>,
    /// By portal, whether the map has its two clusters right before and behind it. Where leafs are thinner than half a unit
    /// it has others there.
    pub in_place: Vec<bool>,
}

/// Finds out where portals stand in the map that they are of.
///
/// # Errors
/// Where the map is of no kind that is known, damaged, or not the one that the portals are of: it has another number of
/// leafs or clusters, or less than half of the portals are in place.
pub fn place_portals(map: &[u8], portals: &PortalFile) -> Result<PlacedPortals, BspError> {
    let map = Map::read(map)?;
    let tree = Tree::read(&map)?;
    let clusters = clusters_of_leafs(&map, portals)?;
    let mut leafs = vec![0; portals.cells.count() as usize];
    for &cluster in clusters.iter().flatten() {
        leafs[cluster as usize] += 1;
    }
    let all = portals.cells.portals();
    let stands = |portal: &Portal| {
        let corners = portal.corners.iter().map(|&corner| DVec3::from(corner));
        let centre = corners.sum::<DVec3>() / portal.corners.len() as f64;
        let corner = |at: usize| DVec3::from(portal.corners[at]) - centre;
        let across: DVec3 = (0..portal.corners.len())
            .map(|at| corner(at).cross(corner((at + 1) % portal.corners.len())))
            .sum();
        let aside = across.normalize_or_zero() * ASIDE;
        let cluster = |point| clusters[tree.leaf_at(point) as usize];
        [cluster(centre - aside), cluster(centre + aside)] == portal.cells.map(Some)
    };
    // Those of another map stand anywhere; of this one all but those at leafs that are thinner than what is tried.
    let in_place: Vec<bool> = all.iter().map(stands).collect();
    let fit = in_place.iter().filter(|&&is_in_place| is_in_place).count();
    if fit * 2 < all.len() {
        return Err(BspError::OtherPlaces {
            fit,
            portals: all.len(),
        });
    }
    Ok(PlacedPortals { leafs, in_place })
}

/// For each leaf of the map its cluster, as numbered by the portals.
pub(in crate::quake) fn clusters_of_leafs(
    map: &Map,
    portals: &PortalFile,
) -> Result<Vec<Option<u32>>, BspError> {
    let count = portals.cells.count();
    let leafs = map.things(map.format.leafs, map.format.leaf_bytes)?;
    if map.format.is_quake3 {
        // Solid leafs say −1.
        let clusters: Vec<i32> = leafs.map(|leaf| int(leaf, 0)).collect();
        let has = clusters.iter().max().map_or(0, |&most| i64::from(most) + 1);
        if has != i64::from(count) {
            return Err(other(has, count as usize, "clusters"));
        }
        return Ok(clusters
            .iter()
            .map(|&cluster| u32::try_from(cluster).ok())
            .collect());
    }
    // Without leafs of its own each cluster is one.
    let of_leafs = portals.cluster_of_leaf.as_deref();
    let named = of_leafs.map_or(count as usize, <[u32]>::len);
    let world_leafs = i64::from(map.world_leafs()?);
    if world_leafs != named as i64 || leafs.len() <= named {
        return Err(other(world_leafs, named, "leafs"));
    }
    // The first leaf is solid, and those after the world's are in doors and lifts.
    let mut clusters = vec![None; leafs.len()];
    for leaf in 0..named {
        clusters[leaf + 1] = Some(of_leafs.map_or(leaf as u32, |of_leafs| of_leafs[leaf]));
    }
    Ok(clusters)
}

fn other(map: i64, portals: usize, what: &'static str) -> BspError {
    BspError::OtherMap { map, portals, what }
}

impl Tree {
    /// The leaf that a point is in; on a plane, the one before it.
    fn leaf_at(&self, point: DVec3) -> u32 {
        let mut at = self.root;
        loop {
            match at {
                Child::Leaf(leaf) => return leaf,
                Child::Node(node) => {
                    let node = self.nodes[node as usize];
                    let plane = self.planes[node.plane as usize];
                    let is_behind = DVec3::from(plane.normal).dot(point) < plane.offset;
                    at = node.children[usize::from(is_behind)];
                }
            }
        }
    }
}
