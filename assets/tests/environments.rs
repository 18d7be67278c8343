//! Do environments map directions as documented, and are the built-in ones what they claim to be?

use std::f32::consts::{PI, TAU};

use burnish_assets::{ENVIRONMENTS, Environment, make_environment};
use glam::{Vec2, Vec3};

#[test]
fn directions_and_places_agree() {
    let near = |a: Vec3, b: Vec3| assert!(a.distance(b) < 1e-5, "{a} {b}");
    near(Environment::direction(0.5, 0.5), Vec3::Z);
    near(Environment::direction(0.0, 0.5), Vec3::NEG_Z);
    near(Environment::direction(0.25, 0.5), Vec3::X);
    near(Environment::direction(0.3, 0.0), Vec3::Y);
    for i in 0..37 {
        for j in 1..19 {
            let uv = Vec2::new((i as f32 + 0.3) / 37.0, j as f32 / 19.0);
            let d = Environment::direction(uv.x, uv.y);
            assert!((d.length() - 1.0).abs() < 1e-5);
            assert!(Environment::uv(d).distance(uv) < 1e-4, "{uv} became {}", Environment::uv(d));
        }
    }
    // Just left of -Z the angle is a tiny negative number.
    let u = Environment::uv(Vec3::new(-1e-12, 0.0, -1.0)).x;
    assert!((0.0..1.0).contains(&u), "{u}");
}

#[test]
fn lookup_is_exact_at_centres_and_wraps() {
    let (width, height) = (8, 4);
    let texels = (0..width * height).map(|k| [k as f32, 1.0, 0.0]).collect();
    let map = Environment { name: String::new(), width, height, texels };
    let at = |i: f32, j: f32| map.lookup(Environment::direction((i + 0.5) / 8.0, (j + 0.5) / 4.0)).x;
    for k in 0..32 {
        let (i, j) = ((k % 8) as f32, (k / 8) as f32);
        assert!((at(i, j) - k as f32).abs() < 1e-3);
    }
    assert!((at(7.5, 1.0) - (15.0 + 8.0) / 2.0).abs() < 1e-2, "half way across the seam: {}", at(7.5, 1.0));
    assert!((at(2.0, -0.4) - 2.0).abs() < 1e-3, "clamped above the first row");
    assert!((map.lookup(Vec3::Y * 7.0).y - 1.0).abs() < 1e-6, "any length");
    assert_eq!(map.lookup(Vec3::ZERO), Vec3::ZERO);
    let none = Environment { name: String::new(), width: 0, height: 0, texels: Vec::new() };
    assert_eq!(none.lookup(Vec3::X), Vec3::ZERO);
}

/// The integral of `radiance * weight(d)` over all directions.
fn integral(map: &Environment, weight: impl Fn(Vec3) -> f32) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for j in 0..map.height {
        let v = (j as f32 + 0.5) / map.height as f32;
        let solid_angle = (v * PI).sin() * PI / map.height as f32 * TAU / map.width as f32;
        for i in 0..map.width {
            let d = Environment::direction((i as f32 + 0.5) / map.width as f32, v);
            sum += Vec3::from_array(map.texels[j * map.width + i]) * (solid_angle * weight(d));
        }
    }
    sum
}

#[test]
fn built_in_environments() {
    for (k, def) in ENVIRONMENTS.iter().enumerate() {
        assert!(ENVIRONMENTS[..k].iter().all(|other| other.name != def.name), "{}", def.name);
        let map = make_environment(&def.name.to_uppercase()).expect(def.name);
        assert_eq!(map, (def.make)(), "{} is made twice the same", def.name);
        assert_eq!((map.texels.len(), map.width), (map.width * map.height, 2 * map.height), "{}", def.name);
        let is_radiance = |x: &f32| x.is_finite() && (0.0..=60000.0).contains(x);
        assert!(map.texels.iter().flatten().all(is_radiance), "{}", def.name);
    }
    assert_eq!(ENVIRONMENTS[0].name, "studio");
    assert!(make_environment("moon").is_none());
}

#[test]
fn furnace_and_black_are_exact() {
    let texels = |name| make_environment(name).expect("in the table").texels;
    assert!(texels("white-furnace").iter().all(|t| *t == [1.0; 3]));
    assert!(texels("black").iter().all(|t| *t == [0.0; 3]));
}

/// The mean radiance in all directions is what a matte white ball shows on average over its surface.
#[test]
fn exposures_are_alike() {
    for (name, from, to) in [("studio", 1.0, 2.0), ("sun", 0.6, 2.0), ("overcast", 0.4, 2.0)] {
        let mean = integral(&make_environment(name).expect("in the table"), |_| 1.0).y / (4.0 * PI);
        assert!((from..to).contains(&mean), "{name}: {mean}");
    }
}

#[test]
fn the_sun_has_its_energy() {
    let map = make_environment("sun").expect("in the table");
    let brightest = map.texels.iter().enumerate().max_by(|a, b| a.1[1].total_cmp(&b.1[1])).map_or(0, |(k, _)| k);
    let (i, j) = (brightest % map.width, brightest / map.width);
    let sun = Environment::direction((i as f32 + 0.5) / map.width as f32, (j as f32 + 0.5) / map.height as f32);
    let disc = integral(&map, |d| if d.dot(sun) > 1.6_f32.to_radians().cos() { d.dot(sun) } else { 0.0 });
    // The halo under the disc adds a few thousandths.
    assert!(disc.distance(Vec3::new(6.6, 6.1, 5.3)) < 0.06, "{disc}");
}

#[test]
fn the_overcast_sky_is_that_of_the_cie() {
    let map = make_environment("overcast").expect("in the table");
    let (zenith, low) = (map.lookup(Vec3::Y).y, map.lookup(Vec3::new(0.0, 0.05, 1.0).normalize()).y);
    assert!((zenith / low - 3.0 / 1.0999).abs() < 0.01, "{}", zenith / low);
    let irradiance = integral(&map, |d| d.y.max(0.0)).y;
    assert!((irradiance / (7.0 / 9.0 * PI * zenith) - 1.0).abs() < 0.01);
}
