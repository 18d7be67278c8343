//! The lobe table: which parts of the model five known materials need, and that each part can be switched on.

use std::collections::HashSet;

use burnish_material::Property as P;
use burnish_material::{LOBES, Lobe, LobeSet, Material, PROPERTIES, Property, TextureRef, Value, idle_lobe};

fn material(values: &[(Property, Value)]) -> Material {
    let mut material = Material::default();
    values.iter().for_each(|(property, value)| _ = material.set(*property, *value));
    material
}

fn float(property: Property, x: f64) -> (Property, Value) {
    (property, Value::Float(x))
}

fn color(property: Property, x: [f64; 3]) -> (Property, Value) {
    (property, Value::Color(x))
}

fn lobes_of(values: &[(Property, Value)]) -> Vec<&'static str> {
    LobeSet::of(&material(values)).names(true)
}

#[test]
fn known_materials_need_these_lobes() {
    assert_eq!(lobes_of(&[]), ["specular", "diffuse"]);
    let gold = [color(P::base_color, [1.0, 0.71, 0.31]), float(P::metallic, 1.0)];
    assert_eq!(lobes_of(&gold), ["metal", "multiple_scattering"]);
    let glass = [float(P::translucency, 1.0), float(P::roughness, 0.0), float(P::dispersion, 0.31)];
    assert_eq!(lobes_of(&glass), ["specular", "transmission", "dispersion"]);
    let green_glass = [float(P::translucency, 1.0), color(P::absorption_color, [0.7, 0.9, 0.8])];
    assert_eq!(lobes_of(&green_glass), ["specular", "transmission", "multiple_scattering", "absorption"]);
    let paint = [float(P::coat, 1.0), float(P::metallic, 0.5)];
    assert_eq!(lobes_of(&paint), ["metal", "specular", "diffuse", "multiple_scattering", "coat"]);
    let skin = [float(P::translucency, 1.0), (P::scatter, Value::Bool(true)), float(P::scatter_red_shift, 0.5)];
    assert_eq!(lobes_of(&skin), ["specular", "transmission", "multiple_scattering", "scattering"]);
}

#[test]
fn a_texture_counts_as_maybe_on() {
    let mut material = Material::default();
    material.slot_mut(P::coat).texture = Some(TextureRef::new("coat.png"));
    assert_eq!(LobeSet::of(&material).names(true), ["specular", "diffuse", "coat", "textures"]);
    material.set(P::coat, Value::Float(0.0));
    assert!(LobeSet::of(&material).has(Lobe::coat));
}

#[test]
fn rows_are_in_order_and_unique() {
    let mut names = HashSet::new();
    for (row, def) in LOBES.iter().enumerate() {
        assert_eq!(def.lobe as usize, row);
        assert_eq!(def.lobe.def().name, def.name);
        assert!(names.insert(def.name) && names.insert(def.switch), "{}", def.name);
        assert_eq!(def.switch, format!("HAS_{}", def.name.to_uppercase()).replace("HAS_HAS", "HAS"));
        let properties: HashSet<_> = def.properties.iter().collect();
        assert_eq!(properties.len(), def.properties.len(), "{}", def.name);
        assert!(def.doc.ends_with('.'), "{}", def.name);
    }
    assert!(LOBES.len() <= 32, "a LobeSet has 32 bits");
}

