//! The material as WGSL: its values, the tables made for them, the functions that callers use, and the lobes behind them.

use super::ShaderOptions;
use super::prune::pruned;
use crate::bsdf::Albedos;
use crate::bsdf::tables::sheen_table;
use crate::preview::shader::{join, printed_spectrum, twins};
use burnish_material::{Group, Inputs, Kind, Lobe, LobeSet, Material, PROPERTIES, Property, PropertyDef, Value, acts_through};
use std::fmt::Write;

/// Most numbers that the tables of the base run over, the azimuth of stretched ones included; each further one would make them ten times as
/// large.
const AXES_MAX: usize = 2;

/// A material taken apart for a shader.
pub(super) struct Source {
    pub lobes: LobeSet,
    /// Properties that the caller fills in from images.
    pub textured: Vec<&'static PropertyDef>,
    /// Properties in the uniform block.
    pub uniform: Vec<&'static PropertyDef>,
    /// Properties that change, while the tables have one value for them.
    pub frozen: Vec<&'static PropertyDef>,
    /// Functions for the caller.
    pub functions: Vec<&'static str>,
    /// Text without the tables.
    pub text: String,
    /// What `albedo_tables` holds.
    pub tables: Vec<f32>,
}

/// Whether a property changes what the code for these lobes computes.
pub(super) fn is_used(property: Property, lobes: LobeSet) -> bool {
    let own = match property {
        Property::metallic => Some(Lobe::metal),
        Property::sheen => Some(Lobe::sheen),
        Property::coat => Some(Lobe::coat),
        Property::emission => Some(Lobe::emission),
        Property::opacity => Some(Lobe::opacity),
        _ => None,
    };
    // Normals and heights bend the frame, which is the caller's.
    let is_of_frame = |lobe: &Lobe| [Lobe::normal_map, Lobe::coat_normal_map, Lobe::height].contains(lobe);
    let through = acts_through(property);
    ![Group::Auxiliary, Group::Detail].contains(&property.def().group)
        && own.is_none_or(|lobe| lobes.has(lobe))
        && !through.iter().any(is_of_frame)
        && (through.is_empty() || through.iter().any(|lobe| lobes.has(*lobe)))
}

/// Properties that the tables depend on without running over them: they cannot change once the shader is written.
fn is_fixed_by_tables(property: Property) -> bool {
    use Property::*;
    [anisotropy, specular_level, specular_ior, dispersion, coat, coat_ior, coat_specular_level].contains(&property)
}

impl Source {
    pub fn new(material: &Material, options: ShaderOptions) -> Self {
        let lobes = LobeSet::of(material);
        let used = PROPERTIES.iter().filter(|def| is_used(def.id, lobes));
        let (textured, constant): (Vec<_>, Vec<_>) = used.partition(|def| material.is_textured(def.id));
        let mut uniform = Vec::new();
        if options.is_uniform {
            let is_free = |def: &&&PropertyDef| def.default.kind() != Kind::Bool && !is_fixed_by_tables(def.id);
            uniform = constant.iter().filter(is_free).copied().collect();
        }
        let (axes, frozen) = axes(lobes, |p| textured.iter().chain(&uniform).any(|def| def.id == p));
        let inputs = material.inputs().convert(|x| f64::from(x as f32));
        // Those of the mean index of refraction: wavelengths would be one more axis, for a difference that nobody sees.
        let albedos = Albedos::new(&inputs, lobes.without(Lobe::dispersion), |p| axes.contains(&p), []);
        let mut tables = if lobes.has(Lobe::sheen) { sheen_table().to_vec() } else { Vec::new() };
        let begin = tables.len();
        tables.extend(albedos.words());

        let mut source = Self {
            lobes,
            textured,
            uniform,
            frozen: frozen.into_iter().map(Property::def).collect(),
            functions: functions(lobes),
            text: String::new(),
            tables,
        };
        let mut text = source.interface(&inputs, begin);
        if lobes.has(Lobe::dispersion) {
            text += &printed_spectrum();
        }
        text += &join(&twins(Some(lobes)));
        let mut roots = source.functions.clone();
        roots.push("Textured");
        source.text = pruned(&text, lobes, &roots);
        source
    }

