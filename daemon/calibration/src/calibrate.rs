//! From samples to an outcome, or to what is missing.

use glam::{DMat3, DQuat, DVec3};
use nalgebra::DMatrix;

use crate::coverage::{Attitudes, CoverageMeter};
use crate::heading::HeadingError;
use crate::linear::dvec;
use crate::outcome::{
    AccelerometerErrors, FieldFound, GyroErrors, MagnetometerErrors, Outcome, TemperatureSpan,
};
use crate::solve::parameters::{ACCEL, FIELD, GYRO, GYRO_SLOPE, HARD, HARD_SLOPE, SOFT};
use crate::solve::{self, Fit, Problem};
use crate::stream::Stream;
use crate::verdict;
use crate::{Coverage, Refusal, Sample, Settings};

/// A component of the accelerometer's bias is shown if its σ is below this part of the prior's.
const SHOWN: f64 = 0.3;

/// Calibrates from a recording.
///
/// # Errors
/// [`Refusal`] if the recording cannot tell, with what it lacks.
pub fn calibrate(samples: &[Sample], settings: &Settings) -> Result<Outcome, Refusal> {
    let stream = Stream::new(samples);
    let mut meter = CoverageMeter::default();
    for sample in samples {
        meter.add(sample);
    }
    let missing = verdict::before_fit(&stream, &meter.coverage(), &settings.limits);
    let refuse = |missing, coverage| Refusal { missing, heading_sigma_deg: None, coverage };
    if !missing.is_empty() {
        return Err(refuse(missing, meter.coverage()));
    }
    let problem = Problem::new(&stream, settings);
    let Some(fit) = solve::fit(&problem, settings) else {
        let missing = vec![verdict::unsolvable(settings)];
        return Err(refuse(missing, meter.coverage()));
    };
    let mut attitudes = Attitudes::default();
    for knot in &fit.state.knots {
        attitudes.add(knot.attitude);
    }
    let coverage = meter.with(&attitudes);
    let outcome = outcome(&problem, &fit, settings, coverage, attitudes.mean_up());
    let missing = verdict::after_fit(&outcome, &fit, settings);
    if missing.is_empty() {
        return Ok(outcome);
    }
    let heading_sigma_deg = Some(outcome.magnetometer.heading_sigma_deg);
    Err(Refusal { missing, heading_sigma_deg, coverage })
}

fn outcome(
    problem: &Problem<'_>,
    fit: &Fit,
    settings: &Settings,
    coverage: Coverage,
    mean_up: DVec3,
) -> Outcome {
    Outcome {
        magnetometer: magnetometer(problem, fit, settings.level_up.unwrap_or(mean_up)),
        gyro: gyro(problem, fit),
        accelerometer: accelerometer(fit, settings),
        temperature: problem
            .stream
            .temperature_c
            .map(|[min_c, max_c, reference_c]| TemperatureSpan { min_c, max_c, reference_c }),
        coverage,
        iterations: fit.iterations,
    }
}

fn magnetometer(problem: &Problem<'_>, fit: &Fit, level_up: DVec3) -> MagnetometerErrors {
    let globals = &fit.state.globals;
    let error = HeadingError::new(globals, &fit.covariance);
    let seen: Vec<(DQuat, f64)> = fit
        .state
        .knots
        .iter()
        .zip(&problem.segments)
        .map(|(knot, segment)| (knot.attitude, segment.warmer_k))
        .collect();
    let soft_iron = globals.soft_iron().inverse();
    let slope = globals.vector(HARD_SLOPE);
    MagnetometerErrors {
        soft_iron,
        hard_iron_ut: globals.vector(HARD),
        hard_iron_slope_ut_k: problem.has_slopes.then_some(slope),
        covariance: covariance(fit, soft_iron, problem.has_slopes),
        heading_sigma_deg: error.over(&seen).to_degrees(),
        level_heading_sigma_deg: error.level(level_up).to_degrees(),
        residual_ut: fit.noise.mag,
        field: field(fit),
    }
}

/// Of `C` row by row, hard iron and slope: `A Exp(δ)` moves `C` by `−δ C`.
fn covariance(fit: &Fit, correction: DMat3, has_slope: bool) -> Vec<Vec<f64>> {
    let size = if has_slope { 15 } else { 12 };
    let mut to_file = DMatrix::<f64>::identity(size, size);
    to_file.view_mut((SOFT, SOFT), (9, 9)).fill(0.0);
    for (i, j, k) in (0..27).map(|n| (n / 9, n / 3 % 3, n % 3)) {
        to_file[(SOFT + 3 * i + j, SOFT + 3 * i + k)] = -correction.col(j)[k];
    }
    let found = fit.covariance.view((SOFT, SOFT), (size, size));
    let covariance = &to_file * found * to_file.transpose();
    covariance.row_iter().map(|row| row.iter().copied().collect()).collect()
}

fn field(fit: &Fit) -> FieldFound {
    let (north, down) = (fit.state.globals.0[FIELD], fit.state.globals.0[FIELD + 1]);
    let strength = north.hypot(down);
    let covariance = fit.covariance.fixed_view::<2, 2>(FIELD, FIELD);
    let sigma = |by: [f64; 2]| {
        let by = nalgebra::Vector2::from(by);
        (by.transpose() * covariance * by)[0].max(0.0).sqrt()
    };
    let square = strength * strength;
    FieldFound {
        strength_ut: strength,
        strength_sigma_ut: sigma([north / strength, down / strength]),
        dip_deg: down.atan2(north).to_degrees(),
        dip_sigma_deg: sigma([-down / square, north / square]).to_degrees(),
    }
}

fn gyro(problem: &Problem<'_>, fit: &Fit) -> GyroErrors {
    let knots = &fit.state.knots;
    let walked = knots.iter().fold(DVec3::ZERO, |sum, knot| sum + knot.bias) / knots.len() as f64;
    let slope = fit.state.globals.vector(GYRO_SLOPE);
    GyroErrors {
        bias_rad_s: fit.state.globals.vector(GYRO) + walked,
        bias_sigma_rad_s: sigmas(fit, GYRO),
        bias_slope_rad_s_k: problem.has_slopes.then_some(slope),
    }
}

fn accelerometer(fit: &Fit, settings: &Settings) -> Option<AccelerometerErrors> {
    let bias_sigma_m_s2 = sigmas(fit, ACCEL);
    let shown = SHOWN * settings.noise.accel_bias_sigma_m_s2;
    (bias_sigma_m_s2.min_element() < shown).then(|| AccelerometerErrors {
        bias_m_s2: fit.state.globals.vector(ACCEL),
        bias_sigma_m_s2,
    })
}

fn sigmas(fit: &Fit, at: usize) -> DVec3 {
    let diagonal = fit.covariance.diagonal();
    dvec(diagonal.fixed_rows::<3>(at).map(|variance| variance.max(0.0).sqrt()))
}
