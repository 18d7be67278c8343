//! The BSDF over angles, in single and in double precision from the same single-precision inputs.

use super::coefficients::check_optics;
use super::reach::{reachable, texture_of};
use super::{Numbers, PRECISION_FLOOR, Worst};
use crate::bsdf::{Albedos, Bsdf, Optics, View, Wavelength, dispersion, interpret};
use crate::lanes::Lanes;
use crate::path::Prepared;
use crate::scene::{Object, Scene};
use crate::vector::{Rgb, V3};
use burnish_material::{Inputs, Lobe, LobeSet, Property};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

/// Cosines of the viewer: all that a picture has, and grazing ones beyond it.
const COSINES: [f64; 8] = [1.0, 0.9, 0.6, 0.3, 0.1, 1e-2, 1e-4, 0.0];
/// Below this cosine only finite numbers are asked for: 0, the horizon itself, is where formulas divide.
const JUDGED_COS_MIN: f64 = 1e-5;
/// Azimuths, radians: along, across and askew of a stretch. Isotropic materials need one, which is no axis.
const AZIMUTHS: [f64; 3] = [0.3, 0.0, FRAC_PI_2];
/// Draws per direction: noise of albedos near 1 stays below half a percent.
const DRAWS: usize = 640;
/// Directions per direction of view that no lobe has drawn.
const UNIFORM: usize = 256;
/// Least magnitude of the cosine of a drawn direction that is compared: `eval` raises smaller ones.
const COMPARED_COS_MIN: f64 = 1e-5;
/// Losses are not judged below this cosine: it is the first step of the tables of albedos, and less than a pixel of a ball.
const LOSS_COS_MIN: f64 = 2.5e-4;
/// Standard errors that a gain or loss must exceed.
const SIGMAS: f64 = 4.0;

/// A drawn direction, as the probe sees it.
#[derive(Clone, Copy, Debug)]
pub struct Draw {
    /// Unit, local.
    pub wi: [f64; 3],
    /// Value times cosine over density.
    pub weight: [f64; 3],
    /// Density; 0 for a delta lobe.
    pub pdf: f64,
    /// From a delta lobe.
    pub is_delta: bool,
    /// Otherwise the path ends.
    pub is_valid: bool,
}

/// A BSDF for one viewing direction, in any precision.
pub trait Scattering {
    /// Draws a direction; `u` in `[0, 1)`.
    fn sample(&self, u: [f64; 4]) -> Draw;
    /// Value times cosine, and density.
    fn eval(&self, wi: [f64; 3]) -> ([f64; 3], f64);
}

impl<L: Lanes<Mask = bool> + Into<f64>> Scattering for Bsdf<'_, L> {
    fn sample(&self, u: [f64; 4]) -> Draw {
        let s = Bsdf::sample(self, u.map(L::of));
        let V3 { x, y, z } = s.wi;
        Draw {
            wi: [x, y, z].map(Into::into),
            weight: s.weight.0.map(Into::into),
            pdf: s.pdf.into(),
            is_delta: s.is_delta,
            is_valid: s.is_valid,
        }
    }

    fn eval(&self, wi: [f64; 3]) -> ([f64; 3], f64) {
        let [x, y, z] = wi.map(L::of);
        let (value, pdf) = Bsdf::eval(self, V3::new(x, y, z));
        (value.0.map(Into::into), pdf.into())
    }
}

/// The `i`-th point of a Kronecker sequence in four dimensions, exact in single precision; the first ones are corners of the cube.
fn point(i: usize) -> [f64; 4] {
    /// Powers of the inverse of the root of `x^5 = x + 1`.
    const STEPS: [f64; 4] = [0.856_674_883_854_503, 0.733_891_856_627_152, 0.628_706_720_892_446, 0.538_597_256_984_949];
    /// Largest single-precision number below 1.
    const LAST: f64 = 1.0 - 1.0 / 16_777_216.0;
    if i < CORNERS {
        return std::array::from_fn(|d| if i >> d & 1 == 1 { LAST } else { 0.0 });
    }
    STEPS.map(|step| {
        let x = 0.5 + i as f64 * step;
        f64::from((x - x.floor()) as f32).min(LAST)
    })
}