    /// The functions and structs that callers use.
    fn interface(&self, inputs: &Inputs<f64>, begin: usize) -> String {
        let mut text = String::new();
        let (take, pass) = match self.textured.is_empty() {
            true => ("", ""),
            false => ("textured: Textured", "textured"),
        };
        let comma = |rest: &str| if rest.is_empty() { String::new() } else { format!("{rest}, ") };
        let (take_first, pass_first) = (comma(take), comma(pass));
        // Writing to a String cannot fail.
        if !self.textured.is_empty() {
            _ = writeln!(
                text,
                "// What the images of the material hold at one point, linear, in the place of its values.\nstruct Textured {{"
            );
            for def in &self.textured {
                let kind = if def.default.kind() == Kind::Float { "f32" } else { "vec3f" };
                _ = writeln!(text, "    // {}\n    {}: {kind},", def.doc, def.name);
            }
            text += "}\n\n";
        }
        if !self.uniform.is_empty() {
            text += "// Values that can change without a new shader: numbers in x, colours in xyz.\nstruct MaterialBlock {\n";
            for def in &self.uniform {
                _ = writeln!(text, "    // {}\n    {}: vec4f,", def.doc, def.name);
            }
            text += "}\n\n@group(0) @binding(0) var<uniform> material: MaterialBlock;\n\n";
        }
        _ = writeln!(
            text,
            "// The values of the material at one point.\nfn material_inputs({take}) -> Inputs {{\n    var inputs: Inputs;"
        );
        for def in PROPERTIES.iter().filter(|def| is_used(def.id, self.lobes)) {
            let name = def.name;
            let is_in = |list: &[&PropertyDef]| list.iter().any(|other| other.id == def.id);
            let value = if is_in(&self.textured) {
                format!("textured.{name}")
            } else if is_in(&self.uniform) {
                format!("material.{name}.{}", if def.default.kind() == Kind::Float { "x" } else { "xyz" })
            } else {
                literal(inputs.value(def.id))
            };
            _ = writeln!(text, "    inputs.{name} = {value};");
        }
        _ = writeln!(text, "    return inputs;\n}}\n");
        text += &FUNCTIONS
            .replace("{take}", take)
            .replace("{pass}", pass)
            .replace("{take, }", &take_first)
            .replace("{pass, }", &pass_first)
            .replace("{begin}", &format!("{begin}u"));
        text
    }

    /// The declaration of the tables; `None` where nothing reads them.
    pub fn tables(&self, declaration: Tables) -> Option<String> {
        if !self.text.contains("albedo_tables") {
            return None;
        }
        let count = self.tables.len();
        let numbers = rows(&self.tables);
        Some(match declaration {
            Tables::Constant => format!("const albedo_tables = array<f32, {count}>(\n{numbers});\n"),
            Tables::Variable => format!("var<private> albedo_tables: array<f32, {count}> = array<f32, {count}>(\n{numbers});\n"),
            Tables::Empty => format!("var<private> albedo_tables: array<f32, {count}>;\n"),
        })
    }
}

/// How the tables are declared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tables {
    /// A constant, for languages that index constants.
    Constant,
    /// A variable that begins with the numbers: SPIR-V, and what becomes it, copies a constant at each lookup.
    Variable,
    /// A variable without them: they are put in later.
    Empty,
}

/// Numbers of the tables, some to a line, with a comma after all but the last.
pub(super) fn rows(numbers: &[f32]) -> String {
    let line = |row: &[f32]| row.iter().map(|x| float(*x)).collect::<Vec<_>>().join(", ");
    numbers.chunks(16).map(line).collect::<Vec<_>>().join(",\n") + "\n"
}

