//! A car in city traffic whose truth is known: stops, turns, up to 80 km/h, over a rough road.
//!
//! Its rear axle rolls along its heading; the body pitches when it brakes and leans in turns. The camera
//! sits ahead of the axle, turned. Its sensors err as the filter believes they do.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3, EulerRot};
use lodestone_fusion::{
    Increment, Mag, Parameters, Rotation, SensorTime, Step, Vehicle, VehicleParameters, so3,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

use crate::simulation::{DT, FIELD};

/// Every so many steps the magnetometer gives a reading: 50 Hz.
const STEPS_PER_MAG: u64 = 8;
/// Hardest braking and throttle, m/s².
const CHANGE_M_S2: f64 = 2.2;
/// How fast throttle and steering follow the driver, s.
const PEDAL_S: f64 = 0.4;
const STEERING_S: f64 = 0.5;

/// What the driver does next.
#[derive(Clone, Copy, Debug)]
enum Leg {
    /// Stands for a time, s.
    Stand(f64),
    /// Drives at a speed, m/s, for a time, s.
    Drive(f64, f64),
    /// Turns by an angle, rad, at a speed, m/s, on a radius, m.
    Turn { angle: f64, speed: f64, radius: f64 },
}

/// Where the camera sits: the vehicle's axes from its own, and its place on the vehicle, m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mount {
    pub(crate) vehicle_from_body: Rotation<Vehicle, lodestone_fusion::Body>,
    pub(crate) position_m: DVec3,
}

impl Mount {
    /// Behind the windscreen, a little nose down and not quite straight ahead.
    pub(crate) fn windscreen() -> Self {
        Self {
            vehicle_from_body: Rotation::from_yaw_pitch_roll(0.05, 0.15, -0.03),
            position_m: DVec3::new(1.6, 0.25, 1.1),
        }
    }

    /// What the filter is told.
    pub(crate) fn parameters(&self) -> VehicleParameters {
        let origin = self.vehicle_from_body.inverse().apply(-self.position_m);
        VehicleParameters::mounted(self.vehicle_from_body, origin)
    }
}

/// The car, its camera, and the truth about both.
#[derive(Clone)]
pub(crate) struct City {
    parameters: Parameters,
    random: ChaCha8Rng,
    mount: Mount,
    leg: Leg,
    leg_s: f64,
    leg_rad: f64,
    steps: u64,
    axle: DVec3,
    yaw: f64,
    yaw_rate: f64,
    acceleration: f64,
    /// Speed of the rear axle along the car, m/s.
    pub(crate) speed: f64,
    /// Way of the rear axle since the beginning, m.
    pub(crate) distance: f64,
    /// Camera's body to world.
    pub(crate) orientation: DQuat,
    /// Of the camera, m.
    pub(crate) position: DVec3,
    /// Of the camera, m/s.
    pub(crate) velocity: DVec3,
    gyro_bias: DVec3,
    accel_bias: DVec3,
    leaky_velocity: DVec3,
    /// Angle by which the local field lies east of north, rad.
    deviation: f64,
    /// Whether the magnetometer works.
    pub(crate) has_mag: bool,
}

impl City {
    pub(crate) fn new(seed: u64, parameters: Parameters, mount: Mount) -> Self {
        let mut city = Self {
            parameters,
            random: ChaCha8Rng::seed_from_u64(seed),
            mount,
            leg: Leg::Stand(4.0),
            leg_s: 0.0,
            leg_rad: 0.0,
            steps: 0,
            axle: DVec3::ZERO,
            yaw: 0.0,
            yaw_rate: 0.0,
            acceleration: 0.0,
            speed: 0.0,
            distance: 0.0,
            orientation: DQuat::IDENTITY,
            position: DVec3::ZERO,
            velocity: DVec3::ZERO,
            gyro_bias: DVec3::ZERO,
            accel_bias: DVec3::ZERO,
            leaky_velocity: DVec3::ZERO,
            deviation: 0.0,
            has_mag: true,
        };
        city.yaw = TAU * city.uniform(0.0, 1.0);
        city.gyro_bias = city.vector(parameters.noise.gyro_bias_sigma);
        city.accel_bias = city.vector(parameters.noise.accel_bias_sigma);
        city.deviation = city.number(parameters.compass.deviation_sigma_rad);
        (city.orientation, city.position) = city.camera();
        city.axle -= city.position;
        city.position = DVec3::ZERO;
        city
    }

