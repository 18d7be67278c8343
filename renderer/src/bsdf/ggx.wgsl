// The GGX microfacet distribution with Smith shadowing, anisotropic. Twin of `ggx.rs`.
//
// All directions are unit, in the frame of the stretch: x along it, z the normal. Nothing here forms `1 - cos^2`.

// Density of microfacet normals `m` per solid angle and projected area, `D(m)`. `alpha_x`, `alpha_y` in [1e-4, 1].
fn d_ggx(m: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    let x = m.x / alpha_x;
    let y = m.y / alpha_y;
    let s = x * x + y * y + m.z * m.z;
    return 1.0 / (PI * alpha_x * alpha_y * s * s);
}

// `sqrt((ax vx)^2 + (ay vy)^2 + vz^2)`: the length that all Smith terms share.
fn smith_length(v: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    return sqrt(sqr(alpha_x * v.x) + sqr(alpha_y * v.y) + sqr(v.z));
}

// Smith masking of one direction, `G1`, in [0, 1]; `length_v` from `smith_length`.
fn g1_smith(v: vec3f, length_v: f32) -> f32 {
    return 2.0 * abs(v.z) / max(abs(v.z) + length_v, 1e-20);
}

// Height-correlated Smith `G2 / (4 mu_o mu_i)` times `mu_i`: what a reflection multiplies with `F D`.
fn reflection_visibility(mu_o: f32, mu_i: f32, length_o: f32, length_i: f32) -> f32 {
    return mu_i / max(2.0 * (mu_i * length_o + mu_o * length_i), 1e-20);
}

// The bound of the spherical cap for `wo`: 1 samples all visible normals, the bounded form leaves out those that
// reflect below the horizon. Source: Eto and Tokuyoshi 2023, equation 5.
fn vndf_bound(wo: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    let a = min(min(1.0, alpha_x), alpha_y);
    let s = 1.0 + sqrt(sqr(wo.x) + sqr(wo.y));
    let a2 = a * a;
    let s2 = s * s;
    return (1.0 - a2) * s2 / (s2 + a2 * sqr(wo.z));
}

// Samples a visible microfacet normal for `wo` (`wo.z >= 0`) at `u0`, `u1` in [0, 1); `k` is 1 or `vndf_bound`.
//
// Returns a unit normal with `z >= 0`, finite at grazing `wo`. Source: Dupuy and Benyoub 2023.
fn vndf_sample(wo: vec3f, alpha_x: f32, alpha_y: f32, k: f32, u0: f32, u1: f32) -> vec3f {
    let os = unit_or_z(vec3f(alpha_x * wo.x, alpha_y * wo.y, wo.z));
    let b = k * min(os.z, 1.0);
    let one_plus_z = (1.0 - u0) * (1.0 + b) + (1.0 - b);
    let one_minus_z = u0 * (1.0 + b);
    let z = (1.0 - u0) * (1.0 + b) - b;
    let st = sqrt(max(one_plus_z * one_minus_z, 0.0));
    let turn = 2.0 * PI * u1;
    let h = vec3f(st * cos(turn) + os.x, st * sin(turn) + os.y, z + os.z);
    return unit_or_z(vec3f(alpha_x * h.x, alpha_y * h.y, max(h.z, 0.0)));
}

// Density per solid angle of a reflected direction whose half vector `m` was drawn by `vndf_sample` with bound `k`.
fn reflection_pdf(wo: vec3f, d: f32, k: f32, length_o: f32) -> f32 {
    return d / max(2.0 * (k * wo.z + length_o), 1e-20);
}

// Density per solid angle of a visible normal `m` with `cos_om = o.m > 0`, unbounded (`k = 1`).
fn vndf_pdf(wo: vec3f, cos_om: f32, d: f32, length_o: f32) -> f32 {
    return 2.0 * max(cos_om, 0.0) * d / max(wo.z + length_o, 1e-20);
}

// Mirror image of `wo` about `m`. Not called `reflect`, which WGSL has with other meaning of its arguments.
fn reflect_about(wo: vec3f, m: vec3f) -> vec3f {
    return m * (2.0 * dot(wo, m)) - wo;
}

// A refracted direction away from the surface on the other side, and whether it exists (no total reflection).
struct Refracted {
    wi: vec3f,
    exists: bool,
}

// Refracts `wo` at a facet `m` with `cos_om = o.m > 0`; `eta = n_transmitted / n_incident`. Not called `refract`, which
// WGSL has with other arguments.
fn refract_at(wo: vec3f, m: vec3f, cos_om: f32, eta: f32) -> Refracted {
    let inverse = 1.0 / eta;
    // 1 - sin^2 written as a difference of squares: exact at normal incidence, no loss for eta near 1.
    let cos2 = ((eta - 1.0) * (eta + 1.0) + cos_om * cos_om) * inverse * inverse;
    let exists = cos2 > 0.0;
    let cos_t = sqrt(select(0.0, cos2, exists));
    let wi = m * (cos_om * inverse - cos_t) - wo * inverse;
    return Refracted(unit_or_z(wi), exists);
}

// Direction rotated about z by an angle given by its cosine and sine.
fn rotate_z(v: vec3f, c: f32, s: f32) -> vec3f {
    return vec3f(c * v.x - s * v.y, s * v.x + c * v.y, v.z);
}

// Roughness along and across the stretch, and whether the surface is a mirror.
struct Alphas {
    x: f32,
    y: f32,
    is_smooth: bool,
}

// Roughness along and across the stretch. Below the smallest alpha in both directions the surface is a mirror.
//
// Returns alphas clamped to [1e-4, 1]. Model reference 3.1, 3.2.
fn alphas(roughness: f32, anisotropy: f32) -> Alphas {
    let along_y = sqr(roughness);
    let along_x = min(along_y + sqr(sqr(anisotropy)), 1.0);
    let is_smooth = along_x < ALPHA_MIN && along_y < ALPHA_MIN;
    return Alphas(max(along_x, ALPHA_MIN), max(along_y, ALPHA_MIN), is_smooth);
}

// A cosine-weighted direction about +z at `u0`, `u1` in [0, 1).
fn cosine_sample(u0: f32, u1: f32) -> vec3f {
    let r = sqrt(u0);
    let turn = 2.0 * PI * u1;
    return vec3f(r * cos(turn), r * sin(turn), sqrt(max(1.0 - u0, 0.0)));
}
