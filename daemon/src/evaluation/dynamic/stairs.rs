//! The paper's figure "Trajectory Representation of Climb Stairs": position and orientation along the
//! way, against the truth.

use serde::Serialize;

use super::harmonic::{Swing, stride_hz, swing};
use super::method::Method;
use super::track::{PoseError, Track, TrackPoint, orientation_rms_deg, wrapped_deg};
use crate::evaluation::statistics::{Quantiles, root_mean_square};

/// A piece of the first flight at an even pace, s after the rest: behind the start, before the landing
/// of the fastest walker (3.36 m at 0.46 m/s).
pub const FLIGHT_S: (f64, f64) = (1.5, 7.0);

/// What each method made of the stairs.
#[derive(Clone, Debug, Serialize)]
pub struct Stairs {
    /// Runs behind every figure.
    pub runs: u32,
    /// The true orientation's swing: part of its variance that the stride explains, for roll, pitch and
    /// yaw.
    pub true_explained: [Quantiles; 3],
    /// The true swing of roll and yaw with the stride and of pitch with the step, degrees.
    pub true_swing_deg: [Quantiles; 3],
    /// Each method's scores, in the order of [`Method::ALL`].
    pub methods: Vec<StairsScore>,
    /// The first run.
    #[serde(skip)]
    pub drawn: Drawn,
}

/// What one method made of the stairs.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct StairsScore {
    /// The method.
    pub method: Method,
    /// Root mean square of the position's error over the walk, m.
    pub rms_m: Quantiles,
    /// The position's error at the end, m.
    pub end_m: Quantiles,
    /// The height's part of it, m.
    pub end_height_m: Quantiles,
    /// Root mean square error of roll, pitch and yaw, degrees.
    pub orientation_rms_deg: [Quantiles; 3],
    /// Part of the variance of roll, pitch and yaw over a flight that the stride explains.
    pub explained: [Quantiles; 3],
    /// Swing of roll and yaw with the stride and of pitch with the step, degrees.
    pub swing_deg: [Quantiles; 3],
}

/// One run, to be drawn.
#[derive(Clone, Debug, Default)]
pub struct Drawn {
    /// The true way.
    pub truth: Track,
    /// What each method found, in the order of [`Method::ALL`].
    pub tracks: Vec<Track>,
}

impl Drawn {
    /// The walk up and down, which ends when the walker has stood at the bottom again for a second.
    /// `None` if that does not happen.
    pub fn until_return(mut truth: Track, mut tracks: Vec<Track>) -> Option<Self> {
        let end = return_to_bottom(&truth)?;
        truth.0.truncate(end);
        for track in &mut tracks {
            track.0.truncate(end);
        }
        Some(Self { truth, tracks })
    }

    /// Scores of the truth itself and of each track. `None` if they are too short.
    pub fn scores(&self) -> Option<(TrackScore, Vec<TrackScore>)> {
        let score = |track: &Track| TrackScore::of(track, &track.errors(&self.truth));
        Some((score(&self.truth)?, self.tracks.iter().map(score).collect::<Option<_>>()?))
    }
}

/// How many instants there are until the walker has stood at the bottom for a second.
fn return_to_bottom(truth: &Track) -> Option<usize> {
    const BOTTOM_M: f64 = 0.02;
    let points = &truth.0;
    let height = |k: &usize| points[*k].position_m.z;
    let highest = (0..points.len()).map(|k| height(&k)).fold(0.0, f64::max);
    // The first time: who is fast climbs the stairs again.
    let top = (0..points.len()).find(|k| height(k) > highest - BOTTOM_M)?;
    let stands_until = |from: &usize| {
        let end = points[*from..].iter().position(|p| p.time_s > points[*from].time_s + 1.0)?;
        let still = |p: &TrackPoint| p.position_m.distance(points[*from].position_m) < 1e-6;
        points[*from..*from + end].iter().all(still).then_some(*from + end)
    };
    (top..points.len()).filter(|k| height(k) < BOTTOM_M).find_map(|k| stands_until(&k))
}

/// What one track of one run is worth.
#[derive(Clone, Debug)]
pub struct TrackScore {
    rms_m: f64,
    end_m: f64,
    end_height_m: f64,
    orientation_rms_deg: [f64; 3],
    swings: [Swing; 3],
}

impl TrackScore {
    /// Scores a track. `None` if it is too short.
    pub fn of(track: &Track, errors: &[PoseError]) -> Option<Self> {
        let distances: Vec<f64> = errors.iter().map(|e| e.position_m.length()).collect();
        let end = errors.last()?.position_m;
        Some(Self {
            rms_m: root_mean_square(&distances)?,
            end_m: end.length(),
            end_height_m: end.z.abs(),
            orientation_rms_deg: orientation_rms_deg(errors)?,
            swings: swings(track)?,
        })
    }

