//! The flow of the mantle towards foundering sea floor (Tectonics.js).
//!
//! Age → density → buoyancy of what is denser than the mantle → smoothed by diffusion → its gradient
//! is the mantle's velocity. All lengths are in km, so that the flow does not follow the mesh.

use super::super::super::{
    clock::Clock,
    constants::FounderingConstants,
    recipe::Recipe,
    sub_plate::{Created, Crust},
};
use crate::mesh::{EdgePayload, SphereMesh};
use glam::DVec3;

/// Gravity in m/s².
const GRAVITY: f64 = 9.81;
/// Implicit steps that the diffusion is cut into. One alone leaves cusps over small sources.
const DIFFUSION_STEPS: usize = 3;
/// Residual at which the diffusion is solved, as a share of the source.
const TOLERANCE: f64 = 1e-6;
/// Most rounds of the solver; it needs about as many as a diffusion length has cells, times five.
const MOST_ROUNDS: usize = 5000;

/// Density of sea floor of an age in My, in kg/m³.
pub(in crate::simulation) fn density(constants: &FounderingConstants, age_my: f64) -> f64 {
    let share = (age_my / constants.old_age).clamp(0.0, 1.0);
    constants.young_density + (constants.old_density - constants.young_density) * share
}

/// Buoyancy of foundering sea floor in N/m³, `min(g(ρₘ − ρ), 0)`: 0 for what floats.
pub(in crate::simulation) fn buoyancy(constants: &FounderingConstants, age_my: f64) -> f64 {
    (GRAVITY * (constants.mantle_density - density(constants, age_my))).min(0.0)
}

/// Angular velocity of the mantle under each sub-plate, `r × v / R`, in rad/My.
pub(in crate::simulation) fn mantle_flow<E: EdgePayload>(
    recipe: &Recipe,
    clock: &Clock,
    mesh: &SphereMesh<E>,
    crust: &[Crust],
    created: &[Created],
) -> Vec<DVec3> {
    let constants = &recipe.constants.foundering;
    let mut field: Vec<f64> = crust
        .iter()
        .zip(created)
        .map(|(crust, created)| {
            if crust.is_continental() {
                0.0
            } else {
                buoyancy(constants, clock.time_my - f64::from(created.0))
            }
        })
        .collect();
    diffuse(
        mesh,
        &mut field,
        constants.diffusion_length / recipe.radius_km,
    );
    // Towards lower buoyancy; the gradient is per radius.
    let per_gradient = -1e3 * constants.mobility / recipe.radius_km;
    gradient(mesh, &field)
        .into_iter()
        .enumerate()
        .map(|(v, slope)| mesh.site(v as u32).cross(slope) * (per_gradient / recipe.radius_km))
        .collect()
}

