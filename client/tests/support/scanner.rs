//! A stand-in for a camera with a depth source: this test program run again, publishing the poses of a camera
//! that moves past a wall, and clouds of that wall as a rolling shutter sees it.

use std::env;
use std::io::{BufRead, BufReader, Read, stdin};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{sleep, spawn};
use std::time::Duration;

use glam::{DQuat, DVec3};
use iceoryx2::port::publisher::Publisher as Port;
use iceoryx2::prelude::ipc;
use lodestone_client::{
    Client, CloudFields, CloudFrame, CloudHeader, CloudPoint, CloudPublisher, Pose,
    monotonic_now_ns,
};
use lodestone_schema::ServiceKind;
use lodestone_schema::transport::{Clouds, Qos, open_clouds_for_writing, open_for_writing};

use super::TestDomain;
use super::publisher::pose;

/// The wall, north of all cameras: its distance from the world's origin, and half its width and height, m.
pub(crate) const WALL_Y_M: f64 = 5.0;
pub(crate) const HALF_WALL_M: [f64; 2] = [1.0, 0.5];
/// Half the extent of the room that is there instead of the wall if asked for, m.
pub(crate) const HALF_ROOM_M: DVec3 = DVec3::new(3.0, WALL_Y_M, 1.5);
/// Points of a cloud, row by row.
pub(crate) const COLUMNS: u32 = 80;
pub(crate) const ROWS: u32 = 40;
/// From the first row to the last.
const SHUTTER_NS: i64 = 30_000_000;
const STEP: Duration = Duration::from_micros(2500);
/// A cloud with every so many poses: 20 Hz.
const STEPS_PER_CLOUD: u64 = 20;

const SETUP: &str = "LODESTONE_TEST_SCANNER";

/// What a scanner does.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Setup {
    /// Time at which it is at `place_m` and looks `yaw_rad`, `CLOCK_MONOTONIC`, ns.
    pub(crate) start_ns: i64,
    pub(crate) place_m: [f64; 2],
    pub(crate) yaw_rad: f64,
    pub(crate) rate_rad_s: f64,
    pub(crate) world_epoch: u32,
    /// Whether poses are published.
    pub(crate) poses: bool,
    /// Whether every second cloud is garbage.
    pub(crate) garbage: bool,
    /// Whether it stands in a room, and not before the wall alone.
    pub(crate) room: bool,
    /// What its poses are wrong by: x and y, m, yaw, rad.
    pub(crate) pose_error: [f64; 3],
    /// Index of the camera.
    pub(crate) camera_id: u32,
}

impl Setup {
    /// A camera at rest, that looks at the wall.
    pub(crate) fn at(place_m: [f64; 2], yaw_rad: f64) -> Self {
        let start_ns = monotonic_now_ns();
        Self {
            start_ns,
            place_m,
            yaw_rad,
            rate_rad_s: 0.0,
            world_epoch: 1,
            poses: true,
            garbage: false,
            room: false,
            pose_error: [0.0; 3],
            camera_id: 0,
        }
    }

    fn to_text(self) -> String {
        let [x, y] = self.place_m;
        let Self { start_ns, yaw_rad, rate_rad_s, world_epoch, poses, garbage, room, .. } = self;
        let ([dx, dy, dyaw], id) = (self.pose_error, self.camera_id);
        format!(
            "{start_ns} {x} {y} {yaw_rad} {rate_rad_s} {world_epoch} {poses} {garbage} {room} {dx} {dy} {dyaw} {id}"
        )
    }

    fn from_text(text: &str) -> Self {
        let parts: Vec<&str> = text.split(' ').collect();
        let number = |i: usize| parts[i].parse::<f64>().expect("a number");
        Self {
            start_ns: parts[0].parse().expect("a time"),
            place_m: [number(1), number(2)],
            yaw_rad: number(3),
            rate_rad_s: number(4),
            world_epoch: parts[5].parse().expect("a number"),
            poses: parts[6] == "true",
            garbage: parts[7] == "true",
            room: parts[8] == "true",
            pose_error: [number(9), number(10), number(11)],
            camera_id: parts[12].parse().expect("a number"),
        }
    }

