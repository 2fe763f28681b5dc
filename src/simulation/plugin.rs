//! Plugins: one for what all stages share, one per stage, and the group of them all.

use super::{
    boundaries::{Boundaries, Contacts, FrontForces, Unsettled},
    clock::Clock,
    events::{EventLog, HeldMotion},
    hot_spot::HotSpot,
    ledger::Ledger,
    plate::{DrivingTorque, NextPlateId, Plate, PlateArea, PlateBorn, Rotation},
    recipe::{Drive, Recipe},
    schedule::{
        self, Cancellation, StageTimings, StepFailure, TectonicStep, TectonicSystems,
        record_failure,
    },
    sea::Sea,
    stages::{apply_forces::driven_by, *},
    statistics::StatisticsPlugin,
    sub_plate::*,
    workers::Workers,
};
use bevy::app::PluginGroupBuilder;
use bevy::prelude::*;

/// The whole simulation. [`History`](super::History) puts it into a world of its own, fills that world
/// from a recipe and keeps its clock.
///
/// | plugin | stage |
/// |---|---|
/// | [`SimulationPlugin`] | components, resources, the [`TectonicStep`] schedule |
/// | [`ApplyEventsPlugin`] | scripted events |
/// | [`RefinePlugin`] | cells split and merge; rows in the order of the planet |
/// | [`ClassifyBoundariesPlugin`] | fronts and their kinds |
/// | [`CreateCrustPlugin`] | ridges and tearing rifts |
/// | [`ApplyForcesPlugin`] | slabs, torque balance, soft margins |
/// | [`MovePlugin`] | sub-plates move |
/// | [`UpliftPlugin`] | arcs, trenches, plateaus, islands over hot spots |
/// | [`ResolveCollisionsPlugin`] | subduction and crushing |
/// | [`RepairMeshPlugin`] | Delaunay, slivers |
/// | [`ErodePlugin`] | wear, sediment, isostasy, sea |
/// | [`ReorganizePlatesPlugin`] | sutures, rifts, new trenches, splinters |
/// | [`StatisticsPlugin`] | after the stages, if an interval is set: measures |
///
/// Every stage can be left out or replaced:
/// `SimulationPlugins.build().disable::<ErodePlugin>().add(MyErosion)`. The mesh stays valid only
/// with `MovePlugin`, `ResolveCollisionsPlugin` and `RepairMeshPlugin` (or their like) in place.
#[derive(Debug, Clone, Copy, Default)]
pub struct SimulationPlugins;

impl PluginGroup for SimulationPlugins {
    fn build(self) -> PluginGroupBuilder {
        PluginGroupBuilder::start::<Self>()
            .add(SimulationPlugin)
            .add(ApplyEventsPlugin)
            .add(RefinePlugin)
            .add(ClassifyBoundariesPlugin)
            .add(CreateCrustPlugin)
            .add(ApplyForcesPlugin)
            .add(MovePlugin)
            .add(UpliftPlugin)
            .add(ResolveCollisionsPlugin)
            .add(RepairMeshPlugin)
            .add(ErodePlugin)
            .add(ReorganizePlatesPlugin)
            .add(StatisticsPlugin::default())
    }
}

/// What all stages share: types, resources and the schedule of the step.
#[derive(Debug, Clone, Copy, Default)]
pub struct SimulationPlugin;

impl Plugin for SimulationPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<AppTypeRegistry>()
            .register_type::<SubPlate>()
            .register_type::<Position>()
            .register_type::<Velocity>()
            .register_type::<Deviation>()
            .register_type::<PlateId>()
            .register_type::<Crust>()
            .register_type::<Elevation>()
            .register_type::<Thickness>()
            .register_type::<MaterialArea>()
            .register_type::<Created>()
            .register_type::<Orogeny>()
            .register_type::<OrogenyBegan>()
            .register_type::<FoldDirection>()
            .register_type::<RidgeDirection>()
            .register_type::<Slab>()
            .register_type::<Trench>()
            .register_type::<Volcanism>()
            .register_type::<HotSpot>()
            .register_type::<HeldMotion>()
            .register_type::<Plate>()
            .register_type::<Rotation>()
            .register_type::<PlateArea>()
            .register_type::<PlateBorn>()
            .register_type::<DrivingTorque>()
            .register_type::<NextPlateId>()
            .register_type::<Recipe>()
            .register_type::<Clock>()
            .register_type::<Ledger>()
            .register_type::<Sea>()
            .register_type::<Mantle>()
            .init_resource::<Boundaries>()
            .init_resource::<Contacts>()
            .init_resource::<FrontForces>()
            .init_resource::<Unsettled>()
            .init_resource::<SortedTable>()
            .init_resource::<EventLog>()
            .init_resource::<StepFailure>()
            .init_resource::<Cancellation>()
            .init_resource::<StageTimings>()
            .init_resource::<Workers>();
        schedule::configure(app);
    }
}

