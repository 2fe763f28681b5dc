//! Grows a planet without a window and writes its maps.
//!
//! ```text
//! cargo run --release --no-default-features --features export --example generate -- \
//!     --seed 7 --sub-plates 10000 --duration 250 --width 2048 --out target/planet
//! ```
//!
//! Exit code 0: the planet is written. 1: the folder cannot be written or the history failed.
//! 2: a flag or the recipe is wrong.

use std::{
    fmt::Display,
    fs,
    io::{IsTerminal, Write, stderr, stdout},
    ops::{ControlFlow, RangeInclusive},
    path::{Path, PathBuf},
    process::ExitCode,
    str::FromStr,
    time::Instant,
};

#[cfg(feature = "save")]
use bevy_tectonics::save;
use bevy_tectonics::{
    export::{Maps, check_folder, write_history, write_planet},
    import,
    simulation::{
        Drive, History, Hypsometry, ImageStart, Outcome, Progress, Recipe, RecipeError,
        SimulationPlugins, Start, StatisticsInterval, Workers,
    },
};
use clap::{Parser, error::ErrorKind};
use indicatif::{ProgressBar, ProgressStyle};
use serde::de::DeserializeOwned;
use serde_json::Value;

/// Grow a planet by plate tectonics and write its maps.
///
/// The same flags grow the same planet, bit for bit, on any machine and with any number of threads.
#[derive(Parser, Debug)]
#[command(version)]
struct Flags {
    /// The planet's seed, 0 to 18446744073709551615 [default: 0, or the recipe's]
    #[arg(long, value_name = "N", value_parser = seed, allow_hyphen_values = true)]
    seed: Option<u64>,

    /// Number of sub-plates: more give finer planets and take longer [default: the recipe's]
    #[arg(long, value_name = "N", value_parser = sub_plates, allow_hyphen_values = true)]
    sub_plates: Option<u32>,

    /// Length of the history in millions of years [default: the recipe's]
    #[arg(long, value_name = "MY", value_parser = duration, allow_hyphen_values = true)]
    duration: Option<f64>,

    /// Width of the maps in pixels, even, 16 to 16384; they are half as high
    #[arg(long, value_name = "PIXELS", default_value = "2048", value_parser = width, allow_hyphen_values = true)]
    width: u32,

    /// Folder for the maps; created where it does not exist
    #[arg(long, value_name = "FOLDER", default_value = "target/planet")]
    out: PathBuf,

    /// How the planet begins: flood-fill, voronoi, hypsometric (with Earth's curve) or image (see
    /// --image); or what a recipe has there, in JSON [default: the recipe's]
    #[arg(long, value_name = "WAY", value_parser = start)]
    start: Option<Start>,

    /// Height map to begin with: a PNG, grey with 8 or 16 bits, equirectangular; means --start image
    #[arg(long, value_name = "FILE")]
    image: Option<String>,

    /// Height of black in the image, in metres [default: the recipe's, or -32768]
    #[arg(long, value_name = "M", allow_hyphen_values = true)]
    lowest: Option<f64>,

    /// Height of white in the image, in metres [default: the recipe's, or 32767]
    #[arg(long, value_name = "M", allow_hyphen_values = true)]
    highest: Option<f64>,

    /// Outlines of the image's plates: a `GeoJSON` file of polygons
    #[arg(long, value_name = "FILE")]
    plate_polygons: Option<String>,

    /// First motions of those plates: a JSON file, `{"AF": {"lat": 12, "lon": -70, "deg_per_my": 0.6}}`
    #[arg(long, value_name = "FILE")]
    plate_rotations: Option<String>,

    /// What moves plates: soft, rigid, foundering or prescribed [default: the recipe's]
    #[arg(long, value_name = "WAY", value_parser = kebab::<Drive>)]
    drive: Option<Drive>,

    /// Threads to use, 1 to 256 [default: one per core]
    #[arg(long, value_name = "N", value_parser = threads, allow_hyphen_values = true)]
    threads: Option<usize>,

    /// Recipe to start from: a file (JSON, also a planet.json, or RON) or a share code; other flags
    /// override it
    #[arg(long, value_name = "FILE|CODE")]
    recipe: Option<PathBuf>,

    /// Save the planet every tenth of the way and at its end, to go on from with --resume
    #[cfg(feature = "save")]
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,

    /// Go on from a saved planet, for --duration from its start [default: its recipe's]
    #[cfg(feature = "save")]
    #[arg(long, value_name = "FILE", conflicts_with_all = [
        "recipe", "seed", "sub_plates", "start", "image", "lowest", "highest", "plate_polygons",
        "plate_rotations", "drive",
    ])]
    resume: Option<PathBuf>,

    /// Also write history.csv: what the planet measures, every so many million years
    #[arg(long, value_name = "MY", num_args = 0..=1, default_missing_value = "10", value_parser = interval)]
    history: Option<f64>,

    /// Show no progress
    #[arg(long)]
    quiet: bool,

    /// Check every invariant of the planet after every step (slow)
    #[arg(long)]
    check: bool,
}

