//! Plates: a few dozen entities that the sub-plates name by id.

use super::sub_plate::PlateId;
use bevy::prelude::*;
use core::ops::AddAssign;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A plate. Its entity holds what moves it; its sub-plates hold its ground.
#[derive(Component, Debug, Clone, Copy, Default, Reflect)]
#[reflect(Component, Default)]
#[require(Rotation, PlateArea, PlateBorn, DrivingTorque)]
pub struct Plate {
    /// What its sub-plates carry. Never 0, never used twice in a history.
    pub id: PlateId,
}

/// Angular velocity in rad/My: the direction is the Euler pole, the length the speed.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, Reflect)]
#[reflect(Component, Default)]
pub struct Rotation(pub DVec3);

/// Area in km², brought up to date when plates are reorganised.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, Reflect)]
#[reflect(Component, Default)]
pub struct PlateArea(pub f64);

/// When the plate came to be, in My on the planet's clock.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, Reflect)]
#[reflect(Component, Default)]
pub struct PlateBorn(pub f64);

/// Torques on the plate in the last step, each the sum of `r × F` over its fronts, in units of
/// force (see [`MotionConstants`](super::constants::MotionConstants)).
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, Reflect)]
#[reflect(Component, Default)]
pub struct DrivingTorque {
    /// Pull of the plate's own slabs.
    pub slab_pull: DVec3,
    /// Suction of slabs that go down under it.
    pub slab_suction: DVec3,
    /// Push of ridges and young rifts.
    pub ridge_push: DVec3,
    /// Drag of the mantle's flow at the roots of continents and at slabs.
    pub mantle_drag: DVec3,
}

impl DrivingTorque {
    /// All of them together.
    #[must_use]
    pub fn sum(&self) -> DVec3 {
        self.slab_pull + self.slab_suction + self.ridge_push + self.mantle_drag
    }
}

impl AddAssign for DrivingTorque {
    fn add_assign(&mut self, other: Self) {
        self.slab_pull += other.slab_pull;
        self.slab_suction += other.slab_suction;
        self.ridge_push += other.ridge_push;
        self.mantle_drag += other.mantle_drag;
    }
}

/// Ids that were never used.
#[derive(Resource, Debug, Clone, Reflect)]
#[reflect(Resource)]
pub struct NextPlateId(pub u16);

impl NextPlateId {
    /// Takes the next id, or none once all 65,535 have been used.
    pub fn take(&mut self) -> Option<PlateId> {
        let id = self.0;
        self.0 = id.checked_add(1)?;
        Some(PlateId(id))
    }
}

/// A plate as the stages read it.
#[derive(Debug, Clone, Copy)]
pub struct PlateRow {
    /// Its id.
    pub id: PlateId,
    /// Its entity.
    pub entity: Entity,
    /// Angular velocity in rad/My.
    pub rotation: DVec3,
    /// When it came to be, in My.
    pub born: f64,
}

/// All plates in the order of their ids, so that no decision depends on the order of entities.
#[derive(Debug, Clone, Default)]
pub struct PlateTable {
    rows: Vec<PlateRow>,
    row_of_id: Vec<u16>,
}

impl PlateTable {
    /// Gathers the plates from their entities.
    pub fn gather<'a>(
        plates: impl Iterator<Item = (Entity, &'a Plate, &'a Rotation, &'a PlateBorn)>,
    ) -> Self {
        let mut rows: Vec<PlateRow> = plates
            .map(|(entity, plate, rotation, born)| PlateRow {
                id: plate.id,
                entity,
                rotation: rotation.0,
                born: born.0,
            })
            .collect();
        rows.sort_by_key(|row| row.id);
        let mut row_of_id = vec![u16::MAX; rows.last().map_or(0, |row| usize::from(row.id.0) + 1)];
        for (row, plate) in rows.iter().enumerate() {
            row_of_id[usize::from(plate.id.0)] = row as u16;
        }
        Self { rows, row_of_id }
    }

    /// The plates in the order of their ids.
    #[must_use]
    pub fn rows(&self) -> &[PlateRow] {
        &self.rows
    }

    /// Row of a plate; none for an id that no plate has.
    #[must_use]
    pub fn row(&self, id: PlateId) -> Option<usize> {
        let row = *self.row_of_id.get(usize::from(id.0))?;
        (row != u16::MAX).then_some(usize::from(row))
    }

    /// Angular velocity of a plate in rad/My; zero for an id that no plate has.
    #[must_use]
    pub fn rotation(&self, id: PlateId) -> DVec3 {
        self.row(id)
            .map_or(DVec3::ZERO, |row| self.rows[row].rotation)
    }
}
