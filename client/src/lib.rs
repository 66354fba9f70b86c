//! Lodestone for consumers: where was this camera, and which way did it look?
//!
//! A consumer connects to the shared memory of the daemon on the same computer, follows the poses
//! of a camera and asks for the time stamp of an image or a cloud:
//!
//! ```no_run
//! use lodestone_client::{Client, Time, body_from_optical_axes};
//!
//! let client = Client::connect()?;
//! let mut poses = client.poses("front")?;
//! # let image_time_ns = 0;
//! # let mut cloud: Vec<[f32; 3]> = Vec::new();
//! let pose = poses.lookup(Time::Unix(image_time_ns))?;
//! let world_from_optical = pose.world_from_body()? * body_from_optical_axes();
//! world_from_optical.apply_to_cloud(&mut cloud);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! * [`Client`] names the place in shared memory and opens streams; it needs no running daemon.
//! * [`PoseStream`] gives poses as they come, and keeps a [`History`] for lookups in the past
//!   (interpolated) and shortly ahead (predicted). It survives a restart of the daemon by itself.
//! * [`HealthStream`] and [`SampleStream`] follow a lane's health and its calibrated samples.
//! * [`CameraPose`] is a pose that was checked: what is unknown is `None`, never zero or `NaN`.
//! * [`Rotation`] and [`Transform`] carry their frames in their types, so that they compose only
//!   where the frames meet.
//!
//! Frames: [`World`] is east, north, up; [`Body`] is the camera's IMU frame (x forward, y left,
//! z up); [`Optical`] is the left optical frame (x right, y down, z forward). Units are SI, angles
//! in rad, times in ns.
//!
//! # Threads
//!
//! A [`Client`] is cheap to clone and may be sent to other threads; a stream stays on the thread
//! that made it. For several threads, give each a clone of the client and let it open its own.
//!
//! # Log
//!
//! The transport reports through `tracing`. A program that installs a subscriber can silence it
//! with the target filter `iceoryx2_bb_loggers=off`.
#![forbid(unsafe_code)]
// `TryFrom` takes messages by value.
#![allow(clippy::large_types_passed_by_value)]
// Tests count in small numbers, and compare what must be equal to the bit.
#![cfg_attr(test, allow(clippy::cast_possible_wrap, clippy::float_cmp))]

mod aiding;
mod batch;
mod client;
mod cloud;
mod connection;
mod covariance;
mod error;
mod export;
mod frame;
mod health;
mod history;
mod interpolate;
pub mod latency;
mod limits;
mod merge;
mod message;
mod pace;
mod pose;
mod pose_stream;
mod predict;
mod refine;
pub mod registration;
mod relative;
mod request;
mod sample;
mod stream;
mod subscription;
mod time;
mod track;
mod transform;
mod transforms;
mod world;

pub use aiding::AidingPublisher;
pub use batch::Batch;
pub use client::{Client, ClientBuilder, PREFIX_VARIABLE, ROOT_VARIABLE};
pub use cloud::{
    Cloud, CloudHeaderError, CloudInfo, CloudLoan, CloudPublisher, CloudStream, KNOT_STEP_NS, Lens,
    LensPlace, MOST_OFFSET_NS, Motion, MotionError, PublishError,
};
pub use error::{
    AidingError, CameraNameError, ConnectError, LookupError, MessageError, NotValid, StreamError,
};
pub use export::{ExportError, ExportFilter, ExportPoint, export_points, write_pcd, write_ply};
pub use frame::{Body, Frame, Optical, Rotation, World};
pub use health::LaneHealth;
pub use history::History;
pub use limits::{LookupLimits, PredictionNoise};
pub use lodestone_schema::transport::{Availability, Domain, DomainError, OpenError};
pub use lodestone_schema::{
    AidFlags, Aiding, AidingKind, AidingOrigin, AlignmentWait, AnchorRefusal, CalibratedSample,
    CloudFields, CloudFrame, CloudHeader, CloudPoint, DistanceSource, HeadingSource, Health,
    LaneState, NorthKind, Pose, PositionSource, RealTimeFlags, SampleFlags, Status, Validity,
    WorldState,
};
pub use merge::{
    CameraMerge, CloudMerger, CloudMergerBuilder, Lateness, MapCounts, MergeCounts, MergeError,
    PlacedCloud, PlacedPoint, PointCounts, PoseSource, Range, VoxelMap, VoxelMapError,
    VoxelMapSettings, VoxelView,
};
pub use message::Message;
pub use pose::{CameraPose, Heading, Origin};
pub use pose_stream::{PoseStream, PoseStreamBuilder};
pub use refine::{
    CloudFix, CloudRefiner, Placement, RefineError, RefineReport, RefineSettings, Refusals,
};
pub use relative::{RelativeMessage, RelativePose, RelativeStream};
pub use request::RequestError;
pub use sample::Sample;
pub use stream::{HealthStream, SampleStream, Stream, WorldStream};
pub use time::{Time, monotonic_now_ns};
pub use track::Counts;
pub use transform::{LengthMismatch, Transform, body_from_optical_axes};
pub use transforms::{FrameEdge, TransformStream};
pub use world::{WorldInfo, WorldMessage};