fn main() -> ExitCode {
    let flags = match Flags::try_parse() {
        Ok(flags) => flags,
        Err(error) if error.kind() == ErrorKind::ValueValidation => {
            // Its first line says it all: flag, value and what is allowed.
            let message = error.to_string();
            eprintln!("{}", message.lines().next().unwrap_or_default());
            return ExitCode::from(2);
        }
        Err(error) => error.exit(),
    };
    let prepared = prepare(&flags).and_then(|(recipe, maps)| Ok((begin(&flags, recipe)?, maps)));
    match prepared {
        Err(message) => fail(2, &message),
        Ok((history, maps)) => grow(&flags, history, &maps)
            .map_or_else(|message| fail(1, &message), |()| ExitCode::SUCCESS),
    }
}

fn fail(code: u8, message: &str) -> ExitCode {
    eprintln!("error: {message}");
    ExitCode::from(code)
}

/// Everything that can be wrong before anything is done.
fn prepare(flags: &Flags) -> Result<(Recipe, Maps), String> {
    let recipe = recipe(flags)?;
    recipe.validate().map_err(|error| error.to_string())?;
    let mut maps = Maps::new(flags.width);
    maps.threads = flags.threads.unwrap_or(maps.threads);
    maps.validate().map_err(|error| error.to_string())?;
    Ok((recipe, maps))
}

