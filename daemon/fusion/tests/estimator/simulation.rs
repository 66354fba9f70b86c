//! A camera whose truth is known, with sensors that err as the filter believes they do.

use glam::{DQuat, DVec3};
use lodestone_fusion::{Increment, Mag, Parameters, SensorTime, Step, so3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Span of a step, s.
pub(crate) const DT: f64 = 0.0025;
/// Every so many steps the magnetometer gives a reading: 50 Hz.
const STEPS_PER_MAG: u64 = 8;
/// The earth's field in the world, µT.
pub(crate) const FIELD: DVec3 = DVec3::new(0.0, 22.0, -42.0);

/// What the camera does.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Motion {
    /// Lies still.
    Still,
    /// Turns at a constant rate in the body, rad/s, in place.
    Turn(DVec3),
    /// Is carried by hand: smooth random turning and walking about, 1σ in rad/s and m/s.
    Carried { rate_sigma: f64, speed_sigma: f64 },
}

/// A smooth random vector: a critically damped oscillator driven by white noise.
#[derive(Clone, Copy, Debug, Default)]
struct Smooth {
    value: DVec3,
    slope: DVec3,
}

/// Time constant of smooth random motion, s: hands move at about half a hertz.
const SMOOTH_S: f64 = 0.3;

impl Smooth {
    fn advance(&mut self, sigma: f64, drive: DVec3) {
        let force = self.value / (SMOOTH_S * SMOOTH_S) + self.slope * (2.0 / SMOOTH_S);
        let density = 2.0 * sigma / SMOOTH_S.powf(1.5);
        self.slope += drive * (density * DT.sqrt()) - force * DT;
        self.value += self.slope * DT;
    }
}

/// The truth, and the sensors that look at it.
#[derive(Clone)]
pub(crate) struct Simulation {
    parameters: Parameters,
    random: ChaCha8Rng,
    rate: Smooth,
    speed: Smooth,
    steps: u64,
    leaky_velocity: DVec3,
    /// Body to world.
    pub(crate) orientation: DQuat,
    /// m/s in the world.
    pub(crate) velocity: DVec3,
    /// m in the world.
    pub(crate) position: DVec3,
    /// rad/s.
    pub(crate) gyro_bias: DVec3,
    /// m/s².
    pub(crate) accel_bias: DVec3,
    /// Angle by which the local field lies east of north, rad.
    pub(crate) deviation: f64,
    /// Whether the camera has a magnetometer.
    pub(crate) has_mag: bool,
    /// A magnet near the camera: field in the world, µT.
    pub(crate) disturbance: DVec3,
    /// A magnet on the camera: field in the body, µT.
    pub(crate) hard_iron: DVec3,
}

impl Simulation {
    /// A camera with random attitude, biases and deviation of the sizes that the parameters state.
    pub(crate) fn new(seed: u64, parameters: Parameters) -> Self {
        let mut simulation = Self::perfect(seed, parameters);
        simulation.gyro_bias = simulation.vector(parameters.noise.gyro_bias_sigma);
        simulation.accel_bias = simulation.vector(parameters.noise.accel_bias_sigma);
        simulation.deviation = parameters.compass.deviation_sigma_rad * simulation.number();
        simulation
    }

    /// The same without biases and deviation.
    pub(crate) fn perfect(seed: u64, parameters: Parameters) -> Self {
        let mut simulation = Self {
            parameters,
            random: ChaCha8Rng::seed_from_u64(seed),
            rate: Smooth::default(),
            speed: Smooth::default(),
            steps: 0,
            leaky_velocity: DVec3::ZERO,
            orientation: DQuat::IDENTITY,
            velocity: DVec3::ZERO,
            position: DVec3::ZERO,
            gyro_bias: DVec3::ZERO,
            accel_bias: DVec3::ZERO,
            deviation: 0.0,
            has_mag: true,
            disturbance: DVec3::ZERO,
            hard_iron: DVec3::ZERO,
        };
        simulation.orientation = so3::exp(simulation.vector(1.0));
        simulation
    }

