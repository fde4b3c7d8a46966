//! A device without a window, and pictures read back from it.

use crate::plan::Frame;
use crate::renderer::{DrawStats, Renderer, RendererOptions, device_options};
use image::RgbaImage;
use thiserror::Error;
use wgpu::{Adapter, Device, Queue, Texture, TextureFormat};

/// A device without a window.
#[derive(Clone, Debug)]
pub struct HeadlessDevice {
    /// The adapter.
    pub adapter: Adapter,
    /// The device.
    pub device: Device,
    /// Its queue.
    pub queue: Queue,
}

/// A device without a window, and a renderer on it.
#[doc(alias = "offscreen")]
pub struct Headless {
    /// The device.
    pub gpu: HeadlessDevice,
    /// The renderer.
    pub renderer: Renderer,
    target: Option<Texture>,
}

/// Why there is no device or no picture.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum HeadlessError {
    /// No adapter was found.
    #[error(
        "no graphics adapter found; on Debian or Ubuntu a software driver is installed by \
         `apt-get install mesa-vulkan-drivers libvulkan1`"
    )]
    NoAdapter,
    /// The adapter refused to make a device.
    #[error("the graphics adapter makes no device: {0}")]
    NoDevice(#[from] wgpu::RequestDeviceError),
    /// The device failed while a picture was made or read back.
    #[error("the graphics device failed: {0}")]
    Failed(String),
}

impl HeadlessDevice {
    /// Creates a device on the best adapter, software drivers included.
    ///
    /// # Errors
    /// [`HeadlessError::NoAdapter`] and [`HeadlessError::NoDevice`].
    pub fn new() -> Result<HeadlessDevice, HeadlessError> {
        pollster::block_on(async {
            // OpenGL only where there is nothing better.
            let mut adapters: Vec<Adapter> = Vec::new();
            for backends in [wgpu::Backends::PRIMARY, wgpu::Backends::GL] {
                let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
                    backends,
                    ..wgpu::InstanceDescriptor::new_without_display_handle()
                });
                adapters = instance.enumerate_adapters(backends).await;
                if !adapters.is_empty() {
                    break;
                }
            }
            let rank = |adapter: &Adapter| match adapter.get_info().device_type {
                wgpu::DeviceType::DiscreteGpu => 0,
                wgpu::DeviceType::IntegratedGpu => 1,
                wgpu::DeviceType::VirtualGpu => 2,
                wgpu::DeviceType::Cpu => 3,
                wgpu::DeviceType::Other => 4,
            };
            adapters.sort_by_key(rank);
            let adapter = adapters.into_iter().next().ok_or(HeadlessError::NoAdapter)?;
            let (device, queue) = adapter.request_device(&device_options(&adapter)).await?;
            Ok(HeadlessDevice {
                adapter,
                device,
                queue,
            })
        })
    }
}

impl Headless {
    /// Creates a device on the best adapter, software drivers included, and a renderer with 1 or 4 samples per pixel.
    ///
    /// # Errors
    /// As [`HeadlessDevice::new`].
    pub fn new(samples: u32) -> Result<Headless, HeadlessError> {
        Ok(Headless::on(HeadlessDevice::new()?, samples))
    }

    /// Creates a renderer with 1 or 4 samples per pixel on a device.
    pub fn on(gpu: HeadlessDevice, samples: u32) -> Headless {
        let options = RendererOptions {
            format: TextureFormat::Rgba8UnormSrgb,
            samples,
        };
        Headless {
            renderer: Renderer::new(&gpu.device, &gpu.queue, options),
            gpu,
            target: None,
        }
    }

    /// Records a picture without drawing it, to measure what that takes.
    pub fn encode(&mut self, frame: &Frame) -> DrawStats {
        let (target, commands, stats) = self.record(frame);
        drop(commands);
        self.target = Some(target);
        stats
    }

    /// Records a picture. Returns the target too, to be put back.
    fn record(&mut self, frame: &Frame) -> (Texture, wgpu::CommandBuffer, DrawStats) {
        let target = self.target(frame.view.size());
        let mut encoder = self
            .gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let on = target.create_view(&wgpu::TextureViewDescriptor::default());
        let stats = self.renderer.draw(&mut encoder, &on, frame);
        (target, encoder.finish(), stats)
    }

    /// Takes the target, or makes one of a size.
    fn target(&mut self, [width, height]: [u32; 2]) -> Texture {
        let fits = |target: &Texture| [target.width(), target.height()] == [width, height];
        self.target.take().filter(fits).unwrap_or_else(|| {
            self.gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("picture"),
                size: wgpu::Extent3d {
                    width,
                    height,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: TextureFormat::Rgba8UnormSrgb,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            })
        })
    }

    /// Draws a visible set, and waits for the picture. Its size is that of the view.
    ///
    /// # Errors
    /// [`HeadlessError::Failed`].
    pub fn draw(&mut self, frame: &Frame) -> Result<(RgbaImage, DrawStats), HeadlessError> {
        let (target, commands, stats) = self.record(frame);
        self.gpu.queue.submit([commands]);
        let picture = read(&self.gpu.device, &self.gpu.queue, &target)?;
        self.target = Some(target);
        Ok((picture, stats))
    }
}

/// Reads an RGBA texture of 8 bits a channel back.
///
/// # Errors
/// [`HeadlessError::Failed`].
pub fn read(device: &Device, queue: &Queue, texture: &Texture) -> Result<RgbaImage, HeadlessError> {
    let failed = |error: &dyn std::fmt::Display| HeadlessError::Failed(error.to_string());
    let [width, height] = [texture.width(), texture.height()];
    // Rows must be whole multiples of this.
    let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("picture"),
        size: u64::from(row) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row),
                rows_per_image: None,
            },
        },
        texture.size(),
    );
    queue.submit([encoder.finish()]);
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
        // An error means that the receiver is gone; then the result is not needed.
        let _ = sender.send(result);
    });
    device
        .poll(wgpu::PollType::wait_indefinitely())
        .map_err(|error| failed(&error))?;
    let mapped = receiver.recv().map_err(|error| failed(&error))?;
    mapped.map_err(|error| failed(&error))?;
    let bytes = buffer
        .slice(..)
        .get_mapped_range()
        .map_err(|error| failed(&error))?;
    let mut picture = RgbaImage::new(width, height);
    for (row, to) in bytes
        .chunks(row as usize)
        .zip(picture.chunks_exact_mut(4 * width as usize))
    {
        to.copy_from_slice(&row[..4 * width as usize]);
    }
    Ok(picture)
}
