//! The sub-plate: one vertex of the mesh, one entity, one row of every column.

use bevy::ecs::{lifecycle::HookContext, world::DeferredWorld};
use bevy::prelude::*;
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Marks a sub-plate. Row number in the table = vertex number of the mesh.
///
/// Components of your own belong on every sub-plate from the start: register them with
/// `world.register_required_components::<SubPlate, Mine>()` before the history begins. Rows are sorted now and
/// then: with such a component the entity is the sub-plate for good, without one its values move to another
/// entity, which is some four times faster, and `Added` and `Changed` do not move with them. So to know a sub-plate
/// again, give it a component.
#[derive(Component, Debug, Clone, Copy, Default, Reflect)]
#[reflect(Component, Default)]
#[require(
    Position,
    Velocity,
    Deviation,
    PlateId,
    Crust,
    Elevation,
    Thickness,
    MaterialArea,
    Created,
    Orogeny,
    OrogenyBegan,
    FoldDirection,
    RidgeDirection,
    Slab,
    Trench,
    Volcanism
)]
#[component(on_add = join_table)]
pub struct SubPlate;

/// Marks all sub-plates or none: which, alternates whenever sub-plates with components of users are sorted.
#[derive(Component, Debug, Clone, Copy)]
pub(super) struct Sorted;

/// Whether the sub-plates carry [`Sorted`] now.
#[derive(Resource, Debug, Clone, Copy, Default)]
pub(super) struct SortedTable(pub bool);

/// New sub-plates go where the others are.
fn join_table(mut world: DeferredWorld, context: HookContext) {
    if world
        .get_resource::<SortedTable>()
        .is_some_and(|table| table.0)
    {
        world.commands().entity(context.entity).insert(Sorted);
    }
}

/// Place on the sphere as a unit vector: the mesh's site, rounded, which the stages write after every change.
/// To move a sub-plate, set its [`Deviation`].
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct Position(pub Vec3);

/// Velocity in km/My (= mm/yr), tangent to the sphere.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct Velocity(pub Vec3);

/// Part of the velocity that departs from the plate's rigid rotation, in km/My. Zero outside the
/// soft margins.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct Deviation(pub Vec3);

/// Id of the plate that carries the sub-plate; 0 = none.
#[derive(
    Component,
    Debug,
    Clone,
    Copy,
    Default,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Serialize,
    Deserialize,
    Reflect,
)]
#[reflect(Component, Default)]
pub struct PlateId(pub u16);

/// Kind of crust.
#[derive(
    Component, Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, Reflect,
)]
#[reflect(Component, Default)]
#[repr(u8)]
pub enum Crust {
    /// Basaltic, thin, dense; made at ridges and lost at trenches.
    #[default]
    Oceanic,
    /// Granitic, thick, buoyant; never lost.
    Continental,
}

impl Crust {
    /// Whether the crust is continental.
    #[must_use]
    pub fn is_continental(self) -> bool {
        self == Self::Continental
    }
}

/// Elevation in m above the sea.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct Elevation(pub f32);

/// Thickness of the crust in km. f64, because the ledger must close over thousands of steps.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct Thickness(pub f64);

/// Area of the crust that the sub-plate stands for, in km². Thickness × area is its volume;
/// deformation changes both and keeps the product.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct MaterialArea(pub f64);

/// When the crust was made, in My on the planet's clock (negative: before the start).
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct Created(pub f32);

/// Kind of the last mountain building.
#[derive(
    Component, Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, Reflect,
)]
#[reflect(Component, Default)]
#[repr(u8)]
pub enum Orogeny {
    /// None in its history.
    #[default]
    None,
    /// By subduction under the plate.
    Andean,
    /// By collision of continents.
    Himalayan,
}

/// When the last mountain building was active, in My on the planet's clock.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct OrogenyBegan(pub f32);

/// Direction across which the crust was folded: a tangent vector, longer where folding went on
/// longer (Cortial et al. 2019, `f ← f + β(sᵢ − sⱼ)δt`).
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct FoldDirection(pub Vec3);

/// Strike of the ridge that made the crust: a unit tangent vector; zero where none did.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct RidgeDirection(pub Vec3);

/// Length of slab that hangs beneath an overriding front, in km.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct Slab(pub f32);

/// Depth by which a trench bends the crust down, in m.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct Trench(pub f32);

/// What hot spots have left on the crust.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct Volcanism {
    /// Part of the thickness of oceanic crust that is a hot spot's lava, in km.
    pub pile_km: f32,
    /// When a hot spot last fed the crust, in My on the planet's clock; none if none ever did.
    pub last_my: Option<f32>,
}

impl Volcanism {
    /// What is left where crust of this and of another sub-plate is mixed, given their areas in km².
    #[must_use]
    pub(crate) fn mixed(self, area: f64, other: Self, other_area: f64) -> Self {
        let pile = f64::from(self.pile_km) * area + f64::from(other.pile_km) * other_area;
        Self {
            pile_km: (pile / (area + other_area).max(f64::MIN_POSITIVE)) as f32,
            last_my: match (self.last_my, other.last_my) {
                (Some(one), Some(two)) => Some(one.max(two)),
                (one, two) => one.or(two),
            },
        }
    }
}
