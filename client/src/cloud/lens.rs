//! Where a camera's lens sits on its body.

use crate::frame::{Body, Optical, Rotation};
use crate::transform::{Transform, body_from_optical_axes};
use crate::transforms::FrameEdge;

/// How the place of a lens is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LensPlace {
    /// The daemon's configuration says it.
    Configured,
    /// Nobody has said; the lens counts as at the IMU, some centimetres off.
    AssumedAtImu,
}

/// The left lens on the camera's body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Optical coordinates to body coordinates.
    pub body_from_optical: Transform<Body, Optical>,
    /// Whether its translation is known.
    pub place: LensPlace,
}

impl Lens {
    /// A lens at the IMU, with axes as built.
    pub const AT_IMU: Self =
        Self { body_from_optical: body_from_optical_axes(), place: LensPlace::AssumedAtImu };

    /// The lens of a camera by the tree of frames; `None` if the tree has no such camera.
    ///
    /// ```
    /// # use lodestone_client::Lens;
    /// assert_eq!(Lens::of("front", &[]), None);
    /// ```
    pub fn of(camera: &str, tree: &[FrameEdge]) -> Option<Self> {
        let is_lens = |edge: &&FrameEdge| {
            edge.parent() == camera
                && edge.child().strip_prefix(camera).is_some_and(|part| part == "/optical")
        };
        let edge = tree.iter().find(is_lens)?;
        let rotation = Rotation::from_quaternion(edge.rotation()?)?;
        let (origin, place) = match edge.translation_m() {
            Some(translation) => (translation, LensPlace::Configured),
            None => (Self::AT_IMU.body_from_optical.origin(), LensPlace::AssumedAtImu),
        };
        Some(Self { body_from_optical: Transform::new(rotation, origin), place })
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use lodestone_schema::{StaticTransform, TransformKind, to_name};

    use super::*;

    fn edge(child: &str, translation_m: [f64; 3]) -> FrameEdge {
        FrameEdge::try_from(StaticTransform {
            sequence: 0,
            time_ns: 0,
            index: 0,
            count: 1,
            kind: TransformKind::Fixed.code(),
            reserved: [0; 7],
            parent: to_name("front").unwrap(),
            child: to_name(child).unwrap(),
            translation_m,
            rotation: body_from_optical_axes().rotation().quaternion().to_array(),
        })
        .unwrap()
    }

    #[test]
    fn a_configured_lens_is_where_it_was_said_to_be() {
        let tree = [edge("front/magnetometer", [1.0; 3]), edge("front/optical", [0.01, 0.06, 0.0])];
        let lens = Lens::of("front", &tree).unwrap();
        assert_eq!(lens.place, LensPlace::Configured);
        let ahead = lens.body_from_optical.apply(DVec3::new(0.0, 0.0, 2.0));
        assert!(ahead.abs_diff_eq(DVec3::new(2.01, 0.06, 0.0), 1e-12), "{ahead}");
        assert_eq!(Lens::of("rear", &tree), None);
    }

    #[test]
    fn a_lens_whose_place_nobody_said_counts_as_at_the_imu_and_says_so() {
        let lens = Lens::of("front", &[edge("front/optical", [f64::NAN; 3])]).unwrap();
        assert_eq!(lens, Lens::AT_IMU);
    }
}
