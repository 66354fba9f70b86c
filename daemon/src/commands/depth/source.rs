//! One camera's depth source: truth in, clouds out.

use std::thread;
use std::time::{Duration, Instant};

use lodestone_client::{
    Body, Client, CloudFields, CloudPublisher, LookupError, LookupLimits, PoseStream, PublishError,
    Time, Transform, World, monotonic_now_ns,
};
use tracing::{info, warn};

use super::DepthError;
use super::schedule::Schedule;
use super::tally::Tally;
use crate::scene::{DepthCamera, Frame, Scene};
use crate::service::signals::StopFlag;

/// True poses kept: some seconds at 100 Hz.
const TRUTH_KEPT: usize = 512;
/// The truth is told this often, and some time after: so long is waited for that of a frame.
const TRUTH_DELAY_NS: i64 = 100_000_000;
/// Between two looks for the truth of a frame.
const NAP: Duration = Duration::from_millis(2);
/// Longest sleep: so soon a stop is seen.
const LONGEST_NAP: Duration = Duration::from_millis(50);
/// Silence of the truth after which that is said.
const SILENCE: Duration = Duration::from_secs(1);
/// Between two lines that say how it goes.
const REPORT_EVERY: Duration = Duration::from_secs(10);

/// A depth source at work; stays on its thread.
pub(super) struct Source {
    name: String,
    camera: DepthCamera,
    truth: PoseStream,
    publisher: CloudPublisher,
    tally: Tally,
    /// What was told last.
    reported: (Instant, Tally),
    /// Since when there is no truth, and whether that was said.
    silent: Option<(Instant, bool)>,
    has_been_outside: bool,
    was_refused: bool,
}

/// How a frame came out.
enum Exposed {
    Published,
    /// Its truth never came.
    WithoutTruth,
    Refused(PublishError),
}

impl Source {
    /// Opens the services, which need not exist yet.
    pub(super) fn open(
        client: &Client,
        name: String,
        camera: DepthCamera,
    ) -> Result<Self, DepthError> {
        // A guess ahead is no truth.
        let limits = LookupLimits { prediction: Duration::ZERO, ..LookupLimits::default() };
        let truth = client.pose_stream(&name)?.truth().capacity(TRUTH_KEPT).limits(limits).open();
        let publisher = client.cloud_publisher(&name, camera.points())?;
        let settings = camera.settings();
        info!(
            "{name}: {} x {} points at {} Hz, {}° wide",
            settings.width, settings.height, settings.rate_hz, settings.field_of_view_deg
        );
        let reported = (Instant::now(), Tally::default());
        Ok(Self {
            name,
            camera,
            truth,
            publisher,
            tally: Tally::default(),
            reported,
            silent: Some((Instant::now(), false)),
            has_been_outside: false,
            was_refused: false,
        })
    }

    /// Publishes until it is told to stop.
    pub(super) fn serve(mut self, scene: &Scene, stop: &StopFlag) -> Tally {
        let mut schedule = Schedule::new(monotonic_now_ns(), self.camera.settings().rate_hz);
        while !stop.is_raised() {
            let ready_ns = schedule.time_ns() + self.camera.shutter_ns();
            if !sleep_until(ready_ns, stop) {
                break;
            }
            let frame = Frame { number: schedule.number(), time_ns: schedule.time_ns() };
            let patience_ns = self.camera.shutter_ns() + TRUTH_DELAY_NS + schedule.period_ns();
            if self.await_truth(ready_ns, frame.time_ns + patience_ns, stop) {
                let exposed = self.expose(scene, frame);
                self.count(exposed);
            } else if !stop.is_raised() {
                self.count(Exposed::WithoutTruth);
            }
            schedule.advance(monotonic_now_ns(), patience_ns);
            self.tally.missed = schedule.missed();
            self.report();
        }
        self.tally
    }

