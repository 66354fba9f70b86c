//! What the consumer hands back, in `consumer.json`: which files it wrote, and by which poses it placed clouds.

use glam::DQuat;
use serde::{Deserialize, Serialize};

/// By whose poses clouds were placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Variant {
    /// The front camera's clouds by its own poses.
    FrontAlone,
    /// The rear camera's clouds by its own poses.
    RearAlone,
    /// Both by their poses without the magnetometer: headings count from wherever each began.
    WithoutMagnetometer,
    /// Both by their own poses.
    Lodestone,
    /// The same, each camera laid over the others' clouds by ICP.
    Refined,
    /// Both by the truth: what is left is the noise of depth.
    Perfect,
}

impl Variant {
    /// All, in the order of the table.
    pub const ALL: [Self; 6] = [
        Self::FrontAlone,
        Self::RearAlone,
        Self::WithoutMagnetometer,
        Self::Lodestone,
        Self::Refined,
        Self::Perfect,
    ];

    /// Name of its file.
    pub const fn file(self) -> &'static str {
        match self {
            Self::FrontAlone => "front.ply",
            Self::RearAlone => "rear.ply",
            Self::WithoutMagnetometer => "merged-without-magnetometer.ply",
            Self::Lodestone => "merged-lodestone.ply",
            Self::Refined => "merged.ply",
            Self::Perfect => "merged-perfect-poses.ply",
        }
    }

    /// For people.
    pub const fn words(self) -> &'static str {
        match self {
            Self::FrontAlone => "front alone",
            Self::RearAlone => "rear alone",
            Self::WithoutMagnetometer => "merged, without magnetometer",
            Self::Lodestone => "merged by Lodestone",
            Self::Refined => "merged, refined by ICP",
            Self::Perfect => "merged by perfect poses",
        }
    }

    /// Whether clouds of a camera, by its index, are in it.
    pub const fn takes(self, camera: usize) -> bool {
        match self {
            Self::FrontAlone => camera == 0,
            Self::RearAlone => camera == 1,
            _ => true,
        }
    }
}

/// Everything.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Seen {
    /// Time that filters were given to settle after the last pose was initialised, s.
    pub settled_s: f64,
    /// Time that clouds were merged for, s.
    pub merged_s: f64,
    /// What was merged.
    pub merges: Vec<Merge>,
    /// The cameras, in the order of the bits in the files.
    pub cameras: Vec<SeenCamera>,
    /// How the refinement went.
    pub refinement: Refinement,
}

/// One merged cloud.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Merge {
    /// By whose poses.
    pub variant: Variant,
    /// Clouds in it.
    pub clouds: u64,
    /// Points in it.
    pub points: u64,
    /// Voxels that they fill.
    pub voxels: u64,
    /// Clouds left out because there was no such pose at their time.
    pub without_pose: u64,
    /// Voxels forgotten because the map was full.
    pub forgotten: u64,
}

/// How often clouds were laid over the others' and what came of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Refinement {
    /// Registrations that were used.
    pub accepted: u64,
    /// Registrations that were refused.
    pub refused: u64,
    /// Clouds that were merged without one, for want of any that was accepted.
    pub unrefined: u64,
    /// Why the last one was refused.
    pub last_refusal: Option<String>,
}

/// What was seen of one camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SeenCamera {
    /// Its name.
    pub name: String,
    /// Clouds lost between source and consumer.
    pub lost: u64,
    /// Mean standard deviation of the heading as published, degrees.
    pub heading_sigma_deg: f64,
    /// By its own poses.
    pub own: MeanPose,
    /// The same, moved by ICP; `None` if nothing was.
    pub refined: Option<MeanPose>,
    /// Without the magnetometer; `None` if there was no such pose.
    pub without_magnetometer: Option<MeanPose>,
    /// By the truth; `None` if there was none.
    pub truth: Option<MeanPose>,
}

/// Mean of a pose over the time of merging.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeanPose {
    /// In the world, m.
    pub position_m: [f64; 3],
    /// Body to world, x y z w.
    pub orientation: [f64; 4],
    /// Standard deviation of the heading over the time, degrees.
    pub heading_spread_deg: f64,
}

impl MeanPose {
    /// Turn about up, from east towards north, rad.
    pub fn yaw_rad(&self) -> f64 {
        DQuat::from_array(self.orientation).to_euler(glam::EulerRot::ZYX).0
    }
}
