//! Transparency: visible sets report how to blend.

use crate::subject::{Subject, subjects, viewer};
use enfilade::{Canvas, Contract, ItemIndex, Owner, Passage, PassageId, Span, Viewer};
use enfilade_scenes::{Group, SCENES};
use std::collections::{BTreeMap, BTreeSet};

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

/// Returns pairs of items whose glass was painted directly over the other's, at any sample.
struct Over {
    passage: PassageId,
    last: BTreeMap<(u16, u16), (PassageId, ItemIndex)>,
    pairs: BTreeSet<[(PassageId, ItemIndex); 2]>,
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
            let set = viewer.draw(scene, &camera.view(size).expect("a valid view"), &mut over);
            let order = set.blend_order(scene);
            let place = |(passage, item): (PassageId, ItemIndex)| {
                order
                    .iter()
                    .position(|glass| (glass.passage, glass.item) == (passage, item.into()))
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
