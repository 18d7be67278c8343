//! Media at the ends of their ranges, and walks that are the same whoever takes them.

use super::*;

fn ends(body: &Body, throughput: [f32; 3], walks: u32, mut see: impl FnMut(&Entry, End)) -> WalkStats {
    let mut stats = WalkStats::default();
    for method in METHODS {
        for i in 0..walks {
            let direction = inwards(DVec3::Z, true, 4, i);
            let entry = entry(&Ball, DVec3::Z, direction, throughput, 4, i);
            let end = walk(&Ball, body, &entry, method, &mut stats);
            if let End::Surface { throughput, .. } = end {
                assert!(throughput.iter().all(|x| x.is_finite() && *x >= 0.0), "{body:?}: {throughput:?}");
            }
            see(&entry, end);
        }
    }
    stats
}

#[test]
fn a_walk_is_the_same_to_the_bit_wherever_it_is_taken() {
    let body = Body::new(&medium([20.0, 40.0, 90.0], [0.01, 0.0, 0.2]), 1.0);
    let mut first = Vec::new();
    ends(&body, [1.0, 0.5, 0.25], 500, |_, end| first.push(end));
    let mut second = Vec::new();
    std::thread::scope(|scope| {
        scope.spawn(|| ends(&body, [1.0, 0.5, 0.25], 500, |_, end| second.push(end)));
    });
    assert_eq!(first, second);
    assert!(first.iter().any(|end| *end != first[0]));
}

#[test]
fn a_body_that_only_absorbs_leaves_nothing_to_chance() {
    let body = Body::new(&medium([0.0, 2.0, 50.0], [1.0; 3]), 1.0);
    ends(&body, [0.7, 1.0, 1.0], 200, |entry, end| {
        let End::Surface { hit, throughput, position, direction, .. } = end else { panic!("{end:?}") };
        assert_eq!((hit, position, direction), (entry.first, entry.position, entry.direction));
        for (k, s) in [0.0, 2.0, 50.0].into_iter().enumerate() {
            let expected = entry.throughput[k] * (-s * hit.t).exp();
            assert!((throughput[k] - expected).abs() <= 1e-5 * expected, "{throughput:?} {k}");
        }
    });
}

#[test]
fn a_clear_body_lets_light_pass() {
    let body = Body::new(&medium([0.0; 3], [0.0; 3]), 1.0);
    let stats = ends(&body, [0.25, 1.0, 4.0], 100, |entry, end| {
        assert!(matches!(end, End::Surface { hit, throughput, .. } if hit == entry.first && throughput == entry.throughput));
    });
    assert_eq!(stats.collisions, 0);
}

#[test]
fn a_clear_channel_beside_a_dense_one_keeps_its_light() {
    let body = Body::new(&medium([0.0, 60.0, 60.0], [0.0, 0.0, 1.0]), 1.0);
    let mut sums = Sums::default();
    ends(&body, [1.0; 3], 60_000, |_, end| match end {
        End::Surface { throughput, .. } => sums.add(throughput.map(f64::from)),
        _ => sums.add([0.0; 3]),
    });
    assert!((sums.mean(0) - 1.0).abs() < 4.0 * sums.sigma(0).max(1e-4), "{}", sums.mean(0));
    assert!((sums.mean(1) - 1.0).abs() < 4.0 * sums.sigma(1).max(1e-4), "{}", sums.mean(1));
    // Straight through a chord c with density c/2: the mean of exp(-s c).
    let s = 60.0f64;
    let known = (1.0 - (1.0 + 2.0 * s) * (-2.0 * s).exp()) / (2.0 * s * s);
    assert!((sums.mean(2) - known).abs() < 5.0 * sums.sigma(2).max(1e-5), "{} {known}", sums.mean(2));
}

#[test]
fn no_medium_makes_a_walk_hang_or_end_in_nonsense() {
    let values = [0.0, 1e-30, 1e-3, 1.0, 1e4, 1e12, f32::MAX, f32::INFINITY, f32::NAN, -1.0];
    let mut worst = WalkStats::default();
    for (i, s) in values.into_iter().enumerate() {
        for (j, a) in values.into_iter().enumerate() {
            let medium = Medium {
                sigma_s: [s, values[(i + j) % values.len()], 3.0],
                sigma_a: [a, values[(i + 3 * j) % values.len()], 1e-6],
            };
            for throughput in [[1.0; 3], [1e-30, 0.0, 1.0], [1e30, 1e-38, 0.0]] {
                worst.add(&ends(&Body::new(&medium, 1.0), throughput, 6, |_, _| {}));
            }
        }
    }
    assert_eq!((worst.cut, worst.outside), (0, 0));
    let dark = Body::new(&medium([1.0; 3], [0.1; 3]), f32::NAN);
    for throughput in [[0.0; 3], [f32::NAN; 3], [-1.0, 0.0, f32::INFINITY]] {
        ends(&dark, throughput, 3, |_, end| assert_eq!(end, End::Absorbed));
    }
}

/// The surface of the ball above a plane; nothing below.
struct Dome;

impl Boundary for Dome {
    fn hit(&self, p: DVec3, d: Vec3, t_max: f32) -> Hit {
        // Whoever has left through the hole meets nothing more.
        if p.length_squared() > 1.0 {
            return Hit::MISS;
        }
        let hit = Ball.hit(p, d, t_max);
        if p.z + f64::from(d.z) * f64::from(hit.t) > -0.2 { hit } else { Hit::MISS }
    }
    fn nearest(&self, p: DVec3, r_max: f64, tolerance: f64) -> Option<Nearest> {
        Ball.nearest(p, r_max, tolerance).filter(|nearest| nearest.point.z > -0.2)
    }
    fn normal(&self, triangle: u32, p: DVec3) -> Vec3 {
        Ball.normal(triangle, p)
    }
    fn is_outside(&self, _: u32, _: &Hit, _: Vec3) -> bool {
        false
    }
}

#[test]
fn walks_end_also_where_the_mesh_is_open() {
    for (extinction, absorbed) in [(0.5, 0.0), (5.0, 0.0), (100.0, 0.0), (100.0, 0.3)] {
        let body = Body::new(&medium([extinction; 3], [absorbed; 3]), 1.0);
        let mut stats = WalkStats::default();
        for method in METHODS {
            for i in 0..60 {
                let entry = entry(&Dome, DVec3::Z, inwards(DVec3::Z, true, 5, i), [1.0; 3], 5, i);
                walk(&Dome, &body, &entry, method, &mut stats);
            }
        }
        assert_eq!(stats.cut, 0);
    }
}
