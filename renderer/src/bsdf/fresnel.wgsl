// Reflectance of smooth interfaces: dielectric Fresnel, specular level, F82-tint metals. Twin of `fresnel.rs`.

// Largest reflectance at normal incidence that a dielectric may reach; keeps the index of refraction finite.
const F0_MAX: f32 = 0.9999;

// Reflectance at normal incidence of an index of refraction `n > 0`.
fn f0_from_ior(n: f32) -> f32 {
    return sqr((n - 1.0) / (n + 1.0));
}

// Index of refraction, at least 1, with this reflectance at normal incidence. `f0` in [0, 1], capped at F0_MAX.
fn ior_from_f0(f0: f32) -> f32 {
    let s = sqrt(min(max(f0, 0.0), F0_MAX));
    return (1.0 + s) / (1.0 - s);
}

// Index of refraction after the specular level: linear in reflectance, 0.5 leaves it. For `n < 1` the reciprocal rule applies.
// Source: specification "Specular level"; model reference 5.1.
fn level_to_ior(n: f32, level: f32) -> f32 {
    let scaled = ior_from_f0(2.0 * level * f0_from_ior(n));
    return select(scaled, 1.0 / scaled, n < 1.0);
}

// Unpolarised Fresnel reflectance for `c = |cos|` in [0, 1] and `eta = n_transmitted / n_incident > 0`.
//
// Exactly 0 for `eta = 1`, exactly 1 under total internal reflection. Keeps full relative precision for `eta` near 1,
// because no difference of nearly equal terms is formed. Model reference 5.2.
fn fresnel(c: f32, eta: f32) -> f32 {
    let d = (eta - 1.0) * (eta + 1.0);
    let g2 = d + c * c;
    let is_matched = eta == 1.0;
    let is_total = g2 <= 0.0;
    let g = sqrt(select(g2, 1.0, is_total || is_matched));
    let f = select(fresnel_bent(c, g, eta), 1.0, is_total);
    return select(f, 0.0, is_matched);
}

// `fresnel` of light that is known to refract, `g` being `eta` times the cosine of refraction, above 0: near total reflection the
// difference under its root would leave few digits of what passes. `eta` is not 1.
fn fresnel_bent(c: f32, g: f32, eta: f32) -> f32 {
    let d = (eta - 1.0) * (eta + 1.0);
    let q = 1.0 / (c + g);
    let rs = -(d * q * q);
    let b = (c * (g + c) - 1.0) / (c * d * q + 1.0);
    return saturate(0.5 * rs * rs * (1.0 + b * b));
}

// Coefficient of the F82-tint curve for reflectance `r` at normal incidence and edge tint `t`, both in [0, 1]. Model reference 4.
fn f82_coefficient(r: vec3f, t: vec3f) -> vec3f {
    return (1.0 - t) * (49.0 / 6.0 + 9.484717935528 * r);
}

// F82-tint reflectance of a metal for `mu = |o.m|` in [0, 1]. Clamped to [0, 1]: dark tints would go negative.
// Source: Kutz, Hasan, Edmondson 2021; model reference 4.
fn f82_tint(mu: f32, r: vec3f, b: vec3f) -> vec3f {
    let u = 1.0 - mu;
    let u2 = u * u;
    let u5 = u2 * u2 * u;
    return saturate(r + (1.0 - r - b * mu * u) * u5);
}

// Cosine-weighted mean of `f82_tint`, clamped to [0, 1]. Exact where the curve needs no clamp.
fn f82_average(r: vec3f, b: vec3f) -> vec3f {
    return saturate(r + (1.0 - r) * (1.0 / 21.0) - b * (1.0 / 126.0));
}
