//! JSON of the attributes of primitives and of their morph targets.

use serde::de::{Deserialize, Deserializer, Error, IgnoredAny, MapAccess, Visitor};
use std::borrow::Cow;
use std::fmt;

/// The use of an attribute; those with a number may come in several sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::gltf) enum Semantic {
    Position,
    Normal,
    Color,
    TextureCoordinates(u32),
    Joints(u32),
    Weights(u32),
}

/// The attributes that are read, each with its accessor, sorted.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::gltf) struct Attributes(Vec<(Semantic, u32)>);

impl Semantic {
    /// Returns the semantic of a key; `None` if it is not read.
    fn of(key: &str) -> Option<Semantic> {
        let (name, set) = match key.rsplit_once('_') {
            Some((name, set)) => (name, number(set)?),
            None => (key, 0),
        };
        match name {
            "POSITION" if key == name => Some(Semantic::Position),
            "NORMAL" if key == name => Some(Semantic::Normal),
            "COLOR" if key == "COLOR_0" => Some(Semantic::Color),
            "TEXCOORD" => Some(Semantic::TextureCoordinates(set)),
            "JOINTS" => Some(Semantic::Joints(set)),
            "WEIGHTS" => Some(Semantic::Weights(set)),
            _ => None,
        }
    }
}

/// Returns the number of a set, which has no leading zeros.
fn number(text: &str) -> Option<u32> {
    let is_plain = text == "0" || !text.starts_with(['0', '+']);
    text.parse().ok().filter(|_| is_plain)
}

impl Attributes {
    /// Returns the accessor of an attribute.
    pub(in crate::gltf) fn get(&self, semantic: Semantic) -> Option<u32> {
        let at = self.0.binary_search_by_key(&semantic, |&(semantic, _)| semantic);
        at.ok().map(|at| self.0[at].1)
    }

    /// Returns the numbers of the sets of joints, increasing.
    pub(in crate::gltf) fn joint_sets(&self) -> impl Iterator<Item = u32> {
        self.0.iter().filter_map(|&(semantic, _)| match semantic {
            Semantic::Joints(set) => Some(set),
            _ => None,
        })
    }
}

impl<'de> Deserialize<'de> for Attributes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Attributes, D::Error> {
        deserializer.deserialize_map(AttributesVisitor)
    }
}

struct AttributesVisitor;

impl<'de> Visitor<'de> for AttributesVisitor {
    type Value = Attributes;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an object of attributes")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Attributes, A::Error> {
        let mut all = Vec::new();
        while let Some(key) = map.next_key::<Cow<str>>()? {
            match Semantic::of(&key) {
                Some(semantic) => {
                    let accessor = map.next_value::<Option<u32>>()?;
                    all.extend(accessor.map(|accessor| (semantic, accessor)));
                }
                None => {
                    map.next_value::<IgnoredAny>()?;
                }
            }
        }
        all.sort_unstable();
        if let Some(pair) = all.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return Err(A::Error::custom(format!("two attributes {:?}", pair[0].0)));
        }
        Ok(Attributes(all))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_are_found_whatever_the_number_of_their_set() {
        let text = r#"{ "WEIGHTS_12": 7, "POSITION": 1, "JOINTS_12": 6, "_POSITION": 9, "COLOR_1": 9, "JOINTS_0": null,
            "TEXCOORD_4": 5, "TANGENT": "x", "JOINTS_01": 9, "JOINTS_+1": 9, "JOINTS_": 9, "NORMAL_0": 9 }"#;
        let attributes: Attributes = serde_json::from_str(text).expect("attributes");
        for (semantic, accessor) in [
            (Semantic::Position, Some(1)),
            (Semantic::Normal, None),
            (Semantic::Color, None),
            (Semantic::TextureCoordinates(4), Some(5)),
            (Semantic::Joints(0), None),
            (Semantic::Joints(1), None),
            (Semantic::Joints(12), Some(6)),
            (Semantic::Weights(12), Some(7)),
        ] {
            assert_eq!(attributes.get(semantic), accessor, "{semantic:?}");
        }
        assert_eq!(attributes.joint_sets().collect::<Vec<_>>(), [12]);
    }

    #[test]
    fn an_attribute_that_is_there_twice_is_refused() {
        let why = serde_json::from_str::<Attributes>(r#"{ "JOINTS_0": 1, "JOINTS_0": 2 }"#);
        assert!(why.expect_err("two").to_string().contains("Joints(0)"));
    }
}
