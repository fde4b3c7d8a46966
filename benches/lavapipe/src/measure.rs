//! Both sides, in turn.

use crate::clock::{Clock, Times, timed};
use crate::differ::{differing, save};
use crate::ours::{Ours, Picture};
use crate::peer::{Cost, Peer};
use crate::place::Place;
use crate::serve::What;
use anyhow::Result;
use enfilade::{Method, Scene, Viewer};
use std::path::Path;

/// Who draws.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Who {
    Ours(Method),
    Driver(What),
}

/// What one of them took.
pub(crate) struct Taken {
    pub(crate) who: Who,
    pub(crate) cores: usize,
    /// For each view: the median over the rounds, by each clock.
    pub(crate) views: Vec<Times>,
}

impl Taken {
    /// Milliseconds for each view.
    pub(crate) fn by(&self, clock: Clock) -> Vec<f64> {
        self.views.iter().map(|times| times[clock.number()]).collect()
    }

    /// The median over the views.
    pub(crate) fn median(&self, clock: Clock) -> f64 {
        median(self.by(clock))
    }
}

/// What is in the pictures, for one way to choose it.
pub(crate) struct Drawn {
    pub(crate) what: What,
    /// Medians over the views.
    pub(crate) triangles: f64,
    pub(crate) draws: f64,
    /// The part of pixels that differ noticeably from ours: over all views, and the most in one.
    pub(crate) differing: [f64; 2],
}

/// Draws all views once on both sides, and compares; writes the pictures where a name to begin with is given.
pub(crate) fn compare(
    place: &Place,
    (ours, scene): (&Ours, &Scene),
    peer: &mut Peer,
    pictures: Option<&Path>,
) -> Result<Vec<Drawn>> {
    let mut viewer = Viewer::new();
    let ours: Vec<Picture> = place
        .views
        .iter()
        .map(|view| ours.picture(&mut viewer, scene, view))
        .collect();
    let size = place.views[0].size;
    let file = |view: usize, whose: &str| {
        pictures.map(|start| start.with_added_extension(format!("{view:02}.{whose}.png")))
    };
    let mut drawn = Vec::new();
    for what in What::ALL {
        let mut costs: Vec<Cost> = Vec::new();
        let mut parts = Vec::new();
        for (view, ours) in ours.iter().enumerate() {
            costs.push(peer.draw(what, view)?);
            let theirs = peer.picture(size)?;
            parts.push(differing(ours, &theirs));
            for (whose, picture) in [("ours", ours), (what.name(), &theirs)] {
                if let Some(file) = file(view, whose) {
                    save(picture, size, &file)?;
                }
            }
        }
        drawn.push(Drawn {
            what,
            triangles: median(costs.iter().map(|cost| cost.triangles as f64).collect()),
            draws: median(costs.iter().map(|cost| cost.draws as f64).collect()),
            differing: [
                parts.iter().sum::<f64>() / parts.len() as f64,
                parts.iter().copied().fold(0.0, f64::max),
            ],
        });
    }
    Ok(drawn)
}

/// Times of all sides. They take turns at every view, so that whatever else the machine does slows all alike; one round
/// to warm up, then `rounds`.
pub(crate) fn time(
    place: &Place,
    ours: &[Ours],
    scenes: &[(Method, Scene)],
    peers: &mut [Peer],
    rounds: usize,
) -> Result<Vec<Taken>> {
    let mut viewers: Vec<Viewer> = scenes.iter().map(|_| Viewer::new()).collect();
    let turns = ours.len() * scenes.len() + peers.len() * What::ALL.len();
    let mut times = vec![vec![Vec::with_capacity(rounds); place.views.len()]; turns];
    for round in 0..=rounds {
        for (number, view) in place.views.iter().enumerate() {
            let mut taken = Vec::with_capacity(turns);
            for ((_, scene), viewer) in scenes.iter().zip(&mut viewers) {
                for ours in ours {
                    taken.push(timed(|| std::hint::black_box(ours.picture(viewer, scene, view))).1);
                }
            }
            for peer in &mut *peers {
                for what in What::ALL {
                    taken.push(peer.draw(what, number)?.times);
                }
            }
            if round > 0 {
                times
                    .iter_mut()
                    .zip(taken)
                    .for_each(|(times, taken)| times[number].push(taken));
            }
        }
    }
    let ours = scenes
        .iter()
        .flat_map(|(method, _)| ours.iter().map(|ours| (Who::Ours(*method), ours.cores)));
    let theirs = peers
        .iter()
        .flat_map(|peer| What::ALL.map(|what| (Who::Driver(what), peer.cores)));
    Ok(ours
        .chain(theirs)
        .zip(times)
        .map(|((who, cores), views)| Taken {
            who,
            cores,
            views: views.iter().map(medians).collect(),
        })
        .collect())
}

/// Of what the rounds took, by each clock.
fn medians(rounds: &Vec<Times>) -> Times {
    Clock::ALL.map(|clock| median(rounds.iter().map(|times| times[clock.number()]).collect()))
}

/// The value in the middle, or between the two in the middle; NaN where there is none.
fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    values.sort_by(f64::total_cmp);
    0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
}
