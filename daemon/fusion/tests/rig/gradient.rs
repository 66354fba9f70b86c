//! Walks past steel: what the gradient is worth, and that it declines where it is worth nothing.

use lodestone_fusion::rig::GradientVerdict;
use lodestone_fusion::so3;

use crate::scene::{Scene, Settings};
use crate::steel;

/// What a walk gave.
#[derive(Debug, Default)]
pub(crate) struct Outcome {
    /// Error of the filter's velocity while the gate is open, m/s.
    pub(crate) velocity: Vec<f64>,
    pub(crate) world: Vec<f64>,
    pub(crate) aligned: Vec<f64>,
    /// Error of the windows' own velocity, m/s, and its NEES per direction.
    pub(crate) window: Vec<f64>,
    pub(crate) window_nees: Vec<f64>,
    pub(crate) nees: Vec<f64>,
    pub(crate) tilt: Vec<f64>,
    /// Verdicts, and how often.
    pub(crate) verdicts: Vec<(GradientVerdict, usize)>,
    pub(crate) gradient: Vec<f64>,
    pub(crate) nis: Vec<f64>,
    /// m.
    pub(crate) position_error: f64,
}

pub(crate) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

pub(crate) fn walk(settings: Settings, seed: u64) -> Outcome {
    let mut scene = Scene::new(settings, seed);
    let mut outcome = Outcome::default();
    let start = scene.position();
    let (mut open, mut turned_at_start) = (false, None);
    while scene.time_s() < 63.0 {
        let report = scene.step(|_, _| {});
        if scene.time_s() > 2.9 && turned_at_start.is_none() {
            let q = scene.filter.estimate().unwrap().orientation.quaternion();
            turned_at_start = Some(q * scene.orientation().conjugate());
        }
        let Some(gradient) = report.and_then(|r| r.gradient) else {
            if open && scene.filter.estimate().is_some() {
                let estimate = scene.filter.estimate().unwrap();
                let body = estimate.orientation.inverse().apply(estimate.velocity);
                let truth = scene.orientation().conjugate() * scene.velocity();
                outcome.velocity.push((body - truth).length());
                let truth = turned_at_start.unwrap() * scene.velocity();
                outcome.aligned.push((estimate.velocity - truth).length());
                outcome.world.push((estimate.velocity - scene.velocity()).length());
            }
            continue;
        };
        open = gradient.verdict == GradientVerdict::Open;
        match outcome.verdicts.iter_mut().find(|(v, _)| *v == gradient.verdict) {
            Some((_, count)) => *count += 1,
            None => outcome.verdicts.push((gradient.verdict, 1)),
        }
        outcome.gradient.push(steel::gradient_norm(&scene.settings.steel, scene.position()));
        outcome.nis.push(gradient.nis);
        if open {
            let estimate = scene.filter.estimate().unwrap();
            // Heading aside.
            let turned = estimate.orientation.quaternion() * scene.orientation().conjugate();
            let truth = turned * scene.velocity();
            let error = gradient.velocity_m_s - truth;
            let inverse = gradient.covariance.inverse();
            outcome.window_nees.push(error.dot(inverse * error) / f64::from(gradient.directions));
            if gradient.directions == 3 {
                outcome.window.push(error.length());
            }
            let error = estimate.velocity - truth;
            let tilt = so3::log(scene.orientation() * estimate.orientation.quaternion().conjugate());
            let p = estimate.orientation_covariance;
            outcome.tilt.push(0.5 * (tilt.x.powi(2) / p.x_axis.x + tilt.y.powi(2) / p.y_axis.y));
            outcome.nees.push(error.dot(estimate.velocity_covariance.inverse() * error) / 3.0);
        }
    }
    let estimate = scene.filter.estimate().unwrap();
    outcome.position_error = (estimate.position - (scene.position() - start)).length();
    outcome
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

pub(crate) fn summarise(what: &str, settings: impl Fn(u64) -> Settings, seeds: u64) {
    let mut all = Outcome::default();
    let (mut with, mut without) = (Vec::new(), Vec::new());
    for seed in 0..seeds {
        let outcome = walk(settings(seed), seed);
        let mut off = settings(seed);
        off.parameters.gradient = None;
        without.push(walk(off, seed).position_error);
        with.push(outcome.position_error);
        all.velocity.extend(outcome.velocity);
        all.window.extend(outcome.window);
        all.world.extend(outcome.world);
        all.aligned.extend(outcome.aligned);
        all.window_nees.extend(outcome.window_nees);
        all.nees.extend(outcome.nees);
        all.tilt.extend(outcome.tilt);
        all.gradient.extend(outcome.gradient);
        all.nis.extend(outcome.nis);
        for (v, n) in outcome.verdicts {
            match all.verdicts.iter_mut().find(|(o, _)| *o == v) {
                Some((_, count)) => *count += n,
                None => all.verdicts.push((v, n)),
            }
        }
    }
    println!(
        "{what}: v {:.3} world {:.3} aligned {:.3} window {:.3} wNEES {:.2} (med {:.2}) vNEES {:.2} tilt {:.2} G {:.1} nis {:.2}/{:.2} pos {:.2} without {:.2} ratio {:.1} {:?}",
        median(&all.velocity), median(&all.world), median(&all.aligned), median(&all.window), mean(&all.window_nees), median(&all.window_nees),
        mean(&all.nees), mean(&all.tilt), median(&all.gradient), median(&all.nis), mean(&all.nis), median(&with), median(&without),
        median(&without) / median(&with), all.verdicts
    );
}

#[test]
fn explore() {
    summarise("indoors", Settings::indoors, 4);
    summarise("bias 0.2", |seed| Settings { mag_bias_ut: 0.2, ..Settings::indoors(seed) }, 4);
    summarise("uniform", |seed| Settings { steel: Vec::new(), ..Settings::indoors(seed) }, 2);
}
