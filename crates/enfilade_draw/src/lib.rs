//! Software renderer for Enfilade scenes, and diagnostic pictures of the visibility methods.
//!
//! It supports mipmapped textures, smooth normals, point, spot and directional lights that shine through portals, hard
//! shadows, ambient occlusion, alpha test, alpha blending, and one or four samples per pixel. [`Show`] lists the
//! diagnostic pictures.
//!
//! ```
//! use enfilade::{GeometryBuilder, Material, Mesh, Method, SceneBuilder, Transform, View, Viewer};
//! use enfilade_draw::{Settings, Stage};
//!
//! let mut geometry = GeometryBuilder::new([Material::opaque([0.8, 0.3, 0.2])]);
//! let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
//! let mesh = geometry.mesh(Mesh::triangles(&corners, &[0, 1, 2], enfilade::MaterialId(0))?);
//! geometry.item("leaf", mesh, Transform::IDENTITY);
//! let mut scene = SceneBuilder::new();
//! scene.add("meadow", geometry.build()?, Method::ZBuffer);
//! let scene = scene.build()?;
//!
//! let view = View::new([0.0, 0.0, 3.0], [0.0, 0.0, 0.0], [64, 48])?;
//! // Mip chains and light reach, prepared once for all pictures of the scene.
//! let stage = Stage::new(&scene);
//! let picture = stage.draw(&mut Viewer::new(), &scene, &view, &Settings::default());
//! assert_ne!(picture.image.get_pixel(32, 24), picture.image.get_pixel(0, 0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod ambient;
mod clip;
mod cover;
mod face;
mod lamps;
mod legend;
mod light;
mod lighting;
mod mips;
mod painter;
mod palette;
mod pending;
mod pixels;
mod samples;
mod shade;
mod shadows;
mod show;
mod sky;
mod smooth;
mod stage;
mod sun;

pub use clip::Clip;
pub use legend::Legend;
pub use lighting::{AmbientLight, DirectLight, PassageLighting};
pub use painter::Painter;
pub use show::Show;
pub use stage::{Exposure, Picture, Samples, Settings, Stage};
pub use sun::with_sun;

pub use image::RgbImage;
