//! One camera of a merger: whose clouds, by whose poses.

use crate::cloud::Lens;

/// A voxel keeps one bit for each camera.
pub(super) const MOST_CAMERAS: usize = 16;

/// By whose poses a camera's clouds are placed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PoseSource {
    /// Those that the daemon estimates for this camera, or another one on the same body.
    Estimate(String),
    /// The truth of a synthetic camera, to compare with.
    Truth(String),
}

impl PoseSource {
    /// The camera whose poses they are.
    pub fn camera(&self) -> &str {
        match self {
            Self::Estimate(camera) | Self::Truth(camera) => camera,
        }
    }
}

/// A camera whose clouds are merged.
///
/// ```
/// use lodestone_client::{CameraMerge, PoseSource};
/// let own = CameraMerge::new("front");
/// assert_eq!(own.poses, PoseSource::Estimate("front".into()));
/// let compared = CameraMerge::new("front").by(PoseSource::Truth("front".into()));
/// assert_eq!(compared.camera, "front");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct CameraMerge {
    /// The camera whose clouds they are.
    pub camera: String,
    /// By whose poses they are placed; default the camera's own.
    pub poses: PoseSource,
    /// Where the lens sits on the body that the poses are of; default what the daemon's tree of frames says.
    pub lens: Option<Lens>,
}

impl CameraMerge {
    /// A camera's clouds by its own poses.
    pub fn new(camera: impl Into<String>) -> Self {
        let camera = camera.into();
        Self { poses: PoseSource::Estimate(camera.clone()), camera, lens: None }
    }

    /// The same clouds by other poses.
    #[must_use]
    pub fn by(mut self, poses: PoseSource) -> Self {
        self.poses = poses;
        self
    }

    /// The same clouds through a lens at a known place.
    #[must_use]
    pub const fn through(mut self, lens: Lens) -> Self {
        self.lens = Some(lens);
        self
    }
}
