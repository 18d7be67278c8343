// Fine detail of surfaces: normal maps, bumps of height maps, the coat's normal. Twin of `path/detail.rs` and `path/frame.rs`.

// A piece of the surface: two edges, in the world and in uv.
struct Span {
    e: vec3f,
    f: vec3f,
    uv_e: vec2f,
    uv_f: vec2f,
}

// Axes of a shading frame.
struct Axes {
    t: vec3f,
    b: vec3f,
    n: vec3f,
}

struct Detail {
    // Frame of the base.
    axes: Axes,
    // Normal of the coat.
    coat: vec3f,
}

fn axes_world(a: Axes, v: vec3f) -> vec3f {
    return a.t * v.x + a.b * v.y + a.n * v.z;
}

fn axes_local(a: Axes, v: vec3f) -> vec3f {
    return vec3f(dot(v, a.t), dot(v, a.b), dot(v, a.n));
}

// Axes along the mesh's tangent (w: sign of the bitangent); any tangent where it is parallel to the normal.
fn axes_along(n: vec3f, tangent: vec4f) -> Axes {
    let along = tangent.xyz - n * dot(n, tangent.xyz);
    let sign = select(1.0, -1.0, n.z < 0.0);
    let a = -(1.0 / (sign + n.z));
    let any = vec3f(1.0 + sign * n.x * n.x * a, sign * n.x * n.y * a, -(sign * n.x));
    let t = unit_or_z(select(along, any, dot(along, along) < 1e-12));
    return Axes(t, cross(n, t) * select(1.0, -1.0, tangent.w < 0.0), n);
}

// Direction of a normal map in tangent space, stronger or weaker by `scale`: model reference 13.
fn scaled_normal(map: vec3f, scale: f32) -> vec3f {
    let n = unit_or_z(map);
    if scale > 1.0 {
        return unit_or_z(vec3f(n.xy * scale, n.z));
    }
    let across = length(n.xy);
    let angle = atan2(across, n.z) * max(scale, 0.0);
    return vec3f(n.xy * (sin(angle) / max(across, 1e-6)), cos(angle));
}

// Normal of a height map in the smooth frame, from its derivatives by u and v; straight up where the piece has no area.
fn bump_normal(a: Axes, span: Span, by_uv: vec2f) -> vec3f {
    let e = vec2f(dot(span.e, a.t), dot(span.e, a.b));
    let f = vec2f(dot(span.f, a.t), dot(span.f, a.b));
    let area = e.x * f.y - e.y * f.x;
    let is_flat = abs(area) <= length(e) * length(f) * 1e-6 || abs(area) < 1e-30;
    let inverse = 1.0 / select(area, 1.0, is_flat);
    let de = dot(by_uv, span.uv_e);
    let df = dot(by_uv, span.uv_f);
    let slopes = clamp(vec2f(de * f.y - df * e.y, df * e.x - de * f.x) * inverse, vec2f(-1e8), vec2f(1e8));
    return normalize(vec3f(select(-slopes, vec2f(0.0), is_flat), 1.0));
}

// A normal map on top of bumps: their slopes add up.
fn combined_normal(map: vec3f, bump: vec3f) -> vec3f {
    return unit_or_z(vec3f(map.xy * bump.z + bump.xy * map.z, map.z * bump.z));
}

// The normal bent where the viewer, on the side `is_front` of the geometric normal, would see its back.
fn facing_normal(n: vec3f, wo: vec3f, is_front: bool) -> vec3f {
    let sign = select(-1.0, 1.0, is_front);
    let lack = 1e-3 - sign * dot(wo, n);
    return select(n, unit_or_z(n + wo * (sign * lack)), lack > 0.0);
}

// Frame and coat normal at a point. `smooth_n` is the interpolated normal on the side of the geometric one, `ng`; `params` those of the object,
// `height` its row of the height map.
fn surface_detail(
    inputs: Inputs,
    params: vec4f,
    height: vec4f,
    smooth_n: vec3f,
    ng: vec3f,
    tangent: vec4f,
    place: MapPlace,
    span: Span,
    wo: vec3f,
    is_front: bool,
) -> Detail {
    let flat = axes_along(smooth_n, tangent);
    if !HAS_NORMAL_MAP && !HAS_COAT_NORMAL_MAP && !HAS_HEIGHT {
        let n = facing_normal(smooth_n, wo, is_front);
        return Detail(axes_along(n, tangent), n);
    }
    var bump = vec3f(0.0, 0.0, 1.0);
    var bumped = smooth_n;
    let is_displaced = params.z > 1.5;
    let has_bump = HAS_HEIGHT && params.z > 0.5 && height.w >= 0.0;
    if has_bump {
        bump = bump_normal(flat, span, map_gradient(object_map(u32(height.w)), place) * params.w);
        let world = axes_world(flat, bump);
        bumped = select(smooth_n, world, dot(world, ng) > 0.0);
    }
    var n = bumped;
    if HAS_NORMAL_MAP {
        let m = scaled_normal(inputs.normal, inputs.normal_scale);
        var mapped = axes_world(flat, m);
        if has_bump && inputs.combine_normal_and_height {
            mapped = select(
                axes_world(flat, combined_normal(m, bump)),
                axes_world(axes_along(bumped, tangent), m),
                is_displaced,
            );
        }
        n = select(smooth_n, mapped, dot(mapped, ng) > 0.0);
    }
    n = facing_normal(n, wo, is_front);
    var coat = n;
    if HAS_COAT {
        // The coat lies on the surface as it is: on the displaced one if it was displaced. The base's maps are not its own.
        var own = flat;
        if is_displaced {
            own = axes_along(bumped, tangent);
        }
        coat = own.n;
        if HAS_COAT_NORMAL_MAP {
            let mapped = axes_world(own, scaled_normal(inputs.coat_normal, inputs.coat_normal_scale));
            coat = select(smooth_n, mapped, dot(mapped, ng) > 0.0);
        }
        coat = facing_normal(coat, wo, is_front);
    }
    return Detail(axes_along(n, tangent), coat);
}
