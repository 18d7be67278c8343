// A material as rows of values and images, and reading them. `object_map` and the two bindings are given by who draws.
// Mirrors `ObjectBlock` in `upload.rs`.

struct ObjectMap {
    // Matrix from uv, by rows.
    matrix: vec4f,
    // xy: shift; z: 0 repeat, 1 clamp, 2 mirror; w: layer of the array.
    shift: vec4f,
}

struct Object {
    // Values; the place of the map, or -1, in w.
    rows: MaterialRows,
    maps: array<ObjectMap, 32>,
    // x: units of length per unit of length of the material; y: where the words of its albedos begin; z: 1 where a height map bends
    // normals, 2 where the mesh follows it already; w: units of length per unit of height.
    params: vec4f,
}

// A place on the surface and how it changes from pixel to pixel.
struct MapPlace {
    uv: vec2f,
    dx: vec2f,
    dy: vec2f,
}

fn map_linear(map: ObjectMap, v: vec2f) -> vec2f {
    return vec2f(dot(map.matrix.xy, v), dot(map.matrix.zw, v));
}

// Image coordinates as the sampler, which repeats, wants them.
fn map_wrapped(map: ObjectMap, given: vec2f) -> vec2f {
    var uv = given;
    if map.shift.z > 1.5 {
        uv = 1.0 - abs(1.0 - (uv - 2.0 * floor(uv * 0.5)));
    } else if map.shift.z > 0.5 {
        let half_texel = 0.5 / vec2f(textureDimensions(material_maps).xy);
        uv = clamp(uv, half_texel, 1.0 - half_texel);
    }
    return uv;
}

// The row, with its value replaced by the texture's if it has one.
fn mapped(row: vec4f, place: MapPlace) -> vec4f {
    if row.w < 0.0 {
        return row;
    }
    let map = object_map(u32(row.w));
    let uv = map_wrapped(map, map_linear(map, place.uv) + map.shift.xy);
    let layer = u32(map.shift.w);
    let texel = textureSampleGrad(material_maps, material_sampler, uv, layer, map_linear(map, place.dx), map_linear(map, place.dy));
    return vec4f(texel.rgb, row.w);
}

// Derivatives of a scalar map by u and by v: differences over one texel of the level, about the place. Twin of `texture.rs`, `gradient`.
fn map_gradient(map: ObjectMap, place: MapPlace) -> vec2f {
    let size = vec2f(textureDimensions(material_maps).xy);
    let dx = map_linear(map, place.dx) * size;
    let dy = map_linear(map, place.dy) * size;
    let level = max(floor(0.5 * log2(max(max(dot(dx, dx), dot(dy, dy)), 1e-20))), 0.0);
    let texel = exp2(level) / size;
    let at = map_linear(map, place.uv) + map.shift.xy;
    let layer = u32(map.shift.w);
    let x = vec2f(0.5 * texel.x, 0.0);
    let y = vec2f(0.0, 0.5 * texel.y);
    let right = textureSampleLevel(material_maps, material_sampler, map_wrapped(map, at + x), layer, level).x;
    let left = textureSampleLevel(material_maps, material_sampler, map_wrapped(map, at - x), layer, level).x;
    let lower = textureSampleLevel(material_maps, material_sampler, map_wrapped(map, at + y), layer, level).x;
    let upper = textureSampleLevel(material_maps, material_sampler, map_wrapped(map, at - y), layer, level).x;
    let by_image = vec2f(right - left, lower - upper) / texel;
    return vec2f(by_image.x * map.matrix.x + by_image.y * map.matrix.z, by_image.x * map.matrix.y + by_image.y * map.matrix.w);
}
