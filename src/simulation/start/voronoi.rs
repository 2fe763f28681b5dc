//! Plates as cells of random centres under noise-warped distance (Cortial et al. 2019).

use super::Layout;
use crate::{
    mesh::SphereMesh,
    simulation::{
        recipe::Recipe,
        stages::reorganize_plates::Outline,
        streams::{self, Purpose},
        sub_plate::PlateId,
        topology::EdgeState,
    },
};
use glam::DVec3;

/// Amplitude of the warp in radians.
const WARP: f64 = 0.25;
/// Speed at which the sea floor of the start spread, in km/My.
const SPREADING: f64 = 30.0;
/// Oldest sea floor of the start, in My.
const OLDEST: f64 = 150.0;

/// Gives every sub-plate to the nearest centre; sea floor is older away from the cell's rim.
pub(super) fn lay_out(recipe: &Recipe, mesh: &SphereMesh<EdgeState>) -> Layout {
    let mut rng = streams::stream(recipe.seed, Purpose::Plates, 0, 0);
    let centres: Vec<DVec3> = (0..recipe.plates)
        .map(|_| streams::direction(&mut rng))
        .collect();
    let outlines = [(); 3].map(|()| Outline::new(&mut rng, 1.4));
    let (plate, age) = mesh
        .sites()
        .iter()
        .map(|&site| {
            let warp = DVec3::from_array([0, 1, 2].map(|axis: usize| outlines[axis].at(site)));
            let warped = (site + warp * WARP).normalize();
            let (mut best, mut second) = ((f64::MAX, 0), f64::MAX);
            for (i, centre) in centres.iter().enumerate() {
                let distance = warped.distance(*centre);
                if distance < best.0 {
                    second = best.0;
                    best = (distance, i);
                } else {
                    second = second.min(distance);
                }
            }
            let rim = 0.5 * (second - best.0) * recipe.radius_km;
            (PlateId(best.1 as u16 + 1), (rim / SPREADING).min(OLDEST))
        })
        .unzip();
    Layout { plate, age }
}
