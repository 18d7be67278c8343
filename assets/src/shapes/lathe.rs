//! Surfaces of revolution: profiles made of arcs and lines, turned about an axis.

use std::f32::consts::TAU;

use glam::{Mat3, Vec2, Vec3};

use super::SurfacePoint;
use crate::mesh::Mesh;

/// A profile in the half plane of `x` = distance from the axis and `y` = height along it, walked from the upper end
/// of the axis to the lower one: the body lies on the right hand. Each point has its outward normal.
#[derive(Default)]
pub(super) struct Profile {
    points: Vec<(Vec2, Vec2)>,
}

impl Profile {
    /// Adds a point with its outward normal. At the place of the last one it is left out, unless its normal is
    /// another: then the two make a sharp edge.
    pub(super) fn point(&mut self, position: Vec2, normal: Vec2) {
        let normal = normal.normalize();
        match self.points.last() {
            Some(&(last, last_normal)) if last.distance(position) < 1e-5 => {
                if last_normal.dot(normal) < 0.999 {
                    self.points.push((last, normal));
                }
            }
            _ => self.points.push((position, normal)),
        }
    }

    /// Adds an arc about `center` from `from_deg` to `to_deg`, angles from the axis' upper end outwards (0 is up, 90
    /// away from the axis), in `steps` equal steps. An arc whose angle grows is a bulge, one whose angle falls a hollow.
    pub(super) fn arc(&mut self, center: Vec2, radius: f32, from_deg: f32, to_deg: f32, steps: u32) {
        let outwards = if to_deg > from_deg { 1.0 } else { -1.0 };
        for step in 0..=steps {
            let angle = from_deg + (to_deg - from_deg) * step as f32 / steps as f32;
            // Exact at the axis, where a rounded 0 would leave a pinhole.
            let direction = match angle {
                0.0 => Vec2::Y,
                180.0 => Vec2::NEG_Y,
                _ => Vec2::new(angle.to_radians().sin(), angle.to_radians().cos()),
            };
            self.point(center + radius * direction, direction * outwards);
        }
    }

    /// Adds the inner points of a straight line from the last point to `to`, so that the line has `steps` pieces; the end belongs to
    /// what follows.
    pub(super) fn line(&mut self, to: Vec2, steps: u32) {
        let Some(&(from, _)) = self.points.last() else { return };
        let along = to - from;
        for step in 1..steps {
            self.point(from + along * (step as f32 / steps as f32), Vec2::new(-along.y, along.x));
        }
    }

    /// Turns the profile about the axis in `segments` steps.
    ///
    /// `world_from_local` rotates the body, whose axis is +Y and whose seam lies at -Z, before it is moved to `center`.
    /// u goes once around to the right, v down the profile in proportion to its length. On the axis every triangle has
    /// a vertex of its own, so that no uv is degenerate; places on the seam and the axis are repeated bit by bit, so
    /// the surface is watertight by position.
    pub(super) fn turn(&self, name: &str, segments: u32, world_from_local: Mat3, center: Vec3) -> Mesh {
        let mut mesh = Mesh { name: name.to_owned(), ..Mesh::default() };
        let mut lengths = vec![0.0_f32];
        for pair in self.points.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + pair[0].0.distance(pair[1].0));
        }
        let whole = lengths[lengths.len() - 1];

        let mut rows: Vec<u32> = Vec::new();
        for (&(p, n), length) in self.points.iter().zip(&lengths) {
            rows.push(mesh.positions.len() as u32);
            let is_pole = p.x <= 0.0;
            for step in 0..segments + u32::from(!is_pole) {
                let u = (step as f32 + if is_pole { 0.5 } else { 0.0 }) / segments as f32;
                // The last column repeats the first one's place exactly.
                let turn = if step == segments { 0.0 } else { u };
                let (sin, cos) = (turn * TAU).sin_cos();
                let around = |v: Vec2| world_from_local * Vec3::new(-v.x * sin, v.y, -v.x * cos);
                mesh.push(SurfacePoint {
                    position: center + around(p.with_x(p.x.max(0.0))),
                    normal: around(n),
                    tangent: world_from_local * Vec3::new(-cos, 0.0, sin),
                    uv: Vec2::new(u, length / whole),
                });
            }
        }
        for (i, pair) in self.points.windows(2).enumerate() {
            let (upper, lower) = (rows[i], rows[i + 1]);
            // Between the two sides of a sharp edge there is nothing.
            if pair[0].0 == pair[1].0 {
                continue;
            }
            for step in 0..segments {
                if pair[1].0.x > 0.0 {
                    mesh.triangles.push([upper + step, lower + step, lower + step + 1]);
                }
                if pair[0].0.x > 0.0 {
                    mesh.triangles.push([upper + step, lower + step + u32::from(pair[1].0.x > 0.0), upper + step + 1]);
                }
            }
        }
        mesh
    }
}
