//! The place in shared memory, and the streams one opens there.

use std::env;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::sync::{Arc, Mutex, PoisonError};

use iceoryx2::node::Node;
use iceoryx2::prelude::ipc;
use lodestone_schema::transport::{Availability, Domain, DomainError, cameras};
use lodestone_schema::{DEFAULT_PREFIX, DEFAULT_ROOT, ServiceKind, WORLD_NAME, is_camera_name};
use rustix::fs::{Access, access};
use rustix::io::Errno;

use crate::aiding::AidingPublisher;
use crate::cloud::{CloudPublisher, CloudStream, PublishError};
use crate::error::{CameraNameError, ConnectError};
use crate::merge::CloudMergerBuilder;
use crate::pose_stream::{PoseStream, PoseStreamBuilder};
use crate::relative::RelativeStream;
use crate::stream::{HealthStream, SampleStream, Stream, WorldStream};
use crate::transforms::TransformStream;

/// Environment variable that names the domain's prefix.
pub const PREFIX_VARIABLE: &str = "LODESTONE_SHM_PREFIX";
/// Environment variable that names the domain's root directory.
pub const ROOT_VARIABLE: &str = "LODESTONE_SHM_ROOT";

/// Opens streams in one domain of shared memory.
///
/// Needs no running daemon: streams connect when there is something to connect to. A client
/// leaves nothing in a domain that no daemon has made.
///
/// ```no_run
/// use std::time::Duration;
/// use lodestone_client::Client;
///
/// let client = Client::connect()?;
/// for found in client.cameras()? {
///     println!("{} (schema version {})", found.camera, found.version);
/// }
/// let mut front = client.poses("front")?;
/// let pose = front.wait(Duration::from_secs(1))?;
/// println!("{:?}", pose.position_m());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Client {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    domain: Domain,
    name: String,
    node: Mutex<Option<Arc<Node<ipc::Service>>>>,
}

/// Says which domain to use.
///
/// ```
/// use lodestone_client::Client;
///
/// let client = Client::builder().prefix("doctest_").root("/dev/shm/lodestone_doctest/").connect()?;
/// // Nobody publishes there, which is an error to handle, not a reason to stop.
/// assert!(client.poses("front")?.latest().is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ClientBuilder {
    domain: Domain,
    name: String,
}

impl Default for ClientBuilder {
    fn default() -> Self {
        let or = |variable, default: &str| env::var(variable).unwrap_or_else(|_| default.into());
        let domain = Domain {
            prefix: or(PREFIX_VARIABLE, DEFAULT_PREFIX),
            root: or(ROOT_VARIABLE, DEFAULT_ROOT),
        };
        Self { domain, name: "lodestone-client".into() }
    }
}

impl ClientBuilder {
    /// First part of the name of every file in `/dev/shm`; default [`PREFIX_VARIABLE`], else
    /// `lodestone_`.
    #[must_use]
    pub fn prefix(mut self, prefix: impl Into<String>) -> Self {
        self.domain.prefix = prefix.into();
        self
    }

    /// Directory of the service files, absolute; default [`ROOT_VARIABLE`], else
    /// `/dev/shm/lodestone/`.
    #[must_use]
    pub fn root(mut self, root: impl Into<String>) -> Self {
        self.domain.root = root.into();
        self
    }

    /// Name under which tools list this process; default `lodestone-client`.
    #[must_use]
    pub fn name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Makes the client; a process uses one domain only.
    ///
    /// # Errors
    /// [`DomainError`] if prefix or root cannot be used, or the process is in another domain.
    pub fn connect(self) -> Result<Client, DomainError> {
        self.domain.enter()?;
        let shared = Shared { domain: self.domain, name: self.name, node: Mutex::new(None) };
        Ok(Client { shared: Arc::new(shared) })
    }
}

impl Client {
    /// A client of the default domain; see [`ClientBuilder`].
    ///
    /// # Errors
    /// As [`ClientBuilder::connect`].
    pub fn connect() -> Result<Self, DomainError> {
        Self::builder().connect()
    }

    /// Says which domain to use.
    pub fn builder() -> ClientBuilder {
        ClientBuilder::default()
    }

    /// The domain in use.
    pub fn domain(&self) -> &Domain {
        &self.shared.domain
    }

    /// The cameras that have a pose service, in any schema version.
    ///
    /// The files of a daemon that was killed stay until the next one starts, so a camera listed
    /// here need not be alive.
    ///
    /// # Errors
    /// [`ConnectError`] if there is no domain or it cannot be entered.
    pub fn cameras(&self) -> Result<Vec<Availability>, ConnectError> {
        Ok(cameras(&*self.node()?, ServiceKind::Pose))
    }

    /// The cameras that have a cloud service, in any schema version; as [`Client::cameras`].
    ///
    /// # Errors
    /// [`ConnectError`] if there is no domain or it cannot be entered.
    pub fn cameras_with_clouds(&self) -> Result<Vec<Availability>, ConnectError> {
        Ok(cameras(&*self.node()?, ServiceKind::Cloud))
    }

