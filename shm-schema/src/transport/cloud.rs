//! Opening the service of a camera's clouds: slices of points with a header.

use iceoryx2::node::Node;
use iceoryx2::prelude::ipc;
use iceoryx2::service::port_factory::publish_subscribe;

use super::open::{
    OpenError, explain, is_in_flux, open_or_create, our_version, retry, service_name,
};
use crate::{CloudHeader, CloudPoint, ServiceKind};

/// An opened service of clouds.
pub type Clouds = publish_subscribe::PortFactory<ipc::Service, [CloudPoint], CloudHeader>;

/// Clouds that wait for one consumer; a slow one loses the oldest.
///
/// Some megabytes each, so few: a consumer that is behind by more than these wants the newest.
pub const CLOUD_BUFFER: usize = 4;
/// Clouds that one consumer may hold at a time.
pub const CLOUD_BORROWED: usize = 2;
/// Most consumers of one camera's clouds at a time.
pub const CLOUD_SUBSCRIBERS: usize = 8;
/// Two, so that a bridge can mirror the service from another host.
const CLOUD_PUBLISHERS: usize = 2;

/// Opens or creates the service of a camera's clouds in order to publish.
///
/// # Errors
/// [`OpenError`]; a service that is just being made or removed is waited for, at most 0.2 s.
pub fn open_clouds_for_writing(
    node: &Node<ipc::Service>,
    camera: &str,
) -> Result<Clouds, OpenError> {
    let name = service_name(ServiceKind::Cloud, camera)?;
    let open = || {
        node.service_builder(&name)
            .publish_subscribe::<[CloudPoint]>()
            .user_header::<CloudHeader>()
            .enable_safe_overflow(true)
            .history_size(0)
            .subscriber_max_buffer_size(CLOUD_BUFFER)
            .subscriber_max_borrowed_samples(CLOUD_BORROWED)
            .max_subscribers(CLOUD_SUBSCRIBERS)
            .max_publishers(CLOUD_PUBLISHERS)
            .max_nodes(CLOUD_SUBSCRIBERS + CLOUD_PUBLISHERS + 2)
            .open_or_create_with_attributes(&our_version())
    };
    open_or_create(node, ServiceKind::Cloud, camera, open)
}

/// Opens the service of a camera's clouds in order to subscribe.
///
/// # Errors
/// [`OpenError`]; a service that is just being made or removed is waited for, at most 0.2 s.
pub fn open_clouds_for_reading(
    node: &Node<ipc::Service>,
    camera: &str,
) -> Result<Clouds, OpenError> {
    let name = service_name(ServiceKind::Cloud, camera)?;
    let open = || {
        node.service_builder(&name)
            .publish_subscribe::<[CloudPoint]>()
            .user_header::<CloudHeader>()
            .open_with_attributes(&our_version())
    };
    retry(open, |e| is_in_flux(*e)).map_err(|e| explain(node, ServiceKind::Cloud, camera, e))
}
