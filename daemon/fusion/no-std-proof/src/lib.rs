//! The estimator as a C library without operating system, heap or standard library.
//!
//! The caller gives the memory: `lodestone_size` bytes, aligned to `lodestone_alignment`.
#![no_std]

use core::mem::MaybeUninit;

use lodestone_fusion::{
    Accel, Accepted, Estimator, Grid, GridParameters, Gyro, ImuSample, Mag, Parameters, SensorTime,
};

/// Grid and estimator of one camera; opaque to C.
pub struct Filter {
    grid: Grid,
    estimator: Estimator,
}

/// A sample in the body frame (x forward, y left, z up).
#[repr(C)]
pub struct Sample {
    /// Sensor time, ns.
    pub time_ns: i64,
    /// Angular rate, rad/s.
    pub gyro: [f64; 3],
    /// Specific force, m/s².
    pub accel: [f64; 3],
    /// Magnetic field, µT; not finite where there is no new reading.
    pub mag: [f64; 3],
}

/// Pose in the world (east, north, up).
#[repr(C)]
pub struct Pose {
    /// Time of validity, sensor time, ns.
    pub time_ns: i64,
    /// Body to world, Hamilton, x y z w.
    pub orientation: [f64; 4],
    /// Position, m.
    pub position: [f64; 3],
}

/// Bytes that a filter takes.
#[unsafe(no_mangle)]
pub extern "C" fn lodestone_size() -> usize {
    size_of::<Filter>()
}

/// Alignment of a filter, bytes.
#[unsafe(no_mangle)]
pub extern "C" fn lodestone_alignment() -> usize {
    align_of::<Filter>()
}

/// Begins a filter for samples at a nominal rate, Hz.
#[unsafe(no_mangle)]
#[allow(improper_ctypes_definitions, reason = "C holds the memory and never looks inside")]
pub extern "C" fn lodestone_begin(filter: &mut MaybeUninit<Filter>, rate_hz: f64) {
    filter.write(Filter {
        grid: Grid::new(GridParameters::at_rate(rate_hz)),
        estimator: Estimator::new(Parameters::default()),
    });
}

/// Takes a sample; true if `pose` was written: the sample was taken and the filter is aligned.
#[unsafe(no_mangle)]
#[allow(improper_ctypes_definitions, reason = "C holds the memory and never looks inside")]
pub extern "C" fn lodestone_step(filter: &mut Filter, sample: &Sample, pose: &mut Pose) -> bool {
    let Ok(accepted) = filter.grid.push(imu_sample(sample)) else { return false };
    if let Accepted::Gap { span, .. } = accepted {
        filter.estimator.cross_gap(span);
    }
    while let Some(step) = filter.grid.next_step() {
        filter.estimator.step(&step);
    }
    let Some(estimate) = filter.estimator.estimate_ahead(&filter.grid.remainder()) else {
        return false;
    };
    *pose = Pose {
        time_ns: estimate.time.as_nanos(),
        orientation: estimate.orientation.quaternion().to_array(),
        position: estimate.position.to_array(),
    };
    true
}

fn imu_sample(sample: &Sample) -> ImuSample {
    let fresh = sample.mag.iter().all(|x| x.is_finite());
    ImuSample {
        time: SensorTime::from_nanos(sample.time_ns),
        gyro: Gyro::new(sample.gyro.into()),
        accel: Accel::new(sample.accel.into()),
        mag: fresh.then(|| Mag::new(sample.mag.into())),
        saturated: false,
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}
