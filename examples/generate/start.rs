//! From flags to the first moment of a history, or to the last one of a save.

use crate::flags::Flags;
#[cfg(feature = "save")]
use bevy::app::PluginGroupBuilder;
#[cfg(feature = "save")]
use bevy_tectonics::save;
use bevy_tectonics::{
    import,
    simulation::{History, ImageStart, Recipe, RecipeError, Start},
};
use serde_json::Value;
use std::{
    fmt::Display,
    fs::File,
    io::{self, Read},
    path::Path,
};

pub fn recipe(flags: &Flags) -> Result<Recipe, String> {
    let mut recipe = match &flags.recipe {
        Some(path) => read_recipe(path)?,
        None => Recipe::earth_like(flags.seed.unwrap_or(0)),
    };
    recipe.seed = flags.seed.unwrap_or(recipe.seed);
    if let Some(sub_plates) = flags.sub_plates {
        recipe = recipe.with_sub_plates(sub_plates);
    }
    recipe.duration_my = flags.duration.unwrap_or(recipe.duration_my);
    recipe.start = start_of(flags, recipe.start)?;
    recipe.drive = flags.drive.unwrap_or(recipe.drive);
    Ok(recipe)
}

/// The start that the flags ask for, beginning with that of the recipe.
fn start_of(flags: &Flags, recipe: Start) -> Result<Start, String> {
    let named = match &flags.start {
        // Its name alone keeps what the recipe says of it.
        Some(Start::Image(image)) if *image == ImageStart::default() => match recipe {
            Start::Image(image) => Start::Image(image),
            _ => Start::Image(ImageStart::default()),
        },
        Some(start) => start.clone(),
        None => recipe,
    };
    let mut image = match (named, &flags.image) {
        (Start::Image(image), _) => image,
        (_, Some(_)) if flags.start.is_none() => ImageStart::default(),
        (other, _) => {
            let own = [
                ("--image", flags.image.is_some()),
                ("--lowest", flags.lowest.is_some()),
                ("--highest", flags.highest.is_some()),
                ("--plate-polygons", flags.plate_polygons.is_some()),
                ("--plate-rotations", flags.plate_rotations.is_some()),
            ];
            return match own.into_iter().find(|(_, given)| *given) {
                Some((flag, _)) => Err(format!("{flag} is of no use without --start image")),
                None => Ok(other),
            };
        }
    };
    image.heights = flags.image.clone().unwrap_or(image.heights);
    image.lowest_m = flags.lowest.unwrap_or(image.lowest_m);
    image.highest_m = flags.highest.unwrap_or(image.highest_m);
    image.plate_polygons = flags.plate_polygons.clone().or(image.plate_polygons);
    image.plate_rotations = flags.plate_rotations.clone().or(image.plate_rotations);
    Ok(Start::Image(image))
}

/// The first moment of a recipe, with the files it names, or the last one of a save.
pub fn begin(flags: &Flags, recipe: Recipe) -> Result<History, String> {
    let plugins = flags.outputs.plugins();
    #[cfg(feature = "save")]
    if let Some(path) = &flags.resume {
        return resume(path, flags.duration, plugins);
    }
    import::begin(recipe, plugins).map_err(|error| error.to_string())
}

/// Goes on from a save until a time in My.
#[cfg(feature = "save")]
fn resume(
    path: &Path,
    duration_my: Option<f64>,
    plugins: PluginGroupBuilder,
) -> Result<History, String> {
    let text = |error: &dyn Display| format!("cannot go on from {}: {error}", path.display());
    let mut history = save::read(path, plugins).map_err(|error| text(&error))?;
    if let Some(duration_my) = duration_my {
        let longer = history.recipe().clone().with_duration(duration_my);
        longer.validate().map_err(|error| text(&error))?;
        history.world_mut().insert_resource(longer);
    }
    let (now, end) = (history.time_my(), history.recipe().duration_my);
    if end < now {
        let error = format!("it is {now} My old already, and --duration is {end}");
        return Err(text(&error));
    }
    Ok(history)
}

/// Reads a recipe, or the recipe of a planet that was written before.
fn read_recipe(path: &Path) -> Result<Recipe, String> {
    let wrong =
        |error: &dyn Display| format!("cannot read a recipe from {}: {error}", path.display());
    let text = match text_of(path) {
        Ok(text) => text,
        // What is no file may be a code.
        Err(error) => {
            let code = path.to_string_lossy();
            return code.parse().map_err(|no_code: RecipeError| {
                format!("{}, nor from a code: {no_code}", wrong(&error))
            });
        }
    };
    if !text.trim_start().starts_with('{') {
        let recipe: Recipe = text.parse().map_err(|error: RecipeError| wrong(&error))?;
        return Ok(beside(recipe, path));
    }
    let mut value: Value = serde_json::from_str(&text).map_err(|error| wrong(&error))?;
    if let Some(inner) = value.get_mut("recipe") {
        value = inner.take();
    }
    let recipe = serde_json::from_value(value).map_err(|error| wrong(&error))?;
    Ok(beside(recipe, path))
}

/// Largest recipe that is read, in bytes.
const LARGEST: u64 = 16 << 20;

/// The text of a file, which may also be a pipe.
fn text_of(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    let length = File::open(path)?
        .take(LARGEST + 1)
        .read_to_string(&mut text)?;
    if length as u64 > LARGEST {
        return Err(io::Error::other("it is larger than 16 megabytes"));
    }
    Ok(text)
}

