// Means of many frames, and the way to the display.

struct Output {
    // x: weight of the new frame in the mean; y: exposure in stops; z: display transform as in `DisplayTransform`.
    params: vec4f,
}

@group(0) @binding(0) var<uniform> output: Output;
@group(0) @binding(1) var picture: texture_2d<f32>;
@group(0) @binding(2) var before: texture_2d<f32>;

@vertex
fn vertex_output(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let at = vec2f(f32((index << 1u) & 2u), f32(index & 2u)) * 2.0 - 1.0;
    return vec4f(at, 0.0, 1.0);
}

// 0 for what is not finite. Comparisons may be compiled away, bits may not.
fn finite(c: vec3f) -> vec3f {
    let bits = bitcast<vec3u>(c) & vec3u(0x7f800000u);
    return select(c, vec3f(0.0), bits == vec3u(0x7f800000u));
}

@fragment
fn fragment_mean(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let texel = vec2i(at.xy);
    let drawn = textureLoad(picture, texel, 0);
    let now = vec4f(finite(drawn.rgb), drawn.a);
    let weight = output.params.x;
    if weight >= 1.0 {
        return now;
    }
    return mix(textureLoad(before, texel, 0), now, weight);
}

@fragment
fn fragment_display(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let radiance = textureLoad(picture, vec2i(at.xy), 0).rgb;
    return vec4f(display_apply(finite(radiance), output.params.y, u32(output.params.z)), 1.0);
}
