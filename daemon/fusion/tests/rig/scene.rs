//! Cameras on a rig that walks past steel, and the filter that follows it.

use glam::{DMat3, DQuat, DVec3};
use lodestone_fusion::rig::{
    Geometry, MAX_MEMBERS, Mounting, RigEstimator, RigParameters, RigReport,
};
use lodestone_fusion::{Increment, Mag, Parameters, Rotation, SensorTime, Step, so3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use crate::steel::{self, Dipole};
use crate::walk::Walk;

/// Span of a step, s.
pub(crate) const DT: f64 = 0.0025;
/// Every so many steps a magnetometer gives a reading: 50 Hz.
const STEPS_PER_MAG: u64 = 8;

/// A portable seeded generator of normal numbers.
#[derive(Clone)]
pub(crate) struct Normal(ChaCha8Rng);

impl Normal {
    pub(crate) fn seeded(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub(crate) fn number(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    pub(crate) fn vector(&mut self, sigma: f64) -> DVec3 {
        DVec3::new(self.number(), self.number(), self.number()) * sigma
    }

    fn matrix(&mut self, sigma: f64) -> DMat3 {
        DMat3::from_cols(self.vector(sigma), self.vector(sigma), self.vector(sigma))
    }
}

/// One camera's errors.
#[derive(Clone)]
pub(crate) struct Member {
    random: Normal,
    pub(crate) mounting: Mounting,
    scale: DMat3,
    pub(crate) gyro_bias: DVec3,
    pub(crate) accel_bias: DVec3,
    /// What the calibration left, µT.
    pub(crate) mag_bias: DVec3,
    /// A magnet beside it, µT in the rig's axes.
    pub(crate) magnet: DVec3,
    /// Steps by which its magnetometer is out of phase.
    phase: u64,
}

/// What is varied.
#[derive(Clone)]
pub(crate) struct Settings {
    pub(crate) walk: Walk,
    pub(crate) steel: Vec<Dipole>,
    pub(crate) mountings: Vec<Mounting>,
    pub(crate) mag_bias_ut: f64,
    /// Scale and alignment errors of the gyroscopes, 1σ of each element of the matrix.
    pub(crate) scale_error: f64,
    pub(crate) parameters: RigParameters,
}

/// The truth, the sensors and the filter.
#[derive(Clone)]
pub(crate) struct Scene {
    pub(crate) settings: Settings,
    pub(crate) members: Vec<Member>,
    pub(crate) filter: RigEstimator,
    geometry: Geometry,
    steps: u64,
}

/// A regular polygon of cameras in the rig's plane that look outwards, with sides of `side_m`.
pub(crate) fn polygon(count: usize, side_m: f64) -> Vec<Mounting> {
    let step = std::f64::consts::TAU / count as f64;
    let radius = side_m / (2.0 * (0.5 * step).sin());
    (0..count)
        .map(|k| {
            let yaw = step * k as f64;
            let place = DVec3::new(yaw.cos(), yaw.sin(), 0.0) * radius;
            Mounting {
                rotation: Rotation::from_yaw_pitch_roll(yaw, 0.1, 0.0),
                imu_m: place,
                magnetometer_m: place,
            }
        })
        .collect()
}

impl Settings {
    /// Three cameras half a metre apart, past steel that stands every two metres.
    pub(crate) fn indoors(seed: u64) -> Self {
        let walk = Walk::default();
        let steel = along(&walk, seed, 2.0, 450.0, 1.7..2.7);
        Self::with(walk, steel)
    }

    pub(crate) fn with(walk: Walk, steel: Vec<Dipole>) -> Self {
        Self {
            walk,
            steel,
            mountings: polygon(3, 0.5),
            mag_bias_ut: 0.0,
            scale_error: 0.0,
            parameters: RigParameters::default(),
        }
    }
}

/// Steel along a walk's path: one dipole every `every_m`, to either side, at any height.
pub(crate) fn along(
    walk: &Walk,
    seed: u64,
    every_m: f64,
    moment: f64,
    distance_m: std::ops::Range<f64>,
) -> Vec<Dipole> {
    let mut random = Normal::seeded(seed ^ 0x57ee1);
    let mut steel: Vec<Dipole> = Vec::new();
    let mut way = 3.0;
    while way < 80.0 {
        let ahead = (walk.path(way + 1e-3) - walk.path(way)).normalize();
        let side = DVec3::Z.cross(ahead);
        let up = random.number() * 0.7;
        let share = 0.5 + 0.5 * random.number().tanh();
        let across = distance_m.start + (distance_m.end - distance_m.start) * share;
        let sign = random.number().signum();
        let position = walk.path(way) + side * (sign * across) + DVec3::Z * (1.0 + up);
        let moment = random.vector(1.0).normalize() * moment;
        // The path crosses itself: what would stand in the way is left out.
        let free = (0..800).all(|k| {
            (walk.path(f64::from(k) * 0.1) + DVec3::Z - position).length() > 0.9 * distance_m.start
        });
        if free {
            steel.push(Dipole { position, moment });
        }
        way += every_m * (1.0 + 0.2 * random.number());
    }
    steel
}

impl Scene {
    pub(crate) fn new(settings: Settings, seed: u64) -> Self {
        let noise = settings.parameters.estimator.noise;
        let members = settings.mountings.iter().enumerate().map(|(k, mounting)| {
            let mut random = Normal::seeded(seed * 100 + k as u64);
            Member {
                mounting: *mounting,
                scale: DMat3::IDENTITY + random.matrix(settings.scale_error),
                gyro_bias: random.vector(noise.gyro_bias_sigma),
                accel_bias: random.vector(noise.accel_bias_sigma),
                mag_bias: random.vector(settings.mag_bias_ut),
                magnet: DVec3::ZERO,
                phase: 3 * k as u64,
                random,
            }
        });
        let members: Vec<Member> = members.collect();
        let geometry = Geometry::new(&settings.mountings).unwrap();
        let filter = RigEstimator::new(geometry, settings.parameters);
        Self { settings, members, filter, geometry, steps: 0 }
    }

    pub(crate) fn time_s(&self) -> f64 {
        self.steps as f64 * DT
    }

    /// True velocity of the filter point, m/s.
    pub(crate) fn velocity(&self) -> DVec3 {
        self.settings.walk.velocity(self.time_s(), DVec3::ZERO)
    }

    /// True position of the filter point, m.
    pub(crate) fn position(&self) -> DVec3 {
        self.settings.walk.position(self.time_s())
    }

    pub(crate) fn orientation(&self) -> DQuat {
        self.settings.walk.orientation(self.time_s())
    }

    /// Mean of the members' biases in the rig's axes, rad/s and m/s².
    pub(crate) fn mean_biases(&self) -> (DVec3, DVec3) {
        let n = self.members.len() as f64;
        let turned = |m: &Member, bias| m.mounting.rotation.apply(bias) / n;
        (
            self.members.iter().map(|m| turned(m, m.gyro_bias)).sum(),
            self.members.iter().map(|m| turned(m, m.accel_bias)).sum(),
        )
    }

    /// Moves the rig on by a step; `alter` may spoil what members say.
    pub(crate) fn step(
        &mut self,
        mut alter: impl FnMut(f64, &mut [Option<Step>; MAX_MEMBERS]),
    ) -> Option<RigReport> {
        let mut steps = self.sense();
        alter(self.time_s(), &mut steps);
        self.filter.step(&steps)
    }

    fn sense(&mut self) -> [Option<Step>; MAX_MEMBERS] {
        let (from_s, walk) = (self.time_s(), &self.settings.walk);
        self.steps += 1;
        let to_s = self.steps as f64 * DT;
        let (before, after) = (walk.orientation(from_s), walk.orientation(to_s));
        let angle = so3::log(before.conjugate() * after);
        let gravity = DVec3::Z * (self.settings.parameters.estimator.gravity_m_s2 * DT);
        let mut steps = [None; MAX_MEMBERS];
        for (k, member) in self.members.iter_mut().enumerate() {
            let arm = self.geometry.imu_arm_m(k);
            let gain = walk.velocity(to_s, arm) - walk.velocity(from_s, arm) + gravity;
            let gained = (before * so3::exp(angle * 0.5)).conjugate() * gain;
            let due = (self.steps + member.phase).is_multiple_of(STEPS_PER_MAG);
            let mag = due.then(|| {
                let place = walk.position(to_s) + after * self.geometry.magnetometer_arm_m(k);
                after.conjugate() * steel::field(&self.settings.steel, place)
            });
            let time = SensorTime::from_nanos(self.steps.cast_signed() * 2_500_000);
            let noise = self.settings.parameters.estimator;
            steps[k] = Some(member.sense(time, angle, gained, mag, &noise));
        }
        steps
    }
}

impl Member {
    fn sense(
        &mut self,
        time: SensorTime,
        angle: DVec3,
        gained: DVec3,
        field: Option<DVec3>,
        p: &Parameters,
    ) -> Step {
        let n = p.noise;
        let to_body = self.mounting.rotation.inverse();
        let angle_noise = self.random.vector(n.gyro_density * DT.sqrt());
        let velocity_noise = self.random.vector(n.accel_density * DT.sqrt());
        let increment = Increment {
            span_s: DT,
            angle: self.scale * to_body.apply(angle) + self.gyro_bias * DT + angle_noise,
            velocity: to_body.apply(gained) + self.accel_bias * DT + velocity_noise,
        };
        let mag = field.map(|field| {
            let noise = self.random.vector(n.mag_sigma_ut);
            Mag::new(to_body.apply(field + self.magnet) + self.mag_bias + noise)
        });
        Step { time, increment, mag, bridged: false, saturated: false }
    }
}
