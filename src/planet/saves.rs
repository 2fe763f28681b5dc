//! Saving and loading in a game (feature `save`): beside the frames, as everything else.

use super::{
    Growth, Planet, PlanetThreads,
    grower::{Grower, Stages},
};
use crate::save::{self, SaveError};
use crate::simulation::History;
use bevy::prelude::*;
use std::{
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
};

/// Saves a planet to a file: *you* trigger it on the planet's entity,
/// `commands.trigger(SavePlanet { entity, path })`. [`PlanetSaved`] or [`SaveFailed`] answers.
///
/// It is written on the planet's thread, after the step under way. The file that was there before stays until
/// the new one is complete.
#[derive(EntityEvent, Debug, Clone, PartialEq)]
pub struct SavePlanet {
    /// The planet.
    pub entity: Entity,
    /// The file.
    pub path: PathBuf,
}

/// Puts a saved planet in the place of this one: *you* trigger it on the planet's entity.
/// [`PlanetLoaded`] or [`LoadFailed`] answers; until then, and after a failure, the old planet goes on.
///
/// [`Planet::recipe`] becomes that of the save. To load without a planet before, spawn one that is paused.
#[derive(EntityEvent, Debug, Clone, PartialEq)]
pub struct LoadPlanet {
    /// The planet.
    pub entity: Entity,
    /// The file.
    pub path: PathBuf,
}

/// A planet lies whole on the disk.
#[derive(EntityEvent, Debug, Clone, PartialEq)]
pub struct PlanetSaved {
    /// The planet.
    pub entity: Entity,
    /// The file.
    pub path: PathBuf,
    /// Its time in My.
    pub time_my: f64,
}

/// A planet could not be saved; a file that was there before still is.
#[derive(EntityEvent, Debug)]
pub struct SaveFailed {
    /// The planet.
    pub entity: Entity,
    /// The file.
    pub path: PathBuf,
    /// Why.
    pub error: SaveError,
}

/// A saved planet has taken the place of the one before. Its first surface follows.
#[derive(EntityEvent, Debug, Clone, PartialEq)]
pub struct PlanetLoaded {
    /// The planet.
    pub entity: Entity,
    /// The file.
    pub path: PathBuf,
    /// Its time in My.
    pub time_my: f64,
}

/// A planet could not be loaded; the one before goes on.
#[derive(EntityEvent, Debug)]
pub struct LoadFailed {
    /// The planet.
    pub entity: Entity,
    /// The file.
    pub path: PathBuf,
    /// Why.
    pub error: SaveError,
}

/// What became of a request to save: the file, the time in My, and what went wrong.
pub(super) type Saved = (PathBuf, f64, Result<(), SaveError>);

/// What is to be saved and loaded.
#[derive(Component, Debug, Default)]
pub(super) struct Saves {
    asked: Vec<PathBuf>,
    to_load: Option<PathBuf>,
    loading: Option<(PathBuf, Arc<Mutex<Option<Loaded>>>)>,
}

type Loaded = Result<History, SaveError>;

pub(super) fn ask_to_save(asked: On<SavePlanet>, mut planets: Query<&mut Saves>) {
    if let Ok(mut saves) = planets.get_mut(asked.entity) {
        saves.asked.push(asked.path.clone());
    }
}

pub(super) fn ask_to_load(asked: On<LoadPlanet>, mut planets: Query<&mut Saves>) {
    if let Ok(mut saves) = planets.get_mut(asked.entity) {
        saves.to_load = Some(asked.path.clone());
        // Only the last one is of interest.
        saves.loading = None;
    }
}

type Kept = (
    Entity,
    &'static mut Planet,
    &'static mut Growth,
    &'static mut Grower,
    &'static mut Saves,
);

/// Hands requests on, and plants what has been loaded.
pub(super) fn tend_saves(
    mut commands: Commands,
    threads: Res<PlanetThreads>,
    stages: Res<Stages>,
    mut planets: Query<Kept>,
) {
    for (entity, mut planet, mut growth, mut grower, mut saves) in &mut planets {
        if let Some(path) = saves.to_load.take() {
            let result = Arc::new(Mutex::new(None));
            let (stages, file, there) = (stages.clone(), path.clone(), result.clone());
            let load = move || {
                let loaded = save::read(&file, (stages.0)());
                *there.lock().unwrap_or_else(PoisonError::into_inner) = Some(loaded);
            };
            if threads.has_any() {
                threads.spawn(async move { load() });
            } else {
                load();
            }
            saves.loading = Some((path, result));
        }
        let is_there = |(path, result): &(PathBuf, Arc<Mutex<Option<Loaded>>>)| {
            let mut result = result.lock().unwrap_or_else(PoisonError::into_inner);
            result.take().map(|loaded| (path.clone(), loaded))
        };
        if let Some((path, loaded)) = saves.loading.as_ref().and_then(is_there) {
            saves.loading = None;
            match loaded {
                Ok(history) => {
                    let time_my = history.time_my();
                    planet.recipe = history.recipe().clone();
                    grower.plant(history, &stages, &threads);
                    growth.set_if_neq(Growth::default());
                    commands.trigger(PlanetLoaded {
                        entity,
                        path,
                        time_my,
                    });
                }
                Err(error) => commands.trigger(LoadFailed {
                    entity,
                    path,
                    error,
                }),
            }
        }
        // A planet that was spawned in this frame has no history to ask yet.
        if saves.asked.is_empty() {
            continue;
        }
        match &grower.job {
            Some(job) if job.failed => {
                for path in saves.asked.drain(..) {
                    let error = SaveError::Failed;
                    commands.trigger(SaveFailed {
                        entity,
                        path,
                        error,
                    });
                }
            }
            Some(job) => job.desk.ask_to_save(core::mem::take(&mut saves.asked)),
            None => {}
        }
    }
}

/// Tells the game what became of its requests.
pub(super) fn answer(commands: &mut Commands, entity: Entity, saved: Vec<Saved>) {
    for (path, time_my, result) in saved {
        match result {
            Ok(()) => commands.trigger(PlanetSaved {
                entity,
                path,
                time_my,
            }),
            Err(error) => commands.trigger(SaveFailed {
                entity,
                path,
                error,
            }),
        }
    }
}
