//! Walks past steel: what the gradient is worth, and that it declines where it is worth nothing.

use glam::DVec3;
use lodestone_fusion::rig::{GradientVerdict, RigReport};

use crate::scene::{Scene, Settings, along, polygon};
use crate::steel;

/// What a walk of a minute gave.
#[derive(Debug, Default)]
struct Outcome {
    /// Error of the velocity in the world while the gate is open, m/s.
    velocity: Vec<f64>,
    /// Error of the velocity in the rig's own axes, which no heading spoils, while the gate is open, m/s.
    in_axes: Vec<f64>,
    /// NEES of it per axis, where a window opened.
    nees: Vec<f64>,
    /// Windows, those that opened, and those that were used at all.
    windows: usize,
    open: usize,
    used: usize,
    /// Frobenius norm of the true gradient, µT/m.
    gradient: Vec<f64>,
    /// At the end, m.
    position_error: f64,
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Time at which the walk ends, s: a minute after it began.
const END_S: f64 = 63.0;

/// A walk, followed by the filter.
struct Followed {
    scene: Scene,
    outcome: Outcome,
    open: bool,
}

impl Followed {
    fn new(settings: Settings, seed: u64) -> Self {
        let scene = Scene::new(settings, seed);
        Self { scene, outcome: Outcome::default(), open: false }
    }

    fn through(mut self) -> Outcome {
        let start = self.scene.position();
        while self.scene.time_s() < END_S {
            let report = self.scene.step(|_, _| {});
            if self.scene.time_s() > 2.9 {
                self.look(report);
            }
        }
        let estimate = self.scene.filter.estimate().expect("aligned");
        let way = self.scene.position() - start;
        self.outcome.position_error = (estimate.position - way).length();
        self.outcome
    }

    fn look(&mut self, report: Option<RigReport>) {
        let estimate = self.scene.filter.estimate().expect("three seconds of rest align");
        let error = estimate.velocity - self.scene.velocity();
        if self.open {
            self.outcome.velocity.push(error.length());
        }
        if self.open {
            let own = estimate.orientation.inverse().apply(estimate.velocity);
            let truth = self.scene.orientation().conjugate() * self.scene.velocity();
            self.outcome.in_axes.push((own - truth).length());
        }
        let Some(gradient) = report.and_then(|r| r.gradient) else { return };
        self.open = gradient.verdict == GradientVerdict::Open;
        self.outcome.windows += 1;
        self.outcome.open += usize::from(self.open);
        self.outcome.used += usize::from(gradient.verdict.is_used());
        let steel = &self.scene.settings.steel;
        self.outcome.gradient.push(steel::gradient_norm(steel, self.scene.position()));
        if self.open {
            let inverse = estimate.velocity_covariance.inverse();
            self.outcome.nees.push(error.dot(inverse * error) / 3.0);
        }
    }
}

/// Walks with several seeds.
#[derive(Debug, Default)]
struct Walks {
    all: Outcome,
    with: Vec<f64>,
    without: Vec<f64>,
}

impl Walks {
    fn of(what: &str, seeds: u64, settings: impl Fn(u64) -> Settings) -> Self {
        let mut walks = Self::default();
        for seed in 0..seeds {
            let outcome = Followed::new(settings(seed), seed).through();
            let mut off = settings(seed);
            off.parameters.gradient = None;
            walks.without.push(Followed::new(off, seed).through().position_error);
            walks.with.push(outcome.position_error);
            walks.all.velocity.extend(outcome.velocity);
            walks.all.in_axes.extend(outcome.in_axes);
            walks.all.nees.extend(outcome.nees);
            walks.all.gradient.extend(outcome.gradient);
            walks.all.windows += outcome.windows;
            walks.all.open += outcome.open;
            walks.all.used += outcome.used;
        }
        println!("{what}: {walks}");
        walks
    }

    fn velocity_error(&self) -> f64 {
        median(&self.all.velocity)
    }

    fn error_in_axes(&self) -> f64 {
        median(&self.all.in_axes)
    }

    fn gain(&self) -> f64 {
        median(&self.without) / median(&self.with)
    }

