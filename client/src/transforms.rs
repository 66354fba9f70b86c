//! The tree of frames, checked.

use core::time::Duration;

use glam::{DQuat, DVec3};
use lodestone_schema::{ServiceKind, StaticTransform, TransformKind, WORLD_NAME, name_of};

use crate::client::Client;
use crate::error::{MessageError, StreamError};
use crate::message::Message;
use crate::stream::nothing;
use crate::subscription::Subscription;

/// One edge of the tree of frames: `p_parent = R p_child + t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameEdge {
    message: StaticTransform,
    kind: TransformKind,
}

impl TryFrom<StaticTransform> for FrameEdge {
    type Error = MessageError;

    fn try_from(message: StaticTransform) -> Result<Self, MessageError> {
        let code = message.kind;
        let kind = TransformKind::from_code(code)
            .ok_or(MessageError::UnknownCode { field: "kind", code })?;
        name_of(&message.parent).ok_or(MessageError::BadName { field: "parent" })?;
        name_of(&message.child).ok_or(MessageError::BadName { field: "child" })?;
        let norm = DQuat::from_array(message.rotation).length();
        let is_unit = (norm - 1.0).abs() < 1e-6;
        if kind == TransformKind::Fixed && !is_unit {
            return Err(MessageError::NotUnit { norm });
        }
        Ok(Self { message, kind })
    }
}

impl Message for FrameEdge {
    type Raw = StaticTransform;
    const KIND: ServiceKind = ServiceKind::Transforms;
    const SILENCE: Duration = Duration::from_secs(5);

    fn sequence(raw: &StaticTransform) -> u64 {
        raw.sequence
    }

    fn time_ns(raw: &StaticTransform) -> i64 {
        raw.time_ns
    }
}

impl FrameEdge {
    /// The frame in which the child is.
    pub fn parent(&self) -> &str {
        name_of(&self.message.parent).unwrap_or_default()
    }

    /// The frame that is in it.
    pub fn child(&self) -> &str {
        name_of(&self.message.child).unwrap_or_default()
    }

    /// Whether the child moves in its parent: the pose of its name says where it is.
    pub fn is_moving(&self) -> bool {
        self.kind == TransformKind::Moving
    }

    /// Child to parent; `None` where the child moves.
    pub fn rotation(&self) -> Option<DQuat> {
        (!self.is_moving()).then(|| DQuat::from_array(self.message.rotation).normalize())
    }

    /// Origin of the child in the parent's axes, m; `None` where it moves, or nobody has said.
    pub fn translation_m(&self) -> Option<DVec3> {
        Some(DVec3::from_array(self.message.translation_m)).filter(|v| v.is_finite())
    }
}

/// The tree of frames.
///
/// ```no_run
/// # let client = lodestone_client::Client::connect()?;
/// for edge in client.transforms().tree()? {
///     println!("{} -> {}: {:?}", edge.parent(), edge.child(), edge.translation_m());
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct TransformStream {
    subscription: Subscription<FrameEdge>,
    edges: Vec<Option<FrameEdge>>,
}

/// More frames than any vehicle has; a message that claims more is passed over.
const MOST_EDGES: usize = 10_000;

impl TransformStream {
    pub(crate) fn new(client: Client) -> Self {
        Self { subscription: Subscription::new(client, WORLD_NAME.into()), edges: Vec::new() }
    }

    /// Every edge, a parent's before its children's.
    ///
    /// # Errors
    /// [`StreamError`] until all have come, within a second.
    pub fn tree(&mut self) -> Result<Vec<FrameEdge>, StreamError> {
        while let Some(received) = self.subscription.next() {
            if received.restart {
                self.edges.clear();
            }
            if let Ok(edge) = received.message {
                self.take(edge);
            }
        }
        let whole: Option<Vec<FrameEdge>> = self.edges.iter().copied().collect();
        whole.filter(|edges| !edges.is_empty()).ok_or_else(|| nothing(&self.subscription))
    }

    fn take(&mut self, edge: FrameEdge) {
        let (index, count) = (edge.message.index as usize, edge.message.count as usize);
        if index >= count || count > MOST_EDGES {
            return;
        }
        self.edges.resize(count, None);
        self.edges[index] = Some(edge);
    }
}
