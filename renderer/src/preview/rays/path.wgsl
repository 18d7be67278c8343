// Paths from the camera: one sample of a pixel's radiance, by the estimator of the path tracer (`path`) with one connection a vertex.

// Events on a path at most, surfaces that are passed straight through and collisions in bodies included.
const EVENTS_MAX: u32 = 1024u;
// Bounces before roulette may end a path.
const ROULETTE_START: u32 = 3u;
// Directions of the light that are considered where the camera sees a surface first.
const CANDIDATES: u32 = 4u;
// Directions that share the space about a rough lobe, and the widest spread: `path/cone.rs`.
const SHARERS: f32 = 16.0;
const SPREAD_MAX: f32 = 0.25;

// What lies at a hit.
struct Point {
    position: vec3f,
    // Geometric normal, outwards, and interpolated one on its side.
    ng: vec3f,
    n: vec3f,
    tangent: vec4f,
    uv: vec2f,
    span: Span,
}

fn point_at(hit: Hit) -> Point {
    let t = triangles[hit.triangle];
    let a = vertices[t.x];
    let b = vertices[t.y];
    let c = vertices[t.z];
    let w = vec3f(1.0 - hit.u - hit.v, hit.u, hit.v);
    var p: Point;
    p.span = Span(b[0].xyz - a[0].xyz, c[0].xyz - a[0].xyz, b[2].zw - a[2].zw, c[2].zw - a[2].zw);
    p.position = a[0].xyz * w.x + b[0].xyz * w.y + c[0].xyz * w.z;
    p.ng = unit_or_z(cross(p.span.e, p.span.f));
    let n = vec3f(a[0].w, a[1].xy) * w.x + vec3f(b[0].w, b[1].xy) * w.y + vec3f(c[0].w, c[1].xy) * w.z;
    let smooth_n = select(unit_or_z(n), p.ng, dot(n, n) < 1e-12);
    p.n = select(smooth_n, -smooth_n, dot(smooth_n, p.ng) < 0.0);
    p.tangent = vec4f(a[1].zw, a[2].xy) * w.x + vec4f(b[1].zw, b[2].xy) * w.y + vec4f(c[1].zw, c[2].xy) * w.z;
    p.uv = a[2].zw * w.x + b[2].zw * w.y + c[2].zw * w.z;
    return p;
}

// Values at a point of the object `object_at`; `width` is how wide the light is that the path stands for.
fn rows_at(p: Point, width: f32) -> MaterialRows {
    if !HAS_TEXTURES {
        return objects[object_at].rows;
    }
    return mapped_rows(objects[object_at].rows, map_place(p, width));
}

fn map_place(p: Point, width: f32) -> MapPlace {
    let area = length(cross(p.span.e, p.span.f));
    let uv_area = abs(p.span.uv_e.x * p.span.uv_f.y - p.span.uv_e.y * p.span.uv_f.x);
    // Texels of half the footprint: the pixel's own filter stays the wider one.
    let across = 0.5 * width * sqrt(uv_area / max(area, 1e-30));
    return MapPlace(p.uv, vec2f(across, 0.0), vec2f(0.0, across));
}

fn optics_at(rows: MaterialRows) -> Optics {
    let params = objects[object_at].params;
    var optics = interpret(inputs_from_rows(rows), params.x);
    optics.albedos = u32(params.y);
    return optics;
}

// Share of the light that reaches `p` from far away along `direction`. `sigma` is the extinction of what the ray starts in.
fn visibility(start: Ray, sigma: vec3f) -> vec3f {
    if !HAS_OPACITY {
        let hit = trace(start, FAR, true);
        // Nothing arrives through an absorbing body without end.
        return select(vec3f(0.0), select(vec3f(1.0), vec3f(0.0), sigma > vec3f(0.0)), hit.triangle == NONE);
    }
    var passage = vec3f(1.0);
    var inside = sigma;
    var ray = start;
    for (var i = 0u; i < 64u; i++) {
        let hit = trace(ray, FAR, false);
        if hit.triangle == NONE {
            return passage * select(vec3f(1.0), vec3f(0.0), inside > vec3f(0.0));
        }
        object_at = triangles[hit.triangle].w;
        let p = point_at(hit);
        let optics = optics_at(rows_at(p, 0.0));
        passage *= (1.0 - optics.opacity) * exp(-min(inside * hit.t, vec3f(80.0)));
        if max_channel(passage) <= 0.0 {
            break;
        }
        let is_entry = dot(p.ng, ray.direction) < 0.0;
        inside = select(vec3f(0.0), optics.sigma_a + optics.sigma_s, is_entry);
        ray = Ray(leave_surface(p.position, select(p.ng, -p.ng, is_entry)), ray.direction, hit.triangle);
    }
    return vec3f(0.0);
}

// Wavelength in nanometres and the weights of the channels for it, from a number in [0, 1).
fn wavelength(u: f32) -> vec4f {
    let at = min(u32(u * f32(SPECTRUM)), SPECTRUM - 1u);
    return SPECTRUM_OF[at];
}

