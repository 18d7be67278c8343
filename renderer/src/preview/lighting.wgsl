// Light on objects. Reflections are sampled from the lobes themselves, the same directions in every pixel, and each
// sample sees the light averaged over its share of directions: clean in one frame, exact in many.

// Numbers in [0, 1)^3 of sample `k` of the `count` of a picture. The first two make a spiral over a disc whose turns are as far apart as its points
// (Vogel 1979): round lobes stay round with few samples. Pictures are shifted against each other evenly (Roberts 2018).
fn sample_numbers(k: f32, count: f32) -> vec3f {
    let picture = frame.samples.x / frame.samples.y;
    let shift = fract(vec3f(0.5) + picture * vec3f(0.8191725134, 0.6710436067, 0.5497004779));
    return vec3f((k + shift.x) / count, fract(k * 0.6180339887 + shift.y), fract(k * 0.7548776662 + shift.z));
}

// A surface point in the world.
struct Surface {
    position: vec3f,
    // Axes of the shading frame; n is on the outside of the body.
    t: vec3f,
    b: vec3f,
    n: vec3f,
    // Share of directions above the surface that the body itself covers.
    self_share: f32,
    // Spherical harmonics of what covers the sky nearby, and what of it is another body: `VertexIn`.
    covered_a: vec4f,
    covered_b: vec4f,
    covered_c: vec4f,
    // Angle by which mirrored directions differ across the pixel.
    spread: f32,
    // Length of light's way through the body where an image gives it; negative where geometry does.
    thickness: f32,
}

fn to_world(s: Surface, v: vec3f) -> vec3f {
    return s.t * v.x + s.b * v.y + s.n * v.z;
}

fn to_local(s: Surface, v: vec3f) -> vec3f {
    return vec3f(dot(v, s.t), dot(v, s.b), dot(v, s.n));
}

// How far direction `d` is covered by something near, in [0, 1].
fn coverage(s: Surface, d: vec3f) -> f32 {
    let linear = vec4f(0.2820948, 0.4886025 * d.y, 0.4886025 * d.z, 0.4886025 * d.x);
    let square = vec4f(1.0925484 * d.x * d.y, 1.0925484 * d.y * d.z, 0.3153916 * (3.0 * d.z * d.z - 1.0), 1.0925484 * d.x * d.z);
    let last = 0.5462742 * (d.x * d.x - d.y * d.y);
    let c = dot(s.covered_a, linear) + dot(s.covered_b, square) + s.covered_c.x * last;
    // Nine coefficients cannot follow an edge: what rings around the true 0 and 1 is cut off.
    return saturate((c - 0.1) * 1.25);
}

// Radiance from `d` at the surface, nearby things included.
fn arriving(s: Surface, d: vec3f, angle: f32, near_radiance: vec3f) -> vec3f {
    let far = incoming(s.position, d, angle);
    if frame.samples.w < 0.5 {
        return far;
    }
    return mix(far, near_radiance, coverage(s, d));
}

// Factor on the number of samples: round cones fill a stretched lobe only if they are many.
fn samples_of_lobe(o: Optics) -> f32 {
    return select(1.0, 4.0, o.anisotropy > 0.0);
}

// Width in radians of the cone that one sample of density `pdf` stands for; a delta lobe's is that of the pixel.
fn sample_angle(o: Optics, s: Surface, pdf: f32, is_delta: bool) -> f32 {
    let own = select(1.0 / max(frame.samples.z * samples_of_lobe(o) * pdf, 1e-6), 0.0, is_delta || pdf <= 0.0);
    return sqrt(own + s.spread * s.spread);
}

// Colour that light keeps when the surface sends it on, all directions together.
fn reflected_color(o: Optics) -> vec3f {
    return o.base_color * (o.w_metal + o.w_diffuse) + vec3f(0.04 * (1.0 - o.w_metal));
}

