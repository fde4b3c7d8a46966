//! The laws of all trees over boxes, built at once or changed step by step.
//!
//! Each tree is compared with brute force and with a tree rebuilt from scratch over the same boxes.

use super::{Aabb, Bvh, KdTree, Octree};
use fastrand::Rng;

/// A tree over indexed AABBs that supports incremental changes.
pub(super) trait DynamicTree: Sized {
    /// Whether a primitive may be listed in several nodes.
    const COPIES: bool;
    /// Maximum number of levels. Each costs O(n log n) at most to build, so it bounds the cost of building.
    const MAX_LEVELS: u32;

    fn over(bounds: &[Aabb]) -> Self;
    /// Moves primitives from their old AABBs, given with them, to those of `bounds`.
    fn shift(&mut self, moved: &[(u32, Aabb)], bounds: &[Aabb], touched: &mut Vec<u32>);
    fn tidy(&mut self, bounds: &[Aabb]) -> bool;
    fn root(&self) -> Option<u32>;
    fn bounds(&self, node: u32) -> Aabb;
    fn children(&self, node: u32) -> Vec<u32>;
    fn things(&self, node: u32) -> &[u32];
    fn node_count(&self) -> usize;
    fn bytes(&self) -> u64;
    /// Checks the structural invariants specific to this tree.
    fn check(&self, bounds: &[Aabb]);
}

/// Boxes that are hard to separate, each set with a name for assertion messages.
pub(super) fn hard_boxes(count: u32) -> Vec<(&'static str, Vec<Aabb>)> {
    let around = |side: f32| placed([-0.5 * side; 3], [side; 3]);
    let all = |side: fn(f32) -> f32| (0..count).map(|i| around(side(i as f32))).collect();
    let row = |at: fn(f32) -> f32| -> Vec<Aabb> {
        let boxes = (0..count).map(|i| placed([at(i as f32), 0.0, 0.0], [0.5; 3]));
        boxes.collect()
    };
    let mut giant = row(|i| i);
    giant[7] = around(1e9);
    vec![
        ("coincident", all(|_| 1.0)),
        ("points at one position", all(|_| 0.0)),
        ("concentric", all(|i| i)),
        ("concentric, of few sizes", all(|i| i % 3.0)),
        ("ever farther apart", row(|i| i * i)),
        ("exponentially spaced", row(|i| (i * 1e-3).exp2().min(1e38))),
        ("in a row, huge", row(|i| 3e38 - i * 1e33)),
        ("in a row, tiny", row(|i| i * 1e-43)),
        ("in a row with one giant", giant),
    ]
}

/// AABBs, the tree over them, and the nodes touched by the last change.
pub(super) struct World<T> {
    pub(super) bounds: Vec<Aabb>,
    pub(super) tree: T,
    /// Nodes that the last change reported as touched.
    pub(super) touched: Vec<u32>,
    /// Number of primitives in each node's subtree, updated only for touched nodes.
    held: Vec<usize>,
    random: Rng,
}

fn point(random: &mut Rng, side: f32) -> [f32; 3] {
    [0; 3].map(|_| side * random.f32())
}

/// Returns a box of a town, usually a small one.
fn thing(random: &mut Rng) -> Aabb {
    let size = if random.usize(..50) == 0 { 12.0 } else { 1.0 };
    placed(point(random, 100.0), point(random, size))
}

/// Returns a box of any kind: empty, flat, huge, far away, or from the town.
fn anything(random: &mut Rng) -> Aabb {
    match random.u32(..20) {
        0 => Aabb::EMPTY,
        1 => placed([50.0; 3], [1.0; 3]),
        2 => placed([50.0; 3], [0.0; 3]),
        3 => placed(point(random, 3000.0).map(|x| x - 1500.0), point(random, 1.0)),
        4 => placed(point(random, 100.0).map(|x| x - 50.0), point(random, 300.0)),
        5 => placed(point(random, 100.0), point(random, 1e-6)),
        6 => placed([-2e38, 1e38, 0.0], point(random, 1e38)),
        7 => placed([7.0, random.f32(), 7.0], [0.0, 20.0, 3.0]),
        _ => thing(random),
    }
}

/// Returns `was` moved by up to 0.2 units per axis.
fn step_from(random: &mut Rng, was: &Aabb) -> Aabb {
    let by = point(random, 0.4).map(|x| x - 0.2);
    let moved = |at: [f32; 3]| [0, 1, 2].map(|axis| at[axis] + by[axis]);
    Aabb {
        min: moved(was.min),
        max: moved(was.max),
    }
}

