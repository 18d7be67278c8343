//! The tree for graphics devices: two children a node, plain words.

use glam::Vec3;
use obvhs::bvh2::Bvh2;

/// Marks a child as a run of triangles: place of the first in bits 3 to 30, their number less one below.
const LEAF: u32 = 1 << 31;
/// Places for triangles.
const TRIANGLES_MAX: usize = 1 << 28;

/// A tree of two children a node. Bounds and corners are bits of `f32`.
#[derive(Clone, Debug, Default)]
pub(crate) struct FlatTree {
    /// Per node: lower corner and code of the first child, upper corner of it and code of the second, then both corners of the second. A code
    /// is the place of a node, or marks a leaf.
    pub nodes: Vec<[[u32; 4]; 4]>,
    /// Per triangle: its corners; behind the first its position in the input.
    pub triangles: Vec<[[u32; 4]; 3]>,
    /// Code of the root; `None` without triangles.
    pub root: Option<u32>,
    /// Inner nodes between the root and the deepest leaf.
    pub depth: u32,
}

impl FlatTree {
    /// A tree over these triangles. Those without area, or with corners that are not finite, are left out, and so are those beyond 2^28.
    pub fn new(triangles: &[[Vec3; 3]]) -> Self {
        let ids: Vec<u32> = super::build::with_area(triangles).into_iter().take(TRIANGLES_MAX).collect();
        if ids.is_empty() {
            return Self::default();
        }
        let binary = super::build::binary_tree(triangles, &ids);
        let mut flat = Self::default();
        flat.triangles.reserve(ids.len());
        // Children are placed before anything below them: near nodes lie near each other.
        let mut open = Vec::new();
        let root = flat.place(&binary, 0, &ids, triangles, 0, &mut open);
        flat.root = Some(root);
        while let Some((source, target, depth)) = open.pop() {
            flat.depth = flat.depth.max(depth);
            let first = binary.nodes[source].first_index as usize;
            let codes = [first, first + 1].map(|child| flat.place(&binary, child, &ids, triangles, depth, &mut open));
            let corners = [first, first + 1].map(|child| {
                let bounds = binary.nodes[child].aabb();
                [bounds.min, bounds.max].map(|v| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits()])
            });
            let word = |[x, y, z]: [u32; 3], w: u32| [x, y, z, w];
            flat.nodes[target] =
                [word(corners[0][0], codes[0]), word(corners[0][1], codes[1]), word(corners[1][0], 0), word(corners[1][1], 0)];
        }
        flat
    }

    /// Gives a node of the source its place and returns its code.
    fn place(
        &mut self,
        binary: &Bvh2,
        source: usize,
        ids: &[u32],
        triangles: &[[Vec3; 3]],
        depth: u32,
        open: &mut Vec<(usize, usize, u32)>,
    ) -> u32 {
        let node = &binary.nodes[source];
        if !node.is_leaf() {
            self.nodes.push([[0; 4]; 4]);
            open.push((source, self.nodes.len() - 1, depth + 1));
            return (self.nodes.len() - 1) as u32;
        }
        let (place, first) = (self.triangles.len() as u32, node.first_index as usize);
        for i in first..first + node.prim_count as usize {
            let id = ids[binary.primitive_indices[i] as usize];
            let [a, b, c] = triangles[id as usize].map(|v| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), 0]);
            self.triangles.push([[a[0], a[1], a[2], id], b, c]);
        }
        LEAF | place << 3 | (node.prim_count - 1)
    }
}
