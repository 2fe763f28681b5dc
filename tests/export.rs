//! The maps keep their promise: names, sizes, formats, places, and all or nothing.
#![cfg(feature = "export")]

use std::{
    fs::{self, File},
    io::BufReader,
    ops::ControlFlow,
    path::Path,
};

use bevy_tectonics::{
    export::{ExportError, FILES, Maps, check_folder, write_planet},
    simulation::{Crust, History, Recipe},
    surface::{Raster, direction},
};
use png::{BitDepth, ColorType};

const WIDTH: u32 = 128;
const HEIGHT: u32 = WIDTH / 2;
fn history() -> History {
    let mut recipe = Recipe::earth_like(3);
    recipe.sub_plates = 400;
    recipe.plates = 8;
    let mut history = History::with_threads(recipe, 1).unwrap();
    history
        .run_until(5.0, |_| ControlFlow::Continue(()))
        .unwrap();
    history
}

fn maps(threads: usize) -> Maps {
    Maps {
        width: WIDTH,
        threads,
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

fn read(path: &Path) -> (ColorType, BitDepth, Vec<u8>) {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap()))
        .read_info()
        .unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!(
        (info.width, info.height),
        (WIDTH, HEIGHT),
        "{}",
        path.display()
    );
    (info.color_type, info.bit_depth, bytes)
}

fn grey16(folder: &Path, name: &str) -> Vec<u16> {
    let (color, depth, bytes) = read(&folder.join(name));
    assert_eq!(
        (color, depth),
        (ColorType::Grayscale, BitDepth::Sixteen),
        "{name}"
    );
    bytes
        .chunks(2)
        .map(|pair| u16::from_be_bytes([pair[0], pair[1]]))
        .collect()
}

#[test]
fn maps_hold_what_the_surface_holds_at_pixel_centres() {
    let mut history = history();
    let surface = history.surface().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let paths = write_planet(&mut history, 1.5, folder.path(), &maps(2)).unwrap();
    assert_eq!(paths, FILES.map(|name| folder.path().join(name)));
    let mut expected = FILES;
    expected.sort_unstable();
    assert_eq!(names(folder.path()), expected);

    let elevation = grey16(folder.path(), "elevation.png");
    let age = grey16(folder.path(), "age.png");
    let plate = grey16(folder.path(), "plate.png");
    let east = grey16(folder.path(), "velocity_east.png");
    let north = grey16(folder.path(), "velocity_north.png");
    let (color, depth, crust) = read(&folder.path().join("crust.png"));
    assert_eq!((color, depth), (ColorType::Grayscale, BitDepth::Eight));
    let (color, depth, _) = read(&folder.path().join("map.png"));
    assert_eq!((color, depth), (ColorType::Rgb, BitDepth::Eight));

    let raster = Raster::new(&surface).unwrap();
    let decode = |value: u16| f64::from(value) - 32768.0;
    for y in (0..HEIGHT).step_by(5) {
        for x in (0..WIDTH).step_by(7) {
            let longitude = (-180.0 + (f64::from(x) + 0.5) * 360.0 / f64::from(WIDTH)).to_radians();
            let latitude = (90.0 - (f64::from(y) + 0.5) * 180.0 / f64::from(HEIGHT)).to_radians();
            let expected = raster.sample(direction(longitude, latitude));
            let at = (y * WIDTH + x) as usize;
            assert!((decode(elevation[at]) - f64::from(expected.elevation)).abs() <= 0.51);
            let continental = expected.crust == Crust::Continental;
            assert_eq!(crust[at], if continental { 255 } else { 0 });
            assert!(
                (f64::from(age[at]) - f64::from(expected.age * 10.0).min(65535.0)).abs() <= 0.51
            );
            assert_eq!(plate[at], expected.plate);

            // The part of the velocity along the ground, from its two components.
            let (sin_lon, cos_lon) = libm::sincos(longitude);
            let (sin_lat, cos_lat) = libm::sincos(latitude);
            let velocity = expected.velocity.as_dvec3();
            let along_east = -sin_lon * velocity.x + cos_lon * velocity.y;
            let along_north =
                -sin_lat * (cos_lon * velocity.x + sin_lon * velocity.y) + cos_lat * velocity.z;
            assert!((decode(east[at]) / 100.0 - along_east).abs() < 0.006);
            assert!((decode(north[at]) / 100.0 - along_north).abs() < 0.006);
        }
    }
}

