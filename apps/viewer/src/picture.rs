//! Pictures that the interface shows: the scene on the GPU, and diagnostic pictures of the software renderer.

use crate::session::{LookKey, Session};
use eframe::egui::{self, TextureId, load::SizedTexture};
use eframe::egui_wgpu;
use eframe::wgpu;
use enfilade::{Light, LightId, LightShape, Scene, ShadowCasters, View, Viewer};
use enfilade_draw::{Exposure, Legend, Settings, Show};
use enfilade_wgpu::{DrawStats, Frame, Renderer, RendererOptions};
use std::sync::Arc;

/// The device, and the renderer of the interface.
#[derive(Clone)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Draws the interface.
    pub renderer: Arc<egui::mutex::RwLock<egui_wgpu::Renderer>>,
    /// Whether a texture can be seen as sRGB and as plain bytes, so that glass is blended linearly.
    pub has_view_formats: bool,
    /// Name of the adapter and its driver.
    pub adapter: String,
}

/// The picture of the scene, as large as its part of the window.
pub(crate) struct ScenePicture {
    renderer: Renderer,
    target: Option<Target>,
    samples: u32,
    /// Whether the first sun of the scene casts shadows.
    pub(crate) shadows: bool,
    casters: ShadowCasters,
}

struct Target {
    size: [u32; 2],
    view: wgpu::TextureView,
    id: TextureId,
}

impl ScenePicture {
    pub(crate) fn new(gpu: &Gpu, samples: u32) -> ScenePicture {
        let mut options = RendererOptions::default();
        options.format = format(gpu);
        options.samples = samples;
        let mut casters = ShadowCasters::new();
        casters.map_size = 2048;
        ScenePicture {
            renderer: Renderer::new(&gpu.device, &gpu.queue, options),
            target: None,
            samples,
            shadows: false,
            casters,
        }
    }

    pub(crate) fn samples(&self) -> u32 {
        self.samples
    }

    /// Returns the bytes of meshes and textures on the GPU.
    pub(crate) fn bytes(&self) -> u64 {
        self.renderer.bytes()
    }

    /// Draws what a session sees.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        session: &Session,
        view: &View,
        exposure: Exposure,
    ) -> (SizedTexture, DrawStats) {
        let size = view.size();
        if self.target.as_ref().is_none_or(|target| target.size != size) {
            let old = self.target.take().map(|target| target.id);
            self.target = Some(Target::new(gpu, size, old));
        }
        let target = self.target.as_ref().expect("it was just made");
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let (scene, stage) = (&session.world.scene, &session.world.stage);
        let mut frame = Frame::new(scene, stage, view, session.viewer.visible());
        frame.exposure = exposure;
        let stats = match &session.frozen {
            None => {
                if let Some(sun) = sun_of(scene).filter(|_| self.shadows) {
                    let ends = [6.0, 20.0, 60.0, f64::INFINITY];
                    self.casters.cascades = ends.map(|end| end * session.world.metre).to_vec();
                    frame.sun = Some((sun, self.casters.find(scene, sun, session.viewer.visible())));
                }
                self.renderer.draw(&mut encoder, &target.view, &frame)
            }
            Some(frozen) => self
                .renderer
                .draw_placed(&mut encoder, &target.view, &frame, &frozen.items),
        };
        gpu.queue.submit([encoder.finish()]);
        let [width, height] = size.map(|side| side as f32);
        (SizedTexture::new(target.id, [width, height]), stats)
    }
}

impl Target {
    fn new(gpu: &Gpu, [width, height]: [u32; 2], old: Option<TextureId>) -> Target {
        let bytes = wgpu::TextureFormat::Rgba8Unorm;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("scene"),
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: format(gpu),
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: if gpu.has_view_formats {
                &[wgpu::TextureFormat::Rgba8Unorm]
            } else {
                &[]
            },
        });
        // The interface works with sRGB bytes.
        let shown = texture.create_view(&wgpu::TextureViewDescriptor {
            format: Some(bytes),
            ..wgpu::TextureViewDescriptor::default()
        });
        let mut renderer = gpu.renderer.write();
        if let Some(old) = old {
            renderer.free_texture(&old);
        }
        Target {
            size: [width, height],
            view: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            id: renderer.register_native_texture(&gpu.device, &shown, wgpu::FilterMode::Nearest),
        }
    }
}

/// Returns the first sun of a scene.
pub(crate) fn sun_of(scene: &Scene) -> Option<LightId> {
    let is_sun = |light: &Light| matches!(light.shape, LightShape::Sun { .. });
    scene
        .lights()
        .iter()
        .position(is_sun)
        .map(|number| LightId(number as u32))
}

fn format(gpu: &Gpu) -> wgpu::TextureFormat {
    match gpu.has_view_formats {
        true => wgpu::TextureFormat::Rgba8UnormSrgb,
        false => wgpu::TextureFormat::Rgba8Unorm,
    }
}

/// A diagnostic picture of the view of the last look.
pub(crate) struct Diagnostic {
    pub(crate) show: Show,
    viewer: Viewer,
    texture: Option<egui::TextureHandle>,
    /// What the picture is of, and its width.
    of: Option<(LookKey, u32)>,
}

impl Diagnostic {
    pub(crate) fn new(show: Show) -> Diagnostic {
        Diagnostic {
            show,
            viewer: Viewer::new(),
            texture: None,
            of: None,
        }
    }

    /// Returns the picture of what a session sees, some pixels wide, above its legend.
    pub(crate) fn draw(&mut self, context: &egui::Context, session: &Session, width: u32) -> SizedTexture {
        let [columns, rows] = session.view.size();
        let size = [width, (width * rows).div_ceil(columns).max(1)];
        if self.of != Some((session.key(), width)) || self.texture.is_none() {
            self.of = Some((session.key(), width));
            let camera = match &session.frozen {
                Some(frozen) => frozen.walker.camera(&session.world.scene),
                None => session.walker.camera(&session.world.scene),
            };
            self.viewer.options = session.viewer.options;
            let mut settings = Settings::default();
            settings.show = self.show;
            let picture = match camera.view(size) {
                Ok(view) => {
                    let world = &session.world;
                    let drawn = world.stage.draw(&mut self.viewer, &world.scene, &view, &settings);
                    match Legend::new(self.show, &world.scene, self.viewer.visible()) {
                        Some(legend) => legend.below(drawn.image),
                        None => drawn.image,
                    }
                }
                Err(_) => enfilade_draw::RgbImage::new(size[0], size[1]),
            };
            let size = [picture.width() as usize, picture.height() as usize];
            let image = egui::ColorImage::from_rgb(size, picture.as_raw());
            match &mut self.texture {
                Some(texture) => texture.set(image, egui::TextureOptions::NEAREST),
                None => {
                    let made = context.load_texture("diagnostic", image, egui::TextureOptions::NEAREST);
                    self.texture = Some(made);
                }
            }
        }
        let texture = self.texture.as_ref().expect("it was just made");
        SizedTexture::new(texture.id(), texture.size_vec2())
    }
}
