//! Render pipelines, made when they are first needed.

use crate::meshes::{VERTEX_ATTRIBUTES, Vertex};
use crate::plan::{INSTANCE_ATTRIBUTES, Instance, OpeningStep};
use std::collections::HashMap;
use wgpu::{
    BindGroupLayout, CompareFunction, Device, RenderPipeline, ShaderModule, StencilFaceState,
    StencilOperation, TextureFormat, VertexBufferLayout,
};

/// What tells pipelines of items apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct ItemKind {
    pub(crate) pass: Pass,
    /// Whether the part before the entry plane is cut off.
    pub(crate) clips: bool,
    pub(crate) sides: Sides,
    /// Whether faces that are counter-clockwise in the item are clockwise on the screen.
    pub(crate) mirrored: bool,
}

/// What is drawn of items.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Pass {
    Opaque,
    Blended,
    /// Depths alone, on a shadow map.
    Depth,
}

/// Format of shadow maps.
pub(crate) const SHADOW_FORMAT: TextureFormat = TextureFormat::Depth32Float;

/// The sides of faces that are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Sides {
    Front,
    Back,
    Both,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Key {
    Item(ItemKind),
    Opening(OpeningStep),
    Sky,
}

/// Formats of what is drawn on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Formats {
    pub(crate) color: TextureFormat,
    pub(crate) depth: TextureFormat,
    pub(crate) samples: u32,
}

pub(crate) struct Pipelines {
    formats: Formats,
    shader: ShaderModule,
    /// Whether clip distances cut at the entry plane, rather than the fragment shader.
    has_clip_distances: bool,
    items: wgpu::PipelineLayout,
    casters: wgpu::PipelineLayout,
    openings: wgpu::PipelineLayout,
    made: HashMap<Key, RenderPipeline>,
}

/// Differences between pipelines.
struct Differences<'a> {
    layout: &'a wgpu::PipelineLayout,
    is_shadow: bool,
    entries: [&'static str; 2],
    buffers: &'a [Option<VertexBufferLayout<'a>>],
    front: wgpu::FrontFace,
    cull: Option<wgpu::Face>,
    /// Whether it writes colours, and whether it blends them.
    colors: [bool; 2],
    writes_depth: bool,
    depth: CompareFunction,
    stencil: StencilOperation,
    constants: &'a [(&'a str, f64)],
}

