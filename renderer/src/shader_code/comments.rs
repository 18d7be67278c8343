//! What a reader of the code is told: the header of the file, and the comments of our WGSL beside what naga wrote.

use super::Language;
use super::source::Source;
use super::tree::{ItemKind, parse, words};
use burnish_material::{Lobe, LobeSet, Material, PropertyDef};
use std::collections::HashMap;

/// Characters of a line of the header.
const WIDTH: usize = 118;

/// What every file says first: the material, who wrote it, its licence, its lobes.
pub(super) fn title(material: &Material, lobes: LobeSet, language: Language) -> Vec<String> {
    let Material { name, provenance, .. } = material;
    let name = if name.is_empty() { "A material".to_owned() } else { clean(name) };
    let mut lines = vec![
        format!("{name}: the BSDF of an Adobe Standard Material 4.0"),
        format!("Written by Burnish {} as {}.", env!("CARGO_PKG_VERSION"), language.label()),
    ];
    if !provenance.licence.is_empty() {
        lines.push(format!("Licence of the material: {}", clean(&provenance.licence)));
    }
    lines.push(String::new());
    lines.push(format!("Lobes in: {}.", list(&lobes.names(true))));
    lines.push(format!("Left out, because the material does not need them: {}.", list(&lobes.names(false))));
    lines.push(String::new());
    lines
}

/// Lines as comments.
pub(super) fn commented(lines: &[String]) -> String {
    let lines = lines.iter().flat_map(|line| wrapped(line));
    lines.map(|line| format!("// {line}").trim_end().to_owned() + "\n").collect()
}

/// The header of a file, every line with `//`.
pub(super) fn header(source: &Source, material: &Material, language: Language) -> String {
    let mut lines = title(material, source.lobes, language);
    let mut say = |text: &str| lines.push(text.to_owned());
    say("Conventions");
    say(
        "  Directions are unit and point away from the surface, in a local frame: x along the tangent of increasing u, y along the bitangent, z along the shading normal on the outside of the body. `wo` goes to the viewer, `wi` to the light; a negative z is inside the body.",
    );
    say(
        "  Values hold |cos| of `wi`. Densities are per solid angle. Perfect mirrors and unbent light are delta lobes: samples draw them (is_delta, pdf 0), values and densities leave them out. A sample's weight is value over density; where is_valid does not hold the path ends.",
    );
    say("  Radiance is not scaled by the square of the index of refraction where it crosses the surface.");
    say(&format!(
        "  Colours are linear Rec.709. Lengths are in units of the material, {} mm each. Angles of properties are turns.",
        material.unit_mm()
    ));
    say("  Four numbers `u` in [0, 1): choice of lobe, direction (two), reflection or refraction.");
    say("");
    functions(source, language, &mut say);
    values(source, &mut say);
    commented(&lines)
}

fn functions(source: &Source, language: Language, say: &mut impl FnMut(&str)) {
    if language == Language::Spirv {
        say("Entry point `main`: a compute shader of 64 invocations a workgroup, one query each. Descriptor set 0:");
        say(
            "  binding 1: array of queries, a vec4 each: wo, wi, u, and one for each image (number in x, colour in xyz), in the order of the list below",
        );
        say(
            "  binding 2: array of results: value (3) and density of wi; direction (3) and density drawn by u; its weight (3) and flags: 1 valid, 2 delta, 4 transmission",
        );
        if !source.uniform.is_empty() {
            say("  binding 0: the uniform block");
        }
    } else {
        say(
            "Functions; a comment above each says what it takes and gives. Several directions at one point: call material_prepare once, then bsdf_eval and bsdf_sample.",
        );
        say(&format!("  {}", source.functions.join(", ")));
        if source.lobes.has(Lobe::dispersion) {
            say(
                "  Dispersion shows with the views of view_dispersed; the others see the mean colour. The tables of lost energy are those of the mean index of refraction.",
            );
        }
        match language {
            Language::Glsl => {
                say("  GLSL 4.50 or Vulkan GLSL: without the line #version it can be pasted into a shader of any stage.")
            }
            Language::Hlsl => say("  HLSL, shader model 6.0."),
            Language::Msl => say("  Metal 2.0. The uniform block, where there is one, is an argument of the functions."),
            _ => {}
        }
    }
    let is_bent = [Lobe::normal_map, Lobe::coat_normal_map, Lobe::height].into_iter().any(|lobe| source.lobes.has(lobe));
    if source.lobes.has(Lobe::coat) && is_bent {
        say(
            "  The coat does not follow the base's maps: it takes its normal, in the frame of the base, as has_coat_normal and coat_normal of the view.",
        );
    }
    say("");
}

