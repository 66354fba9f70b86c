//! The nominal state and the meaning of the error state around it.

use glam::{DMat3, DQuat, DVec3};

use crate::covariance::{
    ACCEL_BIAS, Block, Covariance, DEVIATION, GYRO_BIAS, LEAKY_VELOCITY, MAG_DELAY, MOUNTING,
    ORIENTATION, POSITION, Row, SPEED_SCALE, STATES, VELOCITY,
};
use crate::drift::Drift;
use crate::frame::{Body, Rotation, World};
use crate::so3;
use crate::tie::Tie;
use crate::time::SensorTime;

/// The estimate: nominal values, and the covariance of the error around them.
///
/// The orientation error turns about the world axes (`R_true = Exp(δθ) R`), so that its third
/// component is the heading error whatever the attitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Body to world.
    pub(crate) orientation: DQuat,
    /// Velocity in the world, m/s.
    pub velocity: DVec3,
    /// Position in the world, m.
    pub position: DVec3,
    /// Gyroscope bias in the body, rad/s.
    pub gyro_bias: DVec3,
    /// Accelerometer bias in the body, m/s².
    pub accel_bias: DVec3,
    /// Leaky integral of the acceleration in the world, m/s: what levelling looks at.
    pub leaky_velocity: DVec3,
    /// Angle by which the local field's north lies east of the world's north, rad.
    pub deviation: f64,
    /// How much older a magnetometer reading is than the sample it comes with, s.
    pub mag_delay_s: f64,
    /// Turn of a vehicle's axes against where its camera's mounting has them, about their y and z, rad.
    pub mounting_rad: [f64; 2],
    /// How much too fast a vehicle's speed reads, as a part of it.
    pub speed_scale: f64,
    /// Covariance of the error state.
    pub covariance: Covariance,
    /// What the errors have in common with another camera's.
    pub(crate) tie: Option<Tie>,
    /// How far they have moved on.
    pub(crate) drift: Drift,
}

impl State {
    /// At rest in an attitude, at the origin, without bias, deviation and uncertainty.
    pub(crate) const fn at(orientation: DQuat) -> Self {
        Self {
            orientation,
            velocity: DVec3::ZERO,
            position: DVec3::ZERO,
            gyro_bias: DVec3::ZERO,
            accel_bias: DVec3::ZERO,
            leaky_velocity: DVec3::ZERO,
            deviation: 0.0,
            mag_delay_s: 0.0,
            mounting_rad: [0.0; 2],
            speed_scale: 0.0,
            covariance: Covariance::ZERO,
            tie: None,
            drift: Drift::new(SensorTime::from_nanos(0)),
        }
    }

    /// Body to world.
    pub fn orientation(&self) -> Rotation<World, Body> {
        Rotation::from_unit(self.orientation)
    }

    /// Rotation matrix, body to world.
    pub(crate) fn matrix(&self) -> DMat3 {
        DMat3::from_quat(self.orientation)
    }

    /// Corrects by one scalar measurement with row `h` and a gain, whose `P h` and innovation variance `s`
    /// are given, where that gain is the optimal one.
    pub(crate) fn learn(&mut self, h: &Row, ph: &Row, s: f64) {
        if let Some(tie) = &mut self.tie {
            tie.learn(h, &ph.map(|x| x / s));
        }
        self.covariance.deflate(ph, s);
    }

    /// The same with any gain.
    pub(crate) fn learn_by(&mut self, h: &Row, ph: &Row, gain: &Row, s: f64) {
        if let Some(tie) = &mut self.tie {
            tie.learn(h, gain);
        }
        self.covariance.update_with_gain(ph, gain, s);
    }

    /// Whether an anchor's error is held in common: what the camera measures for itself corrects its own part.
    pub(crate) fn is_held(&self) -> bool {
        self.tie.as_ref().is_some_and(Tie::holds)
    }

    /// Of `P h` what a correction may count: all of it, but of a camera that is held to its anchor only what
    /// is its own.
    pub(crate) fn own_part(&self, h: &Row, ph: &Row) -> Row {
        match &self.tie {
            Some(tie) if tie.holds() => tie.without_anchor(h, ph),
            _ => *ph,
        }
    }

    /// From here on nothing compares with what was before: the state was put elsewhere.
    pub(crate) const fn cut(&mut self, now: SensorTime) {
        self.tie = None;
        self.drift = Drift::new(now);
    }

