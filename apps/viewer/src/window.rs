//! The viewer in a window of the system, or in a canvas of a page.

use crate::app::App;
use crate::loading::Loading;
use crate::picture::Gpu;
use eframe::egui_wgpu::{RenderState, WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use eframe::wgpu;
use std::sync::Arc;

/// What `eframe` drives.
pub struct Window {
    app: App,
    /// Options to apply once the scene is open.
    #[cfg(not(target_arch = "wasm32"))]
    args: Option<crate::args::Args>,
    /// The message that the page has.
    #[cfg(target_arch = "wasm32")]
    said: Option<(String, bool)>,
}

impl Window {
    /// Creates the viewer on the device of a window.
    ///
    /// # Errors
    /// If the window has no device.
    pub fn new(
        context: &eframe::CreationContext<'_>,
        scene: Loading,
        #[cfg(not(target_arch = "wasm32"))] args: Option<crate::args::Args>,
    ) -> Result<Window, String> {
        let state = context
            .wgpu_render_state
            .as_ref()
            .ok_or("there is no graphics device")?;
        Ok(Window {
            app: App::new(gpu(state), scene),
            #[cfg(not(target_arch = "wasm32"))]
            args,
            #[cfg(target_arch = "wasm32")]
            said: None,
        })
    }
}

impl eframe::App for Window {
    fn ui(&mut self, ui: &mut eframe::egui::Ui, _frame: &mut eframe::Frame) {
        #[cfg(not(target_arch = "wasm32"))]
        let had_scene = self.app.session.is_some();
        self.app.show(ui);
        #[cfg(target_arch = "wasm32")]
        if self.said != self.app.message {
            self.said.clone_from(&self.app.message);
            crate::web::said(self.said.as_ref().map_or("", |(message, _)| message));
        }
        // Applied after the first frame of the scene, which knows its size.
        #[cfg(not(target_arch = "wasm32"))]
        if had_scene
            && let Some(args) = self.args.take()
            && let Err(why) = args.apply(&mut self.app)
        {
            self.app.message = Some((format!("{why:#}"), true));
        }
    }
}

fn gpu(state: &RenderState) -> Gpu {
    let info = state.adapter.get_info();
    let flags = state.adapter.get_downlevel_capabilities().flags;
    Gpu {
        device: state.device.clone(),
        queue: state.queue.clone(),
        renderer: Arc::clone(&state.renderer),
        has_view_formats: flags.contains(wgpu::DownlevelFlags::VIEW_FORMATS),
        adapter: format!("{} ({:?})", info.name, info.backend),
    }
}

/// Returns how the device is made: with what the renderer likes.
pub fn device() -> WgpuConfiguration {
    WgpuConfiguration {
        wgpu_setup: WgpuSetup::CreateNew(WgpuSetupCreateNew {
            device_descriptor: Arc::new(enfilade_wgpu::device_options),
            ..WgpuSetupCreateNew::without_display_handle()
        }),
        ..WgpuConfiguration::default()
    }
}
