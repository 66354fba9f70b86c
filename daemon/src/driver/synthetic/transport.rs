//! When samples are taken, which of them are lost, and when the others arrive.

use lodestone_config::model::Transport;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Exp1, StandardNormal};

use super::random::Stream;

/// Rate of the ZED 2's IMU, Hz.
pub(crate) const NOMINAL_RATE_HZ: f64 = 400.0;
/// Sampling instants stay within this part of the interval around their place, so that they
/// never change their order.
const LARGEST_JITTER: f64 = 0.45;

/// One sample on its way. Times are seconds since the source began.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slot {
    /// When the sensor takes it.
    pub(crate) time_s: f64,
    /// When it arrives; never before an earlier sample.
    pub(crate) due_s: f64,
    /// It does not arrive.
    pub(crate) lost: bool,
}

/// The endless sequence of samples.
#[derive(Clone, Debug)]
pub(crate) struct Schedule {
    interval_s: f64,
    jitter_sigma_s: f64,
    drop_probability: f64,
    delay_mean_s: f64,
    jitter: ChaCha8Rng,
    drop: ChaCha8Rng,
    delay: ChaCha8Rng,
    index: u64,
    last_due_s: f64,
}

impl Schedule {
    /// The samples of a configured transport.
    pub(crate) fn new(transport: &Transport, seed: u64) -> Self {
        Self {
            interval_s: rate_hz(transport).recip(),
            jitter_sigma_s: transport.sampling_jitter_s,
            drop_probability: transport.drop_probability,
            delay_mean_s: transport.arrival_delay_s,
            jitter: Stream::Jitter.of(seed),
            drop: Stream::Drop.of(seed),
            delay: Stream::Delay.of(seed),
            index: 0,
            last_due_s: 0.0,
        }
    }

    /// The next sample.
    pub(crate) fn next_slot(&mut self) -> Slot {
        let normal: f64 = StandardNormal.sample(&mut self.jitter);
        let exponential: f64 = Exp1.sample(&mut self.delay);
        let uniform: f64 = self.drop.random();
        let bound_s = LARGEST_JITTER * self.interval_s;
        let jitter_s = (normal * self.jitter_sigma_s).clamp(-bound_s, bound_s);
        let time_s = self.index as f64 * self.interval_s + jitter_s;
        self.index += 1;
        let due_s = (time_s + exponential * self.delay_mean_s).max(self.last_due_s);
        let lost = uniform < self.drop_probability;
        if !lost {
            self.last_due_s = due_s;
        }
        Slot { time_s, due_s, lost }
    }
}

/// Samples per second of the world.
pub(crate) fn rate_hz(transport: &Transport) -> f64 {
    NOMINAL_RATE_HZ * (1.0 + transport.rate_error)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slots(transport: &Transport, count: usize) -> Vec<Slot> {
        let mut schedule = Schedule::new(transport, 7);
        (0..count).map(|_| schedule.next_slot()).collect()
    }

    #[test]
    fn a_perfect_transport_is_a_ruler() {
        for (k, slot) in slots(&Transport::default(), 1000).iter().enumerate() {
            assert!((slot.time_s - k as f64 * 0.0025).abs() < 1e-12);
            assert!(!slot.lost && (slot.due_s - slot.time_s).abs() < 1e-12);
        }
    }

    #[test]
    fn a_rate_error_changes_the_interval() {
        let fast = slots(&Transport { rate_error: 0.02, ..Transport::default() }, 409);
        assert!((fast[408].time_s - 1.0).abs() < 1e-9);
    }

    #[test]
    fn drops_come_as_often_as_configured() {
        let (count, p) = (100_000, 0.03);
        let transport = Transport { drop_probability: p, ..Transport::default() };
        let lost = slots(&transport, count).iter().filter(|s| s.lost).count() as f64;
        let (mean, sigma) = (count as f64 * p, (count as f64 * p * (1.0 - p)).sqrt());
        assert!((lost - mean).abs() < 4.0 * sigma, "{lost} lost, {mean} ± {sigma} expected");
    }

    #[test]
    fn jitter_and_delay_keep_the_order() {
        let transport =
            Transport { sampling_jitter_s: 1e-3, arrival_delay_s: 4e-3, ..Transport::default() };
        let slots = slots(&transport, 20_000);
        assert!(slots.windows(2).all(|w| w[0].time_s < w[1].time_s && w[0].due_s <= w[1].due_s));
        assert!(slots.iter().all(|s| s.due_s >= s.time_s));
    }

    #[test]
    fn the_delay_has_its_mean_where_samples_do_not_queue() {
        let transport = Transport { arrival_delay_s: 1e-4, ..Transport::default() };
        let slots = slots(&transport, 50_000);
        let mean = slots.iter().map(|s| s.due_s - s.time_s).sum::<f64>() / 50_000.0;
        assert!((mean / 1e-4 - 1.0).abs() < 0.02, "{mean}");
    }

    #[test]
    fn one_cause_does_not_change_the_draws_of_another() {
        let plain = Transport { sampling_jitter_s: 1e-4, ..Transport::default() };
        let lossy = Transport { drop_probability: 0.5, arrival_delay_s: 1e-3, ..plain.clone() };
        for (a, b) in slots(&plain, 1000).iter().zip(slots(&lossy, 1000)) {
            assert_eq!(a.time_s.to_bits(), b.time_s.to_bits());
        }
    }
}
