//! From a recipe to the first moment of a world.

mod column;
mod continents;
mod flood_fill;
mod great_circles;
mod hypsometry;
mod image;
mod imported;
mod outlines;
mod relief;
mod voronoi;

pub use column::Column;
pub use hypsometry::{Hypsometry, Normal, Normals};
pub use imported::{
    EulerRotation, HeightMap, ImageStart, ImportedPlate, ImportedWorld, PlatePolygon,
};

use super::{
    clock::{Clock, Tick},
    error::TectonicError,
    events::{self, EventLog},
    hot_spot::HotSpot,
    ledger::Ledger,
    plate::{NextPlateId, Plate, PlateBorn, Rotation},
    recipe::{Recipe, Start},
    sea::Sea,
    stages::{
        Mantle, Splits,
        erode::{continental_height, continental_rise, sea_floor_height},
    },
    streams::{self, Purpose},
    sub_plate::*,
    topology::{EdgeState, Topology},
    workers::Workers,
};
use crate::mesh::{SphereMesh, hilbert_order};
use bevy::prelude::*;
use glam::DVec3;
use relief::Ground;

/// Speeds of the first plates in km/My; the torque balance takes over within a few My.
const FIRST_SPEEDS: core::ops::Range<f64> = 10.0..60.0;

/// Which plate each sub-plate belongs to, and how old its sea floor is.
struct Layout {
    plate: Vec<PlateId>,
    /// Age of the sea floor in My, as if there were no continents.
    age: Vec<f64>,
}

/// The first moment of every sub-plate.
struct Moment {
    plate: Vec<PlateId>,
    ground: Ground,
    sea: Sea,
    /// Angular velocities in rad/My, by id from 1 on, if the start says any.
    rotations: Option<Vec<DVec3>>,
}

/// Fills a world that has [`SimulationPlugins`](super::SimulationPlugins) with the first moment of a
/// planet. From then on every run of [`TectonicStep`](super::TectonicStep) is a step of its history.
/// [`History`](super::History) does this for you in a world of its own.
///
/// # Errors
/// [`TectonicError::Recipe`] for an invalid recipe, [`TectonicError::Build`] if the points cannot be
/// triangulated, [`TectonicError::Import`] if an imported start is not there, as the resource
/// [`ImportedWorld`], or cannot be used; the world is then as it was.
pub fn populate(world: &mut World, recipe: &Recipe) -> Result<(), TectonicError> {
    recipe.validate()?;
    let sites = scatter(recipe);
    let mesh = SphereMesh::<EdgeState>::build(sites)
        .map_err(|error| TectonicError::Build(error.to_string()))?;
    let cell = recipe.cell_area_km2();
    let area = vec![MaterialArea(cell); mesh.vertex_count()];
    let moment = match &recipe.start {
        Start::FloodFill => cratons(recipe, &mesh, flood_fill::lay_out(recipe, &mesh), &area),
        Start::Voronoi => cratons(recipe, &mesh, voronoi::lay_out(recipe, &mesh), &area),
        Start::Hypsometric(hypsometry) => hypsometric(recipe, &mesh, hypsometry, &area),
        Start::Image(image) => imported(recipe, &mesh, image, world.get_resource(), &area)?,
    };
    let mut ledger = Ledger::default();

    let rotations = match moment.rotations {
        Some(rotations) => rotations,
        None => first_rotations(recipe),
    };
    // A centre between two others may have got no ground.
    let mut ids = moment.plate.clone();
    ids.sort_unstable();
    ids.dedup();
    for id in ids {
        let rotation = rotations[usize::from(id.0) - 1];
        world.spawn((Plate { id }, Rotation(rotation), PlateBorn(0.0)));
    }
    let mut fastest = FIRST_SPEEDS.end;
    let mut rows = Vec::with_capacity(mesh.vertex_count());
    for v in 0..mesh.vertex_count() {
        let site = mesh.site(v as u32);
        let (crust, thickness) = (moment.ground.crust[v], moment.ground.thickness[v]);
        if crust.is_continental() {
            ledger.initial_km3 += thickness * cell;
        }
        let rotation = rotations[usize::from(moment.plate[v].0) - 1];
        let velocity = rotation.cross(site) * recipe.radius_km;
        fastest = fastest.max(velocity.length());
        rows.push((
            SubPlate,
            Position(site.as_vec3()),
            Velocity(velocity.as_vec3()),
            moment.plate[v],
            crust,
            Thickness(thickness),
            MaterialArea(cell),
            Created(-moment.ground.age[v] as f32),
            Elevation((moment.ground.heights[v] - moment.sea.level) as f32),
        ));
    }
    world.spawn_batch(rows);
    world.spawn_batch(HotSpot::scattered(recipe));
    let constants = &recipe.constants;
    world.insert_resource(Clock {
        fastest,
        // Slow stages in turn, so that no step has to wait for all of them.
        reorganisation: Tick::after(0.25 * constants.step.reorganisation),

        ..default()
    });
    world.insert_resource(NextPlateId(rotations.len() as u16 + 1));
    world.insert_resource(Topology(mesh));
    world.insert_resource(Splits {
        suspected: true,
        regrouped: true,
        ..default()
    });
    world.insert_resource(Mantle::new(recipe.seed));
    world.insert_resource(ledger);
    world.insert_resource(moment.sea);
    let mut recipe = recipe.clone();
    events::sort(&mut recipe.events);
    world.insert_resource(recipe);
    world.insert_resource(EventLog::default());
    // Its heights are no longer needed.
    world.remove_resource::<ImportedWorld>();
    Ok(())
}

