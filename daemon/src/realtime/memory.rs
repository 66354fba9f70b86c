//! Locks the process's memory.

use rustix::mm::{MlockAllFlags, mlockall};
use rustix::process::{Resource, getrlimit};
use rustix::thread::{CapabilitySet, capabilities};

use super::Refusal;

/// Locks what is mapped now, with every page of it there, and what will be mapped later as far as it is
/// touched. Called once the lanes have what they need.
///
/// Later mappings are locked on their first touch only: a consumer that joins maps a file into the
/// publishing lane, and filling all of it at once would stall that lane. Under a limit they are
/// not locked at all, as a mapping beyond the limit fails, and with it the consumer's connection.
///
/// # Errors
/// [`Refusal::MemoryLock`]; nothing is locked then.
pub fn lock() -> Result<(), Refusal> {
    let limit = getrlimit(Resource::Memlock).current;
    let lock = |flags| mlockall(flags).map_err(|errno| Refusal::MemoryLock { limit, errno });
    lock(MlockAllFlags::CURRENT)?;
    if limit.is_none() || may_exceed_limits() {
        lock(MlockAllFlags::FUTURE | MlockAllFlags::ONFAULT)?;
    }
    Ok(())
}

fn may_exceed_limits() -> bool {
    capabilities(None).is_ok_and(|own| own.effective.contains(CapabilitySet::IPC_LOCK))
}
