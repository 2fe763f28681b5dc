//! What is written besides the maps.

use crate::flags::interval;
use bevy::app::{PluginGroup, PluginGroupBuilder};
use bevy_tectonics::{
    export::{
        ExportError, Film, Globe, Maps, Textures, write_geography, write_rotations, write_tables,
    },
    simulation::{History, RotationHistory, RotationHistoryPlugin, SimulationPlugins},
    surface::Relief,
};
use clap::Args;
use std::path::{Path, PathBuf};

#[derive(Args, Debug)]
#[command(next_help_heading = "More files")]
pub struct Outputs {
    /// What a material wants: normal.png and colour.png, as wide as the maps
    #[arg(long)]
    pub textures: bool,

    /// The same as cube maps, with elevations: 18 files; texels along an edge, 8 to 8192
    #[arg(long, value_name = "SIDE", num_args = 0..=1, default_missing_value = "1024")]
    pub cube: Option<u32>,

    /// The planet as a model, planet.glb (glTF); texels along an edge of its textures, 8 to 4096
    #[arg(long, value_name = "SIDE", num_args = 0..=1, default_missing_value = "1024")]
    pub globe: Option<u32>,

    /// Factor on heights in the model and in normals [default: 10 in the model, 1 in textures]
    #[arg(long, value_name = "FACTOR", value_parser = factor)]
    pub exaggeration: Option<f64>,

    /// `sub_plates.csv` and plates.csv
    #[arg(long)]
    pub tables: bool,

    /// plates.geojson, boundaries.geojson, poles.geojson and rotations.rot (`GPlates`)
    #[arg(long)]
    pub geography: bool,

    /// rotations.rot of the whole history, every so many million years
    #[arg(long, value_name = "MY", num_args = 0..=1, default_missing_value = "10", value_parser = interval)]
    pub rotations: Option<f64>,

    /// Numbered maps, `map_0000.png` and on, every so many million years
    #[arg(long, value_name = "MY", num_args = 0..=1, default_missing_value = "10", value_parser = interval)]
    pub frames: Option<f64>,

    /// history.png, an animated map with a picture every so many million years
    #[arg(long, value_name = "MY", num_args = 0..=1, default_missing_value = "10", value_parser = interval)]
    pub film: Option<f64>,
}

fn factor(text: &str) -> Result<f64, String> {
    let hint = "it must be a number from 0 to 1000";
    crate::flags::number(text, 0.0..=1000.0, hint)
}

impl Outputs {
    /// Says whether all of it can be written.
    pub fn validate(&self, maps: &Maps) -> Result<(), String> {
        let text = |error: ExportError| error.to_string();
        if let Some(textures) = self.cube(maps) {
            textures.validate().map_err(text)?;
        }
        if let Some(globe) = self.globe(maps) {
            globe.validate().map_err(text)?;
        }
        if self.film.is_some() && !Film::WIDTHS.contains(&maps.width) {
            return Err(text(ExportError::FilmWidth(maps.width)));
        }
        Ok(())
    }

    /// The simulation, with what these files need to know of it.
    pub fn plugins(&self) -> PluginGroupBuilder {
        let plugins = SimulationPlugins.build();
        match self.rotations {
            Some(interval_my) => plugins.add(RotationHistoryPlugin { interval_my }),
            None => plugins,
        }
    }

    /// Films of a history, to be exposed as it goes on.
    pub fn reels(
        &self,
        maps: &Maps,
        folder: &Path,
        start_my: f64,
        end_my: f64,
    ) -> Result<Vec<Reel>, String> {
        let begin = |interval_my: f64, is_film: bool| {
            let count = 1.0 + ((end_my - start_my) / interval_my).ceil();
            if count > f64::from(*Film::PICTURES.end()) {
                let most = Film::PICTURES.end();
                return Err(format!("{count} maps are too many, {most} at most"));
            }
            let count = count as u32;
            let camera = if is_film {
                let film = Film::create(folder, *maps, count).map_err(|error| error.to_string())?;
                Camera::Film(Box::new(film))
            } else {
                Camera::Frames(*maps, folder.to_owned(), Vec::new())
            };
            Ok(Reel {
                camera,
                interval_my,
                start_my,
                end_my,
                shown: 0,
                count,
            })
        };
        let frames = self.frames.map(|interval_my| begin(interval_my, false));
        let film = self.film.map(|interval_my| begin(interval_my, true));
        frames.into_iter().chain(film).collect()
    }

