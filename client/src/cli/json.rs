//! A pose as a JSON object, and as a line to read.

use lodestone_client::{CameraPose, Origin};
use serde::Serialize;

use super::describe::{bits, code};

/// One pose; `null` stands for what is unknown.
#[derive(Debug, Serialize)]
pub(super) struct PoseLine<'a> {
    camera: &'a str,
    sequence: u64,
    camera_id: u32,
    reset_counter: u32,
    world_epoch: Option<u32>,
    origin: &'static str,
    predicted_ahead_ns: Option<i64>,
    time_ns: i64,
    unix_time_ns: i64,
    sensor_time_ns: i64,
    arrival_time_ns: i64,
    ring_time_ns: i64,
    published_time_ns: i64,
    position_m: Option<[f64; 3]>,
    velocity_m_s: Option<[f64; 3]>,
    orientation_xyzw: Option<[f64; 4]>,
    heading_deg: Option<f64>,
    heading_sigma_deg: Option<f64>,
    angular_rate_rad_s: Option<[f64; 3]>,
    specific_force_m_s2: Option<[f64; 3]>,
    position_covariance_m2: Option<[f64; 6]>,
    velocity_covariance_m2_s2: Option<[f64; 6]>,
    orientation_covariance_rad2: Option<[f64; 6]>,
    heading_source: String,
    position_source: String,
    aids_used: Vec<String>,
    aids_refused: Vec<String>,
    status: Vec<String>,
    valid: Vec<String>,
}

impl<'a> PoseLine<'a> {
    pub(super) fn new(camera: &'a str, pose: &CameraPose) -> Self {
        let message = pose.message();
        let (origin, predicted_ahead_ns) = origin(pose.origin());
        Self {
            camera,
            sequence: pose.sequence(),
            camera_id: pose.camera_id(),
            reset_counter: pose.reset_counter(),
            world_epoch: Some(pose.world_epoch()).filter(|&epoch| epoch > 0),
            origin,
            predicted_ahead_ns,
            time_ns: pose.time_ns(),
            unix_time_ns: pose.unix_time_ns(),
            sensor_time_ns: message.sensor_time_ns,
            arrival_time_ns: message.arrival_time_ns,
            ring_time_ns: message.ring_time_ns,
            published_time_ns: message.published_time_ns,
            position_m: pose.position_m().map(|v| v.to_array()),
            velocity_m_s: pose.velocity_m_s().map(|v| v.to_array()),
            orientation_xyzw: pose.orientation().map(|r| r.quaternion().to_array()),
            heading_deg: pose.heading().map(lodestone_client::Heading::compass_deg),
            heading_sigma_deg: pose.heading().map(|h| h.sigma_rad.to_degrees()),
            angular_rate_rad_s: pose.angular_rate_rad_s().map(|v| v.to_array()),
            specific_force_m_s2: pose.specific_force_m_s2().map(|v| v.to_array()),
            position_covariance_m2: pose
                .position_covariance_m2()
                .map(|_| message.position_covariance_m2),
            velocity_covariance_m2_s2: pose
                .velocity_covariance_m2_s2()
                .map(|_| message.velocity_covariance_m2_s2),
            orientation_covariance_rad2: pose
                .orientation_covariance_rad2()
                .map(|_| message.orientation_covariance_rad2),
            heading_source: code(pose.heading_source()),
            position_source: code(pose.position_source()),
            aids_used: bits(pose.aids_used()),
            aids_refused: bits(pose.aids_refused()),
            status: bits(pose.status()),
            valid: bits(pose.validity()),
        }
    }

    /// One line for people.
    pub(super) fn to_text(&self) -> String {
        let how = match self.predicted_ahead_ns {
            Some(ns) => format!("predicted {} ms ahead", ns as f64 * 1e-6),
            None => self.origin.to_owned(),
        };
        format!(
            "{} #{} {:.6} s {how}  position {}  velocity {}  orientation {} xyzw  heading {}  {}",
            self.camera,
            self.sequence,
            self.time_ns as f64 * 1e-9,
            with_unit(self.position_m.as_ref(), "m"),
            with_unit(self.velocity_m_s.as_ref(), "m/s"),
            numbers(self.orientation_xyzw.as_ref(), 5),
            heading(self.heading_deg, self.heading_sigma_deg),
            self.status.join(" "),
        )
    }
}

/// `123.4° ± 0.5°`, clockwise from north.
pub(super) fn heading(degrees: Option<f64>, sigma_deg: Option<f64>) -> String {
    match (degrees, sigma_deg) {
        (Some(degrees), Some(sigma)) => format!("{degrees:.1}° ± {sigma:.1}°"),
        _ => "unknown".into(),
    }
}

/// `[1.000 2.000 3.000] m`.
fn with_unit(values: Option<&[f64; 3]>, unit: &str) -> String {
    values.map_or_else(|| "unknown".into(), |_| format!("{} {unit}", numbers(values, 3)))
}

/// `[1.000 2.000 3.000]`.
pub(super) fn numbers<const N: usize>(values: Option<&[f64; N]>, decimals: usize) -> String {
    match values {
        Some(values) => {
            let texts: Vec<String> = values.iter().map(|v| format!("{v:.decimals$}")).collect();
            format!("[{}]", texts.join(" "))
        }
        None => "unknown".into(),
    }
}

fn origin(origin: Origin) -> (&'static str, Option<i64>) {
    match origin {
        Origin::Published => ("published", None),
        Origin::Interpolated => ("interpolated", None),
        Origin::Predicted { ahead_ns } => ("predicted", Some(ahead_ns)),
    }
}
