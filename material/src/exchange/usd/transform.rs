//! Where a prim stands: its transform operations as one matrix. Vectors are rows, as in USD: `p' = p · M`.

use super::layer::{Layer, PrimId, Value};
use crate::exchange::short::short;

/// A 4 by 4 matrix by rows.
pub(super) type Matrix = [[f64; 4]; 4];

/// The matrix that changes nothing.
pub(super) const IDENTITY: Matrix = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
/// More operations than a prim has.
const MAX_OPERATIONS: usize = 32;

/// From the space of a prim to that of the layer. Operations that cannot be read are named in `faults`.
pub(super) fn to_layer(layer: &Layer, mut prim: PrimId, faults: &mut Vec<String>) -> Matrix {
    let mut matrix = IDENTITY;
    while prim != Layer::ROOT {
        let (local, resets) = local(layer, prim, faults);
        matrix = product(&matrix, &local);
        if resets {
            break;
        }
        prim = layer.prim(prim).parent;
    }
    matrix
}

/// A prim's own matrix, and whether what it stands in does not move it.
fn local(layer: &Layer, prim: PrimId, faults: &mut Vec<String>) -> (Matrix, bool) {
    let (mut matrix, mut resets) = (IDENTITY, false);
    let order = layer.value(prim, "xformOpOrder").map_or(&[][..], Value::texts);
    // The first operation of the list is the outermost one.
    for name in order.iter().take(MAX_OPERATIONS) {
        if name == "!resetXformStack!" {
            (matrix, resets) = (IDENTITY, true);
            continue;
        }
        let (bare, inverts) = name.strip_prefix("!invert!").map_or((name.as_ref(), false), |bare| (bare, true));
        let operation = layer.value(prim, bare).and_then(|value| operation(bare, value));
        match operation.and_then(|matrix| if inverts { inverse(&matrix) } else { Some(matrix) }) {
            Some(next) => matrix = product(&next, &matrix),
            None => faults.push(format!(
                "<{}>: expected an operation of transforms, found `{}`; not used",
                short(&layer.path(prim)),
                short(name)
            )),
        }
    }
    (matrix, resets)
}

/// The matrix of `xformOp:KIND` or `xformOp:KIND:NAME`.
fn operation(name: &str, value: &Value) -> Option<Matrix> {
    let kind = name.strip_prefix("xformOp:")?.split(':').next()?;
    let mut matrix = IDENTITY;
    match kind {
        "translate" => matrix[3][..3].copy_from_slice(value.tuple(3)?),
        "scale" => {
            for (k, s) in value.tuple(3)?.iter().enumerate() {
                matrix[k][k] = *s;
            }
        }
        "transform" => {
            for (k, row) in value.tuple(16)?.chunks_exact(4).enumerate() {
                matrix[k].copy_from_slice(row);
            }
        }
        "orient" => {
            let [w, x, y, z] = value.tuple(4)?.try_into().ok()?;
            matrix = quaternion(w, x, y, z)?;
        }
        _ => {
            let axes = kind.strip_prefix("rotate").filter(|axes| !axes.is_empty() && axes.len() <= 3)?;
            let degrees = value.tuple(if axes.len() == 1 { 1 } else { 3 })?;
            // The first letter turns first.
            for axis in axes.bytes() {
                let k = b"XYZ".iter().position(|letter| *letter == axis)?;
                let angle = if degrees.len() == 1 { degrees[0] } else { degrees[k] };
                matrix = product(&matrix, &rotation(k, angle));
            }
        }
    }
    Some(matrix)
}

/// A counterclockwise turn about an axis, degrees.
fn rotation(axis: usize, degrees: f64) -> Matrix {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut matrix = IDENTITY;
    (matrix[a][a], matrix[a][b], matrix[b][a], matrix[b][b]) = (cos, sin, -sin, cos);
    matrix
}

fn quaternion(w: f64, x: f64, y: f64, z: f64) -> Option<Matrix> {
    let length = w * w + x * x + y * y + z * z;
    if length <= 0.0 {
        return None;
    }
    let s = 2.0 / length;
    Some([
        [1.0 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y), 0.0],
        [s * (x * y - w * z), 1.0 - s * (x * x + z * z), s * (y * z + w * x), 0.0],
        [s * (x * z + w * y), s * (y * z - w * x), 1.0 - s * (x * x + y * y), 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ])
}

/// First `a`, then `b`.
pub(super) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

/// The inverse, by elimination; `None` for a matrix that flattens.
pub(super) fn inverse(matrix: &Matrix) -> Option<Matrix> {
    let (mut left, mut right) = (*matrix, IDENTITY);
    for column in 0..4 {
        let pivot = (column..4).max_by(|a, b| left[*a][column].abs().total_cmp(&left[*b][column].abs()))?;
        if left[pivot][column].abs() < 1e-300 || !left[pivot][column].is_finite() {
            return None;
        }
        left.swap(column, pivot);
        right.swap(column, pivot);
        let scale = 1.0 / left[column][column];
        left[column] = left[column].map(|x| x * scale);
        right[column] = right[column].map(|x| x * scale);
        for row in (0..4).filter(|row| *row != column) {
            let factor = left[row][column];
            for k in 0..4 {
                left[row][k] -= factor * left[column][k];
                right[row][k] -= factor * right[column][k];
            }
        }
    }
    Some(right)
}

/// A point through a matrix.
pub(super) fn point(m: &Matrix, p: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|j| p[0] * m[0][j] + p[1] * m[1][j] + p[2] * m[2][j] + m[3][j])
}

/// A direction across surfaces, through the inverse matrix of the one that moves them; of length 1, or as it was where it has none.
pub(super) fn normal(inverse: &Matrix, n: [f64; 3]) -> [f64; 3] {
    let moved: [f64; 3] = std::array::from_fn(|j| (0..3).map(|k| n[k] * inverse[j][k]).sum());
    let length = moved.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() { moved.map(|x| x / length) } else { n }
}

/// Whether a matrix mirrors: whether its upper 3 by 3 part has a negative determinant.
pub(super) fn mirrors(m: &Matrix) -> bool {
    let minor = |a: usize, b: usize| m[1][a] * m[2][b] - m[1][b] * m[2][a];
    m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1) < 0.0
}
