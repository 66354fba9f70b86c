//! How a command fails.

use std::io;
use std::process::ExitCode;

use lodestone_client::{
    CameraNameError, ConnectError, DomainError, ExportError, LookupError, MergeError, StreamError,
};

/// Why a command ends without what was asked for.
#[derive(Debug, thiserror::Error)]
pub(super) enum Failure {
    /// Wrong usage.
    #[error("{0}")]
    Usage(String),
    /// Whoever read the output is gone (`lodestone echo | head`): no reason to complain.
    #[error("nobody reads the output")]
    NobodyReads,
    /// The output cannot be written.
    #[error("cannot write: {0}")]
    Output(io::Error),
    /// Signals cannot be handled.
    #[error("cannot handle signals: {0}")]
    Signals(io::Error),
    /// Anything that is wrong on the other side.
    #[error("{0}")]
    Other(String),
}

impl Failure {
    pub(super) fn exit_code(&self) -> ExitCode {
        match self {
            Self::Usage(_) => ExitCode::from(2),
            _ => ExitCode::FAILURE,
        }
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::NobodyReads,
            _ => Self::Output(error),
        }
    }
}

impl From<DomainError> for Failure {
    fn from(error: DomainError) -> Self {
        match error {
            DomainError::Prefix(_) => Self::Usage(format!("--prefix: {error}")),
            DomainError::Root(_) => Self::Usage(format!("--root: {error}")),
            other => Self::Other(other.to_string()),
        }
    }
}

impl From<CameraNameError> for Failure {
    fn from(error: CameraNameError) -> Self {
        Self::Usage(format!("--camera: {error}"))
    }
}

impl From<MergeError> for Failure {
    fn from(error: MergeError) -> Self {
        Self::Usage(error.to_string())
    }
}

impl From<ExportError> for Failure {
    fn from(error: ExportError) -> Self {
        Self::Other(error.to_string())
    }
}

impl From<ConnectError> for Failure {
    fn from(error: ConnectError) -> Self {
        Self::Other(error.to_string())
    }
}

impl From<StreamError> for Failure {
    fn from(error: StreamError) -> Self {
        Self::Other(error.to_string())
    }
}

impl From<LookupError> for Failure {
    fn from(error: LookupError) -> Self {
        Self::Other(error.to_string())
    }
}
