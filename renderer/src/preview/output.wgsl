// Means of many frames, and the way to the display.

struct Output {
    // x: weight of the new frame in the mean; y: exposure in stops; z: display transform as in `DisplayTransform`.
    params: vec4f,
    // Samples that the drawn picture counts as; those from which it fades, and at which it is gone; 1 where there are sums.
    drawn: vec4f,
}

@group(0) @binding(0) var<uniform> output: Output;
@group(0) @binding(1) var picture: texture_2d<f32>;
@group(0) @binding(2) var before: texture_2d<f32>;
// Sums of the rays' samples by pixel, and their number.
@group(0) @binding(3) var<storage, read> sums: array<vec4f>;

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

// The drawn picture and the rays' samples: at first the one, in the end the other, and a mean of both between.
@fragment
fn fragment_blend(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let texel = vec2u(at.xy);
    let drawn = textureLoad(picture, texel, 0);
    if output.drawn.w == 0.0 {
        return drawn;
    }
    let sum = sums[texel.y * textureDimensions(picture).x + texel.x];
    let fading = saturate((output.drawn.z - sum.w) / (output.drawn.z - output.drawn.y));
    // Sums of few samples stand beside the drawn picture as it comes to them.
    let counts = max(output.drawn.x * fading, select(0.0, 1.0, sum.w < 0.5));
    return vec4f((drawn.rgb * counts + sum.rgb) / (counts + sum.w), drawn.a);
}

@fragment
fn fragment_display(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let radiance = textureLoad(picture, vec2i(at.xy), 0).rgb;
    return vec4f(display_apply(finite(radiance), output.params.y, u32(output.params.z)), 1.0);
}
