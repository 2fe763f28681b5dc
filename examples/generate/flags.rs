//! The command line.

use crate::outputs::Outputs;
use bevy_tectonics::{
    export::Maps,
    simulation::{Drive, Hypsometry, ImageStart, Start},
};
use clap::Parser;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::{ops::RangeInclusive, path::PathBuf, str::FromStr};

/// Grow a planet by plate tectonics and write its maps.
///
/// The same flags grow the same planet, bit for bit, on any machine and with any number of threads.
#[derive(Parser, Debug)]
#[command(version)]
pub struct Flags {
    /// The planet's seed, 0 to 18446744073709551615 [default: 0, or the recipe's]
    #[arg(long, value_name = "N", value_parser = seed, allow_hyphen_values = true)]
    pub seed: Option<u64>,

    /// Number of sub-plates: more give finer planets and take longer [default: the recipe's]
    #[arg(long, value_name = "N", value_parser = sub_plates, allow_hyphen_values = true)]
    pub sub_plates: Option<u32>,

    /// Length of the history in millions of years [default: the recipe's]
    #[arg(long, value_name = "MY", value_parser = duration, allow_hyphen_values = true)]
    pub duration: Option<f64>,

    /// Width of the maps in pixels, even, 16 to 16384; they are half as high
    #[arg(long, value_name = "PIXELS", default_value = "2048", value_parser = width, allow_hyphen_values = true)]
    pub width: u32,

    /// Folder for the maps; created where it does not exist
    #[arg(long, value_name = "FOLDER", default_value = "target/planet")]
    pub out: PathBuf,

    /// How the planet begins: flood-fill, voronoi, hypsometric (with Earth's curve) or image (see
    /// --image); or what a recipe has there, in JSON [default: the recipe's]
    #[arg(long, value_name = "WAY", value_parser = start)]
    pub start: Option<Start>,

    /// Height map to begin with: a PNG, grey with 8 or 16 bits, equirectangular; means --start image
    #[arg(long, value_name = "FILE")]
    pub image: Option<String>,

    /// Height of black in the image, in metres [default: the recipe's, or -32768]
    #[arg(long, value_name = "M", allow_hyphen_values = true)]
    pub lowest: Option<f64>,

    /// Height of white in the image, in metres [default: the recipe's, or 32767]
    #[arg(long, value_name = "M", allow_hyphen_values = true)]
    pub highest: Option<f64>,

    /// Outlines of the image's plates: a `GeoJSON` file of polygons
    #[arg(long, value_name = "FILE")]
    pub plate_polygons: Option<String>,

    /// First motions of those plates: a JSON file, `{"AF": {"lat": 12, "lon": -70, "deg_per_my": 0.6}}`
    #[arg(long, value_name = "FILE")]
    pub plate_rotations: Option<String>,

    /// What moves plates: soft, rigid, foundering or prescribed [default: the recipe's]
    #[arg(long, value_name = "WAY", value_parser = kebab::<Drive>)]
    pub drive: Option<Drive>,

    /// Threads to use, 1 to 256 [default: one per core]
    #[arg(long, value_name = "N", value_parser = threads, allow_hyphen_values = true)]
    pub threads: Option<usize>,

    /// Recipe to start from: a file (JSON, also a planet.json, or RON) or a share code; other flags
    /// override it
    #[arg(long, value_name = "FILE|CODE")]
    pub recipe: Option<PathBuf>,

    /// Save the planet every tenth of the way and at its end, to go on from with --resume
    #[cfg(feature = "save")]
    #[arg(long, value_name = "FILE")]
    pub save: Option<PathBuf>,

    /// Go on from a saved planet, for --duration from its start [default: its recipe's]
    #[cfg(feature = "save")]
    #[arg(long, value_name = "FILE", conflicts_with_all = [
        "recipe", "seed", "sub_plates", "start", "image", "lowest", "highest", "plate_polygons",
        "plate_rotations", "drive",
    ])]
    pub resume: Option<PathBuf>,

    /// Also write history.csv: what the planet measures, every so many million years
    #[arg(long, value_name = "MY", num_args = 0..=1, default_missing_value = "10", value_parser = interval)]
    pub history: Option<f64>,

    #[command(flatten)]
    pub outputs: Outputs,

    /// Show no progress
    #[arg(long)]
    pub quiet: bool,

    /// Check every invariant of the planet after every step (slow)
    #[arg(long)]
    pub check: bool,
}

