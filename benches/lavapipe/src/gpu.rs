//! The `wgpu` renderer on a software Vulkan driver.

use crate::lens::Lens;
use crate::ours::Picture;
use crate::pipelines::{COLOR, DEPTH, LIGHT, Pipelines};
use crate::plan::{Draw, Instance, Plan};
use crate::stock::Stock;
use anyhow::{Context, Result};
use bytemuck::{Pod, Zeroable};
use wgpu::util::DeviceExt;
use wgpu::{
    Adapter, Backends, Buffer, BufferUsages, CommandEncoder, Device, LoadOp, Queue, RenderPass, Texture,
    TextureFormat, TextureUsages,
};

/// Error text if no software driver is found.
const NO_DRIVER: &str = "no software Vulkan driver found: install lavapipe, on Debian and Ubuntu by\n    \
    apt-get install --no-install-recommends mesa-vulkan-drivers libvulkan1\n\
    (`vulkaninfo --summary` of vulkan-tools should then list a device of type CPU)";

/// A device with its buffers and render targets.
pub(crate) struct Gpu {
    /// Name of the driver.
    pub(crate) name: String,
    device: Device,
    queue: Queue,
    pipelines: Pipelines,
    lens: Buffer,
    lens_group: wgpu::BindGroup,
    vertices: Buffer,
    indices: Buffer,
    instances: Buffer,
    size: [u32; 2],
    color: Texture,
    depth: Texture,
}

impl Gpu {
    /// # Errors
    /// If there is no software driver. Hardware adapters are not used instead.
    pub(crate) fn new(stock: &Stock, size: [u32; 2]) -> Result<Gpu> {
        let (name, adapter) = software_adapter()?;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            required_limits: adapter.limits(),
            ..wgpu::DeviceDescriptor::default()
        }))?;
        let lens = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("lens"),
            size: size_of::<LensBytes>() as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let (layout, lens_group) = lens_group(&device, &lens);
        let filled = |label, contents: &[u8], usage| {
            let label = Some(label);
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label,
                contents,
                usage,
            })
        };
        let texture = |format, views: &[TextureFormat], usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d {
                    width: size[0],
                    height: size[1],
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: views,
            })
        };
        Ok(Gpu {
            name,
            pipelines: Pipelines::new(&device, &layout),
            lens,
            lens_group,
            vertices: filled(
                "vertices",
                bytemuck::cast_slice(&stock.vertices),
                BufferUsages::VERTEX,
            ),
            indices: filled(
                "indices",
                bytemuck::cast_slice(&stock.indices),
                BufferUsages::INDEX,
            ),
            instances: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("instances"),
                // One for the world, one for each item, and another for each item that is also glass.
                size: ((1 + 2 * stock.items.len()) * size_of::<Instance>()) as u64,
                usage: BufferUsages::VERTEX | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            size,
            color: texture(
                COLOR,
                &[LIGHT],
                TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
            ),
            depth: texture(DEPTH, &[], TextureUsages::RENDER_ATTACHMENT),
            device,
            queue,
        })
    }

    /// Draws a picture, and waits until it is finished.
    pub(crate) fn draw(&self, plan: &Plan, lens: &Lens) -> Result<()> {
        self.queue
            .write_buffer(&self.lens, 0, bytemuck::bytes_of(&LensBytes::of(lens)));
        self.queue
            .write_buffer(&self.instances, 0, bytemuck::cast_slice(&plan.instances));
        let mut encoder = self
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = self.pass(&mut encoder, COLOR, true);
        self.record(&mut pass, plan.opaque.iter());
        pass.set_pipeline(&self.pipelines.sky);
        pass.draw(0..3, 0..1);
        drop(pass);
        if !plan.glass.is_empty() {
            let mut pass = self.pass(&mut encoder, LIGHT, false);
            self.record(&mut pass, plan.glass.iter().map(|(_, draw)| draw));
        }
        self.queue.submit([encoder.finish()]);
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(())
    }

    /// Begins a render pass on the picture, as bytes or as linear light; clears it if it is the first.
    fn pass<'a>(
        &self,
        encoder: &'a mut CommandEncoder,
        format: TextureFormat,
        first: bool,
    ) -> RenderPass<'a> {
        let color = self.color.create_view(&wgpu::TextureViewDescriptor {
            format: Some(format),
            ..wgpu::TextureViewDescriptor::default()
        });
        let depth = self.depth.create_view(&wgpu::TextureViewDescriptor::default());
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: None,
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &color,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: if first {
                        LoadOp::Clear(wgpu::Color::BLACK)
                    } else {
                        LoadOp::Load
                    },
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth,
                depth_ops: Some(wgpu::Operations {
                    load: if first { LoadOp::Clear(0.0) } else { LoadOp::Load },
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        })
    }

    fn record<'a>(&self, pass: &mut RenderPass, draws: impl Iterator<Item = &'a Draw>) {
        pass.set_bind_group(0, &self.lens_group, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_vertex_buffer(1, self.instances.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        let mut class = None;
        for draw in draws {
            if class.replace(draw.class) != Some(draw.class) {
                pass.set_pipeline(&self.pipelines.faces[draw.class.number()]);
            }
            pass.draw_indexed(draw.indices.clone(), 0, draw.instances.clone());
        }
    }

    /// Returns the last picture.
    pub(crate) fn picture(&self) -> Result<Picture> {
        let [width, height] = self.size;
        // Rows must be whole multiples of this.
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture"),
            size: u64::from(row) * u64::from(height),
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_buffer(
            self.color.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            self.color.size(),
        );
        self.queue.submit([encoder.finish()]);
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // An error means that the receiver is gone; then the result is not needed.
            let _ = sender.send(result);
        });
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        receiver
            .recv()
            .context("the driver did not finish copying the picture")??;
        let bytes = buffer.slice(..).get_mapped_range()?;
        let rows = bytes.chunks(row as usize);
        Ok(rows
            .flat_map(|row| {
                row[..4 * width as usize]
                    .chunks(4)
                    .flat_map(|pixel| pixel[..3].to_vec())
            })
            .collect())
    }
}

/// Returns the CPU driver with its name.
fn software_adapter() -> Result<(String, Adapter)> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: Backends::VULKAN,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let adapters = pollster::block_on(instance.enumerate_adapters(Backends::VULKAN));
    let found = adapters.into_iter().map(|adapter| (adapter.get_info(), adapter));
    let (info, adapter) = found
        .into_iter()
        .find(|(info, _)| info.device_type == wgpu::DeviceType::Cpu)
        .context(NO_DRIVER)?;
    Ok((format!("{}, {}", info.name, info.driver_info), adapter))
}

fn lens_group(device: &Device, lens: &Buffer) -> (wgpu::BindGroupLayout, wgpu::BindGroup) {
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("lens"),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        }],
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("lens"),
        layout: &layout,
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: lens.as_entire_binding(),
        }],
    });
    (layout, group)
}

/// A lens in the shader's layout.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct LensBytes {
    clip_from_relative: [[f32; 4]; 4],
    back: [f32; 4],
    sky: [[f32; 4]; 3],
}

impl LensBytes {
    fn of(lens: &Lens) -> LensBytes {
        LensBytes {
            clip_from_relative: lens.clip_from_relative.to_cols_array_2d(),
            back: lens.back.as_vec3().extend(0.0).into(),
            sky: lens.sky.map(|v| v.extend(0.0).into()),
        }
    }
}
