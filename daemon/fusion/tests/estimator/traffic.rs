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
