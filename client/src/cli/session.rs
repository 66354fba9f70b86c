//! The domain a command works in, and the cameras found there.

use std::time::{Duration, Instant};

use lodestone_client::{Client, OpenError};
use lodestone_schema::SCHEMA_VERSION;

use super::args::Common;
use super::failure::Failure;
use super::stop::Stop;

const BETWEEN_LOOKS: Duration = Duration::from_millis(100);

/// What every command works with.
pub(super) struct Session {
    pub(super) client: Client,
    pub(super) json: bool,
    pub(super) stop: Stop,
    wait: Duration,
}

impl Session {
    pub(super) fn new(common: &Common, stop: Stop) -> Result<Self, Failure> {
        let mut builder = Client::builder().name("lodestone");
        if let Some(prefix) = &common.prefix {
            builder = builder.prefix(prefix);
        }
        if let Some(root) = &common.root {
            builder = builder.root(root);
        }
        Ok(Self { client: builder.connect()?, json: common.json, stop, wait: common.wait })
    }

    /// The cameras of the daemon, waited for as long as the user allows.
    pub(super) fn cameras(&self) -> Result<Vec<String>, Failure> {
        self.until_found(|| self.cameras_now())
    }

    /// The cameras that have clouds, waited for as long as the user allows; those asked for, or all.
    pub(super) fn cameras_with_clouds(&self, asked: &[String]) -> Result<Vec<String>, Failure> {
        for camera in asked {
            // A wrong name is wrong usage, whatever runs.
            self.client.clouds(camera)?;
        }
        self.until_found(|| {
            let there = self.clouds_now()?;
            match asked.iter().find(|camera| !there.contains(camera)) {
                Some(missing) => Err(Failure::Other(format!(
                    "no clouds of camera {missing:?}; there are those of: {}",
                    there.join(", ")
                ))),
                None if asked.is_empty() => Ok(there),
                None => Ok(asked.to_vec()),
            }
        })
    }

    /// The cameras with clouds at this moment; never an empty list.
    fn clouds_now(&self) -> Result<Vec<String>, Failure> {
        let found = self.client.cameras_with_clouds()?;
        let ours = found.into_iter().filter(|f| f.version == SCHEMA_VERSION).map(|f| f.camera);
        let ours: Vec<String> = ours.filter(|camera| self.client.clouds(camera).is_ok()).collect();
        let domain = self.client.domain();
        if ours.is_empty() {
            return Err(Failure::Other(format!(
                "no camera has clouds in domain prefix {:?}, root {:?}: start a depth source (lodestoned depth --camera NAME, or your own)",
                domain.prefix, domain.root
            )));
        }
        Ok(ours)
    }

    /// The camera asked for, or the only one there is.
    pub(super) fn camera(&self, asked: Option<&str>) -> Result<String, Failure> {
        let Some(asked) = asked else { return self.only_camera() };
        // A wrong name is wrong usage, whatever runs.
        self.client.poses(asked)?;
        self.until_found(|| {
            let there = self.cameras_now()?;
            if there.iter().any(|camera| camera == asked) {
                return Ok(asked.to_owned());
            }
            Err(Failure::Other(format!("no camera {asked:?}; there are: {}", there.join(", "))))
        })
    }

    fn only_camera(&self) -> Result<String, Failure> {
        let mut cameras = self.cameras()?;
        match (cameras.pop(), cameras.is_empty()) {
            (Some(camera), true) => Ok(camera),
            (last, _) => {
                cameras.extend(last);
                Err(Failure::Usage(format!(
                    "--camera NAME is needed; there are: {}",
                    cameras.join(", ")
                )))
            }
        }
    }

    /// The cameras at this moment; never an empty list.
    pub(super) fn cameras_now(&self) -> Result<Vec<String>, Failure> {
        let found = self.client.cameras()?;
        let ours: Vec<String> = found
            .iter()
            .filter(|f| f.version == SCHEMA_VERSION && self.client.poses(&f.camera).is_ok())
            .map(|f| f.camera.clone())
            .collect();
        match found.into_iter().next() {
            _ if !ours.is_empty() => Ok(ours),
            Some(other) => {
                let (camera, found) = (other.camera, other.version);
                Err(Failure::Other(OpenError::OtherVersion { camera, found }.to_string()))
            }
            None => Err(self.nobody()),
        }
    }

    /// There is a domain, but nobody publishes in it.
    pub(super) fn nobody(&self) -> Failure {
        let domain = self.client.domain();
        Failure::Other(format!(
            "no daemon in domain prefix {:?}, root {:?}: start lodestoned, or name the domain it uses",
            domain.prefix, domain.root
        ))
    }

    fn until_found<T>(&self, look: impl Fn() -> Result<T, Failure>) -> Result<T, Failure> {
        let begin = Instant::now();
        loop {
            match look() {
                Err(Failure::Other(_)) if begin.elapsed() < self.wait => {}
                done => return done,
            }
            if !self.stop.sleep_until(Instant::now() + BETWEEN_LOOKS) {
                return Err(Failure::Other("stopped while waiting for a daemon".into()));
            }
        }
    }
}
