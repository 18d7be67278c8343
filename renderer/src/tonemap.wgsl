// Display transforms: linear scene radiance to display-referred sRGB. Twin of `tonemap.rs`.

// Gamma-encoded sRGB in [0, 1] of linear Rec.709 radiance; `transform` counts as in `DisplayTransform`.
fn display_apply(radiance: vec3f, exposure_ev: f32, transform: u32) -> vec3f {
    let gain = exp2(clamp(exposure_ev, -64.0, 64.0));
    let c = clamp(radiance * gain, vec3f(0.0), vec3f(1e9));
    switch transform {
        case 0u: {
            return srgb_encode(neutral(c));
        }
        case 1u: {
            return agx(c);
        }
        case 2u: {
            return srgb_encode(aces(c));
        }
        default: {
            return srgb_encode(standard(c));
        }
    }
}

// The sRGB curve. `x` in [0, 1].
fn srgb_encode(encoded: vec3f) -> vec3f {
    let x = saturate(encoded);
    let curved = 1.055 * pow(max(x, vec3f(1e-6)), vec3f(1.0 / 2.4)) - 0.055;
    return select(curved, 12.92 * x, x <= vec3f(0.0031308));
}

// Khronos PBR Neutral tone mapper, specification of 2024.
fn neutral(color: vec3f) -> vec3f {
    let start = 0.8 - 0.04;
    let desaturation = 0.15;
    let x = min(min(color.x, color.y), color.z);
    let offset = select(0.04, x - 6.25 * x * x, x < 0.08);
    let c = color - offset;
    let peak = max(max(c.x, c.y), c.z);
    if peak < start {
        return c;
    }
    let d = 1.0 - start;
    let new_peak = 1.0 - d * d / (peak + d - start);
    let g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
    let v = c * (new_peak / peak);
    return v + (new_peak - v) * g;
}

// AgX by Troy Sobotka, in the polynomial form of Benjamin Wrensch (2023). Returns gamma-encoded values.
fn agx(color: vec3f) -> vec3f {
    let min_ev = -12.47393;
    let max_ev = 4.026069;
    // WGSL writes matrices by columns: these are the rows of `tonemap.rs`, and the vector stands before the matrix.
    let inset = mat3x3f(
        0.84247906, 0.0784336, 0.079223745,
        0.042328242, 0.87846863, 0.07916613,
        0.042375654, 0.0784336, 0.87914297,
    );
    let outset = mat3x3f(
        1.196879, -0.09802088, -0.09902974,
        -0.05289685, 1.1519031, -0.0989612,
        -0.052971635, -0.09804345, 1.1510737,
    );
    let e = clamp(log2(max(color * inset, vec3f(1e-10))), vec3f(min_ev), vec3f(max_ev));
    let x = (e - min_ev) / (max_ev - min_ev);
    let x2 = x * x;
    let x4 = x2 * x2;
    let c = 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232;
    return saturate(c * outset);
}

// ACES RRT and ODT, fit by Stephen Hill.
fn aces(color: vec3f) -> vec3f {
    let input = mat3x3f(0.59719, 0.35458, 0.04823, 0.07600, 0.90834, 0.01566, 0.02840, 0.13383, 0.83777);
    let output = mat3x3f(1.60475, -0.53108, -0.07367, -0.10208, 1.10813, -0.00605, -0.00327, -0.07276, 1.07602);
    let v = color * input;
    let c = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.432951) + 0.238081);
    return saturate(c * output);
}

// Limits by value, not by channel, so that hues keep (specification, Emission).
fn standard(c: vec3f) -> vec3f {
    let peak = max(max(max(c.x, c.y), c.z), 1.0);
    return c / peak;
}
