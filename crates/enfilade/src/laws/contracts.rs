//! Tests every method against its contract, view by view.

use super::owners::OwnerPicture;
use super::reference::Reference;
use super::truth::Verdict;
use crate::method::Method;
use crate::options::Limits;
use crate::scene::Scene;
use crate::sector::Contract;
use crate::view::View;
use crate::viewer::Viewer;
use std::fmt;

/// A scene built once for each suitable method, each with its own viewer, which keeps its state between views (temporal
/// coherence).
pub struct Contestants {
    reference: Reference,
    scene: Scene,
    limits: Limits,
    all: Vec<(Method, Scene, Viewer)>,
}

/// A violation of a method's contract in one view.
#[derive(Clone, Debug)]
pub struct Broken {
    /// The method.
    pub method: Method,
    /// Comparison of its answer with the reference.
    pub verdict: Verdict,
    /// A wrong sample and its possible owners, as text; empty if only the visible set is wrong.
    pub sample: String,
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Verdict {
            missed,
            pixels_different,
            extra,
            ..
        } = &self.verdict;
        let method = self.method;
        write!(
            f,
            "{method}: missed {missed:?}, {pixels_different} wrong pixels, {extra} extra"
        )?;
        if !self.sample.is_empty() {
            write!(f, "; {}", self.sample)?;
        }
        Ok(())
    }
}

/// Number of random positions per pixel at which strict methods are tested.
const POSITIONS: u32 = 4;

impl Contestants {
    /// Builds the reference, and the scene for every method that suits it, at most `limit_bytes` per sector.
    /// Approximate methods are left out.
    pub fn new(scene: &Scene, limits: Limits, limit_bytes: u64) -> Contestants {
        let promises = |method: &Method| method.contract() != Contract::Approximate && scene.suits(*method);
        let all = Method::ALL.into_iter().filter(promises).filter_map(|method| {
            let scene = scene.with_method(method, limit_bytes).ok()?;
            let mut viewer = Viewer::new();
            viewer.options.limits = limits;
            Some((method, scene, viewer))
        });
        Contestants {
            reference: Reference::new(scene),
            scene: scene.clone(),
            limits,
            all: all.collect(),
        }
    }

    /// Returns the methods under test.
    pub fn methods(&self) -> impl Iterator<Item = Method> + '_ {
        self.all.iter().map(|(method, ..)| *method)
    }

    /// Draws a view with every method. Returns the number of certainly visible items and all contract violations.
    pub fn check(&mut self, view: &View) -> (usize, Vec<Broken>) {
        let truth = self.reference.see(&self.scene, view, &self.limits);
        let anywhere = self
            .reference
            .see_anywhere(&self.scene, view, &self.limits, POSITIONS, 1);
        let mut broken = Vec::new();
        for (method, scene, viewer) in &mut self.all {
            let (method, contract) = (*method, method.contract());
            let mut picture = OwnerPicture::new(view.size);
            let set = viewer.draw(scene, view, &mut picture);
            let verdict = truth.check(set, Some(&picture));
            let wrong = truth.different(&picture).next();
            if !verdict.missed.is_empty()
                || wrong.is_some()
                || contract == Contract::Exact && verdict.extra > 0
            {
                let sample =
                    wrong.map(|at| format!("{at:?} is {}, not {}", picture.describe(at), truth.describe(at)));
                broken.push(Broken {
                    method,
                    verdict,
                    sample: sample.unwrap_or_default(),
                });
            }
            if contract == Contract::Strict {
                let verdict = anywhere.check(viewer.look(scene, view), None);
                if !verdict.missed.is_empty() {
                    let sample = "false cull at a random position between samples".to_owned();
                    broken.push(Broken {
                        method,
                        verdict,
                        sample,
                    });
                }
            }
        }
        (truth.visible().len(), broken)
    }
}
