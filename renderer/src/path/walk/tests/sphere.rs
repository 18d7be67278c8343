//! A ball: jumps against walking, work, energy, the mean path that does not depend on the scattering.

use super::*;

/// Light that enters the unit ball at its top.
fn through(body: &Body, method: Method, i: u32, stats: &mut WalkStats) -> [f64; 3] {
    let direction = inwards(DVec3::Z, true, 3, i);
    match walk(&Ball, body, &entry(&Ball, DVec3::Z, direction, [1.0; 3], 3, i), method, stats) {
        End::Surface { throughput, .. } => throughput.map(f64::from),
        End::Absorbed => [0.0; 3],
        End::Lost { .. } => panic!("a ball has no holes"),
    }
}

fn grey(extinction: f32, absorbed: f64) -> Body {
    Body::new(&medium([extinction; 3], [absorbed; 3]), 1.0)
}

#[test]
fn jumps_and_steering_agree_with_walking() {
    for (extinction, absorbed, walks) in
        [(50.0, 0.01, 60_000), (50.0, 1e-4, 60_000), (200.0, 0.01, 30_000), (200.0, 1e-3, 30_000), (25.0, 0.003, 60_000)]
    {
        let body = grey(extinction, absorbed);
        let mut plain_stats = WalkStats::default();
        let plain = measure(0.0, walks, [true; 3], |i| through(&body, Method::Plain, i, &mut plain_stats));
        for method in [Method::Guided, Method::Jumping] {
            let mut stats = WalkStats::default();
            let sums = measure(0.0, 4 * walks, [true; 3], |i| through(&body, method, i + walks, &mut stats));
            let z = (sums.mean(0) - plain.mean(0)) / sums.sigma(0).hypot(plain.sigma(0));
            assert!(z.abs() < 3.5, "{extinction} {absorbed} {method:?}: {} against {}, z {z}", sums.mean(0), plain.mean(0));
            assert!(stats.max_weight < 20.0, "{extinction} {absorbed} {method:?}: weight {}", stats.max_weight);
        }
    }
}

#[test]
fn the_densest_bodies_cost_a_bounded_number_of_flights() {
    for (extinction, absorbed) in [(1e3, 0.0), (1e5, 0.0), (1e5, 1e-4)] {
        let body = grey(extinction, absorbed);
        let mut stats = WalkStats::default();
        let sums = measure(0.0, 40_000, [true; 3], |i| through(&body, Method::Jumping, i, &mut stats));
        let flights = stats.collisions as f64 / sums.count + 1.0;
        assert!(flights < 60.0, "{extinction} {absorbed}: {flights}");
        if absorbed == 0.0 {
            assert!((sums.mean(0) - 1.0).abs() < 1e-9, "{extinction}: {} comes out", sums.mean(0));
        } else {
            // A plane of this albedo under diffuse light, which so dense a ball is.
            assert!((sums.mean(0) - 0.977_187).abs() < 0.002, "{}", sums.mean(0));
        }
        assert_eq!((stats.cut, stats.lost, stats.outside), (0, 0, 0));
    }
}

#[test]
fn the_mean_path_is_four_volumes_over_the_surface() {
    // Blanco and Fournier 2003: for uniform light and without absorption, whatever the scattering.
    for extinction in [0.5, 3.0, 30.0] {
        let body = grey(extinction, 0.0);
        let (mut squares, mut energy) = (0.0, 0.0);
        let mut stats = WalkStats::default();
        let walks = if extinction < 1.0 { 500_000 } else { 40_000 };
        for i in 0..walks {
            let before = stats.collisions;
            // Roulette of the longest walks doubles what it leaves.
            energy += through(&body, Method::Plain, i, &mut stats)[0];
            squares += ((stats.collisions - before) as f64).powi(2);
        }
        let mean = stats.collisions as f64 / f64::from(walks);
        let sigma = (squares / f64::from(walks) - mean * mean).sqrt() / f64::from(walks).sqrt();
        let known = f64::from(extinction) * 4.0 / 3.0;
        assert!((energy / f64::from(walks) - 1.0).abs() < 5e-3, "{extinction}: {energy}");
        assert!((mean - known).abs() < 3.0 * sigma, "{extinction}: {mean} collisions, not {known}");
    }
}

#[test]
fn weights_stay_small_where_steering_is_allowed() {
    // Extinctions at both ends of each share of the rule, alone and together.
    for (extinction, absorbed) in [
        ([25.0; 3], [0.003; 3]),
        ([12.0, 30.0, 60.0], [0.003, 0.032, 0.088]),
        ([8.0; 3], [0.05; 3]),
        ([200.0; 3], [0.01; 3]),
        ([40.0, 40.0, 300.0], [0.001, 0.5, 0.01]),
    ] {
        let body = Body::new(&medium(extinction, absorbed), 1.0);
        for method in [Method::Guided, Method::Jumping] {
            let mut stats = WalkStats::default();
            measure(0.0, 60_000, [true; 3], |i| through(&body, method, i, &mut stats));
            assert!(stats.max_weight < 20.0, "{extinction:?} {absorbed:?} {method:?}: {}", stats.max_weight);
        }
    }
}
