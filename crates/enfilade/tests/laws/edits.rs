//! Every law holds of scenes that are edited between looks, with viewers that remember what is no more.

use crate::subject::{SIZE, Subject, drawn, limits, names, subject, subjects, viewer};
use enfilade::laws::Reference;
use enfilade::{
    Content, ContentBuilder, Contract, FragmentId, ItemId, Mesh, Method, Scene, Transform, Viewer,
};
use std::sync::Arc;

/// Numbers by chance, the same every time.
struct Chance(u64);

impl Chance {
    fn below(&mut self, count: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % count.max(1)
    }

    fn unit(&mut self) -> f32 {
        self.below(1 << 20) as f32 / (1 << 20) as f32
    }
}

/// Where something may be moved to: near, anywhere in the fragment or a little outside, turned, mirrored, flattened.
fn elsewhere(scene: &Scene, fragment: FragmentId, item: ItemId, chance: &mut Chance) -> Transform {
    let content = scene.content(fragment).expect("ours");
    let held = scene.bounds(fragment);
    let size = held.size();
    let place = content.item(item).transform();
    let step = match chance.below(3) {
        0 => size.map(|side| (chance.unit() - 0.5) * 0.02 * side),
        _ => {
            let middle = content.item(item).bounds.center();
            [0, 1, 2].map(|axis| held.min[axis] + (1.2 * chance.unit() - 0.1) * size[axis] - middle[axis])
        }
    };
    let turn = match chance.below(12) {
        0 => Transform::rotation([1.0, 2.0, 3.0], f64::from(chance.unit()) * 6.0),
        1 => Transform::from_columns([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]]),
        2 => Transform::from_columns([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]]),
        _ => Transform::IDENTITY,
    };
    // Turned where it stands.
    let middle = content.item(item).bounds.center();
    let there = [0, 1, 2].map(|axis| middle[axis] + step[axis]);
    let back = middle.map(|value| -value);
    Transform::translation(there) * turn * Transform::translation(back) * place
}

/// So many edits by chance, done at once. As many items as there were at first are aimed at.
fn edit(scene: &mut Scene, count: usize, at_first: &[usize], chance: &mut Chance) -> usize {
    let fragments: Vec<FragmentId> = scene
        .fragments()
        .filter(|&id| {
            scene
                .content(id)
                .is_some_and(|content| !content.items().is_empty())
        })
        .collect();
    let before = scene.clone();
    let mut edit = scene.edit();
    let mut done = 0;
    for _ in 0..count {
        let fragment = fragments[chance.below(fragments.len())];
        let content = before.content(fragment).expect("ours");
        let item = ItemId(chance.below(content.items().len()) as u32);
        let mesh: Arc<Mesh> = Arc::clone(&content.meshes()[content.item(item).mesh.0 as usize]);
        let crowded = content.item_count() > at_first[fragment.0 as usize];
        let asked = match chance.below(10) {
            0 if crowded => edit.remove(fragment, item),
            0 | 1 if content.holds(item) => {
                let there = elsewhere(&before, fragment, item, chance);
                edit.add(fragment, content.name(item), mesh, there).map(|_| ())
            }
            2 => edit.remove(fragment, item),
            3 => {
                let other = ItemId(chance.below(content.items().len()) as u32);
                let mesh = Arc::clone(&content.meshes()[content.item(other).mesh.0 as usize]);
                edit.set_mesh(fragment, item, mesh)
            }
            4 => edit.set_hides(fragment, item, chance.below(3) > 0),
            _ if content.holds(item) => {
                edit.place(fragment, item, elsewhere(&before, fragment, item, chance))
            }
            _ => continue,
        };
        done += usize::from(asked.is_ok());
    }
    edit.finish().expect("the scenes of the laws are small");
    done
}

/// The same content, built of nothing: without what was removed.
fn afresh(content: &Content) -> Content {
    let mut builder = ContentBuilder::new(content.materials());
    for number in (0..content.items().len() as u32).map(ItemId) {
        if content.holds(number) {
            let item = content.item(number);
            let mesh = builder.mesh(Arc::clone(&content.meshes()[item.mesh.0 as usize]));
            let built = builder.item(content.name(number), mesh, item.transform());
            if !item.hides {
                builder.never_hides(built);
            }
        }
    }
    for opening in content.openings() {
        builder.opening(&opening.name, opening.outline.clone());
    }
    builder.build().expect("as sound as it was")
}

