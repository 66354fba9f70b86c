//! The whole driver, polled as a lane polls it.

use std::time::{Duration, Instant};

use glam::{DQuat, DVec3};
use lodestone_config::model::{
    Disturbance, Instrument, MagneticDistortion, Motor, Noise, SensorErrors, Synthetic, Transport,
};

use super::*;

fn world() -> World {
    World { year: Some(2026.5), ..World::default() }
}

fn camera(synthetic: Synthetic) -> Camera {
    Camera { synthetic: Some(synthetic), imu_delay_s: 0.0, ..Camera::default() }
}

fn driver(synthetic: Synthetic) -> SyntheticDriver {
    SyntheticDriver::new(&camera(synthetic), &world()).unwrap()
}

/// As fast as it goes, for `duration_s`.
fn fast(trajectory: TrajectoryKind, duration_s: f64) -> Synthetic {
    Synthetic { trajectory, duration_s, speed: 0.0, rest_s: 1.0, seed: 42, ..Synthetic::default() }
}

fn perfect() -> SensorErrors {
    SensorErrors { noise_scale: 0.0, quantise: false, ..SensorErrors::default() }
}

fn run(driver: &mut SyntheticDriver) -> Vec<Reading> {
    let mut readings = Vec::new();
    while driver.poll(Duration::from_millis(10), &mut readings) == SourceState::Streaming {}
    readings
}

/// What the ZED 2's axis map says: body x, y, z are sensor z, y, −x.
fn to_body(v: DVec3) -> DVec3 {
    DVec3::new(v.z, v.y, -v.x)
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let settings = Synthetic {
        transport: Transport {
            drop_probability: 0.1,
            sampling_jitter_s: 1e-4,
            arrival_delay_s: 1e-3,
            ..Transport::default()
        },
        ..fast(TrajectoryKind::Walk, 5.0)
    };
    let (first, second) = (run(&mut driver(settings.clone())), run(&mut driver(settings.clone())));
    assert!(first.len() > 1700);
    // The debug form of a float is the shortest that reads back to the same bits.
    assert_eq!(format!("{first:?}"), format!("{second:?}"));
    let other = run(&mut driver(Synthetic { seed: 43, ..settings }));
    assert_ne!(format!("{first:?}"), format!("{other:?}"));
}

#[test]
fn a_perfect_sensor_that_stands_reads_gravity_earth_rate_and_field() {
    let settings = Synthetic { errors: perfect(), ..fast(TrajectoryKind::Standing, 1.0) };
    let mut driver = driver(settings);
    let readings = run(&mut driver);
    assert_eq!(readings.len(), 400);
    let field = EarthField::of(&world()).unwrap().world_ut;
    for reading in &readings {
        let truth = driver.truth_at(reading.sensor_time);
        let in_world = |v: DVec3| truth.orientation.apply(to_body(v));
        let force = in_world(reading.accel.vector);
        assert!((force - DVec3::new(0.0, 0.0, 9.81)).length() < 1e-12, "{force}");
        assert!((reading.gyro.vector.length() - 7.292_115e-5).abs() < 1e-15);
        if let Some(mag) = reading.mag {
            assert!((in_world(mag.vector) - field).length() < 1e-12);
        }
        assert!(!reading.saturated);
    }
}

/// Trapezoidal integration of point samples at 400 Hz: the error of attitude is of the order
/// h² ω̈/12 per second, some 1e-4 rad for a walk, and that of position follows from it.
#[test]
fn the_samples_of_a_perfect_sensor_integrate_to_the_truth() {
    let settings = Synthetic { errors: perfect(), ..fast(TrajectoryKind::Walk, 30.0) };
    let mut driver = driver(settings);
    let readings = run(&mut driver);
    let earth = Earth::at(world().latitude_deg, EarthField::of(&world()).unwrap().true_north_rad);
    let start = driver.truth_at(readings[0].sensor_time);
    let (mut q, mut v, mut p) = (start.orientation.quaternion(), DVec3::ZERO, DVec3::ZERO);
    for pair in readings.windows(2) {
        let h = (pair[1].sensor_time - pair[0].sensor_time).as_secs_f64();
        let rate = to_body(pair[0].gyro.vector + pair[1].gyro.vector) * 0.5;
        let turned =
            DQuat::from_scaled_axis(-earth.rate * h) * q * DQuat::from_scaled_axis(rate * h);
        let force =
            (q * to_body(pair[0].accel.vector) + turned * to_body(pair[1].accel.vector)) * 0.5;
        let acceleration = force + earth.gravity - 2.0 * earth.rate.cross(v);
        p += v * h + acceleration * (0.5 * h * h);
        v += acceleration * h;
        q = turned.normalize();
    }
    let truth = driver.truth_at(readings.last().unwrap().sensor_time);
    let attitude = q.angle_between(truth.orientation.quaternion());
    assert!(attitude < 1e-4, "{attitude} rad");
    assert!((p - truth.position_m).length() < 0.05, "{p} against {}", truth.position_m);
    assert!(truth.position_m.length() > 0.2 && (v - truth.velocity_m_s).length() < 0.01);
}

