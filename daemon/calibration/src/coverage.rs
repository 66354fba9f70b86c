//! Which movements were seen.

use glam::{DQuat, DVec3};

use crate::Sample;
use crate::levelling::Levelling;

/// The circle in parts of 5°.
const PARTS: usize = 72;
/// A camera that turns slower than this rests, rad/s: above any bias, below any movement by hand.
const REST_RATE: f64 = 0.03;

/// The movement of a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coverage {
    /// Usable samples, s.
    pub duration_s: f64,
    /// Part of the full circle of headings seen, degrees, 0 to 360.
    pub circle_deg: f64,
    /// Turns about the vertical, left and right alike, in whole turns.
    pub turns: f64,
    /// Tilt from the mean direction, root mean square, degrees.
    pub tilt_deg: f64,
    /// Longest rest, s.
    pub rest_s: f64,
    /// Readings of the magnetometer.
    pub mag_readings: usize,
}

/// Headings and tilts of a sequence of attitudes.
#[derive(Clone, Debug)]
pub(crate) struct Attitudes {
    seen: [bool; PARTS],
    last_heading: Option<f64>,
    turned_rad: f64,
    up: DVec3,
    count: f64,
}

impl Default for Attitudes {
    fn default() -> Self {
        Self {
            seen: [false; PARTS],
            last_heading: None,
            turned_rad: 0.0,
            up: DVec3::ZERO,
            count: 0.0,
        }
    }
}

impl Attitudes {
    /// Takes an attitude, sensor to a level frame.
    pub(crate) fn add(&mut self, attitude: DQuat) {
        let up = attitude.inverse() * DVec3::Z;
        self.up += up;
        self.count += 1.0;
        let heading = heading(attitude);
        let turned = self.last_heading.map_or(0.0, |last| wrapped(heading - last));
        self.turned_rad += turned.abs();
        self.mark(heading, turned);
        self.last_heading = Some(heading);
    }

    /// Marks all parts on the way to a heading.
    fn mark(&mut self, heading: f64, turned: f64) {
        let part = std::f64::consts::TAU / PARTS as f64;
        let between = (turned.abs() / part).ceil().max(1.0) as usize;
        for k in 0..between {
            let on_the_way = heading - turned * k as f64 / between as f64;
            let index = (on_the_way.rem_euclid(std::f64::consts::TAU) / part) as usize;
            self.seen[index.min(PARTS - 1)] = true;
        }
    }

    /// Mean direction of up in the sensor's axes.
    pub(crate) fn mean_up(&self) -> DVec3 {
        self.up.try_normalize().unwrap_or(DVec3::Z)
    }

    /// Degrees of the circle.
    pub(crate) fn circle_deg(&self) -> f64 {
        self.seen.iter().filter(|&&seen| seen).count() as f64 * 360.0 / PARTS as f64
    }

    /// Whole turns.
    pub(crate) fn turns(&self) -> f64 {
        self.turned_rad / std::f64::consts::TAU
    }

    /// Root mean square angle from the mean direction: `2 (1 − R̄)` is its mean square.
    pub(crate) fn tilt_deg(&self) -> f64 {
        let resultant = self.up.length() / f64::max(self.count, 1.0);
        (2.0 * (1.0 - resultant).max(0.0)).sqrt().to_degrees()
    }
}

/// A heading that does not jump as a tumbling sensor's axes pass the vertical: that of the shortest
/// way from its up to the vertical (the twist of the attitude about z).
fn heading(attitude: DQuat) -> f64 {
    2.0 * attitude.z.atan2(attitude.w)
}

fn wrapped(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle - turn * (angle / turn).round()
}

/// Follows the movement sample by sample, by gyroscope and accelerometer alone.
#[derive(Clone, Debug, Default)]
pub(crate) struct CoverageMeter {
    levelling: Option<Levelling>,
    attitudes: Attitudes,
    last_ns: Option<i64>,
    resting_s: f64,
    /// Mean rate of the longest rest: the gyroscope's bias.
    resting_rate: DVec3,
    coverage: Coverage,
}

impl CoverageMeter {
    /// Takes a sample; what is not finite or not later is left out.
    pub(crate) fn add(&mut self, sample: &Sample) {
        let dt_s = self.last_ns.map_or(0.0, |last| (sample.time_ns - last) as f64 * 1e-9);
        if !sample.is_finite() || (self.last_ns.is_some() && dt_s <= 0.0) {
            return;
        }
        self.last_ns = Some(sample.time_ns);
        self.coverage.duration_s += dt_s;
        self.coverage.mag_readings += usize::from(sample.mag_ut.is_some());
        let levelling = self.levelling.get_or_insert_with(|| Levelling::start(sample.accel_m_s2));
        levelling.step(dt_s, sample.gyro_rad_s - self.resting_rate, sample.accel_m_s2);
        let attitude = levelling.attitude;
        self.rest(dt_s, sample.gyro_rad_s);
        self.attitudes.add(attitude);
    }

    fn rest(&mut self, dt_s: f64, rate: DVec3) {
        if rate.length() > REST_RATE {
            self.resting_s = 0.0;
            return;
        }
        self.resting_s += dt_s;
        self.coverage.rest_s = self.coverage.rest_s.max(self.resting_s);
        if self.resting_s > 1.0 {
            self.resting_rate += (rate - self.resting_rate) * dt_s.min(1.0);
        }
    }

    /// The movement so far.
    pub(crate) fn coverage(&self) -> Coverage {
        Coverage { ..self.with(&self.attitudes) }
    }

    /// The movement so far, with attitudes that are known better.
    pub(crate) fn with(&self, attitudes: &Attitudes) -> Coverage {
        Coverage {
            circle_deg: attitudes.circle_deg(),
            turns: attitudes.turns(),
            tilt_deg: attitudes.tilt_deg(),
            ..self.coverage
        }
    }
}
