// Shades items, openings and the sky. The lighting is that of `enfilade_draw` (`Stage::lighting`).
//
// Positions in `p` are relative to the eye, in the space of the passage's sector.

// Whether fragments in front of the entry plane are discarded: where there are no clip distances.
override discards: bool = false;
// Whether the target stores linear values, so that the shader encodes sRGB.
override encodes: bool = false;

struct Frame {
    // Ray through pixel (0, 0) of the viewport, in the space of the eye's sector, and its steps per column and row.
    sky_corner: vec4f,
    sky_right: vec4f,
    sky_down: vec4f,
    // Left top corner of the viewport in the target, in pixels.
    origin: vec4f,
}

struct Passage {
    clip_from_eye: mat4x4f,
    // Rows of the linear part of the map from eye space to the sector.
    sector_x: vec4f, // w: exposure
    sector_y: vec4f, // w: 1 if bright values are compressed
    sector_z: vec4f, // w: light from the eye
    // Entry plane in eye space.
    entry: vec4f,
    // Unit direction against the view direction, in the space of the sector.
    back: vec4f, // w: 1 if the view is parallel
    above: vec4f, // w: first texel of the lights
    below: vec4f, // w: number of lights
    sun: vec4f,
    to_sun: vec4f,
    // Direction of the rays of a parallel view.
    ahead: vec4f,
}

struct Material {
    color: vec4f,
    emission: vec4f, // w: alpha cutoff
    flags: vec4f, // x: 1 if unlit, y: 0 opaque, 1 alpha-tested, 2 alpha-blended
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> passage: Passage;
@group(0) @binding(2) var lights: texture_2d<f32>;
@group(1) @binding(0) var<uniform> material: Material;
@group(1) @binding(1) var color_texture: texture_2d<f32>;
@group(1) @binding(2) var color_sampler: sampler;
@group(1) @binding(3) var glow_texture: texture_2d<f32>;
@group(1) @binding(4) var glow_sampler: sampler;

@group(2) @binding(0) var shadow_maps: texture_depth_2d_array;
@group(2) @binding(1) var shadow_sampler: sampler_comparison;

struct Corner {
    @location(0) position: vec3f,
    @location(1) normal: vec4f,
    @location(2) uv: vec2f,
    @location(3) color: vec4f,
    // Rows of the map from the item to eye space.
    @location(4) eye_x: vec4f,
    @location(5) eye_y: vec4f,
    @location(6) eye_z: vec4f,
}

struct Fragment {
    @invariant @builtin(position) clip: vec4f,
    @location(0) eye: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) color: vec4f,
}

@vertex
fn item(in: Corner) -> Fragment {
    return placed(in);
}

fn placed(in: Corner) -> Fragment {
    let at = vec4f(in.position, 1.0);
    let eye = vec3f(dot(in.eye_x, at), dot(in.eye_y, at), dot(in.eye_z, at));
    // Normals transform by the cofactor matrix. Its sign does not matter: the fragment shader picks the side.
    let x = vec3f(in.eye_x.x, in.eye_y.x, in.eye_z.x);
    let y = vec3f(in.eye_x.y, in.eye_y.y, in.eye_z.y);
    let z = vec3f(in.eye_x.z, in.eye_y.z, in.eye_z.z);
    let n = in.normal.xyz;
    let moved = cross(y, z) * n.x + cross(z, x) * n.y + cross(x, y) * n.z;
    let length = length(moved);
    var out: Fragment;
    out.clip = passage.clip_from_eye * vec4f(eye, 1.0);
    out.eye = eye;
    out.normal = select(vec3f(0.0), moved / length, length > 0.0);
    out.uv = in.uv;
    out.color = in.color;
    return out;
}

fn in_sector(v: vec3f) -> vec3f {
    return vec3f(dot(passage.sector_x.xyz, v), dot(passage.sector_y.xyz, v), dot(passage.sector_z.xyz, v));
}

