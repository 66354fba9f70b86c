//! `lodestoned check`: validates a configuration and the files it names.

use std::io::Write;
use std::path::Path;

use lodestone_config::Loaded;
use lodestone_config::model::Camera;

use super::{CommandError, load};
use crate::cli::CheckArgs;
use crate::lane::low_pass_of;
use crate::recording::Recording;
use crate::service::space::needed_bytes;

/// Validates, and says what the configuration asks for.
///
/// # Errors
/// [`CommandError`] names everything that is wrong.
pub fn check(file: Option<&Path>, args: &CheckArgs) -> Result<(), CommandError> {
    if args.explain {
        say(&explanation(args.json));
        return Ok(());
    }
    let loaded = load(file)?;
    check_files(&loaded)?;
    let name = file.map_or("embedded configuration".into(), |file| file.display().to_string());
    let low_passes: String = loaded.config.camera.iter().filter_map(low_pass).collect();
    let memory_mib = needed_bytes(&loaded.config) as f64 / f64::from(1 << 20);
    say(&format!(
        "{name}: good\n{}{low_passes}shared memory: {memory_mib:.1} MiB\n",
        loaded.config.summary()
    ));
    Ok(())
}

/// What a camera's low-pass delays.
fn low_pass(camera: &Camera) -> Option<String> {
    let cut_off_hz = camera.low_pass_hz?;
    // A recording's rate is its own; most come at this one too.
    let filter = low_pass_of(camera, camera.model.nominal_rate_hz()).ok().flatten()?;
    Some(format!(
        "filter  {}: low-pass {cut_off_hz} Hz delays gyroscope and accelerometer by {:.2} ms, made up for\n",
        camera.name,
        filter.group_delay_s() * 1e3
    ))
}

fn explanation(json: bool) -> String {
    if json {
        return format!("{}\n", serde_json::json!(lodestone_config::keys()));
    }
    format!("{}\n{}", lodestone_config::explain(), lodestone_config::explain_calibration())
}

/// Calibrations, recordings and the kept world are opened, so that a run will not fail on them.
pub(super) fn check_files(loaded: &Loaded) -> Result<(), CommandError> {
    let mut problems = Vec::new();
    if let Err(errors) = loaded.calibrations() {
        problems.extend(errors.iter().map(ToString::to_string));
    }
    problems.extend(loaded.kept_world().err().map(|e| e.to_string()));
    let recordings = loaded.config.camera.iter().filter_map(|camera| loaded.recording(camera));
    let unreadable = recordings.filter_map(|path| Recording::open(&path).err());
    problems.extend(unreadable.map(|e| e.to_string()));
    if problems.is_empty() { Ok(()) } else { Err(CommandError::Files(problems.join("\n"))) }
}

fn say(text: &str) {
    // A reader that went away does not make the configuration worse.
    let _ = std::io::stdout().write_all(text.as_bytes());
}
