//! Measures both renderers in turn.

use crate::clock::{Clock, Times, timed};
use crate::differ::{differing, save};
use crate::ours::{EnfiladeRenderer, Picture};
use crate::peer::{Cost, Peer};
use crate::place::SurveyedScene;
use crate::serve::DrawSet;
use anyhow::Result;
use enfilade::{Method, Scene, Viewer};
use std::path::Path;

/// A renderer with its configuration.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Renderer {
    Enfilade(Method),
    Driver(DrawSet),
}

/// Times of one renderer.
pub(crate) struct Timing {
    pub(crate) who: Renderer,
    pub(crate) cores: usize,
    /// For each view, the median over the rounds, by each clock.
    pub(crate) views: Vec<Times>,
}

impl Timing {
    /// Returns the milliseconds for each view.
    pub(crate) fn by(&self, clock: Clock) -> Vec<f64> {
        self.views.iter().map(|times| times[clock.number()]).collect()
    }

    /// Returns the median over the views.
    pub(crate) fn median(&self, clock: Clock) -> f64 {
        median(self.by(clock))
    }
}

/// Statistics of the pictures of one draw set.
pub(crate) struct DrawStats {
    pub(crate) draw_set: DrawSet,
    /// Median over the views.
    pub(crate) triangles: f64,
    pub(crate) draws: f64,
    /// Part of pixels that differ noticeably from Enfilade's: over all views, and the maximum of one view.
    pub(crate) differing: [f64; 2],
}

/// Draws all views once with both renderers and compares them; writes the pictures if a path prefix is given.
pub(crate) fn compare(
    place: &SurveyedScene,
    (ours, scene): (&EnfiladeRenderer, &Scene),
    peer: &mut Peer,
    pictures: Option<&Path>,
) -> Result<Vec<DrawStats>> {
    let mut viewer = Viewer::new();
    let ours: Vec<Picture> = place
        .views
        .iter()
        .map(|view| ours.picture(&mut viewer, scene, view))
        .collect();
    let size = place.views[0].size();
    let file = |view: usize, whose: &str| {
        pictures.map(|start| start.with_added_extension(format!("{view:02}.{whose}.png")))
    };
    let mut drawn = Vec::new();
    for draw_set in DrawSet::ALL {
        let mut costs: Vec<Cost> = Vec::new();
        let mut parts = Vec::new();
        for (view, ours) in ours.iter().enumerate() {
            costs.push(peer.draw(draw_set, view)?);
            let theirs = peer.picture(size)?;
            parts.push(differing(ours, &theirs));
            for (whose, picture) in [("ours", ours), (draw_set.name(), &theirs)] {
                if let Some(file) = file(view, whose) {
                    save(picture, size, &file)?;
                }
            }
        }
        drawn.push(DrawStats {
            draw_set,
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

/// Measures all renderers. They take turns at every view, so that other load on the machine affects all equally: one
/// warm-up round, then `rounds`.
pub(crate) fn time(
    place: &SurveyedScene,
    ours: &[EnfiladeRenderer],
    scenes: &[(Method, Scene)],
    peers: &mut [Peer],
    rounds: usize,
) -> Result<Vec<Timing>> {
    let mut viewers: Vec<Viewer> = scenes.iter().map(|_| Viewer::new()).collect();
    let turns = ours.len() * scenes.len() + peers.len() * DrawSet::ALL.len();
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
                for draw_set in DrawSet::ALL {
                    taken.push(peer.draw(draw_set, number)?.times);
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
        .flat_map(|(method, _)| ours.iter().map(|ours| (Renderer::Enfilade(*method), ours.cores)));
    let theirs = peers
        .iter()
        .flat_map(|peer| DrawSet::ALL.map(|draw_set| (Renderer::Driver(draw_set), peer.cores)));
    Ok(ours
        .chain(theirs)
        .zip(times)
        .map(|((who, cores), views)| Timing {
            who,
            cores,
            views: views.iter().map(medians).collect(),
        })
        .collect())
}

/// Returns the median of the rounds by each clock.
fn medians(rounds: &Vec<Times>) -> Times {
    Clock::ALL.map(|clock| median(rounds.iter().map(|times| times[clock.number()]).collect()))
}

/// Returns the median; NaN if empty.
fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    values.sort_by(f64::total_cmp);
    0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
}
