//! A second process: where was the camera 10 ms ago, and where is what it saw?
//!
//! `cargo run -p lodestone-client --example where_was_camera -- front`

use std::time::Duration;

use lodestone_client::{Client, Time, body_from_optical_axes, monotonic_now_ns};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let camera = std::env::args().nth(1).unwrap_or_else(|| "front".into());
    let mut poses = Client::connect()?.poses(&camera)?;
    for _ in 0..10 {
        poses.wait(Duration::from_secs(1))?;
        let image_time = Time::Monotonic(monotonic_now_ns() - 10_000_000);
        match poses.lookup(image_time).and_then(|pose| Ok(pose.world_from_body()?)) {
            Ok(world_from_body) => {
                let mut cloud = [[0.0, 0.0, 2.0], [0.5, 0.0, 3.0]]; // x right, y down, z forward
                (world_from_body * body_from_optical_axes()).apply_to_cloud(&mut cloud);
                println!("{camera} was at {} m and saw {cloud:?}", world_from_body.origin());
            }
            Err(error) => println!("{camera}: {error}"),
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    Ok(())
}
