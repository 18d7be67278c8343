//! Whether the library keeps its promises: readable, lossless, unique, inside limits, and with a source per value.

use std::collections::BTreeSet;

use burnish_material::{LimitKind, Material, MaterialFile, Property, Severity, Value, check};
use burnish_presets::{Preset, find, group_title, measured, presets, search};

/// The groups of the library: names of the folders.
const GROUPS: [&str; 14] = [
    "ceramics",
    "emitters",
    "fabrics",
    "foods",
    "glass-gems",
    "liquids",
    "metals",
    "organic",
    "paints",
    "papers",
    "plastics",
    "skin",
    "stone",
    "woods",
];

/// Calls `check` with every preset and its file; a message of the check names the preset.
fn for_each(mut check: impl FnMut(&Preset, &MaterialFile)) {
    for preset in presets() {
        match preset.parse() {
            Ok((file, _)) => check(preset, &file),
            Err(error) => panic!("{}: {error}", preset.file_stem),
        }
    }
}

/// Properties that stand in the file.
fn authored(material: &Material) -> impl Iterator<Item = Property> {
    material.slots().filter(|(_, slot)| slot.value.is_some()).map(|(property, _)| property)
}

/// The three numbers behind `"key": (`, the first time the key stands in the text.
fn triple(text: &str, key: &str) -> Option<[f64; 3]> {
    let (_, rest) = text.split_once(&format!("\"{key}\": ("))?;
    let (inside, _) = rest.split_once(')')?;
    let numbers: Vec<f64> = inside.split(',').map(|number| number.trim().parse().expect("a number")).collect();
    numbers.try_into().ok()
}

#[test]
fn every_file_parses_without_a_warning() {
    for preset in presets() {
        let (file, warnings) = preset.parse().unwrap_or_else(|error| panic!("{}: {error}", preset.file_stem));
        assert!(warnings.is_empty(), "{}: {warnings:?}", preset.file_stem);
        assert!(file.unknown_keys().is_empty(), "{}: {:?}", preset.file_stem, file.unknown_keys());
    }
}

#[test]
fn saving_unedited_gives_the_same_bytes() {
    for_each(|preset, file| assert_eq!(file.to_text(file.material()), preset.text, "{}", preset.file_stem));
}

#[test]
fn the_list_repeats_what_the_files_say() {
    for_each(|preset, file| {
        let material = file.material();
        assert_eq!(preset.name, material.name);
        assert_eq!(preset.tags, material.tags, "{}", preset.name);
        assert_eq!(preset.source, material.provenance.source, "{}", preset.name);
    });
}

#[test]
fn names_and_stems_are_unique_and_sorted() {
    let mut seen = BTreeSet::new();
    for preset in presets() {
        // A stem that equals another preset's name would make `find` depend on order.
        let keys = BTreeSet::from([preset.name.to_lowercase(), preset.file_stem.to_owned()]);
        for key in keys {
            assert!(seen.insert(key.clone()), "{key} stands for two presets");
        }
        let is_kebab = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        assert!(preset.file_stem.chars().all(is_kebab), "{}", preset.file_stem);
    }
    assert!(presets().is_sorted_by_key(|preset| (preset.group, preset.name)));
}

#[test]
fn every_property_has_a_source_with_a_known_method() {
    for_each(|preset, file| {
        for property in authored(file.material()) {
            let place = format!("{}: {}", preset.file_stem, property.def().name);
            let source = file.source_of(property).unwrap_or_else(|| panic!("{place} has no source"));
            assert!(["measured", "derived", "by eye"].contains(&&*source.method), "{place}: {}", source.method);
            let is_complete = !(source.dataset.is_empty() || source.paper.is_empty() || source.licence.is_empty());
            assert!(source.method != "measured" || is_complete, "{place} is measured, but by whom?");
        }
    });
}

#[test]
fn provenance_is_complete() {
    for_each(|preset, file| {
        let provenance = &file.material().provenance;
        for text in [&provenance.source, &provenance.reference, &provenance.method, &provenance.licence] {
            assert!(!text.trim().is_empty(), "{}: {provenance:?}", preset.file_stem);
        }
        assert!(!file.material().notes.is_empty(), "{}", preset.file_stem);
    });
}