    /// Writes all of it and returns the files.
    pub fn write(
        &self,
        history: &mut History,
        maps: &Maps,
        folder: &Path,
    ) -> Result<Vec<PathBuf>, String> {
        let surface = history.surface().map_err(|error| error.to_string())?;
        let mut files = Vec::new();
        let mut write = || -> Result<(), ExportError> {
            if self.textures {
                let textures = Textures::rectangle(maps.width);
                // Its heights are those of the maps, byte for byte.
                files.extend(self.relief(textures, maps).write(&surface, folder)?);
            }
            if let Some(textures) = self.cube(maps) {
                files.extend(textures.write(&surface, folder)?);
            }
            if let Some(globe) = self.globe(maps) {
                files.push(globe.write(&surface, folder)?);
            }
            if self.tables {
                files.extend(write_tables(&surface, folder)?);
            }
            if self.geography {
                files.extend(write_geography(&surface, folder)?);
            }
            if let Some(rotations) = history.world_mut().get_resource::<RotationHistory>() {
                files.push(write_rotations(rotations, folder)?);
            }
            Ok(())
        };
        write().map_err(|error| error.to_string())?;
        Ok(files)
    }

    fn cube(&self, maps: &Maps) -> Option<Textures> {
        let side = self.cube?;
        Some(self.relief(Textures::cube(side), maps))
    }

    fn relief(&self, textures: Textures, maps: &Maps) -> Textures {
        let mut textures = textures.with_relief(self.exaggeration.unwrap_or(1.0));
        textures.threads = maps.threads;
        textures
    }

    fn globe(&self, maps: &Maps) -> Option<Globe> {
        let globe = Globe::default();
        Some(Globe {
            side: self.globe?,
            threads: maps.threads,
            relief: self.exaggeration.map_or(globe.relief, |factor| {
                Relief::exaggerated(factor).with_sea()
            }),
            ..globe
        })
    }
}

/// A film that is being made.
pub struct Reel {
    camera: Camera,
    interval_my: f64,
    start_my: f64,
    end_my: f64,
    shown: u32,
    count: u32,
}

enum Camera {
    Film(Box<Film>),
    Frames(Maps, PathBuf, Vec<PathBuf>),
}

impl Reel {
    /// When the next picture is to be taken, in My.
    pub fn due_my(&self) -> f64 {
        if self.shown == self.count {
            return f64::INFINITY;
        }
        let due = self.start_my + f64::from(self.shown) * self.interval_my;
        due.min(self.end_my)
    }

    /// Takes all pictures that are due.
    pub fn take(&mut self, history: &mut History) -> Result<(), String> {
        if self.due_my() > history.time_my() {
            return Ok(());
        }
        let surface = history.surface().map_err(|error| error.to_string())?;
        while self.due_my() <= history.time_my() {
            let taken = match &mut self.camera {
                Camera::Film(film) => film.add(&surface),
                Camera::Frames(maps, folder, files) => maps
                    .write_frame(&surface, folder, self.shown)
                    .map(|file| files.push(file)),
            };
            taken.map_err(|error| error.to_string())?;
            self.shown += 1;
        }
        Ok(())
    }

    /// The files, once all pictures are taken.
    pub fn finish(self) -> Result<Vec<PathBuf>, String> {
        match self.camera {
            Camera::Film(film) => {
                let file = film.finish().map_err(|error| error.to_string())?;
                Ok(vec![file])
            }
            Camera::Frames(_, _, files) => Ok(files),
        }
    }
}
