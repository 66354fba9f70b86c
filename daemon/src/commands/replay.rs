//! `lodestoned replay`: recordings in, poses out.

use lodestone_config::model::Config;

use super::CommandError;
use crate::cli::ReplayArgs;

/// Replays every recording through the lane.
///
/// # Errors
/// [`CommandError`].
pub fn replay(_config: &Config, _args: &ReplayArgs) -> Result<(), CommandError> {
    // CONNECT: the lane with a recording's clock and a file as publisher.
    Err(CommandError::NotBuilt("replay"))
}
