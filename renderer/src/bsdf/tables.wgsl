// Directional albedos that have no closed form, from the tables that the CPU uses. Twin of `tables.rs`.
//
// `albedo_tables` holds `albedo`, `albedo_mean` and `sheen` one after the other; CONTRASTS, ROUGHNESSES, COSINES and the
// beginnings ALBEDO_MEAN_BEGIN and SHEEN_BEGIN are printed from `tables.rs`.

// Index of the cell in x and place within it in y.
fn cell(u: f32, n: u32) -> vec2f {
    let s = saturate(u) * f32(n - 1);
    let i = min(floor(s), f32(n - 2));
    return vec2f(i, s - i);
}

// Offset of the half of the tables for this ratio in x, the contrast axis in y.
fn contrast(eta: f32) -> vec2f {
    let x = abs(eta - 1.0) / (eta + 1.0);
    return vec2f(select(0.0, f32(CONTRASTS), eta < 1.0), x);
}

fn table_pair(begin: u32, index: f32, t: f32) -> f32 {
    let i = begin + u32(index);
    return mix(albedo_tables[i], albedo_tables[i + 1], t);
}

// Reflected share of uniform light for a dielectric interface of ratio `eta` seen at cosine `mu`; both in range.
fn dielectric_albedo(eta: f32, roughness: f32, mu: f32) -> f32 {
    let c = contrast(eta);
    let x = cell(c.y, CONTRASTS);
    let r = cell(roughness, ROUGHNESSES);
    let t = cell(sqrt(max(mu, 0.0)), COSINES);
    let nt = f32(COSINES);
    let nr = f32(ROUGHNESSES);
    let i = ((c.x + x.x) * nr + r.x) * nt + t.x;
    let low = mix(table_pair(0, i, t.y), table_pair(0, i + nt, t.y), r.y);
    let j = i + nr * nt;
    let high = mix(table_pair(0, j, t.y), table_pair(0, j + nt, t.y), r.y);
    return mix(low, high, x.y);
}

// Cosine-weighted mean of `dielectric_albedo`.
fn dielectric_albedo_mean(eta: f32, roughness: f32) -> f32 {
    let c = contrast(eta);
    let x = cell(c.y, CONTRASTS);
    let r = cell(roughness, ROUGHNESSES);
    let nr = f32(ROUGHNESSES);
    let i = (c.x + x.x) * nr + r.x;
    return mix(table_pair(ALBEDO_MEAN_BEGIN, i, r.y), table_pair(ALBEDO_MEAN_BEGIN, i + nr, r.y), x.y);
}

// Albedo of white sheen of roughness `sheen_roughness` seen at cosine `mu`.
fn sheen_albedo(sheen_roughness: f32, mu: f32) -> f32 {
    let r = cell(sheen_roughness, ROUGHNESSES);
    let t = cell(sqrt(max(mu, 0.0)), COSINES);
    let nt = f32(COSINES);
    let i = r.x * nt + t.x;
    return mix(table_pair(SHEEN_BEGIN, i, t.y), table_pair(SHEEN_BEGIN, i + nt, t.y), r.y);
}
