//! `lodestone echo`.

use lodestone_client::{PoseStream, StreamError};

use super::args::EchoArgs;
use super::failure::Failure;
use super::json::PoseLine;
use super::output::{Output, remark};
use super::session::Session;
use super::stop::NOTICE;

pub(super) fn run(session: &Session, args: &EchoArgs) -> Result<(), Failure> {
    let camera = session.camera(args.camera.as_deref())?;
    let mut poses = session.client.poses(&camera)?;
    let mut output = Output::new();
    let mut left = args.count.unwrap_or(u64::MAX);
    let mut told = String::new();
    while left > 0 && !session.stop.asked() {
        match poses.wait(NOTICE) {
            // A daemon that stops or restarts is waited for.
            Err(StreamError::TimedOut { .. }) => {}
            Err(StreamError::NotConnected(why)) => tell_once(&camera, &why.to_string(), &mut told),
            Err(other) => return Err(other.into()),
            Ok(_) => {
                told.clear();
                left -= print(session, &mut poses, &mut output, left)?;
            }
        }
    }
    Ok(())
}

/// Says why nothing comes, unless it has been said already.
fn tell_once(camera: &str, why: &str, told: &mut String) {
    if why != told {
        eprintln!("lodestone: {camera}: waiting: {why}");
        why.clone_into(told);
    }
}

/// Prints at most `most` of the poses that came; returns how many.
fn print(
    session: &Session,
    poses: &mut PoseStream,
    output: &mut Output,
    most: u64,
) -> Result<u64, Failure> {
    let camera = poses.camera().to_owned();
    let batch = poses.all();
    if batch.restarts > 0 {
        remark(format_args!("{camera}: the daemon has restarted"));
    }
    if batch.lost > 0 || batch.invalid > 0 {
        let (lost, invalid) = (batch.lost, batch.invalid);
        remark(format_args!("{camera}: {lost} poses lost, {invalid} invalid"));
    }
    let mut printed = 0;
    for pose in batch.into_iter().take(usize::try_from(most).unwrap_or(usize::MAX)) {
        let line = PoseLine::new(&camera, pose);
        if session.json { output.json(&line) } else { output.line(&line.to_text()) }?;
        printed += 1;
    }
    Ok(printed)
}
