//! What one thread asks for.

use std::num::NonZeroU64;

use lodestone_config::model::{Camera, Config, DriverKind, Policy};
use rustix::process::{Resource, getrlimit};
use rustix::thread::{Pid, set_current_timer_slack};

use super::Refusal;
use super::roster::pin;
use super::scheduling::become_fifo;
use super::stack;

/// What one thread of a lane asks of the kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ThreadSetup {
    /// Priority under `SCHED_FIFO`; none for fair scheduling.
    pub priority: Option<u8>,
    /// Processor to stay on.
    pub cpu: Option<u16>,
    /// Timer slack, ns, from 1.
    pub timer_slack_ns: u32,
    /// Stack to touch, KiB.
    pub prefault_stack_kib: u32,
}

impl ThreadSetup {
    /// For the threads of one camera.
    pub fn of_camera(config: &Config, camera: usize) -> Self {
        let camera = &config.camera[camera];
        Self::new(config, camera.cpu, !never_waits(camera))
    }

    /// For the thread that fuses the cameras of one body.
    pub fn of_body(config: &Config, body: usize, members: &[usize]) -> Self {
        let all_wait = !members.iter().any(|&member| never_waits(&config.camera[member]));
        Self::new(config, config.body[body].cpu, all_wait)
    }

    fn new(config: &Config, cpu: Option<u16>, waits: bool) -> Self {
        let realtime = &config.realtime;
        Self {
            priority: (realtime.policy == Policy::Fifo && waits).then_some(realtime.priority),
            cpu,
            timer_slack_ns: realtime.timer_slack_ns,
            prefault_stack_kib: realtime.prefault_stack_kib,
        }
    }

    /// Asks for all of it, for the calling thread; gives what was refused.
    pub(super) fn apply(&self, thread: Pid) -> Vec<Refusal> {
        stack::prefault(self.prefault_stack_kib);
        let asked = [self.ask_for_slack(), self.ask_for_cpu(thread), self.ask_for_priority()];
        asked.into_iter().filter_map(Result::err).collect()
    }

    fn ask_for_slack(&self) -> Result<(), Refusal> {
        let slack_ns = self.timer_slack_ns;
        set_current_timer_slack(NonZeroU64::new(slack_ns.into()))
            .map_err(|errno| Refusal::TimerSlack { slack_ns, errno })
    }

    fn ask_for_cpu(&self, thread: Pid) -> Result<(), Refusal> {
        self.cpu.map_or(Ok(()), |cpu| pin(thread, cpu))
    }

    fn ask_for_priority(&self) -> Result<(), Refusal> {
        let Some(priority) = self.priority else { return Ok(()) };
        let limit = getrlimit(Resource::Rtprio).current;
        become_fifo(priority).map_err(|errno| Refusal::Scheduling { priority, limit, errno })
    }
}

/// A source at speed 0 has the next sample at once. Before everything else, and without a pause, it
/// would leave nothing for anybody.
fn never_waits(camera: &Camera) -> bool {
    let speed = match camera.driver {
        DriverKind::Zed2 => None,
        DriverKind::Synthetic => camera.synthetic.as_ref().map(|synthetic| synthetic.speed),
        DriverKind::Replay => camera.replay.as_ref().map(|replay| replay.speed),
    };
    speed == Some(0.0)
}

#[cfg(test)]
mod tests {
    use lodestone_config::model::{Realtime, Replay, RigidBody};

    use super::*;

    fn replaying(speed: f64) -> Camera {
        let replay = Some(Replay { speed, ..Replay::default() });
        Camera { driver: DriverKind::Replay, replay, cpu: Some(3), ..Camera::default() }
    }

    #[test]
    fn a_source_that_never_waits_gets_no_priority_and_neither_does_a_rig_with_one() {
        let config = Config {
            realtime: Realtime { policy: Policy::Fifo, ..Realtime::default() },
            body: vec![RigidBody { cpu: Some(1), ..RigidBody::default() }],
            camera: vec![replaying(1.0), replaying(0.0)],
            ..Config::default()
        };
        let of_camera = |camera| ThreadSetup::of_camera(&config, camera);
        assert_eq!((of_camera(0).priority, of_camera(1).priority), (Some(50), None));
        assert_eq!(of_camera(0).cpu, Some(3));
        assert_eq!(ThreadSetup::of_body(&config, 0, &[0, 1]).priority, None);
        let of_body = ThreadSetup::of_body(&config, 0, &[0]);
        assert_eq!((of_body.priority, of_body.cpu), (Some(50), Some(1)));
    }

    #[test]
    fn without_the_policy_nothing_needs_a_right() {
        let config = Config { camera: vec![replaying(1.0)], ..Config::default() };
        assert_eq!(ThreadSetup::of_camera(&config, 0).priority, None);
    }
}
