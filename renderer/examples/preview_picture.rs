//! Scratch: draws the preview of a shape with a few values and times it.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]
use burnish_assets::*;
use burnish_material::*;
use burnish_renderer::preview::*;
use burnish_renderer::*;
use std::sync::Arc;
use std::time::Instant;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let (shape, env, out, frames) = (&args[1], &args[2], &args[3], args[4].parse::<u32>().unwrap());
    let size: u32 = std::env::var("SIZE").map_or(512, |s| s.parse().unwrap());
    let model: ModelMeshes = make_shape(shape).unwrap().into();
    let mut m = Material::named("x");
    let mut ev = 0.0;
    let mut transform = DisplayTransform::Neutral;
    for a in &args[5..] {
        let (k, v) = a.split_once('=').unwrap();
        if k == "ev" {
            ev = v.parse().unwrap();
            continue;
        }
        if k == "transform" {
            transform = DisplayTransform::from_word(v).unwrap();
            continue;
        }
        let n: Vec<f64> = v.split(',').map(|x| x.parse().unwrap()).collect();
        let def = PROPERTIES.iter().find(|d| d.is_named(k)).unwrap();
        let val = match def.default.kind() {
            Kind::Color => Value::Color([n[0], n[1], n[2]]),
            Kind::Normal => Value::Normal([n[0], n[1], n[2]]),
            Kind::Float => Value::Float(n[0]),
            Kind::Bool => Value::Bool(n[0] > 0.5),
        };
        m.set(def.id, val);
    }
    let t = Instant::now();
    let e = make_environment(env).unwrap();
    println!("env {:?} {}x{}", t.elapsed(), e.width, e.height);
    let light = EnvironmentLight { map: Arc::new(e), rotation_deg: 0.0, scale: 1.0 };
    let scene = Scene::of_model(&model, Arc::new(m), Arc::default(), light, model.unit_mm);
    for o in &scene.objects {
        println!("{} {} tris {}", o.mesh.name, o.mesh.positions.len(), o.mesh.triangles.len());
    }
    let t = Instant::now();
    let (adapter, device, queue) = headless_device().unwrap();
    println!("{:?} device {:?}", adapter.get_info().name, t.elapsed());
    let t = Instant::now();
    let mut p = Preview::new(&device, &queue).unwrap();
    println!("new {:?}", t.elapsed());
    let t = Instant::now();
    p.set_scene(&device, &queue, &scene);
    println!("set_scene {:?} {:?}", t.elapsed(), p.error());
    let draw = |p: &mut Preview, what: &str| {
        let t = Instant::now();
        let mut enc = device.create_command_encoder(&Default::default());
        let more = p.draw(&device, &queue, &mut enc, size, size, Display::default());
        queue.submit([enc.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        println!("{what} {:?} more {more} {:?}", t.elapsed(), p.error());
    };
    draw(&mut p, "first (compile)");
    draw(&mut p, "second");
    draw(&mut p, "third");
    let mut s2 = scene.clone();
    s2.camera.fov_deg += 1e-4;
    p.set_scene(&device, &queue, &s2);
    draw(&mut p, "frame 0 again");
    let mut s2 = scene.clone();
    s2.camera.fov_deg += 2e-4;
    p.set_scene(&device, &queue, &s2);
    draw(&mut p, "frame 0 again");
    let cpu = || {
        let s = std::fs::read_to_string("/proc/self/stat").unwrap();
        let f: Vec<&str> = s.rsplit(") ").next().unwrap().split(' ').collect();
        f[11].parse::<f64>().unwrap() / 100.0
    };
    let t = Instant::now();
    p.set_scene(&device, &queue, &scene);
    p.render(&device, &queue, size, size, 1).unwrap();
    println!("bake {:?}", t.elapsed());
    s2.camera.fov_deg += 3e-4;
    p.set_scene(&device, &queue, &s2);
    let t = Instant::now();
    let c = cpu();
    p.set_scene(&device, &queue, &scene);
    let pixels = p.render(&device, &queue, size, size, frames).unwrap();
    println!(
        "render {frames}: {:?} steps {} cpu {:.0} ms per step",
        t.elapsed(),
        p.steps(),
        (cpu() - c) * 1e3 / p.steps() as f64
    );
    let d = Display { transform, exposure_ev: ev };
    let mut ppm = format!("P6 {size} {size} 255\n").into_bytes();
    let mut sum = [0f64; 3];
    for px in &pixels {
        for k in 0..3 {
            sum[k] += px[k] as f64;
        }
        ppm.extend(d.apply_u8([px[0], px[1], px[2]]));
    }
    println!("mean {:?}", sum.map(|x| x / pixels.len() as f64));
    std::fs::write(out, ppm).unwrap();
}
