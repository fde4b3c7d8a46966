//! The viewer without a window: for screenshots and tests.

use crate::app::App;
use crate::loading::Loading;
use crate::picture::Gpu;
use anyhow::{Result, bail};
use eframe::egui::{self, Event, FullOutput, RawInput, mutex::RwLock};
use eframe::egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};
use eframe::wgpu;
use enfilade_wgpu::{HeadlessDevice, read};
use image::RgbaImage;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time step reported to the interface, in seconds per frame.
const FRAME: f64 = 1.0 / 30.0;

/// A viewer that draws on a texture.
pub struct Offscreen {
    /// The viewer.
    pub app: App,
    context: egui::Context,
    gpu: Gpu,
    target: wgpu::Texture,
    size: [u32; 2],
    time: f64,
}

impl Offscreen {
    /// Creates a viewer on the best adapter, software drivers included, and waits until its scene is open.
    ///
    /// # Errors
    /// If there is no adapter, or the scene cannot be opened.
    pub fn new(size: [u32; 2], scene: Loading) -> Result<Offscreen> {
        /// Longest time to wait for a scene.
        const PATIENCE: Duration = Duration::from_secs(600);
        let HeadlessDevice {
            adapter,
            device,
            queue,
        } = HeadlessDevice::new()?;
        let format = wgpu::TextureFormat::Rgba8Unorm;
        let target = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("window"),
            size: wgpu::Extent3d {
                width: size[0],
                height: size[1],
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let flags = adapter.get_downlevel_capabilities().flags;
        let gpu = Gpu {
            renderer: Arc::new(RwLock::new(Renderer::new(
                &device,
                format,
                RendererOptions::default(),
            ))),
            has_view_formats: flags.contains(wgpu::DownlevelFlags::VIEW_FORMATS),
            adapter: adapter.get_info().name,
            device,
            queue,
        };
        let mut offscreen = Offscreen {
            app: App::new(gpu.clone(), scene),
            context: egui::Context::default(),
            gpu,
            target,
            size,
            time: 0.0,
        };
        let start = Instant::now();
        while offscreen.app.session.is_none() {
            offscreen.frame(Vec::new());
            match &offscreen.app.message {
                Some((why, true)) => bail!("{why}"),
                _ if start.elapsed() > PATIENCE => bail!("opening the scene took longer than {PATIENCE:?}"),
                _ => std::thread::sleep(Duration::from_millis(2)),
            }
        }
        offscreen.frame(Vec::new());
        Ok(offscreen)
    }

    /// Shows a frame, after some events.
    pub fn frame(&mut self, events: Vec<Event>) {
        let [width, height] = self.size.map(|side| side as f32);
        self.time += FRAME;
        let input = RawInput {
            screen_rect: Some(egui::Rect::from_min_size(
                egui::Pos2::ZERO,
                egui::vec2(width, height),
            )),
            time: Some(self.time),
            predicted_dt: FRAME as f32,
            focused: true,
            events,
            ..RawInput::default()
        };
        let output = self.context.clone().run_ui(input, |ui| self.app.show(ui));
        self.paint(output);
    }

    /// Presses a key for some frames.
    pub fn press(&mut self, key: egui::Key, frames: u32) {
        let event = |pressed| Event::Key {
            key,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers: egui::Modifiers::default(),
        };
        self.frame(vec![event(true)]);
        for _ in 1..frames {
            self.frame(Vec::new());
        }
        self.frame(vec![event(false)]);
    }

    /// Clicks at a position in the window, in pixels.
    pub fn click(&mut self, at: [f32; 2], button: egui::PointerButton) {
        let pos = egui::Pos2::from(at);
        let event = |pressed| Event::PointerButton {
            pos,
            button,
            pressed,
            modifiers: egui::Modifiers::default(),
        };
        self.frame(vec![Event::PointerMoved(pos)]);
        self.frame(vec![event(true)]);
        self.frame(vec![event(false)]);
        self.frame(Vec::new());
    }

    /// Returns the picture of the last frame.
    ///
    /// # Errors
    /// If the device fails.
    pub fn picture(&self) -> Result<RgbaImage> {
        Ok(read(&self.gpu.device, &self.gpu.queue, &self.target)?)
    }

    fn paint(&mut self, mut output: FullOutput) {
        let screen = ScreenDescriptor {
            size_in_pixels: self.size,
            pixels_per_point: output.pixels_per_point,
        };
        let jobs = self.context.tessellate(output.shapes, output.pixels_per_point);
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let mut renderer = self.gpu.renderer.write();
        for (id, delta) in &output.textures_delta.set {
            for delta in delta {
                renderer.update_texture(device, queue, *id, delta);
            }
        }
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let buffers = renderer.update_buffers(device, queue, &mut encoder, &jobs, &screen);
        {
            let view = self.target.create_view(&wgpu::TextureViewDescriptor::default());
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("interface"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations::default(),
                })],
                ..wgpu::RenderPassDescriptor::default()
            });
            renderer.render(&mut pass.forget_lifetime(), &jobs, &screen);
        }
        queue.submit(buffers.into_iter().chain([encoder.finish()]));
        for id in &output.textures_delta.free {
            renderer.free_texture(id);
        }
        output.textures_delta.clear();
    }
}
