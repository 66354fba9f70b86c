//! A depth source of one's own: a wall, two metres ahead of a camera, ten times a second.
//!
//! `cargo run -p lodestone-client --example publish_cloud -- front`, and in another terminal
//! `lodestone merge front --duration 5`, while the daemon publishes the poses of that camera.

use std::thread::sleep;
use std::time::Duration;

use lodestone_client::{Client, CloudFields, monotonic_now_ns};

const COLUMNS: u32 = 64;
const ROWS: u32 = 48;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let camera = std::env::args().nth(1).unwrap_or_else(|| "front".into());
    let mut source = Client::connect()?.cloud_publisher(&camera, (COLUMNS * ROWS) as usize)?;
    for _ in 0..100 {
        // A real source stamps the middle of its exposure.
        let seen_ns = monotonic_now_ns();
        // In shared memory already: filled in place, not copied. Points without depth stay NaN.
        let mut cloud = source.loan(COLUMNS, ROWS)?.with_fields(CloudFields::COLOUR);
        for (index, point) in cloud.points_mut().iter_mut().enumerate() {
            let (column, row) = (index as u32 % COLUMNS, index as u32 / COLUMNS);
            // Optical axes: x right, y down, z forward.
            point.position_m = [column as f32 * 0.05 - 1.6, row as f32 * 0.05 - 1.2, 2.0];
            point.colour = [200, 60, (4 * column) as u8, 255];
        }
        let consumers = cloud.send(seen_ns)?;
        println!("{camera}: cloud {} to {consumers} consumers", source.sent());
        sleep(Duration::from_millis(100));
    }
    Ok(())
}