// A direction of the whole sphere.
fn sphere_direction(u: vec2f) -> vec3f {
    let z = 1.0 - 2.0 * u.x;
    let r = sqrt(max(1.0 - z * z, 0.0));
    return vec3f(r * cos(2.0 * PI * u.y), r * sin(2.0 * PI * u.y), z);
}

// One sample of the radiance that a pixel receives.
fn path_radiance(pixel: vec2u, index: u32) -> vec3f {
    let place = pixel + rays.whole.xy;
    let seed = pixel_seed(rays.seed.x, place.y * rays.whole.z + place.x);
    let at = (vec2f(pixel) + draw_pair(seed, index, 0u, 0u)) / vec2f(rays.picture.xy) * 2.0 - 1.0;
    let first = normalize(rays.forward.xyz + at.x * rays.right.xyz - at.y * rays.up.xyz);
    var ray = Ray(rays.origin.xyz, first, NONE);
    var radiance = vec3f(0.0);
    var beta = vec3f(1.0);
    // Density of the last choice of direction; 0 where the way was the only one.
    var pdf = 0.0;
    var sigma_a = rays.absorption.xyz;
    var sigma_s = rays.scattering.xyz;
    var bounces = 0u;
    var vertex = 0u;
    var width = 0.0;
    var spread = rays.origin.w;
    var light_wave = vec4f(LAMBDA_D, 1.0, 1.0, 1.0);
    if HAS_DISPERSION {
        light_wave = wavelength(draw_pair(seed, index, 0u, PAIR_WALK).x);
    }
    var is_dispersed = false;
    // Directions of the light that the last surface considered.
    var lights = 1u;

    for (var event = 0u; event < EVENTS_MAX; event++) {
        // The channel that decides how far light flies in a scattering body: chosen by what the path carries.
        var t_max = FAR;
        let sigma = sigma_a + sigma_s;
        let is_foggy = HAS_SCATTERING && max_channel(sigma_s) > 0.0;
        var share = vec3f(0.0);
        if is_foggy {
            let u = draw_pair(seed, index, SEQUENCE_VERTICES + event, PAIR_WALK);
            share = beta / max(beta.x + beta.y + beta.z, 1e-30);
            let own = select(select(sigma.z, sigma.y, u.x < share.x + share.y), sigma.x, u.x < share.x);
            t_max = min(-log(max(1.0 - u.y, 1e-8)) / max(own, 1e-20), FAR);
        }
        let hit = trace(ray, t_max, false);
        if is_foggy {
            let passage = exp(-min(sigma * hit.t, vec3f(80.0)));
            if hit.triangle == NONE {
                let density = dot(share, sigma * passage);
                beta *= sigma_s * passage / max(density, 1e-30);
                let survival = min(max_channel(beta) * 4.0, 1.0);
                let u = draw_pair(seed, index, SEQUENCE_VERTICES + event, PAIR_PASSAGE);
                let roulette = draw_pair(seed, index, SEQUENCE_VERTICES + event, PAIR_CHOICE).x;
                if density <= 0.0 || roulette >= survival {
                    break;
                }
                beta /= survival;
                ray = Ray(ray.origin + ray.direction * hit.t, sphere_direction(u), NONE);
                pdf = 0.0;
                continue;
            }
            beta *= passage / max(dot(share, passage), 1e-30);
        } else if hit.triangle != NONE && max_channel(sigma_a) > 0.0 {
            beta *= exp(-min(sigma_a * hit.t, vec3f(80.0)));
        }
        if hit.triangle == NONE {
            let place = light_place(ray.direction);
            let weight = select(1.0, pdf / max(pdf + f32(lights) * light_pdf(place), 1e-30), pdf > 0.0);
            radiance += beta * light_radiance(place.xy) * weight * select(vec3f(1.0), vec3f(0.0), sigma > vec3f(0.0));
            break;
        }

        object_at = triangles[hit.triangle].w;
        let p = point_at(hit);
        width += spread * hit.t;
        let rows = rows_at(p, width);
        let inputs = inputs_from_rows(rows);
        let optics = optics_at(rows);
        let wo_world = -ray.direction;
        let is_front = dot(wo_world, p.ng) > 0.0;
        let beyond_a = select(vec3f(0.0), optics.sigma_a, is_front);
        let beyond_s = select(vec3f(0.0), optics.sigma_s, is_front);
        let passage_draw = draw_pair(seed, index, vertex, PAIR_PASSAGE);
        if HAS_OPACITY && passage_draw.x >= optics.opacity {
            // Straight on, as if there were no surface.
            ray = Ray(leave_surface(p.position, select(p.ng, -p.ng, is_front)), ray.direction, hit.triangle);
            sigma_a = beyond_a;
            sigma_s = beyond_s;
            vertex += 1u;
            continue;
        }
        if HAS_EMISSION && is_front {
            radiance += beta * optics.emission;
        }
        if bounces > rays.seed.y {
            break;
        }
        let detail = surface_detail(
            inputs,
            objects[object_at].params,
            rows.height,
            p.n,
            p.ng,
            p.tangent,
            map_place(p, width),
            p.span,
            wo_world,
            is_front,
        );
        let axes = detail.axes;
        var view = view_new(axes_local(axes, wo_world));
        view.throughput = beta;
        if HAS_DISPERSION {
            view.has_light = true;
            view.nm = light_wave.x;
            view.weights = light_wave.yzw;
            view.is_dispersed = is_dispersed;
        }
        if HAS_COAT && (HAS_COAT_NORMAL_MAP || HAS_NORMAL_MAP || HAS_HEIGHT) {
            view.has_coat_normal = true;
            view.coat_normal = axes_local(axes, detail.coat);
        }
        let b = bsdf_prepare(optics, view);

        // Several directions of the light where the camera sees the surface first, and one ray towards the one that is chosen in proportion
        // to what each would bring: resampled importance sampling (Talbot et al. 2005), `path/direct.rs`.
        lights = select(1u, CANDIDATES, bounces == 0u);
        var reservoir = 0.0;
        var chosen = vec3f(0.0);
        var chosen_weight = 0.0;
        var chosen_direction = vec3f(0.0, 0.0, 1.0);
        for (var j = 0u; j < lights; j++) {
            let light = light_sample(draw_pair(seed, index * lights + j, vertex, PAIR_LIGHT));
            let toward = axes_local(axes, light.direction);
            if light.pdf <= 0.0 || dot(light.direction, p.ng) * toward.z <= 0.0 {
                continue;
            }
            let value = bsdf_eval(b, toward);
            let brought = beta * value.value * light.radiance / max(f32(lights) * light.pdf + value.pdf, 1e-30);
            let weight = luminance(brought);
            reservoir += weight;
            let u = unit_number(mix_bits(mix_bits(seed ^ index) + vertex * 0x9e3779b9u + j * 0x85157af5u));
            if weight > 0.0 && u * reservoir < weight {
                chosen = brought;
                chosen_weight = weight;
                chosen_direction = light.direction;
            }
        }
        if chosen_weight > 0.0 {
            let outwards = dot(chosen_direction, p.ng) > 0.0;
            let start = Ray(leave_surface(p.position, select(-p.ng, p.ng, outwards)), chosen_direction, hit.triangle);
            let here = object_at;
            let free = visibility(start, select(sigma, beyond_a + beyond_s, outwards != is_front));
            radiance += chosen * (reservoir / chosen_weight) * free;
            object_at = here;
        }

        let choice = draw_pair(seed, index, vertex, PAIR_CHOICE);
        let drawn = bsdf_sample(b, vec4f(choice.x, draw_pair(seed, index, vertex, PAIR_DIRECTION), choice.y));
        let wi = normalize(axes_world(axes, drawn.wi));
        let leaves_outside = dot(wi, p.ng) > 0.0;
        if !drawn.is_valid || drawn.is_transmission == (leaves_outside == is_front) {
            break;
        }
        beta *= drawn.weight;
        bounces += 1u;
        vertex += 1u;
        if bounces >= ROULETTE_START {
            let survival = clamp(max_channel(beta), 0.05, 1.0);
            if passage_draw.y >= survival {
                break;
            }
            beta /= survival;
        }
        if drawn.is_transmission {
            sigma_a = beyond_a;
            sigma_s = beyond_s;
            is_dispersed = is_dispersed || (HAS_DISPERSION && optics.dispersion > 0.0);
        }
        pdf = select(drawn.pdf, 0.0, drawn.is_delta);
        if HAS_TEXTURES && pdf > 0.0 {
            spread = max(spread, min(sqrt(4.0 / (PI * SHARERS * pdf)), SPREAD_MAX));
        }
        ray = Ray(leave_surface(p.position, select(-p.ng, p.ng, leaves_outside)), wi, hit.triangle);
    }
    return radiance;
}

// 0 for what is not finite. Comparisons may be compiled away, bits may not.
fn finite_radiance(c: vec3f) -> vec3f {
    let bits = bitcast<vec3u>(c) & vec3u(0x7f800000u);
    return clamp(select(c, vec3f(0.0), bits == vec3u(0x7f800000u)), vec3f(0.0), vec3f(1e30));
}

@compute @workgroup_size(8, 8)
fn trace_paths(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_id) local: vec3u,
) {
    let number = group.y * groups.x + group.x;
    if number >= rays.seed.z {
        return;
    }
    // Tiles that follow each other lie far apart, so that a part of a picture is refined everywhere.
    let tile = (rays.tiles.x + number) % rays.tiles.z * rays.tiles.w % rays.tiles.z;
    let pixel = vec2u(tile % rays.tiles.y, tile / rays.tiles.y) * 8u + local.xy;
    if any(pixel >= rays.picture.xy) {
        return;
    }
    let at = pixel.y * rays.picture.x + pixel.x;
    var sum = sums[at];
    for (var i = 0u; i < rays.picture.w; i++) {
        sum += vec4f(finite_radiance(path_radiance(pixel, u32(sum.w))), 1.0);
    }
    sums[at] = sum;
}
