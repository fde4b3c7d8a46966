//! WebAssembly bindings of [Enfilade](enfilade): the classes in the `.wasm` files of the npm package `enfilade`.
//!
//! JavaScript wraps them (`web/src/`): the package's documentation is there. Arrays of numbers are copied in; results are
//! read in place, at the addresses that the classes return. Keys are positions in bit sets, so use small ones.
//!
//! Every error is a JavaScript `Error` whose `code` names the broken rule.
#![forbid(unsafe_code)]

#[cfg(feature = "files")]
mod files;
mod scene;
mod viewer;

#[cfg(feature = "files")]
pub use files::SceneFile;
pub use scene::Scene;
pub use viewer::Viewer;

use wasm_bindgen::JsValue;

/// Returns a JavaScript `Error` with a `code`.
fn error(code: &str, message: impl std::fmt::Display) -> JsValue {
    let error = js_sys::Error::new(&message.to_string());
    // Fails only for objects that cannot be extended.
    let _ = js_sys::Reflect::set(&error, &"code".into(), &code.into());
    error.into()
}

/// Returns an error if an array has another length than its partner demands.
fn check_length(what: &str, length: usize, expected: usize) -> Result<(), JsValue> {
    if length == expected {
        return Ok(());
    }
    Err(error(
        "web/length",
        format_args!("{what} has {length} elements, expected {expected}"),
    ))
}
