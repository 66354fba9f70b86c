//! Writes an initramfs: a cpio archive in the "newc" format (Linux,
//! `Documentation/driver-api/early-userspace/buffer-format.rst`).

/// What an entry is.
enum Kind {
    Directory,
    File,
    CharacterDevice { major: u32, minor: u32 },
}

/// An archive under construction; everything in it belongs to root.
#[derive(Default)]
pub struct Archive {
    bytes: Vec<u8>,
    entries: u32,
}

impl Archive {
    /// Adds a directory; its parent must have been added before.
    pub fn directory(&mut self, path: &str) {
        self.entry(path, 0o040_755, &Kind::Directory, &[]);
    }

    /// Adds a file that everyone may read and execute.
    pub fn executable(&mut self, path: &str, content: &[u8]) {
        self.entry(path, 0o100_755, &Kind::File, content);
    }

    /// Adds a character device that only root may use.
    pub fn character_device(&mut self, path: &str, major: u32, minor: u32) {
        self.entry(path, 0o020_600, &Kind::CharacterDevice { major, minor }, &[]);
    }

    /// Ends the archive.
    pub fn finish(mut self) -> Vec<u8> {
        self.entry("TRAILER!!!", 0, &Kind::File, &[]);
        self.bytes
    }

    fn entry(&mut self, path: &str, mode: u32, kind: &Kind, content: &[u8]) {
        self.entries += 1;
        let name = path.trim_start_matches('/');
        let (major, minor) = match kind {
            Kind::CharacterDevice { major, minor } => (*major, *minor),
            Kind::Directory | Kind::File => (0, 0),
        };
        let links = if matches!(kind, Kind::Directory) { 2 } else { 1 };
        let size = u32::try_from(content.len()).expect("a file below 4 GiB");
        let name_size = u32::try_from(name.len()).expect("a short name") + 1;
        // inode, mode, uid, gid, links, mtime, size, device, device of the node, name, checksum
        let fields = [self.entries, mode, 0, 0, links, 0, size, 0, 0, major, minor, name_size, 0];
        self.bytes.extend_from_slice(b"070701");
        for field in fields {
            self.bytes.extend_from_slice(format!("{field:08x}").as_bytes());
        }
        self.bytes.extend_from_slice(name.as_bytes());
        self.bytes.push(0);
        self.pad();
        self.bytes.extend_from_slice(content);
        self.pad();
    }

    /// Names and contents begin at multiples of four.
    fn pad(&mut self) {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn header_and_padding_follow_the_format() {
        let mut archive = Archive::default();
        archive.executable("/init", b"hello");
        archive.character_device("/console", 5, 1);
        let bytes = archive.finish();

        let header = "070701\
             00000001000081ed0000000000000000000000010000000000000005\
             00000000000000000000000000000000000000050000000000";
        assert_eq!(std::str::from_utf8(&bytes[..110]).unwrap()[..104], header[..104]);
        assert_eq!(&bytes[94..102], b"00000005", "the name and its zero");
        assert_eq!(&bytes[110..124], b"init\0\0hello\0\0\0");
        assert_eq!(&bytes[124..130], b"070701");
        assert_eq!(bytes.len() % 4, 0);
    }
}