fn values(source: &Source, say: &mut impl FnMut(&str)) {
    let names = |defs: &[&PropertyDef]| list(&defs.iter().map(|def| def.name).collect::<Vec<_>>());
    if source.uniform.is_empty() {
        say("Values are constants, in material_inputs.");
    } else {
        say(&format!(
            "Values in the uniform block: {}. A change does not bring in lobes that are left out. All other values are constants, because the tables were made for them or the code does not change with them.",
            names(&source.uniform)
        ));
    }
    if !source.textured.is_empty() {
        say(&format!("Images, for the caller to sample into the struct `Textured`, linear: {}.", names(&source.textured)));
    }
    let of_frame = [Lobe::normal_map, Lobe::coat_normal_map, Lobe::height].into_iter().filter(|lobe| source.lobes.has(*lobe));
    let of_frame: Vec<&str> = of_frame.map(|lobe| lobe.def().name).collect();
    if !of_frame.is_empty() {
        say(&format!("The caller's, because they bend or move the frame: {}.", list(&of_frame)));
    }
    if !source.frozen.is_empty() {
        let frozen = names(&source.frozen);
        say(&format!(
            "The tables of lost energy take one value of {frozen} although it changes: they would be ten times as large."
        ));
    }
}

pub(super) fn list(names: &[&str]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

/// Text that cannot end a comment or go on in the next line.
pub(super) fn clean(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || c == '\\' || c == '?' { ' ' } else { c }).collect::<String>().trim().to_owned()
}

/// The lines of a text; further ones are indented by two more.
fn wrapped(text: &str) -> Vec<String> {
    let indent = text.len() - text.trim_start().len();
    let mut lines = vec![" ".repeat(indent)];
    for word in text.split_whitespace() {
        let is_full =
            lines.last().is_some_and(|line| line.trim() != "" && line.chars().count() + 1 + word.chars().count() > WIDTH);
        if is_full {
            lines.push(" ".repeat(indent + 2));
        }
        if let Some(line) = lines.last_mut() {
            if !line.trim().is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines
}

/// The header without what makes it a comment.
pub(super) fn uncommented(header: &str) -> String {
    header.lines().map(|line| line.trim_start_matches("//").trim_start_matches(' ').to_owned() + "\n").collect()
}

/// Comments of declarations and of members, by name.
pub(super) struct Comments {
    declarations: HashMap<String, Vec<String>>,
    members: HashMap<(String, String), Vec<String>>,
}

impl Comments {
    /// Those of a WGSL text.
    pub fn of(text: &str) -> Self {
        let mut comments = Self { declarations: HashMap::new(), members: HashMap::new() };
        for item in parse(text) {
            if let ItemKind::Struct { members } = &item.kind {
                for member in members.iter().filter(|member| !member.comment.is_empty()) {
                    comments.members.insert((item.name.clone(), member.name.clone()), member.comment.clone());
                }
            }
            if !item.comment.is_empty() {
                comments.declarations.insert(item.name, item.comment);
            }
        }
        comments
    }

    /// A text of another language with header and comments. What has to be the first line stays it.
    pub fn added(mut self, header: &str, text: &str) -> String {
        let mut out = String::new();
        let mut lines = text.lines().peekable();
        if let Some(version) = lines.next_if(|line| line.starts_with("#version")) {
            out += &format!("{version}\n");
        }
        out += &format!("{header}\n");
        let mut inside: Option<String> = None;
        for line in lines {
            if line.starts_with(' ') || line.starts_with('}') || line.starts_with('#') || line.starts_with("//") {
                if let Some(of) = inside.as_ref().filter(|_| line.starts_with(' ')) {
                    let member = words(line).last().map_or("", |(_, word)| word).to_owned();
                    for comment in self.members.remove(&(of.clone(), member)).into_iter().flatten() {
                        out += &format!("    {comment}\n");
                    }
                } else {
                    inside = None;
                }
            } else {
                let name = match line.strip_prefix("struct ") {
                    Some(rest) => {
                        let name = words(rest).next().map_or("", |(_, word)| word);
                        inside = Some(name.to_owned());
                        name
                    }
                    None => line.split('(').next().and_then(|before| words(before).last()).map_or("", |(_, word)| word),
                };
                // naga ends names with `_` that the language, or itself, has another use for.
                let comment = self.declarations.remove(name).or_else(|| self.declarations.remove(name.trim_end_matches('_')));
                for comment in comment.into_iter().flatten() {
                    out += &format!("{comment}\n");
                }
            }
            out += &format!("{line}\n");
        }
        out
    }
}
