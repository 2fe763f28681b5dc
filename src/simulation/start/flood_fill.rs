//! Plates that grow from random seeds (Yggdrasill).

use super::Layout;
use crate::{
    mesh::SphereMesh,
    simulation::{
        recipe::Recipe,
        streams::{self, Purpose},
        sub_plate::PlateId,
        topology::EdgeState,
    },
};

/// Spacing of the sub-plates at which Yggdrasill's drift per round is stated, in km.
const NOMINAL_SPACING: f64 = 630.0;
/// Age drifts by this factor a round on sea floor: young at the rim, old inside.
const DRIFT: f64 = 0.8;

/// Grows all plates together, one frontier a round, the frontier shuffled each time.
pub(super) fn lay_out(recipe: &Recipe, mesh: &SphereMesh<EdgeState>) -> Layout {
    let count = mesh.vertex_count();
    let mut plate = vec![PlateId(0); count];
    let mut age = vec![0.0; count];
    let mut rng = streams::stream(recipe.seed, Purpose::Plates, 0, 0);
    let mut frontier = Vec::new();
    // Plates of unequal pace end unequal in size, as Earth's are.
    let mut pace = vec![0.0; recipe.plates as usize + 1];
    for id in 1..=recipe.plates as u16 {
        let seed = loop {
            let v = streams::below(&mut rng, count);
            if plate[v] == PlateId(0) {
                break v;
            }
        };
        plate[seed] = PlateId(id);
        age[seed] = 60.0 + 100.0 * streams::unit(&mut rng);
        let u = streams::unit(&mut rng);
        pace[usize::from(id)] = 0.15 + 0.85 * u * u;
        frontier.push(seed as u32);
    }
    let drift = libm::pow(DRIFT, recipe.spacing_km() / NOMINAL_SPACING);
    let mut shuffled = streams::stream(recipe.seed, Purpose::Frontier, 0, 0);
    while !frontier.is_empty() {
        streams::shuffle(&mut shuffled, &mut frontier);
        let mut grown = Vec::new();
        for v in frontier {
            let id = plate[v as usize];
            if streams::unit(&mut shuffled) > pace[usize::from(id.0)] {
                grown.push(v);
                continue;
            }
            for w in mesh.neighbours(v) {
                if plate[w as usize] == PlateId(0) {
                    plate[w as usize] = id;
                    age[w as usize] = age[v as usize] * drift;
                    grown.push(w);
                }
            }
        }
        frontier = grown;
    }
    Layout { plate, age }
}
