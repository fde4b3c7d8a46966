//! The renderer: buffers, bind groups and the render pass.

use crate::materials::Materials;
use crate::meshes::Meshes;
use crate::pipelines::{Formats, Pipelines, SHADOW_FORMAT};
use crate::plan::{Frame, ItemDraw, LIGHT_COLUMNS, OpeningStep, PassageBits, PlacedItem, Plan, Step, Store};
use bytemuck::{Pod, Zeroable};
use enfilade::View;
use glam::DVec3;
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, Device, Queue, RenderPass,
    TextureFormat, TextureView,
};

/// Draws visible sets with wgpu.
///
/// Meshes and textures are uploaded when they are first visible, and stay. Keep one renderer per scene and target format;
/// several views may share it, one after another.
#[doc(alias = "wgpu")]
pub struct Renderer {
    device: Device,
    queue: Queue,
    options: RendererOptions,
    depth_format: TextureFormat,
    meshes: Meshes,
    materials: Materials,
    pipelines: Pipelines,
    frame_layout: BindGroupLayout,
    shadow_layout: BindGroupLayout,
    shadows: ShadowMaps,
    buffers: Option<Buffers>,
    targets: Option<Targets>,
    plan: Plan,
}

/// Options of a [`Renderer`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct RendererOptions {
    /// Format of the texture to draw on. Without `Srgb` in its name the shader encodes colours, and glass is blended in sRGB
    /// instead of linearly.
    pub format: TextureFormat,
    /// Samples per pixel: 1, or 4 for antialiased edges.
    pub samples: u32,
}

/// What one picture took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct DrawStats {
    /// Draw calls, those of openings included.
    pub draw_calls: u32,
    /// Draw calls of items.
    pub item_draw_calls: u32,
    /// Triangles of items.
    pub triangles: u64,
    /// Passages that were drawn, those of shadow maps not included.
    pub passages: u32,
    /// Whether all passages of the set were drawn: the stencil buffer counts up to 255 openings in a row.
    pub complete: bool,
}

/// Buffers of the last frame, and the bind group that refers to them.
struct Buffers {
    frame: Buffer,
    passages: Buffer,
    instances: Buffer,
    triangles: Buffer,
    lights: wgpu::Texture,
    group: BindGroup,
}

/// What is drawn on besides the caller's texture.
struct Targets {
    size: [u32; 2],
    depth: TextureView,
    /// With several samples per pixel.
    color: Option<TextureView>,
}

/// Depths that a sun sees, a layer for each of its views.
struct ShadowMaps {
    layers: Vec<TextureView>,
    side: u32,
    group: BindGroup,
}

impl ShadowMaps {
    fn new(device: &Device, layout: &BindGroupLayout, side: u32, layers: u32) -> ShadowMaps {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shadows"),
            size: wgpu::Extent3d {
                width: side,
                height: side,
                depth_or_array_layers: layers.max(1),
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: SHADOW_FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let view = |first: u32, dimension, count| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(dimension),
                base_array_layer: first,
                array_layer_count: Some(count),
                ..wgpu::TextureViewDescriptor::default()
            })
        };
        let all = view(0, wgpu::TextureViewDimension::D2Array, layers.max(1));
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            // Lit where the caster is not nearer to the sun.
            compare: Some(wgpu::CompareFunction::GreaterEqual),
            ..wgpu::SamplerDescriptor::default()
        });
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        ShadowMaps {
            layers: (0..layers)
                .map(|layer| view(layer, wgpu::TextureViewDimension::D2, 1))
                .collect(),
            side,
            group: device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("shadows"),
                layout,
                entries: &[
                    entry(0, wgpu::BindingResource::TextureView(&all)),
                    entry(1, wgpu::BindingResource::Sampler(&sampler)),
                ],
            }),
        }
    }

    fn fits(&self, side: u32, layers: u32) -> bool {
        layers == 0 || (self.side == side && self.layers.len() as u32 >= layers)
    }
}

/// A view in the shader's layout. The fields are documented there.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct FrameBits {
    sky: [[f32; 4]; 3],
    origin: [f32; 4],
}

impl Default for RendererOptions {
    fn default() -> RendererOptions {
        RendererOptions {
            format: TextureFormat::Rgba8UnormSrgb,
            samples: 1,
        }
    }
}

