//! How both ends open the services: names, versions, qualities of service and iceoryx2's settings.
//!
//! ```no_run
//! use lodestone_schema::transport::{Domain, open_for_reading};
//! use lodestone_schema::{Pose, ServiceKind};
//!
//! let node = Domain::default().open_node("my-consumer")?;
//! let service = open_for_reading::<Pose>(&node, ServiceKind::Pose, "front")?;
//! let subscriber = service.subscriber_builder().create()?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
mod cloud;
mod domain;
mod open;

pub use cloud::{
    CLOUD_BORROWED, CLOUD_BUFFER, CLOUD_SUBSCRIBERS, Clouds, open_clouds_for_reading,
    open_clouds_for_writing,
};
pub use domain::{Domain, DomainError, LOCK_FILE};
pub use open::{
    Availability, Events, OpenError, PublishSubscribe, Qos, cameras, open_event_for_reading,
    open_event_for_writing, open_for_reading, open_for_writing,
};
