//! A planet with rules of its own: a stage added between two others, and a stage replaced.
//!
//! ```sh
//! cargo run --release --example custom_stage
//! ```
//!
//! Hot spots stand still in the mantle while the plates drift over them, and each leaves a chain of
//! volcanoes that grows older with the distance, as Hawaii's does. The magma is kept in a component
//! that every sub-plate carries. In a second world the stage that wears mountains is replaced by
//! creep: rock slides downhill and nothing else happens to it.

use bevy::app::PluginGroup;
use bevy::prelude::*;
use bevy_tectonics::prelude::*;
use bevy_tectonics::simulation::{
    Clock, Columns, Created, Elevation, ErodePlugin, Ledger, MaterialArea, Sea, SubPlate,
    Thickness, Topology, Trench, record_failure, sea_floor_depth,
};
use core::ops::ControlFlow;
use glam::DVec3;

const SEED: u64 = 3;
const SUB_PLATES: u32 = 2_500;
const DURATION_MY: f64 = 80.0;

/// Magma that hot spots added to a sub-plate. Every sub-plate has it, new crust starts with none.
#[derive(Component, Debug, Clone, Copy, Default)]
struct HotSpotMagma {
    /// Thickness in km.
    km: f64,
    /// Thickness-weighted mean of the times at which it came, in My.
    mean_time_my: f64,
}

/// Hot spots: directions from the planet's centre that no plate carries along.
#[derive(Resource, Debug, Clone)]
struct HotSpots(Vec<DVec3>);

impl HotSpots {
    /// Reach of a hot spot in km. No less than a spacing, or it would miss most sub-plates.
    const REACH: f64 = 500.0;
    /// Growth of the crust right above one, in km/My.
    const RATE: f64 = 1.2;
}

struct HotSpotPlugin;

impl Plugin for HotSpotPlugin {
    fn build(&self, app: &mut App) {
        // Plugins are built before the planet is: the component is on every sub-plate there will be.
        app.register_required_components::<SubPlate, HotSpotMagma>()
            .insert_resource(HotSpots(vec![DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y]))
            .add_systems(
                TectonicStep,
                burn.pipe(record_failure)
                    .after(TectonicSystems::Move)
                    .before(TectonicSystems::Uplift),
            );
    }
}

/// Thickens the crust that lies above a hot spot.
fn burn(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    hot_spots: Res<HotSpots>,
    topology: Res<Topology>,
    mut ledger: ResMut<Ledger>,
    mut sub_plates: Query<
        (&Crust, &MaterialArea, &mut Thickness, &mut HotSpotMagma),
        With<SubPlate>,
    >,
) -> Result<(), TectonicError> {
    // Columns are slices over all sub-plates, indexed by the vertices of the mesh.
    let mesh = &topology.0;
    let (crust, area, mut thickness, mut magma) = sub_plates.columns(mesh.vertex_count())?;
    let thickness = thickness.bypass_change_detection();
    let magma = magma.bypass_change_detection();
    for v in 0..crust.len() {
        for &hot_spot in &hot_spots.0 {
            let near = mesh.site(v as u32).distance(hot_spot) * recipe.radius_km / HotSpots::REACH;
            let fresh = HotSpots::RATE * (1.0 - near * near).max(0.0) * clock.step_my;
            if fresh == 0.0 {
                continue;
            }
            thickness[v].0 += fresh;
            magma[v].km += fresh;
            magma[v].mean_time_my += (clock.time_my - magma[v].mean_time_my) * fresh / magma[v].km;
            // The ledger counts every cubic kilometre of continent.
            if crust[v].is_continental() {
                ledger.arc_magma_km3 += fresh * area[v].0;
            }
        }
    }
    Ok(())
}

/// Takes the place of [`ErodePlugin`]: rock creeps downhill. Whatever replaces that stage also
/// derives the elevations, because thickness and age are the state and heights follow from them.
struct CreepPlugin;

impl Plugin for CreepPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            TectonicStep,
            (
                creep.pipe(record_failure),
                derive_elevations.pipe(record_failure),
            )
                .chain()
                .in_set(TectonicSystems::Erode),
        );
    }
}

/// Moves continental rock from thick to thin sub-plates, volume for volume.
fn creep(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    topology: Res<Topology>,
    mut sub_plates: Query<(&Crust, &MaterialArea, &mut Thickness), With<SubPlate>>,
) -> Result<(), TectonicError> {
    /// Diffusivity in km²/My.
    const CREEP: f64 = 1_500.0;
    // Slow stages run every two million years and make up for the time since.
    let Some(time) = clock.geology.due() else {
        return Ok(());
    };
    let mesh = &topology.0;
    let (crust, area, mut thickness) = sub_plates.columns(mesh.vertex_count())?;
    let thickness = thickness.bypass_change_detection();
    let share = (CREEP * time / recipe.cell_area_km2()).min(0.1);
    for edge in mesh.edges() {
        let (u, v) = mesh.endpoints(edge);
        let (u, v) = (u as usize, v as usize);
        if crust[u].is_continental() && crust[v].is_continental() {
            let volume = share * (thickness[u].0 - thickness[v].0) * area[u].0.min(area[v].0);
            thickness[u].0 -= volume / area[u].0;
            thickness[v].0 += volume / area[v].0;
        }
    }
    Ok(())
}