impl Renderer {
    /// Creates a renderer. The device needs no feature, but with `DEPTH32FLOAT_STENCIL8` depths are more exact.
    pub fn new(device: &Device, queue: &Queue, options: RendererOptions) -> Renderer {
        let depth_format = match device.features().contains(wgpu::Features::DEPTH32FLOAT_STENCIL8) {
            true => TextureFormat::Depth32FloatStencil8,
            false => TextureFormat::Depth24PlusStencil8,
        };
        let materials = Materials::new(device, queue);
        let frame_layout = frame_layout(device);
        let shadow_layout = shadow_layout(device);
        let formats = Formats {
            color: options.format,
            depth: depth_format,
            samples: options.samples,
        };
        Renderer {
            pipelines: Pipelines::new(
                device,
                formats,
                [&frame_layout, materials.layout(), &shadow_layout],
            ),
            shadows: ShadowMaps::new(device, &shadow_layout, 1, 1),
            shadow_layout,
            device: device.clone(),
            queue: queue.clone(),
            options,
            depth_format,
            meshes: Meshes::default(),
            materials,
            frame_layout,
            buffers: None,
            targets: None,
            plan: Plan::default(),
        }
    }

    /// Records a picture on `target`, whose format is that of the options: sky, items and openings of all passages, in one
    /// render pass, after one for each shadow map.
    ///
    /// The parts of the target beside the view's viewport are cleared.
    pub fn draw(&mut self, encoder: &mut CommandEncoder, target: &TextureView, frame: &Frame) -> DrawStats {
        let mut store = Store {
            device: &self.device,
            queue: &self.queue,
            meshes: &mut self.meshes,
            materials: &mut self.materials,
        };
        self.plan.make(*frame, &mut store);
        self.finish(encoder, target, frame)
    }

    /// Records a picture of items at places of their own, in daylight: a scene from outside, with all rooms at once. The
    /// view is one in the space that they are mapped to, `frame.visible` the set that their entries are from.
    pub fn draw_placed(
        &mut self,
        encoder: &mut CommandEncoder,
        target: &TextureView,
        frame: &Frame,
        items: &[PlacedItem],
    ) -> DrawStats {
        let mut store = Store {
            device: &self.device,
            queue: &self.queue,
            meshes: &mut self.meshes,
            materials: &mut self.materials,
        };
        self.plan.make_placed(*frame, items, &mut store);
        self.finish(encoder, target, frame)
    }

    fn finish(&mut self, encoder: &mut CommandEncoder, target: &TextureView, frame: &Frame) -> DrawStats {
        self.upload(frame.view);
        let size = target.texture().size();
        self.fit_targets([size.width, size.height]);
        let views = frame.sun.map_or(&[][..], |(_, views)| views);
        let side = views.first().map_or(1, |view| view.view.size()[0]);
        if !self.shadows.fits(side, views.len() as u32) {
            self.shadows = ShadowMaps::new(&self.device, &self.shadow_layout, side, views.len() as u32);
        }
        let mut stats = DrawStats::default();
        for (steps, map) in self.plan.shadow_steps.iter().zip(&self.shadows.layers) {
            self.record_shadows(encoder, steps, map, &mut stats);
        }
        self.record(encoder, target, frame.view, stats)
    }

    /// Returns the bytes of meshes and textures on the GPU.
    pub fn bytes(&self) -> u64 {
        self.meshes.bytes() + self.materials.bytes()
    }

