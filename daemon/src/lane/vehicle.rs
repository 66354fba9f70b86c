//! The body that carries a camera, in the estimator's terms.

use glam::DVec3;
use lodestone_config::model::{Camera, Config, Mounting};
use lodestone_fusion::{Body, Rotation, Vehicle, VehicleParameters};

/// The vehicle that carries a camera, if one does.
pub(super) fn vehicle_of(config: &Config, camera: &Camera) -> Option<VehicleParameters> {
    let body = config.body_of(camera)?;
    body.vehicle.then(|| {
        let from_body = attitude(&camera.mounting);
        VehicleParameters::mounted(from_body, on_camera(&camera.mounting, [0.0; 3]))
    })
}

/// Where the body's antenna is, from the camera's own origin in its own axes, m; the origin itself
/// where no antenna is configured.
pub(super) fn antenna_of(config: &Config, camera: &Camera) -> DVec3 {
    let antenna = config.body_of(camera).and_then(|body| body.antenna_m);
    antenna.map_or(DVec3::ZERO, |at_m| on_camera(&camera.mounting, at_m))
}

/// The camera's attitude on the body that carries it.
fn attitude(mounting: &Mounting) -> Rotation<Vehicle, Body> {
    let [roll, pitch, yaw] = mounting.roll_pitch_yaw_deg.map(f64::to_radians);
    Rotation::from_yaw_pitch_roll(yaw, pitch, roll)
}

/// A point on the carrying body, from the camera's own origin in its own axes, m.
fn on_camera(mounting: &Mounting, point_m: [f64; 3]) -> DVec3 {
    let from_camera = DVec3::from(point_m) - DVec3::from(mounting.position_m);
    attitude(mounting).inverse().apply(from_camera)
}

#[cfg(test)]
mod tests {
    use lodestone_config::model::RigidBody;

    use super::*;

    fn on_a_car(vehicle: bool) -> (Config, Camera) {
        // Two metres ahead of the axle, one above it, looking left and nose down.
        let mounting = Mounting {
            position_m: [2.0, 0.0, 1.0],
            roll_pitch_yaw_deg: [0.0, 20.0, 90.0],
            ..Mounting::default()
        };
        let camera = Camera { body: Some("car".into()), mounting, ..Camera::default() };
        let antenna_m = Some([2.0, 0.0, 1.5]);
        let body =
            vec![RigidBody { name: "car".into(), vehicle, antenna_m, ..RigidBody::default() }];
        (Config { body, ..Config::default() }, camera)
    }

    #[test]
    fn the_axle_lies_where_the_mounting_has_it() {
        let (config, camera) = on_a_car(true);
        let vehicle = vehicle_of(&config, &camera).unwrap();
        // Left of a camera that looks left lies the rear; nose down tips what is below it backwards.
        let (sin, cos) = 20.0_f64.to_radians().sin_cos();
        let expected = DVec3::new(sin, 2.0, -cos);
        assert!((vehicle.origin_m - expected).length() < 1e-12, "{}", vehicle.origin_m);
        let forward = vehicle.vehicle_from_body.apply(DVec3::NEG_Y);
        assert!((forward - DVec3::X).length() < 1e-12, "its right is the car's front");
    }

    #[test]
    fn the_antenna_lies_where_the_body_has_it() {
        let (config, camera) = on_a_car(true);
        let (sin, cos) = 20.0_f64.to_radians().sin_cos();
        let expected = DVec3::new(-sin, 0.0, cos) * 0.5;
        assert!((antenna_of(&config, &camera) - expected).length() < 1e-12);
    }

    #[test]
    fn what_is_no_vehicle_has_no_axle() {
        let (config, camera) = on_a_car(false);
        assert_eq!(vehicle_of(&config, &camera), None);
        let alone = Camera { body: None, ..camera };
        assert_eq!(antenna_of(&config, &alone), DVec3::ZERO);
    }
}
