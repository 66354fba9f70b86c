//! Tells a running daemon the speed of a vehicle: one number, m/s, in each line of the standard input.
//!
//! `my-bus-reader | cargo run -p lodestone-client --example aid_with_speed -- front`, with the name of a camera
//! that is configured to sit on a vehicle, or of the vehicle itself where several do.

use std::io::stdin;

use lodestone_client::{AidingOrigin, Client, monotonic_now_ns};

/// Of wheel ticks on a road, m/s, 1σ.
const SIGMA_M_S: f64 = 0.05;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "front".into());
    let mut vehicle = Client::connect()?.aiding(&name)?.made_with(AidingOrigin::Odometry);
    for line in stdin().lines() {
        // A line stands for now; a bus that stamps its messages knows better, and may be two seconds late.
        let time_ns = monotonic_now_ns();
        let line = line?;
        let told = line.trim().parse().map_err(|e| format!("{line:?}: {e}"));
        match told
            .and_then(|v| vehicle.speed(time_ns, v, Some(SIGMA_M_S)).map_err(|e| e.to_string()))
        {
            Ok(()) => {}
            Err(error) => eprintln!("not told: {error}"),
        }
    }
    Ok(())
}
