//! systemd: whether shared memory outlives a login.

use std::path::Path;

use super::finding::Finding;
use super::machine::Machine;

const MAIN: &str = "/etc/systemd/logind.conf";
const DROP_INS: [&str; 3] =
    ["/usr/lib/systemd/logind.conf.d", "/run/systemd/logind.conf.d", "/etc/systemd/logind.conf.d"];

pub(super) fn check(machine: &Machine) -> Vec<Finding> {
    if !machine.exists("/run/systemd/system") {
        return vec![Finding::unknown("RemoveIPC", "systemd does not run here")];
    }
    let drop_ins = DROP_INS.iter().flat_map(|directory| {
        machine.names_in(directory).into_iter().map(move |name| format!("{directory}/{name}"))
    });
    let files = std::iter::once(MAIN.to_owned()).chain(drop_ins.filter(|file| is_read(file)));
    // Of several settings the last one holds.
    let last = files.filter_map(|file| remove_ipc(&machine.read(&file).ok()?)).next_back();
    vec![judge(last)]
}

/// systemd reads no others.
fn is_read(file: &str) -> bool {
    Path::new(file).extension().is_some_and(|extension| extension == "conf")
}

fn remove_ipc(text: &str) -> Option<bool> {
    let value =
        text.lines().filter_map(|line| line.trim().strip_prefix("RemoveIPC=")).next_back()?;
    match value.trim().to_ascii_lowercase().as_str() {
        "no" | "false" | "0" | "off" => Some(false),
        "yes" | "true" | "1" | "on" => Some(true),
        _ => None,
    }
}

fn judge(remove: Option<bool>) -> Finding {
    const NAME: &str = "RemoveIPC";
    if remove == Some(false) {
        return Finding::ok(NAME, "no: shared memory stays when a user logs out");
    }
    let found = if remove.is_some() { "yes" } else { "not set, which is yes" };
    Finding::better(NAME, found)
        .means(
            "when the last session of an ordinary user ends, its shared memory is deleted, also under a daemon \
             that runs as that user; system accounts such as lodestone are spared",
        )
        .change(
            "printf '[Login]\\nRemoveIPC=no\\n' | sudo tee /etc/systemd/logind.conf.d/lodestone.conf && \
             sudo systemctl restart systemd-logind",
        )
}

#[cfg(test)]
mod tests {
    use super::super::finding::Verdict;
    use super::*;

    #[test]
    fn the_last_setting_of_a_file_counts_and_a_comment_does_not() {
        assert_eq!(remove_ipc("[Login]\n#RemoveIPC=yes\n"), None);
        assert_eq!(remove_ipc("RemoveIPC=yes\nRemoveIPC=no"), Some(false));
        assert_eq!(remove_ipc("RemoveIPC=perhaps"), None);
    }

    #[test]
    fn only_a_plain_no_is_good() {
        assert_eq!(judge(Some(false)).verdict, Verdict::Ok);
        assert_eq!(judge(Some(true)).verdict, Verdict::Better);
        assert_eq!(judge(None).verdict, Verdict::Better);
    }
}
