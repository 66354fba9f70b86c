//! Standstill and stance: what a camera that stands knows, and what a walking foot makes of it.

use glam::{DQuat, DVec3};
use lodestone_fusion::{
    Estimator, Increment, POSITION, Parameters, SensorTime, Step, VELOCITY, so3,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use crate::scene::{CARRIED, Scene};
use crate::simulation::{Motion, steps};

#[test]
fn a_standing_camera_does_not_drift() {
    // Given an aligned camera, when it stands for ten minutes, then its position stays where it is, and is
    // not the less certain for it.
    for seed in 0..3 {
        let mut scene = Scene::new(seed);
        scene.pass(3.0, Motion::Still);
        let before = scene.estimate();
        scene.pass(600.0, Motion::Still);
        let after = scene.estimate();
        assert!(after.position.length() < 1e-9, "{}", after.position);
        assert!(after.velocity.length() < 1e-2, "{}", after.velocity);
        let grown = after.position_covariance.x_axis.x - before.position_covariance.x_axis.x;
        assert!(grown <= 1e-12, "a standing camera's variance grew by {grown} m²");
    }
}

#[test]
fn a_camera_that_is_put_down_and_taken_up_again_goes_on_from_there() {
    // Given a camera that was carried and stands, when a minute passes, then it stays where it came to
    // stand; when it is carried again, then its error is what its covariance says.
    let mut scene = Scene::new(5);
    scene.pass(3.0, Motion::Still);
    scene.pass(4.0, CARRIED);
    scene.pass(10.0, Motion::Still);
    let (put_down, truth) = (scene.estimate().position, scene.truth.position);
    scene.pass(60.0, Motion::Still);
    // What a minute teaches of tilt and bias also corrects the way before it, less than it is uncertain.
    let crept = scene.estimate().position - put_down;
    let sigma = scene.estimate().position_covariance.x_axis.x.sqrt();
    assert!(crept.length() < sigma.min(0.02), "it crept by {crept} m, sigma {sigma}");
    assert_eq!(scene.truth.position, truth);
    let way_before = scene.truth.position;
    scene.pass(3.0, CARRIED);
    assert!((scene.truth.position - way_before).length() > 0.1, "it was carried");
    let error = scene.truth.position - scene.estimate().position;
    let covariance = scene.estimate().position_covariance;
    let sigmas = error.dot(covariance.inverse() * error).sqrt();
    assert!(sigmas < 4.0, "{error} m off, {sigmas} sigma");
}

/// The step of a time that runs backwards.
fn backwards(step: &Step) -> Step {
    Step {
        time: SensorTime::from_nanos(-step.time.as_nanos()),
        increment: Increment { angle: -step.increment.angle, ..step.increment },
        mag: None,
        ..*step
    }
}

#[test]
fn a_reversed_estimator_finds_back_to_where_it_was() {
    // Given a camera that was carried for a second, when its estimator goes back over the same steps,
    // then it comes back to where it was then, and to how fast it was.
    let mut scene = Scene::new(6);
    scene.pass(3.0, Motion::Still);
    scene.pass(0.5, CARRIED);
    let before = scene.estimate();
    let past: Vec<Step> = (0..steps(1.0)).map(|_| scene.truth.step(CARRIED)).collect();
    for step in &past {
        scene.filter.step(step);
    }
    let mut reversed = scene.filter.reversed().expect("aligned");
    assert!((scene.estimate().position - before.position).length() > 0.05, "it moved");
    for step in past.iter().rev() {
        reversed.step(&backwards(step));
    }
    let back = reversed.estimate().expect("finite");
    // What was learnt meanwhile of field and gravity is not unlearnt; nor is the integration the same.
    assert!((back.position - before.position).length() < 0.03, "{}", back.position);
    assert!((-back.velocity - before.velocity).length() < 0.06, "{}", back.velocity);
    let turned =
        so3::log(back.orientation.quaternion() * before.orientation.quaternion().conjugate());
    assert!(turned.length() < 0.02, "{turned}");
}

#[test]
fn there_is_no_way_back_before_the_alignment() {
    assert!(Estimator::new(Parameters::default()).reversed().is_none());
}

/// A foot that walks straight on: stances and swings of half a second, strides of 1.3 m, pitching by a
/// radian, and sliding sideways at some centimetres per second while it stands.
struct Foot {
    random: ChaCha8Rng,
    time_s: f64,
    slide_m_s: DVec3,
    before: (DVec3, DVec3, f64),
}

const DT: f64 = 0.005;
const HALF_CYCLE_S: f64 = 0.5;
const STRIDE_M: f64 = 1.3;

impl Foot {
    fn new(seed: u64) -> Self {
        let random = ChaCha8Rng::seed_from_u64(seed);
        Self {
            random,
            time_s: 0.0,
            slide_m_s: DVec3::ZERO,
            before: (DVec3::ZERO, DVec3::ZERO, 0.0),
        }
    }

    /// Position, velocity and pitch of the sole, two seconds of standing first.
    fn pose(time_s: f64) -> (DVec3, DVec3, f64) {
        let walking = (time_s - 2.0).max(0.0);
        let (cycle, into) =
            ((walking / (2.0 * HALF_CYCLE_S)).floor(), walking % (2.0 * HALF_CYCLE_S));
        let phase = if time_s < 2.0 { 0.0 } else { (into / HALF_CYCLE_S).min(1.0) };
        let t = phase;
        let way = t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
        let speed = 30.0 * t * t * (1.0 - t) * (1.0 - t) / HALF_CYCLE_S;
        // The heel rolls up before the sole leaves the ground.
        let (sin, cos) = (std::f64::consts::PI * t).sin_cos();
        let rise = 4.0 * sin.powi(3) * cos * std::f64::consts::PI / HALF_CYCLE_S;
        let position = DVec3::new((cycle + way) * STRIDE_M, 0.0, 0.1 * sin.powi(4));
        let velocity = DVec3::new(speed * STRIDE_M, 0.0, 0.1 * rise);
        (position, velocity, sin * sin)
    }

    fn noise(&mut self, sigma: f64) -> DVec3 {
        let mut number = || -> f64 { StandardNormal.sample(&mut self.random) };
        DVec3::new(number(), number(), number()) * sigma
    }

    /// The next step of its sensor, and the true position and velocity at its end.
    fn step(&mut self) -> (Step, DVec3, DVec3) {
        self.time_s += DT;
        let (position, velocity, pitch) = Self::pose(self.time_s);
        if pitch == 0.0 && self.time_s > 2.0 {
            self.slide_m_s = self.slide_m_s * 0.98 + DVec3::Y * self.noise(0.004).y;
        } else {
            self.slide_m_s *= 0.5;
        }
        let velocity = velocity + self.slide_m_s;
        let position = position.with_y(self.before.0.y + self.slide_m_s.y * DT);
        let gain = velocity - self.before.1 + DVec3::Z * 9.81 * DT;
        let half_way = DQuat::from_rotation_y(0.5 * (pitch + self.before.2));
        let increment = Increment {
            span_s: DT,
            angle: DVec3::Y * (pitch - self.before.2) + self.noise(7e-4 * DT.sqrt()),
            velocity: half_way.conjugate() * gain + self.noise(1.6e-3 * DT.sqrt()),
        };
        self.before = (position, velocity, pitch);
        let time = SensorTime::from_nanos((self.time_s * 1e9) as i64);
        let step = Step { time, increment, mag: None, bridged: false, saturated: false };
        (step, position, velocity)
    }
}

#[test]
fn a_walking_foot_knows_how_far_it_came() {
    // Given sensors on five feet, when each has walked forty strides, then their positions are right to
    // 1.5 % of the way, root mean square, and so they say. In the stances the velocity is no worse than its covariance
    // says; it is better, because what is left of a real foot's stance lasts longer than an update.
    let (mut nees, mut looked, mut nis, mut updates) = (0.0, 0.0, 0.0, 0.0);
    let mut share_squares = 0.0_f64;
    for seed in 0..5 {
        let mut foot = Foot::new(seed);
        let parameters = Parameters { gyro_lag_s: 0.0, ..Parameters::foot_mounted() };
        let mut filter = Estimator::new(parameters);
        let mut truth = DVec3::ZERO;
        for _ in 0..(42.0 / DT) as usize {
            let (step, position, velocity) = foot.step();
            let report = filter.step(&step);
            truth = position;
            if let (Some(outcome), Some(state)) = (report.standstill, filter.state()) {
                (nis, updates) = (nis + outcome.nis, updates + 1.0);
                let error = velocity - state.velocity;
                let block = state.covariance.block(VELOCITY, VELOCITY);
                (nees, looked) = (nees + error.dot(block.inverse() * error) / 3.0, looked + 1.0);
            }
        }
        let estimate = filter.estimate().expect("aligned");
        let error = estimate.position - truth;
        assert!(truth.x > 50.0, "{truth}");
        share_squares += (error.length() / truth.x).powi(2) / 5.0;
        let state = filter.state().expect("aligned");
        let sigma = state.covariance.variances(POSITION).max_element().sqrt();
        assert!(error.length() < 4.0 * sigma && sigma < 1.5, "{error} with a sigma of {sigma} m");
    }
    let share = share_squares.sqrt();
    assert!(share < 0.015, "off by {share} of the way");
    let (nees, nis) = (nees / looked, nis / updates);
    assert!(nees < 1.5, "NEES of the velocity in stances {nees}");
    assert!(nis < 1.5, "NIS of zero velocity, worst axis {nis}");
}
