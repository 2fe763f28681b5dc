//! Grows a planet without a window and writes its maps.
//!
//! ```text
//! cargo run --release --no-default-features --features export --example generate -- \
//!     --seed 7 --sub-plates 10000 --duration 250 --width 2048 --out target/planet
//! ```
//!
//! Exit code 0: the planet is written. 1: the folder cannot be written or the history failed.
//! 2: a flag or the recipe is wrong.

mod flags;
mod gauge;
mod outputs;
mod start;

#[cfg(feature = "save")]
use bevy_tectonics::save;
use bevy_tectonics::{
    export::{FILES, HISTORY_FILE, Maps, check_folder, write_history, write_planet},
    simulation::{History, Recipe, StatisticsInterval, Workers},
};
use clap::{Parser, error::ErrorKind};
use flags::Flags;
use gauge::Gauge;
use outputs::Reel;
use start::begin;
use std::{
    fmt::Display,
    io::{Write, stdout},
    ops::ControlFlow,
    path::Path,
    process::ExitCode,
    time::{Duration, Instant},
};

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
    let prepared = prepare(&flags).and_then(|(recipe, maps)| {
        let history = begin(&flags, recipe)?;
        let (start_my, end_my) = (history.time_my(), history.recipe().duration_my);
        flags.outputs.validate_span(start_my, end_my)?;
        Ok((history, maps))
    });
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
    let recipe = start::recipe(flags)?;
    recipe.validate().map_err(|error| error.to_string())?;
    let mut maps = Maps::new(flags.width);
    maps.threads = flags.threads.unwrap_or(maps.threads);
    maps.validate().map_err(|error| error.to_string())?;
    flags.outputs.validate(&maps)?;
    Ok((recipe, maps))
}

fn grow(flags: &Flags, mut history: History, maps: &Maps) -> Result<(), String> {
    let text = |error: &dyn Display| error.to_string();
    // Before the long run: a planet that cannot be written is not worth growing.
    let optional = flags.outputs.files();
    let history_file = flags.history.map(|_| HISTORY_FILE);
    let files = FILES.into_iter().chain(optional).chain(history_file);
    check_folder(&flags.out, files).map_err(|error| text(&error))?;
    save(flags, &mut history)?;
    let workers = Workers::new(maps.threads);
    history.world_mut().insert_resource(workers);
    if let Some(interval_my) = flags.history {
        let world = history.world_mut();
        world.insert_resource(StatisticsInterval(interval_my));
        history.record_statistics().map_err(|error| text(&error))?;
    }
    let (outputs, end_my) = (&flags.outputs, history.recipe().duration_my);
    let mut reels = outputs.reels(maps, &flags.out, history.time_my(), end_my)?;
    let seconds = run(flags, &mut history, &mut reels)?;
    let mut files =
        write_planet(&mut history, seconds, &flags.out, maps).map_err(|error| text(&error))?;
    if flags.history.is_some() {
        // The end belongs to the history, wherever the interval puts the last moment.
        history.record_statistics().map_err(|error| text(&error))?;
        let file = write_history(&history.statistics_history(), &flags.out);
        files.push(file.map_err(|error| text(&error))?);
    }
    for reel in reels {
        files.extend(reel.finish()?);
    }
    files.extend(outputs.write(&mut history, maps, &flags.out)?);
    // Some files are part of two of them.
    files.sort();
    files.dedup();
    let code = is_told_by_its_recipe(flags).then(|| history.recipe().to_string());
    report(&mut history, seconds, &flags.out, files.len(), code)
}

