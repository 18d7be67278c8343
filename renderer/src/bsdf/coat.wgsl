// The coat's tint of what lies below. Its reflection is an ordinary GGX lobe. Twin of `coat.rs`.

// Exponent of the coat tint for one passage at cosine `mu`: longer at grazing angles. Model reference 8.3.
fn coat_exponent(mu: f32) -> f32 {
    return 0.25 + 0.1575 / mix(0.24, 1.0, mu * mu);
}

// Factor on light that passes the coat once at cosine `mu`; `ln_tint` is the logarithm of the tint, at least `ln 1e-6`.
fn coat_passage(ln_tint: vec3f, mu: f32) -> vec3f {
    let p = coat_exponent(mu);
    return exp(ln_tint * p);
}
