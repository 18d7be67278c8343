// One object's material: property rows, texture maps, and what the picture needs to know of the object itself.
// Mirrors `ObjectBlock` in `upload.rs`.

// Whether this draws the floor, whose light comes from its own map.
override IS_FLOOR: bool = false;

struct Object {
    rows: MaterialRows,
    // Per map: the matrix from uv, by rows.
    map_matrix: array<vec4f, 32>,
    // Per map: xy shift, z: 0 repeat, 1 clamp, 2 mirror.
    map_shift: array<vec4f, 32>,
    // x: scene units per unit of length of the material; y: where the words of its albedos begin.
    params: vec4f,
}

@group(1) @binding(0) var<uniform> object: Object;
@group(1) @binding(1) var material_maps: texture_2d_array<f32>;
@group(1) @binding(2) var material_sampler: sampler;

// A place on the surface and how it changes from pixel to pixel.
struct MapPlace {
    uv: vec2f,
    dx: vec2f,
    dy: vec2f,
}

fn map_linear(map: u32, v: vec2f) -> vec2f {
    let m = object.map_matrix[map];
    return vec2f(dot(m.xy, v), dot(m.zw, v));
}

// The row, with its value replaced by the texture's if it has one.
fn mapped(row: vec4f, place: MapPlace) -> vec4f {
    if row.w < 0.0 {
        return row;
    }
    let map = u32(row.w);
    let shift = object.map_shift[map];
    var uv = map_linear(map, place.uv) + shift.xy;
    if shift.z > 1.5 {
        uv = 1.0 - abs(1.0 - (uv - 2.0 * floor(uv * 0.5)));
    } else if shift.z > 0.5 {
        let half_texel = 0.5 / vec2f(textureDimensions(material_maps).xy);
        uv = clamp(uv, half_texel, 1.0 - half_texel);
    }
    let texel = textureSampleGrad(material_maps, material_sampler, uv, map, map_linear(map, place.dx), map_linear(map, place.dy));
    return vec4f(texel.rgb, row.w);
}
