use std::prelude::v1::*;

use core::f64::consts::TAU;

use super::*;
use crate::time::SensorTime;

const RATE_HZ: f64 = 400.0;

fn sample(k: u64, rate: DVec3, force: DVec3) -> ImuSample {
    ImuSample {
        time: SensorTime::from_nanos(2_500_000 * k.cast_signed()),
        gyro: Gyro::new(rate),
        accel: Accel::new(force),
        mag: None,
        saturated: false,
    }
}

/// Gain and phase, rad, of the filter at a frequency, by correlation over whole periods after it has
/// settled.
fn response(filter: &mut LowPass, frequency_hz: f64) -> (f64, f64) {
    let per_period = RATE_HZ / frequency_hz;
    let (settling, measured) = ((40.0 * per_period) as u64, (200.0 * per_period) as u64);
    let (mut sine, mut cosine) = (0.0, 0.0);
    for k in 0..settling + measured {
        let angle = TAU * frequency_hz * k as f64 / RATE_HZ;
        let input = libm::sin(angle);
        let out = filter.filter(&sample(k, DVec3::X * input, DVec3::Y * input), 0);
        assert!((out.gyro.vector.x - out.accel.vector.y).abs() < 1e-15);
        if k >= settling {
            sine += out.gyro.vector.x * libm::sin(angle);
            cosine += out.gyro.vector.x * libm::cos(angle);
        }
    }
    let half = 0.5 * measured as f64;
    let (sine, cosine) = (sine / half, cosine / half);
    (libm::hypot(sine, cosine), libm::atan2(cosine, sine))
}

#[test]
fn the_stated_delay_is_that_of_the_measured_phase() {
    for cut_off_hz in [10.0, 20.0, 40.0, 80.0, 150.0] {
        let filter = LowPass::new(cut_off_hz, RATE_HZ).unwrap();
        // A frequency that is low and has a whole number of samples in its period.
        let frequency_hz = RATE_HZ / libm::round(RATE_HZ / (cut_off_hz / 25.0));
        let (gain, phase) = response(&mut { filter }, frequency_hz);
        let measured_s = -phase / (TAU * frequency_hz);
        let stated_s = filter.group_delay_s();
        assert!((measured_s / stated_s - 1.0).abs() < 2e-3, "{measured_s} {stated_s}");
        assert!((gain - 1.0).abs() < 1e-5, "{gain} at {frequency_hz} Hz");
    }
    // Well below the sample rate it is the analogue filter's.
    let low = LowPass::new(5.0, RATE_HZ).unwrap();
    assert!((low.group_delay_s() * 5.0 - 0.225_079).abs() < 1e-3);
}

#[test]
fn half_the_power_is_left_at_the_cut_off_and_a_hundredth_of_it_at_three_times_that() {
    let (gain, _) = response(&mut LowPass::new(40.0, RATE_HZ).unwrap(), 40.0);
    assert!((gain * gain - 0.5).abs() < 1e-6, "{gain}");
    let (gain, _) = response(&mut LowPass::new(40.0, RATE_HZ).unwrap(), 100.0);
    assert!(gain < 0.15, "{gain}");
}

#[test]
fn no_rotation_is_lost() {
    // Given a camera that lies, turns in jerks, and lies again
    let mut filter = LowPass::new(20.0, RATE_HZ).unwrap();
    let (mut turned, mut seen) = (DVec3::ZERO, DVec3::ZERO);
    for k in 0..2000 {
        let jerk = if (500..600).contains(&k) { libm::sin(k as f64) + 2.0 } else { 0.0 };
        let rate = DVec3::new(jerk, -2.0 * jerk, 0.5);
        let out = filter.filter(&sample(k, rate, DVec3::Z * 9.81), 0);
        turned += rate;
        seen += out.gyro.vector;
        assert!(
            (out.accel.vector.z - 9.81).abs() < 1e-12,
            "a constant is left alone from the start"
        );
    }
    assert!((turned - seen).length() < 1e-9 * turned.length(), "{turned} {seen}");
}

#[test]
fn lost_samples_neither_stretch_nor_lose_a_steady_change() {
    // Given a rate that grows steadily, when every third sample is lost
    let rate = |k: u64| DVec3::Z * (0.01 * k as f64);
    let (mut whole, mut torn) =
        (LowPass::new(20.0, RATE_HZ).unwrap(), LowPass::new(20.0, RATE_HZ).unwrap());
    let mut missing = 0;
    for k in 0..600 {
        let now = sample(k, rate(k), DVec3::ZERO);
        let expected = whole.filter(&now, 0);
        if k % 3 == 2 {
            missing += 1;
            continue;
        }
        // Then what comes out is the same
        let found = torn.filter(&now, core::mem::take(&mut missing));
        assert!((found.gyro.vector - expected.gyro.vector).length() < 1e-12);
    }
    // After a long silence it begins anew, where the camera then is.
    let late = sample(9000, DVec3::X, DVec3::Y);
    assert_eq!(torn.filter(&late, MOST_MISSING + 1), late);
}

#[test]
fn a_cut_off_that_the_rate_cannot_show_is_refused() {
    for cut_off_hz in [0.0, -1.0, 180.0, f64::NAN, f64::INFINITY] {
        assert_eq!(LowPass::new(cut_off_hz, RATE_HZ), None, "{cut_off_hz}");
    }
}
