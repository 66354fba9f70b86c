use glam::DVec3;
use lodestone_fusion::{Parameters, SensorSpan};

use super::*;

const STEP_NS: i64 = 5_000_000;
/// As hard as a foot swings.
const PUSH_M_S2: f64 = 30.0;

/// Half a second of pushing along x before the camera stands still at sample 100, and stays.
fn pushed(n: i64) -> ImuSample {
    let moves = (1..=100).contains(&n);
    let phase = n as f64 * 0.01 * std::f64::consts::TAU;
    let push = if moves { DVec3::X * PUSH_M_S2 * phase.sin() } else { DVec3::ZERO };
    ImuSample {
        time: SensorTime::from_nanos(n * STEP_NS),
        gyro: Gyro::new(DVec3::ZERO),
        accel: Accel::new(push + DVec3::Z * 9.81),
        mag: None,
        saturated: false,
    }
}

fn held(sample: ImuSample) -> HeldRow {
    HeldRow { time: sample.time, status: Status::empty(), sample: Some(sample) }
}

/// Rows up to the alignment of a foot's sensor with poses, and the estimator then.
fn looked_back(
    samples: impl Iterator<Item = ImuSample>,
) -> (Vec<(HeldRow, Option<Estimate>)>, Estimator) {
    let parameters = GridParameters::at_rate(200.0);
    let (mut grid, mut hindsight) = (Grid::new(parameters), Hindsight::default());
    let mut estimator = Estimator::new(Parameters::foot_mounted());
    for sample in samples {
        if let Ok(Accepted::Gap { span, .. }) = grid.push(sample) {
            estimator.cross_gap(span);
        }
        while let Some(step) = grid.next_step() {
            estimator.step(&step);
        }
        if let Some(now) = estimator.estimate() {
            let back = estimator.reversed().unwrap();
            return (hindsight.look_back((back, now.time), &sample, parameters), estimator);
        }
        assert_eq!(hindsight.hold(held(sample)), None, "there is room");
    }
    panic!("never aligned");
}

#[test]
fn the_way_before_the_alignment_is_found() {
    // Given a camera that was pushed forward by 1.2 m before it stood, when it is aligned, then the
    // first row lies that far behind, where it began to move at speed zero.
    let (rows, estimator) = looked_back((0..200).map(pushed));
    assert!(rows.len() > 100, "{} rows", rows.len());
    let first = rows[0].1.unwrap();
    let way = -first.position;
    // Of a push P sin(τ t / T) over T = 0.5 s, the way is P T² / τ, and the highest speed 2 P T / τ.
    let truth = PUSH_M_S2 * 0.25 / std::f64::consts::TAU;
    assert!((way.x - truth).abs() < 0.01 * truth, "{way} instead of {truth} m");
    assert!(way.y.abs() + way.z.abs() < 0.02, "{way}");
    assert!(first.velocity.length() < 0.05, "{}", first.velocity);
    let middle = rows[50].1.unwrap();
    assert!((middle.velocity.x - 4.0 * truth).abs() < 0.05, "{}", middle.velocity);
    // The latest is where the estimator is, and the first the least certain.
    let (last, now) = (rows[rows.len() - 1].1.unwrap(), estimator.estimate().unwrap());
    assert!((last.position - now.position).length() < 1e-4);
    assert!(first.position_covariance.x_axis.x > last.position_covariance.x_axis.x);
    assert_eq!(last.time, rows[rows.len() - 1].0.time);
}

#[test]
fn before_a_gap_nothing_is_known() {
    let (rows, _) = looked_back((0..60).chain(150..300).map(pushed));
    let (before, after): (Vec<_>, Vec<_>) =
        rows.iter().partition(|(row, _)| row.time < SensorTime::from_nanos(150 * STEP_NS));
    assert_eq!(before.len(), 60);
    assert!(before.iter().all(|(_, pose)| pose.is_none()));
    assert!(!after.is_empty() && after.iter().all(|(_, pose)| pose.is_some()));
}

#[test]
fn a_refused_row_has_the_pose_of_the_row_before() {
    let refused = |row: HeldRow| HeldRow { sample: None, ..row };
    let rows: Vec<HeldRow> = (0..3).map(|n| held(pushed(n))).collect();
    let rows = [refused(rows[0]), rows[1], refused(rows[2])];
    let (_, estimator) = looked_back((100..300).map(pushed));
    let pose = estimator.estimate();
    let mut poses = [None, pose, None];
    keep_over_refused(&rows, &mut poses);
    assert_eq!(poses, [None, pose, pose]);
}

#[test]
fn memory_is_bounded_and_the_oldest_row_is_let_go() {
    let mut hindsight = Hindsight::default();
    let many = i64::try_from(HELD_ROWS).unwrap();
    let row = |n: i64| held(pushed(n));
    for n in 0..many {
        assert_eq!(hindsight.hold(row(n)), None);
    }
    assert_eq!(hindsight.hold(row(many)), Some(row(0)));
    assert_eq!(hindsight.give_up().count(), HELD_ROWS);
    assert!(hindsight.is_empty());
    let span = SensorSpan::from_nanos(STEP_NS * many);
    assert!(span.as_secs_f64() > 120.0, "two minutes at 200 Hz, one at 400 Hz");
}
