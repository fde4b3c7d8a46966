//! The real scenes of the book's figures and of the tests: where each is published, and whether a folder holds them.
//!
//! They are not in the repository, because of their size and licences. A `.glb` holds what the tests need of the
//! published file, converted: positions, indices and base colours, one node per object, all triangles in their order.
//! So its checksum says that two people measured the same scene, not that one has the original.
#![allow(clippy::print_stdout, reason = "a command prints what it finds")]

use anyhow::{Context, Result, ensure};
use sha2::{Digest, Sha256};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub(crate) struct Args {
    /// Folder of real scenes to check; without one, they are only listed
    #[arg(value_name = "FOLDER", env = "ENFILADE_SCENES")]
    folder: Option<PathBuf>,
}

/// A real scene.
struct RealScene {
    file: &'static str,
    what: &'static str,
    published: &'static str,
    licence: &'static str,
    sha256: &'static str,
}

const SCENES: [RealScene; 17] = [
    RealScene {
        file: "blender_villa.glb",
        what: "a villa of 8 rooms with portals, a mirror, lights and textures, exported by Blender 3.4",
        published: "the authors of Enfilade; on request",
        licence: "CC0",
        sha256: "ab7c6a720bbfd71bbd8f6ed75b255ceb43739bd018d18c4110fa1c3ef03a2c76",
    },
    RealScene {
        file: "blender_villa.truth.json",
        what: "its rooms, portals, cameras, and the nodes that another renderer finds visible",
        published: "as blender_villa.glb",
        licence: "CC0",
        sha256: "366414b4e65e7d5f1c3d1f1beac011d7bddcd50b47199ac5fbed25e12978436f",
    },
    RealScene {
        file: "city_etoile.glb",
        what: "buildings around the Place de l'Étoile, Paris",
        published: "https://pypi.org/project/sionna-rt/2.2.0/ sionna/rt/scenes/etoile",
        licence: "ODbL 1.0, OpenStreetMap contributors; Apache-2.0",
        sha256: "5519da721ffd173ea8ad8025fa7ad336dd1944257289710aaefd7d1790b95807",
    },
    RealScene {
        file: "city_munich.glb",
        what: "buildings of Munich",
        published: "https://pypi.org/project/sionna-rt/2.2.0/ sionna/rt/scenes/munich",
        licence: "ODbL 1.0, OpenStreetMap contributors; Apache-2.0",
        sha256: "f7f9d4a6325114660ede8261804aba2e708258f7601e25785678224df09046b7",
    },
    RealScene {
        file: "city_san_francisco.glb",
        what: "buildings and hills of San Francisco",
        published: "https://pypi.org/project/sionna-rt/2.2.0/ sionna/rt/scenes/san_francisco",
        licence: "ODbL 1.0, OpenStreetMap contributors; Apache-2.0",
        sha256: "33b75717f6972568cfe5e8f89a080445aa6f2c8ead5fa11192e9349ef2966482",
    },
    RealScene {
        file: "classroom.glb",
        what: "Japanese Classroom, by NovaZeeke",
        published: "https://github.com/hchoi405/dppm-scenes at 8fdb2dcb, scenes/classroom",
        licence: "CC BY 3.0",
        sha256: "f28bd9060647853c66d9fc5c57deccaeeb89602e2361ceda5238e6fdbde11797",
    },
    RealScene {
        file: "country_kitchen.glb",
        what: "Country Kitchen, by Jay-Artist; 6 of 295 meshes missing, a glass table and a mirror added",
        published: "https://github.com/yysun997/improved-path-guiding at 2e1eb387, scenes/country_kitchen",
        licence: "CC BY 3.0",
        sha256: "45ec0aa2cbf87b597bb62fda228eb8592b81d40ee50d12c2a8c26f5057a92880",
    },
    RealScene {
        file: "ifc_duplex.glb",
        what: "a house of two flats",
        published: "https://github.com/youshengCode/IfcSampleFiles Ifc2x3_Duplex_Architecture.ifc",
        licence: "CC BY 4.0, buildingSMART",
        sha256: "a9c85a048a82bfd32a549d347ea399349a1e55810ee869a14894f2ccc98ee29e",
    },
    RealScene {
        file: "ifc_fzk_haus.glb",
        what: "a small house",
        published: "https://github.com/ThatOpen/engine_web-ifc tests/ifcfiles/public/AC20-FZK-Haus.ifc",
        licence: "CC BY believed, KIT IFC examples; not verified",
        sha256: "8631a951ee6caf5dd63be547104e581512b193733e0df5fa8ce058fa18348cc6",
    },
    RealScene {
        file: "ifc_office_a.glb",
        what: "an office building",
        published: "https://github.com/ThatOpen/engine_web-ifc tests/ifcfiles/public/Office_A_20110811.ifc",
        licence: "CC BY believed, NIBS/buildingSMART Common BIM Files; not verified",
        sha256: "ea4e400b348c74e512f67c89edd2494828d1422db13641741b21b89c08758db2",
    },
    RealScene {
        file: "q3_oa_rpg3dm2.glb",
        what: "a map of OpenArena",
        published: "Debian package openarena-081-maps 0.8.5split-14, pak1-maps.pk3, maps/oa_rpg3dm2.bsp",
        licence: "GPL-2.0-or-later",
        sha256: "e9ffa6f41f89f1669370b7c47efcf8fdbc5addc7e9eafa36374fdadd4f2a7181",
    },
    RealScene {
        file: "san_miguel.glb",
        what: "San Miguel, the edition of 2009 for pbrt; 19 source files missing",
        published: "https://github.com/AndiMiko/pbrt-scenes at 3daf6466, sanmiguel",
        licence: "CC BY 3.0, or free for research and education with attribution: unclear",
        sha256: "b783614c0a1ca29052341daad0bfdf3855e0062e2c3ecd6a4b7ef56d27371337",
    },
    RealScene {
        file: "sponza_crytek.glb",
        what: "Sponza, by Frank Meinl, Crytek; positions only",
        published: "https://github.com/rawrunprotected/rasterizer at 50a1c132, SoftwareRasterizer/Sponza",
        licence: "CC BY 3.0",
        sha256: "ef2f7467b9a25c2b061d5e117c73faeed6054e36736e1524e8e4a7c674c39fa7",
    },
    RealScene {
        file: "staircase.glb",
        what: "The Wooden Staircase, by Wig42",
        published: "https://github.com/hchoi405/dppm-scenes at 8fdb2dcb, scenes/staircase",
        licence: "CC BY 3.0",
        sha256: "148619459d02b65e97d97636a8f6cecae60085f8b3c5e34d2b43d18e55bd30cb",
    },
    RealScene {
        file: "terrain_jacksboro.glb",
        what: "hills at Jacksboro, 344 x 403 heights",
        published: "https://pypi.org/project/matplotlib/3.11.2/ sample_data/jacksboro_fault_dem.npz",
        licence: "public domain believed, USGS elevation",
        sha256: "408d5e0d81c76ea5a65a716f5c0122845286caad63f927f7b236a10890107227",
    },
    RealScene {
        file: "terrain_jacksboro.json",
        what: "the description of the same heights in terrain_jacksboro_u16le.raw",
        published: "as terrain_jacksboro.glb",
        licence: "public domain believed, USGS elevation",
        sha256: "b32d4f52e893b6d875afa71abfe5b73ae8b578fee46d7f45edee62e861a6f1e4",
    },
    RealScene {
        file: "terrain_jacksboro_u16le.raw",
        what: "the same heights, in 16 bits each",
        published: "as terrain_jacksboro.glb",
        licence: "public domain believed, USGS elevation",
        sha256: "0c7e9f894eb7c8d444ca4475e64249e060d96c90ab63fdf439a0381c590ed502",
    },
];

pub(crate) fn run(args: &Args) -> Result<()> {
    let mut different = Vec::new();
    for scene in &SCENES {
        let state = match &args.folder {
            None => "listed",
            Some(folder) => match sha256(&folder.join(scene.file))? {
                None => "missing",
                Some(sum) if sum == scene.sha256 => "ok",
                Some(_) => {
                    different.push(scene.file);
                    "differs"
                }
            },
        };
        println!("{state:<8} {}: {}", scene.file, scene.what);
        println!("         {}", scene.published);
        println!("         {}; SHA-256 {}", scene.licence, scene.sha256);
    }
    ensure!(
        different.is_empty(),
        "not the scenes of the book's figures: {}",
        different.join(", ")
    );
    Ok(())
}

/// Returns the checksum of a file in hexadecimal digits; `None` if there is no such file.
fn sha256(path: &Path) -> Result<Option<String>> {
    let bytes = match fs::read(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        bytes => bytes.with_context(|| path.display().to_string())?,
    };
    let sum = Sha256::digest(&bytes);
    Ok(Some(sum.iter().map(|byte| format!("{byte:02x}")).collect()))
}
