//! Recognizes files of formats that are not read, and says how to make a `.glb` of them.
//!
//! The first bytes decide, never the name: files are renamed, and downloads lose their extension. Formats whose text could also
//! begin an OBJ file are recognized by more than their first word.
//! Source: the specifications of the formats; the converters are those whose options were looked up in their documentation.
//! Cost: O(1); at most [`BEGINNING`] bytes are searched.

use crate::budget::Budget;
use crate::obj::begins_like_obj;
use crate::{BrokenRule, read_regular_file};
use std::path::Path;

/// Number of bytes at the beginning of a file that are searched. Headers of STEP files list authors and programs before the
/// schema.
const BEGINNING: usize = 1 << 16;

/// A format that is not read.
struct OtherFormat {
    /// What the file is: completes "is …".
    name: &'static str,
    /// The shortest way to a `.glb`.
    remedy: &'static str,
}

const IFC: OtherFormat = OtherFormat {
    name: "an IFC model",
    remedy: "convert it: IfcConvert model.ifc model.glb",
};
const IFC_XML: OtherFormat = OtherFormat {
    name: "an IFC model in XML",
    remedy: "save it as .ifc, and convert that: IfcConvert model.ifc model.glb",
};
const IFC_ZIP: OtherFormat = OtherFormat {
    name: "a zipped IFC model",
    remedy: "unpack it, and convert the .ifc inside: IfcConvert model.ifc model.glb",
};
const STEP: OtherFormat = OtherFormat {
    name: "a STEP model",
    remedy: "open it in FreeCAD, select its parts, and use File > Export > glTF 2.0 (*.gltf *.glb) with a name that ends in .glb",
};
const BLEND: OtherFormat = OtherFormat {
    name: "a Blender project",
    remedy: "in Blender use File > Export > glTF 2.0 (.glb), or run: blender --background model.blend --python-expr \
             \"import bpy; bpy.ops.export_scene.gltf(filepath='model.glb')\"",
};
const ZSTANDARD: OtherFormat = OtherFormat {
    name: "compressed with Zstandard, as Blender saves compressed projects (.blend)",
    remedy: "if it is one, open it in Blender and use File > Export > glTF 2.0 (.glb); else unpack it: unzstd FILE",
};
const GZIP: OtherFormat = OtherFormat {
    name: "compressed with gzip, as Blender before 3.0 saved compressed projects (.blend)",
    remedy: "if it is one, open it in Blender and use File > Export > glTF 2.0 (.glb); else unpack it: gunzip FILE.gz",
};
const FBX: OtherFormat = OtherFormat {
    name: "a binary FBX file",
    remedy: "convert it: FBX2glTF --binary --input model.fbx --output model; or in Blender use File > Import > FBX, then \
             File > Export > glTF 2.0 (.glb)",
};
const FBX_TEXT: OtherFormat = OtherFormat {
    name: "an ASCII FBX file",
    remedy: "convert it: FBX2glTF --binary --input model.fbx --output model",
};
const USD: OtherFormat = OtherFormat {
    name: "a USD scene",
    remedy: "in Blender use File > Import > Universal Scene Description, then File > Export > glTF 2.0 (.glb)",
};
const USDZ: OtherFormat = OtherFormat {
    name: "a USDZ package",
    remedy: USD.remedy,
};
const THREE_MF: OtherFormat = OtherFormat {
    name: "a 3MF package",
    remedy: "convert it: assimp export model.3mf model.glb -fglb2",
};
const ZIP: OtherFormat = OtherFormat {
    name: "a ZIP archive",
    remedy: "unpack it, such as with unzip FILE, and name the scene inside",
};
const THREE_DS: OtherFormat = OtherFormat {
    name: "a 3DS file",
    remedy: "convert it: assimp export model.3ds model.glb -fglb2",
};
const COLLADA: OtherFormat = OtherFormat {
    name: "a COLLADA file",
    remedy: "convert it: assimp export model.dae model.glb -fglb2",
};
const X3D: OtherFormat = OtherFormat {
    name: "an X3D file",
    remedy: "in Blender with the extension Web3D X3D/VRML2 use File > Import > X3D, then File > Export > glTF 2.0 (.glb)",
};
const VRML: OtherFormat = OtherFormat {
    name: "a VRML file",
    remedy: X3D.remedy,
};
const STL: OtherFormat = OtherFormat {
    name: "a binary STL file",
    remedy: "convert it: assimp export model.stl model.glb -fglb2; or in Blender use File > Import > STL, then File > \
             Export > glTF 2.0 (.glb)",
};
const STL_TEXT: OtherFormat = OtherFormat {
    name: "an ASCII STL file",
    remedy: STL.remedy,
};
const PLY: OtherFormat = OtherFormat {
    name: "a PLY file",
    remedy: "convert it: assimp export model.ply model.glb -fglb2; or in Blender use File > Import > Stanford PLY, then File \
             > Export > glTF 2.0 (.glb)",
};
const RHINO: OtherFormat = OtherFormat {
    name: "a Rhino model",
    remedy: "in Rhino 8 use File > Export Selected, with the type glTF Binary (*.glb)",
};
const SKETCHUP: OtherFormat = OtherFormat {
    name: "a SketchUp model",
    remedy: "in SketchUp use File > Export > 3D Model, with the type glTF Binary File (*.glb)",
};
const COMPOSITE_TILE: OtherFormat = OtherFormat {
    name: "a composite tile of 3D Tiles (.cmpt)",
    remedy: "split it, and name a .b3dm or .i3dm of it: npx 3d-tiles-tools splitCmpt -i tile.cmpt -o inner",
};
const POINT_TILE: OtherFormat = OtherFormat {
    name: "a point cloud of 3D Tiles (.pnts)",
    remedy: "points hide nothing and are not drawn; name a tile with triangles (.b3dm, .i3dm or .glb)",
};

