use std::vec::Vec;

use glam::DVec3;
use proptest::prelude::*;

use super::*;
use crate::quantity::{Accel, Gyro};

const STEP_NS: i64 = 2_500_000;

fn parameters() -> GridParameters {
    GridParameters::at_rate(400.0)
}

fn sample(nanos: i64, rate: DVec3, force: DVec3) -> ImuSample {
    ImuSample {
        time: SensorTime::from_nanos(nanos),
        gyro: Gyro::new(rate),
        accel: Accel::new(force),
        mag: None,
        saturated: false,
    }
}

fn still(nanos: i64) -> ImuSample {
    sample(nanos, DVec3::ZERO, DVec3::Z * 9.81)
}

/// Every step that the samples complete, in order.
fn steps_of(grid: &mut Grid, samples: &[ImuSample]) -> Vec<Step> {
    let mut steps = Vec::new();
    for sample in samples {
        grid.push(*sample).unwrap();
        while let Some(step) = grid.next_step() {
            steps.push(step);
        }
    }
    steps
}

fn vector(limit: f64) -> impl Strategy<Value = DVec3> {
    (-limit..limit, -limit..limit, -limit..limit).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

/// A stream with spacings from a twentieth of a step to eight steps.
fn any_stream() -> impl Strategy<Value = Vec<ImuSample>> {
    let one = (125_000..20_000_000_i64, vector(30.0), vector(50.0));
    (-1_000_000_000_000..1_000_000_000_000_i64, prop::collection::vec(one, 2..60)).prop_map(
        |(start, parts)| {
            let mut nanos = start;
            parts
                .into_iter()
                .map(|(span, rate, force)| {
                    nanos += span;
                    sample(nanos, rate, force)
                })
                .collect()
        },
    )
}

proptest! {
    #[test]
    fn steps_lie_on_the_constant_grid_whatever_the_jitter(samples in any_stream()) {
        let steps = steps_of(&mut Grid::new(parameters()), &samples);
        let first = samples[0].time.as_nanos();
        let covered = samples[samples.len() - 1].time.as_nanos() - first;
        prop_assert_eq!(i64::try_from(steps.len()), Ok(covered / STEP_NS));
        for (k, step) in (1..).zip(&steps) {
            prop_assert_eq!(step.time.as_nanos(), first + k * STEP_NS);
            prop_assert!((step.increment.span_s - 0.0025).abs() < 1e-15);
        }
    }

    #[test]
    fn nothing_is_gained_or_lost(samples in any_stream()) {
        let mut grid = Grid::new(parameters());
        let mut sum = Increment::ZERO;
        for step in steps_of(&mut grid, &samples) {
            sum = total(&sum, &step.increment);
        }
        let sum = total(&sum, &grid.remainder());
        let exact = integral(&samples);
        prop_assert!((sum.span_s - exact.span_s).abs() < 1e-12);
        prop_assert!((sum.angle - exact.angle).length() < 1e-11, "{} {}", sum.angle, exact.angle);
        prop_assert!((sum.velocity - exact.velocity).length() < 1e-11);
    }

    #[test]
    fn the_same_samples_give_the_same_bits(samples in any_stream()) {
        let run = || {
            let mut grid = Grid::new(parameters());
            // The debug form tells 0.0 from -0.0 and prints every digit.
            std::format!("{:?} {:?}", steps_of(&mut grid, &samples), grid.remainder())
        };
        prop_assert_eq!(run(), run());
    }

    #[test]
    fn a_copy_continues_like_the_original(samples in any_stream(), cut in 0..60_usize) {
        let (before, after) = samples.split_at(cut.min(samples.len()));
        let mut grid = Grid::new(parameters());
        steps_of(&mut grid, before);
        let mut copy = grid;
        prop_assert_eq!(steps_of(&mut grid, after), steps_of(&mut copy, after));
        prop_assert_eq!(grid, copy);
    }

    #[test]
    fn the_field_arrives_as_seen_at_the_end_of_the_step(
        rate in vector(10.0),
        field in vector(60.0),
        spans in prop::collection::vec(300_000..9_000_000_i64, 2..60),
    ) {
        let seen_at = |nanos: i64| so3::exp(rate * (nanos as f64 * -1e-9)) * field;
        let mut nanos = 0;
        let samples: Vec<ImuSample> = spans.iter().map(|span| {
            nanos += span;
            ImuSample { mag: Some(Mag::new(seen_at(nanos))), ..sample(nanos, rate, DVec3::Z) }
        }).collect();
        for step in steps_of(&mut Grid::new(parameters()), &samples) {
            let Some(mag) = step.mag else { continue };
            let error = (mag.vector - seen_at(step.time.as_nanos())).length();
            prop_assert!(error < 1e-9, "off by {error} µT");
        }
    }

    #[test]
    fn no_time_stamp_makes_it_panic_or_run_away(
        mut stamps in prop::collection::vec(any_stamp(), 1..60),
    ) {
        stamps.sort_unstable();
        let mut grid = Grid::new(parameters());
        let bound = parameters().bridge_limit.as_nanos() / STEP_NS + 1;
        for nanos in stamps {
            let _ = grid.push(still(nanos));
            let mut count = 0;
            while let Some(step) = grid.next_step() {
                count += 1;
                prop_assert!(count <= bound, "more steps than the bridge is long");
                prop_assert!((step.increment.span_s - 0.0025).abs() < 1e-15);
            }
        }
    }
}

/// Stamps at both ends of the clock, around zero, and anywhere.
fn any_stamp() -> impl Strategy<Value = i64> {
    let near = 0..40 * STEP_NS;
    prop_oneof![
        near.clone().prop_map(|d| i64::MAX - d),
        near.clone().prop_map(|d| i64::MIN + d),
        near,
        Just(i64::MAX),
        any::<i64>(),
    ]
}

fn total(a: &Increment, b: &Increment) -> Increment {
    Increment {
        span_s: a.span_s + b.span_s,
        angle: a.angle + b.angle,
        velocity: a.velocity + b.velocity,
    }
}

/// The integral of what the samples stand for: means over the interval before each; straight lines
/// where samples are lost.
fn integral(samples: &[ImuSample]) -> Increment {
    let longest_ns = STEP_NS + STEP_NS / 2;
    samples.windows(2).fold(Increment::ZERO, |sum, pair| {
        let span = pair[1].time - pair[0].time;
        let lost = span.as_nanos() >= longest_ns;
        let mean = |from: DVec3, to: DVec3| if lost { 0.5 * (from + to) } else { to };
        let span_s = span.as_secs_f64();
        let part = Increment {
            span_s,
            angle: span_s * mean(pair[0].gyro.vector, pair[1].gyro.vector),
            velocity: span_s * mean(pair[0].accel.vector, pair[1].accel.vector),
        };
        total(&sum, &part)
    })
}

#[test]
fn every_reading_of_a_slow_magnetometer_arrives_once() {
    // Given readings with every eighth sample, when the stream jitters, then each comes through.
    let samples: Vec<ImuSample> = (0..400)
        .map(|k| {
            let nanos = k * STEP_NS + (k * 7_919 % 1_000) * 1_000;
            let mag = (k % 8 == 0).then(|| Mag::new(DVec3::new(k as f64, 0.0, 0.0)));
            ImuSample { mag, ..still(nanos) }
        })
        .collect();
    let fields: Vec<f64> = steps_of(&mut Grid::new(parameters()), &samples)
        .iter()
        .filter_map(|step| step.mag.map(|m| m.vector.x))
        .collect();
    let sent: Vec<f64> = (0..50).map(|k| f64::from(k) * 8.0).collect();
    assert_eq!(fields, sent);
}

#[test]
fn a_jittered_sinusoid_is_integrated_as_if_it_were_even() {
    let (amplitude, pulse) = (2.0, core::f64::consts::TAU * 5.0);
    let turned = |nanos: i64| -amplitude / pulse * libm::cos(pulse * nanos as f64 * 1e-9);
    let stamp = |k: i64| k * STEP_NS + (k * 104_729 % 1_500) * 1_000 / 2;
    let samples: Vec<ImuSample> = (0..2_000)
        .map(|k| {
            let (from, to) = (stamp(k - 1), stamp(k));
            let mean = (turned(to) - turned(from)) / ((to - from) as f64 * 1e-9);
            sample(to, DVec3::X * mean, DVec3::ZERO)
        })
        .collect();
    // At a stamp the sum is exact; between two, at most 3.25 ms apart, the mean strays from the
    // rate by its slope. Nothing adds up from step to step.
    let bound = amplitude * pulse * 0.00325 * 0.00325 / 8.0;
    let mut sum = turned(samples[0].time.as_nanos());
    for step in steps_of(&mut Grid::new(parameters()), &samples) {
        sum += step.increment.angle.x;
        let error = sum - turned(step.time.as_nanos());
        assert!(error.abs() < bound, "{error} at {:?}, allowed {bound}", step.time);
    }
}

#[test]
fn a_fast_sensor_is_summed_and_a_slow_one_divided() {
    for (spacing, expected) in [(STEP_NS / 5, 100), (STEP_NS * 3, 1_500)] {
        let samples: Vec<ImuSample> = (0..=500).map(|k| still(k * spacing)).collect();
        let steps = steps_of(&mut Grid::new(parameters()), &samples);
        assert_eq!(steps.len(), expected);
        for step in steps {
            assert!((step.increment.velocity - DVec3::Z * 9.81 * 0.0025).length() < 1e-14);
        }
    }
}

#[test]
fn lost_samples_are_counted_and_only_their_steps_are_flagged() {
    // Given an even stream, when samples 10, 11 and 12 are lost, then three are counted and the
    // steps between samples 9 and 13 are flagged.
    let mut grid = Grid::new(parameters());
    let mut flagged = Vec::new();
    for k in (0..30).filter(|k| !(10..13).contains(k)) {
        let accepted = grid.push(still(k * STEP_NS)).unwrap();
        match k {
            0 => assert_eq!(accepted, Accepted::First),
            13 => assert_eq!(accepted, Accepted::Continued { lost: 3 }),
            _ => assert_eq!(accepted, Accepted::Continued { lost: 0 }),
        }
        while let Some(step) = grid.next_step() {
            if step.bridged {
                flagged.push(step.time.as_nanos() / STEP_NS);
            }
        }
    }
    assert_eq!(flagged, [10, 11, 12, 13]);
}

#[test]
fn jitter_below_half_an_interval_loses_nothing() {
    let mut grid = Grid::new(parameters());
    grid.push(still(0)).unwrap();
    let late = STEP_NS + STEP_NS / 2 - 1;
    assert_eq!(grid.push(still(late)), Ok(Accepted::Continued { lost: 0 }));
    assert_eq!(grid.push(still(late + 2 * STEP_NS)), Ok(Accepted::Continued { lost: 1 }));
}

#[test]
fn a_gap_too_long_to_bridge_begins_a_new_grid() {
    let mut grid = Grid::new(parameters());
    let limit = parameters().bridge_limit.as_nanos();
    grid.push(still(0)).unwrap();
    assert_eq!(grid.push(still(limit)), Ok(Accepted::Continued { lost: 39 }));
    while grid.next_step().is_some() {}

    let after = limit + limit + 1;
    let span = SensorSpan::from_nanos(limit + 1);
    assert_eq!(grid.push(still(after)), Ok(Accepted::Gap { span, lost: 39 }));
    assert_eq!(grid.next_step(), None, "nothing is made up across the gap");
    assert_eq!(grid.remainder(), Increment::ZERO);

    grid.push(still(after + STEP_NS)).unwrap();
    let step = grid.next_step().expect("the new grid runs");
    assert_eq!(step.time.as_nanos(), after + STEP_NS);
    assert!(!step.bridged);
}

#[test]
fn the_gap_from_one_end_of_the_clock_to_the_other_is_survived() {
    let mut grid = Grid::new(parameters());
    grid.push(still(i64::MIN)).unwrap();
    let accepted = grid.push(still(i64::MAX / 2)).unwrap();
    assert!(matches!(accepted, Accepted::Gap { lost, .. } if lost > 1_000_000_000));
    assert_eq!(grid.next_step(), None);
}

#[test]
fn a_refused_sample_leaves_the_grid_as_it_was() {
    let mut grid = Grid::new(parameters());
    steps_of(&mut grid, &(0..10).map(|k| still(k * STEP_NS)).collect::<Vec<_>>());
    let before = grid;
    let good = still(10 * STEP_NS);
    let with_rate = |x: f64| ImuSample { gyro: Gyro::new(DVec3::new(0.0, x, 0.0)), ..good };
    let with_force = |x: f64| ImuSample { accel: Accel::new(DVec3::new(0.0, 0.0, x)), ..good };
    let with_mag = |x: f64| ImuSample { mag: Some(Mag::new(DVec3::new(x, 0.0, 0.0))), ..good };
    let cases = [
        (still(9 * STEP_NS), Refusal::Duplicate),
        (still(9 * STEP_NS - 1), Refusal::OutOfOrder),
        (still(i64::MIN), Refusal::OutOfOrder),
        (still(i64::MAX), Refusal::OutOfRange),
        (with_rate(f64::NAN), Refusal::NotFinite),
        (with_rate(f64::NEG_INFINITY), Refusal::NotFinite),
        (with_force(f64::INFINITY), Refusal::NotFinite),
        (with_mag(f64::NAN), Refusal::NotFinite),
        (with_rate(-100.1), Refusal::OutOfRange),
        (with_force(1e300), Refusal::OutOfRange),
        (with_mag(5000.1), Refusal::OutOfRange),
    ];
    for (sample, refusal) in cases {
        assert_eq!(grid.push(sample), Err(refusal));
        assert_eq!(grid, before);
        assert_eq!(grid.next_step(), None);
    }
    assert_eq!(grid.push(good), Ok(Accepted::Continued { lost: 0 }));
}

#[test]
fn saturation_marks_every_step_that_rests_on_the_sample() {
    // Given steps at half the sample interval, when sample 5 is saturated, then both lines that
    // meet in it are marked: four steps.
    let mut grid = Grid::new(GridParameters {
        step: SensorSpan::from_nanos(STEP_NS / 2),
        ..GridParameters::at_rate(400.0)
    });
    let samples: Vec<ImuSample> =
        (0..10).map(|k| ImuSample { saturated: k == 5, ..still(k * STEP_NS) }).collect();
    let marked: Vec<i64> = steps_of(&mut grid, &samples)
        .iter()
        .filter(|step| step.saturated)
        .map(|step| step.time.as_nanos() * 2 / STEP_NS)
        .collect();
    assert_eq!(marked, [9, 10, 11, 12]);
}

#[test]
fn a_reset_grid_is_a_new_one() {
    let mut grid = Grid::new(parameters());
    steps_of(&mut grid, &(0..5).map(|k| still(k * STEP_NS + k)).collect::<Vec<_>>());
    grid.reset();
    assert_eq!(grid, Grid::new(parameters()));
    assert_eq!(grid.push(still(0)), Ok(Accepted::First));
}

#[test]
fn aligned_grids_of_sensors_out_of_phase_coincide() {
    // Given two sensors on one clock, one at 400 Hz and one at 380 Hz and out of phase, when both are
    // gridded alike, then their steps end at the same instants and are whole.
    let parameters = GridParameters { aligned: true, ..GridParameters::at_rate(400.0) };
    let ends = |first_ns: i64, interval_ns: i64| {
        let mut grid = Grid::new(parameters);
        let mut ends = std::vec::Vec::new();
        for k in 0..100 {
            let time = SensorTime::from_nanos(first_ns + k * interval_ns);
            let sample = ImuSample {
                time,
                gyro: Gyro::new(DVec3::X),
                accel: Accel::new(DVec3::Z),
                mag: None,
                saturated: false,
            };
            grid.push(sample).unwrap();
            while let Some(step) = grid.next_step() {
                assert!((step.increment.span_s - 0.0025).abs() < 1e-12);
                assert!((step.increment.angle.x - 0.0025).abs() < 1e-12);
                ends.push(step.time.as_nanos());
            }
        }
        ends
    };
    let (one, other) = (ends(7_123_456, 2_500_000), ends(8_000_001, 2_631_579));
    assert!(one.iter().chain(&other).all(|end| end % 2_500_000 == 0));
    assert!(one.contains(&other[0]) && other.windows(2).all(|w| w[1] - w[0] == 2_500_000));
}
