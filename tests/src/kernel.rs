//! Boots a user-mode Linux kernel with one of our programs as its only process.
//!
//! The kernel is an ordinary process, so nothing is needed but the file. It lives outside this
//! repository (`../shared/kernel` beside it); where it is missing, tests say so and pass.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, Read};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, WaitId, WaitIdOptions};

use crate::cpio::Archive;

const KERNEL: &str = "../shared/kernel/linux-min.uml.xz";

/// A kernel that can be booted.
pub struct Kernel {
    compressed: PathBuf,
}

/// What a kernel printed until it stopped.
pub struct Output {
    /// Its console.
    pub console: String,
    /// It did not stop by itself within the time and was killed.
    pub timed_out: bool,
}

impl Kernel {
    /// Finds the kernel and what unpacks it.
    ///
    /// # Errors
    ///
    /// What is missing, in words.
    pub fn find() -> Result<Self, String> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let compressed = root.join(KERNEL);
        if !cfg!(target_arch = "x86_64") {
            return Err("the kernel is built for x86-64".into());
        }
        if !compressed.exists() {
            return Err(format!("no kernel at {KERNEL}"));
        }
        let xz = Command::new("xz").arg("--version").stdout(Stdio::null()).status();
        xz.map_err(|error| format!("cannot run xz: {error}"))?;
        Ok(Self { compressed })
    }

    /// Boots with `program` as `/init` and waits until it powers off, at most `limit`.
    ///
    /// Everything lies in a temporary directory that is removed; every process is killed.
    ///
    /// # Errors
    ///
    /// What the file system or the process table says.
    pub fn boot(&self, program: &Path, limit: Duration) -> io::Result<Output> {
        // Memory in a file system of memory: a disk would be written to.
        let shared_memory = Path::new("/dev/shm");
        let parent =
            if shared_memory.is_dir() { shared_memory.into() } else { std::env::temp_dir() };
        let directory = tempfile::Builder::new().prefix("lodestone-uml-").tempdir_in(parent)?;
        let kernel = directory.path().join("linux");
        unpack(&self.compressed, &kernel)?;
        let initramfs = directory.path().join("initramfs");
        std::fs::write(&initramfs, archive_of(program)?)?;
        let boot = || Running::start(&kernel, &initramfs, directory.path())?.wait(limit);
        let mut output = boot()?;
        for _ in 1..BOOTS {
            if !output.console.contains(INIT_IS_BUSY) {
                break;
            }
            output = boot()?;
        }
        Ok(output)
    }
}

/// The kernel closes the files of its initramfs a little after it has unpacked them. Now and then
/// /init is still open for writing (ETXTBSY) when it is to run; then only another boot helps.
const INIT_IS_BUSY: &str = "Failed to execute /init (error -26)";

/// Most boots until /init runs.
const BOOTS: u32 = 5;

fn unpack(compressed: &Path, to: &Path) -> io::Result<()> {
    let status = Command::new("xz")
        .args([OsStr::new("-dc"), compressed.as_os_str()])
        .stdout(File::create(to)?)
        .status()?;
    if !status.success() {
        return Err(io::Error::other(format!("xz: {status}")));
    }
    std::fs::set_permissions(to, std::fs::Permissions::from_mode(0o755))
}

/// An initramfs with the program, the libraries it is linked to, and the directories it needs.
fn archive_of(program: &Path) -> io::Result<Vec<u8>> {
    let mut archive = Archive::default();
    let mut directories = vec![PathBuf::from("/")];
    for directory in ["/dev", "/proc", "/sys", "/tmp"] {
        archive.directory(directory);
        directories.push(directory.into());
    }
    // The kernel connects the standard streams of /init to it.
    archive.character_device("/dev/console", 5, 1);
    archive.executable("/init", &std::fs::read(program)?);
    for library in libraries_of(program)? {
        add_parents(&mut archive, &mut directories, &library);
        let path = library.to_string_lossy().into_owned();
        archive.executable(&path, &std::fs::read(&library)?);
    }
    Ok(archive.finish())
}

