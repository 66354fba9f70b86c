//! Finding where lenses are, in the daemon's tree of frames.

use std::time::Instant;

use core::time::Duration;

use crate::client::Client;
use crate::cloud::Lens;
use crate::transforms::{FrameEdge, TransformStream};

use super::camera::CameraMerge;

/// The tree is sent about once a second; it is read again in case the configuration has changed.
const BETWEEN_LOOKS: Duration = Duration::from_secs(1);
/// After this long without a tree, lenses count as at the IMU.
const PATIENCE: Duration = Duration::from_secs(2);

/// The lenses of all cameras.
#[derive(Debug)]
pub(super) struct Lenses {
    transforms: TransformStream,
    tree: Vec<FrameEdge>,
    asked_first: Option<Instant>,
    next_look: Option<Instant>,
}

impl Lenses {
    pub(super) fn new(client: &Client) -> Self {
        Self {
            transforms: client.transforms(),
            tree: Vec::new(),
            asked_first: None,
            next_look: None,
        }
    }

    /// The lens of a camera; `None` while it may still turn up.
    pub(super) fn of(&mut self, camera: &CameraMerge) -> Option<Lens> {
        if let Some(given) = camera.lens {
            return Some(given);
        }
        let now = Instant::now();
        let since = *self.asked_first.get_or_insert(now);
        if self.next_look.is_none_or(|next| now >= next) {
            self.look(now);
        }
        let found = Lens::of(&camera.camera, &self.tree)
            .or_else(|| Lens::of(camera.poses.camera(), &self.tree));
        let is_hopeless = now.saturating_duration_since(since) > PATIENCE;
        found.or(is_hopeless.then_some(Lens::AT_IMU))
    }

    fn look(&mut self, now: Instant) {
        if let Ok(tree) = self.transforms.tree() {
            self.tree = tree;
            self.next_look = Some(now + BETWEEN_LOOKS);
        }
    }
}