    /// Adds an estimated error to the nominal state: `x ⊞ δ`.
    pub(crate) fn correct(&mut self, error: &Row) {
        self.drift.correct(error);
        let part = |b: Block| DVec3::new(error[b.0], error[b.0 + 1], error[b.0 + 2]);
        let turned = so3::exp(part(ORIENTATION)) * self.orientation;
        self.orientation = so3::renormalise(turned);
        self.velocity += part(VELOCITY);
        self.position += part(POSITION);
        self.gyro_bias += part(GYRO_BIAS);
        self.accel_bias += part(ACCEL_BIAS);
        self.leaky_velocity += part(LEAKY_VELOCITY);
        self.deviation += error[DEVIATION];
        self.mag_delay_s += error[MAG_DELAY];
        self.mounting_rad[0] += error[MOUNTING];
        self.mounting_rad[1] += error[MOUNTING + 1];
        self.speed_scale += error[SPEED_SCALE];
    }

    /// The error that leads from another state to this one: `self = other ⊞ δ`, in the units and
    /// order of the error states. The orientation's part is at most half a turn long.
    pub fn error_from(&self, other: &Self) -> Row {
        let mut error = [0.0; STATES];
        let mut put = |b: Block, v: DVec3| error[b.0..b.0 + 3].copy_from_slice(&v.to_array());
        put(ORIENTATION, so3::log(self.orientation * other.orientation.conjugate()));
        put(VELOCITY, self.velocity - other.velocity);
        put(POSITION, self.position - other.position);
        put(GYRO_BIAS, self.gyro_bias - other.gyro_bias);
        put(ACCEL_BIAS, self.accel_bias - other.accel_bias);
        put(LEAKY_VELOCITY, self.leaky_velocity - other.leaky_velocity);
        error[DEVIATION] = self.deviation - other.deviation;
        error[MAG_DELAY] = self.mag_delay_s - other.mag_delay_s;
        error[MOUNTING] = self.mounting_rad[0] - other.mounting_rad[0];
        error[MOUNTING + 1] = self.mounting_rad[1] - other.mounting_rad[1];
        error[SPEED_SCALE] = self.speed_scale - other.speed_scale;
        error
    }

    /// Turns the whole world about up by an angle, rad, and takes the heading for known with a
    /// variance, rad²; `deviation_variance` of it is the compass deviation's, with opposite sign.
    pub(crate) fn turn_world(&mut self, angle: f64, variance: f64, deviation_variance: f64) {
        let turn = so3::exp(DVec3::Z * angle);
        self.orientation = so3::renormalise(turn * self.orientation);
        self.velocity = turn * self.velocity;
        self.position = turn * self.position;
        self.leaky_velocity = turn * self.leaky_velocity;
        self.deviation = 0.0;
        let turn = DMat3::from_quat(turn);
        for block in [ORIENTATION, VELOCITY, POSITION, LEAKY_VELOCITY] {
            self.covariance.rotate(block, turn);
        }
        let heading = ORIENTATION.0 + 2;
        self.covariance.forget(heading, variance);
        self.covariance.forget(DEVIATION, deviation_variance);
        self.covariance.set(heading, DEVIATION, -deviation_variance);
    }

    /// Turns all but the place about up by an angle, rad, and takes the heading for known with a variance,
    /// rad².
    pub(crate) fn turn_heading(&mut self, angle: f64, variance: f64) {
        let turn = so3::exp(DVec3::Z * angle);
        self.orientation = so3::renormalise(turn * self.orientation);
        self.velocity = turn * self.velocity;
        self.leaky_velocity = turn * self.leaky_velocity;
        for block in [ORIENTATION, VELOCITY, LEAKY_VELOCITY] {
            self.covariance.rotate(block, DMat3::from_quat(turn));
        }
        self.covariance.forget(ORIENTATION.0 + 2, variance);
    }

    /// The same state in a time that runs backwards: what is a rate changes its sign.
    pub(crate) fn reversed(&self) -> Self {
        let mut reversed = Self {
            velocity: -self.velocity,
            leaky_velocity: -self.leaky_velocity,
            gyro_bias: -self.gyro_bias,
            tie: None,
            ..*self
        };
        for block in [VELOCITY, LEAKY_VELOCITY, GYRO_BIAS] {
            reversed.covariance.rotate(block, -DMat3::IDENTITY);
        }
        reversed
    }

    /// Whether every number in it is finite.
    pub fn is_finite(&self) -> bool {
        self.has_finite_values() && self.covariance.is_finite()
    }

    /// Whether every number in it but the covariance is finite.
    pub(crate) fn has_finite_values(&self) -> bool {
        // NaN and infinity survive every sum.
        let vectors = self.velocity
            + self.position
            + self.gyro_bias
            + self.accel_bias
            + self.leaky_velocity
            + self.orientation.xyz();
        let numbers = self.orientation.w
            + self.deviation
            + self.mag_delay_s
            + self.mounting_rad[0]
            + self.mounting_rad[1]
            + self.speed_scale;
        (vectors.element_sum() + numbers).is_finite()
    }
}
