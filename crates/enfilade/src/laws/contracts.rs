//! Tests every method against its contract, view by view.

use super::owners::OwnerPicture;
use super::reference::Reference;
use super::truth::Verdict;
use crate::method::Method;
use crate::scene::Scene;
use crate::sector::Contract;
use crate::view::View;
use crate::viewer::{Limits, Viewer};
use std::fmt;

/// A scene as every method sees it that suits it, each with a viewer that remembers its last view.
pub struct Contestants {
    reference: Reference,
    scene: Scene,
    limits: Limits,
    all: Vec<(Method, Scene, Viewer)>,
}

/// What a method did against its contract in one view.
#[derive(Clone, Debug)]
pub struct Broken {
    /// By which method.
    pub method: Method,
    /// How its answer compares with the reference.
    pub verdict: Verdict,
    /// A sample that is wrong, and what may be there, as text; empty where only the set is.
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
            "{method}: missed {missed:?}, {pixels_different} wrong pixels, {extra} too many"
        )?;
        if !self.sample.is_empty() {
            write!(f, "; {}", self.sample)?;
        }
        Ok(())
    }
}

/// Places in each pixel at which strict methods are tested.
const PLACES: u32 = 4;

impl Contestants {
    /// Builds the reference, and every method that suits the scene and takes no more than `limit_bytes` in each sector;
    /// approximate ones are left out.
    pub fn new(scene: &Scene, limits: Limits, limit_bytes: u64) -> Contestants {
        let promises = |method: &Method| method.contract() != Contract::Approximate && scene.suits(*method);
        let all = Method::ALL.into_iter().filter(promises).filter_map(|method| {
            let scene = scene.with_method(method, limit_bytes).ok()?;
            let mut viewer = Viewer::new();
            viewer.set_limits(limits);
            Some((method, scene, viewer))
        });
        Contestants {
            reference: Reference::new(scene),
            scene: scene.clone(),
            limits,
            all: all.collect(),
        }
    }

    /// The methods that take part.
    pub fn methods(&self) -> impl Iterator<Item = Method> + '_ {
        self.all.iter().map(|(method, ..)| *method)
    }

    /// Draws a view by every method. Returns the number of items that are certainly visible, and what methods did wrong.
    pub fn check(&mut self, view: &View) -> (usize, Vec<Broken>) {
        let truth = self.reference.see(&self.scene, view, &self.limits);
        let anywhere = self
            .reference
            .see_anywhere(&self.scene, view, &self.limits, PLACES, 1);
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
                    let sample = "between samples".to_owned();
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
