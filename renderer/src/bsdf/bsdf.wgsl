// How a surface scatters light: the layered material as one BSDF with `prepare`, `eval`, `sample`. Twin of `mod.rs`,
// where conventions and fields are described.

// Share of the selection that a lobe gets at least, unless that were more than ten times what it is expected to return: bounds weights.
const SELECTION_MIN: f32 = 0.05;
// Cosines below this are raised to it where they divide.
const COS_MIN: f32 = 1e-4;
// Least share of light that rough glass counts as keeping: bounds its gain at the very horizon.
const GLASS_KEPT_MIN: f32 = 0.01;
const FRAC_1_PI: f32 = 0.318309886183791;

// What a path brings to a point.
struct View {
    // Direction to the viewer: unit, local; below the surface it sees the body's inside.
    wo: vec3f,
    // Weight of the path: it steers the choice of lobe and nothing else.
    throughput: vec3f,
    // Normal of the coat, unit, local, on the outside, if it has one of its own.
    has_coat_normal: bool,
    coat_normal: vec3f,
    // Wavelength of the path in nanometres, the weights of the channels for it, and whether the path is light of it already.
    has_light: bool,
    nm: f32,
    weights: vec3f,
    is_dispersed: bool,
}

// A view along `wo` of white light, without a coat normal of its own, at the sodium line.
fn view_new(wo: vec3f) -> View {
    return View(wo, vec3f(1.0), false, vec3f(0.0, 0.0, 1.0), false, LAMBDA_D, vec3f(1.0), false);
}

struct Bsdf {
    optics: Optics,
    throughput: vec3f,
    place: Place,
    wo: vec3f,
    wo_stretch: vec3f,
    is_below: bool,
    is_inside: bool,
    eta: f32,
    contrast: f32,
    eta_fresnel: f32,
    eta_channels: vec3f,
    spectral: vec3f,
    glass_gain: f32,
    length_o: f32,
    bound: f32,
    coat: f32,
    has_coat_frame: bool,
    coat_frame: CoatFrame,
    coat_wo: vec3f,
    coat_length_o: f32,
    coat_bound: f32,
    below_coat: vec3f,
    below_sheen: f32,
    sheen: f32,
    diffuse_scale: f32,
    metal_scale: vec3f,
    p_coat: f32,
    p_sheen: f32,
    p_interface: f32,
    p_diffuse: f32,
}

// Axes of the base's tables for a wavelength in nanometres.
fn bsdf_numbers(optics: Optics, nm: f32) -> array<f32, AXES> {
    let share = (nm - WAVELENGTH_FIRST) / (WAVELENGTH_LAST - WAVELENGTH_FIRST);
    return array<f32, AXES>(optics.roughness, optics.anisotropy, sqrt(optics.level), optics.coat, share);
}

