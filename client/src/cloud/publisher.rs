//! Publishing clouds, for any depth source.

use core::fmt;

use iceoryx2::port::LoanError;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::{AllocationStrategy, ipc};
use iceoryx2::sample_mut::SampleMut;
use lodestone_schema::transport::{
    CLOUD_BORROWED, CLOUD_BUFFER, CLOUD_SUBSCRIBERS, Clouds, open_clouds_for_writing,
};
use lodestone_schema::{CloudFields, CloudFrame, CloudHeader, CloudPoint};

use super::error::PublishError;
use crate::client::Client;
use crate::error::ConnectError;
use crate::time::monotonic_now_ns;

/// Clouds that can be in use at a time: all queues together hold the newest, each consumer may hold some
/// older ones, one is being filled, one was just sent.
///
/// iceoryx2 itself would count each queue's clouds separately, more than twice as many.
const CLOUDS_IN_USE: usize = CLOUD_BUFFER + CLOUD_SUBSCRIBERS * CLOUD_BORROWED + 2;

/// Publishes the clouds of one depth source, under the name of the camera whose pose they go with.
///
/// The daemon has no part in it and need not run. The directory of its services must exist, though, as for
/// every client: where no daemon ever ran, nothing is left behind, and [`CloudPublisher::loan`] fails with
/// [`ConnectError::NoDaemon`]. A source may start first and simply try again with its next cloud.
///
/// A cloud of 100,000 points takes 2 MB, and up to 22 of
/// them can be in use at a time, which is what the source may come to need in `/dev/shm`.
///
/// ```no_run
/// use lodestone_client::{Client, CloudFields, CloudPoint, monotonic_now_ns};
///
/// let mut front = Client::connect()?.cloud_publisher("front", 2)?;
/// let mut cloud = front.loan(2, 1)?;
/// // Optical axes: x right, y down, z forward.
/// cloud.points_mut()[0].position_m = [0.0, 0.0, 2.0];
/// cloud.points_mut()[1].position_m = [0.5, 0.0, 3.0];
/// cloud.send(monotonic_now_ns())?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct CloudPublisher {
    client: Client,
    camera: String,
    most_points: usize,
    port: Option<Port>,
    sequence: u64,
}

struct Port {
    publisher: Publisher<ipc::Service, [CloudPoint], CloudHeader>,
    /// The service stays in existence while this is held.
    _service: Clouds,
}

impl CloudPublisher {
    pub(crate) fn new(
        client: Client,
        camera: String,
        most_points: usize,
    ) -> Result<Self, PublishError> {
        if most_points == 0 {
            return Err(PublishError::NoPoints);
        }
        Ok(Self { client, camera, most_points, port: None, sequence: 0 })
    }

    /// The camera.
    pub fn camera(&self) -> &str {
        &self.camera
    }

    /// Clouds sent so far.
    pub const fn sent(&self) -> u64 {
        self.sequence
    }

    /// A cloud in shared memory to fill in place: `width * height` points, row by row, none of which has
    /// depth yet. `height` is 1 for points in no order.
    ///
    /// # Errors
    /// [`PublishError`].
    pub fn loan(&mut self, width: u32, height: u32) -> Result<CloudLoan<'_>, PublishError> {
        let count = u64::from(width) * u64::from(height);
        let most = self.most_points;
        let count = usize::try_from(count).ok().filter(|count| *count <= most);
        let count = count.ok_or(PublishError::TooManyPoints { width, height, most })?;
        if height == 0 {
            return Err(PublishError::NoPoints);
        }
        let mut sample = self.loan_points(count)?;
        *sample.user_header_mut() = CloudHeader { width, height, ..CloudHeader::default() };
        Ok(CloudLoan { sample, camera: &self.camera, sequence: &mut self.sequence })
    }

    fn loan_points(&mut self, count: usize) -> Result<LoanedSample, PublishError> {
        let port = match &mut self.port {
            Some(port) => port,
            none => none.insert(open(&self.client, &self.camera, self.most_points)?),
        };
        let loaned = port.publisher.loan_slice(count);
        loaned.map_err(|error| {
            // Two loans at a time cannot be; anything else is worth a fresh start.
            if error != LoanError::OutOfMemory {
                self.port = None;
            }
            transport(&self.camera, &error)
        })
    }
}

