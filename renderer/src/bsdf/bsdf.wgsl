// How a surface scatters light: the layered material as one BSDF with `prepare`, `eval`, `sample`. Twin of `mod.rs`,
// where conventions and fields are described.

// Smallest share of the selection that a lobe with any weight gets: bounds sample weights by its inverse.
const SELECTION_MIN: f32 = 0.05;
// Cosines below this are raised to it where they divide.
const COS_MIN: f32 = 1e-4;
const FRAC_1_PI: f32 = 0.318309886183791;

// A sampled direction. Where `is_valid` does not hold the path ends.
struct BsdfSample {
    wi: vec3f,
    weight: vec3f,
    pdf: f32,
    is_delta: bool,
    is_transmission: bool,
    is_valid: bool,
}

// A value times |cos_theta_i| and its density.
struct BsdfValue {
    value: vec3f,
    pdf: f32,
}

// Reflectance of the interface at a facet, and what its refracting share lets through.
struct Interface {
    reflected: vec3f,
    transmitted: vec3f,
}

struct Bsdf {
    optics: Optics,
    throughput: vec3f,
    wo: vec3f,
    wo_stretch: vec3f,
    is_below: bool,
    is_inside: bool,
    eta: f32,
    eta_fresnel: f32,
    length_o: f32,
    bound: f32,
    coat: f32,
    coat_length_o: f32,
    coat_bound: f32,
    below_coat: vec3f,
    below_sheen: f32,
    sheen: f32,
    diffuse_scale: f32,
    p_coat: f32,
    p_sheen: f32,
    p_interface: f32,
    p_diffuse: f32,
}

// Everything that depends on the viewing direction: albedos of the layers and the probabilities of the lobes.
//
// `wo` is unit and local; below the surface it sees the body's inside. `throughput` of the path weights the choice of lobe
// and nothing else. Lobes that are switched off are not evaluated.
fn bsdf_prepare(optics: Optics, wo_local: vec3f, throughput: vec3f) -> Bsdf {
    let is_below = wo_local.z < 0.0;
    let is_inside = is_below && optics.w_transmission > 0.0;
    let wo = vec3f(wo_local.xy, max(abs(wo_local.z), 1e-6));
    let wo_stretch = rotate_z(wo, optics.rotation_cos, -optics.rotation_sin);
    let mu = max(wo.z, COS_MIN);
    let beta = throughput * (1.0 / max(max_channel(throughput), 1e-30));
    let eta = select(optics.eta, 1.0 / optics.eta, is_inside);
    let eta_fresnel = select(optics.eta_specular, eta, is_inside);

    let coat = select(optics.coat, 0.0, is_inside);
    var e_coat = 0.0;
    var passage = vec3f(1.0);
    var coat_length_o = 1.0;
    var coat_bound = 1.0;
    if HAS_COAT {
        let exact = fresnel(mu, optics.coat_eta);
        let rough = dielectric_albedo(optics.coat_eta, optics.coat_roughness, mu);
        e_coat = coat * select(rough, exact, optics.coat_is_smooth);
        passage = select(coat_passage(optics.coat_ln_tint, mu), vec3f(1.0), is_inside);
        coat_length_o = smith_length(wo, optics.coat_alpha, optics.coat_alpha);
        coat_bound = vndf_bound(wo, optics.coat_alpha, optics.coat_alpha);
    }
    let below_coat = passage * (1.0 - e_coat);
    var sheen = 0.0;
    var e_sheen = 0.0;
    if HAS_SHEEN {
        sheen = select(optics.sheen, 0.0, is_inside);
        e_sheen = sheen_albedo(optics.sheen_roughness, mu);
    }
    let below_sheen = 1.0 - sheen * e_sheen;

    // Selection in proportion to what each lobe is expected to return for this path.
    let k1 = max_channel(below_coat);
    let k2 = k1 * below_sheen;
    let w_coat = e_coat;
    let w_sheen = k1 * sheen * max_channel(optics.sheen_color) * e_sheen;
    var e_dielectric = 0.0;
    if HAS_SPECULAR || HAS_TRANSMISSION {
        let outside = dielectric_albedo(optics.eta_specular, optics.roughness, mu);
        e_dielectric = select(outside, fresnel(mu, eta_fresnel), is_inside);
    }
    var reflected = vec3f(0.0);
    if HAS_METAL {
        reflected = f82_tint(mu, optics.base_color, optics.f82) * optics.w_metal;
    }
    if HAS_SPECULAR {
        let tint = select(optics.edge_color, vec3f(1.0), is_inside);
        reflected = reflected + tint * ((optics.w_diffuse + optics.w_transmission) * e_dielectric);
    }
    var w_interface = k2 * max_channel(beta * reflected);
    if HAS_TRANSMISSION {
        w_interface += k2 * optics.w_transmission * max_channel(beta * optics.transmission_tint) * (1.0 - e_dielectric);
    }
    var w_diffuse = 0.0;
    var diffuse_scale = 0.0;
    if HAS_DIFFUSE {
        let e = dielectric_albedo(optics.eta_specular, optics.roughness, mu);
        let mean = dielectric_albedo_mean(optics.eta_specular, optics.roughness);
        w_diffuse = k2 * optics.w_diffuse * max_channel(beta * optics.base_color) * (1.0 - e);
        diffuse_scale = optics.w_diffuse * (1.0 - e) * FRAC_1_PI / max(1.0 - mean, 1e-6);
    }
    let p = probabilities(vec4f(w_coat, w_sheen, w_interface, w_diffuse));
    let transmits = optics.w_transmission > 0.0;
    let bound = select(vndf_bound(wo_stretch, optics.alpha_x, optics.alpha_y), 1.0, transmits);

    var b: Bsdf;
    b.optics = optics;
    b.throughput = beta;
    b.wo = wo;
    b.wo_stretch = wo_stretch;
    b.is_below = is_below;
    b.is_inside = is_inside;
    b.eta = eta;
    b.eta_fresnel = eta_fresnel;
    b.length_o = smith_length(wo_stretch, optics.alpha_x, optics.alpha_y);
    b.bound = bound;
    b.coat = coat;
    b.coat_length_o = coat_length_o;
    b.coat_bound = coat_bound;
    b.below_coat = below_coat;
    b.below_sheen = below_sheen;
    b.sheen = sheen;
    b.diffuse_scale = diffuse_scale;
    b.p_coat = p.x;
    b.p_sheen = p.y;
    b.p_interface = p.z;
    b.p_diffuse = p.w;
    return b;
}