    /// Waits until the truth is told up to a time; `false` if it was not by the deadline.
    fn await_truth(&mut self, until_ns: i64, deadline_ns: i64, stop: &StopFlag) -> bool {
        loop {
            let told = self.truth.latest().is_ok_and(|pose| pose.time_ns() >= until_ns);
            if told || stop.is_raised() || monotonic_now_ns() > deadline_ns {
                return told;
            }
            thread::sleep(NAP);
        }
    }

    fn expose(&mut self, scene: &Scene, frame: Frame) -> Exposed {
        let (camera, truth) = (&self.camera, &mut self.truth);
        let begin = Instant::now();
        let settings = camera.settings();
        let mut loan = match self.publisher.loan(settings.width as u32, settings.height as u32) {
            Ok(loan) => loan,
            Err(error) => return Exposed::Refused(error),
        };
        let mut outside = false;
        let place_at = |time_ns| {
            let place = place(truth, time_ns)?;
            outside |= !scene.holds(place.origin());
            Ok::<_, LookupError>(place)
        };
        if camera.expose(scene, frame, place_at, loan.points_mut()).is_err() {
            return Exposed::WithoutTruth;
        }
        let fields = match camera.shutter_ns() {
            0 => CloudFields::COLOUR,
            _ => CloudFields::COLOUR | CloudFields::POINT_TIME,
        };
        let sigma_per_m = settings.sigma_per_m as f32;
        let sent = loan.with_fields(fields).with_depth_sigma_per_m(sigma_per_m).send(frame.time_ns);
        self.tally.busy += begin.elapsed();
        if outside && !std::mem::replace(&mut self.has_been_outside, true) {
            warn!("{}: the camera is outside of the room, from where nothing is seen", self.name);
        }
        sent.map_or_else(Exposed::Refused, |_| Exposed::Published)
    }

    fn count(&mut self, exposed: Exposed) {
        match exposed {
            Exposed::Published => {
                self.tally.published += 1;
                self.was_refused = false;
                if let Some((since, _)) = self.silent.take() {
                    let waited_s = since.elapsed().as_secs_f64();
                    info!("{}: the camera's truth is there, after {waited_s:.1} s", self.name);
                }
            }
            Exposed::Refused(error) => {
                self.tally.refused += 1;
                if !std::mem::replace(&mut self.was_refused, true) {
                    warn!("{}: {error}; tried again with each cloud", self.name);
                }
            }
            Exposed::WithoutTruth => {
                // Before the daemon has begun, nothing is lost.
                self.tally.without_truth += u64::from(self.tally.published > 0);
                self.say_silent();
            }
        }
    }

    /// Says once that the truth does not come, and what may be the reason.
    fn say_silent(&mut self) {
        let (since, was_said) = self.silent.get_or_insert((Instant::now(), false));
        if *was_said || since.elapsed() < SILENCE {
            return;
        }
        *was_said = true;
        let reason = match self.truth.connection_error() {
            Some(error) => error.to_string(),
            None => "it is silent".into(),
        };
        warn!("{}: waiting for the camera's truth: {reason}", self.name);
    }

    fn report(&mut self) {
        let (at, before) = self.reported;
        let span = at.elapsed();
        if span >= REPORT_EVERY {
            let lately = self.tally.since(&before);
            let rate_hz = lately.published as f64 / span.as_secs_f64();
            info!("{}: {lately}; {rate_hz:.1} Hz", self.name);
            self.reported = (Instant::now(), self.tally);
        }
    }
}

/// Where the body truly was.
fn place(truth: &mut PoseStream, time_ns: i64) -> Result<Transform<World, Body>, LookupError> {
    Ok(truth.lookup(Time::Monotonic(time_ns))?.world_from_body()?)
}

/// Sleeps until a time, `CLOCK_MONOTONIC`, ns; `false` if it was told to stop.
fn sleep_until(time_ns: i64, stop: &StopFlag) -> bool {
    while !stop.is_raised() {
        let left_ns = time_ns - monotonic_now_ns();
        if left_ns <= 0 {
            return true;
        }
        thread::sleep(Duration::from_nanos(left_ns.unsigned_abs()).min(LONGEST_NAP));
    }
    false
}