// Everything that depends on the viewing direction: albedos of the layers and the probabilities of the lobes.
//
// Lobes that are switched off are not evaluated; the words at `optics.albedos` must have been made for the same set.
fn bsdf_prepare(optics: Optics, view: View) -> Bsdf {
    let is_below = view.wo.z < 0.0;
    let is_inside = is_below && optics.w_transmission > 0.0;
    let wo = vec3f(view.wo.xy, max(abs(view.wo.z), 1e-6));
    let wo_stretch = rotate_z(wo, optics.rotation_cos, -optics.rotation_sin);
    let mu = max(wo.z, COS_MIN);
    let beta = view.throughput * (1.0 / max(max_channel(view.throughput), 1e-30));

    let base = grid_base(optics.albedos);
    let place = grid_place(base, bsdf_numbers(optics, LAMBDA_D));
    let slant = grid_slant(base, wo_stretch);
    var eta_outside = optics.eta;
    var eta_specular = optics.eta_specular;
    var eta_channels = vec3f(1.0);
    var spectral = vec3f(1.0);
    var glass_place = place;
    if HAS_DISPERSION && view.has_light {
        let at = optics_at_wavelength(optics, view.nm);
        eta_outside = at.eta;
        eta_specular = at.eta_specular;
        glass_place = grid_place(base, bsdf_numbers(optics, view.nm));
        let outside = select(optics_per_channel(optics, optics.eta_specular), vec3f(eta_specular), view.is_dispersed);
        let inside = select(optics_per_channel(optics, optics.eta), vec3f(eta_outside), view.is_dispersed);
        eta_channels = select(outside, 1.0 / inside, is_inside);
        // Without dispersion after all (an image, or a kernel that leaves nothing out) light stays white.
        let is_white = view.is_dispersed || optics.dispersion <= 0.0;
        spectral = select(view.weights, vec3f(1.0), is_white);
    } else if HAS_DISPERSION {
        eta_channels = vec3f(select(optics.eta_specular, 1.0 / optics.eta, is_inside));
    }
    let eta = select(eta_outside, 1.0 / eta_outside, is_inside);
    let contrast = select(eta_outside - 1.0, (1.0 - eta_outside) / eta_outside, is_inside);
    let eta_fresnel = select(eta_specular, eta, is_inside);
    var glass_gain = 1.0;
    if HAS_TRANSMISSION && HAS_MULTIPLE_SCATTERING {
        let quantity = select(GLASS_KEPT, GLASS_KEPT_INSIDE, is_inside);
        glass_gain = 1.0 / max(grid_at(base, quantity, glass_place, slant), GLASS_KEPT_MIN);
    }

    var coat = select(optics.coat, 0.0, is_inside);
    var e_coat = 0.0;
    var passage = vec3f(1.0);
    var coat_length_o = 1.0;
    var coat_bound = 1.0;
    var coat_frame: CoatFrame;
    let has_coat_frame = HAS_COAT && (HAS_COAT_NORMAL_MAP || HAS_NORMAL_MAP || HAS_HEIGHT) && view.has_coat_normal;
    var coat_wo = wo;
    if HAS_COAT {
        if has_coat_frame {
            // Seen from below, the frame is mirrored, and so is the normal that faces the viewer.
            let n = view.coat_normal;
            coat_frame = coat_frame_new(select(n, vec3f(-n.xy, n.z), is_below));
            coat_wo = coat_frame_local(coat_frame, wo);
            coat = select(0.0, coat, coat_wo.z > 0.0);
            coat_wo = vec3f(coat_wo.xy, max(coat_wo.z, COS_MIN));
        }
        let mu = max(coat_wo.z, COS_MIN);
        let exact = fresnel(mu, optics.coat_eta);
        let numbers = array<f32, AXES>(optics.coat_roughness, 0.0, sqrt(optics.coat_level), 0.0, 0.0);
        let grid = grid_coat(optics.albedos);
        let miss = grid_at(grid, DIELECTRIC_MISS, grid_place(grid, numbers), grid_slant(grid, coat_wo));
        e_coat = coat * select(1.0 - miss, exact, optics.coat_is_smooth);
        passage = select(coat_passage(optics.coat_ln_tint, mu), vec3f(1.0), is_inside);
        coat_length_o = smith_length(coat_wo, optics.coat_alpha, optics.coat_alpha);
        coat_bound = vndf_bound(coat_wo, optics.coat_alpha, optics.coat_alpha);
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
    let w_sheen = k1 * sheen * max_channel(optics.sheen_color) * e_sheen;
    var miss = 1.0;
    if HAS_SPECULAR || HAS_TRANSMISSION || HAS_DIFFUSE {
        miss = grid_at(base, DIELECTRIC_MISS, place, slant);
    }
    let e_dielectric = select(1.0 - miss, fresnel(mu, eta_fresnel), is_inside);
    var reflected = vec3f(0.0);
    var w_diffuse = 0.0;
    var diffuse_scale = 0.0;
    var metal_scale = vec3f(0.0);
    if HAS_METAL {
        reflected = f82_tint(mu, optics.base_color, optics.f82) * optics.w_metal;
    }
    if HAS_METAL && HAS_MULTIPLE_SCATTERING {
        let lost = grid_at(base, METAL_MISS, place, slant);
        let mean = max(grid_mean(base, METAL_MISS, place), 1e-9);
        let average = f82_average(optics.base_color, optics.f82);
        let further = average * average * (optics.w_metal * lost);
        metal_scale = further * (FRAC_1_PI / mean);
        w_diffuse = k2 * max_channel(beta * further);
    }
    if HAS_SPECULAR {
        let tint = select(optics.edge_color, vec3f(1.0), is_inside);
        reflected = reflected + tint * ((optics.w_diffuse + optics.w_transmission) * e_dielectric);
    }
    var w_interface = k2 * max_channel(beta * reflected);
    if HAS_TRANSMISSION {
        w_interface += k2 * optics.w_transmission * max_channel(beta * optics.transmission_tint) * (1.0 - e_dielectric);
    }
    if HAS_DIFFUSE {
        let mean = grid_mean(base, DIELECTRIC_MISS, place);
        w_diffuse += k2 * optics.w_diffuse * max_channel(beta * optics.base_color) * miss;
        diffuse_scale = optics.w_diffuse * miss * FRAC_1_PI / max(mean, 1e-6);
    }
    let p = probabilities(vec4f(e_coat, w_sheen, w_interface, w_diffuse));
    let transmits = optics.w_transmission > 0.0;
    let bound = select(vndf_bound(wo_stretch, optics.alpha_x, optics.alpha_y), 1.0, transmits);

    var b: Bsdf;
    b.optics = optics;
    b.throughput = beta;
    b.place = place;
    b.wo = wo;
    b.wo_stretch = wo_stretch;
    b.is_below = is_below;
    b.is_inside = is_inside;
    b.eta = eta;
    b.contrast = contrast;
    b.eta_fresnel = eta_fresnel;
    b.eta_channels = eta_channels;
    b.spectral = spectral;
    b.glass_gain = glass_gain;
    b.length_o = smith_length(wo_stretch, optics.alpha_x, optics.alpha_y);
    b.bound = bound;
    b.coat = coat;
    b.has_coat_frame = has_coat_frame;
    b.coat_frame = coat_frame;
    b.coat_wo = coat_wo;
    b.coat_length_o = coat_length_o;
    b.coat_bound = coat_bound;
    b.below_coat = below_coat;
    b.below_sheen = below_sheen;
    b.sheen = sheen;
    b.diffuse_scale = diffuse_scale;
    b.metal_scale = metal_scale;
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

// A direction of the mirrored frame in the frame of the coat.
fn bsdf_in_coat(b: Bsdf, w: vec3f) -> vec3f {
    if HAS_COAT && (HAS_COAT_NORMAL_MAP || HAS_NORMAL_MAP || HAS_HEIGHT) && b.has_coat_frame {
        return coat_frame_local(b.coat_frame, w);
    }
    return w;
}

// Weights to probabilities.
fn probabilities(weights: vec4f) -> vec4f {
    let sum = weights.x + weights.y + weights.z + weights.w;
    let share = weights * (1.0 / select(1.0, sum, sum > 0.0));
    let p = select(vec4f(0.0), max(share, min(vec4f(SELECTION_MIN), 10.0 * share)), weights > vec4f(0.0));
    let p_sum = p.x + p.y + p.z + p.w;
    return p * (1.0 / select(1.0, p_sum, p_sum > 0.0));
}
