//! A message to send where its content does not matter.

use lodestone_schema::Pose;

/// A pose of which nothing is known.
pub const fn empty_pose() -> Pose {
    Pose {
        sequence: 0,
        camera_id: 0,
        reset_counter: 0,
        status: 0,
        validity: 0,
        heading_source: 0,
        position_source: 0,
        aids_used: 0,
        aids_refused: 0,
        world_epoch: 0,
        sensor_time_ns: 0,
        time_ns: 0,
        arrival_time_ns: 0,
        ring_time_ns: 0,
        step_start_time_ns: 0,
        step_end_time_ns: 0,
        published_time_ns: 0,
        unix_offset_ns: 0,
        position_m: [f64::NAN; 3],
        velocity_m_s: [f64::NAN; 3],
        orientation: [f64::NAN; 4],
        angular_rate_rad_s: [f64::NAN; 3],
        specific_force_m_s2: [f64::NAN; 3],
        position_covariance_m2: [f64::NAN; 6],
        velocity_covariance_m2_s2: [f64::NAN; 6],
        orientation_covariance_rad2: [f64::NAN; 6],
    }
}
