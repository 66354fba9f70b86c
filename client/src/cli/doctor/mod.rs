//! `lodestone doctor`: whether this machine lets poses be in time, and what to change.
//!
//! Each family of checks reads files of the machine and judges them by functions of their text alone.

mod clock;
mod daemon;
mod devices;
mod finding;
mod kernel;
mod limits;
mod machine;
mod memory;
mod service;
mod shared_memory;
mod transport;

use lodestone_client::Domain;

use self::finding::{Finding, Verdict};
use self::machine::Machine;
use super::args::DoctorArgs;
use super::failure::Failure;
use super::output::Output;
use super::session::Session;

pub(super) fn run(session: &Session, args: &DoctorArgs) -> Result<(), Failure> {
    let machine = Machine::at(args.machine.as_deref().unwrap_or("/".as_ref()));
    let findings = examine(&machine, session.client.domain(), args.machine.is_none());
    let mut output = Output::new();
    for finding in &findings {
        if session.json {
            output.json(finding)?;
        } else {
            output.line(&finding.to_text())?;
        }
    }
    let count = |verdict| findings.iter().filter(|f| f.verdict == verdict).count();
    let (bad, better) = (count(Verdict::Bad), count(Verdict::Better));
    if bad > 0 {
        return Err(Failure::Other(format!("of {} checks {bad} are bad", findings.len())));
    }
    if !session.json {
        output.line(&format!("\nnothing bad; {better} of {} could be better", findings.len()))?;
    }
    Ok(())
}

/// All checks; `living` unless the machine is made up.
fn examine(machine: &Machine, domain: &Domain, living: bool) -> Vec<Finding> {
    [
        limits::check(machine),
        kernel::check(machine),
        clock::check(machine),
        memory::check(machine),
        shared_memory::check(machine, domain),
        transport::check(machine, domain, living),
        service::check(machine),
        devices::check(machine),
        daemon::check(machine, domain),
    ]
    .concat()
}

#[cfg(test)]
mod tests;
