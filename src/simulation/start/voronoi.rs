//! Plates as cells of random centres under noise-warped distance (Cortial et al. 2019).

use super::Layout;
use crate::{
    mesh::SphereMesh,
    simulation::{
        recipe::Recipe,
        stages::reorganize_plates::{
            Outline,
            splinters::{Pieces, pieces},
        },
        streams::{self, Purpose},
        sub_plate::PlateId,
        topology::EdgeState,
    },
};
use glam::DVec3;
use std::collections::BTreeMap;

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
    let (mut plate, age): (Vec<PlateId>, Vec<f64>) = mesh
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
    join_strays(mesh, &mut plate);
    Layout { plate, age }
}

/// The warp cuts some cells: all but the largest piece of each join the plates around them.
pub(super) fn join_strays(mesh: &SphereMesh<EdgeState>, plate: &mut [PlateId]) {
    loop {
        let Pieces { of, pieces } = pieces(mesh, plate);
        let mut size = vec![0_u32; pieces.len()];
        for &piece in &of {
            size[piece as usize] += 1;
        }
        let mut main: BTreeMap<PlateId, u32> = BTreeMap::new();
        for (piece, &(id, _)) in pieces.iter().enumerate() {
            let best = main.entry(id).or_insert(piece as u32);
            if size[piece] > size[*best as usize] {
                *best = piece as u32;
            }
        }
        if main.len() == pieces.len() {
            return;
        }
        // Main pieces only grow, and some stray touches one: this ends.
        let stray = |v: usize| main[&pieces[of[v] as usize].0] != of[v];
        for v in (0..plate.len()).filter(|&v| stray(v)) {
            let solid = mesh.neighbours(v as u32).find(|&w| !stray(w as usize));
            if let Some(w) = solid {
                plate[v] = pieces[of[w as usize] as usize].0;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::fixtures::random_mesh;

    #[test]
    fn cells_are_whole_warped_and_young_at_their_rims() {
        let recipe = Recipe::earth_like(4).with_sub_plates(6000);
        let mesh = random_mesh::<EdgeState>(6000);
        let layout = lay_out(&recipe, &mesh);
        // Every plate is one piece.
        let whole = pieces(&mesh, &layout.plate).pieces;
        let mut ids: Vec<PlateId> = layout.plate.clone();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(whole.len(), ids.len());
        assert!(ids.len() > recipe.plates as usize / 2);
        // Not all belong to the centre that lies nearest as the crow flies: by how many tells the warp.
        let mut rng = streams::stream(recipe.seed, Purpose::Plates, 0, 0);
        let centres: Vec<DVec3> = (0..recipe.plates)
            .map(|_| streams::direction(&mut rng))
            .collect();
        let nearest = |v: usize| {
            let far = |i: &usize| centres[*i].distance(mesh.site(v as u32));
            let nearest = (0..centres.len()).min_by(|a, b| far(a).total_cmp(&far(b)));
            PlateId(nearest.unwrap() as u16 + 1)
        };
        let kept = (0..6000).filter(|&v| layout.plate[v] == nearest(v)).count();
        assert!((3000..5900).contains(&kept), "{kept}");
        // Sea floor ages from the rims inwards, at 30 km/My.
        let is_rim = |v: usize| {
            let mut around = mesh.neighbours(v as u32);
            around.any(|w| layout.plate[w as usize] != layout.plate[v])
        };
        let mean = |rim: bool| {
            let ages: Vec<f64> = (0..6000)
                .filter(|&v| is_rim(v) == rim)
                .map(|v| layout.age[v])
                .collect();
            ages.iter().sum::<f64>() / ages.len() as f64
        };
        assert!(mean(true) < 10.0 && mean(false) > 2.0 * mean(true));
        assert!(layout.age.iter().all(|age| (0.0..=OLDEST).contains(age)));
    }

    #[test]
    fn strays_join_the_plates_around_them() {
        let mesh = random_mesh::<EdgeState>(800);
        let half = |v: u32| PlateId(if mesh.site(v).z > 0.0 { 1 } else { 2 });
        let mut plate: Vec<PlateId> = (0..800).map(half).collect();
        let expected = plate.clone();
        // One of the southern plate's cells deep in the northern one.
        let north = (0..800).max_by(|&a, &b| mesh.site(a).z.total_cmp(&mesh.site(b).z));
        plate[north.unwrap() as usize] = PlateId(2);
        join_strays(&mesh, &mut plate);
        assert_eq!(plate, expected);
    }
}
