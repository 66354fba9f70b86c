//! What holds for every trajectory, and what makes each the one it is.

use glam::{DQuat, DVec3};
use lodestone_config::model::{
    Synthetic,
    TrajectoryKind::{self, Car, Circles, ModelVehicle, Stairs, Standing, Tumble, Turns, Walk},
};
use proptest::prelude::*;

use crate::driver::synthetic::kinematics::{Earth, Motion, Mover};
use crate::driver::synthetic::random::Stream;

const KINDS: [TrajectoryKind; 8] =
    [Standing, Walk, Stairs, ModelVehicle, Car, Turns, Tumble, Circles];
const SAMPLE_S: f64 = 0.0025;
const REST_S: f64 = 2.0;

fn mover(kind: TrajectoryKind, seed: u64) -> Mover {
    let synthetic = Synthetic { trajectory: kind, rest_s: REST_S, ..Synthetic::default() };
    Mover::new(super::build(&synthetic, &mut Stream::Trajectory.of(seed)))
}

fn samples(mover: &Mover, from_s: f64, duration_s: f64) -> impl Iterator<Item = Motion> {
    let count = (duration_s / SAMPLE_S) as u32;
    (0..=count).map(move |k| mover.at(from_s + f64::from(k) * SAMPLE_S))
}

/// Largest jerk, m/s³, and largest angular acceleration, rad/s², that the motion may have.
const fn roughness(kind: TrajectoryKind) -> (f64, f64) {
    match kind {
        Standing => (0.0, 0.0),
        Walk => (60.0, 9.0),
        Stairs => (80.0, 9.0),
        ModelVehicle => (30.0, 7.0),
        Car => (200.0, 3.0),
        Turns => (2.0, 1.0),
        Tumble => (2.0, 4.0),
        Circles => (10.0, 1.0),
    }
}

/// Rotation vector from one attitude to another, rad, the shorter way round.
fn angle_between(from: DQuat, to: DQuat) -> DVec3 {
    let turn = from.conjugate() * to;
    if turn.w < 0.0 { (-turn).to_scaled_axis() } else { turn.to_scaled_axis() }
}

/// Position and velocity follow the acceleration, attitude follows the rate, and neither
/// acceleration nor rate jumps, from one sample to the next.
fn is_continuous(kind: TrajectoryKind, mover: &Mover, from_s: f64, duration_s: f64) {
    let (jerk, turning) = roughness(kind);
    let all: Vec<_> = samples(mover, from_s, duration_s).collect();
    for (k, pair) in all.windows(2).enumerate() {
        let (a, b, h) = (pair[0], pair[1], SAMPLE_S);
        let at = || format!("{kind:?} at {} s", from_s + k as f64 * h);
        let position = a.position + a.velocity * h + a.acceleration * (0.5 * h * h);
        assert!((b.position - position).length() <= jerk * h * h * h / 6.0 + 1e-9, "{}", at());
        let velocity = a.velocity + (a.acceleration + b.acceleration) * (0.5 * h);
        assert!((b.velocity - velocity).length() <= 0.25 * jerk * h * h + 1e-9, "{}", at());
        assert!((b.acceleration - a.acceleration).length() <= jerk * h + 1e-9, "{}", at());
        assert!((b.rate - a.rate).length() <= turning * h + 1e-9, "{}", at());
        let turned = angle_between(a.orientation.quaternion(), b.orientation.quaternion());
        let expected = (a.rate + b.rate) * (0.5 * h);
        assert!((turned - expected).length() <= 0.25 * turning * h * h + 1e-9, "{}", at());
    }
}

