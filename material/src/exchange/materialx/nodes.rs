//! The nodes of MaterialX that fold: arithmetic, channels, images, coordinates and normals. Anything else is unknown, and said so.
//!
//! Definitions and defaults: MaterialX 1.39, standard library.

use super::image;
use super::numbers::{self, Part, Parts, constant_only, count_of};
use super::walk::{COORDINATES, Direction, Normal, Term, Walk};
use super::xml::Id;

type Folded = Result<Term, Term>;

const NOT_LINEAR: &str = "is more than a factor and an offset on one image";

/// What a node gives, from what stands before it.
pub fn compute(walk: &mut Walk, node: Id) -> Term {
    fold(walk, node).unwrap_or_else(|unknown| unknown)
}

fn fold(walk: &mut Walk, node: Id) -> Folded {
    let tag = walk.graph.tree.tag(node);
    let kind = walk.graph.tree.attribute(node, "type").unwrap_or_default();
    let count = count_of(kind).unwrap_or(if matches!(kind, "multioutput" | "") { 4 } else { 0 });
    let whole = |parts: Option<Parts>| parts.map(|parts| Term::Numbers(Box::new(parts))).ok_or(Term::Unknown(node, NOT_LINEAR));
    match tag {
        "constant" => walk.input(node, "value").ok_or(Term::Unknown(node, "has no value")),
        "dot" | "saturate" | "normalize" | "absval" | "sign" | "floor" | "ceil" | "round" | "fract" | "sqrt" | "exp" | "ln"
        | "sin" | "cos" | "tan" | "magnitude" | "luminance" => one(walk, node, tag, count),
        "add" | "subtract" | "multiply" | "divide" | "power" | "safepower" | "modulo" | "min" | "max" => {
            two(walk, node, tag, count)
        }
        "invert" => {
            let (value, amount) = (walk.numbers(node, "in", &[0.0])?, walk.numbers(node, "amount", &[1.0])?);
            whole(amount.zip(&value, count, Part::minus))
        }
        "clamp" => {
            let (low, high) = (walk.numbers(node, "low", &[0.0])?, walk.numbers(node, "high", &[1.0])?);
            let value = walk.numbers(node, "in", &[0.0])?;
            // Images lie within 0 and 1 by nature.
            if value.as_constants().is_none() && at_most(&low, 0.0) && at_least(&high, 1.0) {
                return whole(Some(value));
            }
            let raised = value.zip(&low, count, constant_only(f64::max));
            whole(raised.and_then(|value| value.zip(&high, count, constant_only(f64::min))))
        }
        "mix" => {
            let (fg, bg) = (walk.numbers(node, "fg", &[0.0])?, walk.numbers(node, "bg", &[0.0])?);
            let amount = walk.numbers(node, "mix", &[0.0])?;
            let parts: Option<Vec<Part>> = (0..count)
                .map(|k| bg.at(k).plus(&fg.at(k).minus(&bg.at(k)).and_then(|part| part.product(&amount.at(k)))?))
                .collect();
            whole(parts.and_then(|parts| Parts::of(&parts)))
        }
        "remap" => {
            let value = walk.numbers(node, "in", &[0.0])?;
            let [[from, to], [low, high]] = [("inlow", "inhigh"), ("outlow", "outhigh")]
                .map(|(a, b)| [walk.constants(node, a, [0.0]), walk.constants(node, b, [1.0])]);
            let (from, to, low, high) = (from?[0], to?[0], low?[0], high?[0]);
            let factor = (high - low) / (to - from);
            let map = |part: &Part, _: &Part| part.times(factor)?.plus(&Part::constant(low - from * factor));
            whole(value.zip(&value, count, map))
        }
        "dotproduct" => {
            let (a, b) = (walk.numbers(node, "in1", &[0.0])?, walk.numbers(node, "in2", &[0.0])?);
            let sum = (0..a.count.max(b.count)).try_fold(Part::constant(0.0), |sum, k| sum.plus(&a.at(k).product(&b.at(k))?));
            whole(sum.and_then(|part| Parts::of(&[part])))
        }
        "extract" => {
            let (value, [index]) = (walk.numbers(node, "in", &[0.0])?, walk.constants(node, "index", [0.0])?);
            whole(value.all().get(index.max(0.0) as usize).and_then(|part| Parts::of(&[*part])))
        }
        "separate2" | "separate3" | "separate4" => Ok(Term::Numbers(Box::new(walk.numbers(node, "in", &[0.0; 4])?))),
        "combine2" | "combine3" | "combine4" => {
            let mut parts = Vec::new();
            for name in ["in1", "in2", "in3", "in4"] {
                if walk.graph.input(node, name).is_some() {
                    parts.extend_from_slice(walk.numbers(node, name, &[0.0])?.all());
                }
            }
            parts.resize(count, Part::constant(0.0));
            whole(Parts::of(&parts))
        }
        "convert" => {
            let value = walk.numbers(node, "in", &[0.0])?;
            let missing = |place: usize| Part::constant(if place == 3 { 1.0 } else { 0.0 });
            let part = |place: usize| if value.count == 1 || place < value.count { value.at(place) } else { missing(place) };
            whole(Parts::of(&(0..count).map(part).collect::<Vec<_>>()))
        }
        "swizzle" => {
            let value = walk.numbers(node, "in", &[0.0])?;
            let part = |c: char| match c {
                'r' | 'x' => Some(value.at(0)),
                'g' | 'y' => Some(value.at(1)),
                'b' | 'z' => Some(value.at(2)),
                'a' | 'w' => Some(value.at(3)),
                '0' => Some(Part::constant(0.0)),
                '1' => Some(Part::constant(1.0)),
                _ => None,
            };
            let parts: Option<Vec<Part>> = walk.text(node, "channels").0.chars().take(5).map(part).collect();
            whole(parts.and_then(|parts| Parts::of(&parts)))
        }
        "ifgreater" | "ifgreatereq" | "ifequal" => {
            let ([a], [b]) = (walk.constants(node, "value1", [1.0])?, walk.constants(node, "value2", [0.0])?);
            let is_first = match tag {
                "ifgreater" => a > b,
                "ifgreatereq" => a >= b,
                _ => a == b,
            };
            walk.input(node, if is_first { "in1" } else { "in2" }).ok_or(Term::Unknown(node, "has no value"))
        }
        "switch" => {
            let [which] = walk.constants(node, "which", [0.0])?;
            let name = format!("in{}", which.clamp(0.0, 9.0) as usize + 1);
            walk.input(node, &name).ok_or(Term::Unknown(node, "has no value"))
        }
        "geompropvalue" | "geomcolor" | "UsdPrimvarReader" if kind != "vector2" => {
            let name = if tag == "UsdPrimvarReader" { "fallback" } else { "default" };
            walk.note(format!("{}: meshes bring no such values; its default is taken", walk.graph.path(node)));
            walk.input(node, name).ok_or(Term::Unknown(node, "reads values of the mesh"))
        }
        "texcoord" | "geompropvalue" | "UsdPrimvarReader" => {
            let [index] = walk.constants(node, "index", [0.0])?;
            if index != 0.0 {
                walk.note(format!("{}: only the first set of coordinates is known; it is taken", walk.graph.path(node)));
            }
            whole(Parts::of(&[Part::channel(COORDINATES, 0), Part::channel(COORDINATES, 1)]))
        }
        "place2d" => image::place2d(walk, node),
        "rotate2d" => {
            let (value, [amount]) = (walk.numbers(node, "in", &[0.0; 2])?, walk.constants(node, "amount", [0.0])?);
            whole(image::rotated(&value, amount))
        }
        "UsdTransform2d" => image::transform2d(walk, node),
        "image" | "tiledimage" | "gltf_image" | "gltf_colorimage" | "UsdUVTexture" => image::read(walk, node, count),
        "normalmap" => normal_map(walk, node),
        "gltf_normalmap" => {
            let image = image::read(walk, node, 3)?;
            normal_of(walk, node, Some(image), 1.0)
        }
        "normal" => Ok(Term::Direction(Direction::Normal)),
        "tangent" => Ok(Term::Direction(Direction::Tangent)),
        "bitangent" | "position" | "viewdirection" => Ok(Term::Direction(Direction::Other)),
        "rotate3d" => rotated_tangent(walk, node),
        _ => Err(Term::Unknown(node, "is no node that a material can hold")),
    }
}

