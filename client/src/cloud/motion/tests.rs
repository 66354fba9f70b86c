use core::f64::consts::PI;

use glam::{DQuat, DVec3, Vec3};
use lodestone_schema::{Pose, Validity};
use proptest::prelude::*;

use super::{KNOT_STEP_NS, MOST_OFFSET_NS, Motion, MotionError};
use crate::cloud::Lens;
use crate::error::LookupError;
use crate::frame::{Body, Optical};
use crate::history::History;
use crate::limits::LookupLimits;
use crate::pose::CameraPose;
use crate::pose::samples::{checked, still};
use crate::time::Time;
use crate::transform::Transform;

const CLOUD_NS: i64 = 10_000_000_000;
const STEP_NS: i64 = 2_500_000;

/// A camera far out that turns about up and moves on.
fn turning(time_ns: i64, rate_rad_s: f64) -> Pose {
    let t = (time_ns - CLOUD_NS) as f64 * 1e-9;
    let velocity = DVec3::new(3.0, -1.0, 0.2);
    Pose {
        position_m: (DVec3::new(20_000.0, -8_000.0, 30.0) + velocity * t).to_array(),
        velocity_m_s: velocity.to_array(),
        orientation: DQuat::from_rotation_z(1.0 + rate_rad_s * t).to_array(),
        angular_rate_rad_s: [0.0, 0.0, rate_rad_s],
        ..still((time_ns / STEP_NS) as u64, time_ns)
    }
}

fn history(rate_rad_s: f64) -> History {
    let mut history = History::new(1000, LookupLimits::default());
    for step in -200..200 {
        history.push(checked(turning(CLOUD_NS + step * STEP_NS, rate_rad_s)));
    }
    history
}

fn motion_in(history: &History, span_ns: (i64, i64)) -> Result<Motion, MotionError> {
    let lens: Transform<Body, Optical> = Lens::AT_IMU.body_from_optical;
    Motion::over(CLOUD_NS, span_ns, lens, |time, fields| history.lookup_with(time, fields))
}

proptest! {
    #[test]
    fn a_point_lands_where_the_pose_at_its_own_time_puts_it(
        rate_rad_s in -10.0..10.0_f64,
        first_ns in -30_000_000..0_i64,
        span_ns in 1..66_000_000_i64,
        share in 0.0..=1.0_f64,
        point in prop::array::uniform3(-5.0..5.0_f32),
    ) {
        let motion = motion_in(&history(rate_rad_s), (first_ns, first_ns + span_ns)).unwrap();
        let offset_ns = first_ns + (span_ns as f64 * share) as i64;
        let pose = checked(turning(CLOUD_NS + offset_ns, rate_rad_s));
        let lens = Lens::AT_IMU.body_from_optical;
        let world_from_optical = pose.world_from_body().unwrap() * lens;
        let expected = world_from_optical.apply(Vec3::from_array(point).as_dvec3());
        let placed = motion.at(offset_ns as i32).apply(Vec3::from_array(point));
        let error_m = (motion.origin_m() + placed.as_dvec3()).distance(expected);
        // θ²/8 of the distance, and f32.
        let bend_rad = rate_rad_s * KNOT_STEP_NS as f64 * 1e-9;
        prop_assert!(error_m < 8.7 * bend_rad.powi(2) / 8.0 + 1e-5, "{error_m} m");
    }
}

#[test]
fn a_hostile_span_is_looked_up_at_few_instants() {
    let history = history(1.0);
    let mut lookups = 0;
    let lens = Lens::AT_IMU.body_from_optical;
    let span = (i64::from(i32::MIN), i64::from(i32::MAX));
    let motion = Motion::over(CLOUD_NS, span, lens, |time, fields| {
        lookups += 1;
        history.lookup_with(time, fields)
    })
    .unwrap();
    assert_eq!(lookups, 2 + 2 * MOST_OFFSET_NS / KNOT_STEP_NS);
    for offset in [i32::MIN, i32::MAX] {
        assert!(motion.at(offset).apply(Vec3::ONE).is_finite());
    }
}

#[test]
fn without_times_of_points_there_is_one_place_for_all() {
    let motion = motion_in(&history(2.0 * PI), (0, 0)).unwrap();
    assert_eq!(motion.at(0), motion.at(5_000_000));
}

#[test]
fn a_cloud_seen_across_a_reset_has_no_motion() {
    // Given a filter that began anew between the lookups of one cloud
    let lens = Lens::AT_IMU.body_from_optical;
    let lookup = |time: Time, _: Validity| -> Result<CameraPose, LookupError> {
        let time_ns = time.to_monotonic_ns(0);
        let reset_counter = u32::from(time_ns > CLOUD_NS + 5_000_000);
        Ok(checked(Pose { reset_counter, ..turning(time_ns, 0.0) }))
    };
    let broken = Motion::over(CLOUD_NS, (0, 10_000_000), lens, lookup);
    assert!(matches!(broken, Err(MotionError::Broken)), "{broken:?}");
}

#[test]
fn a_pose_without_heading_places_nothing() {
    let mut history = History::new(10, LookupLimits::default());
    let validity = Validity::all().difference(Validity::HEADING).bits();
    history.push(checked(Pose { validity, ..still(1, CLOUD_NS) }));
    let refused = motion_in(&history, (0, 0));
    assert!(matches!(refused, Err(MotionError::Lookup(LookupError::NotValid(_)))), "{refused:?}");
}
