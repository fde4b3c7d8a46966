//! Materials on the GPU: a bind group each, uploaded when they are first drawn.

use bytemuck::{Pod, Zeroable};
use enfilade::{Alpha, Filter, Geometry, Material, Texture, TextureId, Wrap};
use enfilade_draw::Stage;
use std::collections::HashMap;
use std::sync::Arc;
use wgpu::util::DeviceExt;
use wgpu::{BindGroup, BindGroupLayout, Device, Queue, Sampler, TextureView};

/// A material in the shader's layout.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Pod, Zeroable)]
#[repr(C)]
struct MaterialBits([u32; 12]);

/// What tells two bind groups apart.
#[derive(PartialEq, Eq, Hash)]
struct Key {
    bits: MaterialBits,
    /// Addresses of the textures; 0 for none.
    textures: [usize; 2],
}

/// All materials and textures that have been drawn.
pub(crate) struct Materials {
    pub(crate) groups: Vec<BindGroup>,
    by_key: HashMap<Key, u32>,
    textures: HashMap<usize, Image>,
    layout: BindGroupLayout,
    white: [Image; 1],
    max_side: u32,
}

struct Image {
    view: TextureView,
    sampler: Sampler,
    bytes: u64,
    /// Keeps the address from being used by another texture.
    _texture: Option<Arc<Texture>>,
}

impl Materials {
    pub(crate) fn new(device: &Device, queue: &Queue) -> Materials {
        let white = Image::new(device, queue, &[([1, 1], &[[255; 4]])], None);
        Materials {
            groups: Vec::new(),
            by_key: HashMap::new(),
            textures: HashMap::new(),
            layout: layout(device),
            white: [white],
            max_side: device.limits().max_texture_dimension_2d,
        }
    }

    pub(crate) fn layout(&self) -> &BindGroupLayout {
        &self.layout
    }

    /// Returns the bytes of textures on the GPU.
    pub(crate) fn bytes(&self) -> u64 {
        self.textures.values().map(|image| image.bytes).sum()
    }

    /// Returns the index of a material's bind group, uploaded if it is new. Meshes without texture coordinates show no
    /// textures.
    pub(crate) fn get(
        &mut self,
        (device, queue): (&Device, &Queue),
        (geometry, stage): (&Geometry, &Stage),
        material: &Material,
        has_uv: bool,
    ) -> u32 {
        let of = |id: Option<TextureId>| geometry.textures().get(id.filter(|_| has_uv)?.0 as usize);
        let textures = [of(material.texture), of(material.emission_texture)];
        let key = Key {
            bits: bits(material),
            textures: textures.map(|texture| texture.map_or(0, |texture| Arc::as_ptr(texture).addr())),
        };
        if let Some(&number) = self.by_key.get(&key) {
            return number;
        }
        for texture in textures.into_iter().flatten() {
            let address = Arc::as_ptr(texture).addr();
            let max_side = self.max_side;
            self.textures.entry(address).or_insert_with(|| {
                let texels = [(texture.size(), texture.texels())];
                let levels: Vec<_> = match stage.mip_levels(texture) {
                    Some(levels) => levels.collect(),
                    None => texels.to_vec(),
                };
                // Levels too large for the device are left out, unless there is no other.
                let fits = |level: &&([u32; 2], _)| level.0[0].max(level.0[1]) > max_side;
                let first = levels.iter().take_while(fits).count().min(levels.len() - 1);
                Image::new(device, queue, &levels[first..], Some(texture))
            });
        }
        let image = |number: usize| match key.textures[number] {
            0 => &self.white[0],
            address => &self.textures[&address],
        };
        let uniform = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("material"),
            contents: bytemuck::bytes_of(&key.bits),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("material"),
            layout: &self.layout,
            entries: &[
                entry(0, uniform.as_entire_binding()),
                entry(1, wgpu::BindingResource::TextureView(&image(0).view)),
                entry(2, wgpu::BindingResource::Sampler(&image(0).sampler)),
                entry(3, wgpu::BindingResource::TextureView(&image(1).view)),
                entry(4, wgpu::BindingResource::Sampler(&image(1).sampler)),
            ],
        });
        let number = self.groups.len() as u32;
        self.groups.push(group);
        self.by_key.insert(key, number);
        number
    }
}

fn bits(material: &Material) -> MaterialBits {
    let [r, g, b, a] = material.base_color;
    let [er, eg, eb] = material.emission;
    let alpha = match material.alpha {
        Alpha::Opaque => 0.0,
        Alpha::Mask => 1.0,
        Alpha::Blend => 2.0,
    };
    let unlit = if material.unlit { 1.0 } else { 0.0 };
    let values = [r, g, b, a, er, eg, eb, material.cutoff, unlit, alpha, 0.0, 0.0];
    MaterialBits(values.map(f32::to_bits))
}

impl Image {
    /// Uploads a texture, from its largest level down.
    fn new(
        device: &Device,
        queue: &Queue,
        levels: &[([u32; 2], &[[u8; 4]])],
        texture: Option<&Arc<Texture>>,
    ) -> Image {
        let ([width, height], _) = levels[0];
        let made = device.create_texture(&wgpu::TextureDescriptor {
            label: texture.map(|texture| texture.name.as_str()),
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
            mip_level_count: levels.len() as u32,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8UnormSrgb,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        for (level, &([width, height], texels)) in (0..).zip(levels) {
            queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    mip_level: level,
                    ..made.as_image_copy()
                },
                bytemuck::cast_slice(texels),
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(4 * width),
                    rows_per_image: None,
                },
                wgpu::Extent3d {
                    width,
                    height,
                    depth_or_array_layers: 1,
                },
            );
        }
        Image {
            view: made.create_view(&wgpu::TextureViewDescriptor::default()),
            sampler: sampler(device, texture.map(|texture| &**texture)),
            bytes: levels.iter().map(|(_, texels)| 4 * texels.len() as u64).sum(),
            _texture: texture.cloned(),
        }
    }
}

fn sampler(device: &Device, texture: Option<&Texture>) -> Sampler {
    let wrap = |axis: usize| match texture.map(|texture| texture.wrap[axis]) {
        None | Some(Wrap::Repeat) => wgpu::AddressMode::Repeat,
        Some(Wrap::Mirror) => wgpu::AddressMode::MirrorRepeat,
        Some(Wrap::Clamp) => wgpu::AddressMode::ClampToEdge,
    };
    let filter = |filter: Option<Filter>| match filter {
        Some(Filter::Linear) => wgpu::FilterMode::Linear,
        _ => wgpu::FilterMode::Nearest,
    };
    let between = texture.and_then(|texture| texture.minify.levels);
    device.create_sampler(&wgpu::SamplerDescriptor {
        address_mode_u: wrap(0),
        address_mode_v: wrap(1),
        mag_filter: filter(texture.map(|texture| texture.magnify)),
        min_filter: filter(texture.map(|texture| texture.minify.texels)),
        mipmap_filter: match between {
            Some(Filter::Linear) => wgpu::MipmapFilterMode::Linear,
            _ => wgpu::MipmapFilterMode::Nearest,
        },
        ..wgpu::SamplerDescriptor::default()
    })
}

fn layout(device: &Device) -> BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty,
        count: None,
    };
    let image = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    let uniform = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("material"),
        entries: &[
            entry(0, uniform),
            entry(1, image),
            entry(2, sampler),
            entry(3, image),
            entry(4, sampler),
        ],
    })
}