    fn uniform(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * (f64::from(self.random.next_u32()) / f64::from(u32::MAX))
    }

    fn vector(&mut self, sigma: f64) -> DVec3 {
        let mut number = || -> f64 { StandardNormal.sample(&mut self.random) };
        DVec3::new(number(), number(), number()) * sigma
    }

    /// A normal number.
    pub(crate) fn number(&mut self, sigma: f64) -> f64 {
        self.vector(sigma).x
    }

    /// Whether the car has come to a stop and stands.
    pub(crate) fn stands(&self) -> bool {
        self.speed == 0.0
    }

    /// Turns the camera on the car, before it drives, by a rotation vector in the car's axes, rad.
    pub(crate) fn turn_camera(&mut self, rotation: DVec3) {
        let turned = so3::exp(rotation) * self.mount.vehicle_from_body.quaternion();
        self.mount.vehicle_from_body = Rotation::from_quaternion(turned).expect("of unit length");
        (self.orientation, self.position) = self.camera();
    }

    /// Moves on by a step; gives what the sensors saw.
    pub(crate) fn step(&mut self) -> Step {
        let (turn_before, place_before, velocity_before) =
            (self.orientation, self.position, self.velocity);
        self.drive();
        (self.orientation, self.position) = self.camera();
        // The mean velocity over the step is known exactly, and twice its mean less the one before is
        // the velocity now; that would swing, so the change is taken from mean to mean.
        let mean = (self.position - place_before) / DT;
        let gain = mean - velocity_before;
        self.velocity = mean;
        self.steps += 1;
        let angle = so3::log(turn_before.conjugate() * self.orientation);
        let halfway = turn_before * so3::exp(0.5 * angle);
        let force = halfway.conjugate() * (gain + DVec3::Z * (self.parameters.gravity_m_s2 * DT));
        self.renew_deviation(angle, gain);
        Step {
            time: SensorTime::from_nanos(self.steps.cast_signed() * 2_500_000),
            increment: self.sense(angle, force),
            mag: self.sense_field(),
            bridged: false,
            saturated: false,
        }
    }

    fn drive(&mut self) {
        let (speed, yaw_rate) = match self.leg {
            Leg::Stand(_) => (0.0, 0.0),
            Leg::Drive(speed, _) => (speed, 0.0),
            Leg::Turn { angle, speed, radius } => {
                let slow = self.speed < speed + 0.5;
                (speed, if slow { angle.signum() * self.speed / radius } else { 0.0 })
            }
        };
        let wanted = ((speed - self.speed) / (2.0 * PEDAL_S)).clamp(-CHANGE_M_S2, CHANGE_M_S2);
        self.acceleration += (wanted - self.acceleration) * (DT / PEDAL_S);
        self.yaw_rate += (yaw_rate - self.yaw_rate) * (DT / STEERING_S);
        self.speed = (self.speed + self.acceleration * DT).max(0.0);
        if speed == 0.0 && self.speed < 0.02 {
            // Held by the brakes.
            (self.speed, self.acceleration, self.yaw_rate) = (0.0, 0.0, 0.0);
        }
        let yaw = self.yaw + 0.5 * self.yaw_rate * DT;
        self.axle += DVec3::new(yaw.cos(), yaw.sin(), self.slope()) * (self.speed * DT);
        self.yaw += self.yaw_rate * DT;
        self.distance += self.speed * DT;
        self.leg_s += DT;
        self.leg_rad += self.yaw_rate * DT;
        self.take_turn();
    }

    /// Rise of the road.
    fn slope(&self) -> f64 {
        0.7 * TAU / 313.0 * (TAU * self.distance / 313.0).cos()
    }

