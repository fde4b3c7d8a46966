//! Tests whether portals belong to a map: by their counts and by their positions.

use super::BspError;
use super::lumps::Map;
use super::tree::{Child, Tree, int};
use crate::quake::PortalFile;
use enfilade_bake::Portal;
use glam::DVec3;

/// Distance in front of and behind a portal at which its two clusters are looked up, in map units; few leafs are
/// thinner.
const ASIDE: f64 = 0.5;

/// Result of matching the portals of a file with a map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlacedPortals {
    /// For each cluster, its number of leafs in the map.
    pub leafs: Vec<u32>,
    /// For each portal, whether its two clusters are directly in front of and behind it in the map. `false` for some
    /// portals of the right map too: where leafs are thinner than half a unit.
    pub in_place: Vec<bool>,
}

/// Matches portals with the map they were compiled from.
///
/// # Errors
/// Returns a [`BspError`] if the format of the map is unknown, if the map is damaged, or if the portals belong to
/// another map: the number of leafs or clusters differs, or less than half of the portals match.
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
    // Portals of another map match at random; those of this map all match, except at leafs thinner than the tested
    // distance.
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

/// Returns the cluster of each leaf of the map, in the numbering of the portals; `None` for solid leafs and for those
/// outside the world model.
pub(in crate::quake) fn clusters_of_leafs(
    map: &Map,
    portals: &PortalFile,
) -> Result<Vec<Option<u32>>, BspError> {
    let count = portals.cells.count();
    let leafs = map.records(map.format.leafs, map.format.leaf_bytes)?;
    if map.format.is_quake3 {
        // Solid leafs have cluster −1.
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
    // Without a leaf list, each leaf is a cluster.
    let of_leafs = portals.cluster_of_leaf.as_deref();
    let named = of_leafs.map_or(count as usize, <[u32]>::len);
    let world_leafs = i64::from(map.world_leafs()?);
    if world_leafs != named as i64 || leafs.len() <= named {
        return Err(other(world_leafs, named, "leafs"));
    }
    // The first leaf is solid; those after the world's leafs belong to brush models such as doors and lifts.
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
    /// Returns the leaf that contains a point; for a point on a plane, the leaf in front of it.
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
