// Values and densities of the BSDF. Twin of `eval.rs`.

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

// Reflectance of the interface at a facet seen under `cos_om`, and what its refracting share lets through.
fn bsdf_interface(b: Bsdf, cos_om: f32) -> Interface {
    return bsdf_interface_bent(b, cos_om, 0.0);
}

// The same with the cosine of the refracted direction; 0 where it is not known.
fn bsdf_interface_bent(b: Bsdf, cos_om: f32, cos_im: f32) -> Interface {
    let o = b.optics;
    var reflected = vec3f(0.0);
    var transmitted = vec3f(0.0);
    if HAS_METAL {
        reflected = f82_tint(cos_om, o.base_color, o.f82) * o.w_metal;
    }
    if HAS_TRANSMISSION {
        var f = fresnel(cos_om, b.eta_fresnel);
        if cos_im != 0.0 && b.eta_fresnel == b.eta && !o.is_matched {
            // Under a coat, light reflects by another index than it bends by.
            f = fresnel_bent(cos_om, max(b.eta * abs(cos_im), 1e-20), b.eta);
        }
        let tint = select(o.edge_color, vec3f(1.0), b.is_inside);
        let share = o.w_transmission * b.glass_gain;
        transmitted = o.transmission_tint * (share * (1.0 - f));
        if HAS_DISPERSION {
            let e = b.eta_channels;
            let channels = vec3f(fresnel(cos_om, e.x), fresnel(cos_om, e.y), fresnel(cos_om, e.z));
            reflected = reflected + tint * channels * share;
            transmitted = transmitted * b.spectral;
        } else {
            reflected = reflected + tint * (share * f);
        }
    }
    if HAS_SPECULAR && HAS_DIFFUSE {
        reflected = reflected + o.edge_color * (o.w_diffuse * fresnel(cos_om, o.eta_specular));
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
fn bsdf_layers(b: Bsdf, wi: vec3f) -> vec3f {
    if !HAS_COAT {
        return b.below_coat;
    }
    let light = coat_passage(b.optics.coat_ln_tint, max(bsdf_in_coat(b, wi).z, COS_MIN));
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
    if HAS_DIFFUSE || (HAS_METAL && HAS_MULTIPLE_SCATTERING) {
        let grid = grid_base(o.albedos);
        let slant = grid_slant(grid, rotate_z(wi, o.rotation_cos, -o.rotation_sin));
        if HAS_DIFFUSE {
            let miss = grid_at(grid, DIELECTRIC_MISS, b.place, slant);
            base = base + o.base_color * (b.diffuse_scale * miss * wi.z);
        }
        if HAS_METAL && HAS_MULTIPLE_SCATTERING {
            base = base + b.metal_scale * (grid_at(grid, METAL_MISS, b.place, slant) * wi.z);
        }
        pdf += b.p_diffuse * wi.z * FRAC_1_PI;
    }
    base = base * b.below_sheen;
    if HAS_SHEEN {
        let fibres = sheen_eval(b.wo, wi, o.sheen_roughness);
        base = base + o.sheen_color * (b.sheen * fibres.x);
        pdf += b.p_sheen * fibres.y;
    }
    var value = base * bsdf_layers(b, wi);
    if HAS_COAT {
        let h_coat = bsdf_in_coat(b, h);
        let wi_coat = bsdf_in_coat(b, wi);
        let is_hidden = o.coat_is_smooth || wi_coat.z <= 0.0 || h_coat.z <= 0.0;
        let d = select(d_ggx(h_coat, o.coat_alpha, o.coat_alpha), 0.0, is_hidden);
        let length_i = smith_length(wi_coat, o.coat_alpha, o.coat_alpha);
        let f = fresnel(cos_om, o.coat_eta);
        let mu_i = max(wi_coat.z, 1e-7);
        let coat = b.coat * f * d * reflection_visibility(b.coat_wo.z, mu_i, b.coat_length_o, length_i);
        value = value + vec3f(coat);
        pdf += b.p_coat * reflection_pdf(b.coat_wo, d, b.coat_bound, b.coat_length_o);
    }
    return BsdfValue(value, pdf);
}

// Factor of the layers on light that crosses the surface: the outer side alone passes coat and sheen.
fn bsdf_layers_across(b: Bsdf, wi: vec3f) -> vec3f {
    let from_outside = b.below_coat * b.below_sheen;
    if !HAS_COAT {
        return from_outside;
    }
    let leaving = coat_passage(b.optics.coat_ln_tint, max(abs(wi.z), COS_MIN));
    return select(from_outside, leaving, b.is_inside);
}

// `bsdf_eval` for directions across the surface, in the mirrored frame (`wi.z < 0`). Source: Walter et al. 2007.
fn bsdf_eval_transmission(b: Bsdf, wi: vec3f) -> BsdfValue {
    let o = b.optics;
    // wo + eta wi, and its length in the place of cos_om + eta cos_im: nearly matched media leave no digits of either otherwise.
    let sum = (b.wo + wi) + wi * b.contrast;
    let sign = select(1.0, -1.0, sum.z < 0.0);
    let m = unit_or_z(sum * sign);
    let cos_om = dot(b.wo, m);
    let cos_im = dot(wi, m);
    let square = dot(sum, sum);
    let is_possible = cos_om > 0.0
        && cos_im < 0.0
        && m.z > 0.0
        && !o.is_smooth
        && !o.is_matched
        && square > 1e-24;
    let m_stretch = rotate_z(m, o.rotation_cos, -o.rotation_sin);
    let wi_stretch = rotate_z(wi, o.rotation_cos, -o.rotation_sin);
    let d = d_ggx(m_stretch, o.alpha_x, o.alpha_y);
    let pdf_m = vndf_pdf(b.wo, cos_om, d, b.length_o);
    let jacobian = sqr(b.eta) * abs(cos_im) / max(square, 1e-20);
    let g1 = g1_smith(wi_stretch, smith_length(wi_stretch, o.alpha_x, o.alpha_y));
    let facet = bsdf_interface_bent(b, saturate(cos_om), cos_im);
    let p = b.p_interface * (1.0 - bsdf_p_reflect(b, facet.reflected, facet.transmitted));
    let value = facet.transmitted * (pdf_m * g1 * jacobian) * bsdf_layers_across(b, wi);
    return BsdfValue(select(vec3f(0.0), value, is_possible), select(0.0, p * pdf_m * jacobian, is_possible));
}