@fragment
fn shade(in: Fragment) -> @location(0) vec4f {
    let p = in_sector(in.eye);
    let steps = array<vec3f, 2>(dpdx(p), dpdy(p));
    let texel = textureSample(color_texture, color_sampler, in.uv);
    let glow = textureSample(glow_texture, glow_sampler, in.uv).rgb;
    if discards && dot(passage.entry, vec4f(in.eye, 1.0)) < 0.0 {
        discard;
    }
    let color = material.color * in.color * texel;
    var coverage = 1.0;
    if material.flags.y == 1.0 && color.a < material.emission.w {
        discard;
    }
    if material.flags.y == 2.0 {
        coverage = clamp(color.a, 0.0, 1.0);
    }
    if material.flags.x == 1.0 {
        return shown(color.rgb, coverage);
    }
    let is_parallel = passage.back.w == 1.0;
    let away = select(p, passage.ahead.xyz, is_parallel);
    var own = cross(steps[0], steps[1]);
    let area = length(own);
    own = select(passage.back.xyz, own / area, area > 0.0);
    own = select(own, -own, dot(own, away) > 0.0);
    var normal = in_sector(in.normal);
    let long = length(normal);
    normal = select(own, normal / long, long > 1e-6);
    normal = select(normal, -normal, dot(normal, own) < 0.0);
    let light = ambient(normal) + direct(p, normal, own, steps) * passage.sector_x.w;
    let emission = material.emission.rgb * glow;
    return shown(compressed(color.rgb * light + emission), coverage);
}

fn ambient(normal: vec3f) -> vec3f {
    let upward = 0.5 + 0.5 * normal.y;
    let sky = passage.below.rgb * (1.0 - upward) + passage.above.rgb * upward;
    let sun = passage.sun.rgb * max(dot(normal, passage.to_sun.xyz), 0.0);
    return sky + sun + passage.sector_z.w * abs(dot(normal, passage.back.xyz));
}

fn compressed(light: vec3f) -> vec3f {
    if passage.sector_y.w == 0.0 {
        return light;
    }
    let soft = 0.6 + 0.4 * (1.0 - exp(-(light - 0.6) / 0.4));
    return select(light, soft, light > vec3f(0.6));
}

// Returns a colour for the target.
fn shown(color: vec3f, coverage: f32) -> vec4f {
    var c = clamp(color, vec3f(0.0), vec3f(1.0));
    if encodes {
        let curved = 1.055 * pow(c, vec3f(1.0 / 2.4)) - 0.055;
        c = select(curved, 12.92 * c, c <= vec3f(0.0031308));
    }
    return vec4f(c, coverage);
}

const LIGHT_TEXELS: u32 = 6u;

fn light_texel(number: u32) -> vec4f {
    let width = textureDimensions(lights).x;
    return textureLoad(lights, vec2u(number % width, number / width), 0);
}

// Depths on a shadow map.
@fragment
fn caster(in: Fragment) {
    let texel = textureSample(color_texture, color_sampler, in.uv);
    if material.flags.y == 1.0 && material.color.a * in.color.a * texel.a < material.emission.w {
        discard;
    }
}

// Returns the part of a sun that reaches a point: 1 where no shadow map covers it. `first` is the first texel of the maps,
// three each: the rows of the map from `p` to clip space.
fn sunlit(p: vec3f, own: vec3f, first: u32, count: u32) -> f32 {
    let size = f32(textureDimensions(shadow_maps).x);
    for (var number = 0u; number < count; number += 1u) {
        let x = light_texel(first + 3u * number);
        let y = light_texel(first + 3u * number + 1u);
        let z = light_texel(first + 3u * number + 2u);
        // A point a texel or two in front of the surface, against shadows of a face on itself.
        let texel = 2.0 / (length(x.xyz) * size);
        let at = vec4f(p + own * (2.0 * texel), 1.0);
        let clip = vec3f(dot(x, at), dot(y, at), dot(z, at));
        let within = 1.0 - 4.0 / size;
        if max(abs(clip.x), abs(clip.y)) > within || clip.z <= 0.0 || clip.z >= 1.0 {
            continue;
        }
        let uv = vec2f(0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y);
        var lit = 0.0;
        for (var tap = 0u; tap < 4u; tap += 1u) {
            let off = (vec2f(f32(tap & 1u), f32(tap >> 1u)) - 0.5) / size;
            lit += textureSampleCompareLevel(shadow_maps, shadow_sampler, uv + off, i32(number), clip.z);
        }
        return 0.25 * lit;
    }
    return 1.0;
}