    /// The poses of a camera, with default settings.
    ///
    /// # Errors
    /// [`CameraNameError`].
    pub fn poses(&self, camera: &str) -> Result<PoseStream, CameraNameError> {
        Ok(self.pose_stream(camera)?.open())
    }

    /// The poses of a camera, with settings.
    ///
    /// # Errors
    /// [`CameraNameError`].
    pub fn pose_stream(&self, camera: &str) -> Result<PoseStreamBuilder, CameraNameError> {
        checked(camera).map(|camera| PoseStreamBuilder::new(self.clone(), camera))
    }

    /// The health of a camera's lane, about once a second.
    ///
    /// # Errors
    /// [`CameraNameError`].
    pub fn health(&self, camera: &str) -> Result<HealthStream, CameraNameError> {
        checked(camera).map(|camera| Stream::new(self.clone(), camera))
    }

    /// The calibrated sensor samples of a camera.
    ///
    /// # Errors
    /// [`CameraNameError`].
    pub fn samples(&self, camera: &str) -> Result<SampleStream, CameraNameError> {
        checked(camera).map(|camera| Stream::new(self.clone(), camera))
    }

    /// A way to tell a camera's lane what this process measures of its motion.
    ///
    /// # Errors
    /// [`CameraNameError`].
    pub fn aiding(&self, camera: &str) -> Result<AidingPublisher, CameraNameError> {
        Ok(AidingPublisher::new(self.clone(), self.poses(camera)?))
    }

    /// The clouds that a depth source sees with a camera.
    ///
    /// # Errors
    /// [`CameraNameError`].
    pub fn clouds(&self, camera: &str) -> Result<CloudStream, CameraNameError> {
        checked(camera).map(|camera| CloudStream::new(self.clone(), camera))
    }

    /// A way to publish clouds seen with a camera, of at most so many points each.
    ///
    /// # Errors
    /// [`PublishError::Name`], [`PublishError::NoPoints`].
    pub fn cloud_publisher(
        &self,
        camera: &str,
        most_points: usize,
    ) -> Result<CloudPublisher, PublishError> {
        CloudPublisher::new(self.clone(), checked(camera)?, most_points)
    }

    /// A way to merge clouds of several cameras into one map.
    pub fn merger(&self) -> CloudMergerBuilder {
        CloudMergerBuilder::new(self.clone())
    }

    /// The world that all cameras share, about once a second and when it changes.
    pub fn world(&self) -> WorldStream {
        Stream::new(self.clone(), WORLD_NAME.into())
    }

    /// The relative pose of two cameras: b in the body axes of a, some ten times a second.
    ///
    /// # Errors
    /// [`CameraNameError`].
    pub fn relative(&self, a: &str, b: &str) -> Result<RelativeStream, CameraNameError> {
        Ok(RelativeStream::new(self.clone(), Some((checked(a)?, checked(b)?))))
    }

    /// The relative poses of all pairs of cameras.
    pub fn relatives(&self) -> RelativeStream {
        RelativeStream::new(self.clone(), None)
    }

    /// The tree of frames.
    pub fn transforms(&self) -> TransformStream {
        TransformStream::new(self.clone())
    }

    /// The node of this process, made once there is a domain to make it in.
    pub(crate) fn node(&self) -> Result<Arc<Node<ipc::Service>>, ConnectError> {
        let mut node = self.shared.node.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(node) = node.as_ref() {
            return Ok(Arc::clone(node));
        }
        let domain = self.domain();
        self.check_root()?;
        let made = Arc::new(domain.open_node(&self.shared.name)?);
        *node = Some(Arc::clone(&made));
        Ok(made)
    }

    /// Whether the domain is there and open to this user.
    ///
    /// Without this, a node would create the directory as this user's and shut the daemon out of
    /// it; and the transport does not tell missing rights from other failures.
    fn check_root(&self) -> Result<(), ConnectError> {
        let root = &self.domain().root;
        let Ok(metadata) = fs::metadata(root) else { return Err(self.no_daemon()) };
        match access(root.as_str(), Access::READ_OK | Access::WRITE_OK | Access::EXEC_OK) {
            Err(Errno::ACCESS | Errno::ROFS | Errno::PERM) => {
                Err(ConnectError::OtherUser { root: root.clone(), owner: metadata.uid() })
            }
            // Anything else shows when the node is made.
            _ => Ok(()),
        }
    }

    fn no_daemon(&self) -> ConnectError {
        let Domain { prefix, root } = self.domain().clone();
        ConnectError::NoDaemon { prefix, root }
    }
}

fn checked(camera: &str) -> Result<String, CameraNameError> {
    if is_camera_name(camera) { Ok(camera.into()) } else { Err(CameraNameError(camera.into())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_client_may_be_shared_between_threads() {
        const fn shareable<T: Send + Sync>() {}
        shareable::<Client>();
    }

    #[test]
    fn a_name_that_cannot_be_a_camera_is_refused() {
        assert!(checked("front-left_2").is_ok());
        assert_eq!(checked("../front"), Err(CameraNameError("../front".into())));
    }
}
