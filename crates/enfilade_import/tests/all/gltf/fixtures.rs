//! Small files that other software wrote: each is read, or refused, as its maker says that it must be.

use enfilade::{Alpha, LightShape};
use enfilade_import::{Import, ImportError, ReadOptions, read};
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures")
}

fn opened(file: &str) -> Result<Import, ImportError> {
    read(&folder().join(file), &ReadOptions::default())
}

fn sound(file: &str) -> Import {
    opened(file).unwrap_or_else(|error| panic!("{error}"))
}

fn warnings(import: &Import) -> String {
    let texts: Vec<String> = import.warnings.iter().map(ToString::to_string).collect();
    texts.join("; ")
}

/// The glTF fixtures of a folder.
fn names(inside: &str) -> impl Iterator<Item = String> {
    let entries = std::fs::read_dir(folder().join(inside)).expect("the fixtures");
    let names = entries.map(|entry| {
        entry
            .expect("an entry")
            .file_name()
            .into_string()
            .expect("a name")
    });
    names.filter(|name| name.ends_with(".glb") || name.ends_with(".gltf"))
}

#[test]
fn every_sound_fixture_is_read_and_only_what_is_left_out_is_warned_of() {
    let mut files = 0;
    for name in names("") {
        files += 1;
        let expected = match &*name {
            "metallic_roughness.glb" => {
                "metallic-roughness, normal, occlusion and transmission textures are not drawn (1)"
            }
            _ => "",
        };
        let import = sound(&name);
        assert_eq!(warnings(&import), expected, "{name}");
        assert!(import.rooms[0].geometry.triangle_count() > 0, "{name}");
        assert!(
            import.cameras.iter().any(|camera| camera.name == "Camera"),
            "{name}"
        );
    }
    assert!(files >= 22, "{files} fixtures");
}

#[test]
fn compressed_fixtures_are_the_same_mesh_as_their_plain_copies() {
    let triangles = |file| sound(file).rooms[0].geometry.triangle_count();
    let of_ball_and_box = triangles("meshopt.glb");
    assert_eq!(triangles("meshopt_filters.glb"), of_ball_and_box);
    let import = sound("meshopt_fallback.glb");
    let geometry = &import.rooms[0].geometry;
    assert!(geometry.meshes().iter().all(|mesh| !mesh.normals().is_empty()));
}

#[test]
fn six_boxes_stored_in_six_ways_are_of_one_size() {
    let import = sound("quantized.glb");
    let geometry = &import.rooms[0].geometry;
    let sizes: Vec<[f32; 3]> = geometry.items().iter().map(|item| item.bounds.size()).collect();
    assert_eq!(sizes.len(), 6);
    for size in &sizes {
        let off = (0..3)
            .map(|axis| (size[axis] - sizes[0][axis]).abs())
            .fold(0.0, f32::max);
        assert!(off < 0.02 * sizes[0][0], "{sizes:?}");
    }
}

#[test]
fn instances_lights_and_cameras_are_those_that_their_maker_put_there() {
    let import = sound("instancing.glb");
    assert!(import.rooms[0].geometry.items().len() > 12);
    let lights = sound("lights.glb").lights;
    let kinds: Vec<&str> = lights
        .iter()
        .map(|light| match light.shape {
            LightShape::Point => "point",
            LightShape::Spot { .. } => "spot",
            LightShape::Sun { .. } => "sun",
        })
        .collect();
    assert!(
        ["point", "spot", "sun"].iter().all(|kind| kinds.contains(kind)) && kinds.len() == 3,
        "{kinds:?}"
    );
    assert!(lights.iter().any(|light| light.range == 2.5), "{lights:?}");
    let import = sound("cameras.glb");
    let cameras = &import.cameras;
    let heights = cameras.iter().zip(&import.orthographic_heights);
    let flat: Vec<&str> = heights
        .filter(|(_, height)| height.is_some())
        .map(|(camera, _)| &*camera.name)
        .collect();
    assert_eq!((cameras.len(), flat), (3, vec!["orthographic"]));
    let cut = sound("cutout.glb");
    let cutoffs = cut.rooms[0].geometry.materials().iter();
    let cutoffs: Vec<f32> = cutoffs
        .filter(|m| m.alpha == Alpha::Mask)
        .map(|m| m.cutoff)
        .collect();
    assert!(cutoffs.contains(&0.3) && cutoffs.contains(&0.9), "{cutoffs:?}");
}

