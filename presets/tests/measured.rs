//! Is the table of measurements whole, and are values compared with the right ones?

use std::collections::BTreeSet;

use burnish_material::{Material, PROPERTIES, Property, Unit, Value};
use burnish_presets::measured::{Measured, find, marks, measured, nearest, neighbours, sentence, zone};
use burnish_presets::presets;

/// Measurements in the collection that the table was made from, and those left out as its head says.
const COLLECTED: usize = 402;
const LEFT_OUT: usize = 4;

fn get(id: &str) -> &'static Measured {
    find(id).unwrap_or_else(|| panic!("{id} is not in the table"))
}

/// A material of unit 1 mm with these values.
fn material(values: &[(Property, Value)]) -> Material {
    material_in(1.0, values)
}

/// A material with these values, lengths in units of so many mm.
fn material_in(unit_mm: f64, values: &[(Property, Value)]) -> Material {
    let mut material = Material::named("test");
    material.unit_mm = Some(unit_mm);
    for &(property, value) in values {
        material.set(property, value);
    }
    material
}

fn float(property: Property, value: f64) -> Material {
    material(&[(property, Value::Float(value))])
}

fn metal(color: [f64; 3]) -> Material {
    material(&[(Property::metallic, Value::Float(1.0)), (Property::base_color, Value::Color(color))])
}

fn nearest_id(material: &Material, property: Property) -> &'static str {
    nearest(material, property).map_or("none", |near| near.measured.id)
}

#[test]
fn every_row_has_name_values_and_sources() {
    assert_eq!(measured().len(), COLLECTED - LEFT_OUT);
    let mut ids = BTreeSet::new();
    for row in measured() {
        assert!(ids.insert(row.id), "{} stands there twice", row.id);
        for text in [row.id, row.name, row.group, row.dataset, row.reference, row.licence] {
            assert!(!text.is_empty(), "{}: {row:?}", row.id);
        }
        assert!(!row.values.is_empty(), "{}", row.id);
    }
}

#[test]
fn values_are_finite_and_spreads_enclose_them() {
    for row in measured() {
        for (property, value) in &row.values {
            let def = property.def();
            assert!(value.numbers().iter().all(|x| x.is_finite() && *x >= 0.0), "{}: {}", row.id, def.name);
            // Also outside of the hard range only where a measured colour leaves it.
            let inside = value.numbers().iter().all(|x| def.limits.contains(*x));
            assert!(
                inside || matches!(value, Value::Color(_)) || *property == Property::specular_ior,
                "{}: {}",
                row.id,
                def.name
            );
        }
        for (property, low, high) in &row.spreads {
            let value = row.value(*property).unwrap_or_else(|| panic!("{}: spread of nothing", row.id));
            for ((low, x), high) in low.numbers().iter().zip(value.numbers()).zip(high.numbers()) {
                assert!(low <= x && x <= high, "{}: {low} {x} {high}", row.id);
            }
        }
    }
    assert_eq!(measured().iter().filter(|row| !row.spreads.is_empty()).count(), 19);
}

#[test]
fn absorption_distance_is_one_over_the_mean_coefficient() {
    let mut count = 0;
    for row in measured() {
        if let (Some(Value::Color(color)), Some(Value::Float(_))) =
            (row.value(Property::absorption_color), row.value(Property::absorption_distance))
        {
            let depth = -color.iter().map(|c| c.ln()).sum::<f64>() / 3.0;
            assert!((depth - 1.0).abs() < 2e-3, "{}: {depth}", row.id);
            count += 1;
        }
    }
    assert_eq!(count, 56);
}

#[test]
fn known_facts() {
    let gold = get("gold");
    assert_eq!(gold.value(Property::base_color), Some(Value::Color([1.0588, 0.7733, 0.3073])));
    let spread = (Value::Color([0.9432, 0.641, 0.3073]), Value::Color([1.0588, 0.7837, 0.399]));
    assert_eq!(gold.spread(Property::base_color), Some(spread));
    assert_eq!(gold.value(Property::specular_ior), None);
    let glass = get("n-bk7");
    assert_eq!(glass.value(Property::specular_ior), Some(Value::Float(1.5168)));
    assert_eq!(glass.value(Property::dispersion), Some(Value::Float(0.3117)));
    assert_eq!(get("sss-skin-1").value(Property::scatter_distance), Some(Value::Float(1.2953)));
    assert!(get("blackbody-2700k").is_computed() && !gold.is_computed());
    assert_eq!(find("unobtainium"), None);
}

