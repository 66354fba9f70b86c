use std::vec::Vec;

use super::*;
use crate::testing::Normal;

const DT: f64 = 0.0025;
const WINDOW_S: f64 = 0.5;

/// The last statistics of a window over samples of rate and force.
fn window(samples: &[(DVec3, DVec3)]) -> WindowStatistics {
    let mut detector = RestDetector::new();
    let increment = |(rate, force): &(DVec3, DVec3)| Increment {
        span_s: DT,
        angle: *rate * DT,
        velocity: *force * DT,
    };
    let push = |s| detector.push(&increment(s), WINDOW_S);
    samples.iter().filter_map(push).last().expect("a full window")
}

/// A standing camera's samples with noise of one standard deviation each, and biases.
fn standing_samples(noise: (f64, f64), bias: (DVec3, DVec3)) -> Vec<(DVec3, DVec3)> {
    let mut random = Normal::seeded(11);
    let gravity = DVec3::new(3.0, -4.0, 8.0).normalize() * 9.81;
    let mut sample =
        || (bias.0 + random.vector(noise.0), gravity + bias.1 + random.vector(noise.1));
    (0..200).map(|_| sample()).collect()
}

fn known() -> Standing {
    Standing { gyro_bias: DVec3::ZERO, gyro_bias_sigma: 0.0, force: 9.81, force_sigma: 0.0 }
}

/// What a camera's estimator knows at first.
fn usual() -> Standing {
    Standing { gyro_bias_sigma: 3e-4, force_sigma: 0.05, ..known() }
}

#[test]
fn the_statistic_is_the_likelihood_ratio_of_the_paper() {
    // The sum over all samples as Skog et al. write it, gravity along the mean force.
    let bias = DVec3::new(0.01, 0.02, -0.01);
    let samples = standing_samples((0.03, 0.4), (bias, DVec3::new(0.3, 0.0, 0.1)));
    let p = RestParameters::default();
    let standing = Standing { gyro_bias: -bias, ..known() };
    let up = samples.iter().map(|s| s.1).sum::<DVec3>().normalize();
    let term = |(rate, force): &(DVec3, DVec3)| {
        (*force - up * 9.81).length_squared() / p.stillness.force_sigma_m_s2.powi(2)
            + (*rate + bias).length_squared() / p.stillness.rate_sigma_rad_s.powi(2)
    };
    let paper = samples.iter().map(term).sum::<f64>() / samples.len() as f64;
    let ours = window(&samples).statistic(&standing, &p.stillness);
    assert!((ours / paper - 1.0).abs() < 1e-9, "{ours} where the paper has {paper}");
}

#[test]
fn noise_as_large_as_stillness_allows_gives_six() {
    let p = RestParameters::default();
    let noise = (p.stillness.rate_sigma_rad_s, p.stillness.force_sigma_m_s2);
    let samples = standing_samples(noise, (DVec3::ZERO, DVec3::ZERO));
    let statistic = window(&samples).statistic(&known(), &p.stillness);
    assert!((statistic - 6.0).abs() < 0.5, "{statistic}");
}

#[test]
fn a_biased_sensor_at_rest_is_at_rest() {
    let p = RestParameters::default();
    let bias = (DVec3::new(8e-4, -6e-4, 5e-4), DVec3::new(0.1, -0.08, 0.12));
    let window = window(&standing_samples((1.7e-3, 0.023), bias));
    assert!(window.is_rest(&usual(), &p));
    // Were the biases known to be zero, the same window would be a slow motion.
    assert!(
        window.statistic(&known(), &p.stillness) > 2.0 * window.statistic(&usual(), &p.stillness)
    );
}

#[test]
fn shaking_swinging_and_slow_turns_are_no_rest() {
    let p = RestParameters::default();
    let at_rest = standing_samples((1.7e-3, 0.023), (DVec3::ZERO, DVec3::ZERO));
    assert!(window(&at_rest).is_rest(&usual(), &p));
    let wave = |n: usize| libm::sin(n as f64 * DT * 30.0);
    let moved = |by: &dyn Fn(usize) -> (DVec3, DVec3)| -> Vec<(DVec3, DVec3)> {
        let add = |(n, s): (usize, &(DVec3, DVec3))| (s.0 + by(n).0, s.1 + by(n).1);
        at_rest.iter().enumerate().map(add).collect()
    };
    let motions: [&dyn Fn(usize) -> (DVec3, DVec3); 3] = [
        &|n| (DVec3::ZERO, DVec3::Y * 0.4 * wave(n)),
        &|n| (DVec3::X * 0.05 * wave(n), DVec3::ZERO),
        &|_| (DVec3::Z * 0.0087, DVec3::ZERO),
    ];
    for (index, motion) in motions.into_iter().enumerate() {
        assert!(!window(&moved(motion)).is_rest(&usual(), &p), "motion {index}");
    }
}

#[test]
fn a_window_is_as_long_as_it_says_at_any_rate() {
    // The first decision comes with the first full window, whatever the length of a step.
    for (rate_hz, window_s) in [(400.0, 0.5), (200.0, 0.05), (285.714, 0.5), (60.0, 0.5)] {
        let mut detector = RestDetector::new();
        let span_s = 1.0 / rate_hz;
        let still = Increment { span_s, angle: DVec3::ZERO, velocity: DVec3::Z * 9.81 * span_s };
        let steps = (1..10_000).find(|_| detector.push(&still, window_s).is_some()).unwrap();
        let took_s = f64::from(steps) * span_s;
        assert!(
            (took_s / window_s - 1.0).abs() < 0.2,
            "{took_s} s for {window_s} s at {rate_hz} Hz"
        );
    }
}
