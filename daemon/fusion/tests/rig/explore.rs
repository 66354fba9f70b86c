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








    let _ = go;



    many();
}

pub fn many() {
    let vary = |what: &str, f: &dyn Fn(u64, &mut Settings)| summarise(what, |s| { let mut x = Settings::indoors(s); f(s, &mut x); x }, 4);
    vary("base", &|_, _| {});
    vary("bias 0.1", &|_, x| x.mag_bias_ut = 0.1);
    vary("bias 0.2", &|_, x| x.mag_bias_ut = 0.2);
    vary("bias 0.3", &|_, x| x.mag_bias_ut = 0.3);
    vary("bias 0.5", &|_, x| x.mag_bias_ut = 0.5);
    vary("scale 7e-3, bias .1", &|_, x| { x.scale_error = 7e-3; x.mag_bias_ut = 0.1; });
    let far = |s: u64, x: &mut Settings, d: f64, g: f64| { x.steel = crate::scene::along(&x.walk, s, 2.0*d/2.2, g*300.0*(d/2.2f64).powi(4), 0.8*d..1.2*d); };
    vary("dist 1.5", &|s, x| far(s, x, 1.5, 1.0));
    vary("dist 3", &|s, x| far(s, x, 3.0, 1.0));
    vary("dist 4", &|s, x| far(s, x, 4.0, 1.0));
    vary("weak .5", &|s, x| far(s, x, 2.2, 0.5));
    vary("weak .25", &|s, x| far(s, x, 2.2, 0.25));
    vary("strong 2", &|s, x| far(s, x, 2.2, 2.0));
    vary("sparse", &|s, x| x.steel = crate::scene::along(&x.walk, s, 6.0, 600.0, 1.7..2.7));
    vary("dense", &|s, x| x.steel = crate::scene::along(&x.walk, s, 1.0, 200.0, 1.5..2.5));
    vary("slow", &|_, x| x.walk.speed_m_s = 0.5);
    vary("fast", &|_, x| x.walk.speed_m_s = 1.8);
    vary("stops", &|_, x| x.walk.starts_and_stops = vec![3.0, 10.0, 13.0, 22.0, 24.0, 35.0, 45.0, 55.0, 58.0]);
    vary("wild", &|_, x| { x.walk.bounce_m = 0.04; x.walk.sway_rad = 0.15 });
    vary("four", &|_, x| x.mountings = crate::scene::polygon(4, 0.5));
    vary("side 0.3", &|_, x| x.mountings = crate::scene::polygon(3, 0.3));
    vary("side 0.9", &|_, x| x.mountings = crate::scene::polygon(3, 0.9));
    vary("uniform", &|_, x| x.steel.clear());
    vary("uniform, bias .3", &|_, x| { x.steel.clear(); x.mag_bias_ut = 0.3; });
    vary("uniform, bias .5", &|_, x| { x.steel.clear(); x.mag_bias_ut = 0.5; });
    vary("uniform, bias 5", &|_, x| { x.steel.clear(); x.mag_bias_ut = 5.0; });
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
