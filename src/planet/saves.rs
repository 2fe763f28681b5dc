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
/// the new one is complete. A planet that is replaced before, by another recipe, may be saved or not, and
/// [`SaveFailed`] says so.
#[derive(EntityEvent, Debug, Clone, PartialEq)]
pub struct SavePlanet {
    /// The planet.
    pub entity: Entity,
    /// The file.
    pub path: PathBuf,
}

/// Puts a saved planet in the place of this one: *you* trigger it on the planet's entity.
/// [`PlanetLoaded`] or [`LoadFailed`] answers; until then, and after a failure, the old planet goes on. It waits
/// until the old planet has been saved, if that was asked for; a later one takes the place of one under way.
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
    loading: Option<Loading>,
}

/// A file that is being read.
#[derive(Debug)]
struct Loading {
    path: PathBuf,
    result: Arc<Mutex<Option<Loaded>>>,
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
        // The planet that was there when it was asked for: before anything is loaded. One that was spawned in
        // this frame has no history to ask yet.
        match &mut grower.job {
            Some(job) if !job.failed => {
                let asked = core::mem::take(&mut saves.asked);
                job.saving.extend_from_slice(&asked);
                job.desk.ask_to_save(asked);
            }
            Some(_) => grower.unsaved.append(&mut saves.asked),
            None => {}
        }
        for path in grower.unsaved.drain(..) {
            let error = SaveError::Failed;
            commands.trigger(SaveFailed {
                entity,
                path,
                error,
            });
        }
        let is_saving = grower
            .job
            .as_ref()
            .is_some_and(|job| !job.saving.is_empty());
        if let Some(path) = saves.to_load.take_if(|_| !is_saving) {
            saves.loading = Some(Loading::start(path, &stages, &threads));
        }
        let Some((path, loaded)) = saves.loading.as_mut().and_then(Loading::result) else {
            continue;
        };
        saves.loading = None;
        match loaded {
            Ok(history) => {
                planet.recipe = history.recipe().clone();
                let time_my = history.time_my();
                let progress = history.progress(planet.end_my());
                grower.plant(history, progress, &stages, &threads);
                growth.set_if_neq(Growth {
                    progress,
                    ..Growth::default()
                });
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
}

impl Loading {
    /// Starts to read a file beside the game, or reads it here where there are no threads.
    fn start(path: PathBuf, stages: &Stages, threads: &PlanetThreads) -> Self {
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
        Self { path, result }
    }

    /// What has been read, once nobody reads any more. Without a result the reader has panicked.
    fn result(&mut self) -> Option<(PathBuf, Loaded)> {
        let result = Arc::get_mut(&mut self.result)?;
        let result = result.get_mut().unwrap_or_else(PoisonError::into_inner);
        let loaded = result.take().unwrap_or(Err(SaveError::Failed));
        Some((self.path.clone(), loaded))
    }
}

/// Tells the game what became of its requests.
pub(super) fn answer(
    commands: &mut Commands,
    entity: Entity,
    saving: &mut Vec<PathBuf>,
    saved: Vec<Saved>,
) {
    for (path, time_my, result) in saved {
        if let Some(at) = saving.iter().position(|asked| *asked == path) {
            saving.remove(at);
        }
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