/// Declares the plugin of a stage: its systems, chained in their set.
macro_rules! stage {
    ($(#[$doc:meta])* $plugin:ident, $set:ident, [$($system:expr),+ $(,)?]) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, Default)]
        pub struct $plugin;

        impl Plugin for $plugin {
            fn build(&self, app: &mut App) {
                app.add_systems(TectonicStep, ($($system,)+).chain().in_set(TectonicSystems::$set));
            }
        }
    };
}

/// Before stage 1: the recipe's events, see [`TectonicSystems::ApplyEvents`]. Between `ApplyForces` and
/// `Move`, plates are kept to the motions that events hold them to, whatever drive took the place of stage 4.
#[derive(Debug, Clone, Copy, Default)]
pub struct ApplyEventsPlugin;

impl Plugin for ApplyEventsPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            TectonicStep,
            (
                apply_events::apply_events
                    .pipe(record_failure)
                    .in_set(TectonicSystems::ApplyEvents)
                    // It takes the whole world, which is no reason against systems of one's own here.
                    .ambiguous_with_all(),
                apply_events::hold_motions
                    .after(TectonicSystems::ApplyForces)
                    .before(TectonicSystems::Move),
            ),
        );
    }
}

stage!(
    /// Stage 1, see [`TectonicSystems::Refine`].
    RefinePlugin, Refine,
    [
        refine::refine.pipe(record_failure),
        resolve_collisions::close_ranks,
        sort_rows::sort_rows,
    ]
);
stage!(
    /// Stage 2, see [`TectonicSystems::ClassifyBoundaries`].
    ClassifyBoundariesPlugin, ClassifyBoundaries,
    [classify_boundaries::classify_boundaries.pipe(record_failure)]
);
stage!(
    /// Stage 3, see [`TectonicSystems::CreateCrust`].
    CreateCrustPlugin, CreateCrust,
    [create_crust::create_crust.pipe(record_failure)]
);
stage!(
    /// Stage 4, see [`TectonicSystems::ApplyForces`].
    ApplyForcesPlugin, ApplyForces,
    [
        apply_forces::slabs::grow_slabs.pipe(record_failure),
        apply_forces::mantle::convect_mantle
            .pipe(record_failure)
            .run_if(driven_by(&[Drive::Soft, Drive::Rigid])),
        apply_forces::torque_balance::balance_torques
            .pipe(record_failure)
            .run_if(driven_by(&[Drive::Soft, Drive::Rigid])),
        apply_forces::foundering::follow_mantle
            .pipe(record_failure)
            .run_if(driven_by(&[Drive::Foundering])),
        apply_forces::prescribed::turn_axes
            .pipe(record_failure)
            .run_if(driven_by(&[Drive::Prescribed])),
        // Margins yield to how plates turn indeed.
        apply_events::hold_motions,
        apply_forces::margins::bend_margins.pipe(record_failure),
    ]
);
stage!(
    /// Stage 5, see [`TectonicSystems::Move`].
    MovePlugin, Move,
    [motion::move_sub_plates.pipe(record_failure)]
);
stage!(
    /// Stage 6, see [`TectonicSystems::Uplift`].
    UpliftPlugin, Uplift,
    [
        uplift::uplift.pipe(record_failure),
        hot_spots::feed_islands.pipe(record_failure),
        hot_spots::wear_islands.pipe(record_failure),
    ]
);
stage!(
    /// Stage 7, see [`TectonicSystems::ResolveCollisions`].
    ResolveCollisionsPlugin, ResolveCollisions,
    [
        resolve_collisions::resolve_collisions.pipe(record_failure),
        resolve_collisions::close_ranks,
    ]
);
stage!(
    /// Stage 8, see [`TectonicSystems::RepairMesh`].
    RepairMeshPlugin, RepairMesh,
    [repair_mesh::repair_mesh.pipe(record_failure)]
);
stage!(
    /// Stage 9, see [`TectonicSystems::Erode`].
    ErodePlugin, Erode,
    [erode::erode.pipe(record_failure), erode::settle.pipe(record_failure)]
);
stage!(
    /// Stage 10, see [`TectonicSystems::ReorganizePlates`].
    ReorganizePlatesPlugin, ReorganizePlates,
    [
        reorganize_plates::fronts::smooth_fronts.pipe(record_failure),
        reorganize_plates::suture::suture.pipe(record_failure),
        reorganize_plates::rift::rift
            .pipe(record_failure)
            .run_if(driven_by(&[Drive::Soft, Drive::Rigid, Drive::Prescribed])),
        reorganize_plates::founder::founder
            .pipe(record_failure)
            .run_if(driven_by(&[Drive::Soft, Drive::Rigid, Drive::Prescribed])),
        reorganize_plates::segment::segment
            .pipe(record_failure)
            .run_if(driven_by(&[Drive::Foundering])),
        reorganize_plates::basins::fill_basins.pipe(record_failure),
        reorganize_plates::splinters::absorb_splinters.pipe(record_failure),
        motion::follow_plates.pipe(record_failure),
    ]
);
