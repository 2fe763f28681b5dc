//! How far inland a place lies, and the level down to which rivers and waves wear it.
//!
//! Behind the edge of the crust comes the profile of a shelf or a fore-arc, behind that the base level of
//! rivers rises inland. Shelves are as wide as their margins are old and as the land behind them is broad.

use super::super::{
    constants::ErosionConstants,
    reach::reach,
    recipe::Recipe,
    sub_plate::{Crust, PlateId, Trench},
    topology::EdgeState,
    workers::Workers,
};
use crate::mesh::{NONE, SphereMesh};

/// Distances from the crust's edge beyond this no longer matter, in km: the base level has reached its highest.
const FAR_INLAND: f64 = 3000.0;
/// Distance in km from which rivers reach the edge.
const DRAINED: f64 = 2000.0;
/// Shape of the continental slope: on Earth it is steepest at its foot. 1 is a straight line.
const SLOPE_POWER: f64 = 1.3;
/// Time in which a margin sinks as the mantle below it cools, in My (McKenzie 1978: 62.8).
const SUBSIDENCE: f64 = 60.0;
/// Breadth of the land that drains to a shelf of nominal width, in km.
const NOMINAL_BREADTH: f64 = 1000.0;
/// Length of coast over which waves and currents spread what rivers bring, in km.
const SPREAD: f64 = 400.0;
/// Most rounds of that: enough for two million sub-plates on a planet like Earth.
const MOST_ROUNDS: f64 = 1000.0;

/// Continental ground seen from the edge of its crust.
pub(super) struct Inland {
    /// Distance of each sub-plate from the edge, in km.
    pub distance: Vec<f64>,
    /// Width of the shelf in front of it, in km; 0 where the edge is far.
    pub width: Vec<f64>,
}

/// One sub-plate at the edge.
struct Edge {
    vertex: u32,
    /// Mean age of the sea floor in front of it in My; none where that sinks or moves on.
    age: Option<f64>,
}

impl Inland {
    pub(super) fn measure(
        recipe: &Recipe,
        workers: &Workers,
        mesh: &SphereMesh<EdgeState>,
        plate: &[PlateId],
        crust: &[Crust],
        trench: &[Trench],
        age: impl Fn(u32) -> f64 + Sync,
    ) -> Self {
        let constants = &recipe.constants.erosion;
        let found = workers.map(crust.len(), |rows| {
            let is_land = |v: &u32| crust[*v as usize].is_continental();
            let mut edges = Vec::new();
            for vertex in (rows.start as u32..rows.end as u32).filter(is_land) {
                let (mut sum, mut floor, mut active) = (0.0, 0.0, false);
                for w in mesh.neighbours(vertex).filter(|w| !is_land(w)) {
                    sum += age(w);
                    floor += 1.0;
                    active |=
                        plate[w as usize] != plate[vertex as usize] || trench[w as usize].0 > 0.0;
                }
                if floor > 0.0 {
                    let age = (!active).then_some(sum / floor);
                    edges.push(Edge { vertex, age });
                }
            }
            edges
        });
        let edges: Vec<Edge> = found.into_iter().flatten().collect();
        let half = 0.5 * recipe.spacing_km();
        let sources: Vec<(u32, f64)> = edges.iter().map(|edge| (edge.vertex, half)).collect();
        let found = reach(workers, mesh, recipe.radius_km, &sources, FAR_INLAND, |v| {
            crust[v as usize].is_continental()
        });
        // Sub-plates whose nearest edge this is, and the sum of their distances from it: their mean tells how
        // broad the land is whatever the roughness of its coast.
        let mut drained = vec![[0.0; 2]; edges.len()];
        for &(_, distance, source) in &found.found {
            if distance < DRAINED {
                let [count, sum] = &mut drained[source as usize];
                *count += 1.0;
                *sum += distance;
            }
        }
        spread_along(recipe, mesh, &edges, &mut drained);
        let widths: Vec<f64> = edges
            .iter()
            .zip(&drained)
            .map(|(edge, [count, sum])| {
                // Twice the mean distance is the breadth of a strip that drains to one side. The edge counts, but
                // where its own cells are wider than all that drains.
                let breadth = 2.0 * sum / count.max(1.0);
                edge.age.map_or(constants.forearc_width, |age| {
                    let sunk = 1.0 - libm::exp(-age.max(0.0) / SUBSIDENCE);
                    let fed = 2.0 * breadth / (breadth + NOMINAL_BREADTH);
                    (constants.shelf_width * sunk * fed).min(0.5 * FAR_INLAND)
                })
            })
            .collect();
        let mut inland = Self {
            distance: vec![FAR_INLAND; crust.len()],
            width: vec![0.0; crust.len()],
        };
        for (v, distance, source) in found.found {
            inland.distance[v as usize] = distance;
            inland.width[v as usize] = widths[source as usize];
        }
        inland
    }

    /// Height in m above the sea down to which rock is worn, and up to which sediment fills but for the
    /// [`slope`](Self::slope).
    pub(super) fn base_level(&self, v: usize, constants: &ErosionConstants) -> f64 {
        let (distance, width) = (self.distance[v], self.width[v]);
        if distance < width {
            let shelf = (width - constants.slope_width).max(0.5 * width);
            let out = ((width - distance) / shelf).min(1.0);
            return constants.base_edge - constants.shelf_depth * out;
        }
        let inner = distance - width;
        (constants.base_edge + constants.base_slope * inner).min(constants.base_highest)
    }

