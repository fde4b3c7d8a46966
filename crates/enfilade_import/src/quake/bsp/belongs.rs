//! Whether portals are those of a map: by what they count, and by where they stand.

use super::BspError;
use super::lumps::Map;
use super::tree::{Child, Tree, int};
use crate::quake::PortalFile;
use glam::DVec3;

/// How far before and behind a portal its two clusters are looked for, in units of the map: thin leafs are few.
const ASIDE: f64 = 0.5;

/// For each cluster of the portals, how many leafs of the map it is.
///
/// # Errors
/// Where the map is of no kind that is known, damaged, or not the one that the portals are of.
pub fn leafs_of_clusters(map: &[u8], portals: &PortalFile) -> Result<Vec<u32>, BspError> {
    let map = Map::read(map)?;
    let tree = Tree::read(&map)?;
    let clusters = clusters_of_leafs(&map, portals)?;
    let mut leafs = vec![0; portals.cells.count() as usize];
    for &cluster in clusters.iter().flatten() {
        leafs[cluster as usize] += 1;
    }
    let all = portals.cells.portals();
    let stands = |portal: &&enfilade_bake::Portal| {
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
    let fit = all.iter().filter(stands).count();
    if fit * 2 < all.len() {
        return Err(BspError::OtherPlaces {
            fit,
            portals: all.len(),
        });
    }
    Ok(leafs)
}

/// For each leaf of the map its cluster, as numbered by the portals.
pub(super) fn clusters_of_leafs(map: &Map, portals: &PortalFile) -> Result<Vec<Option<u32>>, BspError> {
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
    let named: Vec<u32> = match &portals.cluster_of_leaf {
        Some(clusters) => clusters.clone(),
        None => (0..count).collect(),
    };
    let world_leafs = i64::from(map.world_leafs()?);
    if world_leafs != named.len() as i64 || leafs.len() <= named.len() {
        return Err(other(world_leafs, named.len(), "leafs"));
    }
    // The first leaf is solid, and those after the world's are in doors and lifts.
    let mut clusters = vec![None; leafs.len()];
    for (leaf, &cluster) in named.iter().enumerate() {
        clusters[leaf + 1] = Some(cluster);
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