pub(super) fn placed(at: [f32; 3], size: [f32; 3]) -> Aabb {
    Aabb {
        min: at,
        max: [0, 1, 2].map(|axis| at[axis] + size[axis]),
    }
}

impl<T: DynamicTree> World<T> {
    pub(super) fn new(bounds: Vec<Aabb>) -> World<T> {
        let mut world = World {
            tree: T::over(&bounds),
            bounds,
            touched: Vec::new(),
            held: Vec::new(),
            random: Rng::with_seed(11),
        };
        world.count_held();
        world
    }

    /// Creates a world of primitives spread over a town.
    pub(super) fn town(count: usize) -> World<T> {
        let mut random = Rng::with_seed(5);
        World::new((0..count).map(|_| thing(&mut random)).collect())
    }

    /// Changes boxes all at once: `bounds` already has every new box when the tree is updated.
    pub(super) fn change(&mut self, changes: &[(u32, Aabb)]) {
        let was: Vec<(u32, Aabb)> = changes
            .iter()
            .map(|&(thing, now)| (thing, std::mem::replace(&mut self.bounds[thing as usize], now)))
            .collect();
        self.touched.clear();
        self.tree.shift(&was, &self.bounds, &mut self.touched);
        self.held.resize(self.tree.node_count(), 0);
        for &node in &self.touched {
            self.held[node as usize] = self.held_in(node);
        }
    }

    fn held_in(&self, node: u32) -> usize {
        let below = self.tree.children(node).into_iter();
        let below: usize = below.map(|child| self.held[child as usize]).sum();
        self.tree.things(node).len() + below
    }

    fn count_held(&mut self) {
        self.held.clear();
        self.held.resize(self.tree.node_count(), 0);
        for node in self.nodes().into_iter().rev() {
            self.held[node as usize] = self.held_in(node);
        }
    }

    pub(super) fn tidy(&mut self) -> bool {
        let anew = self.tree.tidy(&self.bounds);
        if anew {
            self.count_held();
        }
        anew
    }

    /// Returns all nonempty nodes, parents before children.
    fn nodes(&self) -> Vec<u32> {
        let mut nodes: Vec<u32> = self.tree.root().into_iter().collect();
        let mut next = 0;
        while next < nodes.len() {
            nodes.extend(self.tree.children(nodes[next]));
            next += 1;
        }
        nodes
    }

    /// Returns the primitives that overlap the query box, found by traversal, and the number of boxes tested.
    fn met(tree: &T, bounds: &[Aabb], query: &Aabb) -> (Vec<u32>, usize) {
        let mut met = Vec::new();
        let mut asked = 0;
        let mut pending: Vec<u32> = tree.root().into_iter().collect();
        while let Some(node) = pending.pop() {
            asked += 1;
            if tree.bounds(node).meets(query) {
                pending.extend(tree.children(node));
                asked += tree.things(node).len();
                let things = tree.things(node).iter().copied();
                met.extend(things.filter(|&thing| bounds[thing as usize].meets(query)));
            }
        }
        met.sort();
        if T::COPIES {
            met.dedup();
        }
        (met, asked)
    }

    /// Checks that every primitive is in the tree (once, unless copies are allowed), that node boxes are tight, and
    /// that queries find what brute force finds.
    pub(super) fn check(&mut self) {
        self.tree.check(&self.bounds);
        let mut times = vec![0; self.bounds.len()];
        for node in self.nodes() {
            let outer = self.tree.bounds(node);
            assert_eq!(
                self.held[node as usize],
                self.held_in(node),
                "node {node} changed but was not reported as touched"
            );
            assert!(self.held[node as usize] > 0, "node {node} is empty");
            let mut inner = Aabb::EMPTY;
            for &thing in self.tree.things(node) {
                times[thing as usize] += 1;
                inner = inner.union(&self.bounds[thing as usize]);
            }
            for child in self.tree.children(node) {
                inner = inner.union(&self.tree.bounds(child));
            }
            assert!(T::COPIES || inner == outer, "node {node}: {inner:?} in {outer:?}");
        }
        for (times, bounds) in times.into_iter().zip(&self.bounds) {
            assert_eq!(times > 0, !bounds.is_empty());
            assert!(T::COPIES || times <= 1);
        }
        for _ in 0..10 {
            let query = anything(&mut self.random);
            let (met, _) = World::met(&self.tree, &self.bounds, &query);
            let all = 0..self.bounds.len() as u32;
            let meets = |&thing: &u32| {
                let thing = &self.bounds[thing as usize];
                !thing.is_empty() && thing.meets(&query)
            };
            assert_eq!(met, all.filter(meets).collect::<Vec<u32>>());
        }
    }

