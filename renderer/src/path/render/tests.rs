//! Stop rules, repeats, parts, and what goes on where it stopped.

use super::plan::Plan;
use super::*;
use crate::path::tests::{mixed, picture};

fn totals(stop: StopRules, pace: f64, error: impl Fn(u32) -> Option<ErrorEstimate>) -> (Vec<u32>, StopReason) {
    let (mut plan, mut spp, mut all) = (Plan::new(stop), 0, Vec::new());
    loop {
        match plan.next(spp, f64::from(spp) * pace, pace, error(spp).as_ref()) {
            Ok(step) => spp += step,
            Err(reason) => return (all, reason),
        }
        all.push(spp);
    }
}

#[test]
fn samples_are_exact_and_double() {
    let stop = StopRules { spp: Some(100), ..StopRules::default() };
    assert_eq!(totals(stop, 1e-6, |_| None), (vec![1, 4, 8, 16, 32, 64, 100], StopReason::Spp));
}

#[test]
fn counts_worked_out_later_are_those_of_the_film() {
    let prepared = Prepared::new(&mixed(), None);
    let stop = StopRules { spp: Some(100), ..StopRules::default() };
    for is_adaptive in [false, true] {
        let mut run = Run::new(&prepared, Settings { width: 24, height: 16, seed: 5, threads: 2, stop, is_adaptive });
        while run.step(&|| false).is_ok() {
            assert!(run.counts().per_pixel() == run.film.samples(), "{is_adaptive}: {}", run.film.spp());
        }
        let counts = run.counts().per_pixel();
        assert_eq!((counts.iter().sum::<u32>(), counts.iter().min() < counts.iter().max()), (24 * 16 * 100, is_adaptive));
    }
}

#[test]
fn time_is_kept() {
    for limit in [0.5, 1.0, 3.3, 10.0] {
        let stop = StopRules { seconds: Some(limit), ..StopRules::default() };
        let (all, reason) = totals(stop, 0.01, |_| None);
        let end = f64::from(*all.last().expect("at least one pass")) * 0.01;
        assert_eq!(reason, StopReason::Time);
        assert!(end <= limit && end > limit - 0.02, "{end} for {limit}");
    }
}

#[test]
fn a_target_between_powers_of_two_is_met() {
    let stop = |target| StopRules { relmse: Some(target), ..StopRules::default() };
    for slope in [0.9, 1.0, 1.3] {
        let estimate = |spp: u32| {
            let relmse = f64::from(spp.max(1)).powf(-slope);
            (spp >= 4).then_some(ErrorEstimate { relmse, low: 0.9 * relmse, high: 1.1 * relmse, is_firefly_limited: false })
        };
        for needed in [16.0f64, 23.0, 50.0, 64.0, 65.0, 90.0, 127.0, 1000.0] {
            let target = needed.powf(-slope);
            let (all, reason) = totals(stop(target), 1e-6, estimate);
            let reached = f64::from(*all.last().expect("at least one pass")).powf(-slope) / target;
            assert!(reason == StopReason::Error && (0.8..1.1).contains(&reached), "{slope} {needed}: {reached} {all:?}");
        }
    }
    // Fireflies: the upper end decides.
    let wild = |spp: u32| {
        (spp >= 4).then_some(ErrorEstimate {
            relmse: 1.0 / f64::from(spp),
            low: 0.5 / f64::from(spp),
            high: 2.0 / f64::from(spp),
            is_firefly_limited: true,
        })
    };
    assert_eq!(totals(stop(1.0 / 64.0), 1e-6, wild).0.last(), Some(&128));
}

fn run_to(spp: u32, threads: usize, is_adaptive: bool, seed: u64) -> Film {
    let stop = StopRules { spp: Some(spp), ..StopRules::default() };
    let settings = Settings { width: 24, height: 24, seed, threads, stop, is_adaptive };
    let rendering = render(&mixed(), &settings, &mut |_| true);
    assert_eq!((rendering.stop_reason, rendering.film.spp()), (StopReason::Spp, spp));
    assert_eq!(rendering.samples, 24 * 24 * u64::from(spp));
    rendering.film
}

#[test]
fn adaptive_bits_do_not_depend_on_threads_and_passes() {
    let one = run_to(150, 1, true, 7);
    let counts = one.samples();
    assert!(counts.iter().min() < counts.iter().max());
    for threads in [2, 4] {
        let film = run_to(150, threads, true, 7);
        assert_eq!((film.mean(), film.samples()), (one.mean(), counts.clone()), "{threads} threads");
    }
    // By other steps to the same total.
    let scene = mixed();
    let prepared = Prepared::new(&scene, None);
    let stop = StopRules { spp: Some(150), ..StopRules::default() };
    let mut run = Run::new(&prepared, Settings { width: 24, height: 24, seed: 7, threads: 2, stop, is_adaptive: true });
    for goal in [3, 40, 64, 70, 81, 150] {
        run.plan.stop.spp = Some(goal);
        while run.step(&|| false).is_ok() {}
        assert_eq!(run.film.spp(), goal);
    }
    assert_eq!(run.film.mean(), one.mean());
    assert_eq!(run.film.samples(), counts);
}

#[test]
fn adaptive_sampling_keeps_the_mean() {
    // Against the same number of pictures with equal samples, pixel sums in standard errors of their own scatter.
    const PICTURES: u64 = 12;
    let sums = |is_adaptive: bool| -> Vec<f64> {
        (0..PICTURES)
            .map(|seed| {
                let film = run_to(128, 2, is_adaptive, 2 * seed + u64::from(is_adaptive));
                film.mean().iter().flatten().map(|c| f64::from(*c)).sum()
            })
            .collect()
    };
    let moments = |sums: &[f64]| {
        let mean = sums.iter().sum::<f64>() / PICTURES as f64;
        (mean, sums.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (PICTURES * (PICTURES - 1)) as f64)
    };
    let (a, b) = (moments(&sums(true)), moments(&sums(false)));
    let z = (a.0 - b.0) / (a.1 + b.1).sqrt();
    assert!(z.abs() < 3.5, "{z}: {a:?} {b:?}");
}

