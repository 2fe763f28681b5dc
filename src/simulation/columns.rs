//! Sub-plates read as whole columns: as fast as plain vectors, still ordinary queries.

use super::error::TectonicError;
use bevy::ecs::query::{ArchetypeFilter, ContiguousQueryData};
use bevy::prelude::*;

/// Access to the columns of all sub-plates at once.
pub trait Columns<D: ContiguousQueryData> {
    /// Slices over all sub-plates, indexed by vertex. Mutable ones come as
    /// [`ContiguousMut`](bevy::ecs::change_detection::ContiguousMut); take
    /// `bypass_change_detection()` once and index that.
    ///
    /// # Errors
    /// [`TectonicError::Archetype`] if the sub-plates do not lie in one table of `expected` rows.
    fn columns(&mut self, expected: usize) -> Result<D::Contiguous<'_, '_>, TectonicError>;
}

impl<D: ContiguousQueryData, F: ArchetypeFilter> Columns<D> for Query<'_, '_, D, F> {
    fn columns(&mut self, expected: usize) -> Result<D::Contiguous<'_, '_>, TectonicError> {
        let rows = self.reborrow().count();
        let mut tables = self
            .contiguous_iter_mut()
            .map_err(|_| TectonicError::Archetype { found: 0, expected })?;
        match (tables.next(), tables.next().is_none()) {
            (Some(columns), true) if rows == expected => Ok(columns),
            (_, single) => Err(TectonicError::Archetype {
                found: if single { rows } else { 0 },
                expected,
            }),
        }
    }
}