/// Grows a history to its end, saves it and takes pictures on the way, and returns the seconds it cost without the
/// pictures.
fn run(flags: &Flags, history: &mut History, reels: &mut [Reel]) -> Result<f64, String> {
    let started = Instant::now();
    let mut drawing = Duration::ZERO;
    let end_my = history.recipe().duration_my;
    let mut display = Gauge::new(flags.quiet, end_my);
    check(flags, history)?;
    loop {
        let mut due_my = f64::INFINITY;
        let paused = Instant::now();
        for reel in &mut *reels {
            reel.take(history)?;
            due_my = due_my.min(reel.due_my());
        }
        drawing += paused.elapsed();
        if history.time_my() >= end_my {
            break;
        }
        let before = history.progress(end_my);
        let tenth = (10.0 * before.fraction).floor();
        history
            .run_until(end_my, |progress| {
                display.show(progress);
                let is_saved = 10.0 * progress.fraction >= tenth + 1.0;
                let is_shown = progress.time_my >= due_my;
                if is_saved || is_shown || flags.check && progress.steps > before.steps {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            })
            .map_err(|error| error.to_string())?;
        check(flags, history)?;
        if (10.0 * history.progress(end_my).fraction).floor() > tenth {
            save(flags, history)?;
        }
    }
    display.finish();
    Ok((started.elapsed() - drawing).as_secs_f64())
}

/// Checks the planet, if that was asked for.
fn check(flags: &Flags, history: &mut History) -> Result<(), String> {
    if flags.check {
        history.check().map_err(|error| {
            let (steps, time_my) = (history.steps(), history.time_my());
            format!("after step {steps} at {time_my:.2} My: {error}")
        })?;
    }
    Ok(())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flags::tests::parse;
    use std::fs;

    fn generate(flags: &[&str]) -> Result<(), String> {
        let flags = parse(flags).unwrap();
        let (recipe, maps) = prepare(&flags)?;
        grow(&flags, begin(&flags, recipe)?, &maps)
    }

    #[cfg(feature = "save")]
    #[test]
    fn a_run_in_two_parts_ends_like_one() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        use bevy_tectonics::simulation::SimulationPlugins;
        let run = |flags: &[&str]| {
            let out = file("planet");
            let flags = [flags, &["--width", "64", "--quiet", "--out", &out]].concat();
            generate(&flags)
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
    fn every_flag_writes_what_it_says() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().to_str().unwrap();
        let planet = [
            "--sub-plates",
            "480",
            "--seed",
            "3",
            "--duration",
            "6",
            "--width",
            "64",
        ];
        let more = [
            "--quiet",
            "--history",
            "2",
            "--tables",
            "--geography",
            "--rotations",
            "1",
        ];
        let pictures = [
            "--textures",
            "--cube",
            "16",
            "--globe",
            "16",
            "--frames",
            "3",
            "--film",
            "2",
        ];
        generate(&[&planet[..], &more, &pictures, &["--out", out]].concat()).unwrap();
        let mut names: Vec<String> = fs::read_dir(folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        let faces = |kind: &str| {
            ["nx", "ny", "nz", "px", "py", "pz"].map(|face| format!("{kind}_{face}.png"))
        };
        let mut expected: Vec<String> = [
            "age.png",
            "boundaries.geojson",
            "colour.png",
            "crust.png",
            "elevation.png",
            "history.csv",
            "history.png",
            "map.png",
            "map_0000.png",
            "map_0001.png",
            "map_0002.png",
            "normal.png",
            "planet.glb",
            "planet.json",
            "plate.png",
            "plates.csv",
            "plates.geojson",
            "poles.geojson",
            "rotations.rot",
            "sub_plates.csv",
            "velocity_east.png",
            "velocity_north.png",
        ]
        .map(String::from)
        .into();
        expected.extend(
            ["elevation", "normal", "colour"]
                .into_iter()
                .flat_map(faces),
        );
        expected.sort();
        assert_eq!(names, expected);
        // Lines for every My or every step where that is longer, from the history that was recorded.
        let rotations = fs::read_to_string(folder.path().join("rotations.rot")).unwrap();
        let ages: Vec<f64> = rotations
            .lines()
            .filter(|line| line.starts_with("1 "))
            .map(|line| line.split_whitespace().nth(1).unwrap().parse().unwrap())
            .collect();
        assert_eq!((ages[0], ages.last()), (0.0, Some(&6.0)), "{rotations}");
        assert!(ages.windows(2).all(|ages| ages[1] - ages[0] < 2.0));
    }

    #[test]
    fn outputs_are_checked_before_the_long_run() {
        for (flags, expected) in [
            (&["--cube", "7"][..], "from 8 to 8192"),
            (&["--globe", "5000"], "from 8 to 4096"),
            (&["--film", "1", "--width", "8192"], "16 to 4096"),
        ] {
            let message = prepare(&parse(flags).unwrap()).unwrap_err();
            assert!(message.contains(expected), "{message}");
        }
        let flags = parse(&["--frames", "0.001"]).unwrap();
        let message = flags.outputs.validate_span(0.0, 50.0).unwrap_err();
        assert!(message.contains("50001 maps"), "{message}");
    }
}
