//! Counters that one thread writes and any thread reads.

use std::sync::atomic::{AtomicU64, Ordering};

/// A count since the daemon's start.
#[derive(Debug, Default)]
pub struct Counter(AtomicU64);

impl Counter {
    /// Counts `more`; any thread may.
    pub fn add(&self, more: u64) {
        self.0.fetch_add(more, Ordering::Relaxed);
    }

    /// Takes over a total that is kept elsewhere (a driver's, a ring's).
    pub fn set(&self, total: u64) {
        self.0.store(total, Ordering::Relaxed);
    }

    /// The count.
    pub fn get(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

macro_rules! counters {
    ($($(#[$doc:meta])* $name:ident),+ $(,)?) => {
        /// What a lane counts; the fields of [`lodestone_schema::Health`] with these names.
        #[derive(Debug, Default)]
        pub struct LaneCounters { $($(#[$doc])* pub $name: Counter),+ }

        /// The counters at one time.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct CounterValues { $($(#[$doc])* pub $name: u64),+ }

        impl LaneCounters {
            /// Every counter, read one after the other.
            pub fn values(&self) -> CounterValues {
                CounterValues { $($name: self.$name.get()),+ }
            }
        }

        impl CounterValues {
            /// Copies every counter into a health message.
            pub const fn fill(&self, health: &mut lodestone_schema::Health) {
                $(health.$name = self.$name;)+
            }
        }
    };
}

counters! {
    /// Samples taken from the driver.
    samples,
    /// Poses published.
    poses,
    /// Samples pushed out of the full ring, oldest first.
    ring_dropped,
    /// Samples missing by the sensor's time stamps.
    samples_lost,
    /// Grid steps bridged over lost samples.
    steps_bridged,
    /// Samples with a time stamp already seen.
    duplicates,
    /// Samples whose time stamp ran backwards.
    out_of_order,
    /// Samples refused: not finite, out of range, or unreadable.
    invalid,
    /// Times the device was lost and opened again.
    reconnects,
    /// Re-initialisations of the filter.
    resets,
    /// Messages the transport refused.
    publish_errors,
    /// Aiding measurements that corrected the filter.
    aiding_used,
    /// Aiding measurements refused by their gate, or too late.
    aiding_refused,
    /// Aiding measurements that make no sense.
    aiding_invalid,
}
