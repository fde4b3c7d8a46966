//! Files of formats that are not read: each error names the format, and the way to a `.glb`.

use enfilade_import::{BrokenRule, ImportError, ReadOptions, read, read_bytes};

/// Reads bytes under a name.
fn read_as(name: &str, bytes: &[u8], options: &ReadOptions) -> Result<(), ImportError> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("it is ours");
    read(&path, options).map(drop)
}

/// An archive whose first file has this name.
fn archive(name: &str) -> Vec<u8> {
    let mut bytes = b"PK\x03\x04\x14\0\0\0\0\0\0\0\0\0".to_vec();
    bytes.extend([0; 12]);
    bytes.extend((name.len() as u16).to_le_bytes());
    bytes.extend([0; 2]);
    bytes.extend(name.as_bytes());
    bytes.extend(b"contents");
    bytes
}

/// A binary STL of some triangles, whose header begins with a text.
fn stl(header: &str, triangles: u32) -> Vec<u8> {
    let mut bytes = header.as_bytes().to_vec();
    bytes.resize(80, 0);
    bytes.extend(triangles.to_le_bytes());
    bytes.resize(84 + 50 * triangles as usize, 7);
    bytes
}

fn three_ds(first_part: [u8; 2]) -> Vec<u8> {
    let mut bytes = b"MM\x10\0\0\0".to_vec();
    bytes.extend(first_part);
    bytes.extend([10, 0, 0, 0, 3, 0, 0, 0]);
    bytes
}

fn step(schema: &str) -> Vec<u8> {
    let text = format!(
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('IFC, or not'),'2;1');\nFILE_NAME('a;b.stp','',(''),(''),'','','');\n\
         {schema}\nENDSEC;\nDATA;\n#1=CARTESIAN_POINT('',(0.,0.,0.));\nENDSEC;\nEND-ISO-10303-21;\n"
    );
    text.into_bytes()
}

/// Files, what each is, and a word of the way to a `.glb`.
fn files() -> Vec<(Vec<u8>, &'static str, &'static str)> {
    let text = |text: &str| text.as_bytes().to_vec();
    vec![
        (
            step("FILE_SCHEMA(('IFC2X3'));"),
            "an IFC model",
            "IfcConvert model.ifc model.glb",
        ),
        (step("FILE_SCHEMA ( ( 'ifc4' ) );"), "an IFC model", "IfcConvert"),
        (
            step("FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));"),
            "a STEP model",
            "FreeCAD",
        ),
        (text("\u{feff}ISO-10303-21;"), "a STEP model", "File > Export"),
        (
            text("BLENDER-v405REND"),
            "a Blender project",
            "blender --background",
        ),
        (
            text("BLENDER17-01v0500"),
            "a Blender project",
            "File > Export > glTF 2.0",
        ),
        (b"\x28\xB5\x2F\xFD\x04\x88".to_vec(), "Zstandard", "Blender"),
        (b"\x1F\x8B\x08\x00\x00".to_vec(), "gzip", "Blender"),
        (
            b"Kaydara FBX Binary  \0\x1a\0\xe8\x1c\0\0".to_vec(),
            "a binary FBX file",
            "FBX2glTF --binary",
        ),
        (
            text("; FBX 7.4.0 project file\n; ---\n\nFBXHeaderExtension:  {\n"),
            "an ASCII FBX file",
            "FBX2glTF --binary",
        ),
        (
            text("\r\nFBXHeaderExtension:  {\r\n"),
            "an ASCII FBX file",
            "FBX2glTF --binary",
        ),
        (
            text("#usda 1.0\n(\n    upAxis = \"Z\"\n)\ndef Xform \"a\"\n{\n}\n"),
            "a USD scene",
            "Universal Scene Description",
        ),
        (
            b"PXR-USDC\0\x08\0\0".to_vec(),
            "a USD scene",
            "Universal Scene Description",
        ),
        (
            archive("Scene.USDC"),
            "a USDZ package",
            "Universal Scene Description",
        ),
        (archive("house.ifc"), "a zipped IFC model", "IfcConvert"),
        (archive("textures/wood.png"), "a ZIP archive", "unpack it"),
        (b"PK\x05\x06\0\0\0\0".to_vec(), "a ZIP archive", "unpack it"),
        (b"PK\x03\x04".to_vec(), "a ZIP archive", "unpack it"),
        (
            three_ds([2, 0]),
            "a 3DS file",
            "assimp export model.3ds model.glb -fglb2",
        ),
        (three_ds([0x3d, 0x3d]), "a 3DS file", "-fglb2"),
        (
            text(
                "<?xml version=\"1.0\"?>\n<!-- <X3D> -->\n<COLLADA xmlns=\"http://www.collada.org\" version=\"1.4.1\">",
            ),
            "a COLLADA file",
            "assimp export model.dae model.glb -fglb2",
        ),
        (text("\u{feff} <collada:COLLADA/>"), "a COLLADA file", "-fglb2"),
        (
            text("solid box\n  facet normal 0 0 1\n    outer loop\n"),
            "an ASCII STL file",
            "model.stl model.glb -fglb2",
        ),
        (
            text("solid\r\n\r\nFACET NORMAL 0 0 1\r\n"),
            "an ASCII STL file",
            "-fglb2",
        ),
        (
            text("solid nothing\nendsolid nothing\n"),
            "an ASCII STL file",
            "-fglb2",
        ),
        (stl("", 2), "a binary STL file", "model.stl model.glb -fglb2"),
        (
            stl("solid in spite of its name", 1),
            "a binary STL file",
            "-fglb2",
        ),
        (stl("exported", 0), "a binary STL file", "-fglb2"),
        (text("ply\nformat ascii 1.0\n"), "a PLY file", "-fglb2"),
    ]
}

