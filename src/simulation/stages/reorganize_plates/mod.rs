//! Stage 10: plates join, break, and start to sink.
//!
//! One file per event: [`fronts`] smooths ragged boundaries, [`suture`] welds continents that have
//! stopped closing, [`rift`] breaks large plates, [`founder`] lets old sea floor sink at its margin,
//! [`basins`] fills enclosed seas, and [`splinters`] absorbs what any of them cut off. Splinters are
//! looked for in every step in which something may have been cut, the rest at the pace of the
//! reorganisation clock.

pub(in crate::simulation) mod basins;
pub(in crate::simulation) mod founder;
pub(in crate::simulation) mod fronts;
pub(in crate::simulation) mod rift;
pub(in crate::simulation) mod splinters;
pub(in crate::simulation) mod suture;

use super::super::{
    plate::PlateTable,
    streams,
    sub_plate::{MaterialArea, PlateId},
};
use crate::mesh::Flip;
use bevy::prelude::*;
use fastnoise_lite::{FastNoiseLite, FractalType, NoiseType};
use glam::DVec3;
use rand_chacha::ChaCha8Rng;

/// Whether a plate may have fallen apart since splinters were last looked for.
#[derive(Resource, Debug, Clone, Copy, Default, Reflect)]
#[reflect(Resource)]
pub struct Splits {
    /// Set by whoever removes a connection; cleared once all plates are in one piece.
    pub suspected: bool,
    /// Set when sub-plates changed plates or plates their motion; cleared once velocities follow.
    pub regrouped: bool,
}

impl Splits {
    /// A flip that takes the last edge between two parts of a plate may have cut it.
    pub(in crate::simulation) fn note_flips(&mut self, flips: &[Flip], plate: &[PlateId]) {
        // Crust made in this step is not in the columns yet; it lies at a front, so suspect it.
        let of = |v: u32| plate.get(v as usize).copied().unwrap_or_default();
        self.suspected |= flips.iter().any(|flip| {
            let [a, b] = flip.before.map(of);
            a == b && flip.after.iter().all(|&v| of(v) != a)
        });
    }

    /// A vertex whose plate does not lie in one run around it may have held that plate together.
    pub(in crate::simulation) fn note_removal(
        &mut self,
        ring: &[u32],
        own: PlateId,
        plate: &[PlateId],
    ) {
        let own = |i: usize| plate[ring[i % ring.len()] as usize] == own;
        let runs = (0..ring.len()).filter(|&i| own(i) && !own(i + 1)).count();
        let whole = ring.is_empty() || (0..ring.len()).all(own);
        self.suspected |= runs != 1 && !whole;
    }
}

/// Area of each plate in km², in the order of the table.
pub(in crate::simulation) fn plate_areas(
    table: &PlateTable,
    plate: &[PlateId],
    area: &[MaterialArea],
) -> Vec<f64> {
    let mut areas = vec![0.0; table.rows().len()];
    for (plate, area) in plate.iter().zip(area) {
        if let Some(row) = table.row(*plate) {
            areas[row] += area.0;
        }
    }
    areas
}

/// Smooth noise over the sphere, about −1 to 1, that makes the outlines of events irregular.
pub(in crate::simulation) struct Outline(FastNoiseLite);

impl Outline {
    pub(in crate::simulation) fn new(rng: &mut ChaCha8Rng, frequency: f32) -> Self {
        let mut noise = FastNoiseLite::with_seed(streams::below(rng, i32::MAX as usize) as i32);
        noise.set_noise_type(Some(NoiseType::OpenSimplex2));
        noise.set_fractal_type(Some(FractalType::FBm));
        noise.set_fractal_octaves(Some(4));
        noise.set_frequency(Some(frequency));
        Self(noise)
    }

    pub(in crate::simulation) fn at(&self, direction: DVec3) -> f64 {
        let p = direction.as_vec3();
        f64::from(self.0.get_noise_3d(p.x, p.y, p.z))
    }
}
