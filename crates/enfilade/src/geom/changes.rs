//! Test support: random worlds of AABBs that change, and the invariants of every dynamic tree over them.
//!
//! Each tree is checked against brute force and against a tree rebuilt from scratch over the same boxes.

use crate::geom::Aabb;

/// A tree over indexed AABBs that supports incremental changes.
pub(super) trait DynamicTree: Sized {
    /// Whether a primitive may be listed in several nodes.
    const COPIES: bool;

    fn over(bounds: &[Aabb]) -> Self;
    fn shift(&mut self, thing: u32, was: &Aabb, bounds: &[Aabb], touched: &mut Vec<u32>);
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
    random: Random,
}

/// Deterministic pseudo-random numbers.
#[derive(Clone)]
pub(super) struct Random(pub(super) u64);

impl Random {
    /// Returns a number from 0 to 1.
    pub(super) fn part(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    pub(super) fn below(&mut self, count: usize) -> usize {
        ((self.part() * count as f32) as usize).min(count - 1)
    }

    fn point(&mut self, side: f32) -> [f32; 3] {
        [0; 3].map(|_| side * self.part())
    }

    /// Returns a box of a town, usually a small one.
    fn thing(&mut self) -> Aabb {
        let size = if self.below(50) == 0 { 12.0 } else { 1.0 };
        placed(self.point(100.0), self.point(size))
    }

    /// Returns a box of any kind: empty, flat, huge, far away, or from the town.
    fn anything(&mut self) -> Aabb {
        match self.below(20) {
            0 => Aabb::EMPTY,
            1 => placed([50.0; 3], [1.0; 3]),
            2 => placed([50.0; 3], [0.0; 3]),
            3 => placed(self.point(3000.0).map(|x| x - 1500.0), self.point(1.0)),
            4 => placed(self.point(100.0).map(|x| x - 50.0), self.point(300.0)),
            5 => placed(self.point(100.0), self.point(1e-6)),
            6 => placed([-2e38, 1e38, 0.0], self.point(1e38)),
            7 => placed([7.0, self.part(), 7.0], [0.0, 20.0, 3.0]),
            _ => self.thing(),
        }
    }

    /// Returns `was` moved by up to 0.2 units per axis.
    fn step_from(&mut self, was: &Aabb) -> Aabb {
        let by = self.point(0.4).map(|x| x - 0.2);
        let moved = |at: [f32; 3]| [0, 1, 2].map(|axis| at[axis] + by[axis]);
        Aabb {
            min: moved(was.min),
            max: moved(was.max),
        }
    }
}

fn placed(at: [f32; 3], size: [f32; 3]) -> Aabb {
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
            random: Random(11),
        };
        world.count_held();
        world
    }

    /// Creates a world of primitives spread over a town.
    pub(super) fn town(count: usize) -> World<T> {
        let mut random = Random(5);
        World::new((0..count).map(|_| random.thing()).collect())
    }

    /// Changes boxes all at once: `boxes` already returns every new box when the tree is updated one by one.
    pub(super) fn change(&mut self, changes: &[(u32, Aabb)]) {
        let was: Vec<Aabb> = changes
            .iter()
            .map(|&(thing, now)| std::mem::replace(&mut self.bounds[thing as usize], now))
            .collect();
        self.touched.clear();
        for (&(thing, _), was) in changes.iter().zip(was) {
            let World {
                tree,
                bounds,
                touched,
                ..
            } = self;
            tree.shift(thing, &was, bounds, touched);
        }
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
            let query = self.random.anything();
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
        let mut random = Random(3);
        let mut asked = [0, 0];
        for i in 0..400 {
            let size = [2.0, 10.0, 30.0][i % 3];
            let query = placed(random.point(100.0), random.point(size));
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
        let mut random = Random(changes as u64);
        for _ in 0..changes {
            let thing = random.below(self.bounds.len());
            let was = self.bounds[thing];
            let now = match random.below(10) {
                0 => Aabb::EMPTY,
                1 => random.thing(),
                _ if was.is_empty() => random.thing(),
                _ => random.step_from(&was),
            };
            self.change(&[(thing as u32, now)]);
            self.tidy();
        }
    }
}

/// After thousands of changes, one by one and many at once, queries find the same as in a rebuilt tree.
pub(super) fn whatever_changes_is_found<T: DynamicTree>() {
    for count in [1, 3, 40, 700] {
        let mut random = Random(count as u64);
        let first = (0..count).map(|_| random.anything()).collect();
        let mut world = World::<T>::new(first);
        world.check();
        for round in 0..60 {
            let many = if round % 2 == 0 { 1 } else { 1 + count / 3 };
            for _ in 0..1 + 20 / many {
                let mut changes: Vec<(u32, Aabb)> = (0..many)
                    .map(|_| (random.below(count) as u32, random.anything()))
                    .collect();
                changes.sort_by_key(|&(thing, _)| thing);
                changes.dedup_by_key(|&mut (thing, _)| thing);
                for (thing, now) in &mut changes {
                    if round % 3 == 0 {
                        *now = random.step_from(&world.bounds[*thing as usize]);
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
pub(super) fn what_was_emptied_can_be_filled_again<T: DynamicTree>() {
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
    assert!(
        new.cost_ratio().into_iter().all(|by| by < 1.3),
        "{:?}",
        new.cost_ratio()
    );
}

/// After a hundred thousand changes a tree is about as fast and as small as a rebuilt one.
pub(super) fn a_long_life_leaves_it_as_good_as_new<T: DynamicTree>() {
    let mut world = World::<T>::town(10_000);
    world.live(100_000);
    world.check();
    let cost_ratio = world.cost_ratio();
    assert!(cost_ratio.into_iter().all(|by| by < 1.3), "{cost_ratio:?}");
    let [old, new] = [&world.tree, &T::over(&world.bounds)].map(|tree| tree.bytes());
    assert!(2 * old < 5 * new, "{old} bytes, not {new}");
}
