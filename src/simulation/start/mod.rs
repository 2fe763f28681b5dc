//! From a recipe to the first moment of a world.

mod continents;
mod flood_fill;
mod voronoi;

use super::{
    clock::Clock,
    error::TectonicError,
    events::{self, EventLog},
    hot_spot::HotSpot,
    ledger::Ledger,
    plate::{NextPlateId, Plate, PlateBorn, Rotation},
    recipe::{Recipe, Start},
    sea::Sea,
    stages::{Splits, erode::continental_height, sea_floor_depth},
    streams::{self, Purpose},
    sub_plate::*,
    topology::{EdgeState, Topology},
};
use crate::mesh::{SphereMesh, hilbert_order};
use bevy::prelude::*;
use glam::DVec3;

/// Speeds of the first plates in km/My; the torque balance takes over within a few My.
const FIRST_SPEEDS: core::ops::Range<f64> = 10.0..60.0;

/// Which plate each sub-plate belongs to, and how old its sea floor is.
struct Layout {
    plate: Vec<PlateId>,
    /// Age of the sea floor in My, as if there were no continents.
    age: Vec<f64>,
}

/// Fills a world that has [`SimulationPlugins`](super::SimulationPlugins) with the first moment of a
/// planet. From then on every run of [`TectonicStep`](super::TectonicStep) is a step of its history.
/// [`History`](super::History) does this for you in a world of its own.
///
/// # Errors
/// [`TectonicError::Recipe`] for an invalid recipe, [`TectonicError::Build`] if the points cannot be
/// triangulated; the world is then as it was.
pub fn populate(world: &mut World, recipe: &Recipe) -> Result<(), TectonicError> {
    recipe.validate()?;
    let sites = scatter(recipe);
    let mesh = SphereMesh::<EdgeState>::build(sites)
        .map_err(|error| TectonicError::Build(error.to_string()))?;
    let layout = match recipe.start {
        Start::FloodFill => flood_fill::lay_out(recipe, &mesh),
        Start::Voronoi => voronoi::lay_out(recipe, &mesh),
    };
    let ground = continents::lay(recipe, &mesh);

    let constants = &recipe.constants;
    let cell = recipe.cell_area_km2();
    let area = vec![MaterialArea(cell); mesh.vertex_count()];
    let heights: Vec<f64> = (0..mesh.vertex_count())
        .map(|v| match ground.thickness[v] {
            Some(thickness) => continental_height(&constants.erosion, thickness),
            None => -sea_floor_depth(layout.age[v]),
        })
        .collect();
    let sea = Sea::for_land_share(&heights, &area, recipe.land_share);
    let mut ledger = Ledger::default();

    let rotations: Vec<DVec3> = (0..u64::from(recipe.plates))
        .map(|plate| {
            let mut rng = streams::stream(recipe.seed, Purpose::Rotations, 0, plate);
            let speed = FIRST_SPEEDS.start
                + (FIRST_SPEEDS.end - FIRST_SPEEDS.start) * streams::unit(&mut rng);
            streams::direction(&mut rng) * (speed / recipe.radius_km)
        })
        .collect();
    // A centre between two others may have got no ground.
    let mut ids = layout.plate.clone();
    ids.sort_unstable();
    ids.dedup();
    for id in ids {
        let rotation = rotations[usize::from(id.0) - 1];
        world.spawn((Plate { id }, Rotation(rotation), PlateBorn(0.0)));
    }
    let mut rows = Vec::with_capacity(mesh.vertex_count());
    for v in 0..mesh.vertex_count() {
        let site = mesh.site(v as u32);
        let (crust, thickness, age) = match ground.thickness[v] {
            Some(thickness) => {
                ledger.initial_km3 += thickness * cell;
                (Crust::Continental, thickness, ground.age[v])
            }
            None => (
                Crust::Oceanic,
                constants.ridges.oceanic_thickness,
                layout.age[v],
            ),
        };
        let rotation = rotations[usize::from(layout.plate[v].0) - 1];
        rows.push((
            SubPlate,
            Position(site.as_vec3()),
            Velocity((rotation.cross(site) * recipe.radius_km).as_vec3()),
            layout.plate[v],
            crust,
            Thickness(thickness),
            MaterialArea(cell),
            Created(-age as f32),
            Elevation((heights[v] - sea.level) as f32),
        ));
    }
    world.spawn_batch(rows);
    world.spawn_batch(HotSpot::scattered(recipe));
    let fastest = FIRST_SPEEDS.end;
    world.insert_resource(Clock {
        fastest,
        ..default()
    });
    world.insert_resource(NextPlateId(recipe.plates as u16 + 1));
    world.insert_resource(Topology(mesh));
    world.insert_resource(Splits {
        suspected: true,
        regrouped: true,
    });
    world.insert_resource(ledger);
    world.insert_resource(sea);
    let mut recipe = recipe.clone();
    events::sort(&mut recipe.events);
    world.insert_resource(recipe);
    world.insert_resource(EventLog::default());
    Ok(())
}

/// Fibonacci sphere (Yggdrasill): `y = 1 − 2i/(N − 1)`, `θ = 2π(2 − φ)i`, the index jittered, in an
/// order in which neighbours lie together in memory.
fn scatter(recipe: &Recipe) -> Vec<DVec3> {
    /// Largest shift along the spiral, in spacings. A fraction of an index turns θ by a large angle,
    /// so that index jitter must shrink with the spacing to keep the points apart.
    const JITTER: f64 = 0.35;
    let n = f64::from(recipe.sub_plates);
    let golden = core::f64::consts::TAU * (2.0 - 0.5 * (1.0 + 5.0_f64.sqrt()));
    let most = JITTER * (4.0 * core::f64::consts::PI / n).sqrt() / golden;
    let mut rng = streams::stream(recipe.seed, Purpose::Points, 0, 0);
    let points: Vec<DVec3> = (0..recipe.sub_plates)
        .map(|i| {
            let i = (f64::from(i) + most * streams::unit(&mut rng)).min(n - 1.0);
            let y = 1.0 - 2.0 * i / (n - 1.0);
            let ring = (1.0 - y * y).max(0.0).sqrt();
            let (sin, cos) = libm::sincos(golden * i);
            // What the mesh is built from is what the column can hold.
            DVec3::new(ring * cos, ring * sin, y)
                .as_vec3()
                .as_dvec3()
                .normalize()
        })
        .collect();
    hilbert_order(&points)
        .into_iter()
        .map(|i| points[i as usize])
        .collect()
}