    fn number(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    fn vector(&mut self, sigma: f64) -> DVec3 {
        DVec3::new(self.number(), self.number(), self.number()) * sigma
    }

    /// Moves the camera on by one step and gives what the sensors saw.
    pub(crate) fn step(&mut self, motion: Motion) -> Step {
        let (angle, gain) = self.motion(motion);
        let force_gain = gain + DVec3::Z * (self.parameters.gravity_m_s2 * DT);
        // The velocity is gained in the attitude half-way through the turn.
        let halfway = self.orientation * so3::exp(angle * 0.5);
        let gained = halfway.conjugate() * force_gain;

        self.position += (self.velocity + 0.5 * gain) * DT;
        self.velocity += gain;
        self.orientation = (self.orientation * so3::exp(angle)).normalize();
        self.steps += 1;
        let increment = self.sense(angle, gained);
        self.age(angle, gain);
        Step {
            time: SensorTime::from_nanos(self.steps.cast_signed() * 2_500_000),
            increment,
            mag: self.sense_field(),
            bridged: false,
            saturated: false,
        }
    }

    /// Turn, rad, and gain of velocity in the world, m/s, of the coming step.
    fn motion(&mut self, motion: Motion) -> (DVec3, DVec3) {
        match motion {
            Motion::Still => (DVec3::ZERO, -self.velocity),
            Motion::Turn(rate) => (rate * DT, -self.velocity),
            Motion::Carried { rate_sigma, speed_sigma } => {
                let (turning, pushing) = (self.vector(1.0), self.vector(1.0));
                self.rate.advance(rate_sigma, turning);
                self.speed.advance(speed_sigma, pushing);
                (self.rate.value * DT, self.speed.value - self.velocity)
            }
        }
    }

    fn sense(&mut self, angle: DVec3, gained: DVec3) -> Increment {
        let n = self.parameters.noise;
        let turn_noise = self.vector(n.gyro_scale_walk * angle.length().sqrt());
        let angle_noise = self.vector(n.gyro_density * DT.sqrt());
        let velocity_noise = self.vector(n.accel_density * DT.sqrt());
        Increment {
            span_s: DT,
            angle: angle + self.gyro_bias * DT + angle_noise + turn_noise,
            velocity: gained + self.accel_bias * DT + velocity_noise,
        }
    }

    /// Biases walk, and the deviation is renewed by turning, moving and time.
    fn age(&mut self, angle: DVec3, gain: DVec3) {
        let (n, c) = (self.parameters.noise, self.parameters.compass);
        let gyro_walk = self.vector(n.gyro_bias_walk * DT.sqrt());
        let accel_walk = self.vector(n.accel_bias_walk * DT.sqrt());
        self.gyro_bias += gyro_walk;
        self.accel_bias += accel_walk;
        let leak = 1.0 - DT / self.parameters.levelling.time_constant_s;
        self.leaky_velocity = (self.leaky_velocity + gain) * leak;
        let renewed = self.leaky_velocity.length() * DT / c.deviation_way_m
            + angle.length() / c.deviation_turn_rad
            + DT / c.deviation_time_s;
        let kept = 1.0 - renewed.min(1.0);
        let fresh = c.deviation_sigma_rad * (1.0 - kept * kept).sqrt();
        self.deviation = kept * self.deviation + fresh * self.number();
    }

    fn sense_field(&mut self) -> Option<Mag<lodestone_fusion::Body>> {
        let due = self.has_mag && self.steps.is_multiple_of(STEPS_PER_MAG);
        due.then(|| {
            let local = so3::exp(DVec3::Z * -self.deviation) * FIELD + self.disturbance;
            let noise = self.vector(self.parameters.noise.mag_sigma_ut);
            Mag::new(self.orientation.conjugate() * local + self.hard_iron + noise)
        })
    }
}

/// Steps in a span.
pub(crate) fn steps(seconds: f64) -> usize {
    (seconds / DT).round() as usize
}