#[test]
fn presets_carry_the_same_values() {
    let mut compared = 0;
    for preset in presets() {
        let (file, _) = preset.parse().unwrap_or_else(|error| panic!("{}: {error}", preset.file_stem));
        for def in PROPERTIES {
            let Some(source) = file.source_of(def.id) else { continue };
            let mut rows = measured().iter().filter(|row| row.dataset == source.dataset);
            let (Some(row), None) = (rows.next(), rows.next()) else { continue };
            let Some(value) = row.value(def.id) else { continue };
            // A preset may state its absorption at another distance.
            if matches!(def.id, Property::absorption_color | Property::absorption_distance) {
                continue;
            }
            let found = file.material().value(def.id);
            let same =
                value.numbers().iter().zip(found.numbers()).all(|(x, y)| (x.clamp(0.0, def.limits.slider_max) - y).abs() < 1e-6);
            assert!(same, "{}: {} is {found:?}, measured {value:?}", preset.file_stem, def.name);
            compared += 1;
        }
    }
    assert!(compared >= 70, "only {compared} values were compared");
}

#[test]
fn numbers_find_their_neighbours() {
    let near = nearest(&float(Property::specular_ior, 1.52), Property::specular_ior).unwrap();
    assert!(near.measured.name == "Glass (Soda-lime)", "{}", near.measured.name);
    assert_eq!(nearest_id(&float(Property::coat_ior, 1.5168), Property::coat_ior), "n-bk7");
    assert_eq!(nearest_id(&float(Property::dispersion, 0.3115), Property::dispersion), "n-bk7");

    let between = neighbours(&float(Property::dispersion, 2.2), Property::dispersion).unwrap();
    assert_eq!(between.below.unwrap().measured.id, "rutile-o");
    assert_eq!(between.above.unwrap().measured.id, "zinc-selenide");
    let exact = neighbours(&float(Property::specular_ior, 2.4175), Property::specular_ior).unwrap();
    assert_eq!((exact.below, exact.above.unwrap().measured.id), (exact.above, "diamond"));
    let beyond = neighbours(&float(Property::dispersion, 5.0), Property::dispersion).unwrap();
    assert_eq!((beyond.below.unwrap().measured.id, beyond.above), ("zinc-selenide", None));
    let below = neighbours(&float(Property::dispersion, 0.0), Property::dispersion).unwrap();
    assert_eq!((below.below, below.above.unwrap().measured.id), (None, "mgf2-o"));
}

#[test]
fn lengths_follow_the_unit_of_the_material() {
    let mut skin = float(Property::scatter_distance, 1.2953);
    assert_eq!(nearest_id(&skin, Property::scatter_distance), "sss-skin-1");
    let (low, high) = zone(&skin, Property::scatter_distance).unwrap();
    skin.unit_mm = Some(100.0);
    skin.set(Property::scatter_distance, Value::Float(0.012953));
    let near = nearest(&skin, Property::scatter_distance).unwrap();
    assert_eq!(near.measured.id, "sss-skin-1");
    assert!(near.distance < 1e-9 && matches!(near.value, Value::Float(x) if (x - 0.012953).abs() < 1e-12), "{near:?}");
    let in_units = zone(&skin, Property::scatter_distance).unwrap();
    assert!((in_units.0 * 100.0 - low).abs() < 1e-9 && (in_units.1 * 100.0 - high).abs() < 1e-9, "{in_units:?}");
    // Twice as long and half as long are equally far.
    let far = |x: f64| neighbours(&float(Property::scatter_distance, x), Property::scatter_distance).unwrap();
    let (above, below) = (far(high * 2.0).below.unwrap(), far(low / 2.0).above.unwrap());
    assert!((above.distance - 2f64.ln()).abs() < 1e-9 && (below.distance - 2f64.ln()).abs() < 1e-9);
}