/// Edits a scene round after round, as each method sees it, and holds every look to the method's contract, and to that at
/// the same scene built afresh. Gives the number of edits, and of items that the reference sees for certain.
fn laws_hold_under_edits(subject: &Subject, methods: &[Method], rounds: u64, count: usize) -> [usize; 2] {
    let mut scenes: Vec<(Method, Scene, Viewer)> = methods
        .iter()
        .map(|&method| (method, subject.seen_by(method).clone(), viewer()))
        .collect();
    let at_first: Vec<usize> = (subject.built.scene.fragments())
        .map(|id| {
            subject
                .built
                .scene
                .content(id)
                .map_or(0, |content| content.item_count())
        })
        .collect();
    let (mut edits, mut looked_at) = (0, 0);
    for round in 0..rounds {
        for (_, scene, _) in &mut scenes {
            edits += edit(scene, count, &at_first, &mut Chance(1000 * round + 17));
        }
        let edited = &scenes[0].1;
        let mut fresh = edited.clone();
        for id in edited.fragments() {
            let content = afresh(edited.content(id).expect("ours"));
            fresh.set_content(id, content).expect("the same openings");
        }
        let camera = &subject.built.cameras[round as usize % subject.built.cameras.len()];
        let mut view = camera.view(SIZE);
        view.fragment = edited.fragment_of(&subject.built.cameras[0].view(SIZE));
        let truth = Reference::new(edited).see(edited, &view, &limits());
        let anywhere = Reference::new(edited).see_anywhere(edited, &view, &limits(), 2, round);
        looked_at += truth.visible().len();
        for (method, scene, viewer) in &mut scenes {
            let place = format!("{method} on @{} in round {round}", subject.name);
            viewer.look(scene, &view);
            let looked = names(scene, viewer.visible());
            let mut forgetful = crate::subject::viewer();
            forgetful.look(scene, &view);
            assert_eq!(
                looked,
                names(scene, forgetful.visible()),
                "{place}: remembered what is no more"
            );
            let picture = drawn(viewer, scene, &view);
            assert_eq!(looked, names(scene, viewer.visible()), "{place}: drawn");
            let verdict = truth.check(viewer.visible(), Some(&picture));
            for budget in [0, 1, 100_000] {
                forgetful.set_occluders(Some(budget));
                let verdict = truth.check(forgetful.look(scene, &view), None);
                if method.contract() > Contract::Approximate {
                    assert_eq!(verdict.missed, [], "{place} with {budget} occluders");
                }
            }
            let first = truth.different(&picture).next();
            let why =
                first.map(|at| format!("{at:?} is {:?}, not {}", picture.owner(at), truth.describe(at)));
            if method.contract() > Contract::Approximate {
                assert_eq!(verdict.pixels_different, 0, "{place}: {why:?}");
                assert_eq!(verdict.missed, [], "{place}");
            }
            if method.contract() == Contract::Strict {
                let verdict = anywhere.check(viewer.visible(), None);
                assert_eq!(verdict.missed, [], "{place}, anywhere in a pixel");
            }
            if method.contract() == Contract::Exact {
                assert_eq!(verdict.extra, 0, "{place}");
                let fresh = fresh.with_method(*method, u64::MAX).expect("small");
                let mut viewer = crate::subject::viewer();
                viewer.look(&fresh, &view);
                assert_eq!(looked, names(&fresh, viewer.visible()), "{place}: built afresh");
                // Of the same focal length: all samples of this screen are among those of the wide one.
                let mut wide = view;
                wide.size[0] *= 3;
                viewer.look(scene, &wide);
                let wide = names(scene, viewer.visible());
                assert!(looked.is_subset(&wide), "{place}: less in a wider aperture");
            }
        }
    }
    [edits, looked_at]
}

#[test]
fn every_law_holds_after_a_thousand_edits_between_looks() {
    let small = |subject: &&Subject| subject.name != "enfilade";
    for subject in subjects().iter().filter(small) {
        let [edits, looked_at] = laws_hold_under_edits(subject, &Method::ALL, 3, 1000);
        assert!(edits > 3 * 11 * 300, "@{}: only {edits} edits", subject.name);
        assert!(looked_at > 0, "@{}: nothing is seen", subject.name);
    }
}

#[test]
fn a_few_edits_between_looks_do_no_harm_either() {
    for name in ["mirrors", "teleport", "glass"] {
        let subject = subject(name);
        let [_, looked_at] = laws_hold_under_edits(subject, &Method::ALL, 30, 3);
        assert!(looked_at > 30, "@{name}");
    }
}

#[test]
fn the_palace_may_be_turned_upside_down() {
    let methods = [
        Method::ZBuffer,
        Method::HierarchicalZ,
        Method::HierarchicalS,
        Method::Masked,
        Method::Svbsp,
        Method::Mobsp,
    ];
    let [_, looked_at] = laws_hold_under_edits(subject("enfilade"), &methods, 3, 1000);
    assert!(looked_at > 100);
}
