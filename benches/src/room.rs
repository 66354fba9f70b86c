//! A room, as a depth camera that walks and turns through it sees it.

use glam::{DQuat, DVec3};
use lodestone_client::{
    CameraPose, CloudFields, CloudHeader, CloudInfo, CloudPoint, History, LookupLimits, Pose,
    Status, Validity, body_from_optical_axes,
};

/// Points in a row.
pub const WIDTH: usize = 400;
/// Rows.
pub const HEIGHT: usize = 250;
/// Half of the room's length, width and height, m; its middle is the origin.
const HALF_ROOM_M: DVec3 = DVec3::new(4.0, 3.0, 1.5);
/// Tangents of half the field of view: 110° by 84°, as the widest ZED 2 mode.
const HALF_VIEW: (f64, f64) = (1.43, 0.9);
/// From the first row to the last, ns.
const SHUTTER_NS: i64 = 30_000_000;
/// The first cloud's time, ns.
const START_NS: i64 = 1_000_000_000;
const POSE_STEP_NS: i64 = 2_500_000;

/// How points come by their times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointTimes {
    /// All at once.
    None,
    /// Each row has its own, as by a rolling shutter.
    Rows,
    /// Each point has its own, as by a scanner.
    Points,
}

/// A cloud and its header.
#[derive(Clone, Debug)]
pub struct Seen {
    /// The header.
    pub info: CloudInfo,
    /// The points in optical axes, row by row.
    pub points: Vec<CloudPoint>,
}

/// Poses at 400 Hz around so many seconds.
pub fn poses(seconds: f64) -> History {
    let steps = (seconds * 400.0) as i64 + 400;
    let mut history = History::new(steps as usize, LookupLimits::default());
    for step in 0..steps {
        history.push(pose(step as u64, START_NS - 400_000_000 + step * POSE_STEP_NS));
    }
    history
}

/// What is seen so many seconds after the start.
///
/// # Panics
/// If its own header is not sound.
pub fn seen(seconds: f64, times: PointTimes) -> Seen {
    let time_ns = START_NS + (seconds * 1e9) as i64;
    let count = WIDTH * HEIGHT;
    let points = (0..count).map(|index| {
        let share = match times {
            PointTimes::None => 0.0,
            PointTimes::Rows => (index / WIDTH) as f64 / HEIGHT as f64,
            PointTimes::Points => index as f64 / count as f64,
        };
        let time_offset_ns = (share * SHUTTER_NS as f64) as i32;
        look(index, time_ns, time_offset_ns)
    });
    let has_times =
        if times == PointTimes::None { CloudFields::empty() } else { CloudFields::POINT_TIME };
    let header = CloudHeader {
        time_ns,
        width: WIDTH as u32,
        height: HEIGHT as u32,
        fields: (CloudFields::COLOUR | has_times).bits(),
        ..CloudHeader::default()
    };
    let points: Vec<CloudPoint> = points.collect();
    let info = CloudInfo::check(&header, points.len()).expect("is sound");
    Seen { info, points }
}

/// A pixel's ray to the wall that it meets.
fn look(index: usize, time_ns: i64, time_offset_ns: i32) -> CloudPoint {
    let across = |at: usize, of: usize| (at as f64 + 0.5) / of as f64 * 2.0 - 1.0;
    let (column, row) = (across(index % WIDTH, WIDTH), across(index / WIDTH, HEIGHT));
    let ray = DVec3::new(column * HALF_VIEW.0, row * HALF_VIEW.1, 1.0);
    let (place, turn) = motion(time_ns + i64::from(time_offset_ns));
    let way = turn * body_from_optical_axes().rotation().apply(ray);
    // The nearest of the three walls ahead.
    let ahead = HALF_ROOM_M * way.signum() - place;
    let distance = (ahead / way).min_element();
    let colour = [(index % 251) as u8, 120, 80, 255];
    CloudPoint { position_m: (ray * distance).as_vec3().to_array(), time_offset_ns, colour }
}

/// A slow walk through the room, turning at 0.5 rad/s.
fn motion(time_ns: i64) -> (DVec3, DQuat) {
    let t = (time_ns - START_NS) as f64 * 1e-9;
    let place = DVec3::new(2.0 * (0.3 * t).sin(), 1.5 * (0.4 * t).sin(), 0.1);
    (place, DQuat::from_rotation_z(0.5 * t))
}

fn pose(sequence: u64, time_ns: i64) -> CameraPose {
    let (place, turn) = motion(time_ns);
    let unknown = Validity::VELOCITY | Validity::ANGULAR_RATE | Validity::SPECIFIC_FORCE;
    let small = [1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4];
    CameraPose::try_from(Pose {
        sequence,
        camera_id: 0,
        reset_counter: 0,
        status: Status::INITIALISED.bits(),
        validity: Validity::all().difference(unknown).bits(),
        heading_source: 1,
        position_source: 5,
        aids_used: 0,
        aids_refused: 0,
        world_epoch: 1,
        sensor_time_ns: time_ns,
        time_ns,
        arrival_time_ns: time_ns,
        step_start_time_ns: time_ns,
        step_end_time_ns: time_ns,
        published_time_ns: time_ns,
        unix_offset_ns: 0,
        position_m: place.to_array(),
        velocity_m_s: [f64::NAN; 3],
        orientation: turn.to_array(),
        angular_rate_rad_s: [f64::NAN; 3],
        specific_force_m_s2: [f64::NAN; 3],
        position_covariance_m2: small,
        velocity_covariance_m2_s2: [f64::NAN; 6],
        orientation_covariance_rad2: small,
    })
    .expect("a good pose")
}
