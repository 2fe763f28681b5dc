//! What kind of ground a piece is, and how it is turned: what the history says of the piece's own place.

use super::{
    Exemplars, Landform,
    exemplar::{Level, TEXEL_M},
    floor,
    scatter::{Reached, Scatter},
    value,
};
use crate::simulation::{Crust, Orogeny, Surface};
use crate::surface::raster::Raster;
use glam::Vec3;

/// Time over which mountains grow old, in My.
const AGEING_MY: f32 = 90.0;
/// Volcanoes stand out for so long, in My.
const VOLCANIC_MY: f32 = 25.0;
/// What stands higher than this on oceanic crust, in m above the sea, is a volcano's flank or a shore and no floor
/// that a ridge made. Well below the sea, because pieces reach 18 km beyond their middle: the hills of one in shallow
/// water would come ashore.
const FLANK_M: f32 = -300.0;
/// Continental crust thinner than this, in km, has been stretched.
const STRETCHED_KM: f32 = 30.0;

/// A piece of ground.
#[derive(Clone, Copy)]
pub(super) struct Patch {
    /// None on the sea floor.
    pub landform: Option<Landform>,
    /// Along the fold or the ridge, and across.
    pub along: Vec3,
    pub across: Vec3,
    pub shift: [f32; 2],
    pub bits: u64,
}

impl Patch {
    /// Value in deviations, slope per m, and what finer detail could add, at an offset in m.
    pub fn at(
        &self,
        offset: Vec3,
        exemplars: &Exemplars,
        level: Level,
        detail_m: f32,
    ) -> (f32, Vec3, f32) {
        let Some(landform) = self.landform else {
            return floor::hills(offset, self.along, self.across, self.bits, detail_m);
        };
        let tile = exemplars.get(landform);
        let at = [
            offset.dot(self.along) / TEXEL_M + self.shift[0],
            offset.dot(self.across) / TEXEL_M + self.shift[1],
        ];
        let (value, [x, y]) = tile.at(at, level);
        (
            value,
            (self.along * x + self.across * y) / TEXEL_M,
            tile.error(level),
        )
    }
}

/// What a piece is: the same from whatever sub-plate the search for its place starts.
pub(super) fn describe(
    piece: &Reached,
    scatter: &Scatter,
    surface: &Surface,
    raster: &Raster,
    mut hint: u32,
) -> Patch {
    let up = scatter.middle(piece).normalize();
    let (corners, weights) = raster.corners(up, &mut hint);
    // One of the sub-plates around, more often the nearer: kinds mingle where they meet.
    let [u, v, _] = weights.map(|weight| weight as f32);
    let chance = piece.chance();
    let corner = usize::from(chance >= u) + usize::from(chance >= u + v);
    let vertex = corners[corner];
    let age = value(&surface.orogeny_age, vertex).max(0.0);
    let chance = (chance * 37.0).fract();
    let is_young = chance < libm::expf(-age / AGEING_MY);
    let is_volcanic = (surface
        .volcanism_age
        .get(vertex as usize)
        .copied()
        .flatten())
    .is_some_and(|age| age < VOLCANIC_MY);
    let landform = match (
        value(&surface.crust, vertex),
        value(&surface.orogeny, vertex),
    ) {
        _ if is_volcanic => Some(Landform::Arc),
        (Crust::Oceanic, _) => {
            let is_flank = raster.base(up, &mut hint).elevation > FLANK_M;
            is_flank.then_some(Landform::Arc)
        }
        (_, Orogeny::Andean) if is_young => Some(Landform::Cordillera),
        (_, Orogeny::Himalayan) if is_young => Some(Landform::Collision),
        (_, Orogeny::Andean | Orogeny::Himalayan) => Some(Landform::Old),
        _ if value(&surface.thickness, vertex) < STRETCHED_KM => Some(Landform::Rift),
        _ => Some(Landform::Plain),
    };
    let up = up.as_vec3();
    let flat = |axis: Vec3| (axis - up * up.dot(axis)).try_normalize();
    let [random, _] = piece.turned(up.any_orthonormal_pair().into());
    let along = match landform {
        Some(_) => flat(value(&surface.fold, vertex)).map(|across| across.cross(up)),
        None => flat(value(&surface.ridge, vertex)),
    }
    .unwrap_or(random);
    Patch {
        landform,
        along,
        across: up.cross(along),
        shift: piece.shift(),
        bits: piece.bits,
    }
}