#[test]
fn samples_follow_the_sub_plates() {
    let surface = history().surface().unwrap();
    let raster = Raster::new(&surface).unwrap();
    let mut land = (0, 0);
    for (vertex, &site) in surface.mesh.sites().iter().enumerate() {
        let sample = raster.sample(site * 3.0);
        assert!(sample.elevation.is_finite() && sample.age >= 0.0);
        assert!(surface.plate.contains(&sample.plate));
        let same = u32::from(sample.crust == surface.crust[vertex]);
        land = (land.0 + same, land.1 + 1);
    }
    // Warped coasts move some sub-plates to the other side, but few.
    assert!(land.0 * 10 > land.1 * 8, "{land:?}");
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let surface = history().surface().unwrap();
    let folders = [1, 3, 16].map(|threads| {
        let folder = tempfile::tempdir().unwrap();
        maps(threads).write(&surface, folder.path()).unwrap();
        folder
    });
    for name in names(folders[0].path()) {
        let bytes = folders
            .each_ref()
            .map(|folder| fs::read(folder.path().join(&name)).unwrap());
        assert!(bytes[0] == bytes[1] && bytes[0] == bytes[2], "{name}");
    }
}

#[test]
fn the_summary_has_every_promised_key() {
    let mut history = history();
    let folder = tempfile::tempdir().unwrap();
    write_planet(&mut history, 1.5, folder.path(), &maps(1)).unwrap();
    let text = fs::read_to_string(folder.path().join("planet.json")).unwrap();
    let planet: serde_json::Value = serde_json::from_str(&text).unwrap();
    for key in [
        "recipe",
        "time_my",
        "radius_km",
        "sub_plates",
        "steps",
        "seconds",
        "state_hash",
        "statistics",
        "ledger",
    ] {
        assert!(planet.get(key).is_some(), "{key} is missing");
    }
    assert_eq!(planet["seconds"]["total"], 1.5);
    assert!(planet["seconds"]["stages"].is_object());
    assert_eq!(
        planet["state_hash"],
        format!("{:016x}", history.state_hash().unwrap())
    );
    let recipe: Recipe = serde_json::from_value(planet["recipe"].clone()).unwrap();
    assert_eq!(&recipe, history.recipe());
}

#[test]
fn nothing_half_written_stays() {
    let mut history = history();
    let folder = tempfile::tempdir().unwrap();
    // A folder in the place of a file cannot be replaced by one.
    fs::create_dir_all(folder.path().join("age.png/occupied")).unwrap();
    let error = write_planet(&mut history, 0.0, folder.path(), &maps(1)).unwrap_err();
    assert!(matches!(error, ExportError::Write { .. }));
    assert!(error.to_string().contains("age.png"), "{error}");
    assert_eq!(names(folder.path()), ["age.png"]);
    assert!(
        check_folder(folder.path(), FILES).is_err(),
        "known before a long run"
    );

    let file = folder.path().join("file");
    fs::write(&file, "mine").unwrap();
    let error = write_planet(&mut history, 0.0, &file.join("below"), &maps(1)).unwrap_err();
    assert!(error.to_string().contains("below"), "{error}");
    assert!(check_folder(&file, FILES).is_err());
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
}

#[cfg(unix)]
#[test]
fn a_read_only_folder_is_refused_and_left_alone() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o555)).unwrap();
    if File::create(folder.path().join("probe")).is_ok() {
        println!("skipped: permissions do not bind this user");
        return;
    }
    let error = check_folder(folder.path(), FILES).unwrap_err();
    assert!(
        error
            .to_string()
            .contains(&folder.path().display().to_string())
    );
    assert!(
        maps(1)
            .write(&history().surface().unwrap(), folder.path())
            .is_err()
    );
    assert!(names(folder.path()).is_empty());
}

#[test]
fn settings_and_surfaces_are_checked() {
    let mut surface = history().surface().unwrap();
    let folder = tempfile::tempdir().unwrap();
    for width in [0, 15, 17, 16386] {
        let result = Maps { width, threads: 1 }.write(&surface, folder.path());
        assert!(matches!(result, Err(ExportError::Width(w)) if w == width));
    }
    surface.age.pop();
    let error = maps(1).write(&surface, folder.path()).unwrap_err();
    assert!(error.to_string().contains("age"), "{error}");
    assert!(names(folder.path()).is_empty());
}