// The other direction in the mirrored frame, and back.
fn bsdf_mirrored(b: Bsdf, w: vec3f) -> vec3f {
    return vec3f(w.x, w.y, select(w.z, -w.z, b.is_below));
}

// Reflectance of the interface at a facet seen under `cos_om`, and what its refracting share lets through.
fn bsdf_interface(b: Bsdf, cos_om: f32) -> Interface {
    let o = b.optics;
    var reflected = vec3f(0.0);
    var transmitted = vec3f(0.0);
    if HAS_METAL {
        reflected = f82_tint(cos_om, o.base_color, o.f82) * o.w_metal;
    }
    let f_outside = fresnel(cos_om, o.eta_specular);
    if HAS_TRANSMISSION {
        let f = fresnel(cos_om, b.eta_fresnel);
        let tint = select(o.edge_color, vec3f(1.0), b.is_inside);
        reflected = reflected + tint * (o.w_transmission * f);
        transmitted = o.transmission_tint * (o.w_transmission * (1.0 - f));
    }
    if HAS_SPECULAR {
        reflected = reflected + o.edge_color * (o.w_diffuse * f_outside);
    }
    return Interface(reflected, transmitted);
}

// Probability of reflecting rather than refracting at a facet.
fn bsdf_p_reflect(b: Bsdf, reflected: vec3f, transmitted: vec3f) -> f32 {
    let r = max_channel(b.throughput * reflected);
    let t = max_channel(b.throughput * transmitted);
    return select(1.0, r / max(r + t, 1e-30), t > 0.0);
}

// What reaches the base from the light side, and what remains for the viewer.
fn bsdf_layers(b: Bsdf, mu_i: f32) -> vec3f {
    if !HAS_COAT {
        return b.below_coat;
    }
    let light = coat_passage(b.optics.coat_ln_tint, max(mu_i, COS_MIN));
    return select(b.below_coat * light, b.below_coat, b.is_inside);
}