/// Points that are corners: they are drawn, but stand for no share of the directions.
const CORNERS: usize = 16;

/// Probes the material of every document object at all values it can reach.
pub(super) fn probe_materials(scene: &Scene, prepared: &Prepared, numbers: &mut Numbers, cancel: &dyn Fn() -> bool) {
    let mut done: Vec<&Object> = Vec::new();
    for object in scene.objects.iter().filter(|object| object.is_document) {
        if done.iter().any(|o| Arc::ptr_eq(&o.material, &object.material) && Arc::ptr_eq(&o.textures, &object.textures)) {
            continue;
        }
        done.push(object);
        probe_object(object, prepared, numbers, cancel);
    }
}

fn probe_object(object: &Object, prepared: &Prepared, numbers: &mut Numbers, cancel: &dyn Fn() -> bool) {
    let lobes = LobeSet::of(&object.material);
    let single = |inputs: &Inputs<f64>| inputs.convert(|x| f64::from(x as f32));
    let uniform = single(&object.material.inputs());
    let is_textured = |property: Property| texture_of(object, property).is_some();
    let albedos = Albedos::new(&object.material.inputs(), lobes, is_textured, prepared.albedos());
    // What a bent coat reflects below the base's horizon is lost by design.
    let has_loss = !lobes.has(Lobe::coat_normal_map);
    for (name, inputs) in reachable(object, &uniform) {
        let inputs = single(&inputs);
        probe_inputs(&inputs, lobes, &albedos, object.length_scale, &name, has_loss, numbers, cancel);
    }
}

/// All tints white: what the model then loses, it loses by mistake.
fn whiten(inputs: &mut Inputs<f64>) {
    for color in [
        &mut inputs.base_color,
        &mut inputs.specular_edge_color,
        &mut inputs.sheen_color,
        &mut inputs.absorption_color,
        &mut inputs.coat_color,
    ] {
        *color = [1.0; 3];
    }
}

/// Probes one set of values.
#[expect(clippy::too_many_arguments, reason = "called once; a struct would only rename the arguments")]
fn probe_inputs(
    inputs: &Inputs<f64>,
    lobes: LobeSet,
    albedos: &Albedos,
    length_scale: f64,
    name: &str,
    has_loss: bool,
    numbers: &mut Numbers,
    cancel: &dyn Fn() -> bool,
) {
    let prefix = if name.is_empty() { String::new() } else { format!("{name}, ") };
    let inputs32 = inputs.convert(|x| x as f32);
    let optics32: Optics<f32> = interpret(&inputs32, lobes, length_scale as f32);
    let optics64: Optics<f64> = interpret(inputs, lobes, f64::from(length_scale as f32));
    check_optics(&optics32, &prefix, numbers);
    let mut white = *inputs;
    whiten(&mut white);
    let white32: Optics<f32> = interpret(&white.convert(|x| x as f32), lobes, length_scale as f32);
    // At a threshold the two precisions may choose different formulas, both right.
    let is_comparable = optics32.is_smooth == optics64.is_smooth
        && optics32.is_matched == optics64.is_matched
        && optics32.coat_is_smooth == optics64.coat_is_smooth;

    let is_stretched = lobes.has(Lobe::anisotropy) && optics64.alpha_x != optics64.alpha_y;
    let azimuths = if is_stretched { &AZIMUTHS[..] } else { &AZIMUTHS[..1] };
    let sides: &[f64] = if optics64.w_transmission > 0.0 { &[1.0, -1.0] } else { &[1.0] };
    let normals: &[Option<[f64; 3]>] = if lobes.has(Lobe::coat_normal_map) {
        &[Some([0.0, 0.0, 1.0]), Some([0.6, 0.0, 0.8]), Some([0.0, -0.998_749_22, 0.05])]
    } else {
        &[None]
    };
    // Ends of the visible spectrum, where the index of refraction is furthest from the stated one.
    let wavelengths: &[Option<f64>] = if lobes.has(Lobe::dispersion) { &[Some(380.5), Some(779.5)] } else { &[None] };
    for side in sides {
        for mu in COSINES {
            for azimuth in azimuths {
                if cancel() {
                    return;
                }
                for coat_normal in normals {
                    for wavelength in wavelengths {
                        let s = (1.0 - mu * mu).max(0.0).sqrt();
                        let wo = [s * azimuth.cos(), s * azimuth.sin(), side * mu].map(|x| f64::from(x as f32));
                        let at = At { wo, coat_normal: *coat_normal, wavelength: *wavelength };
                        let single = Bsdf::prepare(&optics32, albedos, lobes, &at.view::<f32>());
                        let exact = Bsdf::prepare(&optics64, albedos, lobes, &at.view::<f64>());
                        // Rounded directions are not unit, which double precision sees.
                        let unit = Bsdf::prepare(&optics64, albedos, lobes, &at.unit().view::<f64>());
                        let place = || {
                            let side = if *side > 0.0 { "outside" } else { "inside" };
                            let light = wavelength.map_or_else(String::new, |nm| format!(", {nm:.0} nm"));
                            format!("{prefix}cosine {mu:e} from {side}, azimuth {azimuth:.2}{light}")
                        };
                        let exact = is_comparable.then_some(&exact as &dyn Scattering);
                        if mu < JUDGED_COS_MIN {
                            let mut counted = Numbers::default();
                            probe_scattering(&single, None, &single, &place, &mut counted);
                            numbers.add_counts(counted);
                            continue;
                        }
                        probe_scattering(&single, exact, &unit, &place, numbers);
                        if has_loss && mu > LOSS_COS_MIN {
                            let white = Bsdf::prepare(&white32, albedos, lobes, &at.view::<f32>());
                            probe_loss(&white, &place, numbers);
                        }
                    }
                }
            }
        }
    }
}

