//! `lodestone watch`.

use std::time::{Duration, Instant};

use super::args::WatchArgs;
use super::failure::Failure;
use super::output::Output;
use super::report::{Monitor, Report};
use super::session::Session;
use super::table::{Screen, lines, plain};

const BETWEEN_DISCOVERIES: Duration = Duration::from_secs(1);

pub(super) fn run(session: &Session, args: &WatchArgs) -> Result<(), Failure> {
    let screen = Screen::of_terminal().filter(|_| !session.json);
    let usual = Duration::from_millis(if screen.is_some() { 200 } else { 1000 });
    let interval = args.interval.unwrap_or(usual).max(Duration::from_millis(10));
    let mut watch = Watch { session, screen, output: Output::new(), monitors: Vec::new() };
    watch.follow(session.cameras()?)?;
    let result = watch.looks(interval, args.count.unwrap_or(u64::MAX));
    if watch.screen.is_some() {
        watch.output.raw(Screen::restore())?;
    }
    result
}

struct Watch<'a> {
    session: &'a Session,
    screen: Option<Screen>,
    output: Output,
    monitors: Vec<Monitor>,
}

impl Watch<'_> {
    /// Looks until the count is reached or the user stops; a daemon that goes is waited for.
    fn looks(&mut self, interval: Duration, count: u64) -> Result<(), Failure> {
        let mut next = Instant::now();
        let mut discovery = next + BETWEEN_DISCOVERIES;
        for _ in 0..count {
            // Connecting comes first: the first look should show something.
            self.connect();
            next += interval;
            if !self.session.stop.sleep_until(next) {
                return Ok(());
            }
            if next >= discovery {
                discovery = next + BETWEEN_DISCOVERIES;
                // Without a daemon the cameras known stay in the table.
                let there = self.session.cameras_now().unwrap_or_default();
                self.follow(there)?;
            }
            self.show()?;
        }
        Ok(())
    }

    fn connect(&mut self) {
        self.monitors.iter_mut().for_each(|monitor| {
            monitor.has_anything();
        });
    }

    fn follow(&mut self, cameras: Vec<String>) -> Result<(), Failure> {
        for camera in cameras {
            if self.monitors.iter().all(|monitor| monitor.camera != camera) {
                self.monitors.push(Monitor::new(&self.session.client, &camera)?);
            }
        }
        Ok(())
    }

    fn show(&mut self) -> Result<(), Failure> {
        let reports: Vec<Report> = self.monitors.iter_mut().map(Monitor::report).collect();
        match &mut self.screen {
            Some(screen) => self.output.raw(&screen.replace(&lines(&reports))),
            None if self.session.json => reports.iter().try_for_each(|r| self.output.json(r)),
            None => reports.iter().try_for_each(|r| self.output.line(&plain(r))),
        }
    }
}