    /// Where the camera is, and how it is turned.
    fn motion(&self, time_ns: i64) -> (DVec3, DQuat) {
        let t = (time_ns - self.start_ns) as f64 * 1e-9;
        let [x, y] = self.place_m;
        (DVec3::new(x, y, 0.0), DQuat::from_rotation_z(self.yaw_rad + self.rate_rad_s * t))
    }
}

/// A scanner in its own process; ends with this value.
pub(crate) struct Scanner {
    child: Child,
    orders: Option<ChildStdin>,
    /// Kept open: the test harness goes on writing there.
    _answers: BufReader<ChildStdout>,
}

impl Scanner {
    /// Starts one, and waits until it publishes.
    pub(crate) fn start(domain: &TestDomain, camera: &str, setup: Setup) -> Self {
        let mut child = Command::new(env::current_exe().expect("this program"))
            .args(["--exact", "scanner_process", "--ignored", "--nocapture"])
            .env("LODESTONE_SHM_PREFIX", &domain.prefix)
            .env("LODESTONE_SHM_ROOT", &domain.root)
            .env(SETUP, format!("{camera} {}", setup.to_text()))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("starts");
        let orders = child.stdin.take();
        let mut answers = BufReader::new(child.stdout.take().expect("a pipe"));
        // The test harness writes to the same pipe.
        let is_ready =
            answers.by_ref().lines().map_while(Result::ok).any(|line| line.ends_with("ready"));
        assert!(is_ready, "the scanner has ended");
        Self { child, orders, _answers: answers }
    }

    /// kill -9.
    pub(crate) fn kill(mut self) {
        self.child.kill().expect("kills");
        self.child.wait().expect("is gone");
    }
}

impl Drop for Scanner {
    fn drop(&mut self) {
        // The end of its orders ends the process.
        drop(self.orders.take());
        let _ = self.child.wait();
    }
}

/// What the scanner process does; nothing if it was not started by [`Scanner::start`].
pub(crate) fn scan_as_ordered() {
    static IS_OVER: AtomicBool = AtomicBool::new(false);
    let Ok(text) = env::var(SETUP) else { return };
    let (camera, setup) = text.split_once(' ').expect("a camera and its setup");
    let mut scan = Scan::open(camera, Setup::from_text(setup));
    spawn(|| {
        let _ = stdin().lock().lines().count();
        IS_OVER.store(true, Ordering::Relaxed);
    });
    while !IS_OVER.load(Ordering::Relaxed) {
        scan.step();
        sleep(STEP);
    }
}

type CloudPort = Port<ipc::Service, [CloudPoint], CloudHeader>;

struct Scan {
    setup: Setup,
    poses: Option<Port<ipc::Service, Pose, ()>>,
    clouds: CloudPublisher,
    garbage: Option<(CloudPort, Clouds)>,
    step: u64,
}

impl Scan {
    fn open(camera: &str, setup: Setup) -> Self {
        let client = Client::connect().expect("enters");
        let node = client.domain().open_node("scanner").expect("a node");
        let qos = Qos { history: 16, max_subscribers: 8, max_publishers: 2, max_borrowed: 2 };
        let poses = setup.poses.then(|| {
            let service = open_for_writing::<Pose>(&node, ServiceKind::Pose, camera, qos);
            service.expect("a service").publisher_builder().create().expect("a port")
        });
        let garbage = setup.garbage.then(|| {
            let service = open_clouds_for_writing(&node, camera).expect("a service");
            let port = service.publisher_builder().initial_max_slice_len(64).create();
            (port.expect("a port"), service)
        });
        let most = (COLUMNS * ROWS) as usize;
        let clouds = client.cloud_publisher(camera, most).expect("a publisher");
        Self { setup, poses, clouds, garbage, step: 0 }
    }

    fn step(&mut self) {
        let now_ns = monotonic_now_ns();
        if let Some(poses) = &self.poses {
            poses.send_copy(self.pose(now_ns)).expect("sends");
        }
        if self.step % STEPS_PER_CLOUD == STEPS_PER_CLOUD - 1 {
            // The shutter closed a moment ago.
            self.send_cloud(now_ns - SHUTTER_NS - 5_000_000);
            if self.step < STEPS_PER_CLOUD {
                println!("ready");
            }
        }
        if self.step % STEPS_PER_CLOUD == 3
            && let Some((port, _)) = &self.garbage
        {
            send_garbage(port, self.step);
        }
        self.step += 1;
    }

