//! Where a car in city traffic is: with speed and constraint, with late fixes, unaided.

use glam::{DMat3, DVec3};
use lodestone_fusion::{
    Aid, Estimator, Measurement, ORIENTATION, POSITION, Parameters, SensorSpan, SensorTime, VELOCITY, so3,
};

use crate::city::{City, Mount};
use crate::simulation::steps;

/// A car and the filter in it.
struct Ride {
    car: City,
    filter: Estimator,
    now: SensorTime,
    distance_at_start: f64,
}

impl Ride {
    fn new(seed: u64, p: Parameters, mount: Mount) -> Self {
        let (car, filter) = (City::new(seed, p, mount), Estimator::new(p));
        Self { car, filter, now: SensorTime::from_nanos(0), distance_at_start: 0.0 }
    }

    fn step(&mut self) {
        let step = self.car.step();
        self.now = step.time;
        self.filter.step(&step);
    }

    fn position_error(&self) -> DVec3 {
        self.car.position - self.filter.state().expect("aligned").position
    }

    fn nees(&self) -> [f64; 2] {
        let state = self.filter.state().expect("aligned");
        let score = |error: DVec3, p: DMat3| error.dot(p.inverse() * error) / 3.0;
        [
            score(self.position_error(), state.covariance.block(POSITION, POSITION)),
            score(self.car.velocity - state.velocity, state.covariance.block(VELOCITY, VELOCITY)),
        ]
    }
}

fn in_vehicle() -> (Parameters, Mount) {
    let mount = Mount::windscreen();
    (Parameters { vehicle: Some(mount.parameters()), ..Parameters::default() }, mount)
}

#[test]
fn explore() {
    for aided in [true, false] {
        for seed in 0..10 {
            let (mut p, mount) = in_vehicle();
            if !aided { p.vehicle = None; }
            let mut ride = Ride::new(seed, p, mount);
            let mut line = String::new();
            for k in 0..steps(604.0) {
                ride.step();
                if std::env::var("DBG").is_ok() && k % 40 == 0 && ride.filter.state().is_some() { let e = ride.filter.estimate().unwrap(); if e.at_rest && ride.car.speed > 0.05 && k > 1700 { println!("  seed {seed} aided {aided} t {:.1} rest at {:.2} m/s, v {:.2} s {:.3}", k as f64*0.0025, ride.car.speed, e.velocity.length(), e.velocity_covariance.x_axis.x.sqrt()); } }
                if std::env::var("TS").is_ok() && aided && seed==7 && k % 400 == 0 && k > 1600 && k < 26000 { let e = ride.filter.estimate().unwrap(); let st = ride.filter.state().unwrap(); let att = so3::log(ride.car.orientation * st.orientation().quaternion().conjugate()) * 57.3; let ve = ride.car.velocity - st.velocity; let sv = st.covariance.variances(VELOCITY); println!("  {:.0} v {:.2} rest {} att {:.2} {:.2} {:.2} s {:.2} {:.2} ve {:.3} {:.3} {:.3} s {:.3} mount {:.4} {:.4} scale {:.4} used {:06b} ref {:06b} nees {:.2} {:.2}", k as f64*0.0025, ride.car.speed, e.at_rest, att.x, att.y, att.z, st.covariance.variances(ORIENTATION).x.sqrt()*57.3, st.covariance.variances(ORIENTATION).z.sqrt()*57.3, ve.x, ve.y, ve.z, sv.x.sqrt(), st.mounting_rad[0], st.mounting_rad[1], st.speed_scale, e.aids.used.bits(), e.aids.refused.bits(), ride.nees()[0], ride.nees()[1]); }
                if aided && k % 8 == 0 && k > steps(3.0) {
                    let noise = ride.car.number(0.05);
                    let speed_m_s = ride.car.speed + noise;
                    let m = Measurement::Speed { speed_m_s, sigma_m_s: Some(0.05) };
                    ride.filter.aid(&Aid { time: ride.now, measurement: m });
                }
                let marks = if aided { [14., 64., 304., 604.] } else { [14., 24., 44., 64.] };
                if marks.iter().any(|m| k == steps(*m) - 1) {
                    let e = ride.position_error();
                    let st = ride.filter.state().unwrap();
                    let att = so3::log(ride.car.orientation * st.orientation().quaternion().conjugate()) * 57.3;
                    let sa = st.covariance.variances(ORIENTATION);
                    line += &format!(" | {:.1} m of {:.0} ({:.2}%) nees {:.2} {:.2} att {:.2} {:.2} {:.2} s {:.2} {:.2}", e.length(), ride.car.distance, 100.0*e.length()/ride.car.distance, ride.nees()[0], ride.nees()[1], att.x, att.y, att.z, sa.x.sqrt()*57.3, sa.z.sqrt()*57.3);
                }
            }
            println!("{aided} {seed}{line}");
        }
    }
    let _ = SensorSpan::from_nanos(0);
}
