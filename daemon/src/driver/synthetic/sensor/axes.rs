//! From body axes back to the axes the sensor reports in.

use glam::{DMat3, DVec3};
use lodestone_config::model::AxisMap;
use thiserror::Error;

/// The axis map is not a right-handed permutation of the axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "axis_map {0:?} is not a rotation; each sensor axis must stand once, with signs that make the \
     map right-handed (the ZED 2 is [\"z\", \"y\", \"-x\"])"
)]
pub struct AxisMapError(pub AxisMap);

/// The inverse of a camera's axis map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SensorAxes {
    sensor_from_body: DMat3,
}

impl SensorAxes {
    /// Inverts the map.
    pub(crate) fn new(map: AxisMap) -> Result<Self, AxisMapError> {
        // The map's rows say which sensor axis a body axis is: as columns they are the transpose,
        // which is the inverse of a rotation.
        let sensor_from_body = DMat3::from_cols_array_2d(&map.directions());
        let is_rotation = (sensor_from_body.determinant() - 1.0).abs() < 1e-12;
        is_rotation.then_some(Self { sensor_from_body }).ok_or(AxisMapError(map))
    }

    /// Sensor coordinates of a vector in body coordinates.
    pub(crate) fn to_sensor(self, body: DVec3) -> DVec3 {
        self.sensor_from_body * body
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_zed_2_feels_gravity_on_minus_x() {
        let axes = SensorAxes::new(AxisMap::default()).unwrap();
        assert_eq!(axes.to_sensor(DVec3::new(0.0, 0.0, 9.81)), DVec3::new(-9.81, 0.0, 0.0));
        assert_eq!(axes.to_sensor(DVec3::X), DVec3::Z);
        assert_eq!(axes.to_sensor(DVec3::Y), DVec3::Y);
    }

    #[test]
    fn a_map_that_is_no_rotation_is_refused() {
        use lodestone_config::model::SignedAxis::{MinusX, PlusX, PlusY, PlusZ};
        for map in [[PlusX, PlusX, PlusY], [MinusX, PlusY, PlusZ], [PlusX, MinusX, PlusZ]] {
            assert_eq!(SensorAxes::new(AxisMap(map)), Err(AxisMapError(AxisMap(map))));
        }
    }
}
