//! Footprints: how wide the bundle of light is that a path stands for, so that images are read no finer than they show.
//!
//! A path carries a cone: its width where the ray starts and how fast it widens. A camera ray starts as narrow as a point and widens as
//! its pixel does. Source: Akenine-Möller et al., Ray Tracing Gems 2019, chapter 20; curvature is left out, which reads images finer
//! than needed behind curved mirrors and never coarser.

use super::batch::Paths;
use super::raygen::View;

/// Directions that are taken to share the space around a rough lobe: as many as there are samples in a pixel of a quick picture. One
/// direction of density `p` then stands for a solid angle of `1 / (16 p)`.
const SHARERS: f32 = 16.0;
/// Widest spread. Half a white hemisphere's: beyond it what lies near would be smeared.
const SPREAD_MAX: f32 = 0.25;

impl View {
    /// How fast the cone of a pixel widens: its height at distance 1.
    pub(super) fn spread(&self) -> f32 {
        2.0 * self.basis.up.length() / self.height.max(1) as f32
    }
}

impl Paths {
    /// Width of a path's cone where its last ray arrived, normalised units.
    #[inline(always)]
    pub(super) fn width_at_hit(&self, path: usize) -> f32 {
        self.cone_width[path] + self.cone_spread[path] * self.hits[path].t
    }

    /// Carries the cone on from the last hit. `pdf` is the density with which a rough lobe chose the new direction; 0 where the way
    /// was the only one.
    #[inline(always)]
    pub(super) fn extend_cone(&mut self, path: usize, pdf: f32) {
        self.cone_width[path] = self.width_at_hit(path);
        if pdf > 0.0 {
            self.cone_spread[path] = self.cone_spread[path].max(spread_of(pdf));
        }
    }
}

/// Spread of a cone that fills its share of the directions around one of density `pdf`, 1/sr.
#[inline(always)]
fn spread_of(pdf: f32) -> f32 {
    // A cone of full angle a has the solid angle pi a^2 / 4.
    let solid_angle = 1.0 / (SHARERS * pdf);
    (4.0 / std::f32::consts::PI * solid_angle).sqrt().min(SPREAD_MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cones_widen_with_the_lobe() {
        // A hemisphere, a narrow lobe, and one next to a mirror.
        assert_eq!(spread_of(0.5 / std::f32::consts::PI), SPREAD_MAX);
        assert!((spread_of(10.0) - 0.0892).abs() < 1e-3);
        assert!(spread_of(1e9) < 1e-4);
        let mut paths = Paths::default();
        paths.resize(1);
        (paths.cone_width[0], paths.cone_spread[0], paths.hits[0].t) = (0.5, 0.01, 10.0);
        paths.extend_cone(0, 0.0);
        assert_eq!((paths.cone_width[0], paths.cone_spread[0]), (0.6, 0.01));
        paths.extend_cone(0, 10.0);
        assert!(paths.cone_spread[0] > 0.08);
        // A narrower lobe does not narrow it.
        paths.extend_cone(0, 1e9);
        assert!(paths.cone_spread[0] > 0.08);
    }
}