type HeightColumns = (
    &'static Crust,
    &'static Thickness,
    &'static MaterialArea,
    &'static Created,
    &'static Trench,
    &'static mut Elevation,
);

/// Continents float, sea floor sinks with age, and the sea keeps its volume.
fn derive_elevations(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    topology: Res<Topology>,
    mut sea: ResMut<Sea>,
    mut sub_plates: Query<HeightColumns, With<SubPlate>>,
) -> Result<(), TectonicError> {
    if clock.geology.due().is_none() {
        return Ok(());
    }
    let (crust, thickness, area, created, trench, mut elevation) =
        sub_plates.columns(topology.0.vertex_count())?;
    let constants = &recipe.constants;
    let heights: Vec<f64> = (0..crust.len())
        .map(|v| {
            let normal = if crust[v].is_continental() {
                constants.erosion.reference_thickness
            } else {
                constants.ridges.oceanic_thickness
            };
            let floor = if crust[v].is_continental() {
                0.0
            } else {
                -sea_floor_depth(clock.time_my - f64::from(created[v].0))
            };
            floor + constants.erosion.isostasy * (thickness[v].0 - normal) - f64::from(trench[v].0)
        })
        .collect();
    sea.settle(&heights, area);
    let elevation = elevation.bypass_change_detection();
    for (elevation, height) in elevation.iter_mut().zip(heights) {
        elevation.0 = (height - sea.level) as f32;
    }
    Ok(())
}

fn main() -> Result<(), TectonicError> {
    let recipe = Recipe::earth_like(SEED)
        .with_sub_plates(SUB_PLATES)
        .with_duration(DURATION_MY);

    let plugins = SimulationPlugins.build().add(HotSpotPlugin);
    let mut rivers = History::with_plugins(recipe.clone(), plugins)?;
    rivers.run_until(DURATION_MY, |_| ControlFlow::Continue(()))?;
    rivers.check()?;
    print_chains(&mut rivers)?;

    let plugins = SimulationPlugins
        .build()
        .disable::<ErodePlugin>()
        .add(CreepPlugin)
        .add(HotSpotPlugin);
    let mut creeping = History::with_plugins(recipe, plugins)?;
    creeping.run_until(DURATION_MY, |_| ControlFlow::Continue(()))?;
    creeping.check()?;

    println!("\nThe same planet, worn in two ways for {DURATION_MY} My:\n");
    println!("           land   mean land   highest   continents");
    for (name, history) in [("rivers", &mut rivers), ("creep", &mut creeping)] {
        let figures = history.statistics()?;
        println!(
            "{name:<8} {:>4.0} % {:>9.0} m {:>7.0} m {:>9.1} km thick",
            100.0 * figures.land_share,
            figures.mean_land_m,
            figures.highest_m,
            figures.continental_thickness_km
        );
    }
    Ok(())
}

/// Prints what each hot spot left behind on the sea floor, the youngest volcanoes first.
fn print_chains(history: &mut History) -> Result<(), TectonicError> {
    let surface = history.surface()?;
    let hot_spots = history.world().resource::<HotSpots>().0.clone();
    let world = history.world_mut();
    let mut magma = world.query_filtered::<&HotSpotMagma, With<SubPlate>>();
    // Queries run through the one table of sub-plates in the order of the mesh's vertices.
    let magma: Vec<HotSpotMagma> = magma.iter(world).copied().collect();

    let mut chains: Vec<Vec<(f64, f64, usize)>> = vec![Vec::new(); hot_spots.len()];
    for (v, magma) in magma.iter().enumerate() {
        if magma.km < 4.0 || surface.crust[v].is_continental() {
            continue;
        }
        let site = surface.mesh.site(v as u32);
        let distance = |spot: &DVec3| site.angle_between(*spot) * surface.radius_km;
        let (spot, km) = hot_spots
            .iter()
            .map(distance)
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or_default();
        chains[spot].push((surface.time_my - magma.mean_time_my, km, v));
    }
    println!("Volcanoes that the hot spots left on the sea floor:\n");
    for (spot, chain) in chains.iter_mut().enumerate() {
        chain.sort_by(|a, b| a.0.total_cmp(&b.0));
        println!("hot spot {}: {} volcanoes", spot + 1, chain.len());
        for &(age, km, v) in chain.iter() {
            println!(
                "  {age:>5.1} My old, {km:>5.0} km away on plate {:>2}, {:>4.1} km of magma, top at {:>6.0} m",
                surface.plate[v], magma[v].km, surface.elevation[v]
            );
        }
    }
    Ok(())
}