    /// Cost of this tree relative to a rebuilt one, by two measures: boxes tested for random queries; and the SAH cost,
    /// the sum of box areas weighted by the number of children and primitives tested on entering each node.
    pub(super) fn cost_ratio(&self) -> [f64; 2] {
        let fresh = T::over(&self.bounds);
        let mut random = Rng::with_seed(3);
        let mut asked = [0, 0];
        for i in 0..400 {
            let size = [2.0, 10.0, 30.0][i % 3];
            let query = placed(point(&mut random, 100.0), point(&mut random, size));
            for (asked, tree) in asked.iter_mut().zip([&self.tree, &fresh]) {
                *asked += World::met(tree, &self.bounds, &query).1;
            }
        }
        let areas = [&self.tree, &fresh].map(|tree| {
            let mut pending: Vec<u32> = tree.root().into_iter().collect();
            let mut sum = 0.0;
            while let Some(node) = pending.pop() {
                let [x, y, z] = tree.bounds(node).size().map(f64::from);
                let children = tree.children(node);
                sum += (x * y + y * z + z * x) * (children.len() + tree.things(node).len()) as f64;
                pending.extend(children);
            }
            sum
        });
        [asked[0] as f64 / asked[1] as f64, areas[0] / areas[1]]
    }

    /// Applies many changes of all kinds one by one: small moves, jumps, removals and insertions.
    pub(super) fn live(&mut self, changes: usize) {
        let mut random = Rng::with_seed(changes as u64);
        for _ in 0..changes {
            let index = random.usize(..self.bounds.len());
            let was = self.bounds[index];
            let now = match random.usize(..10) {
                0 => Aabb::EMPTY,
                1 => thing(&mut random),
                _ if was.is_empty() => thing(&mut random),
                _ => step_from(&mut random, &was),
            };
            self.change(&[(index as u32, now)]);
            self.tidy();
        }
    }
}

/// Builds a tree and checks that every box that is not empty is in a leaf whose boxes enclose it: in one leaf, or in
/// several that share it.
fn every_box_is_held<T: DynamicTree>(what: &str, boxes: &[Aabb]) {
    let tree = T::over(boxes);
    let mut times = vec![0; boxes.len()];
    let mut pending: Vec<(u32, u32)> = tree.root().map(|root| (root, 0)).into_iter().collect();
    while let Some((node, level)) = pending.pop() {
        assert!(
            level <= T::MAX_LEVELS,
            "{what}: more than {} levels",
            T::MAX_LEVELS
        );
        let outer = tree.bounds(node);
        for child in tree.children(node) {
            assert_eq!(outer.union(&tree.bounds(child)), outer, "{what}");
            pending.push((child, level + 1));
        }
        for &thing in tree.things(node) {
            times[thing as usize] += 1;
            let bounds = &boxes[thing as usize];
            let is_held = if T::COPIES {
                !outer.intersection(bounds).is_empty()
            } else {
                outer.union(bounds) == outer
            };
            assert!(is_held, "{what}: box {thing} is outside its leaf");
        }
    }
    for (times, bounds) in times.iter().zip(boxes) {
        assert_eq!(*times > 0, !bounds.is_empty(), "{what}");
        assert!(T::COPIES || *times <= 1, "{what}");
    }
    assert!(
        tree.node_count() <= 4 * boxes.len() + 8,
        "{what}: {} nodes",
        tree.node_count()
    );
    assert_eq!(tree.root().is_none(), boxes.iter().all(Aabb::is_empty), "{what}");
}

