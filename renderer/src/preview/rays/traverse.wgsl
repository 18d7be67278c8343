// Nearest and any hits of rays with the triangles. Twin of `bvh` in what it finds, not in how.

struct Ray {
    origin: vec3f,
    direction: vec3f,
    // The triangle that the ray leaves, which it does not hit.
    excluded: u32,
}

struct Hit {
    // Distance; t_max for a miss.
    t: f32,
    // Position of the triangle in `triangles`, or NONE.
    triangle: u32,
    // Weights of the second and the third corner.
    u: f32,
    v: f32,
}

// Deepest tree that is uploaded.
const STACK: u32 = 64u;
const FAR: f32 = 3e38;

// Distance to a box, or FAR where the ray misses it before `t_max`.
fn box_distance(low: vec3f, high: vec3f, origin: vec3f, inverse: vec3f, t_max: f32) -> f32 {
    let a = (low - origin) * inverse;
    let b = (high - origin) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    let enter = max(max(near.x, near.y), max(near.z, 0.0));
    // Rounding must not push a box behind its own triangles.
    let leave = min(min(far.x, far.y), min(far.z, t_max)) * 1.0000004;
    return select(FAR, enter, enter <= leave);
}

// Nearest hit nearer than `t_max`; with `is_any` the first one that is found. Source of the triangle test: Moeller and Trumbore 1997.
fn trace(ray: Ray, t_max: f32, is_any: bool) -> Hit {
    var hit = Hit(t_max, NONE, 0.0, 0.0);
    // A direction along an axis has no inverse; one that is nearly along it does.
    let tiny = vec3f(1e-20);
    let d = select(ray.direction, select(-tiny, tiny, ray.direction >= vec3f(0.0)), abs(ray.direction) < tiny);
    let inverse = 1.0 / d;
    var stack: array<u32, STACK>;
    var height = 0u;
    var code = rays.light.z;
    var is_open = code != NONE;
    while is_open {
        var next = NONE;
        if code < LEAF {
            let node = nodes[code];
            let a = box_distance(bitcast<vec3f>(node[0].xyz), bitcast<vec3f>(node[1].xyz), ray.origin, inverse, hit.t);
            let b = box_distance(bitcast<vec3f>(node[2].xyz), bitcast<vec3f>(node[3].xyz), ray.origin, inverse, hit.t);
            let is_a = a < FAR;
            let is_b = b < FAR;
            let is_a_first = a <= b;
            if is_a && is_b {
                stack[height] = select(node[0].w, node[1].w, is_a_first);
                height += 1u;
            }
            if is_a || is_b {
                next = select(node[1].w, node[0].w, is_a && (is_a_first || !is_b));
            }
        } else {
            let first = (code & 0x7fffffffu) >> 3u;
            let end = first + (code & 7u) + 1u;
            for (var i = first; i < end; i++) {
                let corners = leaves[i];
                let p = bitcast<vec3f>(corners[0].xyz);
                let e = bitcast<vec3f>(corners[1].xyz) - p;
                let f = bitcast<vec3f>(corners[2].xyz) - p;
                let s = ray.origin - p;
                let across = cross(ray.direction, f);
                let inverse_volume = 1.0 / dot(e, across);
                let u = dot(s, across) * inverse_volume;
                let q = cross(s, e);
                let v = dot(ray.direction, q) * inverse_volume;
                let t = dot(f, q) * inverse_volume;
                // Comparisons with what is not a number do not hold, so flat triangles miss.
                if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < hit.t && corners[0].w != ray.excluded {
                    hit = Hit(t, corners[0].w, u, v);
                }
            }
            if is_any && hit.triangle != NONE {
                return hit;
            }
        }
        if next == NONE {
            is_open = height > 0u;
            height = max(height, 1u) - 1u;
            next = stack[height];
        }
        code = next;
    }
    return hit;
}

// A point moved off its surface along `n`. Twin of `geometry.rs`, `offset`.
fn leave_surface(p: vec3f, n: vec3f) -> vec3f {
    let steps = vec3i(256.0 * n);
    let moved = bitcast<vec3f>(bitcast<vec3i>(p) + select(steps, -steps, p < vec3f(0.0)));
    return select(moved, p + n * (1.0 / 65536.0), abs(p) < vec3f(1.0 / 32.0));
}
