//! Room in `/dev/shm`, and the directory that makes the services findable.

use lodestone_client::Domain;
use rustix::fs::statvfs;
use rustix::process::geteuid;

use super::finding::Finding;
use super::machine::{Machine, Rights};

const DIRECTORY: &str = "/dev/shm";
/// Less than this, and consumers that join may find no room: they and the daemon end by SIGBUS, MiB.
const LEAST_FREE_MIB: u64 = 8;
/// What a daemon with some cameras takes at its start, MiB.
const COMFORTABLE_MIB: u64 = 64;

pub(super) fn check(machine: &Machine, domain: &Domain) -> Vec<Finding> {
    let room = statvfs(machine.path(DIRECTORY)).map_err(|e| format!("{DIRECTORY}: {e}"));
    let room = room.map(|fs| {
        let mib = |blocks: u64| blocks.saturating_mul(fs.f_frsize) >> 20;
        Room { total_mib: mib(fs.f_blocks), free_mib: mib(fs.f_bavail) }
    });
    let rights = machine.rights(&domain.root);
    vec![judge_room(room), judge_root(&domain.root, rights, geteuid().as_raw())]
}

#[derive(Clone, Copy, Debug)]
struct Room {
    total_mib: u64,
    free_mib: u64,
}

fn judge_room(room: Result<Room, String>) -> Finding {
    const NAME: &str = "shared memory";
    let Room { total_mib, free_mib } = match room {
        Ok(room) => room,
        Err(why) => {
            return Finding::bad(NAME, why).means("there is no shared memory to publish in");
        }
    };
    let found = format!("{free_mib} of {total_mib} MiB free in {DIRECTORY}");
    let change = format!(
        "remove what is not needed there, or: sudo mount -o remount,size={}M {DIRECTORY}",
        (total_mib + COMFORTABLE_MIB).next_power_of_two()
    );
    match free_mib {
        ..LEAST_FREE_MIB => Finding::bad(NAME, found)
            .means("the daemon does not start, or ends when a consumer joins (SIGBUS)")
            .change(change),
        LEAST_FREE_MIB..COMFORTABLE_MIB => Finding::better(NAME, found)
            .means("some cameras with a long history and many consumers need more")
            .change(change),
        _ => Finding::ok(NAME, found),
    }
}

/// `rights` are nothing where the directory is not there: the daemon makes it, for its own user.
fn judge_root(root: &str, rights: Option<Rights>, user: u32) -> Finding {
    const NAME: &str = "service files";
    if ["/tmp", "/var/tmp"].iter().any(|tmp| root.starts_with(tmp)) {
        return Finding::better(NAME, format!("{root} is under a directory that is cleaned"))
            .means("after some days cleaners delete the files, and running consumers are cut off")
            .change("shared_memory.root = \"/dev/shm/lodestone/\"");
    }
    let Some(Rights { uid, gid, mode }) = rights else {
        return Finding::unknown(NAME, format!("{root} is not there: no daemon has made it yet"));
    };
    let found = format!("{root} of user {uid}, group {gid}, mode {mode:04o}");
    let shared = mode & 0o070 == 0o070;
    if mode & 0o002 != 0 {
        return Finding::better(NAME, found)
            .means("any process may remove or replace the services' files")
            .change(format!("sudo chmod o-rwx {root}"));
    }
    if shared && mode & 0o1000 != 0 {
        return Finding::bad(NAME, found)
            .means(
                "the sticky bit keeps members of the group from clearing up after one that was killed; the \
                 daemon may then not start again",
            )
            .change(format!("sudo chmod -t {root}"));
    }
    if user != 0 && user != uid && !shared {
        return Finding::bad(NAME, found)
            .means(format!("user {user} gets no poses"))
            .change(format!(
                "run this as user {uid}, or share it: sudo chmod 2770 {root}, and be a member of its group"
            ));
    }
    Finding::ok(NAME, found)
}

#[cfg(test)]
mod tests {
    use super::super::finding::Verdict;
    use super::*;

    fn room(total_mib: u64, free_mib: u64) -> Finding {
        judge_room(Ok(Room { total_mib, free_mib }))
    }

    #[test]
    fn little_room_is_said_with_a_size_that_is_larger() {
        assert_eq!(room(2000, 1900).verdict, Verdict::Ok);
        assert_eq!(room(64, 20).verdict, Verdict::Better);
        let full = room(64, 0);
        assert_eq!(full.verdict, Verdict::Bad);
        assert!(full.change.unwrap().contains("size=128M"));
        assert_eq!(judge_room(Err("not there".into())).verdict, Verdict::Bad);
    }

    #[test]
    fn the_root_is_judged_by_owner_and_mode() {
        let of = |mode, user| {
            judge_root("/dev/shm/l/", Some(Rights { uid: 990, gid: 990, mode }), user).verdict
        };
        assert_eq!(of(0o700, 990), Verdict::Ok);
        assert_eq!(of(0o700, 0), Verdict::Ok);
        assert_eq!(of(0o700, 1000), Verdict::Bad);
        assert_eq!(of(0o2770, 1000), Verdict::Ok);
        assert_eq!(of(0o3770, 990), Verdict::Bad);
        assert_eq!(of(0o777, 990), Verdict::Better);
        assert_eq!(judge_root("/dev/shm/l/", None, 0).verdict, Verdict::Unknown);
        assert_eq!(judge_root("/tmp/l/", None, 0).verdict, Verdict::Better);
    }
}