type LoanedSample = SampleMut<ipc::Service, [CloudPoint], CloudHeader>;

/// A cloud being filled; dropped without [`CloudLoan::send`] it goes back unseen.
pub struct CloudLoan<'a> {
    sample: LoanedSample,
    camera: &'a str,
    sequence: &'a mut u64,
}

impl CloudLoan<'_> {
    /// The points, row by row.
    pub fn points_mut(&mut self) -> &mut [CloudPoint] {
        self.sample.payload_mut()
    }

    /// Says that points hold more than a position; default nothing.
    #[must_use]
    pub fn with_fields(mut self, fields: CloudFields) -> Self {
        self.sample.user_header_mut().fields = fields.bits();
        self
    }

    /// Says in which frame the points are; default [`CloudFrame::Optical`].
    #[must_use]
    pub fn in_frame(mut self, frame: CloudFrame) -> Self {
        self.sample.user_header_mut().frame = frame.code();
        self
    }

    /// Says how the depth's standard deviation grows with its square, 1/m; default not known.
    #[must_use]
    pub fn with_depth_sigma_per_m(mut self, sigma_per_m: f32) -> Self {
        self.sample.user_header_mut().depth_sigma_per_m = sigma_per_m;
        self
    }

    /// Hands the cloud over, seen at a time of `CLOCK_MONOTONIC`, ns; returns how many consumers get it.
    ///
    /// # Errors
    /// [`PublishError::NegativeTime`], [`PublishError::Transport`]; then it goes back unseen.
    pub fn send(mut self, time_ns: i64) -> Result<usize, PublishError> {
        if time_ns < 0 {
            return Err(PublishError::NegativeTime(time_ns));
        }
        let header = self.sample.user_header_mut();
        header.sequence = *self.sequence;
        header.time_ns = time_ns;
        header.published_time_ns = monotonic_now_ns();
        let consumers = self.sample.send().map_err(|error| transport(self.camera, &error))?;
        *self.sequence += 1;
        Ok(consumers)
    }
}

fn transport(camera: &str, error: &impl fmt::Display) -> PublishError {
    PublishError::Transport { camera: camera.into(), what: error.to_string() }
}

fn open(client: &Client, camera: &str, most_points: usize) -> Result<Port, PublishError> {
    let node = client.node()?;
    check_room(camera, most_points)?;
    let service = open_clouds_for_writing(&node, camera).map_err(ConnectError::Open)?;
    let publisher = service
        .publisher_builder()
        .initial_max_slice_len(most_points)
        .allocation_strategy(AllocationStrategy::Static)
        .max_loaned_samples(1)
        .override_sample_preallocation(|worst| worst.min(CLOUDS_IN_USE))
        .create()
        .map_err(|error| transport(camera, &error))?;
    Ok(Port { publisher, _service: service })
}

/// Whether shared memory can take all clouds that may be in use: its files are sparse, and on a full
/// `/dev/shm` the first write to a new page would be a deadly signal instead of an error.
fn check_room(camera: &str, most_points: usize) -> Result<(), PublishError> {
    const MB: u64 = 1_000_000;
    let needed = (most_points as u64)
        .saturating_mul(size_of::<CloudPoint>() as u64)
        .saturating_mul(CLOUDS_IN_USE as u64);
    // Where it cannot be told, the transport will.
    let Ok(space) = rustix::fs::statvfs("/dev/shm") else { return Ok(()) };
    let free = space.f_bavail.saturating_mul(space.f_frsize);
    if needed <= free {
        return Ok(());
    }
    let camera = camera.to_owned();
    Err(PublishError::NoRoom { camera, needed_mb: needed.div_ceil(MB), free_mb: free / MB })
}

impl fmt::Debug for CloudPublisher {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("CloudPublisher")
            .field("camera", &self.camera)
            .field("most_points", &self.most_points)
            .field("connected", &self.port.is_some())
            .field("sent", &self.sequence)
            .finish_non_exhaustive()
    }
}

impl fmt::Debug for CloudLoan<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("CloudLoan").field("header", self.sample.user_header()).finish()
    }
}
