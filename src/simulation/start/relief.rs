//! Crust that stands as high as is wanted, as far as isostasy and the age–depth law allow.

use super::column::Column;
use crate::{
    mesh::SphereMesh,
    simulation::{
        recipe::Recipe,
        stages::{
            erode::{continental_height, continental_rise, sea_floor_height},
            reorganize_plates::Outline,
        },
        streams::{self, Purpose},
        sub_plate::{Crust, PlateId},
        topology::EdgeState,
        workers::Workers,
    },
};

/// Oldest sea floor of the start, in My. Older floor would lie hardly deeper, and founder at once.
const OLDEST: f64 = 140.0;
/// Thinnest sea floor, in km, as in the deepest column.
const THINNEST: f64 = 3.0;
/// Thickest sea floor as a share of what counts as continent.
const PLATEAU: f64 = 0.98;
/// Ages of continental crust in My.
const CRATONS: core::ops::RangeInclusive<f64> = 600.0..=3000.0;

/// The ground of a start.
pub(super) struct Ground {
    /// Kind of crust.
    pub crust: Vec<Crust>,
    /// Thickness in km.
    pub thickness: Vec<f64>,
    /// Age in My.
    pub age: Vec<f64>,
    /// Height in m above the reference level of isostasy.
    pub heights: Vec<f64>,
}

/// Gives every sub-plate the thickness and the age with which it stands at its elevation in m, the sea
/// at the reference level of isostasy.
///
/// * Continental crust has the thickness of its height, up to the thickest that collisions allow.
/// * Sea floor has the thickness of its [`Column`] and the lowest age that takes it down to its depth. What lies
///   deeper than the oldest floor is thinner; what lies higher than a ridge is a plateau.
pub(super) fn raise(
    recipe: &Recipe,
    mesh: &SphereMesh<EdgeState>,
    plate: &[PlateId],
    elevations: &[f64],
    crust: Vec<Crust>,
) -> Ground {
    let constants = &recipe.constants;
    let rise = continental_rise(recipe, &Workers::default(), mesh, plate, &crust);
    let mut rng = streams::stream(recipe.seed, Purpose::Continents, 0, 2);
    let cratons = Outline::new(&mut rng, 1.0);
    let (young, old) = (*CRATONS.start(), *CRATONS.end());
    let mut ground = Ground {
        thickness: Vec::with_capacity(crust.len()),
        age: Vec::with_capacity(crust.len()),
        heights: Vec::with_capacity(crust.len()),
        crust,
    };
    for (v, &elevation) in elevations.iter().enumerate() {
        let (thickness, age, height);
        if ground.crust[v].is_continental() {
            let wanted =
                constants.erosion.reference_thickness + elevation / constants.erosion.isostasy;
            thickness = wanted.clamp(
                constants.ridges.breakup_thickness,
                constants.collisions.thickest,
            );
            let noise = cratons.at(mesh.site(v as u32));
            age = (0.5 * (young + old + (old - young) * noise)).clamp(young, old);
            height = continental_height(&constants.erosion, thickness);
        } else {
            let plateau = PLATEAU * constants.uplift.arc_accretion;
            let floor = |age, thickness| sea_floor_height(recipe, age, thickness, rise[v], 0.0);
            let column = Column::at(elevation).thickness_km.min(plateau);
            age = youngest(elevation, |age| floor(age, column));
            let missing = (elevation - floor(age, column)) / constants.erosion.isostasy;
            thickness = (column + missing).clamp(THINNEST, plateau);
            height = floor(age, thickness);
        }
        ground.thickness.push(thickness);
        ground.age.push(age);
        ground.heights.push(height);
    }
    ground
}

/// The lowest age in My at which the floor has come down to an elevation; if it never does, the one at
/// which it comes nearest.
fn youngest(elevation: f64, floor: impl Fn(f64) -> f64) -> f64 {
    let mut above = floor(0.0);
    let mut nearest = (above, 0.0);
    if above <= elevation {
        return 0.0;
    }
    let mut age = 0.0;
    while age < OLDEST {
        let next = floor(age + 1.0);
        if next <= elevation {
            return age + (above - elevation) / (above - next);
        }
        age += 1.0;
        above = next;
        if above < nearest.0 {
            nearest = (above, age);
        }
    }
    nearest.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::recipe::Recipe;

    #[test]
    fn the_floor_is_as_old_as_its_depth() {
        let recipe = Recipe::default();
        let floor = |age| sea_floor_height(&recipe, age, 7.0, 0.0, 0.0);
        // 2600 + 365·√9 − 3·9 of sediment = 3668 m at 9 My.
        assert!((youngest(-3668.0, floor) - 9.0).abs() < 1e-9);
        assert_eq!(youngest(-2000.0, floor), 0.0);
        // Sediment, 3 m/My, outpaces cooling, 2473·0.0278·e^(−0.0278 t), beyond 112.7 My.
        assert!((youngest(-7000.0, floor) - 113.0).abs() <= 1.0);
    }
}
