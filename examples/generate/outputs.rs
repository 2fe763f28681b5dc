//! What is written besides the maps.

use crate::flags::interval;
use bevy::app::{PluginGroup, PluginGroupBuilder};
use bevy_tectonics::{
    export::{
        ExportError, FILM_FILE, Film, GEOGRAPHY_FILES, GLOBE_FILE, Globe, Maps, TABLE_FILES,
        Textures, write_geography, write_tables,
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

    /// plates.geojson, boundaries.geojson, poles.geojson, and rotations.rot (`GPlates`) of the last
    /// million years
    #[arg(long)]
    pub geography: bool,

    /// The same with rotations of the whole history, or of what follows a save, every so many million
    /// years
    #[arg(long, value_name = "MY", num_args = 0..=1, default_missing_value = "10", value_parser = interval)]
    pub rotations: Option<f64>,

    /// Numbered maps, `map_0000.png` and on, after the first step that reaches a multiple of so many
    /// million years, and at the end
    #[arg(long, value_name = "MY", num_args = 0..=1, default_missing_value = "10", value_parser = interval)]
    pub frames: Option<f64>,

    /// history.png, an animated map of the same moments, or of those that follow a save
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

    /// Says whether the pictures of so many My can be taken.
    pub fn validate_span(&self, start_my: f64, end_my: f64) -> Result<(), String> {
        for interval_my in [self.frames, self.film].into_iter().flatten() {
            let count = Moments::new(interval_my, start_my, end_my).count();
            if count > f64::from(*Film::PICTURES.end()) {
                let most = Film::PICTURES.end();
                return Err(format!("{count:.0} maps are too many, {most} at most"));
            }
        }
        Ok(())
    }

    /// Films of a history, to be exposed as it goes on.
    pub fn reels(
        &self,
        maps: &Maps,
        folder: &Path,
        start_my: f64,
        end_my: f64,
    ) -> Result<Vec<Reel>, String> {
        self.validate_span(start_my, end_my)?;
        let mut reels = Vec::new();
        if let Some(interval_my) = self.frames {
            reels.push(Reel {
                moments: Moments::new(interval_my, start_my, end_my),
                camera: Camera::Frames(*maps, folder.to_owned(), Vec::new()),
            });
        }
        if let Some(interval_my) = self.film {
            let moments = Moments::new(interval_my, start_my, end_my);
            let film = Film::create(folder, *maps, moments.count() as u32);
            reels.push(Reel {
                moments,
                camera: Camera::Film(Box::new(film.map_err(|error| error.to_string())?)),
            });
        }
        Ok(reels)
    }

    /// Names of the files that are asked for, but for pictures by number and by face.
    pub fn files(&self) -> Vec<&'static str> {
        let mut files = Vec::new();
        if self.textures {
            files.extend(["normal.png", "colour.png"]);
        }
        if self.globe.is_some() {
            files.push(GLOBE_FILE);
        }
        if self.tables {
            files.extend(TABLE_FILES);
        }
        if self.has_geography() {
            files.extend(GEOGRAPHY_FILES);
        }
        if self.film.is_some() {
            files.push(FILM_FILE);
        }
        files
    }

    fn has_geography(&self) -> bool {
        self.geography || self.rotations.is_some()
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
            if self.has_geography() {
                let recorded = history.world_mut().get_resource::<RotationHistory>();
                let rotations = recorded
                    .cloned()
                    .unwrap_or_else(|| RotationHistory::of(&surface));
                files.extend(write_geography(&surface, &rotations, folder)?);
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

/// When pictures are taken: at multiples of an interval, and at the end.
struct Moments {
    interval_my: f64,
    end_my: f64,
    /// Number of the next multiple.
    next: f64,
    is_over: bool,
}

impl Moments {
    fn new(interval_my: f64, start_my: f64, end_my: f64) -> Self {
        Self {
            interval_my,
            end_my,
            next: (start_my / interval_my).ceil(),
            is_over: false,
        }
    }

    /// How many are left.
    fn count(&self) -> f64 {
        (self.last() - self.next).max(0.0) + 1.0
    }

    /// Number of the multiple that the end is, or comes before.
    fn last(&self) -> f64 {
        // A hair's breadth of rounding is no moment of its own.
        (self.end_my / self.interval_my - 1e-9).ceil()
    }

    fn due_my(&self) -> f64 {
        if self.is_over {
            f64::INFINITY
        } else {
            (self.next * self.interval_my).min(self.end_my)
        }
    }

    /// Number of a moment that has come.
    fn pop(&mut self, now_my: f64) -> Option<u32> {
        if self.due_my() > now_my {
            return None;
        }
        let number = self.next;
        self.is_over = number >= self.last();
        self.next += 1.0;
        Some(number as u32)
    }
}

/// A film that is being made.
pub struct Reel {
    camera: Camera,
    moments: Moments,
}

enum Camera {
    Film(Box<Film>),
    Frames(Maps, PathBuf, Vec<PathBuf>),
}

impl Reel {
    /// When the next picture is to be taken, in My.
    pub fn due_my(&self) -> f64 {
        self.moments.due_my()
    }

    /// Takes all pictures that are due.
    pub fn take(&mut self, history: &mut History) -> Result<(), String> {
        let now_my = history.time_my();
        if self.due_my() > now_my {
            return Ok(());
        }
        let surface = history.surface().map_err(|error| error.to_string())?;
        while let Some(number) = self.moments.pop(now_my) {
            let taken = match &mut self.camera {
                Camera::Film(film) => film.add(&surface),
                Camera::Frames(maps, folder, files) => maps
                    .write_frame(&surface, folder, number)
                    .map(|file| files.push(file)),
            };
            taken.map_err(|error| error.to_string())?;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_taken_at_multiples_and_at_the_end() {
        let numbers = |interval: f64, start: f64, end: f64| {
            let mut moments = Moments::new(interval, start, end);
            let expected = moments.count();
            let mut found = Vec::new();
            // Steps that fit no interval.
            let mut now = start;
            loop {
                while let Some(number) = moments.pop(now) {
                    found.push(number);
                }
                if now >= end {
                    break;
                }
                now = (now + 0.83).min(end);
            }
            assert_eq!(found.len() as f64, expected, "{interval} {start} {end}");
            assert!(moments.due_my().is_infinite());
            found
        };
        assert_eq!(numbers(2.0, 0.0, 6.0), [0, 1, 2, 3]);
        assert_eq!(numbers(4.0, 0.0, 6.0), [0, 1, 2]);
        assert_eq!(numbers(10.0, 0.0, 0.0), [0]);
        assert_eq!(numbers(0.7, 0.0, 4.9).len(), 8);
        assert_eq!(numbers(1.4, 0.0, 4.2).len(), 4);
        // What goes on from a save goes on with the numbers.
        assert_eq!(numbers(2.0, 4.0, 7.0), [2, 3, 4]);
        assert_eq!(numbers(2.0, 5.0, 5.0), [3]);
    }
}
