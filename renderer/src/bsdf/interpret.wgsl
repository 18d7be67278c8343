// What the properties mean: inputs at one point to the numbers that the lobes use. Twin of `interpret.rs`, where the
// fields of `Optics` are described.

// Smallest absorption colour: caps the optical depth at 6.9 per absorption distance. Model reference 10.1.
const ABSORPTION_COLOR_MIN: f32 = 1e-3;
// Smallest length in scene units. Model reference 10.2.
const LENGTH_MIN: f32 = 1e-6;
// Contrast of refraction below which light passes straight on.
const MATCHED_CONTRAST: f32 = 1e-6;
// Smallest other contrast: half vectors made from it err by about 1 % of the narrowest lobe in single precision.
const CONTRAST_MIN: f32 = 5e-4;
// Smallest channel of the distance scale, and smallest ratio of albedos between channels. Model reference 10.2.
const SCATTER_RATIO_MIN: f32 = 1e-3;
// Largest dispersion: an Abbe number of 1.
const DISPERSION_MAX: f32 = 20.0;
// Largest emitted radiance: sums along a path and over a picture stay within single precision.
const EMISSION_MAX: f32 = 1e30;

struct Optics {
    base_color: vec3f,
    edge_color: vec3f,
    f82: vec3f,
    w_metal: f32,
    w_diffuse: f32,
    w_transmission: f32,
    roughness: f32,
    anisotropy: f32,
    level: f32,
    alpha_x: f32,
    alpha_y: f32,
    rotation_cos: f32,
    rotation_sin: f32,
    is_smooth: bool,
    eta: f32,
    eta_specular: f32,
    dispersion: f32,
    is_matched: bool,
    sheen: f32,
    sheen_color: vec3f,
    sheen_roughness: f32,
    coat: f32,
    coat_ln_tint: vec3f,
    coat_roughness: f32,
    coat_level: f32,
    coat_alpha: f32,
    coat_is_smooth: bool,
    coat_eta: f32,
    transmission_tint: vec3f,
    sigma_a: vec3f,
    sigma_s: vec3f,
    emission: vec3f,
    opacity: f32,
    // Where the words of the material's albedos begin in `albedo_tables`; set by the caller.
    albedos: u32,
}

// Meaning of the inputs. `length_scale` is scene units per unit of the material's lengths.
//
// Inputs may lie outside their hard ranges (textures): they are clamped here. Lobes that are switched off are not
// computed; their fields hold what leaves them without effect.
fn interpret(inputs: Inputs, length_scale: f32) -> Optics {
    let base_color = saturate(inputs.base_color);
    let edge_color = saturate(inputs.specular_edge_color);

    // Metal covers everything dielectric; translucency divides the rest (specification, "Metal and dielectric").
    let w_metal = select(0.0, saturate(inputs.metallic), HAS_METAL);
    let translucency = select(0.0, saturate(inputs.translucency), HAS_TRANSMISSION);
    let w_transmission = (1.0 - w_metal) * translucency;
    let w_diffuse = (1.0 - w_metal) * (1.0 - translucency);

    let roughness = saturate(inputs.roughness);
    let anisotropy = select(0.0, saturate(inputs.anisotropy), HAS_ANISOTROPY);
    let base_alphas = alphas(roughness, anisotropy);
    var rotation_cos = 1.0;
    var rotation_sin = 0.0;
    if HAS_ANISOTROPY {
        // Whole turns go first: times 2 pi, those of an image of large texels would leave no digits.
        let turn = inputs.anisotropy_rotation - floor(inputs.anisotropy_rotation);
        rotation_cos = cos(2.0 * PI * turn);
        rotation_sin = sin(2.0 * PI * turn);
    }

    let coat = select(0.0, saturate(inputs.coat), HAS_COAT);
    let ior = max(inputs.specular_ior, 1e-3);
    let level = saturate(inputs.specular_level);
    let eta_apart_from_level = level_to_ior(ior, level);
    let coat_ior = max(inputs.coat_ior, 1e-3);
    var eta_specular = eta_apart_from_level;
    if HAS_COAT {
        // The base sees the coat as its surroundings. Blending reflectances keeps the ratio above 1, so no false total
        // reflection appears where the coat is the denser medium (model reference 8.2).
        let f0 = mix(f0_from_ior(ior), f0_from_ior(ior / coat_ior), coat) * 2.0 * level;
        eta_specular = select(eta_apart_from_level, ior_from_f0(f0), coat > 0.0);
    }
    let is_matched = abs(eta_apart_from_level - 1.0) < MATCHED_CONTRAST;
    // A half vector needs some contrast: nearly matched media are moved to the smallest that single precision holds.
    let contrast = abs(eta_apart_from_level - 1.0);
    let eta_apart = select(1.0 + CONTRAST_MIN, 1.0 - CONTRAST_MIN, eta_apart_from_level < 1.0);
    let eta = select(select(eta_apart_from_level, eta_apart, contrast < CONTRAST_MIN), 1.0, is_matched);

    let coat_tint = mix(vec3f(1.0), saturate(inputs.coat_color), coat);
    let coat_roughness = saturate(inputs.coat_roughness);
    let coat_level = saturate(inputs.coat_specular_level);
    let coat_alphas = alphas(coat_roughness, 0.0);

    var medium = Medium(vec3f(0.0), vec3f(0.0));
    if HAS_SCATTERING && inputs.scatter {
        medium = scattering(inputs, length_scale);
    }
    var transmission_tint = vec3f(1.0);
    var sigma_a = vec3f(0.0);
    if HAS_ABSORPTION {
        let color = saturate(inputs.absorption_color);
        let distance = max(inputs.absorption_distance, 0.0) * length_scale;
        let is_modulative = inputs.absorption_distance <= 0.0;
        let ln = log(max(color, vec3f(ABSORPTION_COLOR_MIN)));
        sigma_a = select(max(-ln / max(distance, LENGTH_MIN), vec3f(0.0)), vec3f(0.0), is_modulative);
        transmission_tint = select(vec3f(1.0), sqrt(color), is_modulative);
    }

    var emission = vec3f(0.0);
    if HAS_EMISSION {
        let strength = max(inputs.emission, 0.0);
        emission = min(max(inputs.emission_color, vec3f(0.0)) * strength, vec3f(EMISSION_MAX));
    }

    var optics: Optics;
    optics.base_color = base_color;
    optics.edge_color = edge_color;
    optics.f82 = f82_coefficient(base_color, edge_color);
    optics.w_metal = w_metal;
    optics.w_diffuse = w_diffuse;
    optics.w_transmission = w_transmission;
    optics.roughness = roughness;
    optics.anisotropy = anisotropy;
    optics.level = level;
    optics.alpha_x = base_alphas.x;
    optics.alpha_y = base_alphas.y;
    optics.rotation_cos = rotation_cos;
    optics.rotation_sin = rotation_sin;
    optics.is_smooth = base_alphas.is_smooth;
    optics.eta = eta;
    optics.eta_specular = eta_specular;
    optics.dispersion = select(0.0, clamp(inputs.dispersion, 0.0, DISPERSION_MAX), HAS_DISPERSION);
    optics.is_matched = is_matched;
    optics.sheen = select(0.0, saturate(inputs.sheen), HAS_SHEEN);
    optics.sheen_color = saturate(inputs.sheen_color);
    optics.sheen_roughness = max(saturate(inputs.sheen_roughness), SHEEN_ROUGHNESS_MIN);
    optics.coat = coat;
    optics.coat_ln_tint = log(max(coat_tint, vec3f(1e-6)));
    optics.coat_roughness = coat_roughness;
    optics.coat_level = coat_level;
    optics.coat_alpha = coat_alphas.x;
    optics.coat_is_smooth = coat_alphas.is_smooth;
    optics.coat_eta = level_to_ior(coat_ior, coat_level);
    optics.transmission_tint = transmission_tint;
    optics.sigma_a = sigma_a + medium.sigma_a;
    optics.sigma_s = medium.sigma_s;
    optics.emission = emission;
    optics.opacity = select(1.0, saturate(inputs.opacity), HAS_OPACITY);
    return optics;
}

