//! Functions for a WebAssembly host: numbers in, text in the module's memory out. `run.mjs` calls them.
#![cfg(target_arch = "wasm32")]
#![allow(
    unsafe_code,
    reason = "exported names are declared unsafe: two functions could have the same one"
)]

use std::sync::{Mutex, PoisonError};

/// The last report, or the message of the panic that ended it.
static TEXT: Mutex<String> = Mutex::new(String::new());

fn put(text: String) {
    *TEXT.lock().unwrap_or_else(PoisonError::into_inner) = text;
}

/// Returns the number of scenes.
#[unsafe(no_mangle)]
extern "C" fn scene_count() -> usize {
    crate::scenes().count()
}

/// Tests a scene. The text is its report then; if this traps, the message of the panic.
#[unsafe(no_mangle)]
extern "C" fn report(scene: usize) {
    std::panic::set_hook(Box::new(|panic| put(panic.to_string())));
    let named = crate::scenes().nth(scene).expect("a scene below `scene_count`");
    put(crate::report(named).join("\n"));
}

/// Returns the address of the text.
#[unsafe(no_mangle)]
extern "C" fn text() -> *const u8 {
    TEXT.lock().unwrap_or_else(PoisonError::into_inner).as_ptr()
}

/// Returns the length of the text in bytes.
#[unsafe(no_mangle)]
extern "C" fn text_length() -> usize {
    TEXT.lock().unwrap_or_else(PoisonError::into_inner).len()
}