#[test]
fn each_format_that_is_not_read_is_named_with_the_way_to_a_glb_whatever_the_file_is_called() {
    let options = ReadOptions::default();
    for (bytes, format, way) in files() {
        let shown = bytes[..bytes.len().min(20)].escape_ascii().to_string();
        let errors = ["a.obj", "a.glb", "a.bsp", "a"].map(|name| read_as(name, &bytes, &options));
        let from_memory = read_bytes(&bytes, None, &options).map(drop);
        for error in errors.into_iter().chain([from_memory]) {
            let error = error.expect_err("not read");
            assert!(
                matches!(error.rule, BrokenRule::OtherFormat { .. }),
                "{shown}: {error}"
            );
            let said = error.to_string();
            assert!(
                said.contains(&format!("is {format}")) || said.contains(&format!("with {format}")),
                "{shown}: {said}"
            );
            assert!(said.contains(way), "{shown}: {said}");
        }
    }
}

#[test]
fn a_model_larger_than_the_memory_is_named_too() {
    let mut bytes = step("FILE_SCHEMA(('IFC4'));");
    bytes.resize(100_000, b' ');
    let options = ReadOptions {
        limit_bytes: 50_000,
        ..ReadOptions::default()
    };
    for (bytes, format) in [(bytes, "an IFC model"), (stl("", 2000), "a binary STL file")] {
        let said = read_as("a", &bytes, &options).expect_err("not read").to_string();
        assert!(said.contains(format), "{said}");
    }
}

#[test]
fn obj_that_resembles_another_format_is_obj() {
    const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for beginning in [
        "solid\n",
        "solid box\n# facet normal\n",
        "#usda 1.0\n",
        "# FBX 7.4.0 project file\n",
        "#VRML V2.0 utf8\n",
        "MM\n",
        "ply\n",
    ] {
        let text = format!("{beginning}{TRIANGLE}");
        let read = read_as("a.obj", text.as_bytes(), &ReadOptions::default());
        assert!(read.is_ok(), "{beginning}: {read:?}");
    }
    // 84 + 50 bytes, the length of a binary STL of one triangle.
    let text = format!("{TRIANGLE:<134}");
    assert_eq!(text.len(), 134);
    assert!(read_as("a", text.as_bytes(), &ReadOptions::default()).is_ok());
}

#[test]
fn a_damaged_beginning_is_not_taken_for_another_format() {
    let mut long = stl("", 3);
    long.push(0);
    for bytes in [
        &b"MM"[..],
        b"MM\x10\0\0\0\x09\x09",
        b"solid",
        b"solidarity\nfacet",
        b"<html><body>",
        b"<!-- COLLADA",
        b"<",
        b"; FBX",
        b"PK",
        b"ISO-10303-42;",
        &long,
    ] {
        let error = read_as("a", bytes, &ReadOptions::default()).expect_err("not read");
        assert!(
            matches!(error.rule, BrokenRule::UnknownFormat { .. }),
            "{}: {error}",
            bytes.escape_ascii()
        );
    }
}