/// Formats that begin with bytes of their own.
const BY_MAGIC: [(&[u8], OtherFormat); 15] = [
    (b"BLENDER", BLEND),
    (b"\x28\xB5\x2F\xFD", ZSTANDARD),
    (b"\x1F\x8B\x08", GZIP),
    (b"Kaydara FBX Binary", FBX),
    (b"PXR-USDC", USD),
    (b"3D Geometry File Format", RHINO),
    (b"\xFF\xFE\xFF\x0ES\0k\0e\0t\0c\0h\0U\0p\0", SKETCHUP),
    (b"cmpt", COMPOSITE_TILE),
    (b"pnts", POINT_TILE),
    // An archive without files, and one in several parts.
    (b"PK\x05\x06", ZIP),
    (b"PK\x07\x08", ZIP),
    (b"#VRML V", VRML),
    (b"#X3D V", X3D),
    (b"#usda 1.", USD),
    (b"#sdf 1.", USD),
];

/// Returns the error for bytes of a known format that is not read.
pub(crate) fn refusal(bytes: &[u8]) -> Option<BrokenRule> {
    let beginning = &bytes[..bytes.len().min(BEGINNING)];
    recognize(beginning, bytes.len() as u64).map(OtherFormat::refusal)
}

/// Returns the error for a file of a known format that is not read, from its first bytes; for a file that is too large to be
/// read as a whole.
pub(crate) fn refusal_of_file(path: &Path) -> Option<BrokenRule> {
    let mut budget = Budget::new(u64::MAX);
    let beginning = read_regular_file(path, Some(BEGINNING as u64), &String::new, &mut budget).ok()?;
    let length = std::fs::metadata(path).ok()?.len();
    recognize(&beginning, length).map(OtherFormat::refusal)
}

impl OtherFormat {
    fn refusal(self) -> BrokenRule {
        BrokenRule::OtherFormat {
            format: self.name,
            remedy: self.remedy,
        }
    }
}

/// Returns the format of a file of `length` bytes that begins with `beginning`; `None` if it is unknown or read.
fn recognize(beginning: &[u8], length: u64) -> Option<OtherFormat> {
    // Comments of OBJ may hold the first line of another format, such as `#usda 1.0`.
    if begins_like_obj(beginning) {
        return None;
    }
    let text = without_mark(beginning).trim_ascii_start();
    let magic = BY_MAGIC.into_iter().find(|(magic, _)| text.starts_with(magic));
    magic
        .map(|(_, format)| format)
        .or_else(|| zip(beginning))
        .or_else(|| three_ds(beginning))
        .or_else(|| exchange(text))
        .or_else(|| xml(text))
        .or_else(|| fbx_text(text))
        .or_else(|| stl_text(text))
        .or_else(|| ply(text))
        .or_else(|| stl(beginning, length))
}

/// Returns the bytes without a byte order mark.
fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

/// Recognizes archives by the names of their files. The first one is that of the scene in a USDZ package.
fn zip(bytes: &[u8]) -> Option<OtherFormat> {
    /// Length of the header of a file in an archive, without its name.
    const HEADER: usize = 30;
    const LENGTH_OF_NAME: usize = 26;
    let header = bytes.strip_prefix(b"PK\x03\x04").map(|_| bytes)?;
    let length = header.get(LENGTH_OF_NAME..LENGTH_OF_NAME + 2);
    let length = length.map_or(0, |two| usize::from(u16::from_le_bytes([two[0], two[1]])));
    let name = header.get(HEADER..HEADER + length).unwrap_or_default();
    let name = name.to_ascii_lowercase();
    let is = |endings: &[&[u8]]| endings.iter().any(|ending| name.ends_with(ending));
    Some(if is(&[b".usd", b".usda", b".usdc"]) {
        USDZ
    } else if is(&[b".ifc", b".ifcxml"]) {
        IFC_ZIP
    } else if contains(bytes, b"3D/3dmodel.model") {
        THREE_MF
    } else {
        ZIP
    })
}