    fn pose(&self, time_ns: i64) -> Pose {
        let (place, turn) = self.setup.motion(time_ns);
        let [x, y, yaw] = self.setup.pose_error;
        Pose {
            camera_id: self.setup.camera_id,
            position_m: (place + DVec3::new(x, y, 0.0)).to_array(),
            velocity_m_s: [0.0; 3],
            orientation: (DQuat::from_rotation_z(yaw) * turn).to_array(),
            position_covariance_m2: [2.5e-3, 0.0, 0.0, 2.5e-3, 0.0, 2.5e-3],
            orientation_covariance_rad2: [1e-5, 0.0, 0.0, 1e-5, 0.0, 4e-4],
            angular_rate_rad_s: [0.0, 0.0, self.setup.rate_rad_s],
            world_epoch: self.setup.world_epoch,
            ..pose(self.step, time_ns)
        }
    }

    fn send_cloud(&mut self, time_ns: i64) {
        let setup = self.setup;
        let mut cloud = self.clouds.loan(COLUMNS, ROWS).expect("room");
        for (index, point) in cloud.points_mut().iter_mut().enumerate() {
            *point = if setup.room {
                room_point(&setup, time_ns, index as u32)
            } else {
                wall_point(&setup, time_ns, index as u32)
            };
        }
        let cloud = cloud.in_frame(CloudFrame::Body);
        cloud
            .with_fields(CloudFields::COLOUR | CloudFields::POINT_TIME)
            .send(time_ns)
            .expect("sends");
    }
}

/// A place on the wall as the camera sees it when the shutter comes to its row.
fn wall_point(setup: &Setup, time_ns: i64, index: u32) -> CloudPoint {
    let share = |at: u32, of: u32| f64::from(at) / f64::from(of - 1) * 2.0 - 1.0;
    let (column, row) = (index % COLUMNS, index / COLUMNS);
    let place = DVec3::new(
        HALF_WALL_M[0] * share(column, COLUMNS),
        WALL_Y_M,
        HALF_WALL_M[1] * share(row, ROWS),
    );
    let time_offset_ns = SHUTTER_NS * i64::from(row) / i64::from(ROWS);
    let (origin, turn) = setup.motion(time_ns + time_offset_ns);
    let seen = turn.conjugate() * (place - origin);
    CloudPoint {
        position_m: seen.as_vec3().to_array(),
        time_offset_ns: time_offset_ns as i32,
        colour: [200, 100, 50, 255],
    }
}

/// What a ray hits first in a box around the world's origin, of which the wall's plane is one side.
fn room_point(setup: &Setup, time_ns: i64, index: u32) -> CloudPoint {
    let share = |at: u32, of: u32| f64::from(at) / f64::from(of - 1) * 2.0 - 1.0;
    let (column, row) = (index % COLUMNS, index / COLUMNS);
    let ray = DVec3::new(1.0, -1.2 * share(column, COLUMNS), -0.8 * share(row, ROWS));
    let time_offset_ns = SHUTTER_NS * i64::from(row) / i64::from(ROWS);
    let (origin, turn) = setup.motion(time_ns + time_offset_ns);
    let in_world = turn * ray;
    let to_walls = (HALF_ROOM_M * in_world.signum() - origin) / in_world;
    CloudPoint {
        position_m: (ray * to_walls.min_element()).as_vec3().to_array(),
        time_offset_ns: time_offset_ns as i32,
        colour: [100, 150, 200, 255],
    }
}

/// A cloud whose header is not sound, or whose points are not.
fn send_garbage(port: &CloudPort, number: u64) {
    let bad = CloudPoint { position_m: [f32::MAX; 3], time_offset_ns: i32::MIN, colour: [255; 4] };
    let mut sample = port.loan_slice_uninit(64).expect("room").write_from_fn(|_| bad);
    let width = if number % 2 == 1 { u32::MAX } else { 64 };
    *sample.user_header_mut() = CloudHeader {
        sequence: number,
        time_ns: monotonic_now_ns() - 20_000_000,
        width,
        height: u32::MAX,
        fields: u32::MAX,
        ..CloudHeader::default()
    };
    sample.send().expect("sends");
}