// Value times |cos_theta_i| of all lobes that are not delta, and their density. `wi` is unit and local.
fn bsdf_eval(b: Bsdf, wi_local: vec3f) -> BsdfValue {
    let wi = bsdf_mirrored(b, wi_local);
    let is_reflection = wi.z > 0.0;
    let up = bsdf_eval_reflection(b, vec3f(wi.xy, max(abs(wi.z), 1e-7)));
    if !HAS_TRANSMISSION {
        return BsdfValue(select(vec3f(0.0), up.value, is_reflection), select(0.0, up.pdf, is_reflection));
    }
    let through = bsdf_eval_transmission(b, vec3f(wi.xy, -max(abs(wi.z), 1e-7)));
    return BsdfValue(select(through.value, up.value, is_reflection), select(through.pdf, up.pdf, is_reflection));
}

// `bsdf_eval` for directions on the viewer's side, in the mirrored frame.
fn bsdf_eval_reflection(b: Bsdf, wi: vec3f) -> BsdfValue {
    let o = b.optics;
    let h = unit_or_z(b.wo + wi);
    let cos_om = saturate(dot(b.wo, h));
    var base = vec3f(0.0);
    var pdf = 0.0;
    if HAS_METAL || HAS_SPECULAR || HAS_TRANSMISSION {
        let m = rotate_z(h, o.rotation_cos, -o.rotation_sin);
        let wi_stretch = rotate_z(wi, o.rotation_cos, -o.rotation_sin);
        let d = select(d_ggx(m, o.alpha_x, o.alpha_y), 0.0, o.is_smooth);
        let length_i = smith_length(wi_stretch, o.alpha_x, o.alpha_y);
        let visibility = d * reflection_visibility(b.wo.z, wi.z, b.length_o, length_i);
        let facet = bsdf_interface(b, cos_om);
        base = facet.reflected * visibility;
        let p = b.p_interface * bsdf_p_reflect(b, facet.reflected, facet.transmitted);
        pdf = p * reflection_pdf(b.wo, d, b.bound, b.length_o);
    }
    if HAS_DIFFUSE {
        let e = dielectric_albedo(o.eta_specular, o.roughness, wi.z);
        base = base + o.base_color * (b.diffuse_scale * (1.0 - e) * wi.z);
        pdf += b.p_diffuse * wi.z * FRAC_1_PI;
    }
    base = base * b.below_sheen;
    if HAS_SHEEN {
        let fibres = sheen_eval(b.wo, wi, o.sheen_roughness);
        base = base + o.sheen_color * (b.sheen * fibres.x);
        pdf += b.p_sheen * fibres.y;
    }
    var value = base * bsdf_layers(b, wi.z);
    if HAS_COAT {
        let d = select(d_ggx(h, o.coat_alpha, o.coat_alpha), 0.0, o.coat_is_smooth);
        let length_i = smith_length(wi, o.coat_alpha, o.coat_alpha);
        let f = fresnel(cos_om, o.coat_eta);
        let coat = b.coat * f * d * reflection_visibility(b.wo.z, wi.z, b.coat_length_o, length_i);
        value = value + vec3f(coat);
        pdf += b.p_coat * reflection_pdf(b.wo, d, b.coat_bound, b.coat_length_o);
    }
    return BsdfValue(value, pdf);
}

// Factor of the layers on light that crosses the surface: the outer side alone passes coat and sheen.
fn bsdf_layers_across(b: Bsdf, mu_i: f32) -> vec3f {
    let from_outside = b.below_coat * b.below_sheen;
    if !HAS_COAT {
        return from_outside;
    }
    let leaving = coat_passage(b.optics.coat_ln_tint, max(mu_i, COS_MIN));
    return select(from_outside, leaving, b.is_inside);
}

