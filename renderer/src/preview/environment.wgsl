// Light that arrives: environment, floor, and what is near. Radiance is for an environment factor of 1 until
// `incoming` multiplies it.

// World direction into the environment's own frame.
fn map_from_world(d: vec3f) -> vec3f {
    let c = frame.environment.x;
    let s = frame.environment.y;
    return vec3f(c * d.x - s * d.z, d.y, s * d.x + c * d.z);
}

fn map_uv(d: vec3f) -> vec2f {
    // At the poles any longitude will do, but atan2 wants one.
    let x = select(d.x, 1e-12, abs(d.x) + abs(d.z) < 1e-12);
    let turn = atan2(x, -d.z) / (2.0 * PI);
    return vec2f(turn - floor(turn), acos(clamp(d.y, -1.0, 1.0)) / PI);
}

// Radiance of the environment in world direction `d`, averaged over a cone of about `angle` radians across.
fn environment_radiance(d: vec3f, angle: f32) -> vec3f {
    let rows = f32(textureDimensions(environment_map).y);
    // A level is averaged by a bell of two texels' deviation (`BELL`); that of a cone is 0.29 of its width.
    let level = clamp(log2(max(angle * (0.29 / 2.0) * rows / PI, 1e-6)), 0.0, frame.environment.w - 1.0);
    return textureSampleLevel(environment_map, environment_sampler, map_uv(map_from_world(d)), level).rgb;
}

// Irradiance on a surface of world normal `n` that sees nothing but environment and endless floor.
fn open_irradiance(n: vec3f) -> vec3f {
    return textureSampleLevel(irradiance_map, environment_sampler, map_uv(map_from_world(n)), 0.0).rgb;
}

// Place on the floor map, and how far it counts: 1 inside, 0 beyond its edge.
fn floor_place(p: vec3f) -> vec3f {
    let at = (p.xz - frame.floor.xz) / frame.floor.w;
    let edge = max(abs(at.x), abs(at.y));
    return vec3f(at * 0.5 + 0.5, 1.0 - smoothstep(0.8, 0.98, edge));
}

// Irradiance on the floor at world point `p`.
fn floor_irradiance(p: vec3f) -> vec3f {
    let place = floor_place(p);
    let baked = textureSampleLevel(floor_light, floor_sampler, place.xy, 0.0).rgb;
    let glow = textureSampleLevel(floor_glow, floor_sampler, place.xy, 0.0).rgb * frame.sent_on.rgb;
    let shine = textureSampleLevel(floor_shine, floor_sampler, place.xy, 0.0).rgb * frame.shine.rgb;
    return max(frame.floor_open.rgb + (baked + glow + shine) * (place.z * frame.sent_on.w), vec3f(0.0));
}

// Radiance of the floor at `p`, averaged over a disc `across` wide.
fn floor_radiance(p: vec3f, across: f32) -> vec3f {
    let place = floor_place(p);
    let texels = across / frame.floor.w * 0.5 * f32(textureDimensions(floor_map).x);
    let level = log2(max(texels, 1.0));
    let glow = textureSampleLevel(floor_glow_map, floor_sampler, place.xy, level).rgb * frame.sent_on.rgb;
    let shine = textureSampleLevel(floor_shine_map, floor_sampler, place.xy, level).rgb * frame.shine.rgb;
    let near = textureSampleLevel(floor_map, floor_sampler, place.xy, level).rgb + glow + shine;
    return mix(frame.floor_mean.rgb, near, place.z);
}

// Radiance that arrives at `p` from world direction `d`, averaged over a cone of about `angle` radians across.
fn incoming(p: vec3f, d: vec3f, angle: f32) -> vec3f {
    var light = environment_radiance(d, angle);
    if frame.floor.w > 0.0 && d.y < 0.0 {
        let t = max(p.y - frame.floor.y, 0.0) / max(-d.y, 1e-4);
        let q = p + d * t;
        // Seen at a slant the cone covers more; the geometric mean of both widths keeps the far floor from shimmering.
        let across = t * angle / sqrt(max(-d.y, 0.02));
        let below = floor_radiance(q, across);
        let to_edge = min(q.xz - frame.floor_extent.xy, frame.floor_extent.zw - q.xz);
        let inside = saturate(0.5 + min(to_edge.x, to_edge.y) / max(across, 1e-4));
        light = mix(light, below, smoothstep(0.0, max(0.5 * angle, 1e-4), -d.y) * inside);
    }
    return light * frame.environment.z;
}

@fragment
fn fragment_background(in: ScreenOut) -> @location(0) vec4f {
    let at = in.at - frame.jitter.xy;
    let d = normalize(frame.forward.xyz + at.x * frame.right.xyz + at.y * frame.up.xyz);
    let light = environment_radiance(d, 0.0) * frame.environment.z;
    return vec4f(min(light, vec3f(RADIANCE_MAX)), 0.0);
}
