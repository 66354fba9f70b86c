//! Ground truth of a recording, for scores alone: what [`super::Recording`] does not hand on.

use std::path::Path;

use glam::{DQuat, DVec2};
use lodestone_fusion::SensorTime;

use super::decimal;
use super::error::RecordingError;
use super::lines::{Line, LineReader};
use super::source::Source;

/// What really was at the time of one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthRow {
    /// Column `t`.
    pub time: SensorTime,
    /// Columns `qw qx qy qz`: body to world; `None` where the row has none.
    pub orientation: Option<DQuat>,
    /// Columns `px py`, m, in axes of the recording's own; `None` where the row has none.
    pub position_m: Option<DVec2>,
    /// Column `movement`: whether the row is scored; true where there is no such column.
    pub is_scored: bool,
}

/// Columns in the order of their values.
const NAMES: [&str; 8] = ["t", "qw", "qx", "qy", "qz", "px", "py", "movement"];

/// Reads the truth of all rows that have a time. Rows that cannot be read are left out: the
/// recording's own reader counts them.
///
/// # Errors
/// [`RecordingError`] if the file cannot be read.
pub fn read(path: &Path) -> Result<Vec<TruthRow>, RecordingError> {
    let unreadable = |source| RecordingError::Unreadable { path: path.to_path_buf(), source };
    let mut lines = LineReader::new(Source::open(path)?);
    let Some(Line::Text(header)) = lines.next_line().map_err(unreadable)? else {
        return Err(RecordingError::Empty { path: path.to_path_buf() });
    };
    let places = places(header);
    let mut rows = Vec::new();
    while let Some(line) = lines.next_line().map_err(unreadable)? {
        if let Line::Text(text) = line {
            rows.extend(row(text, &places));
        }
    }
    Ok(rows)
}

/// In which column of the file each of [`NAMES`] is.
fn places(header: &[u8]) -> [Option<usize>; NAMES.len()] {
    let header = String::from_utf8_lossy(header);
    let header = header.trim_start_matches('\u{FEFF}');
    let names: Vec<&str> = header.split(',').map(|n| n.trim().trim_matches('"')).collect();
    NAMES.map(|name| names.iter().position(|other| *other == name))
}

fn row(text: &[u8], places: &[Option<usize>; NAMES.len()]) -> Option<TruthRow> {
    let fields: Vec<&[u8]> = text.split(|&byte| byte == b',').map(<[u8]>::trim_ascii).collect();
    let field = |k: usize| fields.get(places[k]?).copied();
    let value = |k: usize| -> Option<f64> {
        let value: f64 = std::str::from_utf8(field(k)?).ok()?.parse().ok()?;
        value.is_finite().then_some(value)
    };
    let time = SensorTime::from_nanos(decimal::seconds_to_nanos(field(0)?)?);
    let quaternion = || {
        let q = DQuat::from_xyzw(value(2)?, value(3)?, value(4)?, value(1)?);
        (q.length() > 0.5).then(|| q.normalize())
    };
    Some(TruthRow {
        time,
        orientation: quaternion(),
        position_m: value(5).zip(value(6)).map(|(x, y)| DVec2::new(x, y)),
        is_scored: places[7].is_none() || value(7).is_some_and(|movement| movement > 0.5),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_there_is_read_and_what_is_not_is_none() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let text =
            "t,gx,qw,qx,qy,qz,px,py,movement\n0.5,9,1,0,0,0,1.5,-2,1\n0.6,9,,,,,nan,3,0\nx,9\n";
        std::fs::write(file.path(), text).unwrap();
        let rows = read(file.path()).unwrap();
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[0].time.as_nanos(), 500_000_000);
        assert_eq!(rows[0].position_m, Some(DVec2::new(1.5, -2.0)));
        assert_eq!(rows[0].orientation, Some(DQuat::IDENTITY));
        assert!(rows[0].is_scored);
        assert_eq!((rows[1].orientation, rows[1].position_m), (None, None));
        assert!(!rows[1].is_scored);
    }

    #[test]
    fn without_a_column_that_says_what_is_scored_all_is() {
        let places = places(b"t,px,py");
        assert!(row(b"1.0,2,3", &places).unwrap().is_scored);
        assert_eq!(row(b"1.0,2", &places).unwrap().position_m, None);
    }
}
