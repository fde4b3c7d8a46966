//! A line of sight between two cells.

use crate::aim::aimed;
use crate::bits::{ones, put, take};
use crate::flow::Flow;
use crate::line::Witness;
use crate::work::{PairsWork, Stage};

/// Chains that are tried between two cells.
const CHAINS: usize = 200;

impl PairsWork {
    /// A line that one cell sees the other by, both below the number of cells and not the same. `None` where none is found,
    /// though there may be one; and before [`Stage::Fixpoint`].
    pub fn line_between(&self, from: u32, to: u32) -> Option<Witness> {
        if self.stage() < Stage::Fixpoint {
            return None;
        }
        // Sight has no direction, but chains are followed from one end.
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
                // Cells next to each other: straight through what they share.
                return Some(Witness {
                    origin: first.centre.into(),
                    direction: first.plane.normal.into(),
                    cells: vec![from, to],
                });
            }
            let mut asked = vec![0; self.bound.words_in_row()];
            ones(self.bound.row(way))
                .filter(|&then| ways.all[then].to == to)
                .for_each(|then| put(&mut asked, then));
            flow.run(
                ways,
                &self.bound,
                &self.passages,
                way,
                &mut asked,
                |asked, reached| {
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
                        asked.fill(0);
                    } else if !reached.first {
                        take(asked, reached.way);
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
