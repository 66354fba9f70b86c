//! A valid configuration in a few lines.

use std::fmt::Write;

use crate::model::{
    Camera, Config, DriverKind, Lane, Policy, Realtime, Replay, Rig, Scene, Synthetic, Threads,
    World,
};

impl Config {
    /// What this configuration will run: the world, the lane, and one line for each camera.
    pub fn summary(&self) -> String {
        let mut out = String::new();
        let plural = if self.camera.len() == 1 { "" } else { "s" };
        let _ = writeln!(out, "{} camera{plural}", self.camera.len());
        let width = self.camera.iter().map(|camera| camera.name.len()).max().unwrap_or(0);
        for camera in &self.camera {
            let _ = writeln!(out, "  {:width$}  {}", camera.name, describe(camera));
        }
        for rig in self.rigs() {
            let _ = writeln!(out, "  {}  {}", self.body[rig.body].name, self.describe_rig(&rig));
        }
        let _ = writeln!(out, "world   {}", describe_world(&self.world));
        if let Some(scene) = &self.scene {
            let _ = writeln!(out, "scene   {}", describe_scene(scene));
        }
        let _ = writeln!(out, "lane    {}", describe_lane(&self.lane));
        let _ = writeln!(out, "threads {}", describe_realtime(&self.realtime));
        let shm = &self.shared_memory;
        let _ = writeln!(
            out,
            "memory  prefix {}, root {}, {} poses of history, up to {} subscribers",
            shm.prefix, shm.root, shm.pose_history, shm.max_subscribers
        );
        out
    }

    fn describe_rig(&self, rig: &Rig) -> String {
        let names: Vec<&str> =
            rig.members.iter().map(|&index| self.camera[index].name.as_str()).collect();
        let gradient = match (self.body[rig.body].gradient, names.len()) {
            (false, _) => "switched off",
            (true, 0..3) => "none: it needs three cameras",
            (true, _) => "where the field is bent by steel",
        };
        format!("rig of {}; velocity by the magnetic gradient: {gradient}", names.join(", "))
    }
}

fn describe(camera: &Camera) -> String {
    let mut parts = vec![describe_source(camera)];
    if camera.serial != 0 {
        parts.push(format!("serial {}", camera.serial));
    }
    match &camera.calibration {
        Some(file) => parts.push(format!("calibration {file}")),
        None if camera.driver == DriverKind::Zed2 => parts.push("not calibrated".into()),
        None => {}
    }
    if let Some(cpu) = camera.cpu {
        parts.push(format!("on cpu {cpu}"));
    }
    if let Some(start) = camera.start {
        let [x, y, z] = start.position_m;
        parts.push(format!("starts at {x} {y} {z} ± {} m", start.sigma_m));
    }
    if let Some(depth) = camera.depth {
        parts.push(format!("depth {} × {} at {} Hz", depth.width, depth.height, depth.rate_hz));
    }
    if let Some(cut_off_hz) = camera.low_pass_hz {
        parts.push(format!("low-pass {cut_off_hz} Hz"));
    }
    match camera.fault.len() {
        0 => {}
        1 => parts.push("1 fault injected".into()),
        count => parts.push(format!("{count} faults injected")),
    }
    parts.join(", ")
}

fn describe_source(camera: &Camera) -> String {
    let nominal_rate_hz = camera.model.nominal_rate_hz();
    match camera.driver {
        DriverKind::Zed2 => format!("zed2, {nominal_rate_hz} Hz nominal"),
        DriverKind::Synthetic => {
            let synthetic = camera.synthetic.clone().unwrap_or_default();
            describe_synthetic(&synthetic, nominal_rate_hz)
        }
        DriverKind::Replay => describe_replay(&camera.replay.clone().unwrap_or_default()),
    }
}

fn describe_synthetic(synthetic: &Synthetic, nominal_rate_hz: f64) -> String {
    let rate_hz = nominal_rate_hz * (1.0 + synthetic.transport.rate_error);
    let trajectory = toml::Value::try_from(synthetic.trajectory);
    let trajectory = trajectory.ok().and_then(|word| word.as_str().map(String::from));
    let end = if synthetic.duration_s > 0.0 {
        format!(", ends after {} s", synthetic.duration_s)
    } else {
        String::new()
    };
    format!(
        "synthetic {}, seed {}, {rate_hz:.1} Hz, {}{end}",
        trajectory.unwrap_or_default(),
        synthetic.seed,
        describe_speed(synthetic.speed)
    )
}

fn describe_replay(replay: &Replay) -> String {
    let repeat = if replay.repeat { ", repeated" } else { "" };
    let speed = describe_speed(replay.speed);
    format!("replay of {}, rate of the recording, {speed}{repeat}", replay.file)
}

fn describe_speed(speed: f64) -> String {
    if speed == 0.0 {
        "as fast as it goes".into()
    } else if (speed - 1.0).abs() < f64::EPSILON {
        "real speed".into()
    } else {
        format!("{speed} times real speed")
    }
}

fn describe_world(world: &World) -> String {
    let kept = match &world.keep {
        Some(file) => format!("kept in {file}"),
        None => "not kept".into(),
    };
    format!(
        "y to {} north, at {}°, {}°, {} m, {kept}",
        world.north.word(),
        world.latitude_deg,
        world.longitude_deg,
        world.altitude_m
    )
}

fn describe_scene(scene: &Scene) -> String {
    let [length, width, height] = scene.room.size_m;
    let pieces = scene.boxes.len() + scene.cylinder.len();
    let moving = if scene.mover.is_some() { ", and something that moves" } else { "" };
    format!("a room of {length} × {width} × {height} m with {pieces} solids in it{moving}")
}

fn describe_lane(lane: &Lane) -> String {
    let rate = match lane.step_rate_hz {
        Some(rate_hz) => format!("{rate_hz} steps/s"),
        None => "steps at the source's nominal rate".into(),
    };
    let threads = match lane.threads {
        Threads::One => "one thread",
        Threads::Two => "two threads",
        Threads::Timed => "two threads, the second on time",
    };
    format!(
        "{rate}, {threads}, bridges {} s, stale after {} s, new start after {} s",
        lane.bridge_limit_s, lane.stale_after_s, lane.reset_after_s
    )
}

fn describe_realtime(realtime: &Realtime) -> String {
    let policy = match realtime.policy {
        Policy::Other => "scheduled with everything else".into(),
        Policy::Fifo => format!("SCHED_FIFO {}", realtime.priority),
    };
    let memory = if realtime.lock_memory { "memory locked" } else { "memory not locked" };
    format!("{policy}, {memory}, timer slack {} ns", realtime.timer_slack_ns)
}
