//! Stage 4: what turns the plates, and what bends their margins.
//!
//! Slabs lengthen and decay ([`slabs`]); all forces at the fronts go into one balance of torques that
//! turns each plate as a rigid body ([`torque_balance`]); springs hold the soft margins ([`margins`]).
//! Each is a system of its own in [`TectonicSystems::ApplyForces`](super::super::TectonicSystems).

pub(in crate::simulation) mod mantle;
pub(in crate::simulation) mod margins;
pub(in crate::simulation) mod slabs;
pub(in crate::simulation) mod torque_balance;
