//! Two cameras of which one is measured against the other again and again: is their relative pose as good
//! as it says, and is what each says of the world?

use glam::{DMat3, DVec3};
use lodestone_fusion::relative::{Apart, Relative, relative_by};
use lodestone_fusion::{
    Aid, AidReport, Anchor, Estimate, Estimator, Measurement, ORIENTATION, POSITION, Parameters,
    Rotation, SensorTime, so3,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use crate::simulation::{DT, Motion, Simulation, steps};

const SEEDS: u64 = 100;
/// Of a registration, 1σ about and along each axis.
const TURN_RAD: f64 = 0.05 * core::f64::consts::PI / 180.0;
const SHIFT_M: f64 = 3e-3;
/// How well each camera knows its place at first, 1σ along each axis.
const PLACE_M: f64 = 0.05;
const CARRIED: Motion = Motion::Carried { rate_sigma: 0.6, speed_sigma: 0.4 };

/// An anchor and its follower, in fields that deviate differently.
struct Pair {
    truth: [Simulation; 2],
    filters: [Estimator; 2],
    random: ChaCha8Rng,
    now: SensorTime,
}

impl Pair {
    fn new(seed: u64, magnetometers: [bool; 2]) -> Self {
        let p = Parameters::default();
        let mut truth = [0, 1].map(|which| Simulation::new(2 * seed + which + 4000, p));
        for (camera, has_mag) in truth.iter_mut().zip(magnetometers) {
            camera.has_mag = has_mag;
        }
        truth[1].position = DVec3::new(2.0, 1.0, 0.3);
        let random = ChaCha8Rng::seed_from_u64(seed);
        let mut pair = Self {
            truth,
            filters: [Estimator::new(p); 2],
            random,
            now: SensorTime::from_nanos(0),
        };
        pair.run([Motion::Still; 2], 3.0);
        for which in 0..2 {
            let place = pair.truth[which].position + pair.vector(PLACE_M);
            pair.filters[which].place(place, DMat3::IDENTITY * (PLACE_M * PLACE_M));
        }
        pair
    }

    fn vector(&mut self, sigma: f64) -> DVec3 {
        let mut number = || -> f64 { StandardNormal.sample(&mut self.random) };
        DVec3::new(number(), number(), number()) * sigma
    }

    fn run(&mut self, motions: [Motion; 2], seconds: f64) {
        for n in 0..steps(seconds) {
            for (k, motion) in motions.into_iter().enumerate() {
                let step = self.truth[k].step(motion);
                self.now = step.time;
                self.filters[k].step(&step);
            }
            if n % 40 == 39 {
                self.follow();
            }
        }
    }

    /// The follower looks at its anchor, ten times a second.
    fn follow(&mut self) {
        if let Some(anchor) = self.filters[0].estimate() {
            self.filters[1].follow(&anchor_of(&anchor));
        }
    }

    fn estimates(&self) -> [Estimate; 2] {
        [0, 1].map(|k| self.filters[k].estimate().expect("aligned"))
    }

    /// A registration of the clouds of both: where the follower is against the anchor, in the world by the
    /// anchor's pose.
    fn register(&mut self) -> AidReport {
        let (turn, shift) = (self.vector(TURN_RAD), self.vector(SHIFT_M));
        let [a, b] = [&self.truth[0], &self.truth[1]];
        let back = a.orientation.conjugate();
        let measured = so3::exp(turn) * (back * b.orientation);
        let distance = back * (b.position - a.position) + shift;
        let [anchor, _] = self.estimates();
        let by = anchor.orientation.quaternion();
        let measurement = Measurement::Pose {
            position_m: anchor.position + by * distance,
            covariance: DMat3::IDENTITY * (SHIFT_M * SHIFT_M),
            lever_m: DVec3::ZERO,
            orientation: Rotation::from_quaternion(by * measured).unwrap(),
            orientation_covariance: DMat3::IDENTITY * (TURN_RAD * TURN_RAD),
            anchor: Some(anchor_of(&anchor)),
        };
        self.filters[1].aid(&Aid { time: self.now, measurement })
    }

    fn relative(&self) -> Relative {
        let [a, b] = self.estimates();
        let tied = b.tie.expect("it was registered");
        let drifted = a.drift.since(&tied.mark).expect("nothing was cut");
        let apart = tied.apart(&drifted, b.position - a.position);
        relative_by(&a.station(), &b.station(), [&Apart::NOTHING, &apart])
    }

    /// Errors of the relative orientation, rad, and of the distance, m, in a's axes.
    fn relative_error(&self, found: &Relative) -> [DVec3; 2] {
        let [a, b] = [&self.truth[0], &self.truth[1]];
        let back = a.orientation.conjugate();
        let turned = back * b.orientation * found.orientation.quaternion().conjugate();
        let distance = back * (b.position - a.position);
        [so3::log(turned), distance - found.distance.expect("both are known").vector]
    }

    /// NEES per number of orientation and position of one camera in the world.
    fn in_world(&self, which: usize) -> [f64; 2] {
        let (truth, state) = (&self.truth[which], self.filters[which].state().unwrap());
        let turn = so3::log(truth.orientation * state.orientation().quaternion().conjugate());
        let block = |b| state.covariance.block(b, b);
        [
            nees(turn, block(ORIENTATION)),
            nees(truth.position - state.position, block(POSITION)),
        ]
    }
}

fn anchor_of(estimate: &Estimate) -> Anchor {
    Anchor {
        id: 1,
        position_m: estimate.position,
        orientation_covariance: estimate.orientation_covariance,
        position_covariance: estimate.position_covariance,
        drift: estimate.drift,
    }
}

fn nees(error: DVec3, covariance: DMat3) -> f64 {
    error.dot(covariance.inverse() * error) / 3.0
}

fn trace(m: DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

/// Means over all seeds: orientation and position.
#[derive(Clone, Copy, Debug, Default)]
struct Score {
    nees: [f64; 2],
    /// Root mean squares of error and σ per axis: degrees, m.
    error: [f64; 2],
    sigma: [f64; 2],
    follower_in_world: [f64; 2],
    anchor_in_world: [f64; 2],
}

impl Score {
    fn add(&mut self, pair: &Pair) {
        let found = pair.relative();
        let errors = pair.relative_error(&found);
        let covariances = [found.orientation_covariance, found.distance.unwrap().covariance];
        let (anchor, follower) = (pair.in_world(0), pair.in_world(1));
        for k in 0..2 {
            self.nees[k] += nees(errors[k], covariances[k]) / SEEDS as f64;
            self.error[k] += errors[k].length_squared() / 3.0 / SEEDS as f64;
            self.sigma[k] += trace(covariances[k]) / 3.0 / SEEDS as f64;
            self.follower_in_world[k] += follower[k] / SEEDS as f64;
            self.anchor_in_world[k] += anchor[k] / SEEDS as f64;
        }
    }

    fn root(mut self) -> Self {
        for square in self.error.iter_mut().chain(&mut self.sigma) {
            *square = square.sqrt();
        }
        self.error[0] = self.error[0].to_degrees();
        self.sigma[0] = self.sigma[0].to_degrees();
        self
    }
}

/// Ten registrations, one each second, and what is left of them so many seconds later.
fn scores(motions: [Motion; 2], later_s: &[f64]) -> Vec<Score> {
    let mut scores = vec![Score::default(); later_s.len()];
    let mut refused = 0;
    for seed in 0..SEEDS {
        let mut pair = Pair::new(seed, [true; 2]);
        for k in 0..10 {
            pair.run(motions, 1.0);
            let report = pair.register();
            refused += u32::from(report.refusal.is_some());
            let _ = k;
        }
        let mut waited_s = 0.0;
        for (score, &at_s) in scores.iter_mut().zip(later_s) {
            pair.run(motions, at_s - waited_s);
            waited_s = at_s;
            score.add(&pair);
        }
    }
    scores.into_iter().map(Score::root).collect()
}

fn show(what: &str, later_s: &[f64], scores: &[Score]) {
    for (at_s, score) in later_s.iter().zip(scores) {
        println!("{what}, {at_s} s later: {score:.4?}");
    }
}

#[test]
fn standing() {
    let later_s = [0.0, DT, 1.0, 10.0, 60.0];
    let scores = scores([Motion::Still; 2], &later_s);
    show("standing", &later_s, &scores);
}

#[test]
fn follower_carried() {
    let later_s = [0.0, 1.0, 5.0, 20.0];
    let scores = scores([Motion::Still, CARRIED], &later_s);
    show("follower carried", &later_s, &scores);
}

#[test]
fn both_carried() {
    let later_s = [0.0, 1.0, 5.0, 20.0];
    let scores = scores([CARRIED; 2], &later_s);
    show("both carried", &later_s, &scores);
}

#[test]
fn parts() {
    let mut sums = [[DVec3::ZERO; 8]; 3];
    for seed in 0..SEEDS {
        let mut pair = Pair::new(seed, [true; 2]);
        for _ in 0..10 {
            pair.run([Motion::Still; 2], 1.0);
            pair.register();
        }
        let error = |pair: &Pair, k: usize| so3::log(pair.truth[k].orientation * pair.filters[k].state().unwrap().orientation().quaternion().conjugate());
        let before = [error(&pair, 0), error(&pair, 1)];
        let mut waited = 0.0;
        for (k, at) in [0.01, 1.0, 10.0].into_iter().enumerate() {
            pair.run([Motion::Still; 2], at - waited);
            waited = at;
            let [a, b] = pair.estimates();
            let tied = b.tie.unwrap();
            let d = a.drift;
            let m = tied.mark;
            let diag = |m: DMat3| DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z);
            let sq = |v: DVec3| v * v;
            let s = &mut sums[k];
            s[0] += sq(error(&pair, 0) - before[0]);
            s[1] += sq(error(&pair, 1) - before[1]);
            s[2] += DVec3::splat(d.angle_rad2 - m.angle_rad2);
            s[3] += DVec3::splat((d.bias_rad - m.bias_rad).powi(2));
            s[4] += d.turned_rad2 - m.turned_rad2;
            s[5] += diag(tied.own[0]);
            let left = tied.shares[0][0] - DMat3::IDENTITY;
            s[6] += diag(left * tied.anchor_covariance[0] * left.transpose());
            s[7] += sq(pair.filters[0].state().unwrap().gyro_bias - pair.truth[0].gyro_bias);
        }
    }
    for s in sums {
        for (name, v) in ["moved a", "moved b", "noise", "bias", "corrected", "own", "left", "biaserr"].iter().zip(s) {
            let v = v / SEEDS as f64;
            println!("{name}: {:.4} {:.4} {:.4} deg", v.x.sqrt().to_degrees(), v.y.sqrt().to_degrees(), v.z.sqrt().to_degrees());
        }
        println!();
    }
}
