//! Relative poses of all pairs of replayed cameras, as CSV.
//!
//! | column | unit | |
//! |---|---|---|
//! | `t` | s | the recordings' time |
//! | `a` `b` | | the cameras' names |
//! | `qw qx qy qz` | | rotation from b's body axes to a's |
//! | `rxx rxy rxz ryy ryz rzz` | rad² | its covariance, as a small rotation about the axes that the schema's message names |
//! | `dx dy dz` | m | b's origin in a's body axes |
//! | `dxx dxy dxz dyy dyz dzz` | m² | its covariance |
//! | `distance_source` `validity` | | as in the shared-memory schema |
//!
//! Ten rows a second for each pair; what is not known is empty.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use lodestone_config::model::Config;
use lodestone_fusion::{Estimate, SensorTime};
use lodestone_schema::{Relative, name_of};

use crate::csv_file::CsvFile;
use crate::poses_csv::PosesError;
use crate::reading::HostTime;
use crate::world::{Motion, Pair, WorldFrame, WorldPhase, WorldStep};

const HEADER: &str = "t,a,b,qw,qx,qy,qz,rxx,rxy,rxz,ryy,ryz,rzz,dx,dy,dz,dxx,dxy,dxz,dyy,dyz,dzz,\
     distance_source,validity\n";

/// Between two rows of a pair, ns.
const INTERVAL_NS: i64 = 100_000_000;

/// The world that the replayed cameras share, and what each has of each other.
pub(super) struct Relatives {
    frame: Arc<WorldFrame>,
    pairs: Vec<Pair>,
    next_ns: Option<i64>,
    file: CsvFile,
}

impl Relatives {
    /// A world that the first replayed camera may fix, and a file for its pairs.
    pub(super) fn create(config: &Config, first: usize, path: &Path) -> Result<Self, PosesError> {
        let phase = WorldPhase { member: Some(first as u16), ..WorldPhase::waiting(1) };
        let members = config.camera.len() + config.body.len();
        Ok(Self {
            frame: Arc::new(WorldFrame::new(members, phase)),
            pairs: Pair::all(config),
            next_ns: None,
            file: CsvFile::create(path, HEADER)?,
        })
    }

    /// The world, for the lanes.
    pub(super) const fn frame(&self) -> &Arc<WorldFrame> {
        &self.frame
    }

    /// Writes the pairs if they are due at a time of the recordings.
    pub(super) fn write_if_due(&mut self, time: SensorTime) -> Result<(), PosesError> {
        let now_ns = time.as_nanos();
        if now_ns < *self.next_ns.get_or_insert(now_ns) {
            return Ok(());
        }
        self.next_ns = Some(now_ns + INTERVAL_NS);
        let mut text = String::new();
        for pair in &self.pairs {
            let message = pair.message(&self.frame, HostTime::from_nanos(now_ns), 0);
            if message.orientation.iter().all(|x| x.is_finite()) {
                append(&mut text, &message);
            }
        }
        self.file.write(text.as_bytes())
    }

    /// Hands all rows to the system.
    pub(super) fn finish(self) -> Result<(), PosesError> {
        self.file.finish()
    }
}

/// Tells those who compare cameras where a member is.
pub(super) fn report(
    frame: &WorldFrame,
    member: usize,
    (time, estimate): (SensorTime, &Estimate),
    world: WorldStep,
) {
    frame.report_motion(member, &Motion::of(estimate, time.as_nanos(), &world));
}

fn append(text: &mut String, m: &Relative) {
    let name = |field| name_of(field).unwrap_or_default();
    let [x, y, z, w] = m.orientation;
    let seconds = m.time_ns as f64 * 1e-9;
    // Writing to a text cannot fail.
    let _ = write!(text, "{seconds:.9},{},{}", name(&m.name_a), name(&m.name_b));
    let turned = [w, x, y, z].into_iter().chain(m.orientation_covariance_rad2);
    for number in turned.chain(m.distance_m).chain(m.distance_covariance_m2) {
        let _ = if number.is_finite() { write!(text, ",{number:.9}") } else { write!(text, ",") };
    }
    let _ = writeln!(text, ",{},{}", m.distance_source, m.validity);
}