    /// The next leg once this one is done.
    fn take_turn(&mut self) {
        let done = match self.leg {
            Leg::Stand(span_s) => self.stands() && self.leg_s > span_s,
            Leg::Drive(_, span_s) => self.leg_s > span_s,
            Leg::Turn { angle, .. } => self.leg_rad.abs() >= angle.abs(),
        };
        if !done {
            return;
        }
        let side = if self.uniform(0.0, 1.0) < 0.5 { 1.0 } else { -1.0 };
        let stops = self.uniform(0.0, 1.0) < 0.4;
        self.leg = match self.leg {
            Leg::Stand(_) | Leg::Turn { .. } => {
                Leg::Drive(self.uniform(7.0, 22.2), self.uniform(8.0, 22.0))
            }
            Leg::Drive(..) if stops => Leg::Stand(self.uniform(8.0, 20.0)),
            Leg::Drive(..) => Leg::Turn {
                angle: side * self.uniform(0.4, 1.6),
                speed: self.uniform(4.5, 7.5),
                radius: self.uniform(10.0, 25.0),
            },
        };
        (self.leg_s, self.leg_rad) = (0.0, 0.0);
    }

    /// Attitude and place of the camera.
    fn camera(&self) -> (DQuat, DVec3) {
        let wave = |size: f64, length_m: f64| size * (TAU * self.distance / length_m).sin();
        let sideways = self.yaw_rate * self.speed;
        let pitch =
            wave(4e-3, 14.1) + wave(2e-4, 1.87) - self.slope().atan() - 0.006 * self.acceleration;
        let roll = wave(8e-3, 83.0) + wave(2e-4, 2.03) + 0.008 * sideways;
        let heave = DVec3::Z * (wave(5e-3, 15.3) + wave(8e-5, 1.87) + wave(2e-5, 0.83));
        let car = DQuat::from_euler(EulerRot::ZYX, self.yaw, pitch, roll);
        let place = self.axle + heave + car * self.mount.position_m;
        (car * self.mount.vehicle_from_body.quaternion(), place)
    }

    fn sense(&mut self, angle: DVec3, force: DVec3) -> Increment {
        let n = self.parameters.noise;
        let turned = self.vector(n.gyro_scale_walk * angle.length().sqrt());
        let angle_noise = self.vector(n.gyro_density * DT.sqrt());
        let velocity_noise = self.vector(n.accel_density * DT.sqrt());
        let gyro_walk = self.vector(n.gyro_bias_walk * DT.sqrt());
        let accel_walk = self.vector(n.accel_bias_walk * DT.sqrt());
        self.gyro_bias += gyro_walk;
        self.accel_bias += accel_walk;
        Increment {
            span_s: DT,
            angle: angle + self.gyro_bias * DT + angle_noise + turned,
            velocity: force + self.accel_bias * DT + velocity_noise,
        }
    }

    /// Streets bend the field, as the filter believes they do.
    fn renew_deviation(&mut self, angle: DVec3, gain: DVec3) {
        let c = self.parameters.compass;
        let leak = 1.0 - DT / self.parameters.levelling.time_constant_s;
        self.leaky_velocity = (self.leaky_velocity + gain) * leak;
        let renewed = self.leaky_velocity.length() * DT / c.deviation_way_m
            + angle.length() / c.deviation_turn_rad
            + DT / c.deviation_time_s;
        let kept = 1.0 - renewed.min(1.0);
        let fresh = c.deviation_sigma_rad * (1.0 - kept * kept).sqrt();
        self.deviation = kept * self.deviation + self.number(fresh);
    }

    fn sense_field(&mut self) -> Option<Mag<lodestone_fusion::Body>> {
        let due = self.has_mag && self.steps.is_multiple_of(STEPS_PER_MAG);
        due.then(|| {
            let noise = self.vector(self.parameters.noise.mag_sigma_ut);
            let local = so3::exp(DVec3::Z * -self.deviation) * FIELD;
            Mag::new(self.orientation.conjugate() * local + noise)
        })
    }
}
