// Directions drawn from the BSDF. Twin of `sample.rs`.

// A sampled direction. Where `is_valid` does not hold the path ends.
struct BsdfSample {
    wi: vec3f,
    weight: vec3f,
    pdf: f32,
    is_delta: bool,
    is_transmission: bool,
    is_valid: bool,
}

// Draws a direction. `u` in [0, 1): choice of lobe, direction (2), reflection or refraction.
fn bsdf_sample(b: Bsdf, u: vec4f) -> BsdfSample {
    let o = b.optics;
    let c1 = b.p_coat;
    let c2 = c1 + b.p_sheen;
    let c3 = c2 + b.p_interface;
    let total = c3 + b.p_diffuse;
    let is_coat = u.x < c1;
    let is_sheen = u.x < c2 && !is_coat;
    // The last lobe with any probability takes what rounding leaves.
    let is_diffuse = (u.x >= c3 || b.p_interface <= 0.0) && b.p_diffuse > 0.0 && !is_coat && !is_sheen;
    let is_interface = !is_coat && !is_sheen && !is_diffuse;

    // One visible normal serves coat and base: each sample has its own alpha and frame.
    var c = o.rotation_cos;
    var s = o.rotation_sin;
    var wo = b.wo_stretch;
    var alpha_x = o.alpha_x;
    var alpha_y = o.alpha_y;
    var bound = b.bound;
    var is_smooth = o.is_smooth;
    if HAS_COAT {
        c = select(c, 1.0, is_coat);
        s = select(s, 0.0, is_coat);
        wo = select(wo, b.coat_wo, is_coat);
        alpha_x = select(alpha_x, o.coat_alpha, is_coat);
        alpha_y = select(alpha_y, o.coat_alpha, is_coat);
        bound = select(bound, b.coat_bound, is_coat);
        is_smooth = (is_coat && o.coat_is_smooth) || (!is_coat && is_smooth);
    }
    let up = vec3f(0.0, 0.0, 1.0);
    let drawn = vndf_sample(wo, alpha_x, alpha_y, bound, u.y, u.z);
    var m = select(rotate_z(drawn, c, s), up, is_smooth);
    if HAS_COAT && (HAS_COAT_NORMAL_MAP || HAS_NORMAL_MAP || HAS_HEIGHT) && b.has_coat_frame {
        m = select(m, coat_frame_outer(b.coat_frame, m), is_coat);
    }
    let cos_om = saturate(dot(b.wo, m));
    var wi = reflect_about(b.wo, m);

    // Refraction at the drawn facet.
    var is_transmission = false;
    var through = vec3f(0.0);
    var through_pdf = 0.0;
    var is_delta = is_smooth && (is_coat || is_interface);
    let facet = bsdf_interface(b, cos_om);
    let p_reflect = bsdf_p_reflect(b, facet.reflected, facet.transmitted);
    if HAS_TRANSMISSION {
        let p_refract = 1.0 - p_reflect;
        let refracted = refract_at(b.wo, m, cos_om, b.eta);
        let bent = select(refracted.wi, -b.wo, o.is_matched);
        is_transmission = is_interface && u.w >= p_reflect && p_refract > 0.0;
        let is_open = (refracted.exists || o.is_matched) && bent.z < 0.0;
        wi = select(wi, bent, is_transmission);
        is_delta = is_delta || (is_transmission && o.is_matched);

        // The weight comes from the facet itself: dividing `eval` by the density would cancel badly for eta near 1.
        let wi_stretch = rotate_z(bent, o.rotation_cos, -o.rotation_sin);
        let is_straight = is_smooth || o.is_matched;
        let g1 = select(g1_smith(wi_stretch, smith_length(wi_stretch, alpha_x, alpha_y)), 1.0, is_straight);
        let p = max(b.p_interface * p_refract, 1e-30);
        let factor = facet.transmitted * (g1 / p) * bsdf_layers_across(b, bent);
        through = select(vec3f(0.0), factor, is_open);
        let d = d_ggx(rotate_z(m, o.rotation_cos, -o.rotation_sin), alpha_x, alpha_y);
        let cos_im = dot(bent, m);
        // cos_om + eta cos_im by Snell's law, without the difference.
        let denominator = b.contrast * (b.eta + 1.0) / max(cos_om + b.eta * abs(cos_im), 1e-20);
        let jacobian = sqr(b.eta) * abs(cos_im) / max(sqr(denominator), 1e-20);
        through_pdf = select(p * vndf_pdf(b.wo, cos_om, d, b.length_o) * jacobian, 0.0, is_straight);
    }

    if HAS_DIFFUSE || (HAS_METAL && HAS_MULTIPLE_SCATTERING) {
        wi = select(wi, cosine_sample(u.y, u.z), is_diffuse);
    }
    if HAS_SHEEN {
        wi = select(wi, sheen_sample(b.wo, o.sheen_roughness, u.y, u.z), is_sheen);
    }

    // A coat with its own normal reflects nothing below its own horizon.
    let is_up = wi.z > 1e-7 && (!is_coat || bsdf_in_coat(b, wi).z > 0.0);
    let wi_up = vec3f(wi.xy, max(abs(wi.z), 1e-7));
    let mixed = bsdf_eval_reflection(b, wi_up);
    var weight = mixed.value * (1.0 / select(1.0, mixed.pdf, mixed.pdf > 0.0));
    var is_valid = is_up && (mixed.pdf > 0.0 || is_delta);
    var pdf = select(mixed.pdf, 0.0, is_delta);

    // Delta reflections: the lobe's own reflectance over the probability of having chosen it.
    if is_delta {
        let p = max(b.p_interface * p_reflect, 1e-30);
        var mirror = (facet.reflected * bsdf_layers(b, wi_up)) * (b.below_sheen / p);
        if HAS_COAT {
            let coat = b.coat * fresnel(cos_om, o.coat_eta) / max(b.p_coat, 1e-30);
            mirror = select(mirror, vec3f(coat), is_coat);
        }
        weight = mirror;
    }
    weight = select(weight, through, is_transmission);
    pdf = select(pdf, through_pdf, is_transmission);
    is_valid = (is_transmission && wi.z < 0.0) || (!is_transmission && is_valid);
    is_valid = is_valid && total > 0.0 && max_channel(weight) > 0.0;
    return BsdfSample(bsdf_mirrored(b, wi), weight, pdf, is_delta, is_transmission, is_valid);
}
