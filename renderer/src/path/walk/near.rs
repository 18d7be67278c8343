//! How far the surface is, remembered: the distance cannot change faster than the walk moves, so most collisions need no query and most
//! flights deep inside no ray.

use super::field::Depth;
use super::{Boundary, Entry, jump, rounding};
use glam::DVec3;

/// How much farther than the nearest surface the one found may be. Costs a tenth of the distance, saves most of a query.
const TOLERANCE: f64 = 0.1;

/// The last known nearest surface.
pub(super) struct Near {
    /// Where it was asked for.
    anchor: DVec3,
    /// A point of the surface, the nearest or nearly so.
    point: DVec3,
    /// No surface is nearer to the anchor than this.
    distance: f64,
    /// Unit vector towards it; none before the first query, or where queries find nothing.
    pub guide: Option<DVec3>,
}

impl Near {
    /// The point of entry is on the surface.
    pub(super) fn new(entry: &Entry) -> Self {
        Self { anchor: entry.position, point: entry.position, distance: 0.0, guide: None }
    }

    /// No surface is nearer than this. May be negative.
    pub(super) fn within(&self, position: DVec3) -> f64 {
        self.distance - self.anchor.distance(position)
    }

    /// Takes over what is known of a place without a query.
    pub(super) fn learn(&mut self, position: DVec3, depth: &Depth) {
        self.guide = Some(depth.normal);
        if depth.at_least > self.within(position) {
            (self.anchor, self.distance) = (position, depth.at_least);
        }
    }

    /// Whether a query at this place may tell something useful. `extinction` is that for which jumps are looked for.
    pub(super) fn is_worth_a_query(&self, position: DVec3, extinction: Option<f64>, steers: bool, radius: f64) -> bool {
        if let Some(s) = extinction {
            let at_most = self.point.distance(position) / (1.0 + TOLERANCE);
            if jump::doublings(s * at_most) > jump::doublings(s * self.within(position)) {
                return true;
            }
        }
        // Where the surface is near, its direction holds for a walk along it; where it is far, until half the way there.
        steers && (self.guide.is_none() || self.anchor.distance(position) > (0.5 * self.distance).max(radius / 8.0))
    }

    /// Asks for the nearest surface.
    pub(super) fn query<B: Boundary>(&mut self, boundary: &B, position: DVec3) {
        let slack = 4.0 * rounding(position);
        let at_most = self.point.distance(position) + slack;
        let Some(nearest) = boundary.nearest(position, at_most, TOLERANCE) else {
            // Nothing is known, least of all that it is safe to fly.
            (self.anchor, self.distance, self.guide) = (position, 0.0, None);
            return;
        };
        let way = nearest.point - position;
        let distance = way.length();
        // The direction of a way that is shorter than the rounding of its ends says nothing.
        let guide =
            if distance > 16.0 * slack { way / distance } else { boundary.normal(nearest.triangle, nearest.point).as_dvec3() };
        let safe = (distance / (1.0 + TOLERANCE) - slack).max(0.0);
        *self = Self { anchor: position, point: nearest.point, distance: safe, guide: Some(guide) };
    }
}
