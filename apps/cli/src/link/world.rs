//! Parses a WORLD.toml, and checks it as far as possible without its files.

use crate::values::among;
use anyhow::{Result, anyhow, bail};
use enfilade_import::{Placing, Shape};
use serde::Deserialize;
use std::collections::HashSet;
use std::path::PathBuf;

/// A whole WORLD.toml.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct World {
    #[serde(rename = "part", default)]
    pub(super) parts: Vec<Part>,
    #[serde(rename = "portal", default)]
    pub(super) portals: Vec<Portal>,
}

/// `[[part]]`: a file and its transform.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Part {
    pub(super) name: String,
    /// Relative to the folder of the WORLD.toml.
    pub(super) file: PathBuf,
    translation: Option<[f64; 3]>,
    rotation: Option<Rotation>,
    scale: Option<f64>,
}

/// A rotation about an axis, counter-clockwise when the axis points at the viewer.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Rotation {
    axis: [f64; 3],
    degrees: f64,
}

/// `[[portal]]`: a portal out of a part.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Portal {
    pub(super) name: String,
    pub(super) from: EndSpec,
    pub(super) to: Option<EndSpec>,
    #[serde(default)]
    pub(super) mirror: bool,
    two_way: Option<bool>,
}

/// One end of a portal: a position in a part, or the part alone.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EndSpec {
    pub(super) part: String,
    pub(super) room: Option<String>,
    pub(super) node: Option<String>,
    center: Option<[f64; 3]>,
    ahead: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    size: Option<[f64; 2]>,
    outline: Option<Vec<[f64; 3]>>,
}

/// How the position of a portal end is specified.
pub(super) enum EndPosition {
    /// Not specified: anywhere in the part.
    Unspecified,
    Node(String),
    Shape(Shape),
}

impl World {
    /// Parses the text. Names of parts and of portals must be unique.
    pub(super) fn parse(text: &str) -> Result<World> {
        let world: World =
            toml::from_str(text).map_err(|error| anyhow!("{}", error.to_string().trim_end()))?;
        if world.parts.is_empty() {
            bail!("it has no [[part]]; add one with a name and a file");
        }
        for (kind, names) in [
            (
                "part",
                world.parts.iter().map(|part| &part.name).collect::<Vec<_>>(),
            ),
            (
                "portal",
                world.portals.iter().map(|portal| &portal.name).collect(),
            ),
        ] {
            let mut known = HashSet::new();
            if let Some(name) = names.into_iter().find(|name| !known.insert(*name)) {
                bail!("two [[{kind}]] are named {name:?}; rename one");
            }
        }
        Ok(world)
    }

    /// Returns the index of a part, by its name.
    pub(super) fn part(&self, name: &str) -> Result<usize> {
        let names = || self.parts.iter().map(|part| part.name.as_str());
        let found = names().position(|part| part == name);
        found.ok_or_else(|| anyhow!("no part {name:?}; {}", among(name, names())))
    }
}

impl Part {
    pub(super) fn placing(&self) -> Result<Placing> {
        let mut placing = Placing::default();
        placing.translation = self.translation.unwrap_or(placing.translation);
        placing.scale = self.scale.unwrap_or(placing.scale);
        if let Some(Rotation { axis, degrees }) = &self.rotation {
            let length = axis.iter().map(|part| part * part).sum::<f64>().sqrt();
            if !(length > 0.0 && length.is_finite()) {
                bail!("rotation: the axis must not be 0; for the vertical use [0, 1, 0]");
            }
            let half = degrees.to_radians() / 2.0;
            let [x, y, z] = axis.map(|part| part / length * half.sin());
            placing.rotation = [x, y, z, half.cos()];
        }
        Ok(placing)
    }
}

impl Portal {
    /// Whether it leads elsewhere than to the room behind it.
    pub(super) fn is_teleport(&self) -> bool {
        self.to.as_ref().is_some_and(EndSpec::has_position)
    }

    /// Whether it is two-way. By default doors are, teleports are not.
    pub(super) fn two_way(&self) -> bool {
        self.two_way.unwrap_or(!self.is_teleport())
    }

    /// Fails if keys contradict each other.
    pub(super) fn check(&self) -> Result<()> {
        if self.mirror && (self.to.is_some() || self.two_way.is_some()) {
            bail!("a mirror leads back; remove `to` and `two_way`, or `mirror`");
        }
        if self.from.room.is_some() {
            bail!("from: the room of an opening is found from its position; remove `room`");
        }
        if self.name.is_empty() || self.name.contains('/') {
            bail!("it needs a name without a /");
        }
        Ok(())
    }
}

impl EndSpec {
    fn has_position(&self) -> bool {
        self.node.is_some() || self.center.is_some() || self.outline.is_some()
    }

    /// Returns the position. An opening given as a rectangle needs a size.
    pub(super) fn position(&self, is_opening: bool) -> Result<EndPosition> {
        let EndSpec {
            node,
            center,
            ahead,
            up,
            size,
            outline,
            ..
        } = self;
        let given = [node.is_some(), center.is_some(), outline.is_some()];
        if given.iter().filter(|given| **given).count() > 1 {
            bail!("its position is given twice; keep one of `node`, `center` and `outline`");
        }
        if center.is_none() && (ahead.is_some() || up.is_some() || size.is_some()) {
            bail!("`ahead`, `up` and `size` belong to a rectangle; give its `center` too");
        }
        Ok(match (node, center, outline) {
            (Some(node), ..) => EndPosition::Node(node.clone()),
            (_, Some(center), _) => {
                if is_opening && size.is_none() {
                    bail!("an opening needs a `size`, width and height, such as [1, 2]");
                }
                EndPosition::Shape(Shape::Rectangle {
                    center: *center,
                    ahead: ahead
                        .ok_or_else(|| anyhow!("it needs `ahead`, a direction such as [0, 0, -1]"))?,
                    up: *up,
                    size: *size,
                })
            }
            (.., Some(outline)) => EndPosition::Shape(Shape::Outline(outline.clone())),
            _ if is_opening => {
                bail!("it needs a `node`, a `center` with `ahead` and `size`, or an `outline`")
            }
            _ => EndPosition::Unspecified,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wrong_in_it_is_told_with_its_line() {
        let error = |text: &str| {
            World::parse(text)
                .err()
                .map(|error| error.to_string())
                .unwrap_or_default()
        };
        assert!(error("").contains("no [[part]]"));
        assert!(error("[[part]]\nname = 'a'\nfil = 'a.glb'").contains("line 3"));
        assert!(error("[[part]]\nname = 'a'\nfile = 'a.glb'\nscale = 'big'").contains("line 4"));
        let twice = "[[part]]\nname = 'a'\nfile = 'a.glb'\n".repeat(2);
        assert!(error(&twice).contains("rename one"));
    }
}