#[test]
fn nothing_jumps_over_a_whole_round() {
    for kind in KINDS {
        is_continuous(kind, &mover(kind, 1), 0.0, 300.0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn nothing_jumps_for_any_seed(seed: u64, from_s in 0.0..20_000.0f64) {
        for kind in KINDS {
            is_continuous(kind, &mover(kind, seed), from_s, 5.0);
        }
    }

    #[test]
    fn it_begins_at_the_origin_and_rests(seed: u64) {
        for kind in KINDS {
            let mover = mover(kind, seed);
            for motion in samples(&mover, -0.1, REST_S + 0.1) {
                prop_assert_eq!(motion.position, DVec3::ZERO);
                prop_assert_eq!(motion.velocity, DVec3::ZERO);
                prop_assert_eq!(motion.acceleration, DVec3::ZERO);
                prop_assert_eq!(motion.rate, DVec3::ZERO);
            }
            let moved = mover.at(REST_S + 5.0).position.length();
            prop_assert!((moved > 1e-3) == (kind != Standing), "{kind:?} moved {moved} m");
        }
    }

    #[test]
    fn seeds_make_different_cameras(seed in 0..u64::MAX) {
        for kind in KINDS {
            let (one, two) = (mover(kind, seed).at(20.0), mover(kind, seed + 1).at(20.0));
            prop_assert!(one.orientation != two.orientation);
        }
    }
}

/// What strapdown integration carries along.
#[derive(Clone, Copy)]
struct State {
    orientation: DQuat,
    velocity: DVec3,
    position: DVec3,
}

impl State {
    fn of(motion: &Motion) -> Self {
        Self {
            orientation: motion.orientation.quaternion(),
            velocity: motion.velocity,
            position: motion.position,
        }
    }

    fn plus(self, slope: &Self, h: f64) -> Self {
        Self {
            orientation: self.orientation + slope.orientation * h,
            velocity: self.velocity + slope.velocity * h,
            position: self.position + slope.position * h,
        }
    }

    /// Derivative under what the sensors feel: the equations of maths.md, eq:ResultingAcceleration
    /// and eq:QuatrionAngularVelocityV1 with the earth's rate, written anew.
    fn slope(self, earth: &Earth, rate: DVec3, force: DVec3) -> Self {
        let pure = |v: DVec3| DQuat::from_xyzw(v.x, v.y, v.z, 0.0);
        let turning = self.orientation * pure(rate) - pure(earth.rate) * self.orientation;
        let felt = self.orientation.normalize() * force;
        Self {
            orientation: turning * 0.5,
            velocity: felt + earth.gravity - 2.0 * earth.rate.cross(self.velocity),
            position: self.velocity,
        }
    }
}

/// Classic Runge-Kutta integration, on an earth that is `assumed`, of exact gyroscope and
/// accelerometer values from the real one.
fn integrate(mover: &Mover, earth: &Earth, assumed: &Earth, duration_s: f64, step_s: f64) -> State {
    let felt = |t: f64| {
        let motion = mover.at(t);
        (earth.inertial_rate(&motion), earth.specific_force(&motion))
    };
    let mut state = State::of(&mover.at(0.0));
    let mut begin = felt(0.0);
    for k in 0..(duration_s / step_s).round() as u32 {
        let t = f64::from(k) * step_s;
        let (middle, end) = (felt(t + 0.5 * step_s), felt(t + step_s));
        let s1 = state.slope(assumed, begin.0, begin.1);
        let s2 = state.plus(&s1, 0.5 * step_s).slope(assumed, middle.0, middle.1);
        let s3 = state.plus(&s2, 0.5 * step_s).slope(assumed, middle.0, middle.1);
        let s4 = state.plus(&s3, step_s).slope(assumed, end.0, end.1);
        state = state.plus(&s1, step_s / 6.0).plus(&s2, step_s / 3.0);
        state = state.plus(&s3, step_s / 3.0).plus(&s4, step_s / 6.0);
        state.orientation = state.orientation.normalize();
        begin = end;
    }
    state
}

/// Global error of the scheme is of the order h⁴ with the motion's fifth derivatives. The fastest
/// motion is the car's shake at some 170 rad/s: (170 · 1e-3)⁴ / 2880 is 3e-7 of amplitudes of
/// 2e-4 rad and 1 m/s², which leaves far less than the bounds even after integrating twice.
#[test]
fn strapdown_integration_of_what_is_felt_gives_the_motion_back() {
    let earth = Earth::at(48.262, 0.07);
    for kind in KINDS {
        let mover = mover(kind, 11);
        let (end, truth) = (integrate(&mover, &earth, &earth, 60.0, 1e-3), mover.at(60.0));
        let attitude = angle_between(truth.orientation.quaternion(), end.orientation).length();
        let position = (end.position - truth.position).length();
        assert!(attitude < 1e-6, "{kind:?}: {attitude} rad");
        assert!(position < 1e-3, "{kind:?}: {position} m");
    }
}

/// The check above sees the earth: leave its rotation out of the integration, and the Coriolis
/// term and the turned attitude cost metres within a minute.
#[test]
fn strapdown_integration_without_the_earths_rotation_is_metres_off() {
    let earth = Earth::at(48.262, 0.07);
    let mover = mover(Car, 11);
    let still = Earth { rate: DVec3::ZERO, ..earth };
    let end = integrate(&mover, &earth, &still, 60.0, 5e-3);
    assert!((end.position - mover.at(60.0).position).length() > 2.0);
}

#[test]
fn gravity_alone_is_felt_at_rest() {
    let earth = Earth::at(48.262, 0.07);
    for kind in KINDS {
        let force = earth.specific_force(&mover(kind, 3).at(0.5 * REST_S));
        assert!((force.length() - 9.81).abs() < 1e-12, "{kind:?}: {force}");
    }
}

fn horizontal_speed(motion: &Motion) -> f64 {
    motion.velocity.truncate().length()
}

#[test]
fn the_car_drives_up_to_80_km_h_and_stops_at_lights() {
    for seed in 0..10 {
        let all: Vec<_> = samples(&mover(Car, seed), 0.0, 300.0).collect();
        let top = all.iter().map(horizontal_speed).fold(0.0, f64::max) * 3.6;
        assert!((70.0..=80.0).contains(&top), "seed {seed}: {top} km/h");
        let stopped = |m: &Motion| horizontal_speed(m) == 0.0 && m.rate == DVec3::ZERO;
        let stops = all.windows(2).filter(|w| !stopped(&w[0]) && stopped(&w[1])).count();
        assert!(stops >= 3, "seed {seed}: {stops} stops");
        let strongest = all.iter().map(|m| m.acceleration.length()).fold(0.0, f64::max);
        assert!((2.0..6.0).contains(&strongest), "seed {seed}: {strongest} m/s²");
    }
}

#[test]
fn a_walker_who_halts_on_landings_goes_the_same_way_and_truly_stands_there() {
    let walker = |halt_s: f64| {
        let trajectory = Stairs;
        let synthetic = Synthetic { trajectory, rest_s: REST_S, halt_s, ..Synthetic::default() };
        Mover::new(super::build(&synthetic, &mut Stream::Trajectory.of(3)))
    };
    let (on, halting) = (walker(0.0), walker(2.0));
    is_continuous(Stairs, &halting, 0.0, 80.0);
    let half = 12.0 * 0.17;
    let on_landings_s = |mover: &Mover| {
        let stands = |m: &Motion| m.velocity.length() < 1e-9 && (m.position.z - half).abs() < 0.01;
        samples(mover, 0.0, 60.0).filter(stands).count() as f64 * SAMPLE_S
    };
    let halted_s = on_landings_s(&halting);
    assert!((halted_s - 4.0).abs() < 0.1, "two halts of two seconds: {halted_s} s");
    assert!(on_landings_s(&on) < 0.1);
    // Where one is at the end of the first flight, the other is too.
    let nearest = |place: DVec3| {
        samples(&halting, 0.0, 80.0).map(|m| m.position.distance(place)).fold(9.0, f64::min)
    };
    let away = [6.0, 9.0, 14.0, 30.0].map(|at| nearest(on.at(at).position));
    assert!(away.iter().all(|m| *m < 0.003), "{away:?}");
}

#[test]
fn the_stairs_go_up_4_m_and_come_back() {
    for seed in 0..10 {
        let all: Vec<_> = samples(&mover(Stairs, seed), 0.0, 120.0).collect();
        let top = all.iter().map(|m| m.position.z).fold(0.0, f64::max);
        assert!((top - 24.0 * 0.17).abs() < 1e-9, "seed {seed}: {top} m");
        let lowest = all.iter().map(|m| m.position.z).fold(0.0, f64::min);
        assert!(lowest.abs() < 1e-9);
        let risen = all.iter().position(|m| m.position.z > 4.0).unwrap();
        assert!(all[risen..].iter().any(|m| m.position.z < 1e-9), "seed {seed}: never down again");
    }
}

#[test]
fn indoors_everything_stays_in_its_room_and_keeps_its_pace() {
    for seed in 0..10 {
        for (kind, reach, fastest, height) in
            [(Walk, 5.5, 1.9, 0.2), (ModelVehicle, 6.5, 1.0, 0.01), (Stairs, 6.0, 1.0, 4.2)]
        {
            let mover = mover(kind, seed);
            for motion in (0..8000).map(|k| mover.at(f64::from(k) * 0.05)) {
                let place = motion.position.truncate().length();
                assert!(place < reach, "{kind:?} {seed}: {place} m away");
                assert!(motion.position.z.abs() < height, "{kind:?} {seed}: {}", motion.position);
                let speed = horizontal_speed(&motion);
                assert!(speed < fastest + 1e-9, "{kind:?} {seed}: {speed} m/s");
            }
        }
    }
}

#[test]
fn the_walk_looks_around_and_pauses_and_does_not_repeat() {
    let all: Vec<_> = samples(&mover(Walk, 5), 0.0, 120.0).collect();
    let rate = all.iter().map(|m| m.rate.length()).fold(0.0, f64::max);
    assert!((0.8..4.0).contains(&rate), "{rate} rad/s");
    let resting = all.iter().filter(|m| m.rate == DVec3::ZERO).count() as f64 * SAMPLE_S;
    assert!(resting > REST_S + 3.0, "{resting} s");
    let mover = mover(Walk, 5);
    let closest = (200..2000)
        .map(|later| (mover.at(f64::from(later) * 0.1).position - mover.at(12.0).position).length())
        .filter(|distance| *distance > 0.0)
        .fold(f64::INFINITY, f64::min);
    assert!(closest > 1e-4, "{closest} m");
}

/// What a calibration wants of a camera that can be lifted: every axis points everywhere.
#[test]
fn tumbling_turns_every_axis_everywhere() {
    for seed in 0..10 {
        let all: Vec<_> = samples(&mover(Tumble, seed), REST_S, 70.0).collect();
        for axis in DVec3::AXES {
            let up = |m: &Motion| m.orientation.apply(axis).z;
            let highest = all.iter().map(up).fold(-1.0, f64::max);
            let lowest = all.iter().map(up).fold(1.0, f64::min);
            assert!(highest > 0.85 && lowest < -0.85, "seed {seed}: {lowest} to {highest}");
        }
        let fastest = all.iter().map(|m| m.rate.length()).fold(0.0, f64::max);
        assert!((0.5..2.5).contains(&fastest), "seed {seed}: {fastest} rad/s");
    }
}

#[test]
fn a_calibrating_car_turns_twice_to_each_side_on_ground_of_one_slope() {
    let slope_deg = 5.0_f64;
    for seed in 0..10 {
        let all: Vec<_> = samples(&mover(Circles, seed), REST_S, 96.0).collect();
        let turned = |side: f64| {
            let rates = all.iter().map(|m| (m.rate.z * side).max(0.0) * SAMPLE_S);
            rates.sum::<f64>() / std::f64::consts::TAU
        };
        for side in [1.0, -1.0] {
            assert!((turned(side) - 2.0).abs() < 0.03, "seed {seed}: {} turns", turned(side));
        }
        for motion in &all {
            let tilt_deg = motion.orientation.apply(DVec3::Z).z.acos().to_degrees();
            assert!((tilt_deg - slope_deg).abs() < 1e-9, "seed {seed}: {tilt_deg}°");
            let forward = motion.orientation.apply(DVec3::X);
            let off_track = motion.velocity.normalize_or_zero().cross(forward).length();
            // Its speed is that of the level circle; only the slope's square is left aside.
            assert!(off_track < 0.02 || motion.velocity.length() < 1e-6, "{off_track}");
        }
        let fastest = all.iter().map(horizontal_speed).fold(0.0, f64::max);
        assert!((1.4..1.6).contains(&fastest), "seed {seed}: {fastest} m/s");
    }
}
