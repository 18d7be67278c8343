// Meshes in the path tracer's own projection: a point lands where the camera ray through it passes.

struct VertexIn {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
    // Light that occlusion takes or neighbours add, xyz, per unit of the environment's factor; w: share of the body itself.
    @location(4) baked_light: vec4f,
    // What stands around the point: 9 spherical harmonics of its coverage; the solid angle of it that is another body, and the luminance of that
    // if it were white, summed over it.
    @location(5) covered_a: vec4f,
    @location(6) covered_b: vec4f,
    @location(7) covered_c: vec4f,
}

struct VertexOut {
    @builtin(position) clip: vec4f,
    // Values at a covered place of the pixel: outside of its triangle a normal may look away.
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
    @location(4) baked_light: vec4f,
    @location(5) covered_a: vec4f,
    @location(6) covered_b: vec4f,
    @location(7) covered_c: vec4f,
}

@vertex
fn vertex_object(in: VertexIn) -> VertexOut {
    let q = in.position - frame.origin.xyz;
    let depth = dot(q, frame.forward.xyz);
    var out: VertexOut;
    // Depth is near / distance: 1 at the near plane, 0 far away, and floats spread well over it.
    let x = dot(q, frame.right_inverse.xyz) + frame.jitter.x * depth;
    let y = dot(q, frame.up_inverse.xyz) + frame.jitter.y * depth;
    out.clip = vec4f(x, y, frame.origin.w, depth);
    out.position = in.position;
    out.normal = in.normal;
    out.tangent = in.tangent;
    out.uv = in.uv;
    out.baked_light = in.baked_light;
    out.covered_a = in.covered_a;
    out.covered_b = in.covered_b;
    out.covered_c = in.covered_c;
    return out;
}

struct ScreenOut {
    @builtin(position) clip: vec4f,
    // Picture coordinates, -1 to 1, y up.
    @location(0) at: vec2f,
}

// One triangle over the whole picture, infinitely far away.
@vertex
fn vertex_screen(@builtin(vertex_index) index: u32) -> ScreenOut {
    let at = vec2f(f32((index << 1u) & 2u), f32(index & 2u)) * 2.0 - 1.0;
    var out: ScreenOut;
    out.clip = vec4f(at, 0.0, 1.0);
    out.at = at;
    return out;
}
