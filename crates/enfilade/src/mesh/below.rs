//! Precomputed contents of the subtrees of a mesh's octree.

use crate::geom::Octree;

/// For each node of an octree the clusters in its subtree.
#[derive(Clone, Debug, Default)]
pub(crate) struct Below {
    /// Clusters of a node come first, then those of its children.
    clusters: Vec<u32>,
    /// Number of triangles before each cluster, and finally the total.
    triangles: Vec<u64>,
    /// Start and end of each subtree in `clusters`.
    nodes: Vec<[u32; 2]>,
}

impl Below {
    /// Computes the subtrees of a new octree; `triangles_in` returns the number of triangles in a cluster.
    pub(super) fn new(tree: &Octree, triangles_in: impl Fn(usize) -> u64) -> Below {
        let mut below = Below {
            clusters: Vec::new(),
            triangles: vec![0],
            nodes: vec![[0; 2]; tree.node_count()],
        };
        let mut waiting: Vec<u32> = tree.root().into_iter().collect();
        while let Some(node) = waiting.pop() {
            waiting.extend(tree.children(node));
            below.nodes[node as usize][0] = below.clusters.len() as u32;
            for &cluster in tree.things(node) {
                below.clusters.push(cluster);
                let before = below.triangles[below.triangles.len() - 1];
                below.triangles.push(before + triangles_in(cluster as usize));
            }
            below.nodes[node as usize][1] = below.clusters.len() as u32;
        }
        // Children have higher numbers than their parents.
        for node in (0..below.nodes.len()).rev() {
            for child in tree.children(node as u32) {
                below.nodes[node][1] = below.nodes[node][1].max(below.nodes[child as usize][1]);
            }
        }
        below
    }

    /// Returns the clusters in the subtree of a node, in no particular order.
    pub(crate) fn clusters(&self, node: u32) -> &[u32] {
        let [start, end] = self.nodes[node as usize];
        &self.clusters[start as usize..end as usize]
    }

    /// Returns the number of triangles in the subtree of a node.
    pub(crate) fn triangles(&self, node: u32) -> u64 {
        let [start, end] = self.nodes[node as usize];
        self.triangles[end as usize] - self.triangles[start as usize]
    }

    /// Returns the memory used, in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.clusters) + size_of_val(&*self.triangles) + size_of_val(&*self.nodes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Aabb;

    #[test]
    fn below_a_node_is_all_that_a_walk_from_there_meets() {
        let boxes: Vec<Aabb> = (0..300_u32)
            .map(|i| {
                let corner = [i % 7, i / 7 % 6, i / 42].map(|step| step as f32 * 1.5);
                let side = if i % 11 == 0 { 4.0 } else { 0.3 };
                Aabb {
                    min: corner,
                    max: corner.map(|value| value + side),
                }
            })
            .collect();
        let tree = Octree::build(&boxes, 4);
        let triangles_in = |cluster: usize| cluster as u64 * 3 + 1;
        let below = Below::new(&tree, triangles_in);
        assert!(tree.node_count() > 40);
        for node in 0..tree.node_count() as u32 {
            let mut met = Vec::new();
            let mut waiting = vec![node];
            while let Some(node) = waiting.pop() {
                met.extend_from_slice(tree.things(node));
                waiting.extend(tree.children(node));
            }
            let mut known = below.clusters(node).to_vec();
            met.sort_unstable();
            known.sort_unstable();
            assert_eq!(known, met, "node {node}");
            let triangles: u64 = met.iter().map(|&cluster| triangles_in(cluster as usize)).sum();
            assert_eq!(below.triangles(node), triangles, "node {node}");
        }
    }
}
