//! What housekeeping does for the world: it looks after it, publishes it, and hears requests.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use iceoryx2::node::Node;
use iceoryx2::prelude::ipc;
use lodestone_config::model::Config;
use lodestone_schema::{RequestKind, StaticTransform};

use crate::publisher::{PublisherError, Requests, WorldPublisher};
use crate::reading::HostTime;
use crate::world::{Keeper, Pair, WorldPhase, messages, tree};

/// The world's keeper with its ports, on the housekeeping thread.
pub(super) struct WorldDuty {
    keeper: Keeper,
    publisher: WorldPublisher,
    requests: Requests,
    /// Raised by a signal.
    reset: Arc<AtomicBool>,
    pairs: Vec<Pair>,
    tree: Vec<StaticTransform>,
    /// Relative poses published.
    relatives: u64,
    /// The phase of the world that was published last.
    shown: Option<WorldPhase>,
}

impl WorldDuty {
    pub(super) fn open(
        node: &Node<ipc::Service>,
        config: &Config,
        keeper: Keeper,
        reset: Arc<AtomicBool>,
    ) -> Result<Self, PublisherError> {
        Ok(Self {
            keeper,
            publisher: WorldPublisher::open(node, &config.shared_memory)?,
            requests: Requests::open(node, &config.shared_memory)?,
            reset,
            pairs: Pair::all(config),
            tree: messages(&tree(config)),
            relatives: 0,
            shown: None,
        })
    }

    /// Several times a second: requests, the world's fate, relative poses.
    pub(super) fn look(&mut self, unix_offset_ns: i64) {
        let mut reset = self.reset.swap(false, Ordering::Relaxed);
        while let Some(request) = self.requests.next() {
            match request {
                RequestKind::ReinitialiseWorld => reset = true,
            }
        }
        if reset {
            self.keeper.reset();
        }
        let now = HostTime::now();
        self.keeper.look(now, unix_offset_ns);
        for pair in &self.pairs {
            let message = pair.message(self.keeper.frame(), now, self.relatives);
            self.publisher.relative(&message);
            self.relatives += 1;
        }
        let phase = self.keeper.frame().phase();
        if self.shown != Some(phase) && self.keeper.is_up_to_date() {
            self.shown = Some(phase);
            self.publisher.world(&self.keeper.message(now, unix_offset_ns));
        }
    }

    /// Once a second: the world and the tree, also for those who came late.
    pub(super) fn publish(&mut self, unix_offset_ns: i64) {
        self.publisher.world(&self.keeper.message(HostTime::now(), unix_offset_ns));
        for edge in &mut self.tree {
            edge.time_ns = HostTime::now().as_nanos();
            self.publisher.transform(edge);
            edge.sequence += u64::from(edge.count);
        }
    }

    /// Messages that could not be sent.
    pub(super) const fn errors(&self) -> u64 {
        self.publisher.errors()
    }

    /// The daemon stops: what is known of the world is written a last time.
    pub(super) fn finish(&mut self) {
        self.keeper.finish();
    }
}