// Scattering and absorption coefficients of a medium, 1/scene unit.
struct Medium {
    sigma_s: vec3f,
    sigma_a: vec3f,
}

// Coefficients of the scattering medium. Model reference 10.2.
//
// The single-scattering albedo inverts van de Hulst's formula for the colour of a thick body (Kulla and Conty 2017); its complement
// is kept as a square of its own, because `1 - a` loses all digits near white.
fn scattering(inputs: Inputs, length_scale: f32) -> Medium {
    let color = saturate(inputs.scatter_color);
    let dark = 1.0 - color;
    let b = 1.139 + 1.17 * color;
    let s = 2.0 * dark / (b + sqrt(b * b - 0.556 * dark));
    let albedo = (1.0 - s) * (1.0 + s);
    let largest = max_channel(albedo);
    let distance = max(max(inputs.scatter_distance, 0.0) * length_scale, LENGTH_MIN);
    let ratio = largest / max(max(albedo, vec3f(largest * SCATTER_RATIO_MIN)), vec3f(1e-30));
    let scale = max(inputs.scatter_distance_scale, vec3f(SCATTER_RATIO_MIN));
    let plain = select(vec3f(1.0), ratio, largest > 0.0) / (distance * scale);
    // Rayleigh scattering grows with the fourth power of frequency: factors at 640, 540 and 460 nm.
    let rayleigh = clamp(inputs.scatter_rayleigh, -1.0, 2.0);
    let red = 1.0 + rayleigh * (RAYLEIGH_RED - 1.0);
    let blue = 1.0 + rayleigh * (RAYLEIGH_BLUE - 1.0);
    // Red shift 1 lets red travel ten times further.
    let shift = exp(clamp(inputs.scatter_red_shift * -LN_10, -60.0, 60.0));
    let extinction = min(plain * vec3f(red * shift, 1.0, blue), vec3f(1.0 / LENGTH_MIN / LENGTH_MIN));
    return Medium(extinction * albedo, extinction * s * s);
}

const LN_10: f32 = 2.302585092994046;
// (540 / 640)^4 and (540 / 460)^4.
const RAYLEIGH_RED: f32 = 0.5068216324;
const RAYLEIGH_BLUE: f32 = 1.8990819787;

// The same for light of one wavelength, nanometres.
fn optics_at_wavelength(optics: Optics, wavelength: f32) -> Optics {
    let x = 1.0 / (wavelength * wavelength);
    var at = optics;
    at.eta = dispersed_ior(optics.eta, optics.dispersion, x);
    at.eta_specular = dispersed_ior(optics.eta_specular, optics.dispersion, x);
    return at;
}

// Index of refraction for the reflectance from outside, or of its bending, as red, green and blue see it.
fn optics_per_channel(optics: Optics, eta: f32) -> vec3f {
    return vec3f(
        dispersed_ior(eta, optics.dispersion, INVERSE_SQUARE.x),
        dispersed_ior(eta, optics.dispersion, INVERSE_SQUARE.y),
        dispersed_ior(eta, optics.dispersion, INVERSE_SQUARE.z),
    );
}
