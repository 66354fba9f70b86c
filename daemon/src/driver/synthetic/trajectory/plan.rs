//! How fast a path is travelled: phases of blended speed, repeated lap by lap.

use crate::driver::synthetic::jet::{Blend, Jet};

/// One phase: the speed goes from `from_m_s` to `to_m_s` along a quintic blend.
#[derive(Clone, Copy, Debug)]
struct Phase {
    start_s: f64,
    start_m: f64,
    duration_s: f64,
    from_m_s: f64,
    to_m_s: f64,
}

impl Phase {
    /// The mean of both speeds holds exactly, because the blend is point-symmetric.
    fn length_m(&self) -> f64 {
        0.5 * (self.from_m_s + self.to_m_s) * self.duration_s
    }

    fn at(&self, time_s: f64) -> Progress {
        let (elapsed, change) = (time_s - self.start_s, self.to_m_s - self.from_m_s);
        let rate = self.duration_s.recip();
        let blend = Blend::at(elapsed * rate);
        let distance = self.from_m_s * elapsed + change * self.duration_s * blend.integral;
        let speed = self.from_m_s + change * blend.value;
        let acceleration = change * blend.first * rate;
        let jerk = change * blend.second * rate * rate;
        let snap = change * blend.third * rate * rate * rate;
        Progress {
            distance: Jet::new(self.start_m + distance, speed, acceleration),
            speed: Jet::new(speed, acceleration, jerk),
            acceleration: Jet::new(acceleration, jerk, snap),
        }
    }
}

/// Where a plan is at one instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    /// Distance since the start, m; grows over the laps.
    pub(crate) distance: Jet,
    /// Speed, m/s.
    pub(crate) speed: Jet,
    /// Acceleration along the path, m/s². Its second derivative jumps where phases meet.
    pub(crate) acceleration: Jet,
}

/// A speed plan: rest, then laps without end. Distance is C³ in time.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    rest_s: f64,
    phases: Vec<Phase>,
    lap_s: f64,
    lap_m: f64,
}

impl Plan {
    /// The plan at a time since the trajectory's beginning, s; before it, it rests.
    pub(crate) fn at(&self, time_s: f64) -> Progress {
        let driven = (time_s - self.rest_s).max(0.0);
        let lap = (driven / self.lap_s).floor();
        // Rounding may put the remainder a hair outside of the lap.
        let within = (driven - lap * self.lap_s).clamp(0.0, self.lap_s);
        let after = self.phases.partition_point(|p| p.start_s <= within);
        let mut progress = self.phases[after.max(1) - 1].at(within);
        progress.distance = progress.distance + lap * self.lap_m;
        progress
    }

    /// Length of one lap, m.
    #[cfg(test)]
    pub(crate) fn lap_m(&self) -> f64 {
        self.lap_m
    }

    /// Duration of one lap, s.
    #[cfg(test)]
    pub(crate) fn lap_s(&self) -> f64 {
        self.lap_s
    }
}

/// Builds a plan leg by leg.
#[derive(Clone, Debug)]
pub(crate) struct PlanBuilder {
    rest_s: f64,
    /// Mean acceleration and deceleration of a change of speed, m/s²; the peak is 1.875 of it.
    change_m_s2: f64,
    phases: Vec<Phase>,
    time_s: f64,
    distance_m: f64,
    speed_m_s: f64,
}

impl PlanBuilder {
    /// Begins with a rest; speed changes with `change_m_s2` on average.
    pub(crate) fn after_rest(rest_s: f64, change_m_s2: f64) -> Self {
        Self {
            rest_s,
            change_m_s2,
            phases: Vec::new(),
            time_s: 0.0,
            distance_m: 0.0,
            speed_m_s: 0.0,
        }
    }