#[test]
fn every_value_is_inside_its_range() {
    for_each(|preset, file| {
        for property in authored(file.material()) {
            let def = property.def();
            for &x in file.material().value(property).numbers() {
                let holds = x.is_finite() && (def.limits.kind == LimitKind::Open || def.limits.contains(x));
                assert!(holds, "{}: {} is {x}, {}", preset.file_stem, def.name, def.limits.text());
            }
        }
    });
}

#[test]
fn nothing_is_written_that_equals_the_default() {
    for_each(|preset, file| {
        for property in authored(file.material()) {
            let is_default = file.material().value(property) == property.def().default;
            assert!(!is_default, "{}: {}", preset.file_stem, property.def().name);
        }
    });
}

#[test]
fn measured_coefficients_come_out_of_the_model() {
    let mut scattering = 0;
    let mut absorbing = 0;
    for_each(|preset, file| {
        let material = file.material();
        if let Some(sigma_t) = triple(preset.text, "sigma_t_per_mm") {
            assert_eq!(material.unit_mm, Some(1.0), "{}: lengths were measured in mm", preset.file_stem);
            let sigma_s = triple(preset.text, "sigma_s_prime_per_mm").unwrap();
            let scale = material.color(Property::scatter_distance_scale);
            let rayleigh = material.float(Property::scatter_rayleigh);
            let red_shift = material.float(Property::scatter_red_shift);
            // Kulla and Conty 2017, as printed; then the extinction of the model, with its two colour effects.
            let albedo = material.color(Property::scatter_color).map(|c| {
                let s = 4.09712 + 4.20863 * c - (9.59217 + 41.6808 * c + 17.7126 * c * c).sqrt();
                1.0 - s * s
            });
            let brightest = albedo.into_iter().fold(0.0, f64::max);
            let factors = [(540.0_f64 / 640.0).powi(4), 1.0, (540.0_f64 / 460.0).powi(4)];
            for c in 0..3 {
                let mut extinction = brightest / albedo[c] / material.float(Property::scatter_distance) / scale[c];
                extinction *= 1.0 + rayleigh * (factors[c] - 1.0);
                if c == 0 {
                    extinction *= 0.1_f64.powf(red_shift);
                }
                // Four digits in three factors.
                assert!((extinction / sigma_t[c] - 1.0).abs() < 1e-3, "{}: {extinction}", preset.file_stem);
                let albedo_error = (albedo[c] - sigma_s[c] / sigma_t[c]).abs();
                assert!(albedo_error < 2e-4, "{}: albedo off by {albedo_error}", preset.file_stem);
            }
        } else if let Some(sigma_a) = triple(preset.text, "sigma_a_per_mm") {
            assert_eq!(material.unit_mm, Some(1.0), "{}: lengths were measured in mm", preset.file_stem);
            let distance = material.float(Property::absorption_distance);
            let color = material.color(Property::absorption_color);
            for c in 0..3 {
                // Four digits of a colour near 1.
                let error = (color[c] - (-sigma_a[c] * distance).exp()).abs();
                assert!(error < 1e-4, "{}: absorption color off by {error}", preset.file_stem);
            }
        }
    });
    for preset in presets() {
        scattering += usize::from(preset.text.contains("sigma_t_per_mm"));
        absorbing += usize::from(preset.text.contains("sigma_a_per_mm"));
    }
    assert!(scattering >= 5 && absorbing >= 12, "the check above found too little: {scattering}, {absorbing}");
}

#[test]
fn a_clamped_value_keeps_the_measured_one_beside_it() {
    let gold = find("gold, polished").unwrap();
    assert_eq!(triple(gold.text, "base_color"), Some([1.0, 0.7733, 0.3073]));
    assert_eq!(triple(gold.text, "measured"), Some([1.0588, 0.7733, 0.3073]));
    for preset in presets() {
        if preset.text.contains("clamp per channel") {
            let measured = triple(preset.text, "measured").unwrap();
            assert!(measured.iter().any(|x| !(0.0..=1.0).contains(x)), "{}", preset.file_stem);
        }
    }
}

