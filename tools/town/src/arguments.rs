//! The command line.

use crate::tile::LIMITS;
use anyhow::{Context, Result, bail, ensure};
use std::path::PathBuf;

pub(crate) const USE: &str =
    "use: town OUT_FOLDER --tiles 8x8 --triangles-per-tile 800000 [--seed 1] [--only X,Y]";

/// The most tiles along a side: beyond, f32 could not hold positions in the whole town exactly.
const MAX_TILES: u32 = 64;

#[derive(Debug)]
pub(crate) struct Arguments {
    pub(crate) folder: PathBuf,
    pub(crate) tiles: [u32; 2],
    pub(crate) triangles: u64,
    pub(crate) seed: u64,
    pub(crate) only: Option<[u32; 2]>,
}

impl Arguments {
    pub(crate) fn parse(arguments: &[String]) -> Result<Arguments> {
        let [mut folder, mut tiles, mut triangles, mut seed, mut only] = [const { None::<&str> }; 5];
        let mut rest = arguments.iter().map(String::as_str);
        while let Some(argument) = rest.next() {
            let value = match argument {
                "--tiles" => &mut tiles,
                "--triangles-per-tile" => &mut triangles,
                "--seed" => &mut seed,
                "--only" => &mut only,
                _ if argument.starts_with('-') => bail!("unknown option {argument}\n{USE}"),
                _ => {
                    ensure!(folder.is_none(), "a second folder, {argument}: name one\n{USE}");
                    folder = Some(argument);
                    continue;
                }
            };
            ensure!(value.is_none(), "{argument} is given twice: give it once");
            let given = rest.next();
            *value = Some(given.with_context(|| format!("{argument} needs a value\n{USE}"))?);
        }
        let folder = folder.with_context(|| format!("no folder for the tiles\n{USE}"))?;
        let tiles = tiles.with_context(|| format!("no --tiles, such as --tiles 8x8\n{USE}"))?;
        let tiles = pair(tiles, 'x')
            .with_context(|| format!("--tiles {tiles}: write columns x rows, such as 8x8"))?;
        ensure!(
            tiles.iter().all(|count| (1..=MAX_TILES).contains(count)),
            "--tiles {}x{}: a side has 1 to {MAX_TILES} tiles",
            tiles[0],
            tiles[1]
        );
        let text = triangles.unwrap_or("800000");
        let triangles = text
            .parse()
            .with_context(|| format!("--triangles-per-tile {text}: write a whole number, such as 800000"))?;
        let [min, max] = LIMITS;
        ensure!(
            (min..=max).contains(&triangles),
            "--triangles-per-tile {triangles}: a tile has {min} to {max}; for more or fewer in all, change --tiles"
        );
        let text = seed.unwrap_or("1");
        let seed = text
            .parse()
            .with_context(|| format!("--seed {text}: write a whole number, such as 1"))?;
        let only = match only {
            None => None,
            Some(text) => {
                let at = pair(text, ',')
                    .with_context(|| format!("--only {text}: write a position, such as 3,4"))?;
                ensure!(
                    at[0] < tiles[0] && at[1] < tiles[1],
                    "--only {text}: positions are from 0,0 to {},{}",
                    tiles[0] - 1,
                    tiles[1] - 1
                );
                Some(at)
            }
        };
        Ok(Arguments {
            folder: folder.into(),
            tiles,
            triangles,
            seed,
            only,
        })
    }

    /// Returns the positions of the tiles to write, row by row.
    pub(crate) fn positions(&self) -> Vec<[u32; 2]> {
        let [columns, rows] = self.tiles;
        let all = (0..rows).flat_map(|y| (0..columns).map(move |x| [x, y]));
        all.filter(|at| self.only.is_none_or(|only| only == *at))
            .collect()
    }
}

/// Parses two numbers with a separator between them.
fn pair(text: &str, separator: char) -> Option<[u32; 2]> {
    let (first, second) = text.split_once(separator)?;
    Some([first.parse().ok()?, second.parse().ok()?])
}

#[cfg(test)]
mod tests {
    use super::Arguments;

    fn parse(line: &str) -> Result<Arguments, String> {
        let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        Arguments::parse(&words).map_err(|error| error.to_string())
    }

    #[test]
    fn arguments_may_be_in_any_order() {
        let parsed = parse("--seed 7 --tiles 3x2 out --only 2,1").expect("valid");
        assert_eq!(
            (parsed.tiles, parsed.seed, parsed.triangles),
            ([3, 2], 7, 800_000)
        );
        assert_eq!(parsed.positions(), [[2, 1]]);
        assert_eq!(
            parse("out --tiles 2x1").expect("valid").positions(),
            [[0, 0], [1, 0]]
        );
    }

    #[test]
    fn errors_name_the_argument_and_the_remedy() {
        for (line, said) in [
            ("", "no folder"),
            ("out", "no --tiles"),
            ("out --tiles 8", "write columns x rows"),
            ("out --tiles 0x8", "1 to 64 tiles"),
            ("out --tiles 8x8 --triangles-per-tile 5", "a tile has 450000 to"),
            (
                "out --tiles 8x8 --triangles-per-tile many",
                "write a whole number",
            ),
            ("out --tiles 8x8 --seed", "needs a value"),
            ("out --tiles 8x8 --seed 1 --seed 2", "given twice"),
            ("out --tiles 8x8 --only 8,0", "from 0,0 to 7,7"),
            ("out --tiles 8x8 --fast", "unknown option"),
            ("out --tiles 8x8 there", "a second folder"),
        ] {
            let error = parse(line).expect_err(line);
            assert!(error.contains(said), "{line}: {error}");
        }
    }
}
