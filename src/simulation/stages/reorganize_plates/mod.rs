//! Stage 10: plates join, break, and start to sink.
//!
//! One file per event: [`fronts`] smooths ragged boundaries, [`suture`] welds continents that have
//! stopped closing, [`rift`] breaks large plates along a [`cut`] that is under [`tension`], [`founder`] lets old sea floor sink at its margin,
//! [`segment`] cuts the mantle's flow into plates where that drives them, [`basins`] fills enclosed
//! seas, and [`splinters`] absorbs what any of them cut off. Splinters are looked for in every step in
//! which something may have been cut, the rest at the pace of the reorganisation clock.

pub(in crate::simulation) mod basins;
mod cut;
pub(in crate::simulation) mod founder;
pub(in crate::simulation) mod fronts;
pub(in crate::simulation) mod rift;
pub(in crate::simulation) mod segment;
pub(in crate::simulation) mod splinters;
mod surge;
pub(in crate::simulation) mod suture;
mod tension;

use super::super::{
    plate::PlateTable,
    streams,
    sub_plate::{MaterialArea, PlateId},
};
use crate::mesh::{EdgePayload, Flip, SphereMesh};
use bevy::prelude::*;
use fastnoise_lite::{FastNoiseLite, FractalType, NoiseType};
use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Whether a plate may have fallen apart since splinters were last looked for.
#[derive(Resource, Debug, Clone, Default, PartialEq, Serialize, Deserialize, Reflect)]
#[reflect(Resource)]
pub struct Splits {
    /// Set by whoever removes a connection; cleared once all plates are in one piece.
    pub suspected: bool,
    /// Set when sub-plates changed plates or plates their motion; cleared once velocities follow.
    pub regrouped: bool,
    /// Pairs of sub-plates that lost a connection and were not found to hang together nearby. None where
    /// everything is looked at anyway.
    pub(crate) cuts: Vec<[u32; 2]>,
    /// Sub-plates that splinters took to another plate in this step.
    pub(crate) moved: Vec<u32>,
}

impl Splits {
    /// Looks whether pairs of sub-plates that lost a connection still hang together nearby; those that a
    /// short search does not join are kept.
    pub(in crate::simulation) fn note_cuts<E: EdgePayload>(
        &mut self,
        mesh: &SphereMesh<E>,
        plates: Carried,
        cuts: &[[u32; 2]],
    ) {
        // Where a sub-plate has gone since, what hung at it is not known.
        self.suspected |= cuts.iter().flatten().any(|&v| mesh.is_detached(v));
        if self.suspected {
            self.cuts.clear();
            return;
        }
        let open = cuts
            .iter()
            .filter(|[a, b]| !hang_together(mesh, plates, *a, *b));
        self.cuts.extend(open);
    }
}

/// Which plate carries which sub-plate, those included that were made in this stage and have no row yet.
#[derive(Clone, Copy)]
pub(in crate::simulation) struct Carried<'a> {
    pub rows: &'a [PlateId],
    pub newborn: &'a [PlateId],
}

impl<'a> Carried<'a> {
    /// Of sub-plates that all have rows.
    pub(in crate::simulation) fn by(rows: &'a [PlateId]) -> Self {
        Self { rows, newborn: &[] }
    }

    pub(in crate::simulation) fn of(&self, v: u32) -> Option<PlateId> {
        let v = v as usize;
        let newborn = || self.newborn.get(v.checked_sub(self.rows.len())?);
        self.rows.get(v).or_else(newborn).copied()
    }
}

/// Sub-plates of one plate that a search visits before it gives up.
const SEARCH: usize = 64;

/// Whether two sub-plates of one plate are joined by a short way within it.
fn hang_together<E: EdgePayload>(mesh: &SphereMesh<E>, plates: Carried, a: u32, b: u32) -> bool {
    let of = |v: u32| plates.of(v);
    if mesh.is_detached(a) || mesh.is_detached(b) || of(a) != of(b) {
        return false;
    }
    let mut seen = vec![a];
    let mut next = 0;
    while next < seen.len() && seen.len() < SEARCH {
        for w in mesh.neighbours(seen[next]) {
            if w == b {
                return true;
            }
            if of(w) == of(a) && !seen.contains(&w) {
                seen.push(w);
            }
        }
        next += 1;
    }
    false
}

/// Pairs of one plate that a flip took the edge from, unless it goes on through the flip's new ends.
pub(in crate::simulation) fn cut_by_flips<'a>(
    flips: &'a [Flip],
    plates: Carried<'a>,
) -> impl Iterator<Item = [u32; 2]> + 'a {
    let of = move |v: u32| plates.of(v);
    flips
        .iter()
        .filter(move |flip| {
            let [a, b] = flip.before.map(of);
            let goes_on = flip.turned && flip.after.iter().any(|&v| of(v) == a);
            a == b && a.is_some() && !goes_on
        })
        .map(|flip| flip.before)
}

/// Notes what may fall apart when a vertex with this ring of neighbours leaves its plate. Whether any of the
/// plate lies beside it.
pub(in crate::simulation) fn leave_plate(
    cuts: &mut Vec<[u32; 2]>,
    older: &mut [[u32; 2]],
    v: u32,
    ring: &[u32],
    plate: &[PlateId],
) -> bool {
    let own = plate[v as usize];
    let heir = ring.iter().copied().find(|&w| plate[w as usize] == own);
    hand_on(cuts.iter_mut().chain(older), v, heir);
    cuts.extend(cut_by_removal(ring, own, plate));
    heir.is_some()
}

/// Pairs that hung together through a vertex with this ring of neighbours: one of each run of its
/// plate and the next.
fn cut_by_removal(ring: &[u32], own: PlateId, plate: &[PlateId]) -> Vec<[u32; 2]> {
    let owned = |i: usize| plate[ring[i % ring.len()] as usize] == own;
    let ends: Vec<u32> = (0..ring.len())
        .filter(|&i| owned(i) && !owned(i + 1))
        .map(|i| ring[i])
        .collect();
    ends.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// Cuts of a sub-plate that leaves go on to one beside it; if it hung at nothing, to each other.
fn hand_on<'a>(cuts: impl Iterator<Item = &'a mut [u32; 2]>, gone: u32, heir: Option<u32>) {
    let mut last = heir;
    for pair in cuts.filter(|pair| pair[0] != pair[1] && pair.contains(&gone)) {
        let other = if pair[0] == gone { pair[1] } else { pair[0] };
        *pair = [last.unwrap_or(other), other];
        if heir.is_none() {
            last = Some(other);
        }
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
