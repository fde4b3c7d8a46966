//! Render pipelines: one for each class of faces, and one for the sky.

use crate::plan::Instance;
use crate::stock::Class;
use crate::weld::Vertex;
use wgpu::{BindGroupLayout, Device, RenderPipeline, ShaderModule, TextureFormat, VertexBufferLayout};

/// Target of opaque faces: the shader encodes sRGB once per face.
pub(crate) const COLOR: TextureFormat = TextureFormat::Rgba8Unorm;
/// The same bytes as linear light, for blending glass.
pub(crate) const LIGHT: TextureFormat = TextureFormat::Rgba8UnormSrgb;
pub(crate) const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// All pipelines.
pub(crate) struct Pipelines {
    /// By [`Class::number`].
    pub(crate) faces: [RenderPipeline; Class::ALL.len()],
    pub(crate) sky: RenderPipeline,
}

impl Pipelines {
    pub(crate) fn new(device: &Device, lens: &BindGroupLayout) -> Pipelines {
        let shader = device.create_shader_module(wgpu::include_wgsl!("shader.wgsl"));
        let faces = Class::ALL.map(|class| {
            let options = PipelineOptions {
                entries: [if class.glass { "glass" } else { "opaque" }, "painted"],
                takes_vertices: true,
                culls_backs: !class.double_sided,
                glass: class.glass,
                writes_depth: !class.glass,
                // At equal depth the first face wins.
                passes: wgpu::CompareFunction::Greater,
            };
            options.build(device, &shader, lens)
        });
        let sky = PipelineOptions {
            entries: ["everywhere", "sky"],
            takes_vertices: false,
            culls_backs: false,
            glass: false,
            writes_depth: false,
            passes: wgpu::CompareFunction::Equal,
        };
        Pipelines {
            faces,
            sky: sky.build(device, &shader, lens),
        }
    }
}

/// Differences between pipelines.
struct PipelineOptions {
    /// Entry points of the vertex and the fragment shader.
    entries: [&'static str; 2],
    takes_vertices: bool,
    culls_backs: bool,
    /// Whether it blends over the target.
    glass: bool,
    writes_depth: bool,
    passes: wgpu::CompareFunction,
}

impl PipelineOptions {
    fn build(&self, device: &Device, shader: &ShaderModule, lens: &BindGroupLayout) -> RenderPipeline {
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(lens)],
            immediate_size: 0,
        });
        let buffers = [Some(vertices()), Some(instances())];
        let [vertex, sector] = self.entries;
        let target = wgpu::ColorTargetState {
            format: if self.glass { LIGHT } else { COLOR },
            blend: self.glass.then_some(wgpu::BlendState::ALPHA_BLENDING),
            write_mask: wgpu::ColorWrites::ALL,
        };
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(vertex),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: shader,
                entry_point: Some(vertex),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: if self.takes_vertices { &buffers } else { &[] },
            },
            primitive: wgpu::PrimitiveState {
                cull_mode: self.culls_backs.then_some(wgpu::Face::Back),
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(self.writes_depth),
                depth_compare: Some(self.passes),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: shader,
                entry_point: Some(sector),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(target)],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

fn vertices() -> VertexBufferLayout<'static> {
    const ATTRIBUTES: [wgpu::VertexAttribute; 3] =
        wgpu::vertex_attr_array![0 => Float32x3, 1 => Snorm16x4, 2 => Unorm16x4];
    VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &ATTRIBUTES,
    }
}

fn instances() -> VertexBufferLayout<'static> {
    const ATTRIBUTES: [wgpu::VertexAttribute; 3] =
        wgpu::vertex_attr_array![3 => Float32x4, 4 => Float32x4, 5 => Float32x4];
    VertexBufferLayout {
        array_stride: size_of::<Instance>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &ATTRIBUTES,
    }
}
