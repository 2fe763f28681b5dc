//! What is done with hostile inputs. A target takes bytes, any bytes, and panics where a promise is broken:
//! everything is either refused with an error of one line or as good as if it had come from a friend.

mod random_recipe;
mod seal;

use bevy_tectonics::import;
use bevy_tectonics::prelude::*;
use bevy_tectonics::save;
use bevy_tectonics::simulation::ImageStart;
use std::fmt::Display;
use std::io::Cursor;

pub use random_recipe::recipe_run;

/// A target by its name, as in `fuzz_targets/` and in `corpus/`.
pub struct Target {
    pub name: &'static str,
    pub run: fn(&[u8]),
    /// How many inputs of this one for a thousand of the quickest.
    pub weight: u64,
}

/// All targets.
pub const TARGETS: [Target; 7] = [
    target("share_code", share_code, 1000),
    target("recipe_text", recipe_text, 1000),
    target("save", save, 200),
    target("height_map", height_map, 500),
    target("outlines", outlines, 200),
    target("rotations", rotations, 500),
    target("recipe_run", recipe_run, 10),
];

const fn target(name: &'static str, run: fn(&[u8]), weight: u64) -> Target {
    Target { name, run, weight }
}

/// Errors are for people: one line, not too long.
fn read(error: &dyn Display) {
    let message = error.to_string();
    assert!(!message.is_empty(), "an error without a word");
    assert!(message.len() < 2_000, "{} bytes of error", message.len());
}

/// A recipe that was accepted says so, and survives being told.
fn known_again(recipe: &Recipe) {
    if let Err(error) = recipe.validate() {
        read(&error);
        return;
    }
    // What was handed in may hold what no code takes, such as the path of a file.
    let code = recipe.to_string();
    if let Ok(again) = code.parse::<Recipe>() {
        assert_eq!(&again, recipe, "{code}");
    }
    let text = format!("{recipe:#}");
    assert_eq!(text.parse::<Recipe>().as_ref(), Ok(recipe), "{text}");
}

/// Share codes and RON: the same parser.
pub fn share_code(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    match text.parse::<Recipe>() {
        Ok(recipe) => known_again(&recipe),
        Err(error) => read(&error),
    }
}

/// Recipes as JSON, and whatever else a text is.
pub fn recipe_text(data: &[u8]) {
    share_code(data);
    match serde_json::from_slice::<Recipe>(data) {
        Ok(recipe) => known_again(&recipe),
        Err(error) => read(&error),
    }
}

/// Saves, as they are and sealed again with checksums that fit.
pub fn save(data: &[u8]) {
    let sealed = seal::save(data);
    for bytes in [data, &sealed] {
        match save::from_bytes(bytes, SimulationPlugins) {
            Ok(mut history) => {
                if let Err(error) = history.step() {
                    read(&error);
                }
            }
            Err(error) => read(&error),
        }
    }
}

/// A picture that everybody can read.
const PICTURE: &[u8] = include_bytes!("../corpus/height_map/grey_8.png");
/// Outlines of three plates.
const OUTLINES: &[u8] = include_bytes!("../corpus/outlines/three.geojson");

/// Begins with files: heights, outlines, rotations.
fn begin(heights: &[u8], outlines: Option<&[u8]>, rotations: Option<&[u8]>) {
    let image = ImageStart {
        heights: "heights".into(),
        plate_polygons: outlines.map(|_| "outlines".into()),
        plate_rotations: rotations.map(|_| "rotations".into()),
        ..ImageStart::default()
    };
    let world = import::read_with(&image, |name| {
        let bytes = match name {
            "heights" => Some(heights),
            "outlines" => outlines,
            _ => rotations,
        };
        Ok(Cursor::new(bytes.unwrap_or_default()))
    });
    let world = match world {
        Ok(world) => world,
        Err(error) => return read(&error),
    };
    let recipe = Recipe::earth_like(1).with_sub_plates(250);
    match History::imported(recipe, world, SimulationPlugins) {
        Ok(mut history) => match history.step() {
            Ok(()) => assert_eq!(history.check(), Ok(())),
            Err(error) => read(&error),
        },
        Err(error) => read(&error),
    }
}

/// Height maps, as they are and with checksums that fit.
pub fn height_map(data: &[u8]) {
    begin(data, None, None);
    begin(&seal::png(data), None, None);
}

/// Outlines of plates.
pub fn outlines(data: &[u8]) {
    begin(PICTURE, Some(data), None);
}

/// Motions of plates.
pub fn rotations(data: &[u8]) {
    begin(PICTURE, Some(OUTLINES), Some(data));
}
