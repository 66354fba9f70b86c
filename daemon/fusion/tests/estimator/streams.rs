//! Whatever a sensor sends, what comes out is finite, of unit length and has a covariance.

use glam::DVec3;
use lodestone_fusion::{
    ACCEL_BIAS, Accel, Accepted, Block, Covariance, DEVIATION, Estimator, GYRO_BIAS, Grid,
    GridParameters, Gyro, HeadingMode, ImuSample, LEAKY_VELOCITY, Mag, ORIENTATION, POSITION,
    Parameters, SensorTime, VELOCITY,
};
use proptest::prelude::*;

const STEP_NS: i64 = 2_500_000;

/// Numbers of every kind: usual, huge, tiny, and none at all.
fn any_number(usual: f64) -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -usual..usual,
        2 => -40.0 * usual..40.0 * usual,
        1 => prop_oneof![
            Just(0.0),
            Just(f64::NAN),
            Just(f64::INFINITY),
            Just(-1e308),
            Just(1e-308),
            any::<f64>(),
        ],
    ]
}

fn any_vector(usual: f64) -> impl Strategy<Value = DVec3> {
    (any_number(usual), any_number(usual), any_number(usual)).prop_map(DVec3::from)
}

/// Steps in time: usual, repeated, backwards, long.
fn any_span() -> impl Strategy<Value = i64> {
    prop_oneof![
        20 => STEP_NS / 2..STEP_NS * 2,
        2 => -STEP_NS..1,
        2 => STEP_NS..100 * STEP_NS,
        1 => prop_oneof![Just(3_600_000_000_000), Just(86_400_000_000_000), any::<i64>()],
    ]
}

fn any_sample() -> impl Strategy<Value = (i64, ImuSample)> {
    let mag = prop::option::weighted(0.2, any_vector(60.0));
    (any_span(), any_vector(2.0), any_vector(20.0), mag, any::<bool>()).prop_map(
        |(span, rate, force, mag, saturated)| {
            let time = SensorTime::from_nanos(0);
            let (gyro, accel) = (Gyro::new(rate), Accel::new(force));
            (span, ImuSample { time, gyro, accel, mag: mag.map(Mag::new), saturated })
        },
    )
}

/// A second and a half of rest, so that there is a state to spoil.
fn rest() -> Vec<(i64, ImuSample)> {
    let sample = |k: i64| ImuSample {
        time: SensorTime::from_nanos(0),
        gyro: Gyro::new(DVec3::ZERO),
        accel: Accel::new(DVec3::Z * 9.81),
        mag: (k % 8 == 0).then(|| Mag::new(DVec3::new(0.0, 22.0, -42.0))),
        saturated: false,
    };
    (0..600).map(|k| (STEP_NS, sample(k))).collect()
}

/// Grid and estimator as a lane runs them.
struct Lane {
    grid: Grid,
    estimator: Estimator,
    nanos: i64,
}

impl Lane {
    fn new(heading: HeadingMode) -> Self {
        let parameters = Parameters { heading, ..Parameters::default() };
        Self {
            grid: Grid::new(GridParameters::at_rate(400.0)),
            estimator: Estimator::new(parameters),
            nanos: 0,
        }
    }

    fn take(&mut self, (span, sample): (i64, ImuSample)) {
        let nanos = self.nanos.saturating_add(span);
        let sample = ImuSample { time: SensorTime::from_nanos(nanos), ..sample };
        let Ok(accepted) = self.grid.push(sample) else { return };
        self.nanos = nanos;
        if let Accepted::Gap { span, .. } = accepted {
            self.estimator.cross_gap(span);
        }
        while let Some(step) = self.grid.next_step() {
            self.estimator.step(&step);
        }
    }

    fn check(&self) {
        let Some(state) = self.estimator.state() else { return };
        assert!(state.is_finite(), "{state:?}");
        let estimate = self.estimator.estimate_ahead(&self.grid.remainder()).expect("finite");
        let norm = estimate.orientation.quaternion().length();
        assert!((norm - 1.0).abs() < 1e-9, "{norm}");
        assert!(estimate.position.is_finite() && estimate.velocity.is_finite());
        assert!(estimate.angular_rate.is_finite() && estimate.specific_force.is_finite());
        check_covariance(&state.covariance);
    }
}

/// Every block on the diagonal is positive, and no two states correlate by more than one.
fn check_covariance(p: &Covariance) {
    const BLOCKS: [Block; 6] =
        [ORIENTATION, VELOCITY, POSITION, GYRO_BIAS, ACCEL_BIAS, LEAKY_VELOCITY];
    assert!(p.variance(DEVIATION) > 0.0);
    for i in BLOCKS {
        let (variances, own) = (p.variances(i), p.block(i, i));
        assert!(variances.min_element() > 0.0, "{i:?}: {variances}");
        assert_eq!(own, own.transpose());
        for j in BLOCKS {
            let others = p.variances(j);
            let cross = p.block(i, j);
            for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                let limit = (variances[r] * others[c]).sqrt() * (1.0 + 1e-6) + 1e-15;
                assert!(cross.col(c)[r].abs() <= limit, "{i:?} {j:?} {r} {c}: {cross} {limit}");
            }
        }
    }
}

fn any_mode() -> impl Strategy<Value = HeadingMode> {
    prop_oneof![
        Just(HeadingMode::Continuous),
        Just(HeadingMode::Adaptive),
        Just(HeadingMode::InitialOnly),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_stream_gives_finite_estimates(
        mode in any_mode(),
        samples in prop::collection::vec(any_sample(), 1..300),
    ) {
        let mut lane = Lane::new(mode);
        for sample in rest().into_iter().chain(samples).chain(rest()) {
            lane.take(sample);
            lane.check();
        }
    }

    #[test]
    fn the_same_stream_gives_the_same_bits(
        samples in prop::collection::vec(any_sample(), 1..100),
    ) {
        let run = || {
            let mut lane = Lane::new(HeadingMode::Adaptive);
            rest().into_iter().chain(samples.iter().copied()).for_each(|s| lane.take(s));
            format!("{:?} {:?}", lane.grid, lane.estimator)
        };
        prop_assert_eq!(run(), run());
    }
}

#[test]
fn the_wildest_minute_a_sensor_can_report_is_survived() {
    // Full scale on every axis, alternating, with a field to match, for a minute.
    let mut lane = Lane::new(HeadingMode::Continuous);
    for sample in rest() {
        lane.take(sample);
    }
    for k in 0..24_000_i64 {
        let sign = if k % 7 < 4 { 1.0 } else { -1.0 };
        let sample = ImuSample {
            time: SensorTime::from_nanos(0),
            gyro: Gyro::new(DVec3::splat(100.0 * sign)),
            accel: Accel::new(DVec3::splat(-1000.0 * sign)),
            mag: Some(Mag::new(DVec3::new(5000.0 * sign, -5000.0, 0.0))),
            saturated: true,
        };
        lane.take((STEP_NS, sample));
        if k % 50 == 0 {
            lane.check();
        }
    }
}
