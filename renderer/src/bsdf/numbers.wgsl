// Plain numbers and vectors: what `lanes.rs` and `vector.rs` offer and WGSL lacks. ALPHA_MIN is printed from `lanes.rs`.

const PI: f32 = 3.14159265358979;

fn sqr(x: f32) -> f32 {
    return x * x;
}

// `exp(x) - 1` without cancellation, for `x <= 0`.
fn exp_m1(x: f32) -> f32 {
    // Below 0.03 the third power is the last that single precision sees.
    let series = x * (1.0 + x * (0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0))));
    return select(exp(x) - 1.0, series, abs(x) < 0.03);
}

// Unit vector; vectors shorter than about 1e-18 give +z.
fn unit_or_z(v: vec3f) -> vec3f {
    let l2 = dot(v, v);
    let is_short = l2 < 1e-36;
    let scaled = v * (1.0 / sqrt(select(l2, 1.0, is_short)));
    return select(scaled, vec3f(0.0, 0.0, 1.0), is_short);
}

fn max_channel(c: vec3f) -> f32 {
    return max(max(c.x, c.y), c.z);
}

// Rec.709 luminance.
fn luminance(c: vec3f) -> f32 {
    return dot(c, vec3f(0.2126390, 0.7151687, 0.0721923));
}
