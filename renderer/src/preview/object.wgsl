// One object's material, as the pass that draws it is given it.

// Whether this draws the floor, whose light comes from its own map.
override IS_FLOOR: bool = false;

@group(1) @binding(0) var<uniform> object: Object;
@group(1) @binding(1) var material_maps: texture_2d_array<f32>;
@group(1) @binding(2) var material_sampler: sampler;

fn object_map(map: u32) -> ObjectMap {
    return object.maps[map];
}
