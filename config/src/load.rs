//! Files: reading them, and finding those that a configuration names.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use crate::calibration::Calibration;
use crate::error::LoadError;
use crate::kept_world::KeptWorld;
use crate::model::{Camera, Config};

/// Largest file that is read, bytes. A configuration of many cameras has some ten thousand.
pub const MAX_FILE_BYTES: u64 = 1 << 20;

/// A configuration and where it came from.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded {
    /// The configuration, checked.
    pub config: Config,
    /// The file as it was named.
    pub path: PathBuf,
}

impl Config {
    /// Loads a configuration from a file.
    ///
    /// # Errors
    ///
    /// The file cannot be read, or something in it is wrong.
    pub fn load(path: impl AsRef<Path>) -> Result<Loaded, LoadError> {
        let path = path.as_ref();
        let config = Self::from_toml(&path.display().to_string(), &read_text(path)?)?;
        Ok(Loaded { config, path: path.into() })
    }
}

impl Loaded {
    /// The path of a file that the configuration names relative to its own directory.
    pub fn resolve(&self, named: impl AsRef<Path>) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(named)
    }

    /// Loads a camera's calibration; `None` if the configuration names none.
    ///
    /// # Errors
    ///
    /// The file cannot be read, something in it is wrong, or it belongs to another camera.
    pub fn calibration(&self, camera: &Camera) -> Result<Option<Calibration>, LoadError> {
        let named = camera.calibration.as_ref();
        named.map(|file| Calibration::load(self.resolve(file), camera.serial)).transpose()
    }

    /// Loads the calibrations of all cameras, in their order; `None` where none is named.
    ///
    /// # Errors
    ///
    /// Everything that is wrong with any of the files, at least one error.
    pub fn calibrations(&self) -> Result<Vec<Option<Calibration>>, Vec<LoadError>> {
        let (mut calibrations, mut errors) = (Vec::new(), Vec::new());
        for camera in &self.config.camera {
            match self.calibration(camera) {
                Ok(calibration) => calibrations.push(calibration),
                Err(error) => errors.push(error),
            }
        }
        if errors.is_empty() { Ok(calibrations) } else { Err(errors) }
    }

    /// The path of the file that keeps the world; `None` if none is configured.
    pub fn kept_world_path(&self) -> Option<PathBuf> {
        self.config.world.keep.as_ref().map(|file| self.resolve(file))
    }

    /// Loads the kept world; `None` if none is configured or none was kept yet.
    ///
    /// # Errors
    ///
    /// As [`KeptWorld::load`].
    pub fn kept_world(&self) -> Result<Option<KeptWorld>, LoadError> {
        let path = self.kept_world_path();
        path.map_or(Ok(None), |path| KeptWorld::load(path, self.config.world.north))
    }

    /// The path of a camera's recording; `None` if it replays none.
    pub fn recording(&self, camera: &Camera) -> Option<PathBuf> {
        camera.replay.as_ref().map(|replay| self.resolve(&replay.file))
    }
}

/// Reads a file of text that is not too large.
pub(crate) fn read_text(path: &Path) -> Result<String, LoadError> {
    let bytes = read_bytes(path).map_err(|source| match source.kind() {
        io::ErrorKind::NotFound => LoadError::NotFound { path: path.into() },
        _ => LoadError::Unreadable { path: path.into(), source },
    })?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(LoadError::TooLarge { path: path.into(), limit: MAX_FILE_BYTES });
    }
    String::from_utf8(bytes).map_err(|error| {
        let offset = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..offset].split(|&byte| byte == b'\n').count();
        LoadError::NotUtf8 { path: path.into(), line, offset }
    })
}

/// Reads one byte more than is allowed at most, so that an endless file ends too.
fn read_bytes(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}