impl Pipelines {
    pub(crate) fn new(
        device: &Device,
        formats: Formats,
        [frame, material, shadows]: [&BindGroupLayout; 3],
    ) -> Pipelines {
        let layout = |groups: &[Option<&BindGroupLayout>]| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("enfilade"),
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        let has_clip_distances = device.features().contains(wgpu::Features::CLIP_DISTANCES);
        let source = match has_clip_distances {
            true => concat!(
                "enable clip_distances;\n",
                include_str!("shader.wgsl"),
                include_str!("clipped.wgsl")
            ),
            false => include_str!("shader.wgsl"),
        };
        Pipelines {
            formats,
            shader: device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("enfilade"),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            }),
            has_clip_distances,
            items: layout(&[Some(frame), Some(material), Some(shadows)]),
            casters: layout(&[Some(frame), Some(material)]),
            openings: layout(&[Some(frame)]),
            made: HashMap::new(),
        }
    }

    /// Makes the pipelines that a picture needs.
    pub(crate) fn prepare(&mut self, device: &Device, items: &[ItemKind], openings: &[OpeningStep]) {
        let keys = items.iter().map(|&kind| Key::Item(kind));
        let keys = keys.chain(openings.iter().map(|&step| Key::Opening(step)));
        for key in keys.chain([Key::Sky]) {
            if !self.made.contains_key(&key) {
                let pipeline = self.make(device, key);
                self.made.insert(key, pipeline);
            }
        }
    }

    pub(crate) fn item(&self, kind: ItemKind) -> &RenderPipeline {
        &self.made[&Key::Item(kind)]
    }

    pub(crate) fn opening(&self, step: OpeningStep) -> &RenderPipeline {
        &self.made[&Key::Opening(step)]
    }

    pub(crate) fn sky(&self) -> &RenderPipeline {
        &self.made[&Key::Sky]
    }

    fn make(&self, device: &Device, key: Key) -> RenderPipeline {
        const CORNERS: [wgpu::VertexAttribute; 1] = wgpu::vertex_attr_array![0 => Float32x4];
        let buffer = |stride, step_mode, attributes| {
            Some(VertexBufferLayout {
                array_stride: stride,
                step_mode,
                attributes,
            })
        };
        let items = [
            buffer(
                size_of::<Vertex>() as u64,
                wgpu::VertexStepMode::Vertex,
                &VERTEX_ATTRIBUTES[..],
            ),
            buffer(
                size_of::<Instance>() as u64,
                wgpu::VertexStepMode::Instance,
                &INSTANCE_ATTRIBUTES[..],
            ),
        ];
        let corners = [buffer(16, wgpu::VertexStepMode::Vertex, &CORNERS[..])];
        let encodes = ("encodes", f64::from(u8::from(!self.formats.color.is_srgb())));
        let keep = StencilOperation::Keep;
        let differences = match key {
            Key::Sky => Differences {
                layout: &self.openings,
                is_shadow: false,
                entries: ["everywhere", "sky"],
                buffers: &[],
                front: wgpu::FrontFace::Ccw,
                cull: None,
                colors: [true, false],
                writes_depth: false,
                depth: CompareFunction::Always,
                stencil: keep,
                constants: &[encodes],
            },
            Key::Item(kind) => Differences {
                layout: if kind.pass == Pass::Depth {
                    &self.casters
                } else {
                    &self.items
                },
                is_shadow: kind.pass == Pass::Depth,
                entries: [
                    if kind.clips && self.has_clip_distances {
                        "clipped_item"
                    } else {
                        "item"
                    },
                    if kind.pass == Pass::Depth {
                        "caster"
                    } else {
                        "shade"
                    },
                ],
                buffers: &items,
                front: if kind.mirrored {
                    wgpu::FrontFace::Cw
                } else {
                    wgpu::FrontFace::Ccw
                },
                cull: match kind.sides {
                    Sides::Front => Some(wgpu::Face::Back),
                    Sides::Back => Some(wgpu::Face::Front),
                    Sides::Both => None,
                },
                colors: [kind.pass != Pass::Depth, kind.pass == Pass::Blended],
                writes_depth: kind.pass != Pass::Blended,
                // At equal depth the first face wins.
                depth: CompareFunction::Greater,
                stencil: keep,
                constants: &[
                    encodes,
                    (
                        "discards",
                        f64::from(u8::from(kind.clips && !self.has_clip_distances)),
                    ),
                ],
            },
            Key::Opening(step) => Differences {
                layout: &self.openings,
                is_shadow: false,
                entries: match step {
                    OpeningStep::Clear => ["opening_far", "sky"],
                    OpeningStep::Closed => ["opening", "closed"],
                    _ => ["opening", "nothing"],
                },
                buffers: &corners,
                front: wgpu::FrontFace::Ccw,
                cull: None,
                colors: [matches!(step, OpeningStep::Clear | OpeningStep::Closed), false],
                writes_depth: step != OpeningStep::Raise,
                depth: match step {
                    OpeningStep::Depth | OpeningStep::Closed => CompareFunction::Greater,
                    OpeningStep::Raise => CompareFunction::Equal,
                    OpeningStep::Clear | OpeningStep::Lower => CompareFunction::Always,
                },
                stencil: match step {
                    OpeningStep::Raise => StencilOperation::IncrementClamp,
                    OpeningStep::Lower => StencilOperation::DecrementClamp,
                    _ => keep,
                },
                constants: &[encodes],
            },
        };
        self.build(device, &differences)
    }

    fn build(&self, device: &Device, of: &Differences) -> RenderPipeline {
        let target = wgpu::ColorTargetState {
            format: self.formats.color,
            blend: of.colors[1].then_some(wgpu::BlendState::ALPHA_BLENDING),
            write_mask: if of.colors[0] {
                wgpu::ColorWrites::COLOR
            } else {
                wgpu::ColorWrites::empty()
            },
        };
        let targets = [Some(target)];
        let face = StencilFaceState {
            compare: CompareFunction::Equal,
            fail_op: StencilOperation::Keep,
            depth_fail_op: StencilOperation::Keep,
            pass_op: of.stencil,
        };
        let options = wgpu::PipelineCompilationOptions {
            constants: of.constants,
            ..wgpu::PipelineCompilationOptions::default()
        };
        let [vertex, fragment] = of.entries;
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(vertex),
            layout: Some(of.layout),
            vertex: wgpu::VertexState {
                module: &self.shader,
                entry_point: Some(vertex),
                compilation_options: options.clone(),
                buffers: of.buffers,
            },
            primitive: wgpu::PrimitiveState {
                front_face: of.front,
                cull_mode: of.cull,
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: if of.is_shadow {
                    SHADOW_FORMAT
                } else {
                    self.formats.depth
                },
                depth_write_enabled: Some(of.writes_depth),
                depth_compare: Some(of.depth),
                stencil: match of.is_shadow {
                    true => wgpu::StencilState::default(),
                    false => wgpu::StencilState {
                        front: face,
                        back: face,
                        read_mask: 0xff,
                        write_mask: 0xff,
                    },
                },
                // Away from the light, where depth is less.
                bias: wgpu::DepthBiasState {
                    slope_scale: if of.is_shadow { -2.0 } else { 0.0 },
                    ..wgpu::DepthBiasState::default()
                },
            }),
            multisample: wgpu::MultisampleState {
                count: if of.is_shadow { 1 } else { self.formats.samples },
                ..wgpu::MultisampleState::default()
            },
            fragment: Some(wgpu::FragmentState {
                module: &self.shader,
                entry_point: Some(fragment),
                compilation_options: options,
                targets: if of.is_shadow { &[] } else { &targets },
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}
