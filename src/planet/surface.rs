//! The newest snapshot of a planet.

use crate::simulation::{Statistics, Surface};
use bevy::prelude::*;
use core::ops::Deref;
use std::sync::Arc;

/// The newest snapshot of a planet: an immutable [`Surface`] and what it measures. Cloning is cheap,
/// and a clone lives as long as you keep it: hand it to a task, or compare it with a later one.
///
/// It is replaced as the history goes on; [`SurfaceChanged`](super::SurfaceChanged) tells when.
#[derive(Component, Debug, Clone)]
pub struct PlanetSurface {
    pub(super) surface: Arc<Surface>,
    pub(super) statistics: Arc<Statistics>,
}

impl PlanetSurface {
    /// The snapshot itself, to be kept or sent elsewhere.
    #[must_use]
    pub fn share(&self) -> Arc<Surface> {
        self.surface.clone()
    }

    /// What the planet measured at that moment.
    #[must_use]
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }
}

impl Deref for PlanetSurface {
    type Target = Surface;

    fn deref(&self) -> &Surface {
        &self.surface
    }
}