#[test]
fn broken_fixtures_are_refused_or_read_without_what_is_broken() {
    /// Expected text of the warning or error; empty if there is none.
    const KNOWN: [(&str, &str); 35] = [
        (
            "all_nan_texcoords.glb",
            "warning: texture coordinates that are not finite are 0",
        ),
        (
            "bad_cameras.glb",
            "warning: cameras with an invalid angle, near plane or transform are ignored",
        ),
        (
            "bad_data_uri.gltf",
            "warning: images that cannot be read are grey (image 0 has an invalid URI",
        ),
        (
            "bad_lights.glb",
            "warning: lights with an invalid color, range, cone or transform are ignored",
        ),
        ("bad_normals.glb", "warning: normals that are not finite"),
        (
            "cut_jpeg.glb",
            "warning: images that cannot be read are grey (image 0 \"letter\": it is truncated",
        ),
        ("cut_png.glb", "warning: images that cannot be read are grey"),
        ("empty_png.glb", "warning: images that cannot be read are grey"),
        (
            "huge_jpeg.glb",
            "warning: images that cannot be read are grey (image 0 \"letter\": 65500x65500 texels need",
        ),
        ("huge_png.glb", "warning: images that cannot be read are grey"),
        (
            "image_out_of_range.glb",
            "error: texture 0 names image 7, but there are only 1",
        ),
        (
            "image_outside.gltf",
            "warning: images that cannot be read are grey (image 0 is `../../../Cargo.toml`",
        ),
        (
            "instances_differ.glb",
            "error: node 0 \"letter\" has 3 translations (TRANSLATION), but 5 scales (SCALE)",
        ),
        (
            "meshopt_count.glb",
            "error: bufferView 5 is compressed, but it decodes to 24000000000 bytes",
        ),
        (
            "meshopt_cut.glb",
            "error: bufferView 5 is compressed, but its bytes are damaged",
        ),
        (
            "meshopt_filter.glb",
            "error: bufferView 5 is compressed, but its filter is none of",
        ),
        (
            "meshopt_not.glb",
            "error: bufferView 5 is compressed, but its bytes are damaged",
        ),
        (
            "missing_image.gltf",
            "warning: images that cannot be read are grey (image 0 is the file `",
        ),
        ("nan_colors.glb", "warning: colors that are not finite are white"),
        (
            "nan_texcoords.glb",
            "warning: texture coordinates that are not finite are 0",
        ),
        (
            "negative_range.glb",
            "warning: lights with an invalid color, range, cone or transform are ignored (node 2 \"range\")",
        ),
        (
            "no_such_texcoord.glb",
            "warning: textured faces without texture coordinates",
        ),
        (
            "not_an_image.glb",
            "warning: images that cannot be read are grey (image 0 \"letter\": it is neither PNG nor JPEG",
        ),
        ("png_called_jpeg.glb", ""),
        (
            "sampler_out_of_range.glb",
            "error: texture 0 names sampler 7, but there are only 1",
        ),
        (
            "sparse_out_of_order.glb",
            "error: accessor 0 has the sparse index 1 at position 1",
        ),
        (
            "sparse_out_of_range.glb",
            "error: accessor 0 has the sparse index 4000 at position 1",
        ),
        (
            "sparse_too_many.glb",
            "error: accessor 0 has 2000000000 sparse elements, but only 4",
        ),
        ("swelling_png.glb", ""),
        (
            "texture_out_of_range.glb",
            "error: material 0 names texture 7, but there are only 1",
        ),
        (
            "texture_without_source.glb",
            "warning: images that cannot be read are grey (texture 0: it has no image",
        ),
        (
            "unknown_optional.glb",
            "warning: extensions are not read (ACME_teapot)",
        ),
        (
            "unknown_required.glb",
            "error: requires an unsupported extension: ACME_spout, ACME_teapot;",
        ),
        (
            "unknown_wrap.glb",
            "error: sampler 0 has wrapS 12345, which glTF does not define",
        ),
        (
            "view_out_of_range.glb",
            "error: image 0 \"letter\" names bufferView 99, but there are only 5",
        ),
    ];
    for name in names("broken") {
        let said = match opened(&format!("broken/{name}")) {
            Ok(import) if import.warnings.is_empty() => String::new(),
            Ok(import) => format!("warning: {}", warnings(&import)),
            Err(error) => format!("error: {}", error.rule),
        };
        let known = KNOWN.iter().find(|(known, _)| *known == name);
        let (_, expected) = known.unwrap_or_else(|| panic!("{name} is new here: it says `{said}`"));
        assert!(
            said.starts_with(expected) && said.is_empty() == expected.is_empty(),
            "{name}: it says\n  {said}\nand not\n  {expected}"
        );
    }
}
