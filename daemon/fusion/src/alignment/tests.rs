use std::format;
use std::vec::Vec;

use glam::DVec3;

use super::*;
use crate::grid::Increment;
use crate::quantity::Mag;
use crate::testing::{Normal, attitudes};
use crate::time::SensorTime;

const DT: f64 = 0.0025;
const FIELD: DVec3 = DVec3::new(0.0, 22.0, -42.0);
const GRAVITY: DVec3 = DVec3::new(0.0, 0.0, 9.81);

fn step(index: i64, rate: DVec3, force: DVec3, mag: Option<DVec3>) -> Step {
    Step {
        time: SensorTime::from_nanos(index * 2_500_000),
        increment: Increment { span_s: DT, angle: rate * DT, velocity: force * DT },
        mag: mag.map(Mag::new),
        bridged: false,
        saturated: false,
    }
}

/// Feeds steps until aligned, for at most `seconds`; gives what was found and after how long.
fn align(
    alignment: &mut Alignment,
    seconds: f64,
    mut at: impl FnMut(i64) -> Step,
) -> Option<(Aligned, f64)> {
    let mut p = Parameters::default();
    p.alignment.motion_s = None;
    (1..=(seconds / DT) as i64)
        .find_map(|k| alignment.push(&at(k), &p).map(|aligned| (aligned, k as f64 * DT)))
}

/// A camera at rest in an attitude, with or without magnetometer.
fn resting(orientation: DQuat, mag: bool) -> impl Fn(i64) -> Step {
    let body = orientation.conjugate();
    let mag = mag.then_some(body * FIELD);
    move |k| step(k, DVec3::ZERO, body * GRAVITY, mag)
}

#[test]
fn any_attitude_at_rest_is_found() {
    let nearly_over =
        (1..8).map(|k| so3::exp(DVec3::X * (core::f64::consts::PI - 10_f64.powi(-k))));
    for orientation in attitudes().into_iter().chain(nearly_over) {
        let (aligned, _) = align(&mut Alignment::new(), 3.0, resting(orientation, true)).unwrap();
        let error = so3::log(orientation * aligned.state.orientation.conjugate());
        assert!(error.length() < 1e-9, "{error} off at {orientation}");
        assert!((aligned.field.unwrap() - FIELD).length() < 1e-7);
        assert_eq!(aligned.state.velocity, DVec3::ZERO);
        assert!(aligned.state.covariance.is_finite());
    }
}

#[test]
fn without_a_magnetometer_it_is_level_and_the_heading_counts_from_here() {
    for orientation in attitudes() {
        let (aligned, _) = align(&mut Alignment::new(), 3.0, resting(orientation, false)).unwrap();
        assert_eq!(aligned.field, None);
        let up = aligned.state.orientation * (orientation.conjugate() * DVec3::Z);
        assert!((up - DVec3::Z).length() < 1e-9, "{up}");
        let heading = aligned.state.covariance.variance(ORIENTATION.0 + 2);
        assert!(heading < 1e-3, "the world's own heading counts from here: {heading} rad²");
    }
}

#[test]
fn it_takes_the_rest_it_asks_for_and_little_more() {
    let (_, after_s) = align(&mut Alignment::new(), 5.0, resting(DQuat::IDENTITY, true)).unwrap();
    let asked = Parameters::default().alignment.rest_s;
    assert!(after_s > asked - 1e-9 && after_s < asked + 0.1, "{after_s} s");
}

#[test]
fn the_mean_rate_is_the_first_bias() {
    let bias = DVec3::new(0.004, -0.003, 0.002);
    let mut random = Normal::seeded(4);
    let density = Parameters::default().noise.gyro_density;
    let noise = density / libm::sqrt(DT);
    let (aligned, _) = align(&mut Alignment::new(), 3.0, |k| {
        step(k, bias + random.vector(noise), GRAVITY, Some(FIELD))
    })
    .unwrap();
    let sigma = libm::sqrt(aligned.state.covariance.variance(GYRO_BIAS.0));
    let error = (aligned.state.gyro_bias - bias).abs().max_element();
    assert!(error < 4.0 * sigma, "{error} for a sigma of {sigma}");
    assert!(sigma < 5.0 * density, "and it says that it knows: {sigma}");
}

/// What it says after three seconds of something that is not rest.
fn reason(at: impl FnMut(i64) -> Step) -> Waiting {
    let mut alignment = Alignment::new();
    assert!(align(&mut alignment, 3.0, at).is_none(), "not at rest");
    alignment.waiting()
}