#[test]
fn any_stopped_picture_is_repeated_and_goes_on_as_if_it_had_not_stopped() {
    let prepared = Prepared::new(&mixed(), None);
    let settings = |stop| Settings { width: 40, height: 36, seed: 9, threads: 2, stop, is_adaptive: true };
    let by = |relmse| StopRules { relmse: Some(relmse), ..StopRules::default() };
    let whole = Tile { at: [0, 0], size: [40, 36] };
    let again = |samples| repeat(&prepared, &settings(by(1e-9)), whole, samples, Instant::now(), &mut |_| true).film;
    let through = render_prepared(&prepared, &settings(by(2e-3)), Instant::now(), &mut |_| true);
    assert_eq!(through.stop_reason, StopReason::Error);
    assert!(again(through.film.total_samples()).mean() == through.film.mean());
    // Not even one sample in every pixel: any beginning of the coarse picture.
    let mut first = Run::new(&prepared, settings(StopRules { seconds: Some(1e3), ..StopRules::default() }));
    first.step(&|| false).expect("there is time");
    first.pace = PASS_SECONDS / 100.0;
    for _ in 0..5 {
        first.step(&|| false).expect("there is time");
        first.pace = PASS_SECONDS / 100.0;
        let film = again(first.film.total_samples());
        assert!(film.samples() == first.film.samples() && film.mean() == first.film.mean());
    }
    // Stopped in the middle, put aside, taken up.
    let mut passes = 0;
    let stopped = render_prepared(&prepared, &settings(by(2e-3)), Instant::now(), &mut |state| {
        passes += 1;
        state.film.spp() < 32
    });
    assert_eq!(stopped.stop_reason, StopReason::Cancelled);
    let bytes = stopped.keep();
    let kept = Kept::read(&bytes).expect("it was just made");
    assert_eq!(kept.spp(), stopped.film.spp());
    let on = kept.go_on(&prepared, &settings(by(2e-3)), Instant::now(), &mut |_| true).expect("it is of this size");
    assert!(on.film.mean() == through.film.mean() && on.film.samples() == through.film.samples());
    assert_eq!((on.error, on.stop_reason), (through.error, StopReason::Error));
    // The same from the very beginning, with a time limit that was over before every pixel had a sample.
    let early = settings(StopRules { seconds: Some(1e3), ..StopRules::default() });
    let begun = render_prepared(&prepared, &early, Instant::now(), &mut |_| false);
    assert_eq!(begun.film.spp(), 0);
    let kept = Kept::read(&begun.keep()).expect("it was just made");
    let on = kept.go_on(&prepared, &settings(by(2e-3)), Instant::now(), &mut |_| true).expect("it is of this size");
    assert!(on.film.mean() == through.film.mean() && on.film.samples() == through.film.samples());
    // Damage is found, wherever it is.
    for at in [0, 9, 40, bytes.len() / 2, bytes.len() - 1] {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1;
        assert!(Kept::read(&damaged).is_err(), "{at}");
    }
    assert!(Kept::read(&bytes[..bytes.len() - 8]).is_err() && Kept::read(&[]).is_err());
}

#[test]
fn tiles_are_parts_of_the_picture() {
    let prepared = Prepared::new(&mixed(), None);
    let stop = StopRules { spp: Some(6), ..StopRules::default() };
    let settings = Settings { width: 40, height: 30, seed: 3, threads: 2, stop, is_adaptive: false };
    let whole = render_prepared(&prepared, &settings, Instant::now(), &mut |_| true).film.mean();
    for tile in [Tile { at: [0, 0], size: [17, 30] }, Tile { at: [17, 11], size: [23, 19] }] {
        let part = render_tile(&prepared, &settings, tile, Instant::now(), &mut |_| true).film;
        assert_eq!([part.width, part.height], tile.size);
        let row = |y: usize| &whole[(tile.at[1] + y) * 40 + tile.at[0]..][..tile.size[0]];
        assert!(part.mean().chunks(tile.size[0]).enumerate().all(|(y, of_part)| of_part == row(y)), "{tile:?}");
    }
}

#[test]
fn a_time_limit_within_the_first_pass_leaves_a_whole_picture() {
    let scene = mixed();
    let prepared = Prepared::new(&scene, None);
    let stop = StopRules { seconds: Some(1e3), ..StopRules::default() };
    let mut run = Run::new(&prepared, Settings { width: 40, height: 40, seed: 7, threads: 1, stop, is_adaptive: false });
    run.step(&|| false).expect("there is time");
    assert_eq!((run.film.total_samples(), run.film.spp(), run.error), (4, 0, None));
    assert!(run.film.mean().iter().all(|c| c[0] > 0.0));
    // Time is up: what came in time is kept, and it is the beginning of the same picture.
    run.settings.stop.seconds = Some(0.0);
    run.plan.stop.seconds = Some(0.0);
    assert_eq!(run.step(&|| false), Err(StopReason::Time));
    assert_eq!(run.film.total_samples(), 4);
    run.settings.stop.seconds = Some(1e3);
    while run.film.spp() == 0 {
        run.step(&|| false).expect("there is time");
    }
    assert_eq!(run.film.mean(), picture(&scene, 40, &[1], 1).0.mean());
}
