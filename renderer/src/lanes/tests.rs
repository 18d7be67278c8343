//! Every width gives the same bits; elementary functions agree with double precision.

use super::*;

/// Numbers of all magnitudes, and the borders.
fn numbers() -> Vec<f32> {
    let mut x: Vec<f32> = vec![
        0.0,
        -0.0,
        1.0,
        -1.0,
        f32::MIN_POSITIVE,
        -f32::MIN_POSITIVE,
        1e-45,
        -1e-45,
        1e-40,
        f32::MAX,
        f32::MIN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
        88.722_83,
        88.722_85,
        -87.336_55,
        -103.97,
        -104.1,
        std::f32::consts::SQRT_2,
        std::f32::consts::FRAC_1_SQRT_2,
        8192.0,
        8193.0,
        1e9,
    ];
    let mut state = 1u32;
    for i in 0..6000 {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = state ^ (state >> 15);
        x.push(match i % 3 {
            0 => f32::from_bits(word),
            1 => (word >> 8) as f32 / 16_777_216.0 * 14.0 - 7.0,
            _ => (word >> 8) as f32 / 16_777_216.0 * 220.0 - 110.0,
        });
    }
    x.resize(x.len().next_multiple_of(MAX_LANES), 0.5);
    x
}

/// Everything that lanes can do with two numbers.
fn all<L: Lanes>(a: L, b: L, table: &[f32]) -> Vec<L> {
    let (sin, cos) = a.sin_cos();
    // The parts of what is not a normal positive number have no meaning, but are the same.
    let (m, e) = L::select(a.is_finite(), a, L::one()).split_binary();
    let index: [usize; MAX_LANES] = b.abs().to_array().map(|x| x as usize);
    let flag = |mask: L::Mask| L::select(mask, L::one(), L::zero());
    vec![
        a + b,
        a - b,
        a * b,
        a / b,
        -a,
        a.halves().0,
        a.halves().1,
        a.sqrt(),
        a.abs(),
        a.floor(),
        a.exp(),
        a.exp_m1(),
        a.ln(),
        sin,
        cos,
        m,
        e,
        a.floor().max(L::of(-126.0)).min(L::of(127.0)).exp2_whole(),
        a.min(b),
        a.max(b),
        a.lesser(b),
        a.greater(b),
        L::gather(table, b),
        L::gather_at(table, &index),
        L::gather_at(&[], &index),
        L::gather(&[], b),
        flag(a.lt(b)),
        flag(a.le(b)),
        flag(a.eq(b)),
        flag(a.is_finite()),
        flag(!(a.lt(b) | b.eq(a)) & a.is_finite()),
    ]
}

struct All<'a>(&'a [f32], &'a [f32]);

impl Kernel for All<'_> {
    type Output = Vec<Vec<u32>>;
    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let table: Vec<f32> = (0..300).map(|i| i as f32).collect();
        let mut out = Vec::new();
        for start in (0..self.0.len()).step_by(L::WIDTH) {
            let (a, b) = (L::from_fn(|i| self.0[start + i]), L::from_fn(|i| self.1[start + i]));
            let results = all(a, b, &table);
            for lane in 0..L::WIDTH {
                let bits = |x: &L| if x.lane(lane).is_nan() { u32::MAX } else { x.lane(lane).to_bits() };
                out.push(results.iter().map(bits).collect());
            }
        }
        out
    }
}

#[test]
fn every_width_gives_the_same_bits() {
    let a = numbers();
    let mut b = a.clone();
    b.rotate_left(1234);
    let one = All(&a, &b).run::<f32>();
    for (name, many) in [
        ("eight", All(&a, &b).run::<Wide<8>>()),
        ("sixteen", All(&a, &b).run::<Wide<16>>()),
        ("this processor's", dispatch(All(&a, &b))),
    ] {
        for (i, (x, y)) in one.iter().zip(&many).enumerate() {
            assert_eq!(x, y, "{name} lanes: {} {}", a[i], b[i]);
        }
    }
}

/// Error in units of the last place of the exact result.
fn ulps(x: f32, exact: f64) -> f64 {
    let nearest = exact as f32;
    if x == nearest || (x.is_nan() && nearest.is_nan()) {
        return 0.0;
    }
    let unit = (f64::from(nearest.abs().next_up()) - f64::from(nearest.abs())).max(f64::from(f32::from_bits(1)));
    ((f64::from(x) - exact) / unit).abs()
}

#[test]
fn elementary_functions_agree_with_double_precision() {
    for x in numbers() {
        let wide = f64::from(x);
        assert!(ulps(Lanes::exp(x), wide.exp()) <= 2.0, "exp({x})");
        assert!(ulps(Lanes::exp_m1(x), wide.exp_m1()) <= 2.0, "exp_m1({x}) {} {}", Lanes::exp_m1(x), wide.exp_m1());
        assert!(ulps(Lanes::ln(x), wide.ln()) <= 2.0, "ln({x})");
        let (s, c) = Lanes::sin_cos(x);
        for (name, got, exact) in [("sin", s, wide.sin()), ("cos", c, wide.cos())] {
            // Near a root far from 0 the angle itself holds no more digits.
            let is_close = ulps(got, exact) <= 2.0 || (f64::from(got) - exact).abs() < 6e-8 * (1.0 + wide.abs() / 64.0).min(64.0);
            assert!(is_close, "{name}({x}): {got} {exact}");
        }
    }
    assert_eq!(Lanes::ln(0.0f32), f32::NEG_INFINITY);
    assert!(Lanes::ln(-1.0f32).is_nan() && Lanes::exp(f32::NAN).is_nan() && Lanes::exp_m1(f32::NAN).is_nan());
    assert_eq!([Lanes::exp(f32::NEG_INFINITY), Lanes::exp(f32::INFINITY)], [0.0, f32::INFINITY]);
    assert_eq!([Lanes::exp_m1(f32::NEG_INFINITY), Lanes::exp_m1(f32::INFINITY)], [-1.0, f32::INFINITY]);
    assert!(Lanes::exp_m1(-0.0f32).is_sign_negative());
}

#[test]
fn masks_turn_into_bits_and_back() {
    fn check<M: Mask>(width: usize) {
        for word in [0u32, 1, 0x8001, 0x5a5a, 0xffff, 0xffff_ffff] {
            let expected = word & (((1u64 << width) - 1) as u32);
            let mask = M::from_bits(word);
            assert_eq!(mask.bits(), expected);
            assert_eq!(mask.any(), expected != 0);
            assert_eq!(M::from_fn(|i| (word >> i) & 1 == 1).bits(), expected);
        }
    }
    check::<bool>(1);
    check::<WideMask<8>>(8);
    check::<WideMask<16>>(16);
}

#[test]
fn halves_are_those_of_the_format() {
    for (low, high) in [(0.0f32, 1.0f32), (65504.0, 0.333), (6.1e-5, 1024.5), (1e-7, 3.0)] {
        let [low, high] = [low, high].map(half::f16::from_f32);
        let word = f32::from_bits(u32::from(low.to_bits()) | u32::from(high.to_bits()) << 16);
        let (a, b) = word.halves();
        assert_eq!([a, b].map(|x| x * 2f32.powi(112)), [low.to_f32(), high.to_f32()]);
    }
}
