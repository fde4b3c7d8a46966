//! The viewer in a web page: what its script calls.

use crate::loading::Loading;
use crate::window::{Window, device};
use wasm_bindgen::prelude::*;
use web_sys::HtmlCanvasElement;

#[wasm_bindgen]
extern "C" {
    /// Shows on the page that the viewer has stopped. The page defines it.
    #[wasm_bindgen(js_name = enfiladeFailed)]
    fn failed(message: &str);

    /// Gives a message of the viewer to screen readers, which cannot read the canvas. The page defines it.
    #[wasm_bindgen(js_name = enfiladeSaid)]
    pub(crate) fn said(message: &str);
}

/// Starts the viewer in a canvas, with a file of these bytes, or the palace if there is none.
///
/// # Errors
/// If the browser has neither WebGPU nor WebGL2.
#[wasm_bindgen]
pub async fn start(
    canvas: HtmlCanvasElement,
    name: Option<String>,
    bytes: Option<Vec<u8>>,
) -> Result<(), JsValue> {
    std::panic::set_hook(Box::new(|panic| failed(&panic.to_string())));
    let options = eframe::WebOptions {
        wgpu_options: device(),
        ..eframe::WebOptions::default()
    };
    let scene = match (name, bytes) {
        (Some(name), Some(bytes)) => Loading::arriving(&name, async { Ok(bytes) }),
        (Some(name), None) => Loading::file(&name),
        (None, _) => Loading::file("@enfilade"),
    };
    let create = move |context: &eframe::CreationContext<'_>| {
        let window = Window::new(context, scene)?;
        Ok(Box::new(window) as Box<dyn eframe::App>)
    };
    eframe::WebRunner::new()
        .start(canvas, options, Box::new(create))
        .await
}
