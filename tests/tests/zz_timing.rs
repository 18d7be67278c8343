use burnish_material::*;
use burnish_renderer::bsdf::Albedos;
use burnish_tests::materials::*;
#[test]
fn timing() {
    use Property::*;
    let sets: &[(&str, &[(Property, f64)], &[Property])] = &[
        ("metal", &[(metallic, 1.0)], &[]),
        ("dielectric", &[], &[]),
        ("glass", &[(translucency, 1.0)], &[]),
        ("all uniform isotropic + coat", &[(translucency, 0.5), (metallic, 0.5), (coat, 1.0), (coat_roughness, 0.3)], &[]),
        ("metal aniso", &[(metallic, 1.0), (anisotropy, 0.5)], &[]),
        ("all aniso + coat", &[(translucency, 0.5), (metallic, 0.5), (coat, 1.0), (coat_roughness, 0.3), (anisotropy, 0.5)], &[]),
        ("metal rough map", &[(metallic, 1.0)], &[roughness]),
        ("dielectric rough map", &[], &[roughness]),
        ("dielectric+metal rough map", &[(metallic, 0.5)], &[roughness]),
        ("glass rough map", &[(translucency, 1.0)], &[roughness]),
        ("metal aniso rough+aniso map", &[(metallic, 1.0), (anisotropy, 0.5)], &[roughness, anisotropy]),
        ("all, 3 maps", &[(metallic, 0.5), (translucency, 0.5), (coat, 1.0)], &[roughness, specular_level, coat]),
        (
            "all aniso, 4 maps",
            &[(metallic, 0.5), (translucency, 0.5), (coat, 1.0), (anisotropy, 0.5)],
            &[roughness, specular_level, coat, anisotropy],
        ),
        ("glass dispersion", &[(translucency, 1.0), (dispersion, 2.0)], &[]),
    ];
    for (name, values, varying) in sets {
        let mut m = material(&[(roughness, f(0.37))]);
        for (p, x) in *values {
            m.set(*p, f(*x));
        }
        let lobes = LobeSet::of(&m);
        let mut best = f64::MAX;
        let mut words = 0;
        for _ in 0..3 {
            let t = std::time::Instant::now();
            let a = Albedos::new(&m.inputs(), lobes, |p| varying.contains(&p), []);
            best = best.min(t.elapsed().as_secs_f64());
            words = a.words().len();
        }
        println!("{name}: {:.2} ms, {words} words", best * 1e3);
    }
}