fn every_set_of_boxes_is_held<T: DynamicTree>() {
    for count in [0, 1, 2, 3, 7, 10] {
        every_box_is_held::<T>("few", &World::<T>::town(count).bounds);
    }
    every_box_is_held::<T>("none", &[Aabb::EMPTY; 9]);
    every_box_is_held::<T>("a town", &World::<T>::town(5000).bounds);
    let growing = (0..300).map(|i| placed([1.2_f32.powi(i); 3], [1.0; 3]));
    every_box_is_held::<T>("growing", &growing.collect::<Vec<_>>());
    let corners = [[-3e38; 3], [3e38; 3], [0.0; 3], [-3e38; 3], [1e-20; 3]];
    let mut huge = corners.map(|at| placed(at, [1e37; 3]));
    huge[2] = Aabb::EMPTY;
    every_box_is_held::<T>("huge", &huge);
    for (what, boxes) in hard_boxes(100_000) {
        every_box_is_held::<T>(what, &boxes);
    }
}

/// After thousands of changes, one by one and many at once, queries find the same as in a rebuilt tree.
fn whatever_changes_is_found<T: DynamicTree>() {
    for count in [1, 3, 40, 700] {
        let mut random = Rng::with_seed(count as u64);
        let first = (0..count).map(|_| anything(&mut random)).collect();
        let mut world = World::<T>::new(first);
        world.check();
        for round in 0..60 {
            let many = if round % 2 == 0 { 1 } else { 1 + count / 3 };
            for _ in 0..1 + 20 / many {
                let mut changes: Vec<(u32, Aabb)> = (0..many)
                    .map(|_| (random.usize(..count) as u32, anything(&mut random)))
                    .collect();
                changes.sort_by_key(|&(thing, _)| thing);
                changes.dedup_by_key(|&mut (thing, _)| thing);
                for (thing, now) in &mut changes {
                    if round % 3 == 0 {
                        *now = step_from(&mut random, &world.bounds[*thing as usize]);
                    }
                }
                world.change(&changes);
            }
            world.check();
            if round % 10 == 9 {
                world.tidy();
                world.check();
            }
        }
    }
}

/// A tree from which everything is removed is empty and can be filled again.
fn what_was_emptied_can_be_filled_again<T: DynamicTree>() {
    let mut world = World::<T>::town(300);
    let full = world.bounds.clone();
    for _ in 0..3 {
        for thing in 0..300 {
            world.change(&[(thing, Aabb::EMPTY)]);
        }
        assert_eq!(world.tree.root(), None);
        world.check();
        for (thing, &bounds) in full.iter().enumerate() {
            world.change(&[(thing as u32, bounds)]);
            world.tidy();
        }
        world.check();
    }
    let mut new = World::<T>::new(vec![Aabb::EMPTY; 300]);
    for (thing, &bounds) in full.iter().enumerate() {
        new.change(&[(thing as u32, bounds)]);
        new.tidy();
    }
    new.check();
    // The largest ratio seen is 1.37.
    assert!(
        new.cost_ratio().into_iter().all(|by| by < 1.5),
        "{:?}",
        new.cost_ratio()
    );
}

/// After a hundred thousand changes a tree is about as fast and as small as a rebuilt one.
fn a_long_life_leaves_it_as_good_as_new<T: DynamicTree>() {
    let mut world = World::<T>::town(10_000);
    world.live(100_000);
    world.check();
    let cost_ratio = world.cost_ratio();
    assert!(cost_ratio.into_iter().all(|by| by < 1.3), "{cost_ratio:?}");
    let [old, new] = [&world.tree, &T::over(&world.bounds)].map(|tree| tree.bytes());
    assert!(2 * old < 5 * new, "{old} bytes, not {new}");
}

#[test]
fn every_box_is_in_a_leaf_that_holds_it_however_hard_to_separate() {
    every_set_of_boxes_is_held::<Octree>();
    every_set_of_boxes_is_held::<Bvh>();
    every_set_of_boxes_is_held::<KdTree>();
}

#[test]
fn queries_find_whatever_has_changed() {
    whatever_changes_is_found::<Octree>();
    whatever_changes_is_found::<Bvh>();
    whatever_changes_is_found::<KdTree>();
}

#[test]
fn a_tree_that_was_emptied_can_be_filled_again() {
    what_was_emptied_can_be_filled_again::<Octree>();
    what_was_emptied_can_be_filled_again::<Bvh>();
    what_was_emptied_can_be_filled_again::<KdTree>();
}

#[test]
fn a_tree_is_as_good_as_new_after_a_hundred_thousand_changes() {
    a_long_life_leaves_it_as_good_as_new::<Octree>();
    a_long_life_leaves_it_as_good_as_new::<Bvh>();
    a_long_life_leaves_it_as_good_as_new::<KdTree>();
}
