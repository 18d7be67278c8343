// Sheen: a thin slab of fibre-like microflakes along the normal, single scattering in closed form. Twin of `sheen.rs`.
// Model reference 7; scale 1/2 stands in for multiple scattering and keeps the albedo below 1.

// Smallest sheen roughness that is evaluated.
const SHEEN_ROUGHNESS_MIN: f32 = 1e-3;

// Projected area of the flakes towards unit `v`; `r` in [1e-3, 1]. In [r, 1].
fn sheen_sigma(v: vec3f, r: f32) -> f32 {
    return sqrt(sqr(v.x) + sqr(v.y) + sqr(r * v.z));
}

// Density of flake normals `m`.
fn sheen_d(m: vec3f, r: f32) -> f32 {
    let s = sqr(m.x) + sqr(m.y) + sqr(m.z / r);
    return 1.0 / (PI * r * s * s);
}

// Untinted sheen times `mu_i` in x, its sampling density per solid angle in y. `wo.z > 0` and `wi.z > 0`.
fn sheen_eval(wo: vec3f, wi: vec3f, r: f32) -> vec2f {
    let d = sheen_d(unit_or_z(wo + wi), r);
    let sigma_o = sheen_sigma(wo, r);
    let sigma_i = sheen_sigma(wi, r);
    let crossed = max(sigma_i * wo.z + sigma_o * wi.z, 1e-12);
    let depth = crossed / max(wo.z * wi.z, 1e-12);
    let absorbed = -exp_m1(-min(depth, 80.0));
    let value = 0.5 * d * absorbed * wi.z / crossed;
    return vec2f(value, d / (4.0 * sigma_o));
}

// Samples a direction by visible flake normals. The result may lie below the horizon: the caller rejects it.
// Source: Heitz, Dupuy, Crassin, Dachsbacher 2015 (SGGX), reduced to this slab.
fn sheen_sample(wo: vec3f, r: f32, u0: f32, u1: f32) -> vec3f {
    let axis = unit_or_z(vec3f(wo.x, wo.y, r * wo.z));
    let h0 = cosine_sample(u0, u1);
    // Any frame about the axis will do, and this one has no branch and no pole (Duff et al. 2017).
    let sign = select(1.0, -1.0, axis.z < 0.0);
    let a = -(1.0 / (sign + axis.z));
    let b = axis.x * axis.y * a;
    let t = vec3f(1.0 + sign * axis.x * axis.x * a, sign * b, -(sign * axis.x));
    let s = vec3f(b, sign + axis.y * axis.y * a, -axis.y);
    let h = t * h0.x + s * h0.y + axis * h0.z;
    let m = unit_or_z(vec3f(h.x, h.y, r * h.z));
    return reflect_about(wo, m);
}
