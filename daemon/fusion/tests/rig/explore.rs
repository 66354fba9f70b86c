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
    let go = |what: &str, f: &dyn Fn(&mut lodestone_fusion::rig::GradientParameters)| summarise(what, |s| with(Settings::indoors(s), |p| f(p)), 3);





    for real in [0.0, 7e-3, 14e-3] { for walk in [7e-3, 3.5e-3, 2e-3, 1e-3] {
      let sc = |s| { let mut x = Settings::indoors(s); x.parameters.estimator.noise.gyro_scale_walk = walk; x.scale_error = real; x.parameters.gradient.as_mut().unwrap().deweight = 1.0; x.parameters.gradient.as_mut().unwrap().roughness_ut_m2 = 5.0; x };
      summarise(&format!("scale {real} believed {walk}"), sc, 3);
    }}
}

#[test]
fn trace() {
    let mut s = Settings::indoors(0);
    s.parameters.estimator.noise.mag_sigma_ut = 0.05;
    s.parameters.gradient.as_mut().unwrap().mag_sigma_ut = 0.05;
    let mut scene = crate::scene::Scene::new(s, 0);
    while scene.time_s() < 30.0 {
        let Some(r) = scene.step(|_, _| {}).and_then(|r| r.gradient) else { continue };
        let v = scene.orientation().conjugate() * scene.velocity();
        let e = scene.filter.estimate().unwrap();
        let q = e.orientation.inverse();
        println!("{:.2} {:?} err {:.3} main {:.3} sig {:.3} G {:.1}±{:.1} true {:.1} nis {:.2} dirs {} att {:.4}", scene.time_s(), r.verdict, q.apply(r.velocity_m_s) - v, q.apply(e.velocity) -v, (e.velocity_covariance.x_axis.x).sqrt(), r.gradient_ut_m, r.gradient_sigma_ut_m, crate::steel::gradient_norm(&scene.settings.steel, scene.position()), r.nis, r.directions, lodestone_fusion::so3::log(scene.orientation() * e.orientation.quaternion().conjugate()));
    }
}