    /// Depth in m below the base level down to which the sea leaves stretched crust unfilled: the slope
    /// that leads from the shelf to the foot of the crust.
    pub(super) fn slope(&self, v: usize, constants: &ErosionConstants) -> f64 {
        let out = 1.0 - self.distance[v] / constants.slope_width;
        if out > 0.0 {
            constants.slope_depth * libm::pow(out, SLOPE_POWER)
        } else {
            0.0
        }
    }
}

/// Blends values along the edge of the crust, by a walk that is as wide as [`SPREAD`].
fn spread_along(
    recipe: &Recipe,
    mesh: &SphereMesh<EdgeState>,
    edges: &[Edge],
    values: &mut [[f64; 2]],
) {
    let mut place = vec![NONE; mesh.vertex_count()];
    for (edge, i) in edges.iter().zip(0..) {
        place[edge.vertex as usize] = i;
    }
    let near: Vec<Vec<u32>> = edges
        .iter()
        .map(|edge| {
            let around = mesh.neighbours(edge.vertex).map(|w| place[w as usize]);
            around.filter(|&i| i != NONE).collect()
        })
        .collect();
    // Each round is a step of one spacing for two thirds of it.
    let steps = SPREAD / recipe.spacing_km();
    let rounds = (1.5 * steps * steps).clamp(1.0, MOST_ROUNDS);
    let mut before = values.to_vec();
    for _ in 0..rounds.round() as usize {
        before.copy_from_slice(values);
        for (value, near) in values.iter_mut().zip(&near) {
            for &i in near {
                value[0] += before[i as usize][0];
                value[1] += before[i as usize][1];
            }
            let share = 1.0 / (1 + near.len()) as f64;
            *value = value.map(|sum| sum * share);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::fixtures::random_mesh;
    use bevy::utils::default;

    /// A continent north of 30° and a ribbon 8° wide at 40° south, on one plate, with floor of one age.
    fn measured(age: f64, plate: [u16; 2]) -> (SphereMesh<EdgeState>, Vec<Crust>, Inland) {
        let mesh = random_mesh::<EdgeState>(6000);
        let recipe = Recipe::earth_like(1).with_sub_plates(6000);
        let latitude = |v: usize| libm::asin(mesh.site(v as u32).z).to_degrees();
        let crust: Vec<Crust> = (0..6000)
            .map(|v| {
                let is_land = latitude(v) > 30.0 || (latitude(v) + 40.0).abs() < 4.0;
                if is_land {
                    Crust::Continental
                } else {
                    Crust::Oceanic
                }
            })
            .collect();
        let plates: Vec<PlateId> = (crust.iter())
            .map(|crust| PlateId(plate[usize::from(!crust.is_continental())]))
            .collect();
        let trench = vec![Trench::default(); 6000];
        let workers = Workers::default();
        let inland = Inland::measure(&recipe, &workers, &mesh, &plates, &crust, &trench, |_| age);
        (mesh, crust, inland)
    }

    /// Mean width of the shelf in front of the continent's land, and of the ribbon's.
    fn widths(age: f64, plate: [u16; 2]) -> [f64; 2] {
        let (mesh, crust, inland) = measured(age, plate);
        [true, false].map(|north| {
            let of =
                |v: &usize| crust[*v].is_continental() && (mesh.site(*v as u32).z > 0.0) == north;
            let near = |v: &usize| of(v) && inland.distance[*v] < DRAINED;
            let land: Vec<usize> = (0..6000).filter(near).collect();
            land.iter().map(|&v| inland.width[v]).sum::<f64>() / land.len() as f64
        })
    }

    #[test]
    fn shelves_widen_with_age_and_with_the_land_behind_them() {
        let [old, ribbon] = widths(180.0, [1, 1]);
        assert!(old > 1.5 * ribbon, "{old} {ribbon}");
        // 1 - 1/e^(1/4) of its width at 15 My, 1 - 1/e^3 at 180.
        let [young, _] = widths(15.0, [1, 1]);
        let expected = (1.0 - libm::exp(-0.25)) / (1.0 - libm::exp(-3.0));
        assert!((young / old - expected).abs() < 1e-9, "{young} {old}");
        // Another plate's floor moves on: a fore-arc, whatever its age.
        let forearc = Recipe::default().constants.erosion.forearc_width;
        assert_eq!(widths(15.0, [1, 2]), [forearc; 2]);
    }

    #[test]
    fn base_levels_rise_inland_behind_a_shelf_and_a_slope() {
        let constants = ErosionConstants {
            base_edge: -10.0,
            base_slope: 0.5,
            base_highest: 650.0,
            shelf_depth: 200.0,
            slope_width: 100.0,
            slope_depth: 3000.0,
            ..default()
        };
        // Distance, width, base level, slope: the shelf's 200 m are reached 400 or 200 km in front of
        // its inner edge, 3000 · 0.5^1.3 = 1218.379.
        let places = [
            (0.0, 500.0, -210.0, 3000.0),
            (50.0, 500.0, -210.0, 1218.379),
            (100.0, 500.0, -210.0, 0.0),
            (300.0, 500.0, -110.0, 0.0),
            (500.0, 500.0, -10.0, 0.0),
            (1500.0, 500.0, 490.0, 0.0),
            (200.0, 300.0, -110.0, 0.0),
            (2000.0, 300.0, 650.0, 0.0),
        ];
        let inland = Inland {
            distance: places.map(|place| place.0).to_vec(),
            width: places.map(|place| place.1).to_vec(),
        };
        for (v, (_, _, base, slope)) in places.into_iter().enumerate() {
            assert!((inland.base_level(v, &constants) - base).abs() < 1e-9);
            assert!((inland.slope(v, &constants) - slope).abs() < 1e-3);
        }
    }
}