/// The same recipe with its files looked for beside that of the recipe.
fn beside(mut recipe: Recipe, path: &Path) -> Recipe {
    if let (Start::Image(image), Some(folder)) = (&recipe.start, path.parent()) {
        recipe.start = Start::Image(import::beside(folder, image));
    }
    recipe
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{flags::tests::parse, prepare};
    use bevy_tectonics::simulation::Hypsometry;
    use std::fs;

    #[test]
    fn starts_are_names_or_json() {
        let start = |text: &str| prepare(&parse(&["--start", text]).unwrap()).map(|(r, _)| r.start);
        assert_eq!(start("voronoi"), Ok(Start::Voronoi));
        let earth = Hypsometry::default();
        assert_eq!(start("hypsometric"), Ok(Start::Hypsometric(earth)));
        let curve = Hypsometry::Curve(vec![(0.0, -5000.0), (1.0, 2000.0)]);
        assert_eq!(
            start(r#"{"hypsometric": {"curve": [[0, -5000], [1, 2000]]}}"#),
            Ok(Start::Hypsometric(curve))
        );
        let wrong = start(r#"{"hypsometric": {"curve": [[0, -5000]]}}"#).unwrap_err();
        assert!(wrong.contains("curve.length is 1"), "{wrong}");
    }

    #[test]
    fn an_image_has_flags_of_its_own() {
        let start = |flags: &[&str]| prepare(&parse(flags).unwrap()).map(|(r, _)| r.start);
        let image = ImageStart {
            heights: "earth.png".into(),
            lowest_m: -11_000.0,
            plate_polygons: Some("plates.json".into()),
            ..ImageStart::default()
        };
        let flags = ["--image", "earth.png", "--lowest", "-11000"];
        let flags = [&flags[..], &["--plate-polygons", "plates.json"]].concat();
        assert_eq!(start(&flags), Ok(Start::Image(image.clone())));
        let named = [&flags[..], &["--start", "image"]].concat();
        assert_eq!(start(&named), Ok(Start::Image(image)));
        for wrong in [
            &["--plate-polygons", "plates.json"][..],
            &["--start", "voronoi", "--image", "earth.png"],
        ] {
            assert!(start(wrong).unwrap_err().contains("--start image"));
        }
        for (wrong, message) in [
            (["--start", "image"], "start.image.heights is empty"),
            (["--image", "no-such.png"], "no-such.png"),
        ] {
            let flags = parse(&wrong).unwrap();
            let (recipe, _) = prepare(&flags).unwrap();
            let error = begin(&flags, recipe).unwrap_err();
            assert!(error.contains(message), "{error}");
        }
    }

    #[test]
    fn a_recipe_may_be_a_code_or_a_text() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("recipe.ron");
        let recipe = Recipe::earth_like(99).with_duration(12.5);
        fs::write(&path, format!("{recipe:#}")).unwrap();
        for source in [recipe.to_string().as_str(), path.to_str().unwrap()] {
            let (read, _) = prepare(&parse(&["--recipe", source]).unwrap()).unwrap();
            assert_eq!(read, recipe);
        }
        let wrong = prepare(&parse(&["--recipe", "no-such.json"]).unwrap()).unwrap_err();
        assert!(
            wrong.contains("no-such.json") && wrong.contains("code"),
            "{wrong}"
        );
    }

    #[test]
    fn files_beside_a_recipe_are_found() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("recipe.json");
        fs::write(folder.path().join("map.png"), "").unwrap();
        let text =
            r#"{"start": {"image": {"heights": "map.png", "plate_polygons": "elsewhere.json"}}}"#;
        fs::write(&path, text).unwrap();
        let flags = parse(&["--recipe", path.to_str().unwrap()]).unwrap();
        let Ok((
            Recipe {
                start: Start::Image(image),
                ..
            },
            _,
        )) = prepare(&flags)
        else {
            panic!("no image");
        };
        assert_eq!(Path::new(&image.heights), folder.path().join("map.png"));
        assert_eq!(image.plate_polygons.as_deref(), Some("elsewhere.json"));
    }

    #[test]
    fn the_recipe_refuses_what_it_cannot_grow() {
        for (flag, field, allowed, values) in [
            (
                "--sub-plates",
                "sub_plates",
                "between 200 and 2000000",
                ["199", "2000001"],
            ),
            (
                "--duration",
                "duration_my",
                "between 0 and 10000",
                ["-5", "10000.5"],
            ),
            (
                "--duration",
                "duration_my",
                "between 0 and 10000",
                ["NaN", "inf"],
            ),
        ] {
            for value in values {
                let message = prepare(&parse(&[flag, value]).unwrap()).unwrap_err();
                assert!(
                    message.contains(field) && message.contains(allowed),
                    "{message}"
                );
                assert_eq!(message.lines().count(), 1);
            }
        }
    }

    #[test]
    fn flags_override_a_recipe_and_a_planet_is_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("planet.json");
        let mut recipe = Recipe::earth_like(99);
        recipe.duration_my = 123.0;
        let planet = serde_json::json!({ "recipe": recipe, "steps": 5 });
        for value in [planet, serde_json::to_value(&recipe).unwrap()] {
            fs::write(&path, value.to_string()).unwrap();
            let file = path.to_str().unwrap();
            let (read, _) = prepare(&parse(&["--recipe", file, "--seed", "5"]).unwrap()).unwrap();
            assert_eq!((read.seed, read.duration_my), (5, 123.0));
        }
        fs::write(&path, "{").unwrap();
        let flags = parse(&["--recipe", path.to_str().unwrap()]).unwrap();
        assert!(prepare(&flags).unwrap_err().contains("planet.json"));
    }
}
