//! Draws what Enfilade sees, in software: base colours under a sun and an ambient sky, and pictures of how a method
//! came to its answer.
//!
//! ```
//! use enfilade::{ContentBuilder, Material, Mesh, Method, SceneBuilder, Transform, View, Viewer};
//! use enfilade_draw::{Painter, Show};
//!
//! let mut content = ContentBuilder::new([Material::opaque([0.8, 0.3, 0.2])]);
//! let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
//! let mesh = content.mesh(Mesh::triangles(&corners, &[0, 1, 2], enfilade::MaterialId(0))?);
//! content.item("leaf", mesh, Transform::IDENTITY);
//! let mut scene = SceneBuilder::new();
//! scene.add("meadow", content.build()?, Method::ZBuffer);
//! let scene = scene.build()?;
//!
//! let view = View::new([0.0, 0.0, 3.0], [0.0, 0.0, 0.0], [64, 48]);
//! let mut painter = Painter::new(&scene, &view, Show::Image);
//! Viewer::new().draw(&scene, &view, &mut painter);
//! let picture = painter.into_image();
//! assert_ne!(picture.get_pixel(32, 24), picture.get_pixel(0, 0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod clip;
mod cover;
mod lamps;
mod light;
mod painter;
mod palette;
mod show;

pub use clip::Clip;
pub use painter::Painter;
pub use show::Show;

pub use image::RgbImage;
