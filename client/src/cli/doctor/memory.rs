//! What can make a page of memory late: swap, and huge pages being put together.

use super::finding::Finding;
use super::machine::Machine;

pub(super) fn check(machine: &Machine) -> Vec<Finding> {
    let huge = machine.read("/sys/kernel/mm/transparent_hugepage/enabled");
    vec![swap(machine.read("/proc/swaps")), huge_pages(huge)]
}

fn swap(swaps: Result<String, String>) -> Finding {
    const NAME: &str = "swap";
    let swaps = match swaps {
        Ok(swaps) => swaps,
        Err(why) => return Finding::unknown(NAME, why),
    };
    // The first line is a heading.
    let places: Vec<&str> =
        swaps.lines().skip(1).filter_map(|line| line.split_whitespace().next()).collect();
    if places.is_empty() {
        return Finding::ok(NAME, "none");
    }
    Finding::better(NAME, places.join(", "))
        .means("a page of a lane that is not locked may have to come from there, in milliseconds")
        .change("realtime.lock_memory = true, or sudo swapoff -a")
}

fn huge_pages(enabled: Result<String, String>) -> Finding {
    const NAME: &str = "huge pages";
    let enabled = match enabled {
        Ok(enabled) => enabled,
        Err(why) => return Finding::unknown(NAME, why),
    };
    let chosen = enabled.split(['[', ']']).nth(1).unwrap_or("").to_owned();
    match chosen.as_str() {
        "madvise" | "never" => Finding::ok(NAME, chosen),
        "always" => Finding::better(NAME, chosen)
            .means("the kernel may stop a process to put huge pages together")
            .change("echo madvise | sudo tee /sys/kernel/mm/transparent_hugepage/enabled"),
        _ => Finding::unknown(NAME, "transparent_hugepage/enabled says nothing known"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::finding::Verdict;
    use super::*;

    #[test]
    fn swap_is_named_by_its_place() {
        let heading = "Filename Type Size Used Priority";
        assert_eq!(swap(Ok(heading.into())).verdict, Verdict::Ok);
        let found = swap(Ok(format!("{heading}\n/dev/zram0 partition 1 0 100")));
        assert_eq!((found.verdict, &*found.found), (Verdict::Better, "/dev/zram0"));
        assert_eq!(swap(Err("not there".into())).verdict, Verdict::Unknown);
    }

    #[test]
    fn the_bracketed_word_counts() {
        let of = |text: &str| huge_pages(Ok(text.into())).verdict;
        assert_eq!(of("always [madvise] never"), Verdict::Ok);
        assert_eq!(of("[always] madvise never"), Verdict::Better);
        assert_eq!(of("]]["), Verdict::Unknown);
    }
}