    /// Travels `length_m`: changes to at most `cruise_m_s` and reaches the end with `exit_m_s`.
    ///
    /// Where the leg is too short for that, it cruises slower, or leaves slower, or brakes harder.
    pub(crate) fn leg(&mut self, length_m: f64, cruise_m_s: f64, exit_m_s: f64) -> &mut Self {
        let (change, entry) = (self.change_m_s2, self.speed_m_s);
        let reachable = (entry * entry + 2.0 * change * length_m).sqrt();
        let exit = exit_m_s.min(reachable);
        let top = (0.5 * (entry * entry + exit * exit) + change * length_m).sqrt();
        let cruise = cruise_m_s.min(top).max(exit.min(entry));
        let up_m = (cruise * cruise - entry * entry).abs() / (2.0 * change);
        let down_m = (cruise * cruise - exit * exit).abs() / (2.0 * change);
        let shrink = (length_m / (up_m + down_m)).min(1.0);
        self.change_over(up_m * shrink, cruise);
        self.change_over((length_m - (up_m + down_m) * shrink).max(0.0), cruise);
        self.change_over(down_m * shrink, exit)
    }

    /// Stands still; only after a leg that ends at speed zero.
    pub(crate) fn pause(&mut self, duration_s: f64) -> &mut Self {
        debug_assert!(self.speed_m_s == 0.0, "a pause begins at rest");
        self.push(duration_s, 0.0)
    }

    /// The plan of the legs so far, repeated; the last one ends as the first one begins, at rest.
    pub(crate) fn finish(&mut self) -> Plan {
        debug_assert!(self.speed_m_s == 0.0, "a lap ends at rest");
        Plan {
            rest_s: self.rest_s,
            phases: std::mem::take(&mut self.phases),
            lap_s: self.time_s,
            lap_m: self.distance_m,
        }
    }

    fn change_over(&mut self, length_m: f64, to_m_s: f64) -> &mut Self {
        let mean = 0.5 * (self.speed_m_s + to_m_s);
        if length_m <= 1e-9 || mean <= 0.0 {
            return self;
        }
        self.push(length_m / mean, to_m_s)
    }

    fn push(&mut self, duration_s: f64, to_m_s: f64) -> &mut Self {
        let phase = Phase {
            start_s: self.time_s,
            start_m: self.distance_m,
            duration_s,
            from_m_s: self.speed_m_s,
            to_m_s,
        };
        self.time_s += duration_s;
        self.distance_m += phase.length_m();
        self.speed_m_s = to_m_s;
        self.phases.push(phase);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn plan(cruise: f64, length: f64) -> Plan {
        let mut builder = PlanBuilder::after_rest(2.0, 1.5);
        builder.leg(length, cruise, 4.0).leg(12.0, 4.0, 4.0).leg(length, cruise, 0.0).pause(3.0);
        builder.finish()
    }

    proptest! {
        #[test]
        fn legs_have_their_length(cruise in 4.0..25.0f64, length in 10.0..400.0f64) {
            let plan = plan(cruise, length);
            prop_assert!((plan.lap_m() - (2.0 * length + 12.0)).abs() < 1e-9);
        }

        #[test]
        fn speed_and_its_change_stay_in_bounds(cruise in 4.0..25.0f64, t in 0.0..500.0f64) {
            let at = plan(cruise, 100.0).at(t);
            prop_assert!(at.speed.value >= -1e-12 && at.speed.value <= cruise + 1e-12);
            prop_assert!(at.acceleration.value.abs() <= 1.875 * 1.5 + 1e-9);
        }

        #[test]
        fn every_derivative_fits_the_next(t in 0.0..200.0f64) {
            const STEP: f64 = 1e-5;
            let plan = plan(20.0, 150.0);
            let (a, b, c) = (plan.at(t - STEP), plan.at(t), plan.at(t + STEP));
            let slope = |a: Jet, c: Jet| (c.value - a.value) / (2.0 * STEP);
            prop_assert!((slope(a.distance, c.distance) - b.speed.value).abs() < 1e-6);
            prop_assert!((slope(a.speed, c.speed) - b.acceleration.value).abs() < 1e-4);
            prop_assert!((slope(a.acceleration, c.acceleration) - b.acceleration.first).abs() < 1e-2);
        }
    }

    #[test]
    fn it_rests_first_and_at_the_end_of_each_lap() {
        let plan = plan(20.0, 150.0);
        for t in [-1.0, 0.0, 1.0, 2.0] {
            assert_eq!(plan.at(t).distance, Jet::constant(0.0));
        }
        let pause = plan.at(2.0 + plan.lap_s() - 1.0);
        assert!(pause.speed.value.abs() < 1e-12);
        assert!((pause.distance.value - plan.lap_m()).abs() < 1e-9);
    }
}