/// Mean and standard deviation of one axis.
fn statistics(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    (mean, (values.map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt())
}

#[test]
fn white_noise_has_its_density_and_the_bias_is_the_one_configured() {
    let bias = [0.01, -0.02, 0.005];
    let errors = SensorErrors { gyro_bias_rad_s: Some(bias), ..SensorErrors::default() };
    let camera = Camera {
        noise: Some(Noise {
            gyro_bias_walk_rad_s2_rthz: 0.0,
            accel_bias_walk_m_s3_rthz: 0.0,
            ..Camera::default().model.noise()
        }),
        ..camera(Synthetic { errors, ..fast(TrajectoryKind::Standing, 60.0) })
    };
    let noise = camera.noise.unwrap();
    let readings = run(&mut SyntheticDriver::new(&camera, &world()).unwrap());
    for (axis, bias) in bias.into_iter().enumerate() {
        let (mean, sigma) = statistics(readings.iter().map(|r| r.gyro.vector[axis]));
        let expected = noise.gyro_density_rad_s_rthz * 400_f64.sqrt();
        assert!((sigma / expected - 1.0).abs() < 0.03, "gyro {axis}: {sigma}, {expected}");
        assert!((mean - bias).abs() < 5.0 * expected / 155.0 + 7.3e-5, "gyro {axis}: {mean}");
        let (_, sigma) = statistics(readings.iter().map(|r| r.accel.vector[axis]));
        let expected = noise.accel_density_m_s2_rthz * 400_f64.sqrt();
        assert!((sigma / expected - 1.0).abs() < 0.03, "accel {axis}: {sigma}, {expected}");
        let mag = readings.iter().filter_map(|r| r.mag).map(move |m| m.vector[axis]);
        let (_, sigma) = statistics(mag);
        assert!((sigma / noise.mag_sigma_ut - 1.0).abs() < 0.06, "mag {axis}: {sigma}");
    }
}

/// The Allan deviation of a random walk k at a long averaging time τ is k √(τ/3).
#[test]
fn the_bias_walks_as_configured() {
    let camera = Camera {
        noise: Some(Noise {
            gyro_density_rad_s_rthz: 0.0,
            gyro_bias_walk_rad_s2_rthz: 1e-3,
            ..Camera::default().model.noise()
        }),
        ..camera(fast(TrajectoryKind::Standing, 300.0))
    };
    let readings = run(&mut SyntheticDriver::new(&camera, &world()).unwrap());
    let tau_s = 1.0;
    let (mut sum, mut count) = (0.0, 0.0);
    for axis in 0..3 {
        let means: Vec<f64> = readings
            .chunks_exact(400)
            .map(|c| c.iter().map(|r| r.gyro.vector[axis]).sum::<f64>() / 400.0)
            .collect();
        sum += means.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>();
        count += (means.len() - 1) as f64;
    }
    let allan = (0.5_f64 * sum / count).sqrt();
    let expected = 1e-3 * (tau_s / 3.0_f64).sqrt();
    assert!((allan / expected - 1.0).abs() < 0.1, "{allan} against {expected}");
}

#[test]
fn values_are_whole_counts_of_the_device() {
    let readings = run(&mut driver(fast(TrajectoryKind::Walk, 3.0)));
    let whole = |value: f64, step: f64| (value / step - (value / step).round()).abs() < 1e-6;
    let (gyro, accel) = (1000.0 / 32768.0 * std::f64::consts::PI / 180.0, 8.0 * 9.8189 / 32768.0);
    for r in &readings {
        assert!(r.gyro.vector.to_array().into_iter().all(|v| whole(v, gyro)));
        assert!(r.accel.vector.to_array().into_iter().all(|v| whole(v, accel)));
        assert!(r.mag.is_none_or(|m| m.vector.to_array().into_iter().all(|v| whole(v, 0.0625))));
        // The nearest f32 of a hundredth.
        let hundredths = f64::from(r.temperature_c.unwrap()) * 100.0;
        assert!((hundredths - hundredths.round()).abs() < 1e-3);
    }
}

#[test]
fn a_rate_beyond_the_range_saturates() {
    let errors =
        SensorErrors { gyro_bias_rad_s: Some([0.0, 18.0, 0.0]), ..SensorErrors::default() };
    let readings = run(&mut driver(Synthetic { errors, ..fast(TrajectoryKind::Standing, 0.5) }));
    let end = (1000.0_f64 * 32767.0 / 32768.0).to_radians();
    assert!(readings.iter().all(|r| r.saturated && (r.gyro.vector.y - end).abs() < 1e-9));
}

#[test]
fn the_magnetometer_reads_every_nth_sample_and_its_distortion() {
    let distortion = MagneticDistortion {
        hard_iron_ut: [10.0, -20.0, 30.0],
        soft_iron: [[1.1, 0.02, 0.0], [0.0, 0.9, 0.05], [0.01, 0.0, 1.0]],
        temperature_ut_k: [0.5, 0.0, -0.5],
    };
    let errors = SensorErrors { temperature_start_c: 35.0, temperature_end_c: 35.0, ..perfect() };
    let settings = Synthetic {
        distortion,
        errors,
        transport: Transport { mag_every: 5, ..Transport::default() },
        ..fast(TrajectoryKind::Standing, 1.0)
    };
    let mut driver = driver(settings);
    let readings = run(&mut driver);
    let body = driver.truth_at(readings[0].sensor_time).orientation.inverse();
    let field = body.apply(EarthField::of(&world()).unwrap().world_ut);
    let b = DVec3::new(-field.z, field.y, field.x);
    let expected = DVec3::new(
        1.1 * b.x + 0.02 * b.y + 10.0 + 5.0,
        0.9 * b.y + 0.05 * b.z - 20.0,
        0.01 * b.x + b.z + 30.0 - 5.0,
    );
    for (k, reading) in readings.iter().enumerate() {
        assert_eq!(reading.mag.is_some(), k % 5 == 0, "sample {k}");
        assert!(reading.mag.is_none_or(|m| (m.vector - expected).length() < 1e-9));
    }
}

#[test]
fn a_disturbance_is_felt_only_while_it_lasts() {
    let disturbance =
        Disturbance { at_s: 1.0, duration_s: 1.0, field_ut: [0.0, 25.0, 0.0], frequency_hz: 0.0 };
    let settings = Synthetic {
        errors: perfect(),
        disturbance: vec![disturbance],
        ..fast(TrajectoryKind::Standing, 3.0)
    };
    let readings = run(&mut driver(settings));
    let at = |k: usize| readings[k].mag.unwrap().vector;
    assert!((at(0) - at(1000)).length() < 1e-12, "before and after");
    assert!(((at(600) - at(0)).length() - 25.0).abs() < 1e-9, "during");
}

/// What runs on the vehicle moves with the camera: turned into the world, it turns with it.
#[test]
fn motors_and_instruments_are_fixed_to_the_body() {
    let quiet = Synthetic { errors: perfect(), ..fast(TrajectoryKind::Tumble, 20.0) };
    let running = Synthetic {
        motor: vec![Motor { field_ut: [0.0, 4.0, 0.0], idle_hz: 3.3, hz_per_m_s: 0.0 }],
        instrument: vec![Instrument { field_ut: [1.0, 0.0, -2.0], on_s: 1.0, off_s: 0.0 }],
        ..quiet.clone()
    };
    let (without, with) = (run(&mut driver(quiet)), run(&mut driver(running)));
    let added = without
        .iter()
        .zip(&with)
        .filter_map(|(a, b)| Some(to_body(b.mag?.vector) - to_body(a.mag?.vector)));
    let added: Vec<DVec3> = added.collect();
    assert!(added.len() == 1000);
    assert!(added.iter().all(|b| (b.x - 1.0).abs() < 1e-9 && (b.z + 2.0).abs() < 1e-9));
    let largest = added.iter().map(|b| b.y.abs()).fold(0.0, f64::max);
    let mean = added.iter().map(|b| b.y).sum::<f64>() / 1000.0;
    assert!((largest - 4.0).abs() < 0.05 && mean.abs() < 0.1, "{largest} {mean}");
}

#[test]
fn flicker_comes_on_top_of_the_white_noise_and_changes_nothing_else() {
    let white = fast(TrajectoryKind::Standing, 60.0);
    let errors = SensorErrors { mag_flicker_ut_rthz: 0.5, ..SensorErrors::default() };
    let both = run(&mut driver(Synthetic { errors, ..white.clone() }));
    let white = run(&mut driver(white));
    assert!(white.iter().zip(&both).all(|(a, b)| a.gyro == b.gyro && a.accel == b.accel));
    let sigma = |readings: &[Reading]| {
        let x: Vec<f64> = readings.iter().filter_map(|r| Some(r.mag?.vector.x)).collect();
        crate::evaluation::statistics::standard_deviation(&x).unwrap()
    };
    assert!(sigma(&both) > 1.5 * sigma(&white), "{} {}", sigma(&both), sigma(&white));
}

#[test]
fn temperature_warms_and_moves_the_bias() {
    let errors = SensorErrors {
        temperature_start_c: 25.0,
        temperature_end_c: 45.0,
        temperature_time_constant_s: 2.0,
        gyro_temperature_rad_s_k: [1e-3, 0.0, 0.0],
        ..perfect()
    };
    let readings = run(&mut driver(Synthetic { errors, ..fast(TrajectoryKind::Standing, 10.0) }));
    let (first, last) = (readings[0], readings[readings.len() - 1]);
    let warmed = f64::from(last.temperature_c.unwrap() - first.temperature_c.unwrap());
    assert!((warmed - 20.0 * (1.0 - (-5.0_f64).exp())).abs() < 0.01, "{warmed}");
    let moved = last.gyro.vector - first.gyro.vector;
    assert!((moved - DVec3::new(1e-3 * warmed, 0.0, 0.0)).length() < 1e-6, "{moved}");
}

#[test]
fn one_error_does_not_change_the_draws_of_another() {
    let noisy = fast(TrajectoryKind::Walk, 2.0);
    let biased = Synthetic {
        errors: SensorErrors { gyro_bias_rad_s: Some([1.0; 3]), ..SensorErrors::default() },
        ..noisy.clone()
    };
    let (plain, biased) = (run(&mut driver(noisy)), run(&mut driver(biased)));
    for (a, b) in plain.iter().zip(&biased) {
        assert_eq!((a.accel, a.mag, a.sensor_time), (b.accel, b.mag, b.sensor_time));
        assert_ne!(a.gyro, b.gyro);
    }
}

#[test]
fn lost_samples_leave_gaps_and_are_counted() {
    let lossless = fast(TrajectoryKind::Walk, 20.0);
    let lossy = Synthetic {
        transport: Transport { drop_probability: 0.05, ..Transport::default() },
        ..lossless.clone()
    };
    let mut driver_with_loss = driver(lossy);
    let (all, rest) = (run(&mut driver(lossless)), run(&mut driver_with_loss));
    assert_eq!(all.len(), rest.len() + driver_with_loss.dropped() as usize);
    assert!((300..500).contains(&driver_with_loss.dropped()));
    let mut of_all = all.iter();
    assert!(rest.iter().all(|reading| of_all.any(|other| other == reading)));
}

#[test]
fn everything_lost_ends_all_the_same() {
    let settings = Synthetic {
        transport: Transport { drop_probability: 1.0, ..Transport::default() },
        ..fast(TrajectoryKind::Walk, 2.0)
    };
    let mut driver = driver(settings);
    assert!(run(&mut driver).is_empty());
    assert_eq!(driver.dropped(), 800);
}

#[test]
fn the_sensor_clock_has_its_own_origin_and_rate() {
    let settings = Synthetic {
        transport: Transport { clock_error: 1e-3, rate_error: -0.05, ..Transport::default() },
        errors: perfect(),
        ..fast(TrajectoryKind::Walk, 10.0)
    };
    let mut driver = driver(settings);
    let readings = run(&mut driver);
    assert_eq!(readings.len(), 3800);
    let (first, last) = (readings[0], readings[3799]);
    assert!(first.sensor_time.as_nanos() > 0);
    let (sensor, host) = (
        (last.sensor_time - first.sensor_time).as_secs_f64(),
        (last.arrival.as_nanos() - first.arrival.as_nanos()) as f64 * 1e-9,
    );
    assert!((sensor / host - 1.001).abs() < 1e-9, "{sensor} s in {host} s");
    let force = driver.truth_at(last.sensor_time).specific_force.vector;
    assert!((to_body(last.accel.vector) - force).length() < 1e-6);
}

#[test]
fn the_truth_is_told_to_another_thread() {
    let driver = driver(fast(TrajectoryKind::Car, 1.0));
    let source = driver.truth_source();
    let at = SensorTime::from_nanos(source.start().as_nanos() + 30_000_000_000);
    let there = std::thread::spawn(move || source.truth_at(at)).join().unwrap();
    assert_eq!(there, driver.truth_at(at));
    assert!(there.velocity_m_s.length() > 1.0);
}

#[test]
fn one_poll_is_bounded() {
    let mut driver = driver(fast(TrajectoryKind::Walk, 0.0));
    for _ in 0..3 {
        let mut readings = Vec::new();
        assert_eq!(driver.poll(Duration::ZERO, &mut readings), SourceState::Streaming);
        assert_eq!(readings.len(), BATCH);
    }
}

/// Given a source at 20-fold speed, when it is polled late, then nothing is skipped, no sample
/// arrives before it was taken, and the run lasts at least as long as its samples.
#[test]
fn at_real_speed_samples_come_when_they_are_due() {
    let settings = Synthetic { speed: 20.0, ..fast(TrajectoryKind::Walk, 4.0) };
    let mut driver = driver(settings);
    let mut readings = Vec::new();
    let begin = Instant::now();
    assert_eq!(driver.poll(Duration::from_millis(50), &mut readings), SourceState::Streaming);
    std::thread::sleep(Duration::from_millis(60));
    readings.extend(run(&mut driver));
    assert!(begin.elapsed() >= Duration::from_millis(199));
    assert_eq!(readings.len(), 1600);
    let (first, start) = (readings[0], driver.truth_source().start());
    for reading in &readings {
        let taken = (reading.sensor_time - start).as_nanos() / 20;
        let Pace::Timed { start: Some(began), .. } = driver.pace else { unreachable!() };
        assert!(reading.arrival.as_nanos() - began.as_nanos() >= taken - 1);
        assert!(reading.arrival >= first.arrival);
    }
}

#[test]
fn a_poll_returns_after_its_timeout_without_a_sample() {
    let mut driver = driver(Synthetic { speed: 1e-3, ..fast(TrajectoryKind::Walk, 0.0) });
    let mut readings = Vec::new();
    driver.poll(Duration::ZERO, &mut readings);
    assert_eq!(readings.len(), 1, "the first sample is due at once, the next one in 2.5 s");
    let begin = Instant::now();
    let state = driver.poll(Duration::from_millis(20), &mut readings);
    assert_eq!((state, readings.len()), (SourceState::Streaming, 1));
    assert!(begin.elapsed() >= Duration::from_millis(20));
}

#[test]
fn settings_without_meaning_are_refused_by_name() {
    let base = fast(TrajectoryKind::Walk, 1.0);
    let transport = |transport| Synthetic { transport, ..base.clone() };
    for (settings, key) in [
        (Synthetic { rest_s: f64::NAN, ..base.clone() }, "rest_s"),
        (Synthetic { speed: -1.0, ..base.clone() }, "speed"),
        (transport(Transport { mag_every: 0, ..Transport::default() }), "mag_every"),
        (transport(Transport { rate_error: -1.0, ..Transport::default() }), "rate_error"),
        (
            transport(Transport { drop_probability: 1.5, ..Transport::default() }),
            "drop_probability",
        ),
    ] {
        let error = SyntheticDriver::new(&camera(settings), &world()).err().unwrap();
        assert!(error.to_string().contains(key), "{error}");
    }
}

#[test]
fn it_says_what_it_is() {
    let camera = Camera { serial: 77, ..camera(fast(TrajectoryKind::ModelVehicle, 1.0)) };
    let driver = SyntheticDriver::new(&camera, &world()).unwrap();
    let info = driver.info();
    assert_eq!(info.description, "synthetic model vehicle");
    assert_eq!((info.serial, info.nominal_rate_hz), (Some(77), 400.0));
    assert_eq!(driver.counters(), DriverCounters::default());
}