/// One way of looking at the surface.
struct At {
    wo: [f64; 3],
    coat_normal: Option<[f64; 3]>,
    wavelength: Option<f64>,
}

impl At {
    /// The same with a direction of unit length in double precision.
    fn unit(&self) -> Self {
        let length = self.wo.iter().map(|x| x * x).sum::<f64>().sqrt();
        Self { wo: self.wo.map(|x| x / length), ..*self }
    }

    fn view<L: Lanes<Mask = bool>>(&self) -> View<L> {
        let v = |[x, y, z]: [f64; 3]| V3::new(L::of(x), L::of(y), L::of(z));
        View {
            coat_normal: self.coat_normal.map(|n| v(n.map(|x| f64::from(x as f32)))),
            light: self.wavelength.map(|nm| Wavelength {
                nm: L::of(nm),
                weights: Rgb(dispersion::spectrum().weights(nm).map(|w| L::of(f64::from(w)))),
                is_dispersed: true,
            }),
            ..View::new(v(self.wo))
        }
    }
}

/// Counts what is not finite or negative; whether all is sound.
fn count(values: &[f64], what: &str, place: &dyn Fn() -> String, numbers: &mut Numbers) -> bool {
    let is_finite = values.iter().all(|x| x.is_finite());
    let is_sound = is_finite && values.iter().all(|x| *x >= 0.0);
    if !is_sound {
        numbers.nonfinite += u64::from(!is_finite);
        numbers.negative += u64::from(is_finite);
        if numbers.first_bad.is_empty() {
            numbers.first_bad = format!("{what} at {}", place());
        }
    }
    is_sound
}