#[test]
fn each_lobe_can_be_switched_on() {
    let on: [(Lobe, Vec<(Property, Value)>); 17] = [
        (Lobe::metal, vec![float(P::metallic, 0.1)]),
        (Lobe::specular, vec![]),
        (Lobe::diffuse, vec![]),
        (Lobe::transmission, vec![float(P::translucency, 0.1)]),
        (Lobe::multiple_scattering, vec![float(P::metallic, 0.1)]),
        (Lobe::anisotropy, vec![float(P::anisotropy, 0.1)]),
        (Lobe::sheen, vec![float(P::sheen, 0.1)]),
        (Lobe::coat, vec![float(P::coat, 0.1)]),
        (Lobe::emission, vec![float(P::emission, 0.1)]),
        (Lobe::opacity, vec![float(P::opacity, 0.9)]),
        (Lobe::absorption, vec![float(P::translucency, 1.0), color(P::absorption_color, [0.5, 1.0, 1.0])]),
        (Lobe::scattering, vec![float(P::opacity, 0.9), (P::scatter, Value::Bool(true))]),
        (Lobe::dispersion, vec![float(P::translucency, 1.0), float(P::dispersion, 0.1)]),
        (Lobe::normal_map, vec![(P::normal, Value::Normal([0.6, 0.0, 0.8]))]),
        (Lobe::coat_normal_map, vec![float(P::coat, 1.0), (P::coat_normal, Value::Normal([0.6, 0.0, 0.8]))]),
        (Lobe::height, vec![float(P::height, 0.7)]),
        (Lobe::textures, vec![]),
    ];
    assert_eq!(on.len(), LOBES.len());
    for (lobe, values) in &on {
        let mut material = material(values);
        if *lobe == Lobe::textures {
            material.slot_mut(P::roughness).texture = Some(TextureRef::new("r.png"));
        }
        assert!(LobeSet::of(&material).has(*lobe), "{lobe:?}");
    }
    // And each but those of the default material is out without that.
    let default = LobeSet::of(&Material::default());
    let always = [Lobe::specular, Lobe::diffuse];
    assert!(LOBES.iter().all(|def| default.has(def.lobe) == always.contains(&def.lobe)));
}

#[test]
fn sets_behave_as_sets() {
    let set = LobeSet::EMPTY.with(Lobe::coat).with(Lobe::metal).with(Lobe::coat);
    assert_eq!(set.names(true), ["metal", "coat"]);
    assert_eq!(set.without(Lobe::coat).names(true), ["metal"]);
    assert_eq!(set.union(LobeSet::all()), LobeSet::all());
    assert_eq!(set.names(true).len() + set.names(false).len(), LOBES.len());
}

#[test]
fn properties_listed_by_a_lobe_are_idle_while_it_is_out() {
    for def in LOBES {
        for property in def.properties {
            // A lobe that this property can bring in itself is never the reason to call it idle.
            let is_idle = idle_lobe(&Material::default(), *property).is_some();
            let own_switch = [P::specular_level, P::coat_normal, P::combine_normal_and_height, P::height_level];
            let is_out = !LobeSet::of(&Material::default()).has(def.lobe);
            assert!(is_idle || !is_out || own_switch.contains(property), "{}: {property:?}", def.name);
        }
    }
    let name = |values: &[(Property, Value)], property| idle_lobe(&material(values), property).map(|def| def.name);
    assert_eq!(name(&[], P::dispersion), Some("dispersion"));
    assert_eq!(name(&[float(P::translucency, 1.0)], P::dispersion), None);
    assert_eq!(name(&[float(P::translucency, 1.0), float(P::specular_level, 0.0)], P::specular_ior), None);
    assert_eq!(name(&[float(P::metallic, 1.0)], P::specular_ior), Some("specular"));
    assert_eq!(name(&[float(P::metallic, 1.0)], P::translucency), Some("transmission"));
    assert_eq!(name(&[float(P::translucency, 1.0)], P::base_color), Some("metal"));
    assert_eq!(name(&[float(P::coat, 1.0)], P::coat_roughness), None);
    assert_eq!(name(&[float(P::coat, 1.0)], P::coat_normal_scale), Some("coat_normal_map"));
    assert_eq!(name(&[float(P::roughness, 1.0)], P::anisotropy), Some("anisotropy"));
    for switch in [P::roughness, P::metallic, P::opacity, P::emission, P::sheen, P::coat] {
        assert_eq!(name(&[], switch), None, "{switch:?}");
    }
    assert_eq!(PROPERTIES.iter().filter(|def| idle_lobe(&Material::default(), def.id).is_none()).count(), 18);
}
