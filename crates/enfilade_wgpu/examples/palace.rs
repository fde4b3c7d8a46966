//! Draws the palace with an application's own device, and writes `palace.png`.
#![allow(clippy::print_stdout)]

use enfilade::Viewer;
use enfilade_draw::Stage;
use enfilade_wgpu::{Frame, Renderer, RendererOptions, device_options, read};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The application's own device and texture.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&device_options(&adapter)))?;
    let mut options = RendererOptions::default();
    options.samples = 4;
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: 1280,
            height: 720,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: options.format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    // Once per scene: its light and textures, and a renderer.
    let palace = enfilade_scenes::built_in("enfilade").ok_or("the palace is built in")?;
    let stage = Stage::new(&palace.scene);
    let mut renderer = Renderer::new(&device, &queue, options);
    let mut viewer = Viewer::new();
    // Each frame: look, and record what is visible.
    let view = palace.cameras[0].view([1280, 720])?;
    let visible = viewer.look(&palace.scene, &view);
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let on = target.create_view(&wgpu::TextureViewDescriptor::default());
    let stats = renderer.draw(
        &mut encoder,
        &on,
        &Frame::new(&palace.scene, &stage, &view, visible),
    );
    queue.submit([encoder.finish()]);
    println!("{stats:?}");
    read(&device, &queue, &target)?.save("palace.png")?;
    Ok(())
}
