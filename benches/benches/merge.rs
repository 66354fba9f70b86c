//! What merging costs for each point: placing it by the pose at its own time, and taking it into the map.
//!
//! A room of 8 by 6 by 3 m, seen by a depth camera of 100,000 points at 15 Hz that walks and turns through
//! it. Times are per point, of this thread's own processor time: other load counts only
//! by what it takes of caches and clock. The peer is what one would write first: each point transformed in f64 and added to
//! a voxel of the standard library's hash map.

use std::collections::HashMap;
use std::hint::black_box;
use std::time::Duration;

use criterion::Criterion;
use glam::{DVec3, Vec3};
use lodestone_benches::ledger::Ledger;
use lodestone_benches::room::{PointTimes, Seen, poses, seen};
use lodestone_client::{
    CloudPoint, History, Motion, PlacedCloud, PlacedPoint, Range, VoxelMap, VoxelMapSettings,
    body_from_optical_axes,
};

use rustix::time::{ClockId, clock_gettime};

const PEER: &str = "peer: a hash map of std, one pose";
const CLOUDS: usize = 30;
const RATE_HZ: f64 = 15.0;
const VOXEL_M: f64 = 0.05;
/// What the 30 ms of a rolling shutter are looked up over.
const SPAN_NS: (i64, i64) = (0, 30_000_000);

fn main() {
    let criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(3))
        .configure_from_args();
    let mut bench = Bench { criterion, ledger: Ledger::default() };
    let history = poses(CLOUDS as f64 / RATE_HZ);
    let of = |times| -> Vec<Seen> {
        (0..CLOUDS).map(|index| seen(index as f64 / RATE_HZ, times)).collect()
    };
    let (still, rows, points) =
        (of(PointTimes::None), of(PointTimes::Rows), of(PointTimes::Points));
    for (name, clouds) in [
        ("place, all by one pose", &still),
        ("place, a time for each row", &rows),
        ("place, a time for each point", &points),
    ] {
        let mut buffer = Vec::new();
        bench.per_point(name, clouds, |seen| {
            buffer = black_box(place(seen, &history, std::mem::take(&mut buffer))).into_points();
        });
    }
    insert(&mut bench, &rows, &history);
    whole(&mut bench, &rows, &history);
    peer(&mut bench, &still, &history);
    bench.criterion.final_summary();
    bench.ledger.print_ratios(PEER);
}

/// Taking placed clouds into a map with room, and into one that must forget with each cloud.
fn insert(bench: &mut Bench, clouds: &[Seen], history: &History) {
    let placed: Vec<PlacedCloud> = clouds.iter().map(|c| place(c, history, Vec::new())).collect();
    let mut map = map(2_000_000);
    bench.per_point("insert", &placed, |cloud| map.insert(cloud));
    let mut full = self::map(20_000);
    bench.per_point("insert, a map that is too small", &placed, |cloud| full.insert(cloud));
    println!("voxels {}, evicted {}", map.len(), full.counts().evicted);
}

/// The whole way.
fn whole(bench: &mut Bench, clouds: &[Seen], history: &History) {
    let mut map = map(2_000_000);
    let mut buffer = Vec::new();
    bench.per_point("place and insert", clouds, |seen| {
        let placed = place(seen, history, std::mem::take(&mut buffer));
        map.insert(&placed);
        buffer = placed.into_points();
    });
}

/// What one would write first.
fn peer(bench: &mut Bench, clouds: &[Seen], history: &History) {
    let mut voxels: HashMap<[i64; 3], (DVec3, [u64; 3], u64)> = HashMap::new();
    bench.per_point(PEER, clouds, |seen| {
        let pose = history.lookup(lodestone_client::Time::Monotonic(seen.info.time_ns()));
        let world_from_body = pose.expect("is kept").world_from_body().expect("is valid");
        let transform = world_from_body * body_from_optical_axes();
        for point in seen.points.iter().filter(|p| p.position_m[2].is_finite()) {
            let place = transform.apply(Vec3::from_array(point.position_m).as_dvec3());
            let cell = (place / VOXEL_M).floor().to_array().map(|c| c as i64);
            let voxel = voxels.entry(cell).or_default();
            voxel.0 += place;
            voxel.1 = [0, 1, 2].map(|i| voxel.1[i] + u64::from(point.colour[i]));
            voxel.2 += 1;
        }
    });
}

fn map(max_voxels: usize) -> VoxelMap {
    VoxelMap::new(VoxelMapSettings { voxel_m: VOXEL_M, max_voxels }).expect("a good size")
}

fn place(seen: &Seen, history: &History, buffer: Vec<PlacedPoint>) -> PlacedCloud {
    let lens = body_from_optical_axes();
    let span = if seen.info.has_point_time() { SPAN_NS } else { (0, 0) };
    let lookup = |time, fields| history.lookup_with(time, fields);
    let motion = Motion::over(seen.info.time_ns(), span, lens, lookup).expect("is kept");
    let points: &[CloudPoint] = &seen.points;
    PlacedCloud::place(0, (&seen.info, points), motion, Range::default(), buffer)
}

/// Processor time of this thread.
fn thread_time() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec.cast_unsigned(), time.tv_nsec as u32)
}

struct Bench {
    criterion: Criterion,
    ledger: Ledger,
}

/// A cloud of either kind.
trait Points {
    fn count(&self) -> u64;
}

impl Points for Seen {
    fn count(&self) -> u64 {
        self.points.len() as u64
    }
}

impl Points for PlacedCloud {
    fn count(&self) -> u64 {
        self.points().len() as u64
    }
}

impl Bench {
    /// Takes all clouds again and again; criterion's iterations count points.
    fn per_point<C: Points>(&mut self, name: &str, clouds: &[C], mut take: impl FnMut(&C)) {
        let ledger = &self.ledger;
        self.criterion.bench_function(name, |bencher| {
            bencher.iter_custom(|points| {
                let (mut total, mut taken) = (Duration::ZERO, 0);
                for cloud in clouds.iter().cycle() {
                    let begin = thread_time();
                    take(black_box(cloud));
                    total += thread_time().saturating_sub(begin);
                    taken += cloud.count();
                    if taken >= points {
                        break;
                    }
                }
                ledger.add(name, total, taken);
                total.mul_f64(points as f64 / taken as f64)
            });
        });
    }
}