// `bsdf_eval` for directions across the surface, in the mirrored frame (`wi.z < 0`). Source: Walter et al. 2007.
fn bsdf_eval_transmission(b: Bsdf, wi: vec3f) -> BsdfValue {
    let o = b.optics;
    let sum = b.wo + wi * b.eta;
    let sign = select(1.0, -1.0, sum.z < 0.0);
    let m = unit_or_z(sum * sign);
    let cos_om = dot(b.wo, m);
    let cos_im = dot(wi, m);
    let denominator = cos_om + b.eta * cos_im;
    let is_possible = cos_om > 0.0
        && cos_im < 0.0
        && m.z > 0.0
        && !o.is_smooth
        && !o.is_matched
        && abs(denominator) > 1e-12;
    let m_stretch = rotate_z(m, o.rotation_cos, -o.rotation_sin);
    let wi_stretch = rotate_z(wi, o.rotation_cos, -o.rotation_sin);
    let d = d_ggx(m_stretch, o.alpha_x, o.alpha_y);
    let pdf_m = vndf_pdf(b.wo, cos_om, d, b.length_o);
    let jacobian = sqr(b.eta) * abs(cos_im) / max(sqr(denominator), 1e-20);
    let g1 = g1_smith(wi_stretch, smith_length(wi_stretch, o.alpha_x, o.alpha_y));
    let facet = bsdf_interface(b, saturate(cos_om));
    let p = b.p_interface * (1.0 - bsdf_p_reflect(b, facet.reflected, facet.transmitted));
    let value = facet.transmitted * (pdf_m * g1 * jacobian) * bsdf_layers_across(b, abs(wi.z));
    return BsdfValue(select(vec3f(0.0), value, is_possible), select(0.0, p * pdf_m * jacobian, is_possible));
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
        wo = select(wo, b.wo, is_coat);
        alpha_x = select(alpha_x, o.coat_alpha, is_coat);
        alpha_y = select(alpha_y, o.coat_alpha, is_coat);
        bound = select(bound, b.coat_bound, is_coat);
        is_smooth = (is_coat && o.coat_is_smooth) || (!is_coat && is_smooth);
    }
    let up = vec3f(0.0, 0.0, 1.0);
    let drawn = vndf_sample(wo, alpha_x, alpha_y, bound, u.y, u.z);
    let m = select(rotate_z(drawn, c, s), up, is_smooth);
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
        let factor = facet.transmitted * (g1 / p) * bsdf_layers_across(b, abs(bent.z));
        through = select(vec3f(0.0), factor, is_open);
        let d = d_ggx(rotate_z(m, o.rotation_cos, -o.rotation_sin), alpha_x, alpha_y);
        let cos_im = dot(bent, m);
        let denominator = cos_om + b.eta * cos_im;
        let jacobian = sqr(b.eta) * abs(cos_im) / max(sqr(denominator), 1e-20);
        through_pdf = select(p * vndf_pdf(b.wo, cos_om, d, b.length_o) * jacobian, 0.0, is_straight);
    }

    if HAS_DIFFUSE {
        wi = select(wi, cosine_sample(u.y, u.z), is_diffuse);
    }
    if HAS_SHEEN {
        wi = select(wi, sheen_sample(b.wo, o.sheen_roughness, u.y, u.z), is_sheen);
    }

    let is_up = wi.z > 1e-7;
    let wi_up = vec3f(wi.xy, max(abs(wi.z), 1e-7));
    let mixed = bsdf_eval_reflection(b, wi_up);
    var weight = mixed.value * (1.0 / select(1.0, mixed.pdf, mixed.pdf > 0.0));
    var is_valid = is_up && (mixed.pdf > 0.0 || is_delta);
    var pdf = select(mixed.pdf, 0.0, is_delta);

    // Delta reflections: the lobe's own reflectance over the probability of having chosen it.
    if is_delta {
        let p = max(b.p_interface * p_reflect, 1e-30);
        var mirror = (facet.reflected * bsdf_layers(b, wi_up.z)) * (b.below_sheen / p);
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

// Weights to probabilities: every lobe with any weight gets at least SELECTION_MIN before they are normalised.
fn probabilities(weights: vec4f) -> vec4f {
    let sum = weights.x + weights.y + weights.z + weights.w;
    let inverse = 1.0 / select(1.0, sum, sum > 0.0);
    let p = select(vec4f(0.0), max(weights * inverse, vec4f(SELECTION_MIN)), weights > vec4f(0.0));
    let p_sum = p.x + p.y + p.z + p.w;
    let p_inverse = 1.0 / select(1.0, p_sum, p_sum > 0.0);
    return p * p_inverse;
}
