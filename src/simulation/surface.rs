//! An immutable copy of a planet's surface: what games query, renderers draw and exports write.

mod kept;
mod kinds;

pub(crate) use kept::{Ball, Kept, SegmentTree, Starts};
pub use kept::{BoundarySegment, PlateSummary};

use super::{
    boundaries::Contacts,
    check::run,
    clock::Clock,
    columns::Columns,
    error::TectonicError,
    hot_spot::HotSpot,
    plate::{Plate, PlateBorn, PlateTable, Rotation},
    recipe::Recipe,
    sub_plate::*,
    topology::{BoundaryKind, Topology},
};
use crate::mesh::SphereMesh;
use bevy::prelude::*;
use glam::{DVec3, Vec3};
use kinds::Margins;

/// A planet at one moment. Vectors are indexed by the mesh's vertices, one value per sub-plate, unless
/// they say otherwise.
///
/// What can be asked of it is told in [`surface`](crate::surface). Answers rest on what is worked out
/// once and kept: to change a planet, change a clone before it is asked anything.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Time since the start in My.
    pub time_my: f64,
    /// Radius in km.
    pub radius_km: f64,
    /// Seed of the recipe, for detail that must not change from snapshot to snapshot.
    pub seed: u64,
    /// Places of the sub-plates and their Delaunay triangulation.
    pub mesh: SphereMesh,
    /// Elevation in m above the sea.
    pub elevation: Vec<f32>,
    /// Kind of crust.
    pub crust: Vec<Crust>,
    /// Age of the crust in My.
    pub age: Vec<f32>,
    /// Id of the plate, 0 = none.
    pub plate: Vec<u16>,
    /// Velocity in km/My (= mm/yr), tangent.
    pub velocity: Vec<Vec3>,
    /// Thickness of the crust in km.
    pub thickness: Vec<f32>,
    /// Kind of the last mountain building.
    pub orogeny: Vec<Orogeny>,
    /// Time since the last mountain building in My; that of the crust where there was none.
    pub orogeny_age: Vec<f32>,
    /// Direction across which the crust was folded: tangent, longer where folding went on longer; zero where it
    /// never did.
    pub fold: Vec<Vec3>,
    /// Strike of the ridge that made the crust: a unit tangent; zero where none did.
    pub ridge: Vec<Vec3>,
    /// Time since a hot spot last fed the crust in My; none where none ever did.
    pub volcanism_age: Vec<Option<f32>>,
    /// Hot spots, in the order of their ids.
    pub hot_spots: Vec<HotSpot>,
    /// Kind of boundary per *edge number* of the mesh: from the plate at the edge's first end to that at
    /// its second. `Joined` within plates, and only there.
    pub boundary: Vec<BoundaryKind>,
    /// Per *plate*, in the order of ids: the id and the angular velocity in rad/My.
    pub rotations: Vec<(u16, DVec3)>,
    /// What queries keep.
    pub(crate) kept: Kept,
}

impl Surface {
    /// Copies the surface out of a simulation world.
    ///
    /// # Errors
    /// [`TectonicError::Archetype`] if the sub-plates no longer lie in one table.
    pub fn capture(world: &mut World) -> Result<Self, TectonicError> {
        run(world, capture)
    }

    /// Nominal spacing of the sub-plates in km.
    #[must_use]
    pub fn spacing_km(&self) -> f64 {
        self.radius_km
            * (4.0 * core::f64::consts::PI / self.mesh.vertex_count().max(1) as f64).sqrt()
    }
}

type SurfaceColumns = (
    &'static Elevation,
    &'static Crust,
    &'static Created,
    &'static PlateId,
    &'static Velocity,
    &'static Thickness,
    &'static Orogeny,
    &'static OrogenyBegan,
    &'static Volcanism,
    &'static FoldDirection,
    &'static RidgeDirection,
);

fn capture(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    topology: Res<Topology>,
    contacts: Res<Contacts>,
    plates: Query<(Entity, &Plate, &Rotation, &PlateBorn)>,
    hot_spots: Query<&HotSpot>,
    mut sub_plates: Query<SurfaceColumns, With<SubPlate>>,
) -> Result<Surface, TectonicError> {
    let mesh = &topology.0;
    let (
        elevation,
        crust,
        created,
        plate,
        velocity,
        thickness,
        orogeny,
        began,
        volcanism,
        fold,
        ridge,
    ) = sub_plates.columns(mesh.vertex_count())?;
    let plates = PlateTable::gather(plates.iter());
    let margins = Margins {
        mesh,
        plate,
        crust,
        created,
        plates: &plates,
        contacts: &contacts,
        recipe: &recipe,
    };
    let since = |time: f32| (clock.time_my - f64::from(time)).max(0.0) as f32;
    Ok(Surface {
        time_my: clock.time_my,
        radius_km: recipe.radius_km,
        seed: recipe.seed,
        mesh: mesh.without_payload(),
        elevation: elevation.iter().map(|elevation| elevation.0).collect(),
        crust: crust.to_vec(),
        age: created.iter().map(|created| since(created.0)).collect(),
        plate: plate.iter().map(|plate| plate.0).collect(),
        velocity: velocity.iter().map(|velocity| velocity.0).collect(),
        thickness: thickness
            .iter()
            .map(|thickness| thickness.0 as f32)
            .collect(),
        orogeny: orogeny.to_vec(),
        orogeny_age: orogeny
            .iter()
            .zip(began.iter().zip(created))
            .map(|(kind, (began, created))| {
                since(if *kind == Orogeny::None {
                    created.0
                } else {
                    began.0
                })
            })
            .collect(),
        fold: fold.iter().map(|fold| fold.0).collect(),
        ridge: ridge.iter().map(|ridge| ridge.0).collect(),
        volcanism_age: volcanism
            .iter()
            .map(|volcanism| volcanism.last_my.map(since))
            .collect(),
        hot_spots: HotSpot::in_order(&hot_spots),
        boundary: margins.kinds(),
        rotations: plates
            .rows()
            .iter()
            .map(|plate| (plate.id.0, plate.rotation))
            .collect(),
        kept: Kept::default(),
    })
}
