//! From a physical value to counts of a signed 16-bit register and back.

use glam::DVec3;

use super::Digital;

/// A three-axis register.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quantiser {
    /// Unit of one count; none keeps the value as it is, without range.
    step: Option<f64>,
}

impl Quantiser {
    /// Registers of `step` per count, or none if not `enabled`.
    pub(crate) const fn new(step: f64, enabled: bool) -> Self {
        Self { step: if enabled { Some(step) } else { None } }
    }

    /// Rounds to whole counts and stops at the ends of the range.
    pub(crate) fn read(self, vector: DVec3) -> Digital {
        let Some(step) = self.step else { return Digital { vector, saturated: false } };
        let (low, high) = (f64::from(i16::MIN), f64::from(i16::MAX));
        let counts = (vector / step).round().clamp(DVec3::splat(low), DVec3::splat(high));
        let at_end = |count: f64| count <= low || count >= high;
        Digital { vector: counts * step, saturated: counts.to_array().into_iter().any(at_end) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_rounded_and_stop_at_the_range() {
        let quantiser = Quantiser::new(0.5, true);
        let inside = quantiser.read(DVec3::new(0.74, -0.76, 3.0));
        assert_eq!(inside, Digital { vector: DVec3::new(0.5, -1.0, 3.0), saturated: false });
        let outside = quantiser.read(DVec3::new(1e9, -1e9, 0.0));
        assert_eq!(outside.vector, DVec3::new(16_383.5, -16_384.0, 0.0));
        assert!(outside.saturated);
    }

    #[test]
    fn switched_off_it_changes_nothing() {
        let vector = DVec3::new(1e9, -0.123, 0.0);
        let read = Quantiser::new(0.5, false).read(vector);
        assert_eq!(read, Digital { vector, saturated: false });
    }
}
