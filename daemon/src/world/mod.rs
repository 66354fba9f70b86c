//! The world that all cameras share: who fixes it, where each camera stands in it, how it is kept.
//!
//! ```text
//! lane ── Membership ──> WorldFrame <── Keeper (housekeeping)
//!         founds, follows  one atomic word   patience, reset, file, pairs, tree
//! ```
//!
//! `W` is levelled by gravity and turned to north by the field, which every filter does for itself.
//! What is left to agree on is its origin and since when it counts: that is [`WorldFrame`], one atomic
//! word that lanes look at once a step. A lane never waits for another one.

mod anchor;
mod founding;
mod frame;
mod keeper;
mod membership;
mod motion;
mod pairs;
mod store;
#[cfg(test)]
mod tests;
mod tie;
mod ties;
mod tree;
mod words;

pub use anchor::anchor_for;
pub use founding::Founding;
pub use frame::{WorldFrame, WorldPhase};
pub(crate) use keeper::unknown as blank_world;
pub use keeper::{Beginning, Keeper};
pub use membership::{MemberSettings, Membership, Place, WorldStep};
pub use motion::Motion;
pub(crate) use pairs::unknown as blank_relative;
pub use pairs::{Pair, relative_of};
pub use store::{Epochs, StoreError};
pub(crate) use tree::blank as blank_transform;
pub use tree::{Edge, Fixed, messages, tree};