fn at_most(parts: &Parts, limit: f64) -> bool {
    parts.as_constants().is_some_and(|all| all.iter().all(|x| *x <= limit))
}

fn at_least(parts: &Parts, limit: f64) -> bool {
    parts.as_constants().is_some_and(|all| all.iter().all(|x| *x >= limit))
}

fn one(walk: &mut Walk, node: Id, tag: &str, count: usize) -> Folded {
    let value = match walk.input(node, "in") {
        Some(Term::Numbers(parts)) => *parts,
        // Directions have length 1 already.
        Some(term) if matches!(tag, "dot" | "normalize") => return Ok(term),
        Some(Term::Unknown(at, why)) => return Err(Term::Unknown(at, why)),
        Some(_) => return Err(Term::Unknown(node, "has a direction where it needs numbers")),
        None => Parts::constants(&[0.0; 3]).ok_or(Term::Unknown(node, "has no value"))?,
    };
    let each = |f: fn(f64) -> f64| value.zip(&value, count, constant_only(|a, _| f(a)));
    let length = || {
        let all = value.as_constants()?;
        Some(all.iter().map(|x| x * x).sum::<f64>().sqrt())
    };
    let parts = match tag {
        "dot" => Some(value),
        "saturate" => {
            let amount = walk.constants(node, "amount", [1.0])?;
            if amount == [1.0] { Some(value) } else { None }
        }
        "absval" => each(f64::abs),
        "sign" => each(|x| if x == 0.0 { 0.0 } else { x.signum() }),
        "floor" => each(f64::floor),
        "ceil" => each(f64::ceil),
        "round" => each(f64::round),
        "fract" => each(|x| x - x.floor()),
        "sqrt" => each(f64::sqrt),
        "exp" => each(f64::exp),
        "ln" => each(f64::ln),
        "sin" => each(f64::sin),
        "cos" => each(f64::cos),
        "tan" => each(f64::tan),
        "magnitude" => length().and_then(|length| Parts::constants(&[length])),
        "normalize" => length()
            .filter(|length| *length > 0.0)
            .and_then(|length| value.zip(&value, count, |part, _| part.times(1.0 / length))),
        _ => {
            let weights = walk.constants(node, "lumacoeffs", [0.2722287, 0.6740818, 0.0536895])?;
            let sum = (0..3).try_fold(Part::constant(0.0), |sum, k| sum.plus(&value.at(k).times(weights[k])?));
            sum.and_then(|part| Parts::of(&vec![part; count.clamp(1, 3)]))
        }
    };
    parts.map(|parts| Term::Numbers(Box::new(parts))).ok_or(Term::Unknown(node, NOT_LINEAR))
}

