//! `history.csv`: what a planet measured over time.

use std::{
    io::{self, Write},
    path::{Path, PathBuf},
};

use super::{
    ExportError,
    draft::{self, Draft},
};
use crate::simulation::{Statistics, StatisticsHistory};

/// Name of the file that [`write_history`] writes.
pub const HISTORY_FILE: &str = "history.csv";

/// Writes a history as CSV: a line of names, then a line for every moment, the earliest first.
///
/// Columns are the single figures of [`Statistics`] in the order of [`Statistics::MEASURES`], where the
/// unit and meaning of each is told; names are those of its fields. The first is `time_my`. Numbers are
/// decimal, with as many digits as it takes to read back the same bits.
///
/// # Errors
/// What `writer` says.
pub fn history_csv(history: &StatisticsHistory, writer: impl Write) -> io::Result<()> {
    let mut csv = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(writer);
    csv.write_record(Statistics::MEASURES.iter().map(|measure| measure.name))?;
    for moment in history.moments() {
        csv.serialize(moment.figures())?;
    }
    csv.flush()
}

/// Writes a history as `history.csv` into `folder`, which is created where it does not exist, and
/// returns the file's path. See [`history_csv`] for its columns.
///
/// # Errors
/// [`ExportError::Write`] names the file and the cause; then it was neither written nor replaced.
pub fn write_history(history: &StatisticsHistory, folder: &Path) -> Result<PathBuf, ExportError> {
    let draft = Draft::create(folder, HISTORY_FILE)?;
    draft.fill(|pen| history_csv(history, pen))?;
    draft::publish(vec![draft])?;
    Ok(folder.join(HISTORY_FILE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_reads_back_bit_for_bit() {
        let mut history = StatisticsHistory::default();
        for i in 0..3 {
            history.push(&Statistics {
                time_my: 10.0 * f64::from(i),
                land_share: 0.1 + 0.2 * f64::from(i),
                mean_ocean_m: -3730.0 / 7.0,
                ledger_gap: 1e-17,
                plates: 21,
                hypsometry_500_m: vec![0.5; 2],
                ..Statistics::default()
            });
        }
        let folder = tempfile::tempdir().unwrap();
        let path = write_history(&history, folder.path()).unwrap();
        assert_eq!(path, folder.path().join("history.csv"));
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.starts_with("time_my,interval_my,land_share,"));
        assert_eq!(text.lines().count(), 4);

        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let names: Vec<String> = reader.headers().unwrap().iter().map(Into::into).collect();
        let known: Vec<&str> = Statistics::MEASURES.iter().map(|m| m.name).collect();
        assert_eq!(names, known);
        for (row, moment) in reader.deserialize::<Vec<f64>>().zip(history.moments()) {
            let bits = |row: Vec<f64>| row.into_iter().map(f64::to_bits).collect::<Vec<_>>();
            assert_eq!(bits(row.unwrap()), bits(moment.figures()));
        }
        // Each name belongs to a field of planet.json too.
        let fields = serde_json::to_value(Statistics::default()).unwrap();
        assert!(known.iter().all(|name| fields.get(name).is_some()));
    }

    #[test]
    fn a_folder_in_the_way_is_named() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join(HISTORY_FILE)).unwrap();
        let error = write_history(&StatisticsHistory::default(), folder.path()).unwrap_err();
        assert!(error.to_string().contains(HISTORY_FILE));
    }
}
