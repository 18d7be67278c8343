// The environment as a light. Twin of `path/light.rs` and `path/distribution.rs`.

struct LightSample {
    direction: vec3f,
    radiance: vec3f,
    // Density over the sphere; 0 where nothing was drawn.
    pdf: f32,
}

const LIGHT_SIN_MIN: f32 = 1e-6;

// World direction into the map's own frame.
fn map_from_world(d: vec3f) -> vec3f {
    let c = rays.environment.x;
    let s = rays.environment.y;
    return vec3f(c * d.x - s * d.z, d.y, s * d.x + c * d.z);
}

// Place on the map, and the sine of the polar angle.
fn light_place(d: vec3f) -> vec3f {
    let m = map_from_world(d);
    let x = select(m.x, 1e-12, abs(m.x) + abs(m.z) < 1e-12);
    let turn = atan2(x, -m.z) / (2.0 * PI);
    let sin_theta = sqrt(m.x * m.x + m.z * m.z);
    // The angle from both components keeps its digits near the poles, where the arc cosine does not.
    return vec3f(turn - floor(turn), atan2(sin_theta, m.y) / PI, sin_theta);
}

fn light_radiance(place: vec2f) -> vec3f {
    return textureSampleLevel(environment_map, environment_sampler, place, 0.0).rgb * rays.environment.z;
}

// Density over the sphere of a place, as `light_sample` draws it.
fn light_pdf(place: vec3f) -> f32 {
    let rows = rays.light.x;
    let columns = rays.light.y;
    if rows == 0u {
        return 0.0;
    }
    let row = min(u32(max(place.y, 0.0) * f32(rows)), rows - 1u);
    let column = min(u32(max(place.x, 0.0) * f32(columns)), columns - 1u);
    let first = rows + 1u + rows * (columns + 1u);
    return light_table[first + row * columns + column] / (2.0 * PI * PI * max(place.z, LIGHT_SIN_MIN));
}

// The cell that holds `u` of a cumulative table at `base`, and the place within it.
fn light_search(base: u32, count: u32, u: f32) -> vec2f {
    var found = 0u;
    var step = 1u << (31u - countLeadingZeros(max(count, 2u) - 1u));
    while step > 0u {
        let candidate = found + step;
        if candidate < count && light_table[base + candidate] <= u {
            found = candidate;
        }
        step >>= 1u;
    }
    let low = light_table[base + found];
    let high = light_table[base + found + 1u];
    let width = select(1.0, high - low, high > low);
    return vec2f(f32(found), clamp((u - low) / width, 0.0, 0.99999994));
}

// A direction drawn where the light is brighter than its mean: to be used beside directions of the BSDF.
fn light_sample(u: vec2f) -> LightSample {
    let rows = rays.light.x;
    let columns = rays.light.y;
    if rows == 0u {
        return LightSample(vec3f(0.0, 1.0, 0.0), vec3f(0.0), 0.0);
    }
    let row = light_search(0u, rows, u.y);
    let column = light_search(rows + 1u + u32(row.x) * (columns + 1u), columns, u.x);
    let place = vec2f((column.x + column.y) / f32(columns), (row.x + row.y) / f32(rows));
    let phi = 2.0 * PI * place.x;
    let theta = PI * place.y;
    let m = vec3f(sin(theta) * sin(phi), cos(theta), -sin(theta) * cos(phi));
    let c = rays.environment.x;
    let s = rays.environment.y;
    let d = vec3f(c * m.x + s * m.z, m.y, c * m.z - s * m.x);
    return LightSample(d, light_radiance(place), light_pdf(vec3f(place, sin(theta))));
}
