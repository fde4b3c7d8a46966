// The vertex shader of items behind a clip plane, on devices with clip distances. It follows `shader.wgsl` in one module.

struct ClippedFragment {
    @invariant @builtin(position) clip: vec4f,
    @builtin(clip_distances) distances: array<f32, 1>,
    @location(0) eye: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) color: vec4f,
}

@vertex
fn clipped_item(in: Corner) -> ClippedFragment {
    let whole = placed(in);
    var out: ClippedFragment;
    out.clip = whole.clip;
    out.distances[0] = dot(passage.entry, vec4f(whole.eye, 1.0));
    out.eye = whole.eye;
    out.normal = whole.normal;
    out.uv = whole.uv;
    out.color = whole.color;
    return out;
}