#[test]
fn metals_reflect_as_measured() {
    let mut compared = 0;
    let mut clamped = 0;
    for_each(|preset, file| {
        let material = file.material();
        let Some(source) = file.source_of(Property::base_color) else { return };
        if material.float(Property::metallic) != 1.0 || source.method != "measured" {
            return;
        }
        let row = measured::measured().iter().find(|row| row.dataset == source.dataset);
        let row = row.unwrap_or_else(|| panic!("{}: {} is not in the table", preset.file_stem, source.dataset));
        for (property, text) in [(Property::base_color, "F0"), (Property::specular_edge_color, "edge")] {
            let Some(Value::Color(real)) = row.value(property) else { panic!("{}: the table has no {text}", preset.file_stem) };
            let written = material.color(property);
            // The one rule for what lies outside of Rec.709: clamp per channel to [0,1].
            let off = real.iter().zip(written).map(|(real, x)| (real.clamp(0.0, 1.0) - x).abs()).fold(0.0, f64::max);
            assert!(off <= 0.002, "{}: {text} is {written:?}, measured {real:?}", preset.file_stem);
            if real.iter().any(|x| !(0.0..=1.0).contains(x)) {
                let [r, g, b] = real;
                let beside = format!("\"measured\": ({r:?}, {g:?}, {b:?})");
                let holds = preset.text.contains("clamp per channel to [0,1]") && preset.text.contains(&beside);
                assert!(holds, "{}: {text} is clamped, expected {beside} beside it", preset.file_stem);
                clamped += 1;
            }
        }
        if let Some((low, high)) = row.spread(Property::base_color) {
            let written = (source.spread_min, source.spread_max);
            assert_eq!(written, (Some(low), Some(high)), "{}: spread of the datasets", preset.file_stem);
        }
        compared += 1;
    });
    assert!(compared >= 30 && clamped >= 6, "only {compared} metals were compared, {clamped} values clamped");
}

#[test]
fn nothing_is_odd_about_a_preset() {
    for_each(|preset, file| {
        for finding in check(file.material()) {
            assert!(finding.severity < Severity::Warning, "{}: {finding}", preset.file_stem);
        }
    });
}

#[test]
fn the_required_groups_are_there() {
    assert!(presets().len() >= 165, "{} presets", presets().len());
    let groups: BTreeSet<_> = presets().iter().map(|preset| preset.group).collect();
    assert_eq!(groups, BTreeSet::from(GROUPS));
    for group in groups {
        assert_ne!(group_title(group), "Other", "{group} needs a title in lib.rs");
        let count = presets().iter().filter(|preset| preset.group == group).count();
        assert!(count >= 5, "only {count} presets in {group}");
    }
    assert_eq!(group_title("no such group"), "Other");
}

#[test]
fn find_takes_name_or_stem_in_any_case() {
    for preset in presets() {
        for name in [preset.name.to_uppercase(), preset.name.to_lowercase(), preset.file_stem.to_uppercase()] {
            assert_eq!(find(&name), Some(preset), "{name}");
        }
    }
    assert_eq!(find(" Diamond "), find("diamond"));
    assert_eq!(find(""), None);
    assert_eq!(find("unobtainium"), None);
}

#[test]
fn search_wants_every_word() {
    let names = |query| search(query).iter().map(|preset| preset.file_stem).collect::<Vec<_>>();
    assert_eq!(search("").len(), presets().len());
    assert_eq!(names("BRUSHED alu"), ["aluminium-brushed"]);
    assert_eq!(names("metal brushed steel"), ["stainless-steel-brushed"]);
    assert_eq!(names("glass brushed"), Vec::<&str>::new());
    assert!(names("jewellery").contains(&"diamond"), "tags are searched");
    assert_eq!(names("skin").len(), presets().iter().filter(|preset| preset.group == "skin").count());
}
