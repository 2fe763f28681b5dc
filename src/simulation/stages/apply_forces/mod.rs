//! Stage 4: what turns the plates, and what bends their margins.
//!
//! Slabs lengthen and decay ([`slabs`]). Then the recipe's [`Drive`] turns each plate as a rigid body:
//! a balance of the torques of all forces at the fronts ([`torque_balance`]) and of the slow convection
//! under continents ([`mantle`]), the mantle's flow
//! towards foundering sea floor ([`foundering`], its flow in [`foundering_flow`]), or rotations that plates
//! keep ([`prescribed`]). Fronts push the soft margins ([`margins`]), and [`springs`] hold them. Each is a system of its own in
//! [`TectonicSystems::ApplyForces`](super::super::TectonicSystems).

pub(in crate::simulation) mod drag;
pub(in crate::simulation) mod foundering;
pub(in crate::simulation) mod foundering_flow;
pub(in crate::simulation) mod mantle;
pub(in crate::simulation) mod margins;
pub(in crate::simulation) mod prescribed;
pub(in crate::simulation) mod slabs;
mod springs;
pub(in crate::simulation) mod torque_balance;

use super::super::recipe::{Drive, Recipe};
use bevy::prelude::*;

/// Whether one of these drives turns the plates: a condition of systems.
pub(in crate::simulation) fn driven_by(
    drives: &'static [Drive],
) -> impl Fn(Res<Recipe>) -> bool + Clone {
    move |recipe| drives.contains(&recipe.drive)
}