/// Numbers that the tables run over, and those that change although the tables have no room for them.
fn axes(lobes: LobeSet, changes: impl Fn(Property) -> bool) -> (Vec<Property>, Vec<Property>) {
    use Property as P;
    let mut axes = Vec::new();
    let mut frozen = Vec::new();
    let mut left = AXES_MAX - usize::from(lobes.has(Lobe::anisotropy));
    for property in [P::roughness, P::anisotropy, P::specular_level, P::coat] {
        let matters = match property {
            P::anisotropy => lobes.has(Lobe::anisotropy),
            P::coat => lobes.has(Lobe::coat),
            _ => true,
        };
        if !changes(property) || !matters {
            continue;
        }
        if left > 0 {
            left -= 1;
            axes.push(property);
        } else {
            frozen.push(property);
        }
    }
    axes.extend([P::coat_roughness, P::coat_specular_level].into_iter().filter(|p| lobes.has(Lobe::coat) && changes(*p)));
    (axes, frozen)
}

fn functions(lobes: LobeSet) -> Vec<&'static str> {
    let mut names =
        vec!["material_eval", "material_pdf", "material_sample", "material_prepare", "view_new", "bsdf_eval", "bsdf_sample"];
    let further = [
        ("view_dispersed", lobes.has(Lobe::dispersion)),
        ("material_opacity", lobes.has(Lobe::opacity)),
        ("material_emission", lobes.has(Lobe::emission)),
        ("material_medium", lobes.has(Lobe::absorption) || lobes.has(Lobe::scattering)),
    ];
    names.extend(further.into_iter().filter(|(_, is_in)| *is_in).map(|(name, _)| name));
    names
}

/// A value as WGSL.
fn literal(value: Value) -> String {
    match value {
        Value::Color(v) | Value::Normal(v) => format!("vec3f({})", v.map(|x| float(x as f32)).join(", ")),
        Value::Float(x) => float(x as f32),
        Value::Bool(on) => on.to_string(),
    }
}

/// A number as all languages read it: finite, and 0 for those that are too small for some of them.
pub(super) fn float(x: f32) -> String {
    format!("{:?}", if x.is_normal() { x } else { 0.0 })
}

const FUNCTIONS: &str = "
// Value of the BSDF times |cos| for light from `wi` seen from `wo`, without delta lobes.
fn material_eval({take, }wo: vec3f, wi: vec3f) -> vec3f {
    return bsdf_eval(material_prepare({pass, }view_new(wo)), wi).value;
}

// Density with which `material_sample` draws `wi` for `wo`, per solid angle, without delta lobes.
fn material_pdf({take, }wo: vec3f, wi: vec3f) -> f32 {
    return bsdf_eval(material_prepare({pass, }view_new(wo)), wi).pdf;
}

// Draws a direction for `wo` by four numbers in [0, 1).
fn material_sample({take, }wo: vec3f, u: vec4f) -> BsdfSample {
    return bsdf_sample(material_prepare({pass, }view_new(wo)), u);
}

// The BSDF at one point for one view: for `bsdf_eval` and `bsdf_sample`, which the functions above call.
fn material_prepare({take, }view: View) -> Bsdf {
    return bsdf_prepare(material_optics({pass}), view);
}

// Share of the surface that is there, in [0, 1]; the rest lets light pass straight on.
fn material_opacity({take}) -> f32 {
    return material_optics({pass}).opacity;
}

// Radiance that the front side emits.
fn material_emission({take}) -> vec3f {
    return material_optics({pass}).emission;
}

// Scattering and absorption coefficients in the body, per unit of length of the material. Scattering is isotropic.
fn material_medium({take}) -> Medium {
    let optics = material_optics({pass});
    return Medium(optics.sigma_s, optics.sigma_a);
}

// What the values mean.
fn material_optics({take}) -> Optics {
    var optics = interpret(material_inputs({pass}), 1.0);
    optics.albedos = {begin};
    return optics;
}

// A view along `wo` of light of one wavelength, chosen by `u` in [0, 1). The mean over `u` is that of white light.
fn view_dispersed(wo: vec3f, u: f32) -> View {
    let light = SPECTRUM_OF[min(u32(u * f32(SPECTRUM)), SPECTRUM - 1u)];
    var view = view_new(wo);
    view.has_light = true;
    view.nm = light.x;
    view.weights = light.yzw;
    return view;
}

";
