//! Opens a scene in a window.

#[cfg(not(target_arch = "wasm32"))]
fn main() -> std::process::ExitCode {
    use enfilade_viewer::loading::Loading;
    use enfilade_viewer::window::{Window, device};
    let scene = std::env::args().nth(1).unwrap_or("@enfilade".to_owned());
    let options = eframe::NativeOptions {
        renderer: eframe::Renderer::Wgpu,
        wgpu_options: device(),
        viewport: eframe::egui::ViewportBuilder::default().with_inner_size([1280.0, 800.0]),
        ..eframe::NativeOptions::default()
    };
    let made = eframe::run_native(
        "Enfilade",
        options,
        Box::new(move |context| Ok(Box::new(Window::new(context, Loading::file(&scene))?))),
    );
    match made {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(why) => {
            #[expect(clippy::print_stderr)]
            {
                eprintln!("error: {why}");
            }
            std::process::ExitCode::FAILURE
        }
    }
}

#[cfg(target_arch = "wasm32")]
fn main() {}