fn add_parents(archive: &mut Archive, known: &mut Vec<PathBuf>, file: &Path) {
    let mut parents: Vec<&Path> = file.ancestors().skip(1).collect();
    parents.reverse();
    for parent in parents {
        if !known.iter().any(|path| path == parent) {
            archive.directory(&parent.to_string_lossy());
            known.push(parent.into());
        }
    }
}

/// The dynamic loader and every library, by the loader's own account.
fn libraries_of(program: &Path) -> io::Result<Vec<PathBuf>> {
    const LOADER: &str = "/lib64/ld-linux-x86-64.so.2";
    let listing = Command::new(LOADER).arg("--list").arg(program).output()?;
    if !listing.status.success() {
        return Err(io::Error::other(String::from_utf8_lossy(&listing.stderr).into_owned()));
    }
    let mut libraries = vec![PathBuf::from(LOADER)];
    for line in String::from_utf8_lossy(&listing.stdout).lines() {
        // "libc.so.6 => /lib/x86_64-linux-gnu/libc.so.6 (0x…)"
        let path = line.split_once("=> ").and_then(|(_, rest)| rest.split(' ').next());
        libraries.extend(path.map(PathBuf::from).filter(|path| path != Path::new(LOADER)));
    }
    Ok(libraries)
}

/// Without what the kernel says of each of the 63 consoles it does not have.
fn without_noise(console: &str) -> String {
    let is_noise = |line: &&str| {
        line.starts_with("Using a channel type") || line.starts_with("setup_one_line failed")
    };
    console
        .lines()
        .filter(|line| !is_noise(line))
        .fold(String::new(), |all, line| all + line + "\n")
}

/// A kernel that runs; dropping it kills every process of it.
struct Running {
    child: Child,
    console: Option<std::thread::JoinHandle<String>>,
    ended: bool,
}

impl Running {
    fn start(kernel: &Path, initramfs: &Path, directory: &Path) -> io::Result<Self> {
        let mut child = Command::new(kernel)
            .args(["mem=192M", "con=null", "con0=fd:0,fd:1", "quiet", "panic=-1"])
            .arg(format!("initrd={}", initramfs.display()))
            .arg(format!("uml_dir={}/", directory.display()))
            .env("TMPDIR", directory)
            .env("HOME", directory)
            .current_dir(directory)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            // A group of its own, to be killed as one.
            .process_group(0)
            .spawn()?;
        let mut stdout = child.stdout.take().ok_or_else(|| io::Error::other("no stdout"))?;
        let console = std::thread::spawn(move || {
            let mut bytes = Vec::new();
            // What came before an error is still worth showing.
            let _ = stdout.read_to_end(&mut bytes);
            String::from_utf8_lossy(&bytes).into_owned()
        });
        Ok(Self { child, console: Some(console), ended: false })
    }

    fn wait(&mut self, limit: Duration) -> io::Result<Output> {
        let started = Instant::now();
        let mut timed_out = false;
        while !self.has_ended()? {
            timed_out = started.elapsed() > limit;
            if timed_out {
                break;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        self.kill();
        let console = self.console.take().and_then(|thread| thread.join().ok());
        Ok(Output { console: without_noise(&console.unwrap_or_default()), timed_out })
    }

    /// Whether the kernel is a zombie. It stays one until `kill`, so that the number of its group
    /// cannot pass to another process.
    fn has_ended(&self) -> io::Result<bool> {
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        let pid = Pid::from_child(&self.child);
        Ok(rustix::process::waitid(WaitId::Pid(pid), options)?.is_some())
    }

    /// Kills the group; user-mode Linux runs each guest process as a child in it.
    fn kill(&mut self) {
        if self.ended {
            return;
        }
        self.ended = true;
        // A group without members is no error here.
        let _ = rustix::process::kill_process_group(Pid::from_child(&self.child), Signal::KILL);
        let _ = self.child.wait();
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.kill();
    }
}