#[test]
fn zones_and_marks_come_from_data() {
    let any = float(Property::dispersion, 0.0);
    assert_eq!(zone(&any, Property::dispersion), Some((0.1883, 2.4795)));
    let (low, high) = zone(&any, Property::specular_ior).unwrap();
    assert_eq!((low, high), (1.3098, 3.3632));
    let dispersions: Vec<f64> = marks(&any, Property::dispersion).collect();
    assert!(dispersions.contains(&2.0267) && dispersions.is_sorted_by(|a, b| a < b));
    assert_eq!((dispersions.first(), dispersions.last()), (Some(&0.1883), Some(&2.4795)));
    for property in [Property::roughness, Property::metallic, Property::translucency, Property::emission, Property::base_color] {
        assert_eq!(zone(&any, property), None, "{}", property.def().name);
        assert_eq!(marks(&any, property).count(), 0, "{}", property.def().name);
    }
}

#[test]
fn base_colors_are_compared_with_their_kind() {
    assert_eq!(nearest_id(&metal([1.0, 0.7733, 0.3073]), Property::base_color), "gold");
    assert_eq!(nearest_id(&metal([0.95, 0.64, 0.54]), Property::base_color), "copper");
    let brick = [0.262, 0.095, 0.061];
    let mut body = material(&[(Property::base_color, Value::Color(brick))]);
    assert_eq!(nearest_id(&body, Property::base_color), "pb-brick");
    assert_ne!(nearest_id(&metal(brick), Property::base_color), "pb-brick");
    assert_eq!(nearest(&body, Property::specular_edge_color), None, "an edge colour was measured on metals only");
    body.set(Property::translucency, Value::Float(1.0));
    assert_eq!(nearest(&body, Property::base_color), None, "a clear body has no diffuse colour");
}

#[test]
fn a_light_is_compared_without_its_brightness() {
    let glow = |x: f64| material(&[(Property::emission_color, Value::Color([x, 0.4153 * x, 0.0991 * x]))]);
    assert_eq!(nearest_id(&glow(1.0), Property::emission_color), "blackbody-2700k");
    assert_eq!(nearest_id(&glow(50.0), Property::emission_color), "blackbody-2700k");
    assert_eq!(nearest(&glow(0.0), Property::emission_color), None);
}

#[test]
fn absorption_is_compared_at_the_depth_of_the_material() {
    // 10 mm of merlot, in units of 100 mm.
    let sigma = [0.11633, 0.25191, 0.29440];
    let color = sigma.map(|sigma: f64| (-sigma * 10.0).exp());
    let values = [(Property::absorption_color, Value::Color(color)), (Property::absorption_distance, Value::Float(0.1))];
    let mut wine = material_in(100.0, &values);
    let near = nearest(&wine, Property::absorption_color).unwrap();
    assert_eq!(near.measured.id, "sss-merlot");
    assert!(near.distance < 2e-3, "{near:?}");
    let depth = nearest(&wine, Property::absorption_distance).unwrap();
    assert!(matches!(depth.value, Value::Float(x) if (x - 0.1).abs() < 1e-3), "{depth:?}");
    let (low, high) = zone(&wine, Property::absorption_distance).unwrap();
    assert!(low < 0.1 && 0.1 < high, "{low} {high}");
    wine.set(Property::absorption_distance, Value::Float(0.0));
    assert_eq!(nearest(&wine, Property::absorption_color), None, "no absorption in the body");
    assert_eq!(nearest(&wine, Property::absorption_distance), None);
    wine.set(Property::absorption_distance, Value::Float(0.1)).set(Property::absorption_color, Value::Color([1.0; 3]));
    assert_eq!(nearest(&wine, Property::absorption_color), None, "white does not absorb");
    assert_eq!(zone(&wine, Property::absorption_distance), None);
}