    fn nees(&self) -> f64 {
        self.all.nees.iter().sum::<f64>() / self.all.nees.len() as f64
    }
}

impl std::fmt::Display for Walks {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Outcome { windows, open, used, gradient, .. } = &self.all;
        write!(
            out,
            "gradient {:.1} µT/m, open {open} and used {used} of {windows}, velocity error {:.3} m/s (NEES {:.2}), \
             in the rig's axes {:.3} m/s, position error after a minute {:.2} m, without {:.2} m, gain {:.1}",
            median(gradient),
            self.velocity_error(),
            self.nees(),
            self.error_in_axes(),
            median(&self.with),
            median(&self.without),
            self.gain()
        )
    }
}

#[test]
fn past_steel_the_velocity_is_good_and_the_way_five_times_better() {
    // Steel turns the field where these walks begin, and with it the heading: the gate is the gradient's, so
    // its error is that of the velocity in the rig's own axes. The position is that in the world.
    let walks = Walks::of("indoors", 10, Settings::indoors);
    assert!(walks.error_in_axes() <= 0.06, "{walks}");
    assert!(walks.gain() >= 5.0, "{walks}");
    assert!((0.2..2.0).contains(&walks.nees()), "{walks}");
}

#[test]
fn from_clear_ground_the_velocity_in_the_world_is_as_good() {
    // Given a walk that begins five metres from any steel, so that its north is right
    let walks = Walks::of("from clear ground", 10, |seed| {
        let mut settings = Settings::indoors(seed);
        let start = Scene::new(settings.clone(), seed).position();
        settings.steel.retain(|dipole| dipole.position.distance(start) > 5.0);
        settings
    });
    assert!(walks.velocity_error() <= 0.06, "{walks}");
    assert!(walks.gain() >= 5.0, "{walks}");
    assert!((0.2..1.5).contains(&walks.nees()), "{walks}");
}

#[test]
fn a_rig_that_starts_beside_steel_doubts_its_heading_and_finds_north_on_its_way() {
    let (mut before, mut after) = (0.0, 0.0);
    for seed in 0..4 {
        // Given steel near where the rig is aligned, which turns the field there
        let mut settings = Settings::indoors(seed);
        let mut scene = Scene::new(settings.clone(), seed);
        let beside = scene.position() + DVec3::new(1.1, 0.3, -0.4);
        settings
            .steel
            .push(steel::Dipole { position: beside, moment: DVec3::new(120.0, -60.0, 40.0) });
        scene = Scene::new(settings, seed);
        let heading = |scene: &Scene| {
            let estimate = scene.filter.estimate().expect("aligned");
            let turn = estimate.orientation.quaternion() * scene.orientation().conjugate();
            (2.0 * (turn.z / turn.w).atan(), estimate.orientation_covariance.z_axis.z.sqrt())
        };
        while scene.time_s() < 4.0 {
            scene.step(|_, _| {});
        }
        // Then it says so as soon as it leaves
        let (error, sigma) = heading(&scene);
        assert!(error.abs() > 0.1 && error.abs() < 3.0 * sigma, "{seed}: {error} ± {sigma}");
        // And when it has walked for a minute past other steel, it knows better
        while scene.time_s() < END_S {
            scene.step(|_, _| {});
        }
        let (later, sure) = heading(&scene);
        println!("{seed}: {error:.3} ± {sigma:.3}, then {later:.3} ± {sure:.3}");
        assert!(later.abs() < 4.0 * sure && sure < 0.5 * sigma, "{seed}: {later} ± {sure}");
        (before, after) = (before + error * error, after + later * later);
    }
    assert!(after < 0.25 * before, "{after} after {before} rad²");
}

#[test]
fn what_calibrations_leave_is_learnt() {
    let walks = Walks::of("biases of 0.3 µT, scale errors of 0.7 %", 4, |seed| Settings {
        mag_bias_ut: 0.3,
        scale_error: 7e-3,
        ..Settings::indoors(seed)
    });
    assert!(walks.error_in_axes() <= 0.1, "{walks}");
    assert!(walks.gain() >= 5.0, "{walks}");
}

