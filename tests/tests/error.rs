//! Is the stated error of a picture the true one?

use burnish_renderer::path::Prepared;
use burnish_tests::coverage::{Reference, SITUATIONS, cases, scene};

const SIZE: usize = 48;

#[test]
fn the_interval_holds_the_true_error() {
    let (mut all, mut inside) = (0, 0);
    for number in [0, 5, 11] {
        let prepared = Prepared::new(&scene(SITUATIONS[number]), None);
        let reference = Reference::new(&prepared, SIZE, 512);
        for case in cases(&prepared, &reference, SIZE, 1, &[8, 16, 32, 64], true) {
            all += 1;
            inside += u32::from(case.is_inside());
            let ratio = case.told.relmse / case.truth;
            assert!((0.5..2.0).contains(&ratio), "{:?}: {case:?}", SITUATIONS[number]);
            assert!(case.spp < 64 || case.span() <= 2.0, "{:?}: {case:?}", SITUATIONS[number]);
        }
    }
    assert!(10 * inside >= 9 * all, "{inside} of {all}");
}