// Reflected radiance of all lobes but those that the irradiance lights: diffuse and further metallic scattering.
fn reflections(prepared: Bsdf, s: Surface, near_radiance: vec3f) -> vec3f {
    var b = prepared;
    b.p_diffuse = 0.0;
    b.diffuse_scale = 0.0;
    b.metal_scale = vec3f(0.0);
    let total = b.p_coat + b.p_sheen + b.p_interface;
    if total <= 0.0 {
        return vec3f(0.0);
    }
    b.p_coat = b.p_coat / total;
    b.p_sheen = b.p_sheen / total;
    b.p_interface = b.p_interface / total;

    // Every lobe gets its own samples: choosing lobes at random would show as steps between neighbouring pixels.
    let each = u32(frame.samples.y * samples_of_lobe(b.optics));
    var coat_count = 0u;
    if HAS_COAT && b.p_coat > 0.0 {
        coat_count = select(each, 1u, b.optics.coat_is_smooth);
    }
    var sheen_count = 0u;
    if HAS_SHEEN && b.p_sheen > 0.0 {
        sheen_count = each;
    }
    var base_count = 0u;
    if b.p_interface > 0.0 {
        base_count = select(each, 1u, b.optics.is_smooth);
    }
    var radiance = vec3f(0.0);
    for (var i = 0u; i < coat_count + sheen_count + base_count; i++) {
        var choice = 0.5 * b.p_coat;
        var share = b.p_coat / f32(max(coat_count, 1u));
        var k = i;
        var count = coat_count;
        if i >= coat_count + sheen_count {
            choice = b.p_coat + b.p_sheen + 0.5 * b.p_interface;
            share = b.p_interface / f32(max(base_count, 1u));
            k = i - coat_count - sheen_count;
            count = base_count;
        } else if i >= coat_count {
            choice = b.p_coat + 0.5 * b.p_sheen;
            share = b.p_sheen / f32(max(sheen_count, 1u));
            k = i - coat_count;
            count = sheen_count;
        }
        let u = sample_numbers(f32(k), f32(count));
        let drawn = bsdf_sample(b, vec4f(choice, u.xy, 0.0));
        var reflect_share = 1.0;
        if HAS_TRANSMISSION && i >= coat_count + sheen_count {
            let h = unit_or_z(b.wo + bsdf_mirrored(b, drawn.wi));
            let facet = bsdf_interface(b, saturate(dot(b.wo, h)));
            reflect_share = bsdf_p_reflect(b, facet.reflected, facet.transmitted);
            // The same facet, refracted.
            let bent = bsdf_sample(b, vec4f(choice, u.xy, 0.9999999));
            if bent.is_transmission && bent.is_valid && reflect_share < 1.0 {
                let weight = bent.weight * (share * (1.0 - reflect_share));
                let angle = sample_angle(b.optics, s, bent.pdf, bent.is_delta);
                radiance += weight * through_body(b.optics, s, to_world(s, bent.wi), angle, u);
            }
        }
        if drawn.is_valid && !drawn.is_transmission {
            let angle = sample_angle(b.optics, s, drawn.pdf, drawn.is_delta);
            radiance += drawn.weight * (share * reflect_share) * arriving(s, to_world(s, drawn.wi), angle, near_radiance);
        }
    }
    return radiance;
}

// Radiance under irradiance `light` of the lobes that spread it: diffuse and further metallic scattering. Their coupling with the
// reflecting surface takes its mean over all light.
fn diffuse(b: Bsdf, light: vec3f) -> vec3f {
    let base = grid_base(b.optics.albedos);
    var spread = vec3f(0.0);
    if HAS_DIFFUSE {
        spread = b.optics.base_color * (b.diffuse_scale * grid_mean(base, DIELECTRIC_MISS, b.place));
    }
    if HAS_METAL && HAS_MULTIPLE_SCATTERING {
        spread = spread + b.metal_scale * grid_mean(base, METAL_MISS, b.place);
    }
    var layers = b.below_coat;
    if HAS_COAT {
        // Mean exponent of the coat's tint over cosine-weighted directions: model reference 8.3.
        layers = layers * exp(b.optics.coat_ln_tint * 0.546);
    }
    return spread * b.below_sheen * layers * light;
}