fn two(walk: &mut Walk, node: Id, tag: &str, count: usize) -> Folded {
    let neutral = if matches!(tag, "add" | "subtract" | "min" | "max") { 0.0 } else { 1.0 };
    let (a, b) = (walk.numbers(node, "in1", &[0.0])?, walk.numbers(node, "in2", &[neutral])?);
    let parts = match tag {
        "add" => a.zip(&b, count, Part::plus),
        "subtract" => a.zip(&b, count, Part::minus),
        "multiply" => a.zip(&b, count, Part::product),
        "divide" => a.zip(&b, count, |a, b| a.times(1.0 / b.as_constant().filter(|b| *b != 0.0)?)),
        "power" | "safepower" if b.as_constants().is_some_and(|all| all.iter().all(|x| *x == 1.0)) => Some(a),
        "power" => a.zip(&b, count, constant_only(f64::powf)),
        "safepower" => a.zip(&b, count, constant_only(|a, b| a.signum() * a.abs().powf(b))),
        "modulo" => a.zip(&b, count, constant_only(|a, b| a - b * (a / b).floor())),
        "min" => a.zip(&b, count, constant_only(f64::min)),
        _ => a.zip(&b, count, constant_only(f64::max)),
    };
    parts.map(|parts| Term::Numbers(Box::new(parts))).ok_or(Term::Unknown(node, NOT_LINEAR))
}

fn normal_map(walk: &mut Walk, node: Id) -> Folded {
    if walk.text(node, "space").0 == "object" {
        return Err(Term::Unknown(node, "is in the space of the object"));
    }
    let [x, y] = walk.constants(node, "scale", [1.0, 1.0])?;
    if x != y {
        walk.note(format!("{}: the strengths of x and y differ; that of x is taken", walk.graph.path(node)));
    }
    let image = walk.input(node, "in");
    normal_of(walk, node, image, x)
}