// Returns the light of lamps and suns on a white surface, without exposure. `own` is the normal of the face.
fn direct(p: vec3f, normal: vec3f, own: vec3f, steps: array<vec3f, 2>) -> vec3f {
    var sum = vec3f(0.0);
    var next = u32(passage.above.w);
    for (var number = 0u; number < u32(passage.below.w); number += 1u) {
        let t0 = light_texel(next);
        let t1 = light_texel(next + 1u);
        let t2 = light_texel(next + 2u);
        let t3 = light_texel(next + 3u);
        let t4 = light_texel(next + 4u);
        let t5 = light_texel(next + 5u);
        let planes = next + LIGHT_TEXELS;
        next = planes + u32(t5.x) + 3u * u32(t5.w);
        let color = t1.rgb;
        if t0.w == 1.0 {
            let facing = dot(normal, t0.xyz);
            if facing > 0.0 {
                var penumbra = 0.0;
                if t5.z == 1.0 {
                    // The angle at which the sun is seen, in radians.
                    penumbra = 0.0093 * abs(dot(t4.xyz, p) - t4.w);
                }
                var part = passing(p, planes, t5.xy, steps, penumbra);
                if part > 0.0 && t5.w > 0.0 {
                    part *= sunlit(p, own, planes + u32(t5.x), u32(t5.w));
                }
                sum += color * (facing * part);
            }
            continue;
        }
        let to_lamp = t0.xyz - p;
        let facing = dot(normal, to_lamp);
        let square = dot(to_lamp, to_lamp);
        let own_square = square * t1.w;
        let range_part = own_square * t2.w;
        if facing <= 0.0 || range_part >= 1.0 {
            continue;
        }
        let part = passing(p, planes, t5.xy, steps, 0.0);
        if part <= 0.0 {
            continue;
        }
        let per_distance = 1.0 / sqrt(square);
        var cone = 1.0;
        if t3.z == 1.0 {
            let off = -dot(t2.xyz, to_lamp) * per_distance;
            cone = clamp(off * t3.x + t3.y, 0.0, 1.0);
            cone *= cone;
        }
        let falloff = (1.0 - range_part * range_part) / max(own_square, t3.w);
        sum += color * (part * falloff * cone * facing * per_distance);
    }
    return sum;
}

// Returns the part of a light that passes all planes of its beam. `counts` holds the number of planes, and of those whose
// edges are smoothed.
fn passing(p: vec3f, first: u32, counts: vec2f, steps: array<vec3f, 2>, penumbra: f32) -> f32 {
    // Faces that end at a plane of an opening are in full light up to there.
    let touching = 1e-4 * (1.0 + length(p));
    var part = 1.0;
    for (var number = 0u; number < u32(counts.x); number += 1u) {
        let plane = light_texel(first + number);
        let inside = dot(plane.xyz, p) - plane.w;
        if f32(number) < counts.y {
            let a = abs(dot(plane.xyz, steps[0]));
            let b = abs(dot(plane.xyz, steps[1]));
            let wide = sqrt(max(a, b) * max(a, b) + penumbra * penumbra);
            part *= part_within(inside, wide, min(a, b));
        } else if inside < -touching {
            return 0.0;
        }
    }
    return part;
}

// Returns the part of a pixel on the inner side of an edge. `inside` is the signed distance of its centre; `wide` and
// `narrow` are the extents of its longer and its shorter side across the edge.
fn part_within(inside: f32, wide: f32, narrow: f32) -> f32 {
    let off = abs(inside);
    var outer = 0.0;
    if wide > 0.0 && off <= 0.5 * (wide - narrow) {
        outer = 0.5 - off / wide;
    } else if wide > 0.0 && off < 0.5 * (wide + narrow) {
        let rest = 0.5 * (wide + narrow) - off;
        outer = rest * rest / (2.0 * wide * narrow);
    }
    return select(1.0 - outer, outer, inside < 0.0);
}

// Openings: corners in clip space, projected in 64 bits.

@vertex
fn opening(@location(0) clip: vec4f) -> @invariant @builtin(position) vec4f {
    return clip;
}

// The same, infinitely far away.
@vertex
fn opening_far(@location(0) clip: vec4f) -> @builtin(position) vec4f {
    return vec4f(clip.xy, 0.0, clip.w);
}

@vertex
fn everywhere(@builtin(vertex_index) number: u32) -> @builtin(position) vec4f {
    return vec4f(f32(number & 1u) * 4.0 - 1.0, f32(number >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn closed() -> @location(0) vec4f {
    return shown(vec3f(0.10, 0.07, 0.05), 1.0);
}

@fragment
fn nothing() -> @location(0) vec4f {
    return vec4f(0.0);
}

@fragment
fn sky(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let pixel = floor(at.xy - frame.origin.xy);
    let ray = frame.sky_corner.xyz + frame.sky_right.xyz * pixel.x + frame.sky_down.xyz * pixel.y;
    let up = ray.y / length(ray);
    let horizon = vec3f(0.78, 0.84, 0.90);
    let above = vec3f(0.18, 0.36, 0.68);
    let below = vec3f(0.28, 0.27, 0.26);
    let color = horizon + (above - horizon) * sqrt(max(up, 0.0)) + (below - horizon) * clamp(-3.0 * up, 0.0, 1.0);
    return shown(color, 1.0);
}
