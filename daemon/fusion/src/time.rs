//! Sensor time: integer nanoseconds of the sensor's own clock.

use core::ops::{Add, Sub};

/// An instant on the sensor's clock, ns since an arbitrary origin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct SensorTime(i64);

/// A span on the sensor's clock, ns; may be negative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct SensorSpan(i64);

impl SensorTime {
    /// Takes nanoseconds since the clock's origin.
    pub const fn from_nanos(nanos: i64) -> Self {
        Self(nanos)
    }

    /// Nanoseconds since the clock's origin.
    pub const fn as_nanos(self) -> i64 {
        self.0
    }
}

impl SensorSpan {
    /// Takes nanoseconds.
    pub const fn from_nanos(nanos: i64) -> Self {
        Self(nanos)
    }

    /// Takes seconds, rounded to the nanosecond (saturating).
    pub fn from_secs_f64(seconds: f64) -> Self {
        Self(libm_round(seconds * 1e9))
    }

    /// Nanoseconds.
    pub const fn as_nanos(self) -> i64 {
        self.0
    }

    /// Seconds.
    pub fn as_secs_f64(self) -> f64 {
        self.0 as f64 * 1e-9
    }
}

/// Rounds half away from zero; `f64::round` needs `std`.
fn libm_round(value: f64) -> i64 {
    (value + 0.5_f64.copysign(value)) as i64
}

impl Sub for SensorTime {
    type Output = SensorSpan;

    fn sub(self, earlier: Self) -> SensorSpan {
        SensorSpan(self.0.saturating_sub(earlier.0))
    }
}

impl Add<SensorSpan> for SensorTime {
    type Output = Self;

    fn add(self, span: SensorSpan) -> Self {
        Self(self.0.saturating_add(span.0))
    }
}
