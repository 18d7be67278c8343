// The coat's tint of what lies below, and its frame. Its reflection is an ordinary GGX lobe. Twin of `coat.rs`.

// Exponent of the coat tint for one passage at cosine `mu`: longer at grazing angles. Model reference 8.3.
fn coat_exponent(mu: f32) -> f32 {
    return 0.25 + 0.1575 / mix(0.24, 1.0, mu * mu);
}

// Factor on light that passes the coat once at cosine `mu`; `ln_tint` is the logarithm of the tint, at least `ln 1e-6`.
fn coat_passage(ln_tint: vec3f, mu: f32) -> vec3f {
    let p = coat_exponent(mu);
    return exp(ln_tint * p);
}

// Axes of a coat with normals of its own, in the frame of the base. Which tangents does not matter: the coat is isotropic.
struct CoatFrame {
    t: vec3f,
    b: vec3f,
    n: vec3f,
}

// Axes about a unit normal. Source: Duff et al. 2017.
fn coat_frame_new(n: vec3f) -> CoatFrame {
    let sign = select(1.0, -1.0, n.z < 0.0);
    let a = -(1.0 / (sign + n.z));
    let b = n.x * n.y * a;
    let t = vec3f(1.0 + sign * n.x * n.x * a, sign * b, -(sign * n.x));
    return CoatFrame(t, vec3f(b, sign + n.y * n.y * a, -n.y), n);
}

// A direction of the base's frame in this one.
fn coat_frame_local(f: CoatFrame, w: vec3f) -> vec3f {
    return vec3f(dot(w, f.t), dot(w, f.b), dot(w, f.n));
}

// A direction of this frame in the base's.
fn coat_frame_outer(f: CoatFrame, w: vec3f) -> vec3f {
    return f.t * w.x + f.b * w.y + f.n * w.z;
}