    /// The swing that each angle is expected to have: roll and yaw with each stride, pitch with each
    /// step.
    fn expected_swing_deg(&self) -> [f64; 3] {
        let [roll, pitch, yaw] = self.swings;
        [roll.at_stride, pitch.at_step, yaw.at_stride]
    }
}

/// Times, s, and roll, pitch and yaw, degrees without jumps, over a piece of the first flight.
pub fn flight(track: &Track) -> (Vec<f64>, [Vec<f64>; 3]) {
    let within = |time_s: f64| (FLIGHT_S.0..=FLIGHT_S.1).contains(&time_s);
    let points = track.0.iter().filter(|point| within(point.time_s));
    let angles: Vec<[f64; 3]> = points.clone().map(TrackPoint::roll_pitch_yaw_deg).collect();
    let first = angles.first().copied().unwrap_or_default();
    let axis =
        |k: usize| angles.iter().map(|angle| first[k] + wrapped_deg(angle[k] - first[k])).collect();
    (points.map(|point| point.time_s).collect(), [axis(0), axis(1), axis(2)])
}

/// The swing of roll, pitch and yaw; the stride's frequency is that of the roll.
fn swings(track: &Track) -> Option<[Swing; 3]> {
    let (times_s, angles) = flight(track);
    let hz = stride_hz(&times_s, &angles[0])?;
    let of = |axis: usize| swing(&times_s, &angles[axis], hz);
    Some([of(0)?, of(1)?, of(2)?])
}

impl Stairs {
    /// Puts runs together, each with the score of the truth and those of the methods. `None` without a
    /// run.
    pub fn of(runs: &[(TrackScore, Vec<TrackScore>)], drawn: Drawn) -> Option<Self> {
        let truths: Vec<&TrackScore> = runs.iter().map(|(truth, _)| truth).collect();
        let methods = Method::ALL.iter().enumerate().map(|(index, &method)| {
            let scores: Vec<&TrackScore> = runs.iter().map(|(_, ours)| &ours[index]).collect();
            StairsScore::of(method, &scores)
        });
        Some(Self {
            runs: runs.len() as u32,
            true_explained: axes(&truths, |score| score.swings.map(|swing| swing.explained))?,
            true_swing_deg: axes(&truths, TrackScore::expected_swing_deg)?,
            methods: methods.collect::<Option<_>>()?,
            drawn,
        })
    }

    /// A method's score.
    pub fn of_method(&self, method: Method) -> Option<&StairsScore> {
        self.methods.iter().find(|score| score.method == method)
    }
}

impl StairsScore {
    fn of(method: Method, runs: &[&TrackScore]) -> Option<Self> {
        let one = |figure: fn(&TrackScore) -> f64| Quantiles::of(runs.iter().map(|r| figure(r)));
        Some(Self {
            method,
            rms_m: one(|score| score.rms_m)?,
            end_m: one(|score| score.end_m)?,
            end_height_m: one(|score| score.end_height_m)?,
            orientation_rms_deg: axes(runs, |score| score.orientation_rms_deg)?,
            explained: axes(runs, |score| score.swings.map(|swing| swing.explained))?,
            swing_deg: axes(runs, TrackScore::expected_swing_deg)?,
        })
    }
}

/// Quantiles of a figure with three axes.
fn axes(runs: &[&TrackScore], figure: fn(&TrackScore) -> [f64; 3]) -> Option<[Quantiles; 3]> {
    let axis = |k: usize| Quantiles::of(runs.iter().map(|run| figure(run)[k]));
    Some([axis(0)?, axis(1)?, axis(2)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use lodestone_fusion::Rotation;

    /// Heights at ten instants a second.
    fn walk(heights: impl Iterator<Item = f64>) -> Track {
        let point = |(k, z): (usize, f64)| TrackPoint {
            time_s: k as f64 * 0.1,
            position_m: DVec3::Z * z,
            orientation: Rotation::IDENTITY,
        };
        Track(heights.enumerate().map(point).collect())
    }

    #[test]
    fn a_walk_ends_when_the_walker_stands_at_the_bottom_and_not_before_nor_a_lap_later() {
        let up = || (0..=40).map(|k| f64::from(k) * 0.1);
        let rest = |z: f64| std::iter::repeat_n(z, 20);
        let lap = || rest(0.0).chain(up()).chain(rest(4.0)).chain(up().map(|z| 4.0 - z));
        let twice = walk(lap().chain(lap()).chain(rest(0.0)));
        let end = return_to_bottom(&twice).unwrap();
        assert!((122..=134).contains(&end), "{end}");
        assert_eq!(return_to_bottom(&walk(rest(0.0).chain(up()))), None, "still at the top");
    }
}