/// Recognizes 3DS files: the main chunk, whose first part is the version or the scene.
fn three_ds(bytes: &[u8]) -> Option<OtherFormat> {
    const MAIN: &[u8] = b"MM";
    const FIRST_PARTS: [[u8; 2]; 4] = [[0x02, 0x00], [0x3D, 0x3D], [0x3E, 0x3D], [0x00, 0xB0]];
    let first_part = bytes.strip_prefix(MAIN)?.get(4..6)?;
    FIRST_PARTS
        .iter()
        .any(|part| part == first_part)
        .then_some(THREE_DS)
}

/// Recognizes text after ISO 10303-21, which holds IFC models and STEP parts; the schema tells which.
fn exchange(text: &[u8]) -> Option<OtherFormat> {
    let rest = text.strip_prefix(b"ISO-10303-21;")?;
    let schema = after(rest, b"FILE_SCHEMA").unwrap_or_default();
    let schema = schema.split(|&byte| byte == b';').next().unwrap_or_default();
    Some(if contains(&schema.to_ascii_uppercase(), b"'IFC") {
        IFC
    } else {
        STEP
    })
}

/// Recognizes XML by its root element.
fn xml(text: &[u8]) -> Option<OtherFormat> {
    let mut rest = text;
    // Declarations and comments come before the root element.
    loop {
        rest = rest.trim_ascii_start().strip_prefix(b"<")?;
        if let Some(comment) = rest.strip_prefix(b"!--") {
            rest = after(comment, b"-->")?;
        } else if rest.starts_with(b"?") || rest.starts_with(b"!") {
            rest = after(rest, b">")?;
        } else {
            break;
        }
    }
    let is_end = |byte: &u8| byte.is_ascii_whitespace() || b"/>".contains(byte);
    let root = rest.split(is_end).next().unwrap_or_default();
    let root = root.rsplit(|&byte| byte == b':').next().unwrap_or_default();
    match &*root.to_ascii_lowercase() {
        b"collada" => Some(COLLADA),
        b"ifcxml" => Some(IFC_XML),
        b"x3d" => Some(X3D),
        _ => None,
    }
}

/// Recognizes FBX as text: by its first comment or its first node.
fn fbx_text(text: &[u8]) -> Option<OtherFormat> {
    let first = text
        .split(|byte| b"\r\n".contains(byte))
        .next()
        .unwrap_or_default();
    let is_named = first.starts_with(b"; FBX ");
    let node = text.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii);
    let node = node.filter(|line| !line.is_empty() && !line.starts_with(b";"));
    let begins_with_header = node.take(1).any(|line| line.starts_with(b"FBXHeaderExtension:"));
    (is_named || begins_with_header).then_some(FBX_TEXT)
}

/// Recognizes STL as text. Its first word alone says little: OBJ files may begin with any line, and binary STL files too.
fn stl_text(text: &[u8]) -> Option<OtherFormat> {
    let mut lines = text.split(|byte| b"\r\n".contains(byte)).map(<[u8]>::trim_ascii);
    let first = lines.next()?.to_ascii_lowercase();
    let is_solid = first.split(u8::is_ascii_whitespace).next()? == b"solid";
    let second = lines.find(|line| !line.is_empty()).unwrap_or_default();
    let second = second.to_ascii_lowercase();
    let is_facet = contains(&first, b" facet normal ")
        || second.starts_with(b"facet")
        || second.starts_with(b"endsolid");
    (is_solid && is_facet).then_some(STL_TEXT)
}

/// Recognizes PLY by its first two lines.
fn ply(text: &[u8]) -> Option<OtherFormat> {
    let second = text.strip_prefix(b"ply")?.trim_ascii_start();
    [&b"format "[..], b"comment "]
        .iter()
        .any(|word| second.starts_with(word))
        .then_some(PLY)
}

/// Recognizes binary STL, which has no magic number: its length follows from its number of triangles.
fn stl(bytes: &[u8], length: u64) -> Option<OtherFormat> {
    const HEADER: usize = 80;
    const BYTES_PER_TRIANGLE: u64 = 50;
    let count = bytes.get(HEADER..)?.first_chunk::<4>()?;
    let triangles = u64::from(u32::from_le_bytes(*count));
    (length == HEADER as u64 + 4 + triangles * BYTES_PER_TRIANGLE).then_some(STL)
}

/// Returns what follows the first occurrence of some bytes.
fn after<'b>(bytes: &'b [u8], wanted: &[u8]) -> Option<&'b [u8]> {
    let at = bytes.windows(wanted.len()).position(|part| part == wanted)?;
    Some(&bytes[at + wanted.len()..])
}

fn contains(bytes: &[u8], wanted: &[u8]) -> bool {
    after(bytes, wanted).is_some()
}
