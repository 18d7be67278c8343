// Dispersion: index of refraction by wavelength. Twin of `dispersion.rs`, where wavelengths are drawn and weighted; WAVELENGTH_FIRST,
// WAVELENGTH_LAST, LAMBDA_D (nanometres) and INVERSE_SQUARE (means over the channels' sensitivities, 1/nm^2) are printed from there.

// Index of refraction at an inverse squared wavelength (1/nm^2). `n_d` at the sodium line; `dispersion` in [0, 20], 20 over the Abbe
// number. At least 1 where `n_d` is; the reciprocal rule holds below 1. Cauchy's formula with two terms.
fn dispersed_ior(n_d: f32, dispersion: f32, inverse_square: f32) -> f32 {
    let is_thin = n_d < 1.0;
    let dense = select(n_d, 1.0 / n_d, is_thin);
    let moved = dense + (dense - 1.0) * dispersion * (1.0 / 20.0) * (523454.0 * inverse_square - 1.51605);
    let n = max(moved, 1.0);
    return select(n, 1.0 / n, is_thin);
}
