//! Removes what killed processes left in the domain, before anything new needs the room.

use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeState};
use iceoryx2::prelude::{CallbackProgression, ipc};
use tracing::{info, warn};

/// Removes the files of every dead daemon and consumer; call it under the instance lock.
///
/// What cannot be removed (another user's, another version's) is logged and left: it takes room,
/// but opening the services says more exactly whether it is in the way.
pub fn clear(settings: &Config) {
    let mut removed = 0;
    let listed = Node::<ipc::Service>::list(settings, |node| {
        if let NodeState::Dead(dead) = node {
            match dead.try_remove_stale_resources() {
                Ok(()) => removed += 1,
                Err(e) => warn!("cannot remove what a killed process left: {e:?}"),
            }
        }
        CallbackProgression::Continue
    });
    if let Err(e) = listed {
        warn!("cannot look for what killed processes left: {e:?}");
    }
    if removed > 0 {
        info!("removed what {removed} killed nodes left in shared memory");
    }
}
