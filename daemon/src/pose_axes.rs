//! The world's axes in which poses are written: the filter's are east, north, up.

use glam::{DQuat, DVec3};
use lodestone_fusion::{Estimate, Rotation};

use crate::cli::WorldAxes;
use crate::poses_csv::PoseRow;

/// East, north, up or north, east, down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// x east, y north, z up.
    EastNorthUp,
    /// x north, y east, z down.
    NorthEastDown,
}

impl Axes {
    /// The axes that were asked for; which way a recording's z axis points is known with the first
    /// pose.
    pub fn choose(asked: WorldAxes, first: &Estimate) -> Self {
        let points_down = (first.orientation.quaternion() * DVec3::Z).z < 0.0;
        match asked {
            WorldAxes::Ned => Self::NorthEastDown,
            WorldAxes::Auto if points_down => Self::NorthEastDown,
            WorldAxes::Enu | WorldAxes::Auto => Self::EastNorthUp,
        }
    }

    /// A row in these axes. Body axes stay as they are, and so do standard deviations, which are the
    /// worst axis' or horizontal.
    #[must_use]
    pub fn of_row(self, row: PoseRow) -> PoseRow {
        if self == Self::EastNorthUp {
            return row;
        }
        let vector = |v: DVec3| DVec3::new(v.y, v.x, -v.z);
        // Half a turn about the horizontal that lies between north and east.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let turn = DQuat::from_xyzw(half, half, 0.0, 0.0);
        PoseRow {
            position_m: row.position_m.map(vector),
            velocity_m_s: row.velocity_m_s.map(vector),
            orientation: row
                .orientation
                .and_then(|r| Rotation::from_quaternion(turn * r.quaternion())),
            ..row
        }
    }
}