#[test]
fn four_cameras_do_better_than_three() {
    let three = Walks::of("three", 4, Settings::indoors);
    let four = Walks::of("four", 4, |seed| Settings {
        mountings: polygon(4, 0.5),
        ..Settings::indoors(seed)
    });
    assert!(four.error_in_axes() < three.error_in_axes());
    assert!(four.all.used > three.all.used);
}

#[test]
fn walking_fast_and_slowly_swaying_and_stopping() {
    let vary = |what, change: fn(&mut Settings)| {
        Walks::of(what, 4, |seed| {
            let mut settings = Settings::indoors(seed);
            change(&mut settings);
            settings
        })
    };
    let slow = vary("slow", |s| s.walk.speed_m_s = 0.5);
    assert!(slow.error_in_axes() <= 0.06 && slow.gain() >= 5.0, "{slow}");
    let fast = vary("fast", |s| s.walk.speed_m_s = 1.8);
    assert!(fast.error_in_axes() <= 0.12 && fast.gain() >= 5.0, "{fast}");
    let swaying = vary("swaying", |s| (s.walk.bounce_m, s.walk.sway_rad) = (0.04, 0.15));
    assert!(swaying.error_in_axes() <= 0.08 && swaying.gain() >= 5.0, "{swaying}");
    let stopping = vary("stopping", |s| {
        s.walk.starts_and_stops = vec![3.0, 10.0, 13.0, 22.0, 24.0, 35.0, 45.0, 55.0, 58.0];
    });
    assert!(stopping.error_in_axes() <= 0.06 && median(&stopping.with) < 1.8, "{stopping}");
}

#[test]
fn denser_and_farther_steel() {
    let walks = Walks::of("dense", 4, |seed| {
        let mut settings = Settings::indoors(seed);
        settings.steel = along(&settings.walk, seed, 1.0, 200.0, 1.5..2.5);
        settings
    });
    assert!(walks.error_in_axes() <= 0.09 && walks.gain() >= 5.0, "{walks}");
    let walks = Walks::of("far", 4, |seed| {
        let mut settings = Settings::indoors(seed);
        settings.steel = along(&settings.walk, seed, 2.7, 1000.0, 2.4..3.6);
        settings
    });
    assert!(walks.error_in_axes() <= 0.08 && walks.gain() >= 5.0, "{walks}");
}

#[test]
fn in_a_uniform_field_the_gate_stays_shut_and_nothing_is_lost() {
    for bias in [0.0, 0.3, 1.0] {
        let walks = Walks::of("uniform", 4, |seed| Settings {
            steel: Vec::new(),
            mag_bias_ut: bias,
            ..Settings::indoors(seed)
        });
        assert_eq!(walks.all.used, 0, "{walks}");
        assert!(walks.gain() > 0.97, "{walks}");
    }
}

#[test]
fn the_rigs_own_field_carries_no_velocity() {
    // Given magnets of several µT on the rig that no calibration took out, when it walks in a uniform
    // field, then its gradient, which moves along, does no harm.
    let walks = Walks::of("own field", 6, |seed| Settings {
        steel: Vec::new(),
        mag_bias_ut: 5.0,
        ..Settings::indoors(seed)
    });
    assert!(walks.all.used * 100 <= walks.all.windows, "{walks}");
    assert!(walks.gain() > 0.95, "{walks}");
}

#[test]
fn two_cameras_and_cameras_in_a_line_tell_no_velocity() {
    let line = |count: usize| {
        let mut mountings = polygon(count, 0.5);
        for (k, mounting) in mountings.iter_mut().enumerate() {
            let place = DVec3::Y * (0.3 * k as f64);
            (mounting.imu_m, mounting.magnetometer_m) = (place, place);
        }
        mountings
    };
    for count in [2, 3] {
        let settings = Settings { mountings: line(count), ..Settings::indoors(1) };
        let outcome = Followed::new(settings, 1).through();
        assert_eq!((outcome.windows, outcome.open), (0, 0), "{count} in a line");
    }
}
