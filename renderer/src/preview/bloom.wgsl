// Light that a lens spreads around what is brighter than the display: halves of the picture's excess, added up again from the coarsest.

// Weights of a halving, four texels wide: binomial.
const HALVING: array<f32, 4> = array<f32, 4>(0.125, 0.375, 0.375, 0.125);
// Share of the excess that is spread by each level.
const SPREAD: f32 = 0.02;
// What a texel gives at most, in units of the display's white: a rare bright sample must not light the picture.
const EXCESS_MAX: f32 = 64.0;

// Exposure in stops, within the limits of `display_apply`.
fn stops() -> f32 {
    return clamp(output.params.y, -64.0, 64.0);
}

// What is above the display's white, in units of it.
fn excess(radiance: vec3f) -> vec3f {
    let shown = finite(radiance) * exp2(stops());
    let peak = max(max(shown.r, shown.g), max(shown.b, 1e-6));
    return shown * (clamp(peak - 1.0, 0.0, EXCESS_MAX) / peak);
}

fn halved(at: vec2f, is_first: bool) -> vec4f {
    let last = vec2i(textureDimensions(picture)) - 1;
    let corner = 2 * vec2i(at) - 1;
    var sum = vec3f(0.0);
    for (var j = 0; j < 4; j++) {
        for (var i = 0; i < 4; i++) {
            let texel = textureLoad(picture, clamp(corner + vec2i(i, j), vec2i(0), last), 0).rgb;
            var light = texel;
            if is_first {
                light = excess(texel);
            }
            sum += light * (HALVING[i] * HALVING[j]);
        }
    }
    return vec4f(sum, 1.0);
}

@fragment
fn fragment_first(@builtin(position) at: vec4f) -> @location(0) vec4f {
    return halved(at.xy, true);
}

@fragment
fn fragment_halved(@builtin(position) at: vec4f) -> @location(0) vec4f {
    return halved(at.xy, false);
}

// A coarse level at a place of one that is twice as fine: bilinear.
fn coarse(level: texture_2d<f32>, at: vec2f) -> vec3f {
    let last = vec2i(textureDimensions(level)) - 1;
    let p = 0.5 * at - 0.5;
    let corner = vec2i(floor(p));
    let f = p - floor(p);
    let a = textureLoad(level, clamp(corner, vec2i(0), last), 0).rgb;
    let b = textureLoad(level, clamp(corner + vec2i(1, 0), vec2i(0), last), 0).rgb;
    let c = textureLoad(level, clamp(corner + vec2i(0, 1), vec2i(0), last), 0).rgb;
    let d = textureLoad(level, clamp(corner + vec2i(1, 1), vec2i(0), last), 0).rgb;
    return mix(mix(a, b, f.x), mix(c, d, f.x), f.y);
}

// A level and all coarser ones: `picture` holds those, `before` the level.
@fragment
fn fragment_added(@builtin(position) at: vec4f) -> @location(0) vec4f {
    return vec4f(textureLoad(before, vec2i(at.xy), 0).rgb + coarse(picture, at.xy), 1.0);
}

// The picture with its bloom (`before`, half the size) on the display.
@fragment
fn fragment_display_bloom(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let radiance = finite(textureLoad(picture, vec2i(at.xy), 0).rgb);
    let spread = coarse(before, at.xy) * SPREAD * exp2(-stops());
    return vec4f(display_apply(radiance + spread, output.params.y, u32(output.params.z)), 1.0);
}
