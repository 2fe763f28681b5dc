//! Continents from random great circles, ranked onto a hypsometric curve (Tectonics.js).

use super::hypsometry::Hypsometry;
use crate::{
    mesh::SphereMesh,
    simulation::{
        recipe::Recipe,
        streams::{self, Purpose},
        topology::EdgeState,
    },
};
use glam::DVec3;

/// Number of steps.
const CIRCLES: usize = 1_000;
/// Steepness of a step, per radius: on Earth it rises within some 100 km.
const STEEPNESS: f64 = 300.0;
/// Largest distance of a circle's plane from the centre, in radii. True great circles would make
/// every ocean the mirror of a continent.
const OFFSET: f64 = 0.5;

/// Elevation in m above the sea of every sub-plate, so that the surface has the wanted hypsometry: the
/// steps decide which place is higher, the curve by how much.
pub(super) fn elevations(
    recipe: &Recipe,
    hypsometry: &Hypsometry,
    mesh: &SphereMesh<EdgeState>,
) -> Vec<f64> {
    let field = field(recipe, mesh.sites());
    let mut order: Vec<u32> = (0..field.len() as u32).collect();
    order.sort_by(|&a, &b| {
        field[a as usize]
            .total_cmp(&field[b as usize])
            .then(a.cmp(&b))
    });
    // Ranks by area: cells are not all of one size.
    let cells = mesh.cell_areas();
    let sphere: f64 = cells.iter().sum();
    let mut elevations = vec![0.0; field.len()];
    let mut lower = 0.0;
    for v in order {
        let cell = cells[v as usize] / sphere;
        elevations[v as usize] = hypsometry.elevation(lower + 0.5 * cell);
        lower += cell;
    }
    elevations
}

/// The sum of the steps at every site.
fn field(recipe: &Recipe, sites: &[DVec3]) -> Vec<f64> {
    let mut rng = streams::stream(recipe.seed, Purpose::Continents, 0, 1);
    let circles: Vec<(DVec3, f64)> = (0..CIRCLES)
        .map(|_| {
            let pole = streams::direction(&mut rng);
            (pole, OFFSET * (2.0 * streams::unit(&mut rng) - 1.0))
        })
        .collect();
    sites
        .iter()
        .map(|site| {
            let steps = circles
                .iter()
                .map(|(pole, offset)| step(site.dot(*pole) - offset));
            steps.sum()
        })
        .collect()
}

/// The logistic function, from 0 to 1.
fn step(x: f64) -> f64 {
    let x = STEEPNESS * x;
    if x.abs() > 37.0 {
        // All that f64 can tell.
        return f64::from(u8::from(x > 0.0));
    }
    1.0 / (1.0 + libm::exp(-x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_logistic() {
        assert_eq!(step(0.0), 0.5);
        // 1/(1 + e⁻³) at a hundredth of the radius.
        assert!((step(0.01) - 0.952_574).abs() < 1e-6);
        assert!((step(-0.01) - 0.047_426).abs() < 1e-6);
        assert_eq!((step(-0.2), step(0.2)), (0.0, 1.0));
    }
}
