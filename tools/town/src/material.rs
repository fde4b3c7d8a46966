//! The materials of the town.

use serde_json::{Value, json};

/// Index into the materials of a tile.
#[derive(Clone, Copy, Debug, Eq, Ord, PartialEq, PartialOrd)]
pub(crate) enum Material {
    Cream,
    Ochre,
    Rose,
    Grey,
    Brick,
    Stone,
    RedTile,
    BrownTile,
    Glass,
    Wood,
    Paint,
    Metal,
    Asphalt,
    Cobble,
    Paving,
    Earth,
    Lawn,
    Bark,
    Leaf,
    LightLeaf,
    Rubber,
    Red,
    Blue,
    Silver,
    Cloth,
    Dark,
    Plaster,
    Lamp,
}

enum Kind {
    /// Opaque and one-sided.
    Solid,
    /// Alpha-blended.
    Glass,
    /// Opaque, two-sided, and too small to occlude anything.
    Detail,
    /// Emissive.
    Light,
}

const TABLE: [(Material, &str, [f64; 3], Kind); 28] = [
    (Material::Cream, "cream stucco", [0.78, 0.7, 0.53], Kind::Solid),
    (Material::Ochre, "ochre stucco", [0.68, 0.45, 0.2], Kind::Solid),
    (Material::Rose, "rose stucco", [0.64, 0.38, 0.32], Kind::Solid),
    (Material::Grey, "grey stucco", [0.5, 0.53, 0.52], Kind::Solid),
    (Material::Brick, "brick", [0.38, 0.15, 0.1], Kind::Solid),
    (Material::Stone, "stone", [0.56, 0.52, 0.45], Kind::Solid),
    (
        Material::RedTile,
        "red roof tile",
        [0.48, 0.17, 0.09],
        Kind::Solid,
    ),
    (
        Material::BrownTile,
        "brown roof tile",
        [0.27, 0.15, 0.1],
        Kind::Solid,
    ),
    (Material::Glass, "glass", [0.35, 0.47, 0.52], Kind::Glass),
    (Material::Wood, "wood", [0.26, 0.14, 0.07], Kind::Solid),
    (Material::Paint, "white paint", [0.8, 0.79, 0.75], Kind::Solid),
    (Material::Metal, "iron", [0.06, 0.07, 0.075], Kind::Solid),
    (Material::Asphalt, "asphalt", [0.07, 0.07, 0.075], Kind::Solid),
    (Material::Cobble, "cobble", [0.22, 0.21, 0.2], Kind::Solid),
    (Material::Paving, "paving", [0.38, 0.36, 0.32], Kind::Solid),
    (Material::Earth, "earth", [0.13, 0.1, 0.06], Kind::Solid),
    (Material::Lawn, "lawn", [0.12, 0.16, 0.05], Kind::Solid),
    (Material::Bark, "bark", [0.12, 0.08, 0.05], Kind::Solid),
    (Material::Leaf, "leaf", [0.09, 0.2, 0.04], Kind::Detail),
    (Material::LightLeaf, "light leaf", [0.2, 0.3, 0.06], Kind::Detail),
    (Material::Rubber, "rubber", [0.02, 0.02, 0.02], Kind::Solid),
    (Material::Red, "red paint", [0.5, 0.03, 0.03], Kind::Solid),
    (Material::Blue, "blue paint", [0.04, 0.1, 0.3], Kind::Solid),
    (Material::Silver, "silver paint", [0.5, 0.52, 0.54], Kind::Solid),
    (Material::Cloth, "cloth", [0.55, 0.3, 0.2], Kind::Solid),
    (Material::Dark, "dark interior", [0.025, 0.022, 0.02], Kind::Solid),
    (Material::Plaster, "plaster", [0.6, 0.57, 0.5], Kind::Solid),
    (Material::Lamp, "lamp", [1.0, 0.9, 0.7], Kind::Light),
];

/// Returns the glTF materials, in the order of [`Material`].
pub(crate) fn all() -> Value {
    let written = TABLE.iter().map(|(_, name, [red, green, blue], kind)| {
        let alpha = if matches!(kind, Kind::Glass) { 0.35 } else { 1.0 };
        let mut material = json!({"name": name, "pbrMetallicRoughness": {
            "baseColorFactor": [red, green, blue, alpha], "metallicFactor": 0, "roughnessFactor": 0.8}});
        match kind {
            Kind::Solid => {}
            Kind::Glass => {
                material["alphaMode"] = json!("BLEND");
                material["doubleSided"] = json!(true);
            }
            Kind::Detail => {
                material["doubleSided"] = json!(true);
                material["extras"] = json!({"enfilade": {"detail": true}});
            }
            Kind::Light => material["emissiveFactor"] = json!([0.9, 0.75, 0.45]),
        }
        material
    });
    written.collect()
}

#[cfg(test)]
mod tests {
    use super::TABLE;

    #[test]
    fn the_table_is_in_the_order_of_the_ids() {
        for (index, (material, ..)) in TABLE.iter().enumerate() {
            assert_eq!(*material as usize, index);
        }
    }
}
