// The light of crates/enfilade_draw/src/light.rs: a sun, an ambient sky, and a little from the eye. It depends on the
// normal alone, so it is worked out once for each face, at its first corner.

struct Lens {
    clip_from_relative: mat4x4f,
    back: vec4f,
    sky_corner: vec4f,
    sky_right: vec4f,
    sky_down: vec4f,
}

@group(0) @binding(0) var<uniform> lens: Lens;

const SUN = vec3f(0.424, 0.755, 0.5);
const SUNLIGHT = vec3f(0.58, 0.53, 0.45);
const ZENITH = vec3f(0.36, 0.40, 0.48);
const GROUND = vec3f(0.20, 0.18, 0.16);
const FROM_THE_EYE = 0.22;

struct Corner {
    @location(0) position: vec3f,
    @location(1) normal: vec4f,
    @location(2) color: vec4f,
    // Rows of the matrix that puts it where it is, relative to the eye.
    @location(3) x: vec4f,
    @location(4) y: vec4f,
    @location(5) z: vec4f,
}

struct Shaded {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat, first) color: vec4f,
}

// Linear light as sRGB. The card can do it, too, but for each sample: with this driver that
// costs several milliseconds a picture.
fn encoded(linear: vec3f) -> vec3f {
    let light = clamp(linear, vec3f(0.0), vec3f(1.0));
    return select(1.055 * pow(light, vec3f(1.0 / 2.4)) - 0.055, 12.92 * light, light <= vec3f(0.0031308));
}

fn shaded(corner: Corner) -> Shaded {
    let at = vec4f(corner.position, 1.0);
    let relative = vec3f(dot(corner.x, at), dot(corner.y, at), dot(corner.z, at));
    // Columns of the matrix that turns normals from the right: right for places that stretch, too.
    let x = corner.x.xyz;
    let y = corner.y.xyz;
    let z = corner.z.xyz;
    var upright = normalize(corner.normal.xyz * mat3x3f(cross(y, z), cross(z, x), cross(x, y)));
    if dot(relative, upright) > 0.0 {
        upright = -upright;
    }
    let ambient = mix(GROUND, ZENITH, 0.5 + 0.5 * upright.y);
    let light = ambient + SUNLIGHT * max(dot(upright, SUN), 0.0) + FROM_THE_EYE * abs(dot(upright, lens.back.xyz));
    return Shaded(lens.clip_from_relative * vec4f(relative, 1.0), vec4f(corner.color.rgb * light, corner.color.a));
}

@vertex
fn opaque(corner: Corner) -> Shaded {
    let face = shaded(corner);
    return Shaded(face.position, vec4f(encoded(face.color.rgb), 1.0));
}

// Glass is blended as light, so it stays linear and the card encodes it.
@vertex
fn glass(corner: Corner) -> Shaded {
    return shaded(corner);
}

@fragment
fn painted(face: Shaded) -> @location(0) vec4f {
    return face.color;
}

// One triangle around the screen, infinitely far away.
@vertex
fn everywhere(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4f {
    let at = vec2f(f32(corner & 1u), f32(corner >> 1u)) * 4.0 - 1.0;
    return vec4f(at, 0.0, 1.0);
}

@fragment
fn sky(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let direction = lens.sky_corner.xyz + lens.sky_right.xyz * at.x + lens.sky_down.xyz * at.y;
    let up = normalize(direction).y;
    let horizon = vec3f(0.78, 0.84, 0.90);
    let above = mix(horizon, vec3f(0.18, 0.36, 0.68), sqrt(max(up, 0.0)));
    let below = mix(horizon, vec3f(0.28, 0.27, 0.26), min(-3.0 * up, 1.0));
    return vec4f(encoded(select(below, above, up >= 0.0)), 1.0);
}
