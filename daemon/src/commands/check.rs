//! `lodestoned check`: validates a configuration.

use std::io::Write;
use std::path::Path;

use super::{CommandError, load};
use crate::cli::CheckArgs;
use crate::service::space::needed_bytes;

/// Validates, and says what the configuration asks for.
///
/// # Errors
/// [`CommandError`] names everything that is wrong.
pub fn check(file: Option<&Path>, args: &CheckArgs) -> Result<(), CommandError> {
    if args.explain {
        // CONNECT: the table of keys with unit, default and range.
        return Err(CommandError::NotBuilt("check --explain"));
    }
    let config = load(file)?;
    let name = file.map_or("embedded configuration".into(), |file| file.display().to_string());
    // A reader that went away does not make the configuration worse.
    let _ = writeln!(
        std::io::stdout(),
        "{name}: good; {} cameras, {:.1} MiB of shared memory",
        config.camera.len(),
        needed_bytes(&config) as f64 / f64::from(1 << 20),
    );
    Ok(())
}