#[test]
fn every_measured_value_is_nearest_to_itself() {
    for row in measured() {
        let material = material(&row.values);
        for &(property, value) in &row.values {
            let Some(near) = nearest(&material, property) else { continue };
            let others_too = near.distance < 1e-6 || near.measured.id == row.id;
            // Its distance in the table is that at which its own mean depth is 1, to four digits.
            let is_absorption = property.def().unit == Unit::Length && near.distance < 2e-3;
            assert!(others_too || is_absorption, "{}: {} {value:?} is nearest to {near:?}", row.id, property.def().name);
        }
    }
}

#[test]
fn sentences_say_where_a_value_lies() {
    let say = |material: &Material, property| sentence(material, property).unwrap_or_default();
    let bk7 = say(&float(Property::specular_ior, 1.5168), Property::specular_ior);
    assert_eq!(bk7, "Nearest measured: Crown glass N-BK7 (1.517)");
    let between = say(&float(Property::dispersion, 2.2), Property::dispersion);
    assert_eq!(between, "Between Rutile (TiO2, o) (2.027) and Zinc selenide (2.479)");
    let above = say(&float(Property::dispersion, 3.0), Property::dispersion);
    assert_eq!(above, "Above every measured one; highest: Zinc selenide (2.479)");
    let below = say(&float(Property::dispersion, 0.1), Property::dispersion);
    assert_eq!(below, "Below every measured one; lowest: MgF2 (anti-reflection coat, o) (0.1883)");
    let lamp = material(&[(Property::emission_color, Value::Color([1.0, 0.4153, 0.0991]))]);
    assert_eq!(say(&lamp, Property::emission_color), "Nearest computed: Black body 2700 K (1, 0.4153, 0.0991)");

    let gold = say(&metal([1.0588, 0.7733, 0.3073]), Property::base_color);
    assert_eq!(gold, "Nearest measured: Gold (1.059, 0.7733, 0.3073)");
    let alloy = say(&metal([0.97, 0.775, 0.36]), Property::base_color);
    assert_eq!(
        alloy,
        "Between Gold alloy (Au90 Ag10) (1.002, 0.8186, 0.3758) and Red brass (Cu85 Zn15) (0.9125, 0.7141, 0.4199)"
    );
    let dull = say(&metal([0.9, 0.7, 0.02]), Property::base_color);
    let note = "; blue 0.02 is below every measured metal (lowest: Titanium nitride 0.2327, Gold 0.3073)";
    assert!(dull.ends_with(note), "{dull}");
    let white = say(&metal([1.0; 3]), Property::base_color);
    assert!(white.contains("; blue 1 is above every measured metal (highest: Silver 0.9738, "), "{white}");
    assert!(!white.contains("; red"), "gold reflects more red: {white}");

    let violet = say(&metal([0.3, 0.1, 0.8]), Property::base_color);
    assert!(violet.starts_with("Far from every measured one; nearest: "), "{violet}");

    let milk = material_in(100.0, &[(Property::scatter_distance, Value::Float(0.0039199))]);
    assert_eq!(say(&milk, Property::scatter_distance), "Nearest measured: Whole milk (0.00392, 0.392 mm)");
    assert_eq!(sentence(&milk, Property::roughness), None);
}

#[test]
fn no_value_is_too_strange() {
    for x in [0.0, -1.0, 1e-300, 1e300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for (unit, metallic) in [(1e-300, 0.0), (1e300, 1.0), (f64::NAN, 0.0)] {
            let mut material = material_in(unit, &[]);
            for def in PROPERTIES {
                match def.default {
                    Value::Float(_) => material.set(def.id, Value::Float(x)),
                    Value::Color(_) => material.set(def.id, Value::Color([x, 0.5, x])),
                    _ => continue,
                };
            }
            material.set(Property::metallic, Value::Float(metallic)).set(Property::translucency, Value::Float(0.0));
            for def in PROPERTIES {
                let near = nearest(&material, def.id);
                assert!(near.is_none_or(|near| near.distance >= 0.0), "{}: {near:?} of {x}", def.name);
                assert!(
                    x.is_finite() || sentence(&material, def.id).is_none() || def.id == Property::metallic,
                    "{} of {x}",
                    def.name
                );
                _ = zone(&material, def.id);
            }
        }
    }
}
