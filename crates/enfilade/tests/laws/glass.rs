//! Transparency: every method paints transparent layers in the order of the reference, and visible sets report how to
//! blend.

use crate::subject::{SIZE, Subject, limits, subjects, viewer};
use enfilade::laws::{LayerPicture, Reference};
use enfilade::{Canvas, Contract, ItemId, Owner, Passage, PassageId, Span, Viewer};
use enfilade_scenes::{Group, SCENES};
use std::collections::{BTreeMap, BTreeSet};

/// Compares the transparent layers that every method paints with the reference, from every camera. Returns the number
/// of compared samples, of those with two or more layers, and the maximum number of layers.
fn glass_is_painted_in_order(subject: &Subject, size: [u32; 2]) -> [usize; 3] {
    let Subject { name, built, seen } = subject;
    let reference = Reference::new(&built.scene);
    let mut looked_at = [0, 0, 0];
    for camera in &built.cameras {
        let view = camera.view(size);
        let truth = reference.layers(&built.scene, &view, &limits());
        for (method, scene) in seen {
            let mut picture = LayerPicture::new(size);
            viewer().draw(scene, &view, &mut picture);
            let verdict = truth.check(&picture);
            if method.contract().never_misses() {
                let first = verdict.different.first().copied();
                let why = first.map(|at| format!("{at:?}: {}", truth.describe(&picture, at)));
                let place = format!("{method} on @{name} from `{}`", camera.name);
                assert_eq!(verdict.different.len(), 0, "{place}: {why:?}");
            }
            looked_at[0] += verdict.compared;
            looked_at[1] += verdict.stacked;
            looked_at[2] = looked_at[2].max(verdict.deepest);
        }
    }
    looked_at
}

/// The scenes with a relevant amount of glass.
fn with_glass() -> impl Iterator<Item = &'static Subject> {
    let names: Vec<&str> = (SCENES.iter())
        .filter(|named| named.is(Group::Glass) || named.name == "enfilade")
        .map(|named| named.name)
        .collect();
    subjects()
        .iter()
        .filter(move |subject| names.contains(&subject.name))
}

#[test]
fn glass_is_painted_over_what_is_behind_it_and_under_what_is_before_it() {
    for subject in with_glass() {
        let size = if subject.name == "enfilade" {
            [160, 90]
        } else {
            SIZE
        };
        let [compared, stacked, deepest] = glass_is_painted_in_order(subject, size);
        match subject.name {
            "bottles" => assert!(compared > 10_000 && stacked > 5_000 && deepest >= 8, "{deepest}"),
            "glass" => assert!(compared > 1000 && stacked > 500, "{compared} {stacked}"),
            "enfilade" => assert!(compared > 1000, "{compared}"),
            _ => {}
        }
    }
}

/// Returns pairs of items whose glass was painted directly over the other's, at any sample.
struct Over {
    passage: PassageId,
    last: BTreeMap<(u16, u16), (PassageId, ItemId)>,
    pairs: BTreeSet<[(PassageId, ItemId); 2]>,
}

impl Canvas for Over {
    fn enter(&mut self, id: PassageId, _passage: &Passage) {
        self.passage = id;
    }

    fn row(&mut self, y: u16, spans: &[Span]) {
        for span in spans {
            for x in span.x0..span.x1 {
                match span.owner {
                    Owner::Face(item, _) if span.see_through => {
                        let this = (self.passage, item);
                        let below = self.last.insert((x, y), this);
                        self.pairs.extend(below.map(|below| [below, this]));
                    }
                    _ => {
                        self.last.remove(&(x, y));
                    }
                }
            }
        }
    }
}

#[test]
fn an_engine_that_blends_items_is_told_their_order() {
    let mut compared = 0;
    for Subject { name, built, seen } in with_glass() {
        for (camera, (method, scene)) in built
            .cameras
            .iter()
            .flat_map(|camera| seen.iter().map(move |seen| (camera, seen)))
        {
            if method.contract() == Contract::Approximate {
                continue;
            }
            let size = [96, 54];
            let mut viewer: Viewer = viewer();
            let mut over = Over {
                passage: PassageId(0),
                last: BTreeMap::new(),
                pairs: BTreeSet::new(),
            };
            let set = viewer.draw(scene, &camera.view(size), &mut over);
            let order = set.blend_order(scene);
            let place = |(passage, item): (PassageId, ItemId)| {
                order
                    .iter()
                    .position(|glass| (glass.passage, glass.item) == (passage, item))
            };
            for [below, above] in over.pairs {
                let [a, b] = [below, above].map(|(passage, item)| {
                    let geometry = scene.geometry(set.passage(passage).sector).expect("ours");
                    geometry.item(item).bounds
                });
                // Alpha-tested items are drawn in the opaque pass.
                let Some([below_at, above_at]) = place(below).zip(place(above)).map(<[usize; 2]>::from)
                else {
                    continue;
                };
                if below.0 == above.0 && a.meets(&b) {
                    continue;
                }
                compared += 1;
                assert!(
                    below_at < above_at,
                    "{method} on @{name} from `{}`: {above:?} is painted before {below:?}",
                    camera.name
                );
            }
        }
    }
    assert!(compared > 200, "{compared}");
}
