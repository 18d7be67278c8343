//! A material as OSL: closures of the same meaning, layered as the model layers them. The closures are those that OSL shares with
//! MaterialX (Open Shading Language specification 1.12, "Material closures").

use super::comments::{clean, commented, list, title};
use super::source::{float, is_used};
use super::tree::words;
use super::{Language, ShaderOptions};
use burnish_material::{Kind, Lobe, LobeSet, Material, PROPERTIES, PropertyDef, Value};

/// Functions that the shader may call; those that it does are written.
const HELPERS: &[(&str, &str)] = &[
    ("sqr", "float sqr(float x)\n{\n    return x * x;\n}\n"),
    (
        "f0_of_ior",
        "// Reflectance at normal incidence.\nfloat f0_of_ior(float n)\n{\n    return sqr((n - 1.0) / (n + 1.0));\n}\n",
    ),
    (
        "ior_of_f0",
        "// Index of refraction, at least 1, with this reflectance at normal incidence.\nfloat ior_of_f0(float f0)\n{\n    float s = sqrt(clamp(f0, 0.0, 0.9999));\n    return (1.0 + s) / (1.0 - s);\n}\n",
    ),
    (
        "level_to_ior",
        "// Index of refraction after the specular level: linear in reflectance, 0.5 leaves it.\nfloat level_to_ior(float n, float level)\n{\n    float scaled = ior_of_f0(2.0 * level * f0_of_ior(n));\n    return n < 1.0 ? 1.0 / scaled : scaled;\n}\n",
    ),
    (
        "f82_tint",
        "// Reflectance of metal over Schlick's curve, at cosine mu: r at normal incidence, tinted by t towards the edge.\ncolor f82_tint(float mu, color r, color t)\n{\n    float u5 = pow(1.0 - mu, 5.0);\n    color schlick = r + (1.0 - r) * u5;\n    color lost = (1.0 - t) * (49.0 / 6.0 + 9.484717935528 * r) * (mu * (1.0 - mu) * u5);\n    return clamp((schlick - lost) / max(schlick, color(1e-6)), color(0.0), color(1.0));\n}\n",
    ),
    (
        "albedo_of_color",
        "// Single-scattering albedo that gives a thick body this colour.\nfloat albedo_of_color(float c)\n{\n    float b = 1.139 + 1.17 * c;\n    float s = 2.0 * (1.0 - c) / (b + sqrt(b * b - 0.556 * (1.0 - c)));\n    return (1.0 - s) * (1.0 + s);\n}\n",
    ),
];

/// The text of the shader.
pub(super) fn text(material: &Material, options: ShaderOptions) -> String {
    let lobes = LobeSet::of(material);
    let statements = statements(lobes);
    let is_read = |def: &&PropertyDef| is_used(def.id, lobes) && words(&statements).any(|(_, word)| word == name_of(def));
    let used: Vec<_> = PROPERTIES.iter().filter(is_read).collect();
    let is_parameter = |def: &&PropertyDef| options.is_uniform || material.is_textured(def.id);
    let (parameters, constants): (Vec<_>, Vec<_>) = used.into_iter().partition(is_parameter);
    let inputs = material.inputs();
    let declared = |def: &PropertyDef| format!("{} = {}", declaration(def), literal(inputs.value(def.id)));

    let mut body: String = constants.iter().map(|def| format!("    {};\n", declared(def))).collect();
    if !body.is_empty() {
        body.push('\n');
    }
    body += &statements;
    let mut helpers = String::new();
    // A helper calls only those above it.
    for (name, text) in HELPERS.iter().rev() {
        if body.contains(&format!("{name}(")) || helpers.contains(&format!("{name}(")) {
            helpers = format!("{text}\n{helpers}");
        }
    }
    let parameters = parameters.iter().map(|def| format!("    // {}\n    {}", def.doc, declared(def))).collect::<Vec<_>>();
    let parameters = if parameters.is_empty() { String::new() } else { format!("\n{}\n", parameters.join(",\n")) };
    format!("{}\n{helpers}surface {}({parameters})\n{{\n{body}}}\n", header(material, lobes), identifier(&material.name))
}

