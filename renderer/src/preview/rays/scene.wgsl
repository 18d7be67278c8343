// What rays meet: the tree, its triangles, the materials, the light. Mirrors the structs in `rays/upload.rs`. Lengths are normalised units
// (`path/geometry.rs`), in which the edited object has a size of about 1.

struct Rays {
    // Camera: position and axes; w of the first: how fast a pixel widens with the distance.
    origin: vec4f,
    right: vec4f,
    up: vec4f,
    forward: vec4f,
    // Cosine and sine of the environment's rotation, its factor, its levels.
    environment: vec4f,
    // What the camera is in: coefficients, 1/unit.
    absorption: vec4f,
    scattering: vec4f,
    // Rows and columns of the light's table, 0 without one; code of the tree's root; whether any surface lets rays pass.
    light: vec4u,
    // Width and height of what is drawn; number of the first sample; samples.
    picture: vec4u,
    // First tile, tiles a row, tiles in all, step between them.
    tiles: vec4u,
    // Seed; bounces at most.
    seed: vec4u,
    // Where what is drawn begins in its picture, and the columns of that.
    whole: vec4u,
}

@group(0) @binding(0) var<uniform> rays: Rays;
@group(0) @binding(1) var<storage, read> nodes: array<array<vec4u, 4>>;
@group(0) @binding(2) var<storage, read> leaves: array<array<vec4u, 3>>;
@group(0) @binding(3) var<storage, read> vertices: array<array<vec4f, 3>>;
@group(0) @binding(4) var<storage, read> triangles: array<vec4u>;
@group(0) @binding(5) var<storage, read> light_table: array<f32>;
@group(0) @binding(6) var<storage, read> objects: array<Object>;
@group(0) @binding(7) var<storage, read> albedo_tables: array<f32>;
@group(0) @binding(8) var environment_map: texture_2d<f32>;
@group(0) @binding(9) var environment_sampler: sampler;
@group(0) @binding(10) var material_maps: texture_2d_array<f32>;
@group(0) @binding(11) var material_sampler: sampler;
// Sums of all samples of a pixel, and their number.
@group(0) @binding(12) var<storage, read_write> sums: array<vec4f>;

const NONE: u32 = 0xffffffffu;
const LEAF: u32 = 0x80000000u;

// The object that `object_map` reads.
var<private> object_at: u32;

fn object_map(map: u32) -> ObjectMap {
    return objects[object_at].maps[map];
}