    /// Writes the plan to buffers, larger ones if needed.
    fn upload(&mut self, view: &View) {
        let plan = &self.plan;
        let rows = plan.lights.len().div_ceil(LIGHT_COLUMNS).max(1) as u32;
        let passages: &[u8] = bytemuck::cast_slice(&plan.passages);
        let instances: &[u8] = bytemuck::cast_slice(&plan.instances);
        let triangles: &[u8] = bytemuck::cast_slice(&plan.triangles);
        let fits = |buffers: &Buffers| {
            buffers.passages.size() >= passages.len() as u64
                && buffers.instances.size() >= instances.len() as u64
                && buffers.triangles.size() >= triangles.len() as u64
                && buffers.lights.height() >= rows
        };
        if !self.buffers.as_ref().is_some_and(fits) {
            let sizes = [passages.len(), instances.len(), triangles.len()];
            self.buffers = Some(Buffers::new(&self.device, &self.frame_layout, sizes, rows));
        }
        let Some(buffers) = &self.buffers else { return };
        let write = |buffer: &Buffer, bytes: &[u8]| {
            if !bytes.is_empty() {
                self.queue.write_buffer(buffer, 0, bytes);
            }
        };
        write(&buffers.frame, bytemuck::bytes_of(&FrameBits::new(view)));
        write(&buffers.passages, passages);
        write(&buffers.instances, instances);
        write(&buffers.triangles, triangles);
        if !plan.lights.is_empty() {
            let mut texels = plan.lights.clone();
            texels.resize(rows as usize * LIGHT_COLUMNS, [0.0; 4]);
            self.queue.write_texture(
                buffers.lights.as_image_copy(),
                bytemuck::cast_slice(&texels),
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(16 * LIGHT_COLUMNS as u32),
                    rows_per_image: None,
                },
                wgpu::Extent3d {
                    width: LIGHT_COLUMNS as u32,
                    height: rows,
                    depth_or_array_layers: 1,
                },
            );
        }
        let mut kinds: Vec<_> = Vec::new();
        let mut openings: Vec<_> = Vec::new();
        for step in plan.shadow_steps.iter().flatten().chain(&plan.steps) {
            match step {
                Step::Items(draw) => kinds.push(draw.kind),
                Step::Opening(step, _) => openings.push(*step),
                Step::Passage { .. } => {}
            }
        }
        kinds.sort_unstable();
        kinds.dedup();
        self.pipelines.prepare(&self.device, &kinds, &openings);
    }

    fn fit_targets(&mut self, size: [u32; 2]) {
        if self.targets.as_ref().is_some_and(|targets| targets.size == size) {
            return;
        }
        let texture = |label, format| {
            let texture = self.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d {
                    width: size[0],
                    height: size[1],
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: self.options.samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        self.targets = Some(Targets {
            size,
            depth: texture("depth", self.depth_format),
            color: (self.options.samples > 1).then(|| texture("samples", self.options.format)),
        });
    }

    fn record_shadows(
        &self,
        encoder: &mut CommandEncoder,
        steps: &[Step],
        map: &TextureView,
        stats: &mut DrawStats,
    ) {
        let Some(buffers) = &self.buffers else { return };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("enfilade shadows"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: map,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        });
        let mut state = State::default();
        for step in steps {
            match step {
                Step::Passage { number, .. } => {
                    let offset = number * size_of::<PassageBits>() as u32;
                    pass.set_bind_group(0, &buffers.group, &[offset]);
                }
                Step::Items(draw) => {
                    self.record_items(&mut pass, &mut state, buffers, draw);
                    stats.draw_calls += 1;
                }
                Step::Opening(..) => {}
            }
        }
    }

    fn record(
        &self,
        encoder: &mut CommandEncoder,
        target: &TextureView,
        view: &View,
        mut stats: DrawStats,
    ) -> DrawStats {
        stats.complete = self.plan.complete;
        let (Some(buffers), Some(targets)) = (&self.buffers, &self.targets) else {
            return stats;
        };
        let (view_to_draw, resolve_target) = match &targets.color {
            Some(samples) => (samples, Some(target)),
            None => (target, None),
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("enfilade"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: view_to_draw,
                depth_slice: None,
                resolve_target,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: match resolve_target {
                        Some(_) => wgpu::StoreOp::Discard,
                        None => wgpu::StoreOp::Store,
                    },
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0),
                    store: wgpu::StoreOp::Discard,
                }),
            }),
            ..wgpu::RenderPassDescriptor::default()
        });
        let viewport = view.viewport();
        let [x, y] = viewport.origin.map(|value| value as f32);
        let [width, height] = viewport.size.map(|value| value as f32);
        pass.set_viewport(x, y, width, height, 0.0, 1.0);
        pass.set_pipeline(self.pipelines.sky());
        pass.set_bind_group(0, &buffers.group, &[0]);
        pass.set_bind_group(2, &self.shadows.group, &[]);
        pass.set_stencil_reference(0);
        pass.draw(0..3, 0..1);
        stats.draw_calls += 1;
        let mut state = State::default();
        for step in &self.plan.steps {
            match step {
                Step::Passage {
                    number,
                    scissor: [x, y, width, height],
                    level,
                } => {
                    pass.set_scissor_rect(*x, *y, *width, *height);
                    let offset = number * size_of::<PassageBits>() as u32;
                    pass.set_bind_group(0, &buffers.group, &[offset]);
                    state.level = *level;
                }
                Step::Items(draw) => {
                    self.record_items(&mut pass, &mut state, buffers, draw);
                    let count = (draw.indices[1] - draw.indices[0]) / 3;
                    stats.item_draw_calls += 1;
                    stats.triangles += u64::from(count) * u64::from(draw.instances[1] - draw.instances[0]);
                }
                Step::Opening(step, triangles) => {
                    if triangles.is_empty() {
                        continue;
                    }
                    state.items = None;
                    let above = matches!(step, OpeningStep::Clear | OpeningStep::Lower);
                    pass.set_pipeline(self.pipelines.opening(*step));
                    pass.set_stencil_reference(state.level + u32::from(above));
                    pass.set_vertex_buffer(0, buffers.triangles.slice(..));
                    pass.draw(triangles.clone(), 0..1);
                    stats.draw_calls += 1;
                }
            }
        }
        stats.draw_calls += stats.item_draw_calls;
        stats.passages = self.plan.passages_drawn;
        stats
    }

    fn record_items(&self, pass: &mut RenderPass, state: &mut State, buffers: &Buffers, draw: &ItemDraw) {
        let last = state.items.as_ref();
        if last.is_none_or(|last| last.kind != draw.kind) {
            pass.set_pipeline(self.pipelines.item(draw.kind));
        }
        if state.items_level != Some(state.level) || last.is_none() {
            pass.set_stencil_reference(state.level);
            state.items_level = Some(state.level);
        }
        if last.is_none_or(|last| last.material != draw.material) {
            pass.set_bind_group(1, &self.materials.groups[draw.material as usize], &[]);
        }
        if last.is_none_or(|last| last.page != draw.page) {
            let page = &self.meshes.pages[draw.page as usize];
            pass.set_vertex_buffer(0, page.vertices.slice(..));
            pass.set_index_buffer(page.indices.slice(..), wgpu::IndexFormat::Uint32);
        }
        if last.is_none() {
            pass.set_vertex_buffer(1, buffers.instances.slice(..));
        }
        let [start, end] = draw.indices;
        pass.draw_indexed(start..end, 0, draw.instances[0]..draw.instances[1]);
        state.items = Some(draw.clone());
    }
}

