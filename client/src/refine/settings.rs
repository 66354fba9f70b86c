//! How often, how long, how much.

use core::time::Duration;

use crate::registration::{RegistrationSettings, SurfaceSettings};

/// Settings of a [`super::CloudRefiner`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefineSettings {
    /// Index of the camera whose clouds stay as its poses place them.
    pub anchor: usize,
    /// Time between two registrations of a camera.
    pub period: Duration,
    /// Time between two clouds of a camera that are remembered to be registered against.
    pub remember_every: Duration,
    /// A registration looks back over one to two of these: long enough to gather surfaces, short enough that
    /// the poses by which they were placed have not drifted.
    pub memory: Duration,
    /// How long clouds of a camera wait for its first accepted registration; then they go in as they are.
    pub patience: Duration,
    /// A correction that was not confirmed for so long is no longer used.
    pub expiry: Duration,
    /// Edge of the voxels in which surfaces are gathered, m.
    pub voxel_m: f64,
    /// Voxels remembered of each camera, twice.
    pub max_voxels: usize,
    /// Points of a cloud that are remembered or registered.
    pub points: usize,
    /// Whether accepted registrations are given to the daemon: a pose in which they are already needs no
    /// correction.
    pub aids: bool,
    /// What a registration allows.
    pub registration: RegistrationSettings,
    /// How surfaces are found.
    pub surface: SurfaceSettings,
}

impl Default for RefineSettings {
    fn default() -> Self {
        Self {
            anchor: 0,
            period: Duration::from_secs(2),
            remember_every: Duration::from_millis(200),
            memory: Duration::from_secs(10),
            patience: Duration::from_secs(6),
            expiry: Duration::from_secs(30),
            voxel_m: 0.05,
            max_voxels: 200_000,
            points: 20_000,
            aids: false,
            registration: RegistrationSettings::default(),
            surface: SurfaceSettings { planes: 8_000, ..SurfaceSettings::default() },
        }
    }
}