/// Rotations about random poles, by plate.
fn first_rotations(recipe: &Recipe) -> Vec<DVec3> {
    (0..u64::from(recipe.plates))
        .map(|plate| {
            let mut rng = streams::stream(recipe.seed, Purpose::Rotations, 0, plate);
            let speed = FIRST_SPEEDS.start
                + (FIRST_SPEEDS.end - FIRST_SPEEDS.start) * streams::unit(&mut rng);
            streams::direction(&mut rng) * (speed / recipe.radius_km)
        })
        .collect()
}

/// Cratons, blind to the plates, and a sea that leaves the wanted share dry.
fn cratons(
    recipe: &Recipe,
    mesh: &SphereMesh<EdgeState>,
    layout: Layout,
    area: &[MaterialArea],
) -> Moment {
    let continents = continents::lay(recipe, mesh);
    let constants = &recipe.constants;
    let floor = constants.ridges.oceanic_thickness;
    let mut ground = Ground {
        crust: vec![Crust::Oceanic; layout.plate.len()],
        thickness: vec![floor; layout.plate.len()],
        heights: Vec::new(),
        age: layout.age,
    };
    for (v, thickness) in continents.thickness.into_iter().enumerate() {
        if let Some(thickness) = thickness {
            ground.crust[v] = Crust::Continental;
            ground.thickness[v] = thickness;
            ground.age[v] = continents.age[v];
        }
    }
    let rise = continental_rise(
        recipe,
        &Workers::default(),
        mesh,
        &layout.plate,
        &ground.crust,
    );
    ground.heights = (0..rise.len())
        .map(|v| {
            if ground.crust[v].is_continental() {
                continental_height(&constants.erosion, ground.thickness[v])
            } else {
                sea_floor_height(recipe, ground.age[v], floor, rise[v], 0.0)
            }
        })
        .collect();
    Moment {
        sea: Sea::for_land_share(&ground.heights, area, recipe.land_share),
        plate: layout.plate,
        ground,
        rotations: None,
    }
}

/// A surface with a wanted hypsometry. Plates are flooded from random seeds, blind to the continents:
/// they come in unequal sizes and most carry both kinds of crust. Tectonics.js takes them from the
/// age of the sea floor, which here follows from the depths that were drawn and has no history yet.
fn hypsometric(
    recipe: &Recipe,
    mesh: &SphereMesh<EdgeState>,
    hypsometry: &Hypsometry,
    area: &[MaterialArea],
) -> Moment {
    let elevations = great_circles::elevations(recipe, hypsometry, mesh);
    let crust = elevations
        .iter()
        .map(|&elevation| Column::at(elevation).crust())
        .collect();
    let plate = flood_fill::lay_out(recipe, mesh).plate;
    let ground = relief::raise(recipe, mesh, &plate, &elevations, crust);
    Moment {
        sea: Sea::at_level(&ground.heights, area, 0.0),
        plate,
        ground,
        rotations: None,
    }
}

/// What was read from a map.
fn imported(
    recipe: &Recipe,
    mesh: &SphereMesh<EdgeState>,
    image: &ImageStart,
    world: Option<&ImportedWorld>,
    area: &[MaterialArea],
) -> Result<Moment, TectonicError> {
    let Some(world) = world else {
        return Err(TectonicError::import(
            image.heights.as_str(),
            "it was not read",
            "read by the cargo feature `import`, or handed over to `History::imported`",
        ));
    };
    let image::Imported {
        plate,
        ground,
        rotations,
    } = image::lay_out(recipe, image, world, mesh)?;
    Ok(Moment {
        sea: Sea::at_level(&ground.heights, area, 0.0),
        plate,
        ground,
        rotations,
    })
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
