//! Does an angle swing with the stride? A fit of the stride's harmonics, and a spectrum.
//!
//! Over a flight of stairs at an even pace an angle is a slow trend (the walker looks about), plus
//! the swing `Σ aₖ cos(2πkft) + bₖ sin(2πkft)`, plus whatever else. A cubic takes the trend off; of what
//! is left, the part that the first three harmonics explain says how harmonic it is: 1 is entirely.

use std::f64::consts::TAU;

use serde::Serialize;

/// Harmonics of the stride: the stride, the step, and one more.
const HARMONICS: u32 = 3;
/// Stride frequencies that are tried, Hz: from a slow climb to a run.
const TRIED_HZ: (f64, f64, f64) = (0.4, 1.3, 0.005);

/// What the stride explains of one angle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Swing {
    /// Amplitude at the stride's frequency, in the unit of the values.
    pub at_stride: f64,
    /// Amplitude at twice that: each step.
    pub at_step: f64,
    /// Part of the variance about the trend that the harmonics explain, 0 to 1.
    pub explained: f64,
}

/// The frequency of the stride, Hz: that of the largest swing. Harmonics do not count, or half the stride's
/// frequency would explain as much. `None` of too few values.
pub fn stride_hz(times_s: &[f64], values: &[f64]) -> Option<f64> {
    let (low, high, step) = TRIED_HZ;
    let tried = (0..=((high - low) / step) as u32).map(|k| low + f64::from(k) * step);
    let scored: Option<Vec<(f64, f64)>> =
        tried.map(|hz| Some((hz, swing(times_s, values, hz)?.at_stride))).collect();
    scored?.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(hz, _)| hz)
}

/// The swing at a stride's frequency. `None` of too few values, and of values that do not change.
pub fn swing(times_s: &[f64], values: &[f64], stride_hz: f64) -> Option<Swing> {
    if values.len() < 20 || values.len() != times_s.len() {
        return None;
    }
    let mut basis = trend(times_s);
    let left = without(values, &basis);
    let total = square(&left);
    // Of values that do not change, rounding is left.
    let changes = total > 1e-20 * square(values);
    let mut energies = Vec::new();
    for harmonic in 1..=HARMONICS {
        let turn = |t: &f64| TAU * f64::from(harmonic) * stride_hz * t;
        let waves = [
            times_s.iter().map(|t| turn(t).cos()).collect::<Vec<f64>>(),
            times_s.iter().map(|t| turn(t).sin()).collect(),
        ];
        let energy = waves.into_iter().filter_map(|wave| {
            let unit = unit(without(&wave, &basis))?;
            let along = dot(&left, &unit);
            basis.push(unit);
            Some(along * along)
        });
        energies.push(energy.sum::<f64>());
    }
    // A wave of amplitude A has the energy A² n / 2.
    let amplitude = |energy: f64| (2.0 * energy / values.len() as f64).sqrt();
    changes.then(|| Swing {
        at_stride: amplitude(energies[0]),
        at_step: amplitude(energies[1]),
        explained: energies.iter().sum::<f64>() / total,
    })
}

/// Amplitude over frequency, Hz, of values about their trend, through a Hann window: a sine of
/// amplitude A has a peak of A.
pub fn spectrum(times_s: &[f64], values: &[f64], frequencies_hz: &[f64]) -> Vec<(f64, f64)> {
    let left = without(values, &trend(times_s));
    let count = left.len().max(1) as f64;
    let hann = |k: usize| 1.0 - (TAU * (k as f64 + 0.5) / count).cos();
    let amplitude = |&hz: &f64| {
        let (mut cosine, mut sine) = (0.0, 0.0);
        for (k, (time_s, value)) in times_s.iter().zip(&left).enumerate() {
            let (s, c) = (TAU * hz * time_s).sin_cos();
            cosine += hann(k) * value * c;
            sine += hann(k) * value * s;
        }
        (hz, 2.0 * cosine.hypot(sine) / count)
    };
    frequencies_hz.iter().map(amplitude).collect()
}

/// Orthonormal vectors that span the cubics over these times.
fn trend(times_s: &[f64]) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let (first, last) = (times_s.first().copied().unwrap_or(0.0), times_s.last().copied());
    let half = 0.5 * (last.unwrap_or(1.0) - first).max(1e-9);
    for power in 0..=3 {
        let column = times_s.iter().map(|t| ((t - first) / half - 1.0).powi(power)).collect();
        basis.extend(unit(without_owned(column, &basis)));
    }
    basis
}

