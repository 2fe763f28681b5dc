//! Planets of two plates whose motion is known: the hemispheres on either side of the plane y = 0.

use bevy::app::{PluginGroup, PluginGroupBuilder};
use bevy::prelude::*;
use bevy_tectonics::prelude::*;
use bevy_tectonics::simulation::{
    ApplyForcesPlugin, Created, Ledger, MaterialArea, Plate, PlateId, Rotation, Splits, SubPlate,
    Thickness, Topology,
};
use glam::DVec3;

/// The plate at y < 0.
pub const SOUTH: PlateId = PlateId(1);
/// The plate at y > 0.
pub const NORTH: PlateId = PlateId(2);

/// Ground of one sub-plate.
#[derive(Debug, Clone, Copy)]
pub struct Ground {
    pub crust: Crust,
    pub thickness_km: f64,
    pub created_my: f32,
}

pub const SEA_FLOOR: Ground = Ground {
    crust: Crust::Oceanic,
    thickness_km: 7.0,
    created_my: -50.0,
};

pub const CONTINENT: Ground = Ground {
    crust: Crust::Continental,
    thickness_km: 35.0,
    created_my: -1000.0,
};

/// A recipe of two plates on which nothing happens by chance.
pub fn recipe(sub_plates: u32) -> Recipe {
    let mut recipe = Recipe {
        plates: 2,
        hot_spots: 0,
        ..Recipe::earth_like(1)
            .with_sub_plates(sub_plates)
            .with_duration(1000.0)
    };
    let plates = &mut recipe.constants.plates;
    plates.rift_rate = 0.0;
    plates.founder_age = 500.0;
    plates.basin = 0.0;
    recipe
}

/// All stages but the one that would change the plates' rotations.
pub fn steady() -> PluginGroupBuilder {
    SimulationPlugins.build().disable::<ApplyForcesPlugin>()
}

/// Lays plates and ground anew on a planet of two plates and sets their rotations, in rad/My.
pub fn arrange(
    history: &mut History,
    rotations: [DVec3; 2],
    ground: impl Fn(PlateId, DVec3) -> Ground,
) {
    let world = history.world_mut();
    let sites = world.resource::<Topology>().0.sites().to_vec();
    let mut volume = 0.0;
    let mut sub_plates = world.query_filtered::<(
        &mut PlateId,
        &mut Crust,
        &mut Thickness,
        &mut Created,
        &MaterialArea,
    ), With<SubPlate>>();
    for (site, (mut plate, mut crust, mut thickness, mut created, area)) in
        sites.into_iter().zip(sub_plates.iter_mut(world))
    {
        *plate = if site.y < 0.0 { SOUTH } else { NORTH };
        let ground = ground(*plate, site);
        *crust = ground.crust;
        thickness.0 = ground.thickness_km;
        created.0 = ground.created_my;
        if crust.is_continental() {
            volume += thickness.0 * area.0;
        }
    }
    world.insert_resource(Ledger {
        initial_km3: volume,
        ..default()
    });
    turn(history, rotations);
    let mut splits = history.world_mut().resource_mut::<Splits>();
    splits.suspected = true;
    splits.regrouped = true;
}

/// Sets the rotations of both plates.
pub fn turn(history: &mut History, rotations: [DVec3; 2]) {
    let world = history.world_mut();
    let mut plates = world.query::<(&Plate, &mut Rotation)>();
    for (plate, mut rotation) in plates.iter_mut(world) {
        rotation.0 = rotations[usize::from(plate.id.0) - 1];
    }
}

/// Every component of one kind, in the order of the mesh's vertices.
pub fn column<T: Component + Clone>(history: &mut History) -> Vec<T> {
    let world = history.world_mut();
    let mut column = world.query_filtered::<&T, With<SubPlate>>();
    column.iter(world).cloned().collect()
}

/// Runs this much further, with a check after every step.
pub fn run(history: &mut History, time_my: f64) {
    let end = history.time_my() + time_my;
    while history.time_my() < end {
        history.step().unwrap();
        history.check().unwrap();
    }
}
