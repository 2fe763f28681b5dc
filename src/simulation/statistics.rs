//! What a planet measures, in the terms in which Earth is measured.

use super::{
    check::run, clock::Clock, columns::Columns, error::TectonicError, recipe::Recipe, sea::Sea,
    sub_plate::*, topology::Topology,
};
use bevy::prelude::*;
use glam::{DMat3, DVec3};
use serde::Serialize;
use std::collections::BTreeMap;

/// Figures of a planet at one moment. Shares are of the sphere's area unless said otherwise.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Statistics {
    /// Share above the sea. Earth 0.29.
    pub land_share: f64,
    /// Share of continental crust. Earth 0.41.
    pub continental_share: f64,
    /// Share by elevation in bins of 500 m from −11,000 m to 9,000 m.
    pub hypsometry_500_m: Vec<f64>,
    /// Mean elevation of land in m. Earth 850.
    pub mean_land_m: f64,
    /// Mean elevation of the sea floor in m. Earth −3,730.
    pub mean_ocean_m: f64,
    /// Highest sub-plate in m.
    pub highest_m: f64,
    /// Lowest sub-plate in m.
    pub lowest_m: f64,
    /// Mean age of the sea floor in My. Earth 60.
    pub ocean_age_mean_my: f64,
    /// Oldest sea floor in My. Earth 180 (a few relicts up to 340).
    pub ocean_age_oldest_my: f64,
    /// Number of plates. Earth 52, of which 38 exceed 0.05 % of the sphere.
    pub plates: usize,
    /// Share of the largest plate. Earth 0.21.
    pub largest_plate: f64,
    /// Mean speed over the area in mm/yr, without net rotation. Earth 38.
    pub speed_mean: f64,
    /// Median speed over the area in mm/yr, without net rotation. Earth 29.
    pub speed_median: f64,
    /// Length of the boundaries between plates in km. Earth 260,000.
    pub boundary_km: f64,
    /// Share of that length which opens, slides and closes (30° rule). Earth 0.36, 0.28, 0.35.
    pub boundary_shares: [f64; 3],
    /// Gathering of the continents: length of the mean position vector of continental crust.
    pub continental_concentration: f64,
    /// Mean thickness of continental crust in km. Earth 30–40.
    pub continental_thickness_km: f64,
    /// Height of the sea's surface in m above the reference level of isostasy.
    pub sea_level_m: f64,
}

impl Statistics {
    /// Measures a simulation world.
    ///
    /// # Errors
    /// [`TectonicError::Archetype`] if the sub-plates no longer lie in one table.
    pub fn measure(world: &mut World) -> Result<Self, TectonicError> {
        run(world, measure)
    }
}

fn measure(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    topology: Res<Topology>,
    sea: Res<Sea>,
    mut sub_plates: Query<
        (
            &PlateId,
            &Crust,
            &Elevation,
            &Created,
            &Velocity,
            &Thickness,
        ),
        With<SubPlate>,
    >,
) -> Result<Statistics, TectonicError> {
    let mesh = &topology.0;
    let (plate, crust, elevation, created, velocity, thickness) =
        sub_plates.columns(mesh.vertex_count())?;
    let cells = mesh.cell_areas();
    let sphere: f64 = cells.iter().sum();
    let mut statistics = Statistics {
        hypsometry_500_m: vec![0.0; 40],
        highest_m: f64::MIN,
        lowest_m: f64::MAX,
        sea_level_m: sea.level,
        ..default()
    };
    let mut plates: BTreeMap<PlateId, f64> = BTreeMap::new();
    let mut continents = DVec3::ZERO;
    let mut inertia = DMat3::ZERO;
    let mut spin = DVec3::ZERO;
    let (mut land, mut wet, mut floor) = (0.0, 0.0, 0.0);
    for v in 0..cells.len() {
        let share = cells[v] / sphere;
        let site = mesh.site(v as u32);
        let z = f64::from(elevation[v].0);
        let bin = ((z + 11_000.0) / 500.0).floor().clamp(0.0, 39.0) as usize;
        statistics.hypsometry_500_m[bin] += share;
        statistics.highest_m = statistics.highest_m.max(z);
        statistics.lowest_m = statistics.lowest_m.min(z);
        if z > 0.0 {
            land += share;
            statistics.mean_land_m += z * share;
        } else {
            wet += share;
            statistics.mean_ocean_m += z * share;
        }
        if crust[v].is_continental() {
            statistics.continental_share += share;
            statistics.continental_thickness_km += thickness[v].0 * share;
            continents += site * share;
        } else {
            let age = clock.time_my - f64::from(created[v].0);
            floor += share;
            statistics.ocean_age_mean_my += age * share;
            statistics.ocean_age_oldest_my = statistics.ocean_age_oldest_my.max(age);
        }
        *plates.entry(plate[v]).or_default() += share;
        inertia += (DMat3::IDENTITY
            - DMat3::from_cols(site * site.x, site * site.y, site * site.z))
            * share;
        spin += site.cross(velocity[v].0.as_dvec3()) * share;
    }
    statistics.land_share = land;
    statistics.mean_land_m /= land.max(1e-9);
    statistics.mean_ocean_m /= wet.max(1e-9);
    statistics.ocean_age_mean_my /= floor.max(1e-9);
    let continental = statistics.continental_share.max(1e-9);
    statistics.continental_thickness_km /= continental;
    statistics.continental_concentration = continents.length() / continental;
    statistics.plates = plates.len();
    statistics.largest_plate = plates.values().copied().fold(0.0, f64::max);

    let net = inertia.inverse() * spin;
    let mut speeds: Vec<(f64, f64)> = (0..cells.len())
        .map(|v| {
            let own = velocity[v].0.as_dvec3() - net.cross(mesh.site(v as u32));
            (own.length(), cells[v] / sphere)
        })
        .collect();
    statistics.speed_mean = speeds.iter().map(|(speed, share)| speed * share).sum();
    speeds.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut below = 0.0;
    for (speed, share) in speeds {
        below += share;
        if below >= 0.5 {
            statistics.speed_median = speed;
            break;
        }
    }
    measure_boundaries(&mut statistics, &recipe, mesh, plate, velocity);
    Ok(statistics)
}

/// Length of the boundaries, by the chord of the dual edges, and what they do.
fn measure_boundaries(
    statistics: &mut Statistics,
    recipe: &Recipe,
    mesh: &crate::mesh::SphereMesh<super::topology::EdgeState>,
    plate: &[PlateId],
    velocity: &[Velocity],
) {
    let mut shares = [0.0; 3];
    for edge in mesh.edges() {
        let (u, v) = mesh.endpoints(edge);
        if plate[u as usize] == plate[v as usize] {
            continue;
        }
        let (a, b) = (mesh.site(u), mesh.site(v));
        let dual = (mesh.site(mesh.apex(2 * edge)) - mesh.site(mesh.apex(2 * edge + 1))) / 3.0;
        let normal = dual.cross((a + b).normalize());
        let normal = if normal.dot(b - a) < 0.0 {
            -normal
        } else {
            normal
        };
        let length = normal.length() * recipe.radius_km;
        let slip = (velocity[v as usize].0 - velocity[u as usize].0).as_dvec3();
        let opening = slip.dot(normal.normalize_or_zero()) / slip.length().max(1e-9);
        let kind = if opening > 0.5 {
            0
        } else if opening < -0.5 {
            2
        } else {
            1
        };
        shares[kind] += length;
        statistics.boundary_km += length;
    }
    statistics.boundary_shares = shares.map(|share| share / statistics.boundary_km.max(1e-9));
}