/// What is left of values beside what lies along orthonormal vectors (modified Gram-Schmidt).
fn without(values: &[f64], basis: &[Vec<f64>]) -> Vec<f64> {
    without_owned(values.to_vec(), basis)
}

fn without_owned(mut values: Vec<f64>, basis: &[Vec<f64>]) -> Vec<f64> {
    for direction in basis {
        let along = dot(&values, direction);
        for (value, part) in values.iter_mut().zip(direction) {
            *value -= along * part;
        }
    }
    values
}

/// The vector of unit length; `None` if rounding is all that is left of it.
fn unit(mut vector: Vec<f64>) -> Option<Vec<f64>> {
    let length = square(&vector).sqrt();
    for value in &mut vector {
        *value /= length;
    }
    (length > 1e-9).then_some(vector)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn square(values: &[f64]) -> f64 {
    dot(values, values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn times() -> Vec<f64> {
        (0..220).map(|k| 3.0 + f64::from(k) * 0.025).collect()
    }

    fn angle(times: &[f64], hz: f64, (stride, step): (f64, f64), other: f64) -> Vec<f64> {
        let value = |t: &f64| {
            30.0 - 4.0 * t
                + 0.3 * t * t
                + stride * (TAU * hz * t + 0.7).sin()
                + step * (TAU * 2.0 * hz * t - 1.1).sin()
                + other * (TAU * 3.31 * t).sin()
        };
        times.iter().map(value).collect()
    }

    #[test]
    fn a_harmonic_swing_on_a_trend_is_found_with_its_amplitudes() {
        let times = times();
        let values = angle(&times, 0.73, (3.0, 1.5), 0.0);
        let hz = stride_hz(&times, &values).unwrap();
        assert!((hz - 0.73).abs() < 0.011, "{hz}");
        let swing = swing(&times, &values, 0.73).unwrap();
        assert!((swing.at_stride - 3.0).abs() < 0.15, "{swing:?}");
        assert!((swing.at_step - 1.5).abs() < 0.1, "{swing:?}");
        assert!(swing.explained > 0.9999, "{swing:?}");
    }

    #[test]
    fn half_a_stride_is_not_taken_for_the_stride() {
        let times = times();
        let values = angle(&times, 0.82, (2.8, 0.0), 0.0);
        let hz = stride_hz(&times, &values).unwrap();
        assert!((hz - 0.82).abs() < 0.02, "{hz}");
    }

    #[test]
    fn what_does_not_go_with_the_stride_is_not_explained() {
        let times = times();
        let values = angle(&times, 0.73, (1.0, 0.0), 1.0);
        let swing = swing(&times, &values, 0.73).unwrap();
        assert!((swing.explained - 0.5).abs() < 0.06, "{swing:?}");
    }

    #[test]
    fn the_spectrum_peaks_where_the_swing_is() {
        let times = times();
        let values = angle(&times, 0.9, (2.0, 0.0), 0.0);
        let frequencies: Vec<f64> = (10..80).map(|k| f64::from(k) * 0.05).collect();
        let spectrum = spectrum(&times, &values, &frequencies);
        let peak = spectrum.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        assert!((peak.0 - 0.9).abs() < 0.06 && (peak.1 - 2.0).abs() < 0.15, "{peak:?}");
    }

    #[test]
    fn nothing_to_fit_is_no_swing() {
        assert_eq!(swing(&times(), &[1.0; 220], 0.7), None);
        assert_eq!(swing(&[0.0; 3], &[1.0, 2.0, 3.0], 0.7), None);
        assert_eq!(stride_hz(&[], &[]), None);
    }

    proptest! {
        #[test]
        fn no_more_than_everything_is_explained(values in proptest::collection::vec(-9.0..9.0f64, 60), hz in 0.4..1.3f64) {
            let times: Vec<f64> = (0..60).map(|k| f64::from(k) * 0.1).collect();
            if let Some(swing) = swing(&times, &values, hz) {
                prop_assert!((0.0..=1.0 + 1e-9).contains(&swing.explained));
            }
        }
    }
}
