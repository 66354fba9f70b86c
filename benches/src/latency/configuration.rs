//! The daemon's configuration for a measurement.

use std::fmt::Write;

use lodestone_schema::transport::Domain;

use super::cores::PRIORITY;

/// What is measured of the daemon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setup {
    /// Synthetic cameras, each at 400 Hz by its own clock.
    pub cameras: usize,
    /// `lane.threads`.
    pub threads: &'static str,
    /// `shared_memory.wake_events`.
    pub wake_events: bool,
}

impl Setup {
    /// One camera as it is by default.
    pub const ONE: Self = Self { cameras: 1, threads: "one", wake_events: false };

    /// The configuration file: cameras that are carried by hand after a rest in which they align. Their
    /// clocks differ by some parts in a thousand, as real ones do, so that their samples meet sometimes.
    ///
    /// The lanes ask for `SCHED_FIFO` if they are to have real time: where it is not allowed, they run on
    /// without.
    pub fn configuration(&self, domain: &Domain, real_time: bool) -> String {
        let Self { threads, wake_events, .. } = self;
        let policy = if real_time { "fifo" } else { "other" };
        let mut text = format!(
            "[shared_memory]\nprefix = {:?}\nroot = {:?}\nwake_events = {wake_events}\n\
             [realtime]\npolicy = {policy:?}\npriority = {PRIORITY}\nlock_memory = {real_time}\n\
             [lane]\nthreads = {threads:?}\n[estimator]\nalignment_rest_s = 0.2\n",
            domain.prefix, domain.root
        );
        for k in 0..self.cameras {
            let rate_error = 0.0011 * (k % 7) as f64 - 0.003 * f64::from(u8::from(k > 0));
            let (name, seed) = (camera(k), k + 1);
            // Writing to a string cannot fail.
            let _ = write!(
                text,
                "[[camera]]\nname = {name:?}\ndriver = \"synthetic\"\n\
                 [camera.synthetic]\ntrajectory = \"walk\"\nrest_s = 0.5\nseed = {seed}\n\
                 [camera.synthetic.transport]\nrate_error = {rate_error:.4}\n"
            );
        }
        text
    }
}

/// Name of a camera of the harness.
pub fn camera(number: usize) -> String {
    format!("bench{number}")
}

#[cfg(test)]
mod tests {
    use lodestone_config::model::Config;

    use super::*;

    #[test]
    fn the_daemon_takes_it() {
        let domain = Domain { prefix: "p_".into(), root: "/dev/shm/x/".into() };
        for setup in [Setup::ONE, Setup { cameras: 64, threads: "timed", wake_events: true }] {
            let text = setup.configuration(&domain, true);
            let config = Config::from_toml("bench", &text).expect("is valid");
            assert_eq!(config.camera.len(), setup.cameras);
            assert_eq!(config.shared_memory.wake_events, setup.wake_events);
        }
    }
}