fn header(material: &Material, lobes: LobeSet) -> String {
    let mut lines = title(material, lobes, Language::Osl);
    lines.extend(
        [
            "A surface shader for renderers with OSL's material closures (1.12 or newer); `roughness_x` and `roughness_y` of those closures are taken as GGX alpha.",
            "Colours are linear Rec.709. The tangent is dPdu, the normal N.",
        ]
        .map(str::to_owned),
    );
    lines.push(format!("Lengths are in units of the material, {} mm each.", material.unit_mm()));
    let textured: Vec<&str> =
        material.slots().filter(|(p, slot)| slot.texture.is_some() && is_used(*p, lobes)).map(|(p, _)| p.def().name).collect();
    if !textured.is_empty() {
        lines.push(format!("Parameters to connect images to, linear: {}.", list(&textured)));
    }
    let frame = [Lobe::normal_map, Lobe::coat_normal_map, Lobe::height];
    let frame: Vec<&str> = frame.into_iter().filter(|lobe| lobes.has(*lobe)).map(|lobe| lobe.def().name).collect();
    if !frame.is_empty() {
        lines.push(format!("The caller's, because they bend or move the surface: {}.", list(&frame)));
    }
    let differs = [
        (Lobe::dispersion, "dispersion has no closure; the mean index of refraction is used"),
        (Lobe::multiple_scattering, "energy lost between facets is made up by the renderer, or not at all"),
        (Lobe::coat, "the coat's tint takes the angle of the viewer for that of the light as well"),
        (Lobe::metal, "the tint of metal edges is that of the viewer's angle, not of each facet's"),
        (Lobe::sheen, "sheen is the closure's lobe, with the same numbers"),
    ];
    for (_, text) in differs.iter().filter(|(lobe, _)| lobes.has(*lobe)) {
        lines.push(format!("Differs: {text}."));
    }
    commented(&lines)
}

/// The statements for these lobes.
fn statements(lobes: LobeSet) -> String {
    let has = |lobe| lobes.has(lobe);
    let mut text = String::new();
    let mut add = |is_in: bool, lines: &str| {
        if is_in {
            text += lines;
        }
    };
    let has_dielectric = has(Lobe::specular) || has(Lobe::transmission);
    let has_facets = has(Lobe::metal) || has_dielectric;
    add(true, "    normal n = normalize(N);\n");
    add(has_facets, "    vector t = normalize(dPdu);\n");
    add(
        has_facets && has(Lobe::anisotropy),
        "    float turn = 2.0 * M_PI * anisotropy_rotation;\n    t = cos(turn) * t + sin(turn) * cross(n, t);\n",
    );
    add(has(Lobe::metal) || has(Lobe::coat), "    float mu = clamp(abs(dot(n, I)) / max(length(I), 1e-20), 1e-4, 1.0);\n");
    add(has_facets, "    float alpha_y = sqr(roughness);\n");
    add(has_facets && has(Lobe::anisotropy), "    float alpha_x = min(alpha_y + sqr(sqr(anisotropy)), 1.0);\n");
    add(has_facets && !has(Lobe::anisotropy), "    float alpha_x = alpha_y;\n");
    add(has_dielectric, "    float eta = level_to_ior(max(specular_ior, 1e-3), specular_level);\n");
    let is_coated = has(Lobe::coat) && has(Lobe::specular);
    add(
        is_coated && has(Lobe::diffuse),
        "    // The base sees the coat as its surroundings.\n    float f0 = mix(f0_of_ior(specular_ior), f0_of_ior(specular_ior / max(coat_ior, 1e-3)), coat) * 2.0 * specular_level;\n    float eta_below = coat > 0.0 ? ior_of_f0(f0) : eta;\n",
    );
    let eta_below = if is_coated { "eta_below" } else { "eta" };
    add(true, "\n    closure color result = 0;\n");
    if has(Lobe::diffuse) {
        let diffuse = "oren_nayar_diffuse_bsdf(n, base_color, 0.0)";
        let opaque = if has(Lobe::specular) {
            format!(
                "layer(dielectric_bsdf(n, t, specular_edge_color, color(0.0), alpha_x, alpha_y, {eta_below}, \"ggx\"), {diffuse})"
            )
        } else {
            diffuse.to_owned()
        };
        add(true, &format!("    result = {opaque};\n"));
    }
    if has(Lobe::transmission) {
        let tint = if has(Lobe::absorption) { "tint" } else { "color(1.0)" };
        add(
            has(Lobe::absorption),
            "    // At distance 0 the colour tints each crossing instead of the body.\n    color tint = absorption_distance > 0.0 ? color(1.0) : sqrt(clamp(absorption_color, color(0.0), color(1.0)));\n",
        );
        add(
            true,
            &format!(
                "    closure color glass = dielectric_bsdf(n, t, specular_edge_color, {tint}, alpha_x, alpha_y, eta, \"ggx\");\n"
            ),
        );
        medium(lobes, &mut add);
        let mixed = if has(Lobe::diffuse) { "(1.0 - translucency) * result + translucency * glass" } else { "glass" };
        add(true, &format!("    result = {mixed};\n"));
    }
    if has(Lobe::metal) {
        add(
            true,
            "    closure color metal = generalized_schlick_bsdf(n, t, f82_tint(mu, base_color, specular_edge_color), color(0.0), alpha_x, alpha_y, base_color, color(1.0), 5.0, \"ggx\");\n    result = (1.0 - metallic) * result + metallic * metal;\n",
        );
    }
    let has_layers = has(Lobe::sheen) || has(Lobe::coat);
    // Seen through the body there is neither coat nor sheen.
    let (open, indent, close) = match has_layers && has(Lobe::transmission) {
        true => ("    if (!backfacing()) {\n", "        ", "    }\n"),
        false => ("", "    ", ""),
    };
    add(has_layers, open);
    add(
        has(Lobe::sheen),
        &format!("{indent}result = layer(sheen * sheen_bsdf(n, sheen_color, max(sheen_roughness, 1e-3)), result);\n"),
    );
    if has(Lobe::coat) {
        for line in [
            "float coat_eta = level_to_ior(max(coat_ior, 1e-3), coat_specular_level);",
            "// Twice through a layer that is longer at grazing angles.",
            "float passages = 2.0 * (0.25 + 0.1575 / mix(0.24, 1.0, mu * mu));",
            "color coat_tint = pow(max(mix(color(1.0), coat_color, coat), color(1e-6)), passages);",
            "float coat_alpha = sqr(coat_roughness);",
            "closure color coat_lobe = dielectric_bsdf(n, normalize(dPdu), color(1.0), color(0.0), coat_alpha, coat_alpha, coat_eta, \"ggx\");",
            "result = layer(coat * coat_lobe, coat_tint * result);",
        ] {
            add(true, &format!("{indent}{line}\n"));
        }
    }
    add(has_layers, close);
    add(
        has(Lobe::emission),
        "    if (!backfacing())\n        result = result + emission_strength * emission_color * emission();\n",
    );
    add(has(Lobe::opacity), "    result = opacity * result + (1.0 - opacity) * transparent();\n");
    add(true, "\n    Ci = result;\n");
    text
}