/// Diffuses a field over this length in radii: implicit steps of the finite-volume operator on the
/// Voronoi cells, each solved by conjugate gradients with sums in the order of the vertices.
fn diffuse<E: EdgePayload>(mesh: &SphereMesh<E>, field: &mut [f64], length: f64) {
    let time = length * length / DIFFUSION_STEPS as f64;
    let cells: Vec<f64> = mesh.cell_areas().iter().map(|a| a.max(1e-12)).collect();
    // Across each edge flows the difference times the Voronoi side's length over the edge's.
    let conductance: Vec<(u32, u32, f64)> = mesh
        .edges()
        .map(|edge| {
            let (u, v) = mesh.endpoints(edge);
            let side = mesh
                .circumcentre(2 * edge)
                .distance(mesh.circumcentre(2 * edge + 1));
            let length = mesh.site(u).distance(mesh.site(v)).max(1e-12);
            (u, v, time * side / length)
        })
        .collect();
    let mut diagonal = cells.clone();
    for &(u, v, flow) in &conductance {
        diagonal[u as usize] += flow;
        diagonal[v as usize] += flow;
    }
    let apply = |x: &[f64]| -> Vec<f64> {
        let mut y: Vec<f64> = x.iter().zip(&diagonal).map(|(x, d)| x * d).collect();
        for &(u, v, flow) in &conductance {
            y[u as usize] -= flow * x[v as usize];
            y[v as usize] -= flow * x[u as usize];
        }
        y
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    for _ in 0..DIFFUSION_STEPS {
        let source: Vec<f64> = field.iter().zip(&cells).map(|(x, a)| x * a).collect();
        let mut residual: Vec<f64> = source
            .iter()
            .zip(apply(field))
            .map(|(b, y)| b - y)
            .collect();
        let precondition =
            |r: &[f64]| -> Vec<f64> { r.iter().zip(&diagonal).map(|(r, d)| r / d).collect() };
        let mut direction = precondition(&residual);
        let mut energy = dot(&residual, &direction);
        let enough = TOLERANCE * TOLERANCE * dot(&source, &precondition(&source));
        for _ in 0..MOST_ROUNDS {
            if energy <= enough {
                break;
            }
            let image = apply(&direction);
            let step = energy / dot(&direction, &image);
            for v in 0..field.len() {
                field[v] += step * direction[v];
                residual[v] -= step * image[v];
            }
            let conditioned = precondition(&residual);
            let left = dot(&residual, &conditioned);
            let turn = left / energy;
            energy = left;
            for (direction, z) in direction.iter_mut().zip(conditioned) {
                *direction = z + *direction * turn;
            }
        }
    }
}

/// Gradient of a field per radius, tangent to the sphere: the plane that fits the neighbours best.
fn gradient<E: EdgePayload>(mesh: &SphereMesh<E>, field: &[f64]) -> Vec<DVec3> {
    (0..field.len() as u32)
        .map(|v| {
            let site = mesh.site(v);
            let east = site.any_orthonormal_vector();
            let north = site.cross(east);
            let (mut xx, mut xy, mut yy, mut x, mut y) = (0.0, 0.0, 0.0, 0.0, 0.0);
            for w in mesh.neighbours(v) {
                let way = mesh.site(w) - site;
                let (e, n) = (way.dot(east), way.dot(north));
                let weight = 1.0 / way.length_squared().max(1e-24);
                let rise = (field[w as usize] - field[v as usize]) * weight;
                xx += e * e * weight;
                xy += e * n * weight;
                yy += n * n * weight;
                x += e * rise;
                y += n * rise;
            }
            let determinant = xx * yy - xy * xy;
            if determinant > 1e-9 {
                (east * (yy * x - xy * y) + north * (xx * y - xy * x)) / determinant
            } else {
                DVec3::ZERO
            }
        })
        .collect()
}

/// Mean of a field of angular velocities over areas that `of` sorts into `count` groups.
pub(in crate::simulation) fn mean_rotations(
    flow: &[DVec3],
    area: impl Fn(usize) -> f64,
    of: impl Fn(usize) -> Option<usize>,
    count: usize,
) -> Vec<DVec3> {
    let mut sums = vec![(DVec3::ZERO, 0.0); count];
    for (v, &turn) in flow.iter().enumerate() {
        if let Some(group) = of(v) {
            sums[group].0 += turn * area(v);
            sums[group].1 += area(v);
        }
    }
    sums.into_iter()
        .map(
            |(sum, area)| {
                if area > 0.0 { sum / area } else { DVec3::ZERO }
            },
        )
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::fixtures::even_mesh;

    #[test]
    fn floor_founders_once_it_is_denser_than_the_mantle() {
        let constants = FounderingConstants::default();
        // 2890 + 410 · 100/250 = 3054 kg/m³ floats on 3075.
        assert!((density(&constants, 100.0) - 3054.0).abs() < 1e-9);
        assert_eq!(buoyancy(&constants, 100.0), 0.0);
        // 2890 + 410 · 200/250 = 3218; 9.81 · (3075 − 3218) = −1402.83 N/m³.
        assert!((buoyancy(&constants, 200.0) + 1402.83).abs() < 1e-6);
        // From 250 My on: 9.81 · (3075 − 3300) = −2207.25 N/m³.
        assert!((buoyancy(&constants, 400.0) + 2207.25).abs() < 1e-6);
    }

    /// z is a spherical harmonic of degree 1: `∇² z = −2 z`, so that an implicit step of length² t
    /// divides it by 1 + 2t, on any mesh.
    #[test]
    fn diffusion_follows_lengths_and_not_cells() {
        let (length, steps) = (0.5, DIFFUSION_STEPS as f64);
        let expected = libm::pow(1.0 + 2.0 * length * length / steps, -steps);
        for n in [500, 4000] {
            let mesh = even_mesh::<()>(n);
            let mut field: Vec<f64> = mesh.sites().iter().map(|site| site.z).collect();
            diffuse(&mesh, &mut field, length);
            let slopes = gradient(&mesh, &field);
            for (v, site) in mesh.sites().iter().enumerate() {
                assert!((field[v] - expected * site.z).abs() < 0.01, "{n}: {v}");
                // ∇z is the part of the z axis that is tangent.
                let slope = (DVec3::Z - *site * site.z) * expected;
                assert!((slopes[v] - slope).length() < 0.05, "{n}: {v}");
            }
        }
    }

    #[test]
    fn plates_turn_by_the_mean_over_their_areas() {
        let turn = DVec3::new(1.0, -2.0, 3.0);
        // Two sub-plates that turn alike, two that do not, and one that is on no plate.
        let flow = [turn, turn, DVec3::Y * 4.0, DVec3::Z * 8.0, DVec3::X];
        let areas = [2.0, 6.0, 1.0, 3.0, 5.0];
        let plates = [Some(0), Some(0), Some(1), Some(1), None];
        let rotations = mean_rotations(&flow, |v| areas[v], |v| plates[v], 3);
        // (1 · 4 y + 3 · 8 z)/4 = y + 6 z; the third plate has no ground.
        assert_eq!(rotations, [turn, DVec3::new(0.0, 1.0, 6.0), DVec3::ZERO]);
    }

    /// Floor whose buoyancy falls evenly from pole to pole: `−1103.625 (1 + z)` N/m³, from 0 at an age of
    /// 185/1.64 My to −2207.25 at 250 My.
    #[test]
    fn the_mantle_flows_at_mobility_times_the_gradient() {
        let mut recipe = Recipe::default().with_sub_plates(2000);
        recipe.constants.foundering = FounderingConstants {
            diffusion_length: 2000.0,
            mobility: 2.0,
            ..FounderingConstants::default()
        };
        let clock = Clock {
            time_my: 250.0,
            ..Clock::default()
        };
        let mesh = even_mesh::<()>(2000);
        let afloat = 185.0 / 1.64;
        let created: Vec<Created> = mesh
            .sites()
            .iter()
            .map(|site| {
                let age = afloat + (250.0 - afloat) * 0.5 * (1.0 + site.z);
                Created((250.0 - age) as f32)
            })
            .collect();
        let crust = vec![Crust::Oceanic; 2000];
        let flow = mantle_flow(&recipe, &clock, &mesh, &crust, &created);
        // The gradient is 1103.625/6.371 = 173.226 N/m³ per 1,000 km of the part of the z axis that is
        // tangent; diffused it is (1 + 2 · (2000/6371)²/3)⁻³ = 0.82622 of that. Twice it is 286.25 km/My.
        for (site, turn) in mesh.sites().iter().zip(flow) {
            let velocity = turn.cross(*site) * recipe.radius_km;
            let expected = (DVec3::Z - *site * site.z) * 286.25;
            assert!((velocity - expected).length() < 15.0, "{site}: {velocity}");
        }
    }

    #[test]
    fn the_mantle_flows_towards_old_floor_from_all_sides_and_no_continent_stops_it() {
        let recipe = Recipe::default().with_sub_plates(2000);
        let clock = Clock {
            time_my: 200.0,
            ..Clock::default()
        };
        let mesh = even_mesh::<()>(2000);
        let centre = DVec3::new(0.6, 0.0, 0.8);
        let old: Vec<bool> = mesh.sites().iter().map(|p| p.dot(centre) > 0.9).collect();
        let made = |old: &bool| Created(if *old { 0.0 } else { 200.0 });
        let created: Vec<Created> = old.iter().map(made).collect();
        let floor = vec![Crust::Oceanic; 2000];
        let flow = mantle_flow(&recipe, &clock, &mesh, &floor, &created);
        for (site, turn) in mesh.sites().iter().zip(&flow) {
            let near = site.dot(centre);
            if near > 0.0 && near < 0.95 {
                let velocity = turn.cross(*site).normalize();
                let towards = (centre - *site * near).normalize();
                assert!(velocity.dot(towards) > 0.98, "{site}: {velocity}");
            }
        }
        let continent_where = |is_old: bool| -> Vec<Crust> {
            let kind = |old: &bool| {
                if *old == is_old {
                    Crust::Continental
                } else {
                    Crust::Oceanic
                }
            };
            old.iter().map(kind).collect()
        };
        // Around the patch a continent drags no more than young floor does, and is dragged as much.
        let around = continent_where(false);
        assert_eq!(mantle_flow(&recipe, &clock, &mesh, &around, &created), flow);
        // A continent as old as the patch does not founder.
        let instead = continent_where(true);
        let still = mantle_flow(&recipe, &clock, &mesh, &instead, &created);
        assert!(still.iter().all(|turn| *turn == DVec3::ZERO));
    }
}
