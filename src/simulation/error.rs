//! Everything that can go wrong, each with what, where and the allowed range.

use crate::mesh;
use thiserror::Error;

/// Why a recipe was refused, a step could not be completed, or a check failed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TectonicError {
    /// A value of the recipe lies outside its range.
    #[error("{field} is {value}, but must be {allowed}")]
    Recipe {
        /// Path of the value inside the recipe, such as `constants.motion.slab_pull`.
        field: String,
        /// The value as given.
        value: String,
        /// What is allowed, with the unit.
        allowed: String,
    },
    /// Something that a start is imported from cannot be used.
    #[error("{what}: {found}, but must be {allowed}")]
    Import {
        /// Path of the file, or the part of the imported world.
        what: String,
        /// What was found there.
        found: String,
        /// What is allowed.
        allowed: String,
    },
    /// The starting points could not be triangulated.
    #[error("the start could not be triangulated: {0}")]
    Build(String),
    /// The mesh could not be mended after a move.
    #[error("the mesh could not be repaired at {time_my:.3} My: {source}")]
    Repair {
        /// When, in My.
        time_my: f64,
        /// What the mesh reported.
        source: mesh::RepairError,
    },
    /// A consistency check of the mesh failed.
    #[error("the mesh is faulty at {time_my:.3} My: {source}")]
    Mesh {
        /// When, in My.
        time_my: f64,
        /// What the mesh reported.
        source: mesh::MeshFault,
    },
    /// A field holds a value that is not finite.
    #[error("{field} of sub-plate {vertex} is not finite at {time_my:.3} My")]
    NotFinite {
        /// Name of the component.
        field: &'static str,
        /// Row of the sub-plate.
        vertex: usize,
        /// When, in My.
        time_my: f64,
    },
    /// There is less than no crust.
    #[error("the crust of sub-plate {vertex} is {thickness_km} km thick at {time_my:.3} My")]
    Thickness {
        /// Row of the sub-plate.
        vertex: usize,
        /// Its thickness in km.
        thickness_km: f64,
        /// When, in My.
        time_my: f64,
    },
    /// A velocity points out of the surface.
    #[error(
        "velocity of sub-plate {vertex} has a radial part of {radial} km/My at {time_my:.3} My"
    )]
    NotTangential {
        /// Row of the sub-plate.
        vertex: usize,
        /// Radial part in km/My.
        radial: f64,
        /// When, in My.
        time_my: f64,
    },
    /// A plate lies in several pieces, or a sub-plate belongs to none.
    #[error("plate {plate} lies in {pieces} pieces at {time_my:.3} My")]
    PlateInPieces {
        /// Id of the plate.
        plate: u16,
        /// Number of connected pieces (0: a sub-plate names a plate that does not exist).
        pieces: usize,
        /// When, in My.
        time_my: f64,
    },
    /// The continental volume differs from what the ledger booked.
    #[error(
        "the ledger is open by a share of {relative:.3e} of the continental volume \
         (allowed 1e-6) at {time_my:.3} My"
    )]
    LedgerOpen {
        /// Difference as a share of the volume.
        relative: f64,
        /// When, in My.
        time_my: f64,
    },
    /// The cells of the sub-plates do not cover the sphere.
    #[error("cell areas sum to {sum} of the sphere instead of 1 at {time_my:.3} My")]
    AreaOpen {
        /// Sum of all cells, as a share of the sphere.
        sum: f64,
        /// When, in My.
        time_my: f64,
    },
    /// The sub-plates' table and the mesh no longer agree.
    #[error(
        "{found} sub-plates lie in one table but the mesh has {expected}: components of your own \
         on sub-plates must be registered as required by `SubPlate`, never inserted later"
    )]
    Archetype {
        /// Rows found in the first table.
        found: usize,
        /// Vertices of the mesh.
        expected: usize,
    },
    /// The last step failed or was cancelled between two of its stages: nothing can go on from here.
    #[error("the history was stopped in the middle of the step to {time_my:.3} My")]
    Interrupted {
        /// Where the step would have ended, in My.
        time_my: f64,
    },
    /// A linear system of the torque balance had no solution.
    #[error("the torque balance has no finite solution at {time_my:.3} My")]
    TorqueBalance {
        /// When, in My.
        time_my: f64,
    },
}

impl TectonicError {
    /// An [`Import`](Self::Import) error.
    pub(crate) fn import(
        what: impl Into<String>,
        found: impl Into<String>,
        allowed: impl Into<String>,
    ) -> Self {
        Self::Import {
            what: what.into(),
            found: found.into(),
            allowed: allowed.into(),
        }
    }
}