pub fn number<T: FromStr + PartialOrd>(
    text: &str,
    allowed: RangeInclusive<T>,
    hint: &str,
) -> Result<T, String> {
    text.parse()
        .ok()
        .filter(|value| allowed.contains(value))
        .ok_or_else(|| hint.to_owned())
}

fn seed(text: &str) -> Result<u64, String> {
    number(
        text,
        0..=u64::MAX,
        "it must be a whole number from 0 to 18446744073709551615",
    )
}

// Recipes know their own ranges and are checked as a whole: what a flag alone can get wrong is only
// that it is no number at all.
fn sub_plates(text: &str) -> Result<u32, String> {
    number(
        text,
        0..=u32::MAX,
        "it must be a whole number from 200 to 2000000",
    )
}

fn duration(text: &str) -> Result<f64, String> {
    text.parse()
        .map_err(|_| "it must be a number from 0 to 10000 (millions of years)".to_owned())
}

pub fn interval(text: &str) -> Result<f64, String> {
    number(
        text,
        f64::MIN_POSITIVE..=f64::MAX,
        "it must be a number above 0 (millions of years)",
    )
}

fn width(text: &str) -> Result<u32, String> {
    let hint = "it must be an even number from 16 to 16384";
    let width = number(text, Maps::WIDTHS, hint)?;
    if width % 2 == 0 {
        Ok(width)
    } else {
        Err(hint.to_owned())
    }
}

fn threads(text: &str) -> Result<usize, String> {
    number(
        text,
        Maps::THREADS,
        "it must be a whole number from 1 to 256",
    )
}

/// A start by its name alone, or as a recipe states it.
fn start(text: &str) -> Result<Start, String> {
    match text {
        "hypsometric" => Ok(Start::Hypsometric(Hypsometry::default())),
        "image" => Ok(Start::Image(ImageStart::default())),
        json if json.starts_with('{') => {
            serde_json::from_str(json).map_err(|error| error.to_string())
        }
        name => kebab(name),
    }
}

/// A choice by the name it has in a recipe.
fn kebab<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    serde_json::from_value(Value::from(text)).map_err(|error| error.to_string())
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use clap::error::ErrorKind;

    pub fn parse(flags: &[&str]) -> Result<Flags, clap::Error> {
        Flags::try_parse_from([&["generate"], flags].concat())
    }

    #[test]
    fn flags_are_well_formed() {
        use clap::CommandFactory;
        Flags::command().debug_assert();
        let flags = parse(&[]).unwrap();
        assert_eq!(
            (flags.width, flags.quiet, flags.check, flags.history),
            (2048, false, false, None)
        );
        let history = |flags: &[&str]| parse(flags).unwrap().history;
        assert_eq!(history(&["--history"]), Some(10.0));
        assert_eq!(history(&["--history", "2.5"]), Some(2.5));
        assert_eq!(history(&["--history", "--quiet"]), Some(10.0));
    }

    #[test]
    fn wrong_values_are_named_with_what_is_allowed() {
        for (flag, value, expected) in [
            ("--width", "15", "even number from 16 to 16384"),
            ("--width", "17", "even number from 16 to 16384"),
            ("--width", "16386", "even number from 16 to 16384"),
            ("--width", "wide", "even number from 16 to 16384"),
            ("--width", "-16", "even number from 16 to 16384"),
            ("--threads", "0", "from 1 to 256"),
            ("--threads", "257", "from 1 to 256"),
            ("--seed", "-1", "from 0 to 18446744073709551615"),
            ("--seed", "1.5", "from 0 to 18446744073709551615"),
            ("--sub-plates", "many", "from 200 to 2000000"),
            ("--sub-plates", "-1", "from 200 to 2000000"),
            ("--duration", "long", "from 0 to 10000"),
            ("--history", "0", "above 0"),
            ("--history", "inf", "above 0"),
            ("--start", "banana", "flood-fill"),
            ("--drive", "banana", "rigid"),
        ] {
            let error = parse(&[flag, value]).expect_err(flag);
            assert_eq!(
                (error.kind(), error.exit_code()),
                (ErrorKind::ValueValidation, 2)
            );
            let message = error.to_string();
            let line = message.lines().next().unwrap();
            assert!(line.contains(flag) && line.contains(expected), "{line}");
        }
    }
}
