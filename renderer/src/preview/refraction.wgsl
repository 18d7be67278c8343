// Light through a refracting body. The inside is taken for a sphere about the body through the point of entry, whose
// walls reflect and refract exactly; leaving light sees environment and floor.

// Events inside the body: what is still inside then leaves as mean light.
const INNER_EVENTS: u32 = 4u;

// Radiance that reaches `s` from inside along `d` (world, into the body). `angle`: width of the cone that it stands for.
fn through_body(o: Optics, s: Surface, d_in: vec3f, angle: f32, u: vec3f) -> vec3f {
    var radiance = vec3f(0.0);
    var throughput = vec3f(1.0);
    var p = s.position;
    var d = d_in;
    let out_vector = p - frame.body.xyz;
    let radius = max(length(out_vector), 0.2 * frame.body.w);
    // A sphere that holds the point and bulges towards its normal: where the surface is flat or hollow the centre moves.
    let center = p - s.n * radius;
    let n_inside = 1.0 / o.eta;
    let alpha = select(sqrt(o.alpha_x * o.alpha_y), 0.0, o.is_smooth);
    for (var i = 0u; i < INNER_EVENTS; i++) {
        let across = max(-2.0 * dot(p - center, d), 0.0);
        let length_inside = select(s.thickness, across, s.thickness < 0.0);
        p = p + d * across;
        // What scatters out of the way comes back as light of the body: `body_light`.
        throughput *= exp(-min((o.sigma_a + o.sigma_s) * length_inside, vec3f(80.0)));
        var n = unit_or_z(p - center);
        let m = n;
        let cos_i = saturate(dot(d, m));
        let f = select(fresnel(cos_i, n_inside), 0.0, o.is_matched);
        if f < 1.0 {
            let bent = refract_at(-d, -m, cos_i, n_inside);
            let leaving = select(bent.wi, d, o.is_matched);
            // Two rough walls tilt light independently: 0.35 of what a mirror of that roughness would do.
            let blur = max(angle, 0.35 * alpha * 2.0);
            radiance += throughput * (1.0 - f) * o.transmission_tint * incoming(p, leaving, blur);
        }
        throughput *= f;
        if max_channel(throughput) < 0.004 {
            break;
        }
        d = d - m * (2.0 * dot(d, m));
    }
    return radiance + throughput * open_irradiance(d) * (FRAC_1_PI * frame.environment.z);
}

// Radiance that a scattering body sends to the viewer, who sees its surface under cosine `mu`, where irradiance `here` arrives and `behind`
// does on the far side. Light enters, spreads by the albedo of a thick body and leaves, partly after reflections at the surface from inside:
// Christensen and Burley 2015; mean reflectance by Egan and Hilgeman 1973.
fn body_light(o: Optics, mu: f32, here: vec3f, behind: vec3f) -> vec3f {
    let sigma_t = o.sigma_a + o.sigma_s;
    let share = o.sigma_s / max(sigma_t, vec3f(1e-20));
    let root = sqrt(max(1.0 - share, vec3f(0.0)));
    let albedo = (1.0 - root) * (1.0 - 0.139 * root) / (1.0 + 1.17 * root);
    let eta = max(o.eta, 1.0);
    let inner = clamp(-1.440 / (eta * eta) + 0.710 / eta + 0.668 + 0.0636 * eta, 0.0, 0.95);
    let entering = eta * eta * (1.0 - inner);
    let leaving = (1.0 - fresnel(mu, eta)) / (eta * eta);
    // How far light spreads against the size of the body: what is far beyond it shines through from behind.
    let reach = 1.0 / max(sqrt(3.0 * (1.0 - share)) * sigma_t * frame.body.w, vec3f(1e-6));
    let light = mix(here, 0.5 * (here + behind), saturate(reach * 2.0));
    let held = 1.0 - exp(-min(sigma_t * frame.body.w, vec3f(80.0)));
    return light * FRAC_1_PI * held * (entering * leaving) * albedo / (1.0 - albedo * inner);
}
