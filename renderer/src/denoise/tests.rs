//! Synthetic pictures whose truth is known.

use super::*;
use crate::path::ErrorEstimate;

const SIDE: usize = 64;

/// A number in `[0, 1)` for a seed: splitmix64.
fn uniform(seed: u64) -> f64 {
    let mut x = seed.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Smooth light over a checker of two albedos.
fn truth(x: usize, y: usize) -> f64 {
    let light = 0.6 + 0.4 * (x as f64 * 0.07).sin() * (y as f64 * 0.05).cos();
    light * if is_bright(x, y) { 0.8 } else { 0.1 }
}

fn is_bright(x: usize, y: usize) -> bool {
    (x / 16 + y / 16).is_multiple_of(2)
}

/// Replicates of `samples` exponential samples each around the truth.
fn noisy(seed: u64, samples: u32, truth: impl Fn(usize, usize) -> f64) -> Input {
    let value = |x: usize, y: usize, r: usize, k: usize| {
        let sample = |i: u32| {
            let number = ((seed * 4 + r as u64) * 3 + k as u64) * 1_000_003 + u64::from(i);
            -truth(x, y) * (1.0 - uniform(number.wrapping_mul(SIDE as u64 * SIDE as u64) + (y * SIDE + x) as u64)).ln()
        };
        ((0..samples).map(sample).sum::<f64>() / f64::from(samples)) as f32
    };
    let pixel = |i: usize| std::array::from_fn(|r| std::array::from_fn(|k| value(i % SIDE, i / SIDE, r, k)));
    Input { width: SIDE, height: SIDE, replicates: (0..SIDE * SIDE).map(pixel).collect() }
}

fn checker_guides() -> Guides {
    let pixels = || (0..SIDE * SIDE).map(|i| is_bright(i % SIDE, i / SIDE));
    Guides {
        albedo: pixels().map(|bright| [if bright { 0.8 } else { 0.1 }; 3]).collect(),
        normal: pixels().map(|_| [0.0, 1.0, 0.0]).collect(),
        nearness: pixels().map(|_| 1.0).collect(),
    }
}

fn run(input: &Input, guides: &Guides, threads: usize) -> Denoised {
    Denoiser::Own.run(input, guides, threads, &|| false).expect("nobody cancels")
}

fn relmse(pixels: &[[f32; 3]], truth: impl Fn(usize, usize) -> f64) -> f64 {
    let term = |(i, pixel): (usize, &[f32; 3])| {
        let t = truth(i % SIDE, i / SIDE);
        pixel.iter().map(|x| (f64::from(*x) - t).powi(2) / (t * t + 0.01)).sum::<f64>()
    };
    pixels.iter().enumerate().map(term).sum::<f64>() / (3 * pixels.len()) as f64
}

fn mean(input: &Input) -> Vec<[f32; 3]> {
    input.replicates.iter().map(|r| std::array::from_fn(|k| r.iter().map(|c| 0.25 * c[k]).sum())).collect()
}

#[test]
fn a_constant_picture_stays() {
    let input = Input { width: 9, height: 5, replicates: vec![[[0.25, 0.5, 2.0]; 4]; 45] };
    let out = run(&input, &Guides::default(), 1);
    assert!(out.pixels.iter().flatten().zip([0.25_f32, 0.5, 2.0].iter().cycle()).all(|(x, y)| (x - y).abs() < 1e-6 * y));
    assert!(out.error.relmse < 1e-12, "{:?}", out.error);
}

#[test]
fn noise_goes_and_edges_stay() {
    let input = noisy(1, 4, truth);
    let (raw, with) = (relmse(&mean(&input), truth), relmse(&run(&input, &checker_guides(), 1).pixels, truth));
    assert!(with < raw / 10.0, "{with} of {raw}");
    // Both sides of an edge that only the guides tell apart in this noise.
    let faint = |x: usize, y: usize| if is_bright(x, y) { 0.5 } else { 0.4 };
    let input = noisy(2, 4, faint);
    let (without, with) = (run(&input, &Guides::default(), 1), run(&input, &checker_guides(), 1));
    let (without, with) = (relmse(&without.pixels, faint), relmse(&with.pixels, faint));
    assert!(with < 0.5 * without, "{with} {without}");
}

#[test]
fn light_is_neither_lost_nor_made() {
    let input = noisy(3, 16, truth);
    let sum = |pixels: &[[f32; 3]]| pixels.iter().flatten().map(|x| f64::from(*x)).sum::<f64>();
    let ratio = sum(&run(&input, &checker_guides(), 1).pixels) / sum(&mean(&input));
    assert!((ratio - 1.0).abs() < 0.012, "{ratio}");
}

/// So dark that errors are divided by a constant almost: what is unbiased is the squared error, not its division.
fn dark(x: usize, y: usize) -> f64 {
    0.02 * truth(x, y)
}

/// Mean estimate and mean true error of dark pictures with several seeds, by a filter, and how many intervals hold.
fn estimates(seeds: u64, filter: impl Fn(&Input) -> [Vec<[f32; 3]>; 2]) -> (f64, f64, usize) {
    let (mut estimated, mut true_error, mut inside) = (0.0, 0.0, 0);
    for seed in 0..seeds {
        let input = noisy(100 + seed, 4, dark);
        let halves = filter(&input);
        let pixels: Vec<[f32; 3]> =
            halves[0].iter().zip(&halves[1]).map(|(a, b)| std::array::from_fn(|k| 0.5 * (a[k] + b[k]))).collect();
        let error = estimate::error(&input, &halves);
        let t = relmse(&pixels, dark);
        estimated += error.relmse / seeds as f64;
        true_error += t / seeds as f64;
        inside += usize::from(error.low <= t && t <= error.high);
    }
    (estimated, true_error, inside)
}

#[test]
fn the_error_is_estimated_without_bias() {
    let filter = |input: &Input| means::halves(input, &Guides::default(), 1, &|| false).expect("nobody cancels");
    let (estimated, true_error, inside) = estimates(96, filter);
    assert!((estimated / true_error - 1.0).abs() < 0.06, "{estimated} {true_error}");
    assert!(inside >= 90, "{inside} of 96");
    // Also where nothing is filtered, and where everything is blurred away.
    let (estimated, true_error, _) = estimates(24, |input| [input.half(0), input.half(1)]);
    assert!((estimated / true_error - 1.0).abs() < 0.06, "raw: {estimated} {true_error}");
    let (estimated, true_error, _) =
        estimates(24, |input| [vec![[0.005; 3]; SIDE * SIDE], vec![[0.005; 3]; input.replicates.len()]]);
    assert!((estimated / true_error - 1.0).abs() < 0.06, "flat: {estimated} {true_error}");
}

#[test]
fn a_filter_that_sees_the_other_half_would_be_found_out() {
    // Halves that share their noise: the estimate must not be believed, which is why the filter never does that.
    let (estimated, true_error, _) = estimates(24, |input| [mean(input), mean(input)]);
    assert!(estimated < 0.7 * true_error, "{estimated} {true_error}");
}

#[test]
fn threads_do_not_change_the_picture() {
    let (input, guides) = (noisy(5, 1, truth), checker_guides());
    let one = run(&input, &guides, 1);
    for threads in [0, 2, 3, 16] {
        let other = run(&input, &guides, threads);
        assert!(one.pixels == other.pixels && one.error == other.error, "{threads} threads");
    }
}

#[test]
fn it_can_be_cancelled() {
    let result = Denoiser::Own.run(&noisy(5, 1, truth), &Guides::default(), 2, &|| true);
    assert!(matches!(result, Err(DenoiseError::Cancelled)));
}

#[test]
fn every_number_is_finite() {
    let is_finite = |out: &Denoised| {
        let ErrorEstimate { relmse, low, high, .. } = out.error;
        out.pixels.iter().flatten().all(|x| x.is_finite()) && [relmse, low, high].iter().all(|x| x.is_finite())
    };
    let wild = [0.0, f32::NAN, f32::INFINITY, f32::MAX, f32::NEG_INFINITY, f32::MIN_POSITIVE, -1.0, 3e14, 1e-30];
    for (width, height) in [(0, 0), (0, 3), (1, 1), (1, 7), (2, 1), (3, 5), (33, 17)] {
        let black = Input { width, height, replicates: vec![[[0.0; 3]; 4]; width * height] };
        let out = run(&black, &Guides::default(), 2);
        assert!(out.pixels.len() == width * height && is_finite(&out) && out.error.relmse == 0.0, "{width}x{height}");
        let mut wilder = black.clone();
        for (i, x) in wilder.replicates.iter_mut().flatten().flatten().enumerate() {
            *x = wild[i * 7 % 31 % wild.len()];
        }
        let infinite = vec![[f32::INFINITY, f32::NAN, -f32::MAX]; width * height];
        let guides = Guides { albedo: infinite.clone(), normal: infinite, nearness: vec![f32::NAN; width * height] };
        let out = run(&wilder, &guides, 2);
        assert!(out.pixels.len() == width * height && is_finite(&out), "{width}x{height}");
    }
    // Fewer pixels than the size says.
    let out = run(&Input { width: 4, height: 4, replicates: Vec::new() }, &Guides::default(), 1);
    assert!(out.pixels.len() == 16 && is_finite(&out));
}

#[test]
fn a_library_that_is_not_there_is_named() {
    let folder = std::env::temp_dir();
    let error = Oidn::load(Some(folder.join("no such library.so").as_os_str())).expect_err("there is none");
    let text = error.to_string();
    assert!(text.contains("no such library.so") && text.contains(LIBRARY_VARIABLE), "{text}");
}

#[test]
fn open_image_denoise_reduces_the_error() {
    let oidn = match Oidn::find() {
        Ok(oidn) => oidn,
        Err(error) => {
            eprintln!("skipped: {error}");
            return;
        }
    };
    assert!(oidn.version().starts_with("2."), "{}", oidn.version());
    let (input, guides) = (noisy(1, 4, truth), checker_guides());
    let denoiser = Denoiser::Oidn(oidn);
    let out = denoiser.run(&input, &guides, 1, &|| false).expect("it works");
    let (raw, t) = (relmse(&mean(&input), truth), relmse(&out.pixels, truth));
    assert!(t < 0.2 * raw && out.error.low <= t && t <= out.error.high, "{t} of {raw}: {:?}", out.error);
    // Images of any size, black ones too.
    for (width, height) in [(0, 0), (1, 1), (3, 17)] {
        let black = Input { width, height, replicates: vec![[[0.0; 3]; 4]; width * height] };
        let out = denoiser.run(&black, &Guides::default(), 1, &|| false).expect("it works");
        assert!(out.pixels.len() == width * height && out.pixels.iter().flatten().all(|x| x.is_finite()), "{width}x{height}");
    }
}
