// What every pass of the preview is given: camera, light, floor and the tables of albedos. Mirrors `FrameBlock` in `upload.rs`.

struct Frame {
    // Camera position; w: distance of the near plane.
    origin: vec4f,
    // Camera axes over the squares of their lengths: dot products with them give picture coordinates at distance 1.
    right_inverse: vec4f,
    up_inverse: vec4f,
    // Camera axes with half the picture's extent at distance 1 as lengths; w of the first: width of the edited object.
    right: vec4f,
    up: vec4f,
    forward: vec4f,
    // xy: shift of the picture in clip space for anti-aliasing; zw: pixels.
    jitter: vec4f,
    // Cosine and sine of the environment's rotation, its factor, and its number of mip levels.
    environment: vec4f,
    // x, z: centre of the floor map; y: height of the floor; w: half its width, or 0 without a floor.
    floor: vec4f,
    // Corners of the floor: least x and z, largest x and z.
    floor_extent: vec4f,
    // Mean radiance of the floor, and irradiance on it where nothing stands near, under an environment of factor 1.
    floor_mean: vec4f,
    floor_open: vec4f,
    // x: number of the first sample; y: samples per lobe; z: samples that the light is filtered for; w: 1 with baked light.
    samples: vec4f,
    // Sphere about the edited object.
    body: vec4f,
    // Mean colour of what the object stands on, floor apart.
    stand: vec4f,
    // Share of light that the edited objects send on where it falls on them; w: how much of it they stop at all.
    sent_on: vec4f,
    // Radiance that they shine with, under an environment of factor 1.
    shine: vec4f,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var environment_map: texture_2d<f32>;
@group(0) @binding(2) var environment_sampler: sampler;
@group(0) @binding(3) var irradiance_map: texture_2d<f32>;
@group(0) @binding(4) var floor_light: texture_2d<f32>;
@group(0) @binding(5) var floor_map: texture_2d<f32>;
@group(0) @binding(6) var floor_sampler: sampler;
@group(0) @binding(7) var<storage, read> albedo_tables: array<f32>;

// What white bodies in the place of the edited ones add to the floor's light and to its radiance.
@group(0) @binding(8) var floor_glow: texture_2d<f32>;
@group(0) @binding(9) var floor_glow_map: texture_2d<f32>;
// The same for bodies that shine with radiance 1.
@group(0) @binding(10) var floor_shine: texture_2d<f32>;
@group(0) @binding(11) var floor_shine_map: texture_2d<f32>;

// Numbers that a half float holds: radiance beyond is cut, which no display shows.
const RADIANCE_MAX: f32 = 60000.0;