/// Probes a BSDF for one viewing direction: `single` in single precision, `exact` the same in double precision with the same rounded inputs
/// (none where the two choose different formulas), `unit` in double precision with a direction of unit length.
pub fn probe_scattering(
    single: &dyn Scattering,
    exact: Option<&dyn Scattering>,
    unit: &dyn Scattering,
    place: &dyn Fn() -> String,
    numbers: &mut Numbers,
) {
    let mut albedo = Albedo::default();
    let mut density = 0.0;
    let uniform = 1.0 / (4.0 * PI);
    // Drawn directions count where the density is high, uniform ones where it is low. Only the latter tell whether a density is too large,
    // so they get the larger part.
    let share = |pdf: f64, is_drawn: bool| {
        let (part, count) = if is_drawn { (1.0, DRAWS) } else { (2.0, UNIFORM) };
        part * pdf / ((pdf + 2.0 * uniform) * count as f64)
    };
    for i in 0..CORNERS + DRAWS {
        let u = point(i);
        let s = single.sample(u);
        let is_counted = i >= CORNERS;
        if s.is_valid {
            let is_sound = count(&[s.weight[0], s.weight[1], s.weight[2], s.pdf], "a sample", place, numbers)
                && count(&s.wi.map(f64::abs), "a direction", place, numbers);
            if is_counted {
                albedo.add(s.weight);
            }
            if is_sound && !s.is_delta {
                let (value, pdf) = single.eval(s.wi);
                count(&[value[0], value[1], value[2], pdf], "a value", place, numbers);
                if is_counted {
                    density += share(pdf, true);
                    if let Some(exact) = exact {
                        compare(&(value, pdf), &exact.eval(s.wi), place, &mut numbers.precision);
                    }
                }
            }
        } else if is_counted {
            albedo.add([0.0; 3]);
        }
        // Corners lie on the borders of lobes, where a rounding decides whether there is a value at all.
        if is_counted {
            mismatch(unit, &unit.sample(u), place, &mut numbers.pdf_mismatch);
        }
    }
    for i in 0..UNIFORM {
        let [a, b, ..] = point(CORNERS + i);
        let z = 2.0 * a - 1.0;
        let r = (1.0 - z * z).max(0.0).sqrt();
        let wi = [r * (2.0 * PI * b).cos(), r * (2.0 * PI * b).sin(), z].map(|x| f64::from(x as f32));
        let (value, pdf) = single.eval(wi);
        if count(&[value[0], value[1], value[2], pdf], "a value", place, numbers) {
            density += share(pdf, false);
        }
        if let Some(exact) = exact {
            compare(&(value, pdf), &exact.eval(wi), place, &mut numbers.precision);
        }
    }
    numbers.density_excess.note(density - 1.0, place);
    numbers.gain.note(albedo.beyond_noise(1.0), place);
}

pub(super) fn probe_loss(white: &dyn Scattering, place: &dyn Fn() -> String, numbers: &mut Numbers) {
    let mut albedo = Albedo::default();
    for i in 0..DRAWS {
        let s = white.sample(point(CORNERS + i));
        albedo.add(if s.is_valid { s.weight } else { [0.0; 3] });
    }
    numbers.loss.get_or_insert_default().note(albedo.beyond_noise(-1.0), place);
}

/// Mean weight of draws, with its standard error.
#[derive(Default)]
struct Albedo {
    count: f64,
    sum: [f64; 3],
    squares: [f64; 3],
}

impl Albedo {
    fn add(&mut self, weight: [f64; 3]) {
        self.count += 1.0;
        for (k, w) in weight.into_iter().enumerate() {
            self.sum[k] += w;
            self.squares[k] += w * w;
        }
    }

    /// How far the mean of a channel is above 1 (`sign` 1) or below it (`sign` -1), less what may be chance.
    fn beyond_noise(&self, sign: f64) -> f64 {
        let excess = |k: usize| {
            let mean = self.sum[k] / self.count;
            let variance = (self.squares[k] / self.count - mean * mean).max(0.0);
            // Evenly spread points err less than independent ones; a standard error is still the safer side.
            sign * (mean - 1.0) - SIGMAS * (variance / self.count).sqrt()
        };
        (0..3).map(excess).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// What a draw says against what `eval` says of its direction.
fn mismatch(of: &dyn Scattering, s: &Draw, place: &dyn Fn() -> String, worst: &mut Worst) {
    if !s.is_valid || s.is_delta || s.wi[2].abs() < COMPARED_COS_MIN {
        return;
    }
    let (value, pdf) = of.eval(s.wi);
    worst.note(relative(s.pdf, pdf, 1e-6), place);
    for (weight, value) in s.weight.into_iter().zip(value) {
        worst.note(relative(weight * s.pdf, value, 1e-6), place);
    }
}

fn compare(single: &([f64; 3], f64), double: &([f64; 3], f64), place: &dyn Fn() -> String, worst: &mut Worst) {
    worst.note(relative(single.1, double.1, PRECISION_FLOOR), place);
    for (single, double) in single.0.into_iter().zip(double.0) {
        worst.note(relative(single, double, PRECISION_FLOOR), place);
    }
}

fn relative(a: f64, b: f64, floor: f64) -> f64 {
    if a == b { 0.0 } else { (a - b).abs() / b.abs().max(floor) }
}
