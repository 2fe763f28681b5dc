//! `planet.json`: what was grown, how, and at what cost.

use std::{io::Write, path::Path};

use serde::{Serialize, Serializer};

use super::{ExportError, draft::Draft};
use crate::simulation::{History, Ledger, Recipe, Statistics, Surface};

/// The contents of `planet.json`.
#[derive(Serialize)]
pub struct Summary {
    /// Everything needed to grow this planet again.
    pub recipe: Recipe,
    /// Age of the planet, My.
    pub time_my: f64,
    /// Radius of the planet, km.
    pub radius_km: f64,
    /// Number of sub-plates at the end.
    pub sub_plates: usize,
    /// Number of steps taken.
    pub steps: u64,
    /// Where the time went.
    pub seconds: Seconds,
    /// Hash of every field of the final state, 16 hexadecimal digits.
    pub state_hash: String,
    /// Land share, ages, plates, speeds, boundaries.
    pub statistics: Statistics,
    /// Where crust came from and went.
    pub ledger: Ledger,
}

/// Wall time in seconds.
#[derive(Serialize)]
pub struct Seconds {
    /// In all, as the caller measured it.
    pub total: f64,
    /// By stage, in the order in which the stages run.
    #[serde(serialize_with = "in_order")]
    pub stages: Vec<(&'static str, f64)>,
}

fn in_order<S: Serializer>(
    stages: &[(&'static str, f64)],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_map(stages.iter().map(|(stage, seconds)| (stage, seconds)))
}

impl Summary {
    /// Summarises a history whose present state is `surface` and that has cost `total_seconds` of wall
    /// time.
    ///
    /// # Errors
    /// When the history's fields cannot be read.
    pub fn new(
        history: &mut History,
        surface: &Surface,
        total_seconds: f64,
    ) -> Result<Self, ExportError> {
        Ok(Self {
            recipe: history.recipe().clone(),
            time_my: history.time_my(),
            radius_km: surface.radius_km,
            sub_plates: surface.mesh.sites().len(),
            steps: history.steps(),
            seconds: Seconds {
                total: total_seconds,
                stages: history.stage_seconds(),
            },
            state_hash: format!("{:016x}", history.state_hash()?),
            statistics: history.statistics()?,
            ledger: history.ledger(),
        })
    }

    pub(super) fn draft(&self, folder: &Path) -> Result<Draft, ExportError> {
        let draft = Draft::create(folder, "planet.json")?;
        draft.fill(|pen| {
            serde_json::to_writer_pretty(&mut *pen, self)?;
            pen.write_all(b"\n")
        })?;
        Ok(draft)
    }
}
