//! Finds a line of sight between two cells.

use crate::aim::aimed;
use crate::bits::{ones, put, take};
use crate::flow::Flow;
use crate::line::Witness;
use crate::work::{PairsWork, Stage};

/// Maximum number of portal chains to try between two cells.
const CHAINS: usize = 200;

impl PairsWork {
    /// Returns a line of sight between two different cells, both below the number of cells. Returns `None` if no line
    /// is found, though one may exist, and before [`Stage::Fixpoint`].
    pub fn line_between(&self, from: u32, to: u32) -> Option<Witness> {
        if self.stage() < Stage::Fixpoint {
            return None;
        }
        // Visibility is symmetric, but chains start at one end and may find a line only from there.
        self.line_from(from, to).or_else(|| {
            let Witness {
                origin,
                direction,
                mut cells,
            } = self.line_from(to, from)?;
            cells.reverse();
            Some(Witness {
                origin,
                direction: direction.map(|along| -along),
                cells,
            })
        })
    }

    fn line_from(&self, from: u32, to: u32) -> Option<Witness> {
        let ways = &self.ways;
        let mut flow = Flow::default();
        let mut chains = 0;
        let mut witness = None;
        for way in ways.out_of(from) {
            let first = &ways.all[way];
            if first.to == to {
                // Neighbours: straight through the shared portal.
                return Some(Witness {
                    origin: first.centre.into(),
                    direction: first.plane.normal.into(),
                    cells: vec![from, to],
                });
            }
            let mut undecided = vec![0; self.progress.bound.words_in_row()];
            ones(self.progress.bound.row(way))
                .filter(|&then| ways.all[then].to == to)
                .for_each(|then| put(&mut undecided, then));
            flow.run(
                ways,
                &self.progress.bound,
                &self.passages,
                way,
                &mut undecided,
                |undecided, reached| {
                    chains += 1;
                    let line = aimed(ways, way, reached);
                    let line = line.filter(|(_, line)| line.contains(&(reached.way as u32)));
                    if let Some(([start, end], line)) = line {
                        let mut cells: Vec<u32> = line
                            .iter()
                            .skip_while(|&&taken| taken as usize != way)
                            .map(|&taken| ways.all[taken as usize].from)
                            .collect();
                        cells.truncate(cells.iter().position(|&cell| cell == to).unwrap_or(cells.len()));
                        cells.push(to);
                        witness = Some(Witness {
                            origin: start.into(),
                            direction: (end - start).normalize().into(),
                            cells,
                        });
                    }
                    if witness.is_some() || chains >= CHAINS {
                        undecided.fill(0);
                    } else if !reached.first {
                        take(undecided, reached.way);
                    }
                },
            );
            if witness.is_some() || chains >= CHAINS {
                break;
            }
        }
        witness
    }
}