/// What is set in the render pass.
#[derive(Default)]
struct State {
    level: u32,
    /// The level that the stencil reference was set for.
    items_level: Option<u32>,
    /// The last draw, if all of its state is still set.
    items: Option<ItemDraw>,
}

impl Buffers {
    fn new(device: &Device, layout: &BindGroupLayout, sizes: [usize; 3], light_rows: u32) -> Buffers {
        let buffer = |label, size: usize, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: size.next_power_of_two().max(1 << 12) as u64,
                usage: usage | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let [passages, instances, triangles] = sizes;
        let frame = buffer("frame", size_of::<FrameBits>(), BufferUsages::UNIFORM);
        let passages = buffer("passages", passages, BufferUsages::UNIFORM);
        let lights = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("lights"),
            size: wgpu::Extent3d {
                width: LIGHT_COLUMNS as u32,
                height: light_rows.next_power_of_two(),
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: TextureFormat::Rgba32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let lights_view = lights.create_view(&wgpu::TextureViewDescriptor::default());
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout,
            entries: &[
                entry(0, frame.as_entire_binding()),
                entry(
                    1,
                    wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                        buffer: &passages,
                        offset: 0,
                        size: wgpu::BufferSize::new(size_of::<PassageBits>() as u64),
                    }),
                ),
                entry(2, wgpu::BindingResource::TextureView(&lights_view)),
            ],
        });
        Buffers {
            frame,
            passages,
            instances: buffer("instances", instances, BufferUsages::VERTEX),
            triangles: buffer("openings", triangles, BufferUsages::VERTEX),
            lights,
            group,
        }
    }
}

impl FrameBits {
    fn new(view: &View) -> FrameBits {
        let [dx, dy] = [0, 1].map(|axis| f64::from(view.sample()[axis]) + View::GENERIC_OFFSET[axis]);
        let direction = |x: f64, y: f64| DVec3::from(view.ray([x + 0.5 + dx, y + 0.5 + dy])[1]);
        let corner = direction(0.0, 0.0);
        let steps = [corner, direction(1.0, 0.0) - corner, direction(0.0, 1.0) - corner];
        let [x, y] = view.viewport().origin.map(|value| value as f32);
        FrameBits {
            sky: steps.map(|step| step.as_vec3().extend(0.0).into()),
            origin: [x, y, 0.0, 0.0],
        }
    }
}

/// Returns the options for a device that the renderer likes: of the adapter's limits, and with more exact depths and clip
/// distances where there are. Both may be missing, as in WebGL2.
pub fn device_options(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    wgpu::DeviceDescriptor {
        label: Some("enfilade"),
        required_features: adapter.features()
            & (wgpu::Features::DEPTH32FLOAT_STENCIL8 | wgpu::Features::CLIP_DISTANCES),
        required_limits: adapter.limits(),
        ..wgpu::DeviceDescriptor::default()
    }
}

fn shadow_layout(device: &Device) -> BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty,
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("shadows"),
        entries: &[
            entry(
                0,
                wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Depth,
                    view_dimension: wgpu::TextureViewDimension::D2Array,
                    multisampled: false,
                },
            ),
            entry(
                1,
                wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison),
            ),
        ],
    })
}

fn frame_layout(device: &Device) -> BindGroupLayout {
    let entry = |binding, visibility, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty,
        count: None,
    };
    let uniform = |has_dynamic_offset, size: usize| wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset,
        min_binding_size: wgpu::BufferSize::new(size as u64),
    };
    let lights = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let both = wgpu::ShaderStages::VERTEX_FRAGMENT;
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("frame"),
        entries: &[
            entry(
                0,
                wgpu::ShaderStages::FRAGMENT,
                uniform(false, size_of::<FrameBits>()),
            ),
            entry(1, both, uniform(true, size_of::<PassageBits>())),
            entry(2, wgpu::ShaderStages::FRAGMENT, lights),
        ],
    })
}
