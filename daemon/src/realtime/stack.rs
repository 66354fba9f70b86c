//! Touches a thread's stack before it matters.

use std::hint::black_box;

const PAGE: usize = 4096;

/// Writes to so much of the calling thread's stack, so that no page of it is new later.
pub(super) fn prefault(kib: u32) {
    let pages = kib as usize * 1024 / PAGE;
    if pages > 0 {
        touch(pages);
    }
}

/// A frame of a page or more for each call, which no inlining may merge.
#[inline(never)]
fn touch(pages: usize) {
    let mut page = [0_u8; PAGE];
    black_box(&mut page);
    if pages > 1 {
        touch(pages - 1);
    }
    // Still needed here, so that the call above is no jump that gives this frame up first.
    black_box(&page);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Resident stack of this process's mappings around an address, KiB, by the kernel's account.
    fn resident_kib(address: usize) -> u64 {
        let smaps = std::fs::read_to_string("/proc/self/smaps").unwrap();
        let mut inside = false;
        for line in smaps.lines() {
            if let Some((range, _)) = line.split_once(' ')
                && let Some((start, end)) = range.split_once('-')
                && let (Ok(start), Ok(end)) =
                    (usize::from_str_radix(start, 16), usize::from_str_radix(end, 16))
            {
                inside = (start..end).contains(&address);
            }
            if let (true, Some(size)) = (inside, line.strip_prefix("Rss:")) {
                return size.trim().trim_end_matches(" kB").parse().unwrap();
            }
        }
        panic!("no mapping of the stack");
    }

    #[test]
    fn what_was_asked_for_is_resident_afterwards_and_was_not_before() {
        std::thread::spawn(|| {
            let here = 0_u8;
            let address = &raw const here as usize;
            let before = resident_kib(address);
            prefault(512);
            let after = resident_kib(address);
            assert!(before < 512 && after >= 512, "{before} KiB before, {after} KiB after");
        })
        .join()
        .unwrap();
    }
}