@fragment
fn fragment_object(in: VertexOut, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let place = MapPlace(in.uv, dpdx(in.uv), dpdy(in.uv));
    var rows = object.rows;
    if HAS_TEXTURES {
        rows = mapped_rows(rows, place);
    }
    let inputs = inputs_from_rows(rows);
    var optics = interpret(inputs, object.params.x);
    optics.albedos = u32(object.params.y);

    var s: Surface;
    s.position = in.position;
    // An open sheet is the same seen from behind.
    let outward = select(-1.0, 1.0, is_front);
    let toward = normalize(frame.origin.xyz - s.position);
    let smooth_n = unit_or_z(in.normal) * outward;
    let across = cross(dpdx(in.position), dpdy(in.position));
    let ng = select(across, -across, dot(across, smooth_n) < 0.0);
    let span = Span(dpdx(in.position), dpdy(in.position), place.dx, place.dy);
    let tangent = vec4f(in.tangent.xyz, in.tangent.w * outward);
    let detail = surface_detail(inputs, object.params, rows.height, smooth_n, ng, tangent, place, span, toward, true);
    s.n = detail.axes.n;
    s.t = detail.axes.t;
    s.b = detail.axes.b;
    let bend = dot(dpdx(smooth_n), dpdx(smooth_n)) + dot(dpdy(smooth_n), dpdy(smooth_n));
    s.spread = min(sqrt(0.3 * bend), 0.5);
    s.thickness = -1.0;
    if rows.volume_thickness.w >= 0.0 {
        s.thickness = max(inputs.volume_thickness * inputs.volume_thickness_scale, 0.0) * frame.right.w;
    }
    s.self_share = in.baked_light.w;
    s.covered_a = in.covered_a;
    s.covered_b = in.covered_b;
    s.covered_c = in.covered_c;

    // Light on the surface: open sky and floor, less what is covered; between the body's own walls it goes to and fro.
    var light = vec3f(0.0);
    if IS_FLOOR {
        light = floor_irradiance(s.position);
    } else {
        light = max(open_irradiance(s.n) + in.baked_light.xyz, vec3f(0.0));
    }
    let bounce = reflected_color(optics) * min(s.self_share, 0.9);
    light = light * frame.environment.z;
    // A body that shines lights its own hollows.
    var own_radiance = vec3f(0.0);
    if HAS_EMISSION {
        own_radiance = optics.emission;
        light += own_radiance * (PI * min(s.self_share, 0.9));
    }
    light = light / (1.0 - bounce);
    own_radiance += reflected_color(optics) * light * FRAC_1_PI;
    // What is near is another body or the object itself, lit like the point that looks at it.
    let covered = max(s.covered_a.x * 3.5449077, 1e-4);
    let other = min(s.covered_c.y / covered, 1.0);
    let other_radiance = frame.stand.rgb * (s.covered_c.z / covered * frame.environment.z);
    let near_radiance = other_radiance + own_radiance * (1.0 - other);

    var wo = to_local(s, toward);
    // Interpolated normals turn away a little before the surface does.
    wo = unit_or_z(vec3f(wo.xy, max(wo.z, 0.02)));
    var view = view_new(wo);
    if HAS_COAT && (HAS_COAT_NORMAL_MAP || HAS_NORMAL_MAP || HAS_HEIGHT) {
        view.has_coat_normal = true;
        view.coat_normal = to_local(s, detail.coat);
    }
    let prepared = bsdf_prepare(optics, view);
    var radiance = reflections(prepared, s, near_radiance);
    if HAS_DIFFUSE || (HAS_METAL && HAS_MULTIPLE_SCATTERING) {
        // What the map occludes is finer than what the mesh does.
        radiance += diffuse(prepared, light * saturate(inputs.ambient_occlusion));
    }
    if HAS_SCATTERING && max_channel(optics.sigma_s) > 0.0 {
        let behind = max(open_irradiance(-s.n), vec3f(0.0)) * frame.environment.z;
        let lit = body_light(optics, wo.z, light, behind);
        radiance += optics.w_transmission * optics.transmission_tint * prepared.below_coat * prepared.below_sheen * lit;
    }
    if HAS_EMISSION {
        radiance += optics.emission;
    }
    radiance = clamp(radiance, vec3f(0.0), vec3f(RADIANCE_MAX));
    return vec4f(radiance * optics.opacity, optics.opacity);
}
