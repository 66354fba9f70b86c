use crate::gradient::summarise;
use crate::scene::Settings;
use crate::steel::Dipole;
use crate::walk::Walk;
use glam::DVec3;


fn with(s: Settings, f: impl Fn(&mut lodestone_fusion::rig::GradientParameters)) -> Settings {
    let mut s = s;
    f(s.parameters.gradient.as_mut().unwrap());
    s
}

#[test]
fn far() {

    for rough in [3.0, 10.0, 30.0] {
      for live in [0.0, 0.3, 1.0] {
      for reach in [0.0, 0.1] {
        summarise(&format!("indoors {rough} {live} {reach}"), |s| with(Settings::indoors(s), |p| { p.roughness_ut_m2 = rough; p.reach_m = reach; p.liveliness_per_m = live; }), 2);
      }
      }
    }
}

#[test]
fn trace() {
    let mut s = Settings::indoors(0);
    let n = &mut s.parameters.estimator.noise;
    n.gyro_density *= 0.01; n.gyro_scale_walk *= 0.01; n.gyro_bias_sigma *= 0.01; n.accel_bias_sigma *= 0.01; n.accel_density *= 0.01;
    let mut scene = crate::scene::Scene::new(s, 0);
    while scene.time_s() < 25.0 {
        let Some(r) = scene.step(|_, _| {}).and_then(|r| r.gradient) else { continue };
        let v = scene.velocity();
        let e = scene.filter.estimate().unwrap();
        println!("{:.2} {:?} win {:.2} truth {:.2} main {:.2} G {:.1}±{:.1} true {:.1} nis {:.2} dirs {} s {:.3}", scene.time_s(), r.verdict, r.velocity_m_s, v, e.velocity, r.gradient_ut_m, r.gradient_sigma_ut_m, crate::steel::gradient_norm(&scene.settings.steel, scene.position()), r.nis, r.directions, (r.covariance.x_axis.x.min(9.0)+ r.covariance.y_axis.y.min(9.0)).sqrt());
    }
}
