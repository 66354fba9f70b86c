//! Is a rig as good as its number of cameras, and does it know?

use glam::{DMat3, DVec3};
use lodestone_fusion::{ACCEL_BIAS, GYRO_BIAS, so3};

use crate::scene::{Scene, Settings, polygon};

fn uniform(count: usize) -> Settings {
    let mut settings = Settings::indoors(0);
    settings.steel.clear();
    settings.mountings = polygon(count, 0.5);
    settings
}

/// 1σ of the rate's noise per axis, from step to step, of a rig at rest, rad/s.
fn rate_noise(count: usize, seed: u64) -> f64 {
    let mut scene = Scene::new(uniform(count), seed);
    let mut rates: Vec<DVec3> = Vec::new();
    while scene.time_s() < 2.9 {
        scene.step(|_, _| {});
        rates.extend(scene.filter.estimate().map(|e| e.angular_rate));
    }
    let differences = rates.windows(2).map(|w| (w[1] - w[0]).length_squared());
    (differences.sum::<f64>() / (rates.len() - 1) as f64 / 6.0).sqrt()
}

#[test]
fn gyro_noise_falls_with_the_root_of_the_number_of_cameras() {
    let one = rate_noise(1, 3);
    for count in [2, 3, 4, 8] {
        let ratio = one / rate_noise(count, 3);
        let expected = (count as f64).sqrt();
        assert!((ratio / expected - 1.0).abs() < 0.1, "{count} cameras: {ratio:.2}");
    }
}

/// Sums of NEES per degree of freedom over seeds and times.
#[derive(Default)]
struct Nees {
    tilt: f64,
    gyro_bias: f64,
    accel_bias: f64,
    heading_error_2: f64,
    count: f64,
}

fn normalised(error: DVec3, covariance: DMat3) -> f64 {
    error.dot(covariance.inverse() * error) / 3.0
}

impl Nees {
    fn look(&mut self, scene: &Scene) {
        let state = scene.filter.estimator().state().expect("aligned");
        let covariance = |block| state.covariance.block(block, block);
        let estimated = state.orientation().quaternion();
        let error = so3::log(scene.orientation() * estimated.conjugate());
        let p = covariance(lodestone_fusion::ORIENTATION);
        self.tilt += 0.5 * (error.x.powi(2) / p.x_axis.x + error.y.powi(2) / p.y_axis.y);
        self.heading_error_2 += error.z.powi(2);
        let (gyro_bias, accel_bias) = scene.mean_biases();
        self.gyro_bias += normalised(gyro_bias - state.gyro_bias, covariance(GYRO_BIAS));
        self.accel_bias += normalised(accel_bias - state.accel_bias, covariance(ACCEL_BIAS));
        self.count += 1.0;
    }

    /// A minute of walking, 24 seeds.
    fn of(count: usize) -> Self {
        let mut nees = Self::default();
        for seed in 0..24 {
            let mut scene = Scene::new(Settings { scale_error: 7e-3, ..uniform(count) }, seed);
            let mut next_s = 10.0;
            while scene.time_s() < 63.0 {
                scene.step(|_, _| {});
                if scene.time_s() > next_s {
                    nees.look(&scene);
                    next_s += 2.0;
                }
            }
        }
        println!(
            "{count} cameras: NEES tilt {:.2}, gyroscope bias {:.2}, accelerometer bias {:.2}; heading {:.2}°",
            nees.tilt / nees.count,
            nees.gyro_bias / nees.count,
            nees.accel_bias / nees.count,
            (nees.heading_error_2 / nees.count).sqrt().to_degrees()
        );
        nees
    }
}

#[test]
fn three_cameras_are_as_sure_as_they_may_be_and_better_than_one() {
    let (three, one) = (Nees::of(3), Nees::of(1));
    for (what, sum, (low, high)) in
        [("tilt", three.tilt, (0.4, 1.6)), ("gyroscope bias", three.gyro_bias, (0.4, 1.8))]
    {
        let value = sum / three.count;
        assert!((low..high).contains(&value), "{what}: {value:.2} is not in {low} to {high}");
    }
    // Levelling takes what walking does for chance; one camera alone is too sure as well.
    assert!(three.accel_bias < one.accel_bias);
    let better = (one.heading_error_2 / three.heading_error_2).sqrt();
    assert!(better > 1.2, "heading: {better:.2} times better");
}
