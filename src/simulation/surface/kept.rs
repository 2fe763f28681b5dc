//! What queries on a surface work out once and keep. Plain data: the queries are the surface room's.

use crate::simulation::BoundaryKind;
use core::fmt;
use glam::{DVec3, Vec3};
use std::sync::OnceLock;

/// A piece of the boundary between two plates: the line on which two sub-plates meet.
///
/// Pieces of a boundary share their ends bit for bit; two meet along a boundary, three where three
/// plates meet. They are the sides of the sub-plates' Voronoi cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundarySegment {
    /// Both ends, unit vectors.
    pub ends: [DVec3; 2],
    /// Ids of the plates, the smaller first: it lies to the left on the way from the first end to the
    /// second, seen from outside.
    pub plates: [u16; 2],
    /// The two sub-plates (vertices of the mesh), in the order of `plates`.
    pub sub_plates: [u32; 2],
    /// What the plates do here: never [`BoundaryKind::Joined`]. `SubductingOrigin` says that the first
    /// of `plates` goes under, `SubductingDestination` that the second does.
    pub kind: BoundaryKind,
    /// Velocity of the second plate relative to the first in km/My (= mm/yr), tangent at the middle.
    pub slip: Vec3,
    /// Part of the slip that parts the plates in km/My: positive where they part, negative where they
    /// close. Measured across this very piece: zigzags of a front make it vary from piece to piece.
    pub opening: f32,
    /// Length in km.
    pub length_km: f64,
}

impl BoundarySegment {
    /// Id of the plate that goes under, if one does.
    #[must_use]
    pub fn subducting(&self) -> Option<u16> {
        match self.kind {
            BoundaryKind::SubductingOrigin => Some(self.plates[0]),
            BoundaryKind::SubductingDestination => Some(self.plates[1]),
            _ => None,
        }
    }

    /// Relative speed of the plates in km/My.
    #[must_use]
    pub fn speed(&self) -> f32 {
        self.slip.length()
    }

    /// The place a share (0 to 1, clamped) of the way from the first end to the second: a unit vector.
    #[must_use]
    pub fn point(&self, share: f64) -> DVec3 {
        let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
        self.ends[0]
            .lerp(self.ends[1], share)
            .normalize_or(self.ends[0])
    }
}

/// A plate at the moment of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlateSummary {
    /// Its id.
    pub id: u16,
    /// Number of its sub-plates.
    pub sub_plates: u32,
    /// Area in km².
    pub area_km2: f64,
    /// Continental share of that area, 0 to 1.
    pub continental_share: f64,
    /// Mean of its places, a unit vector. It may lie outside a plate that is bent round another.
    pub centre: DVec3,
    /// Angular velocity in rad/My: the direction is the Euler pole.
    pub rotation: DVec3,
    /// Mean speed over the area in km/My (= mm/yr).
    pub speed: f64,
}

impl PlateSummary {
    /// Velocity of the rigid plate in a direction (a unit vector) in km/My, tangent there.
    #[must_use]
    pub fn velocity(&self, direction: DVec3, radius_km: f64) -> DVec3 {
        self.rotation.cross(direction) * radius_km
    }
}

/// A grid on the cube around the sphere with a nearby vertex in each cell.
pub(crate) struct Starts {
    /// Cells per side of a face.
    pub(crate) side: u32,
    /// Six faces of rows of cells.
    pub(crate) cells: Vec<u32>,
}

/// A ball around some boundary segments, in the space around the unit sphere.
pub(crate) struct Ball {
    pub(crate) centre: DVec3,
    pub(crate) radius: f64,
    /// Its segments in the order of the tree.
    pub(crate) segments: core::ops::Range<u32>,
    /// Its second half; the first follows it. 0 in a leaf.
    pub(crate) second: u32,
}

/// Boundary segments by place.
pub(crate) struct SegmentTree {
    /// Numbers of segments.
    pub(crate) order: Vec<u32>,
    /// The tree in preorder.
    pub(crate) balls: Vec<Ball>,
}

/// All of it. A copy starts without, so that it may be changed.
#[derive(Default)]
pub(crate) struct Kept {
    pub(crate) starts: OnceLock<Starts>,
    /// Lowest and highest elevation in m.
    pub(crate) range: OnceLock<[f64; 2]>,
    /// Slope of the ground per vertex, tangent and uphill, in m per radian.
    pub(crate) slopes: OnceLock<Vec<Vec3>>,
    pub(crate) segments: OnceLock<Vec<BoundarySegment>>,
    pub(crate) tree: OnceLock<SegmentTree>,
    pub(crate) plates: OnceLock<Vec<PlateSummary>>,
}

impl Clone for Kept {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl PartialEq for Kept {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl fmt::Debug for Kept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Kept")
    }
}
