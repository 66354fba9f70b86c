//! A depth camera in the scene.

use glam::Vec3;
use lodestone_client::{Body, Optical, Transform, World, body_from_optical_axes};
use lodestone_config::model::{Camera, Depth};
use lodestone_schema::CloudPoint;

use super::Scene;
use super::rays::{LANES, Packet};
use super::stereo::{Draws, Stereo};
use super::view::{Bound, View};

/// Rows that share an instant: a fiftieth of the time of a rolling shutter with 250 rows.
const ROWS: usize = 5;

/// A pinhole camera with square pixels and the errors of stereo, read out row by row.
#[derive(Clone, Debug)]
pub struct DepthCamera {
    settings: Depth,
    stereo: Stereo,
    lens: Transform<Body, Optical>,
    /// To the right for a metre of depth, each column, in packets.
    across: Vec<[f32; LANES]>,
    /// Downward for a metre of depth, each row.
    down: Vec<f32>,
    /// The directions of each packet of each band of rows.
    cones: Vec<Bound>,
}

/// One exposure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Counts the exposures; the same number gives the same noise.
    pub number: u64,
    /// When the first row is read, `CLOCK_MONOTONIC`, ns.
    pub time_ns: i64,
}

impl DepthCamera {
    /// The depth camera of a camera; `index` is the camera's in the configuration.
    ///
    /// Rays begin at the left lens, which is at the IMU where it is not configured: so take it those who
    /// read the clouds.
    pub fn new(camera: &Camera, index: usize) -> Self {
        let settings = camera.depth.unwrap_or_default();
        let half_width = 0.5 * settings.width as f64;
        let focal_px = half_width / (0.5 * settings.field_of_view_deg.to_radians()).tan();
        let ray = |pixel: usize, count: usize| {
            ((pixel as f64 + 0.5 - 0.5 * count as f64) / focal_px) as f32
        };
        let packets = settings.width.div_ceil(LANES);
        let packet = |p: usize| std::array::from_fn(|lane| ray(p * LANES + lane, settings.width));
        let across: Vec<[f32; LANES]> = (0..packets).map(packet).collect();
        let down: Vec<f32> = (0..settings.height).map(|row| ray(row, settings.height)).collect();
        let axes = body_from_optical_axes();
        let lens = camera.lens_position_m.unwrap_or_default().into();
        Self {
            settings,
            stereo: Stereo::new(&settings, index as u64),
            lens: Transform::new(axes.rotation(), lens),
            cones: cones(&across, &down),
            across,
            down,
        }
    }

    /// The settings.
    pub const fn settings(&self) -> &Depth {
        &self.settings
    }

    /// Points of a cloud.
    pub const fn points(&self) -> usize {
        self.settings.width * self.settings.height
    }

    /// Span from the first row to the last, ns.
    pub fn shutter_ns(&self) -> i64 {
        (self.settings.rolling_shutter_s * 1e9).round() as i64
    }

    /// Exposes one frame into a cloud, organised, in the optical frame; `pose_at` tells where the body is
    /// at a time, `CLOCK_MONOTONIC`, ns.
    ///
    /// Of `cloud`, as many points are written as the camera has.
    ///
    /// # Errors
    /// What `pose_at` says; then a part of the cloud may be written.
    pub fn expose<E>(
        &self,
        scene: &Scene,
        frame: Frame,
        mut pose_at: impl FnMut(i64) -> Result<Transform<World, Body>, E>,
        cloud: &mut [CloudPoint],
    ) -> Result<(), E> {
        let mut draws = self.stereo.begin(frame.number);
        let mut candidates = Vec::new();
        for (band, points) in cloud.chunks_mut(ROWS * self.settings.width).enumerate() {
            let offset_ns = self.offset_ns(band);
            let time_ns = frame.time_ns + i64::from(offset_ns);
            let place = pose_at(time_ns)? * self.lens;
            if !scene.holds(place.origin()) {
                points.fill(CloudPoint { time_offset_ns: offset_ns, ..NOTHING });
                continue;
            }
            let view = scene.view(place, time_ns);
            let rows = Rows { view: &view, band, offset_ns };
            self.expose_rows(&rows, &mut draws, &mut candidates, points);
        }
        Ok(())
    }

    /// When a band of rows is read: its middle.
    fn offset_ns(&self, band: usize) -> i32 {
        let middle = (band * ROWS) as f64 + 0.5 * (ROWS - 1) as f64;
        let part = middle / (self.settings.height.max(2) - 1) as f64;
        (self.settings.rolling_shutter_s * 1e9 * part).round() as i32
    }

    fn expose_rows(
        &self,
        rows: &Rows<'_>,
        draws: &mut Draws,
        candidates: &mut Vec<u32>,
        points: &mut [CloudPoint],
    ) {
        let packets = self.across.len();
        let cones = &self.cones[rows.band * packets..];
        for ((packet, across), cone) in self.across.iter().enumerate().zip(cones) {
            candidates.clear();
            let met = rows.view.solids.iter().zip(0..);
            candidates.extend(met.filter(|(s, _)| cone.meets(&s.bound)).map(|(_, index)| index));
            let first = packet * LANES;
            for (row, line) in points.chunks_mut(self.settings.width).enumerate() {
                let end = (first + LANES).min(line.len());
                let down = self.down[rows.band * ROWS + row];
                let rays = Rays { across, down, candidates };
                self.expose_packet(rows, &rays, draws, &mut line[first..end]);
            }
        }
    }

    fn expose_packet(
        &self,
        rows: &Rows<'_>,
        rays: &Rays<'_>,
        draws: &mut Draws,
        points: &mut [CloudPoint],
    ) {
        let packet = Packet::new(rows.view, rays.across, rays.down);
        let hits = packet.cast(rows.view, rays.candidates);
        for (lane, (point, &across)) in points.iter_mut().zip(rays.across).enumerate() {
            let seen = packet.look(rows.view, &hits, lane);
            let length_squared = 1.0 + across * across + rays.down * rays.down;
            let depth = hits.depth_m[lane];
            let measured = self.stereo.measure(draws, depth, seen.along_normal, length_squared);
            *point = match measured.filter(|_| seen.is_there) {
                Some(depth) => CloudPoint {
                    position_m: [across * depth, rays.down * depth, depth],
                    time_offset_ns: rows.offset_ns,
                    colour: seen.colour,
                },
                None => CloudPoint { time_offset_ns: rows.offset_ns, ..NOTHING },
            };
        }
    }
}

/// A band of rows at one instant.
struct Rows<'v> {
    view: &'v View<'v>,
    band: usize,
    offset_ns: i32,
}

/// A packet's rays in one row.
struct Rays<'r> {
    across: &'r [f32; LANES],
    down: f32,
    candidates: &'r [u32],
}

/// A point without depth.
const NOTHING: CloudPoint =
    CloudPoint { position_m: [f32::NAN; 3], time_offset_ns: 0, colour: [0; 4] };

/// The directions of each packet of each band of rows, by their corners.
fn cones(across: &[[f32; LANES]], down: &[f32]) -> Vec<Bound> {
    let bands = down.chunks(ROWS).map(|rows| [rows[0], rows[rows.len() - 1]]);
    bands
        .flat_map(|[top, bottom]| {
            across.iter().map(move |packet| {
                let (left, right) = (packet[0], packet[LANES - 1]);
                Bound::of_directions(&[
                    Vec3::new(left, top, 1.0),
                    Vec3::new(right, top, 1.0),
                    Vec3::new(left, bottom, 1.0),
                    Vec3::new(right, bottom, 1.0),
                ])
            })
        })
        .collect()
}
