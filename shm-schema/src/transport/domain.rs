//! Where the services lie: iceoryx2's prefix and root directory, and its other settings.

use core::time::Duration;
use std::io::{self, Write};
use std::os::fd::AsRawFd;

use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeBuilder, NodeCreationFailure};
use iceoryx2::prelude::{
    FileName, FilePath, NodeName, Path, SemanticString, SignalHandlingMode, ipc,
};

use crate::{DEFAULT_PREFIX, DEFAULT_ROOT};

/// How long iceoryx2 may wait for a file that another process is still making.
///
/// A publisher waits this long inside `send` for a subscriber whose files it may not open, so the
/// default of one second would stall the lane.
const CREATION_TIMEOUT: Duration = Duration::from_millis(1);

/// Name of the file in a domain's root on which its daemon holds a lock: `pid N` in its first line.
pub const LOCK_FILE: &str = "lodestoned.lock";

/// A place in shared memory: processes meet if they name the same prefix and root.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Domain {
    /// First part of the name of every file in `/dev/shm`.
    pub prefix: String,
    /// Directory of service and node files, absolute.
    pub root: String,
}

/// Why a domain cannot be entered.
#[derive(Debug, thiserror::Error)]
pub enum DomainError {
    /// The prefix is not a file name.
    #[error("prefix {0:?} cannot start a file name; allowed: letters, digits, '_', '-'")]
    Prefix(String),
    /// The root is not a path.
    #[error(
        "root {0:?} is not a directory path iceoryx2 can use; allowed: an absolute path of at most 255 bytes"
    )]
    Root(String),
    /// iceoryx2's settings could not be handed over.
    #[error("cannot hand its settings to iceoryx2: {0}")]
    Settings(String),
    /// The process already uses iceoryx2 with other settings.
    #[error(
        "this process already uses iceoryx2 with prefix {prefix:?} and root {root:?}: enter one domain only, before any other use of iceoryx2"
    )]
    AlreadyElsewhere {
        /// Prefix in use.
        prefix: String,
        /// Root in use.
        root: String,
    },
    /// The node could not be made.
    #[error("cannot join {root}: {source}{}", hint(*.source))]
    Node {
        /// The domain's root.
        root: String,
        /// What iceoryx2 says.
        source: NodeCreationFailure,
    },
}

fn hint(failure: NodeCreationFailure) -> &'static str {
    match failure {
        NodeCreationFailure::InsufficientPermissions => {
            " (the directory belongs to another user: run as that user, or configure another root)"
        }
        // Also what iceoryx2 says of a directory that another user made.
        _ => " (does the directory belong to this user, and is there space in /dev/shm?)",
    }
}

impl Default for Domain {
    fn default() -> Self {
        Self { prefix: DEFAULT_PREFIX.into(), root: DEFAULT_ROOT.into() }
    }
}

impl Domain {
    /// Makes a node in this domain.
    ///
    /// iceoryx2 looks at its process-wide settings when it cleans up after dead processes, so the
    /// first domain a process enters becomes its only one.
    ///
    /// # Errors
    /// [`DomainError`] names the prefix, the root or what the file system refused.
    pub fn open_node(&self, name: &str) -> Result<Node<ipc::Service>, DomainError> {
        let config = self.enter()?;
        let builder = NodeBuilder::new()
            .config(config)
            // The daemon and its consumers handle their own signals.
            .signal_handling_mode(SignalHandlingMode::Disabled);
        let builder = match NodeName::new(name) {
            Ok(name) => builder.name(&name),
            Err(_) => builder,
        };
        builder.create().map_err(|source| DomainError::Node { root: self.root.clone(), source })
    }

    /// Makes this domain the process's iceoryx2 settings and returns them.
    ///
    /// # Errors
    /// As [`Domain::open_node`].
    pub fn enter(&self) -> Result<&'static Config, DomainError> {
        let wanted = self.settings()?;
        let in_force = install(&wanted)?;
        let same = in_force.global.prefix == wanted.global.prefix
            && in_force.global.root_path() == wanted.global.root_path();
        same.then_some(in_force).ok_or_else(|| DomainError::AlreadyElsewhere {
            prefix: in_force.global.prefix.to_string(),
            root: in_force.global.root_path().to_string(),
        })
    }

    fn settings(&self) -> Result<Config, DomainError> {
        let mut config = Config::default();
        config.global.prefix = FileName::new(self.prefix.as_bytes())
            .map_err(|_| DomainError::Prefix(self.prefix.clone()))?;
        let root = Path::new(self.root.as_bytes()).ok().filter(|_| self.root.starts_with('/'));
        let root = root.ok_or_else(|| DomainError::Root(self.root.clone()))?;
        config.global.set_root_path(&root);
        config.global.creation_timeout = CREATION_TIMEOUT;
        Ok(config)
    }
}

/// Hands settings to iceoryx2 through an anonymous file: it takes them from a path only.
fn install(config: &Config) -> Result<&'static Config, DomainError> {
    let text = toml::to_string(config).map_err(|e| DomainError::Settings(e.to_string()))?;
    let file = anonymous_file(&text).map_err(|e| DomainError::Settings(e.to_string()))?;
    let path = format!("/proc/self/fd/{}", file.as_raw_fd());
    let path =
        FilePath::new(path.as_bytes()).map_err(|e| DomainError::Settings(format!("{e:?}")))?;
    Config::setup_global_config_from_file(&path).map_err(|e| DomainError::Settings(e.to_string()))
}

fn anonymous_file(text: &str) -> io::Result<std::fs::File> {
    let descriptor = rustix::fs::memfd_create("iceoryx2.toml", rustix::fs::MemfdFlags::CLOEXEC)?;
    let mut file = std::fs::File::from(descriptor);
    file.write_all(text.as_bytes())?;
    Ok(file)
}
