//! The tree: built by `obvhs`, collapsed to eight children a node.

use super::{BLOCK, Block, Bvh, EMPTY, LEAF, NONE, Node};
use glam::Vec3;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::triangle::Triangle;
use obvhs::{BvhBuildParams, ploc::PlocSearchDistance};
use std::time::Duration;

impl Bvh {
    /// A tree over these triangles. Those without area, or with corners that are not finite, are left out.
    pub fn new(triangles: &[[Vec3; 3]]) -> Self {
        let ids = with_area(triangles);
        if ids.is_empty() {
            return Self::default();
        }
        let binary = binary_tree(triangles, &ids);
        let mut builder = Collapse { binary: &binary, triangles, ids: &ids, bvh: Self::default() };
        builder.run();
        builder.bvh
    }
}

/// A tree of two children a node over those triangles, with up to [`BLOCK`] of them a leaf.
pub(super) fn binary_tree(triangles: &[[Vec3; 3]], ids: &[u32]) -> Bvh2 {
    let kept: Vec<Triangle> = ids
        .iter()
        .map(|&i| {
            let [a, b, c] = triangles[i as usize];
            Triangle { v0: a.into(), v1: b.into(), v2: c.into() }
        })
        .collect();
    let params = BvhBuildParams {
        ploc_search_distance: PlocSearchDistance::Low,
        max_prims_per_leaf: BLOCK as u32,
        ..BvhBuildParams::medium_build()
    };
    let mut build_time = Duration::ZERO;
    build_bvh2_from_tris(&kept, params, &mut build_time)
}

/// Positions of the triangles that rays can meet: those with an area, and corners that are finite.
pub(super) fn with_area(triangles: &[[Vec3; 3]]) -> Vec<u32> {
    let has_area = |&i: &u32| {
        let [a, b, c] = triangles[i as usize];
        let area = (b - a).as_dvec3().cross((c - a).as_dvec3()).length_squared();
        area > 0.0 && area.is_finite()
    };
    (0..triangles.len() as u32).filter(has_area).collect()
}

/// Turns the binary tree into one with eight children a node.
struct Collapse<'a> {
    binary: &'a Bvh2,
    triangles: &'a [[Vec3; 3]],
    /// Input positions of the triangles that the binary tree holds.
    ids: &'a [u32],
    bvh: Bvh,
}

impl Collapse<'_> {
    fn run(&mut self) {
        self.bvh.nodes.push(Node { bounds: [[0.0; 8]; 6], children: [EMPTY; 8] });
        let mut open = vec![(0usize, 0usize)];
        while let Some((source, target)) = open.pop() {
            let mut members = vec![source];
            // Opening the largest inner child first keeps the sum of areas small.
            while members.len() < 8 {
                let largest = (0..members.len()).filter(|&i| !self.binary.nodes[members[i]].is_leaf()).max_by(|&a, &b| {
                    let area = |i: usize| self.binary.nodes[members[i]].aabb().half_area();
                    area(a).total_cmp(&area(b))
                });
                let Some(i) = largest else { break };
                let first = self.binary.nodes[members[i]].first_index as usize;
                members[i] = first;
                members.push(first + 1);
            }
            let mut node = Node {
                bounds: std::array::from_fn(|k| [if k < 3 { f32::INFINITY } else { f32::NEG_INFINITY }; 8]),
                children: [EMPTY; 8],
            };
            for (slot, member) in members.into_iter().enumerate() {
                let source = &self.binary.nodes[member];
                let (min, max) = (source.aabb().min.to_array(), source.aabb().max.to_array());
                for k in 0..3 {
                    node.bounds[k][slot] = min[k];
                    node.bounds[k + 3][slot] = max[k];
                }
                node.children[slot] = if source.is_leaf() {
                    let first = source.first_index as usize;
                    self.leaf(first, first + source.prim_count as usize)
                } else {
                    self.bvh.nodes.push(Node { bounds: [[0.0; 8]; 6], children: [EMPTY; 8] });
                    open.push((member, self.bvh.nodes.len() - 1));
                    (self.bvh.nodes.len() - 1) as u32
                };
            }
            self.bvh.nodes[target] = node;
        }
    }

    /// A block, or, where a leaf holds more than a block does, a node over blocks.
    fn leaf(&mut self, first: usize, end: usize) -> u32 {
        if end - first <= BLOCK {
            let mut block = Block { corners: [[[0.0; 4]; 3]; 3], ids: [NONE; 4] };
            for (slot, i) in (first..end).enumerate() {
                let id = self.ids[self.binary.primitive_indices[i] as usize];
                block.ids[slot] = id;
                for (c, corner) in self.triangles[id as usize].iter().enumerate() {
                    for (k, x) in corner.to_array().into_iter().enumerate() {
                        block.corners[c][k][slot] = x;
                    }
                }
            }
            self.bvh.blocks.push(block);
            return LEAF | (self.bvh.blocks.len() - 1) as u32;
        }
        let index = self.bvh.nodes.len();
        self.bvh.nodes.push(Node {
            bounds: std::array::from_fn(|k| [if k < 3 { f32::INFINITY } else { f32::NEG_INFINITY }; 8]),
            children: [EMPTY; 8],
        });
        let step = (end - first).div_ceil(8).max(BLOCK);
        for (slot, start) in (first..end).step_by(step).enumerate() {
            let stop = (start + step).min(end);
            let child = self.leaf(start, stop);
            let node = &mut self.bvh.nodes[index];
            node.children[slot] = child;
            for i in start..stop {
                let id = self.ids[self.binary.primitive_indices[i] as usize];
                for corner in self.triangles[id as usize] {
                    for (k, x) in corner.to_array().into_iter().enumerate() {
                        node.bounds[k][slot] = node.bounds[k][slot].min(x);
                        node.bounds[k + 3][slot] = node.bounds[k + 3][slot].max(x);
                    }
                }
            }
        }
        index as u32
    }
}