/// The normal that an image stores as 0.5·n + 0.5.
fn normal_of(walk: &mut Walk, node: Id, stored: Option<Term>, scale: f64) -> Folded {
    match stored {
        None => Ok(Term::Normal(Normal { scale, ..Normal::FLAT })),
        Some(Term::Numbers(parts)) => unpacked(&parts, 0.5, 0.5, scale).map(Term::Normal).ok_or_else(|| {
            walk.note(format!("{}: the image of the normal is changed on the way", walk.graph.path(node)));
            Term::Unknown(node, NOT_LINEAR)
        }),
        Some(Term::Unknown(at, why)) => Err(Term::Unknown(at, why)),
        Some(_) => Err(Term::Unknown(node, "is no normal map")),
    }
}

/// The normal n whose numbers are `factor·n + offset`, with `scale` on its slope: an image in one of the two orientations, or a constant.
pub fn unpacked(parts: &Parts, factor: f64, offset: f64, scale: f64) -> Option<Normal> {
    if let Some(all) = parts.as_constants() {
        let n: Vec<f64> = all.iter().map(|x| (x - offset) / factor).collect();
        let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
        let flat = Normal { scale, ..Normal::FLAT };
        let is_usable = n.len() == 3 && length > 1e-6 && length.is_finite();
        // The usual stored value of flat is half of 255, rounded.
        let is_flat = is_usable && n[0].abs() < 0.005 && n[1].abs() < 0.005 && n[2] > 0.0;
        return match (is_usable, is_flat) {
            (true, true) => Some(flat),
            (true, false) => Some(Normal { constant: [n[0] / length, n[1] / length, n[2] / length], ..flat }),
            _ => None,
        };
    }
    let [x, y, z] = [parts.at(0), parts.at(1), parts.at(2)];
    let source = x.source?;
    // Numbers of a stored image t are n = 2t - 1, so x = factor·(2t - 1) + offset.
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-3;
    let follows = |part: &Part, channel: usize, sign: f64, strength: f64| {
        let weight = 2.0 * factor * sign * strength;
        let others = (0..4).filter(|k| *k != channel).all(|k| part.weights[k] == 0.0);
        part.source == Some(source) && others && near(part.weights[channel], weight) && near(part.bias, offset - 0.5 * weight)
    };
    let strength = x.weights[0] / (2.0 * factor);
    let is_flipped = y.weights[1] * factor < 0.0;
    let sign = if is_flipped { -1.0 } else { 1.0 };
    let fits = follows(&x, 0, 1.0, strength) && follows(&y, 1, sign, strength);
    let has_z = follows(&z, 2, 1.0, 1.0) || follows(&z, 2, 1.0, strength);
    // All three by the same factor is the same direction.
    let strength = if follows(&z, 2, 1.0, strength) { 1.0 } else { strength };
    (fits && has_z).then_some(Normal { source: Some(source), is_flipped, constant: [0.0, 0.0, 1.0], scale: scale * strength })
}

/// The direction that a reader finds after this constant was written: of length 1, and the surface's own where it has none.
pub fn readable_normal(constant: [f64; 3]) -> [f64; 3] {
    let stored = Parts::constants(&constant.map(|x| numbers::stored(0.5 * x + 0.5)));
    stored.and_then(|parts| unpacked(&parts, 0.5, 0.5, 1.0)).map_or(Normal::FLAT.constant, |normal| normal.constant)
}

/// A tangent turned about the normal. MaterialX turns clockwise, in degrees.
fn rotated_tangent(walk: &mut Walk, node: Id) -> Folded {
    let (turned, axis) = (walk.input(node, "in"), walk.input(node, "axis"));
    let amount = walk.numbers(node, "amount", &[0.0])?;
    let before = match turned {
        Some(Term::Direction(Direction::Tangent)) => Part::constant(0.0),
        Some(Term::Tangent(turns)) => turns,
        _ => return Err(Term::Unknown(node, "turns something else than the tangent")),
    };
    if !matches!(axis, Some(Term::Direction(Direction::Normal) | Term::Normal(_))) {
        return Err(Term::Unknown(node, "turns about something else than the normal"));
    }
    let turns = amount.at(0).times(-1.0 / 360.0).and_then(|turns| before.plus(&turns));
    turns.map(Term::Tangent).ok_or(Term::Unknown(node, NOT_LINEAR))
}
