// The directional albedo of sheen from the table that the CPU uses. Twin of `tables.rs`.
//
// `albedo_tables` begins with it; the words of each material follow (`albedos.wgsl`). ROUGHNESSES and COSINES are printed from `tables.rs`.

// Index of the cell in x and place within it in y.
fn cell(u: f32, n: u32) -> vec2f {
    let s = saturate(u) * f32(n - 1);
    let i = min(floor(s), f32(n - 2));
    return vec2f(i, s - i);
}

fn table_pair(i: u32, t: f32) -> f32 {
    return mix(albedo_tables[i], albedo_tables[i + 1], t);
}

// Albedo of white sheen of roughness `sheen_roughness` seen at cosine `mu`.
fn sheen_albedo(sheen_roughness: f32, mu: f32) -> f32 {
    let r = cell(sheen_roughness, ROUGHNESSES);
    let t = cell(sqrt(max(mu, 0.0)), COSINES);
    let i = u32(r.x) * COSINES + u32(t.x);
    return mix(table_pair(i, t.y), table_pair(i + COSINES, t.y), r.y);
}
