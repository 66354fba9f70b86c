//! iceoryx2: what other programs of it are set to, and what killed processes left.

use std::time::Duration;

use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeState};
use iceoryx2::prelude::{CallbackProgression, ipc};
use lodestone_client::Domain;

use super::finding::Finding;
use super::machine::Machine;

/// Where iceoryx2 looks for settings.
const GLOBAL: &str = "/etc/iceoryx2/iceoryx2.toml";
/// Above this a publisher stands still too long for a subscriber whose files it may not open.
const LONGEST_TIMEOUT: Duration = Duration::from_millis(5);

/// `living` is false for a machine that is made up: its processes are not ours.
pub(super) fn check(machine: &Machine, domain: &Domain, living: bool) -> Vec<Finding> {
    let dead = if living && machine.exists(&domain.root) { dead_nodes(domain) } else { Ok(0) };
    vec![settings(machine.read(GLOBAL).ok().as_deref(), domain), leftovers(dead)]
}

fn settings(text: Option<&str>, domain: &Domain) -> Finding {
    const NAME: &str = "iceoryx2";
    let Some(text) = text else {
        return Finding::ok(
            NAME,
            format!(
                "no {GLOBAL}; Lodestone's programs bring their own settings, others need these"
            ),
        )
        .change(format!("for iox2 and bridges: {}", wanted(domain)));
    };
    let config = match toml::from_str::<Config>(text) {
        Ok(config) => config.global,
        Err(error) => {
            let line = error.to_string().lines().next().unwrap_or_default().to_owned();
            return Finding::bad(NAME, format!("{GLOBAL}: {line}"))
                .means("other programs that use iceoryx2 fail or take its defaults")
                .change(format!("correct it: {}", wanted(domain)));
        }
    };
    let (prefix, root) = (config.prefix.to_string(), config.root_path().to_string());
    let found = format!(
        "{GLOBAL}: prefix {prefix:?}, root {root:?}, creation timeout {:?}",
        config.creation_timeout
    );
    let same_place =
        prefix == domain.prefix && root.trim_end_matches('/') == domain.root.trim_end_matches('/');
    if !same_place {
        return Finding::better(NAME, found)
            .means("iox2 and bridges look at another place, and see no cameras")
            .change(wanted(domain));
    }
    if config.creation_timeout > LONGEST_TIMEOUT {
        return Finding::better(NAME, found)
            .means(
                "a program that publishes there stands still that long for one it has no rights to",
            )
            .change(wanted(domain));
    }
    Finding::ok(NAME, found)
}

fn wanted(domain: &Domain) -> String {
    format!(
        "in {GLOBAL}, [global]: prefix = {:?}, root-path = {:?}, creation-timeout = {{ secs = 0, nanos = \
         1000000 }}",
        domain.prefix, domain.root
    )
}

fn dead_nodes(domain: &Domain) -> Result<usize, String> {
    let config = domain.enter().map_err(|error| error.to_string())?;
    let mut dead = 0;
    Node::<ipc::Service>::list(config, |state| {
        dead += usize::from(matches!(state, NodeState::Dead(_)));
        CallbackProgression::Continue
    })
    .map_err(|error| format!("nodes cannot be listed: {error}"))?;
    Ok(dead)
}

fn leftovers(dead: Result<usize, String>) -> Finding {
    const NAME: &str = "leftovers";
    match dead {
        Ok(0) => Finding::ok(NAME, "no process was killed without being cleared up after"),
        Ok(count) => Finding::better(NAME, format!("{count} killed processes left files"))
            .means("they take shared memory; a running daemon clears them within a second")
            .change("start lodestoned, or stop it and: rm -r its shared_memory.root and PREFIX* in /dev/shm"),
        Err(why) => Finding::unknown(NAME, why),
    }
}

#[cfg(test)]
mod tests {
    use super::super::finding::Verdict;
    use super::*;

    fn of(prefix: &str, root: &str, timeout_ns: u32) -> Verdict {
        let mut text = toml::to_string(&Config::default()).unwrap().parse::<toml::Table>().unwrap();
        let global = text["global"].as_table_mut().unwrap();
        global.insert("prefix".into(), prefix.into());
        global.insert("root-path".into(), root.into());
        let timeout = [("secs", 0), ("nanos", i64::from(timeout_ns))];
        let timeout = timeout.map(|(key, n)| (key.to_owned(), n.into()));
        global.insert("creation-timeout".into(), toml::Table::from_iter(timeout).into());
        settings(Some(&text.to_string()), &Domain::default()).verdict
    }

    #[test]
    fn settings_of_the_system_are_compared_with_ours() {
        let Domain { prefix, root } = Domain::default();
        assert_eq!(of(&prefix, &root, 1_000_000), Verdict::Ok);
        assert_eq!(of(&prefix, &root, 900_000_000), Verdict::Better);
        assert_eq!(of("iox2_", &root, 1_000_000), Verdict::Better);
        assert_eq!(of(&prefix, "/tmp/iceoryx2/", 1_000_000), Verdict::Better);
        assert_eq!(settings(None, &Domain::default()).verdict, Verdict::Ok);
        assert_eq!(settings(Some("[global"), &Domain::default()).verdict, Verdict::Bad);
    }

    #[test]
    fn what_was_left_is_counted() {
        assert_eq!(leftovers(Ok(0)).verdict, Verdict::Ok);
        assert!(leftovers(Ok(3)).found.starts_with("3 killed"));
        assert_eq!(leftovers(Err("no right".into())).verdict, Verdict::Unknown);
    }
}