/// What the light meets in a refracting body.
fn medium(lobes: LobeSet, add: &mut impl FnMut(bool, &str)) {
    let (absorbs, scatters) = (lobes.has(Lobe::absorption), lobes.has(Lobe::scattering));
    if !absorbs && !scatters {
        return;
    }
    add(true, "    color sigma_a = 0.0;\n    color sigma_s = 0.0;\n");
    add(
        absorbs,
        "    if (absorption_distance > 0.0)\n        sigma_a = -log(clamp(absorption_color, color(1e-3), color(1.0))) / absorption_distance;\n",
    );
    for line in [
        "color albedo = color(albedo_of_color(scatter_color[0]), albedo_of_color(scatter_color[1]), albedo_of_color(scatter_color[2]));",
        "float largest = max(albedo[0], max(albedo[1], albedo[2]));",
        "color ratio = largest > 0.0 ? largest / max(albedo, color(largest * 1e-3)) : color(1.0);",
        "// Rayleigh scattering grows with the fourth power of frequency; red shift 1 lets red travel ten times further.",
        "color further = color((1.0 + scatter_rayleigh * (0.5068216324 - 1.0)) * pow(0.1, scatter_red_shift), 1.0, 1.0 + scatter_rayleigh * (1.8990819787 - 1.0));",
        "color extinction = ratio * further / (max(scatter_distance, 1e-6) * max(scatter_distance_scale, color(1e-3)));",
        "sigma_s = extinction * albedo;",
        "sigma_a = sigma_a + extinction * (1.0 - albedo);",
    ] {
        add(scatters, &format!("    {line}\n"));
    }
    add(
        true,
        "    color sigma_t = max(sigma_s + sigma_a, color(1e-12));\n    glass = layer(glass, anisotropic_vdf(sigma_s / sigma_t, sigma_t, 0.0));\n",
    );
}

/// Type and name.
fn declaration(def: &PropertyDef) -> String {
    let kind = match def.default.kind() {
        Kind::Float => "float",
        Kind::Bool => "int",
        Kind::Color => "color",
        Kind::Normal => "normal",
    };
    format!("{kind} {}", name_of(def))
}

/// The name of a property in the shader: not that of a closure.
fn name_of(def: &PropertyDef) -> &'static str {
    if def.name == "emission" { "emission_strength" } else { def.name }
}

fn literal(value: Value) -> String {
    match value {
        Value::Float(x) => float(x as f32),
        Value::Bool(on) => i32::from(on).to_string(),
        Value::Color(v) => format!("color({})", v.map(|x| float(x as f32)).join(", ")),
        Value::Normal(v) => format!("normal({})", v.map(|x| float(x as f32)).join(", ")),
    }
}

/// The name of the shader.
fn identifier(name: &str) -> String {
    let words: Vec<String> =
        clean(name).split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty()).map(str::to_lowercase).collect();
    let name = words.join("_");
    format!("asm_{}", if name.is_empty() { "material" } else { &name })
}