fn recipe(flags: &Flags) -> Result<Recipe, String> {
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
fn begin(flags: &Flags, recipe: Recipe) -> Result<History, String> {
    #[cfg(feature = "save")]
    if let Some(path) = &flags.resume {
        return resume(path, flags.duration);
    }
    let _ = flags;
    import::begin(recipe, SimulationPlugins).map_err(|error| error.to_string())
}

/// Goes on from a save until a time in My.
#[cfg(feature = "save")]
fn resume(path: &Path, duration_my: Option<f64>) -> Result<History, String> {
    let text = |error: &dyn Display| format!("cannot go on from {}: {error}", path.display());
    let mut history = save::read(path, SimulationPlugins).map_err(|error| text(&error))?;
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
    let text = match fs::read_to_string(path) {
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

/// The same recipe with its files looked for beside that of the recipe.
fn beside(mut recipe: Recipe, path: &Path) -> Recipe {
    if let (Start::Image(image), Some(folder)) = (&recipe.start, path.parent()) {
        recipe.start = Start::Image(import::beside(folder, image));
    }
    recipe
}

fn grow(flags: &Flags, mut history: History, maps: &Maps) -> Result<(), String> {
    let text = |error: &dyn Display| error.to_string();
    // Before the long run: a planet that cannot be written is not worth growing.
    check_folder(&flags.out).map_err(|error| text(&error))?;
    let started = Instant::now();
    let duration = history.recipe().duration_my;
    save(flags, &mut history)?;
    let workers = Workers::new(maps.threads);
    history.world_mut().insert_resource(workers);
    if let Some(interval_my) = flags.history {
        let world = history.world_mut();
        world.insert_resource(StatisticsInterval(interval_my));
        history.record_statistics().map_err(|error| text(&error))?;
    }
    let mut display = Gauge::new(flags.quiet, duration);
    loop {
        let before = history.progress(duration);
        let tenth = (10.0 * before.fraction).floor();
        let outcome = history
            .run_until(duration, |progress| {
                display.show(progress);
                let is_saved = 10.0 * progress.fraction >= tenth + 1.0;
                if is_saved || flags.check && progress.steps > before.steps {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            })
            .map_err(|error| text(&error))?;
        if flags.check {
            history.check().map_err(|error| {
                format!(
                    "after step {} at {:.2} My: {error}",
                    history.steps(),
                    history.time_my()
                )
            })?;
        }
        if (10.0 * history.progress(duration).fraction).floor() > tenth {
            save(flags, &mut history)?;
        }
        if outcome == Outcome::Finished {
            break;
        }
    }
    display.finish();
    let seconds = started.elapsed().as_secs_f64();
    let mut files =
        write_planet(&mut history, seconds, &flags.out, maps).map_err(|error| text(&error))?;
    if flags.history.is_some() {
        // The end belongs to the history, wherever the interval puts the last moment.
        history.record_statistics().map_err(|error| text(&error))?;
        let file = write_history(&history.statistics_history(), &flags.out);
        files.push(file.map_err(|error| text(&error))?);
    }
    let code = is_told_by_its_recipe(flags).then(|| history.recipe().to_string());
    report(&mut history, seconds, &flags.out, files.len(), code)
}

/// Saves the planet, if that was asked for.
fn save(flags: &Flags, history: &mut History) -> Result<(), String> {
    #[cfg(feature = "save")]
    if let Some(path) = &flags.save {
        save::write(history, path).map_err(|error| format!("cannot save: {error}"))?;
    }
    let _ = (flags, history);
    Ok(())
}

/// Whether the recipe alone grows the planet again. Where a save ended, a step did.
fn is_told_by_its_recipe(flags: &Flags) -> bool {
    #[cfg(feature = "save")]
    if flags.resume.is_some() && flags.duration.is_some() {
        return false;
    }
    let _ = flags;
    true
}

/// Prints what was grown.
fn report(
    history: &mut History,
    seconds: f64,
    folder: &Path,
    files: usize,
    code: Option<String>,
) -> Result<(), String> {
    let statistics = history.statistics().map_err(|error| error.to_string())?;
    let hash = history.state_hash().map_err(|error| error.to_string())?;
    let text = format!(
        "{time:.0} My in {steps} steps, {seconds:.1} s\n\
         land             {land:6.1} %\n\
         plates           {plates:6}\n\
         mean speed       {speed:6.1} mm/yr\n\
         oldest sea floor {oldest:6.0} My\n\
         state hash       {hash:016x}\n\
         {code}\
         {files} files in       {folder}\n",
        code = code.map_or_else(String::new, |code| format!("share code       {code}\n")),
        time = history.time_my(),
        steps = history.steps(),
        land = 100.0 * statistics.land_share,
        plates = statistics.plates,
        speed = statistics.speed_mean,
        oldest = statistics.ocean_age_oldest_my,
        folder = folder.display(),
    );
    match stdout().write_all(text.as_bytes()) {
        // Whoever reads us has read enough.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        result => result.map_err(|error| format!("cannot print the summary: {error}")),
    }
}

/// Progress on stderr: a bar in a terminal, otherwise a line every tenth.
enum Gauge {
    Nothing,
    Bar(ProgressBar),
    Lines { tenths: u32 },
}

impl Gauge {
    fn new(quiet: bool, duration_my: f64) -> Self {
        if quiet {
            return Self::Nothing;
        }
        if !stderr().is_terminal() {
            return Self::Lines { tenths: 0 };
        }
        let template = "{bar:40} {percent:>3} %  {msg}  {elapsed} gone, {eta} to go";
        let style =
            ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::new(1000).with_style(style);
        bar.set_message(format!("0 of {duration_my:.0} My"));
        Self::Bar(bar)
    }

    fn show(&mut self, progress: &Progress) {
        let place = || {
            format!(
                "{:.0} of {:.0} My, step {}",
                progress.time_my, progress.end_my, progress.steps
            )
        };
        match self {
            Self::Nothing => {}
            Self::Bar(bar) => {
                bar.set_message(place());
                bar.set_position((progress.fraction * 1000.0) as u64);
            }
            Self::Lines { tenths } => {
                let reached = (progress.fraction * 10.0) as u32;
                if reached > *tenths {
                    *tenths = reached;
                    eprintln!("{} %: {}", reached * 10, place());
                }
            }
        }
    }

    fn finish(&self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

fn number<T: FromStr + PartialOrd>(
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

fn interval(text: &str) -> Result<f64, String> {
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
mod tests {
    use super::*;

    fn parse(flags: &[&str]) -> Result<Flags, clap::Error> {
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
        assert!(prepare(&flags).is_ok());
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

    #[cfg(feature = "save")]
    #[test]
    fn a_run_in_two_parts_ends_like_one() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        let run = |flags: &[&str]| {
            let out = file("planet");
            let flags = [flags, &["--width", "64", "--quiet", "--out", &out]].concat();
            let flags = parse(&flags).unwrap();
            let (recipe, maps) = prepare(&flags).unwrap();
            grow(&flags, begin(&flags, recipe)?, &maps)
        };
        let planet = ["--sub-plates", "480", "--seed", "3", "--duration", "10"];
        run(&[&planet[..], &["--save", &file("a")]].concat()).unwrap();
        run(&[
            "--resume",
            &file("a"),
            "--duration",
            "20",
            "--save",
            &file("b"),
        ])
        .unwrap();
        let mut once = save::read(Path::new(&file("a")), SimulationPlugins).unwrap();
        once.world_mut().resource_mut::<Recipe>().duration_my = 20.0;
        once.run_until(20.0, |_| ControlFlow::Continue(())).unwrap();
        let twice = save::read(Path::new(&file("b")), SimulationPlugins);
        assert_eq!(twice.unwrap().state_hash(), once.state_hash());
        let back = run(&["--resume", &file("b"), "--duration", "15"]).unwrap_err();
        assert!(back.contains("20 My"), "{back}");
        assert!(
            run(&["--resume", &file("none")])
                .unwrap_err()
                .contains("none")
        );
        assert!(parse(&["--resume", "a", "--seed", "3"]).is_err());
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
