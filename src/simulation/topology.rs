//! The mesh of a world, and what its edges carry.

use crate::mesh::{EdgePayload, SphereMesh};
use bevy::prelude::*;

/// Kind of boundary that an edge crosses (Yggdrasill's five, and none).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Reflect)]
#[repr(u8)]
pub enum BoundaryKind {
    /// Both ends lie on one plate.
    #[default]
    Joined,
    /// The plates slide past each other, or rest.
    Transform,
    /// The plates part.
    Ridge,
    /// The plate at the edge's first end goes under.
    SubductingOrigin,
    /// The plate at the edge's second end goes under.
    SubductingDestination,
    /// Continents meet.
    Collision,
}

impl BoundaryKind {
    /// Whether crust goes under here.
    #[must_use]
    pub fn is_subducting(self) -> bool {
        matches!(self, Self::SubductingOrigin | Self::SubductingDestination)
    }

    /// The same boundary seen from the other end.
    #[must_use]
    pub fn reversed(self) -> Self {
        match self {
            Self::SubductingOrigin => Self::SubductingDestination,
            Self::SubductingDestination => Self::SubductingOrigin,
            other => other,
        }
    }
}

/// State of an edge and of its cross edge, which joins the two vertices opposite to it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EdgeState {
    /// Boundary across the edge.
    pub kind: BoundaryKind,
    /// Boundary across the cross edge.
    pub cross_kind: BoundaryKind,
    /// Rest length of the spring along the edge, in radii; 0 until it is first needed.
    pub rest: f32,
    /// Rest length of the spring along the cross edge, in radii; 0 until it is first needed.
    pub cross_rest: f32,
}

impl EdgePayload for EdgeState {
    /// The edge becomes its own cross edge: the springs swap, so that no stored strain is lost.
    fn flipped(&mut self) {
        core::mem::swap(&mut self.kind, &mut self.cross_kind);
        core::mem::swap(&mut self.rest, &mut self.cross_rest);
    }

    /// The cross edge has other ends: its rest length is measured anew when next needed.
    fn reshaped(&mut self) {
        self.cross_rest = 0.0;
    }
}

/// The mesh of the world: vertex number = row of the sub-plate.
#[derive(Resource, Debug, Clone)]
pub struct Topology(pub SphereMesh<EdgeState>);