#[test]
fn a_camera_that_swings_is_refused_for_turning() {
    let swing = |k: i64| DVec3::X * 0.3 * libm::sin(k as f64 * DT * 20.0);
    let why = reason(|k| step(k, swing(k), GRAVITY, None));
    assert!(matches!(why, Waiting::Turning(rate) if rate > 0.1 && rate < 0.3), "{why}");
    assert!(format!("{why}").contains("rad/s"));
}

#[test]
fn a_camera_on_an_engine_is_refused_for_shaking() {
    let shake = |k: i64| DVec3::Y * 1.5 * libm::sin(k as f64 * DT * 200.0);
    let why = reason(|k| step(k, DVec3::ZERO, GRAVITY + shake(k), None));
    assert!(matches!(why, Waiting::Shaking(force) if force > 0.8 && force < 1.5), "{why}");
}

#[test]
fn a_wrong_gravity_is_refused_with_its_size() {
    for size in [0.0, 8.5, 11.0, 981.0] {
        let why = reason(|k| step(k, DVec3::ZERO, DVec3::Z * size, None));
        assert!(matches!(why, Waiting::NotGravity(g) if (g - size).abs() < 1e-9), "{why}");
    }
}

#[test]
fn a_turntable_is_refused_with_its_rate() {
    let why = reason(|k| step(k, DVec3::Z * 0.2, GRAVITY, None));
    assert!(matches!(why, Waiting::ConstantTurn(rate) if (rate - 0.2).abs() < 1e-9), "{why}");
}

#[test]
fn too_short_a_rest_is_still_collecting() {
    let mut alignment = Alignment::new();
    assert!(align(&mut alignment, 0.3, resting(DQuat::IDENTITY, true)).is_none());
    assert_eq!(alignment.waiting(), Waiting::Collecting);
}

#[test]
fn rest_after_motion_is_accepted_and_only_rest_counts() {
    // Given a camera that was swung in another field, when it comes to rest, then attitude and
    // field are those of the rest alone.
    let orientation = so3::exp(DVec3::new(0.4, -0.2, 1.0));
    let rest = resting(orientation, true);
    let (aligned, after_s) = align(&mut Alignment::new(), 6.0, |k| {
        if k > 800 {
            return rest(k);
        }
        step(k, DVec3::X * libm::sin(k as f64 * 0.05), GRAVITY, Some(DVec3::X * 90.0))
    })
    .unwrap();
    let error = so3::log(orientation * aligned.state.orientation.conjugate());
    assert!(error.length() < 1e-9, "{error}");
    assert!(after_s > 3.0 - 1e-9 && after_s < 3.7, "{after_s} s");
}

#[test]
fn an_accelerometer_bias_tilts_it_as_the_covariance_says() {
    // The tilt that a bias causes, by central differences, against the correlation of the first
    // covariance.
    const DELTA: f64 = 1e-4;
    let p = Parameters::default();
    for orientation in attitudes() {
        let body = orientation.conjugate();
        let tilt = |bias: DVec3| -> (DVec3, State) {
            let at = |k| step(k, DVec3::ZERO, body * GRAVITY + bias, None);
            let (aligned, _) = align(&mut Alignment::new(), 3.0, at).unwrap();
            // True attitude relative to the estimate; only tilt, the heading is open.
            let up_in_body = body * DVec3::Z;
            let seen = aligned.state.orientation * up_in_body;
            (seen.cross(DVec3::Z), aligned.state)
        };
        let (_, state) = tilt(DVec3::ZERO);
        let variance = p.noise.accel_bias_sigma * p.noise.accel_bias_sigma;
        let coupling = state.covariance.block(ORIENTATION, ACCEL_BIAS) * variance.recip();
        for axis in DVec3::AXES {
            let exact = (tilt(axis * DELTA).0 - tilt(axis * -DELTA).0) / (2.0 * DELTA);
            let got = coupling * axis;
            assert!((got - exact).length() < 1e-6, "{got} for {exact} at {orientation}");
        }
    }
}

#[test]
fn the_first_covariance_is_one() {
    for orientation in attitudes() {
        for mag in [true, false] {
            let (aligned, _) =
                align(&mut Alignment::new(), 3.0, resting(orientation, mag)).unwrap();
            let dense = crate::testing::Dense::of(&aligned.state.covariance);
            assert!(dense.is_symmetric());
            assert!(dense.is_positive_semidefinite(1e-9));
        }
    }
}

#[test]
fn every_reason_reads_as_a_sentence() {
    let all = [
        Waiting::Collecting,
        Waiting::Turning(0.1),
        Waiting::Shaking(0.3),
        Waiting::NotGravity(3.0),
        Waiting::ConstantTurn(0.1),
    ];
    let texts: Vec<_> = all.iter().map(|why| format!("{why}")).collect();
    for (k, text) in texts.iter().enumerate() {
        assert!(text.len() > 10 && !texts[..k].contains(text), "{text}");
    }
}
