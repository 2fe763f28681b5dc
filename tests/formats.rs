//! What is exported for other programs says what the surface says. `tests/readers/` opens the same files
//! in those programs.
#![cfg(feature = "export")]

use bevy::app::PluginGroup;
use bevy::math::{DMat3, DQuat, DVec3};
use bevy::prelude::{App, Component};
use bevy_tectonics::export::*;
use bevy_tectonics::import;
use bevy_tectonics::prelude::*;
use bevy_tectonics::simulation::{
    ImageStart, PlateId, Position, RotationHistory, RotationHistoryPlugin, Start, SubPlate,
};
use bevy_tectonics::surface::{Raster, Relief, direction_of, east_north, lat_lon};
use core::ops::ControlFlow;
use std::collections::BTreeMap;
use std::fs;
use std::io::BufReader;
use std::path::Path;
use std::sync::LazyLock;

fn recipe() -> Recipe {
    let mut recipe = Recipe::earth_like(3).with_sub_plates(800);
    recipe.plates = 9;
    recipe
}

/// One surface for all tests: after some time, so that it has kinds of everything.
static SURFACE: LazyLock<Surface> = LazyLock::new(|| {
    let mut history = History::with_threads(recipe(), 1).unwrap();
    history
        .run_until(12.0, |_| ControlFlow::Continue(()))
        .unwrap();
    history.surface().unwrap()
});

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// Width, height and samples, 8 or 16 bits each.
fn read(path: &Path) -> ([u32; 2], Vec<u16>) {
    let file = BufReader::new(fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let samples = match info.bit_depth {
        png::BitDepth::Sixteen => bytes
            .chunks(2)
            .map(|pair| u16::from_be_bytes([pair[0], pair[1]]))
            .collect(),
        _ => bytes.into_iter().map(u16::from).collect(),
    };
    ([info.width, info.height], samples)
}

/// Columns, rows and middles of the faces in the frame of a scene, as graphics interfaces define them.
const FACES: [(&str, [[f64; 3]; 3]); 6] = [
    ("px", [[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]]),
    ("nx", [[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]]),
    ("py", [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]),
    ("ny", [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0]]),
    ("pz", [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]),
    ("nz", [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]),
];

#[test]
fn cube_maps_hold_the_surface_at_the_middles_of_texels() {
    let side = 24;
    let folder = tempfile::tempdir().unwrap();
    let textures = Textures::cube(side).with_relief(Relief::exaggerated(20.0).with_sea());
    let paths = textures.write(&SURFACE, folder.path()).unwrap();
    assert_eq!(paths.len(), 18);
    let raster = Raster::new(&SURFACE).unwrap();
    let mut steepest = 0.0_f64;
    for (face, axes) in FACES {
        let [along, down, out] = axes.map(DVec3::from);
        let file = |kind: &str| read(&folder.path().join(format!("{kind}_{face}.png")));
        let ((size, heights), (_, normals)) = (file("elevation"), file("normal"));
        assert_eq!(size, [side, side]);
        assert_eq!(file("colour").1.len(), 3 * heights.len());
        for (i, &height) in heights.iter().enumerate() {
            let at = |n: usize| (2.0 * n as f64 + 1.0) / f64::from(side) - 1.0;
            let (s, t) = (at(i % side as usize), at(i / side as usize));
            let scene = (along * s + down * t + out).normalize();
            let place = DVec3::new(scene.x, -scene.z, scene.y);
            let expected = f64::from(raster.sample(place).elevation);
            assert!((f64::from(height) - 32768.0 - expected).abs() <= 0.51);

            let normal = DVec3::from_array(
                [0, 1, 2].map(|c| f64::from(normals[3 * i + c]) / 32_767.5 - 1.0),
            );
            assert!((normal.length() - 1.0).abs() < 1e-4);
            steepest = steepest.max(1.0 - normal.z);
            if expected < -3000.0 {
                // The sea lies level, but where it meets a coast.
                assert!(normal.z > 0.8);
            }
        }
    }
    // As they are, slopes of this planet would be 400 times less: below what 16 bits can hold.
    assert!(steepest > 1e-3, "{steepest}: heights are exaggerated");
}

#[test]
fn a_rectangle_has_the_heights_of_the_maps_and_their_slopes() {
    let folder = tempfile::tempdir().unwrap();
    let (maps, textures) = (folder.path().join("maps"), folder.path().join("textures"));
    // The larger one is worked on in several bands of rows.
    for width in [128_usize, 2048] {
        let rows = width / 2;
        Maps::new(width as u32).write(&SURFACE, &maps).unwrap();
        let rectangle = Textures::rectangle(width as u32).with_relief(30.0);
        assert_eq!(rectangle.write(&SURFACE, &textures).unwrap().len(), 3);
        let elevation = |folder: &Path| fs::read(folder.join("elevation.png")).unwrap();
        assert!(elevation(&maps) == elevation(&textures));

        let (_, heights) = read(&textures.join("elevation.png"));
        let (_, normals) = read(&textures.join("normal.png"));
        let pixel_m = 1000.0 * SURFACE.radius_km * core::f64::consts::PI / rows as f64;
        let middle = rows / 2;
        for y in (rows / 8..rows - rows / 8)
            .step_by(3)
            .chain(middle - 2..middle + 2)
        {
            let latitude = core::f64::consts::PI * (0.5 - (y as f64 + 0.5) / rows as f64);
            let cos = libm::cos(latitude);
            for x in (1..width - 1).step_by(width / 25) {
                let height = |x: usize, y: usize| f64::from(heights[width * y + x]);
                let east = (height(x + 1, y) - height(x - 1, y)) / (2.0 * pixel_m * cos);
                let north = (height(x, y - 1) - height(x, y + 1)) / (2.0 * pixel_m);
                let at = 3 * (width * y + x);
                let [right, up, out] =
                    [0, 1, 2].map(|c| f64::from(normals[at + c]) / 32_767.5 - 1.0);
                // Rounded heights on both sides, and ground that lies lower or higher than the sphere.
                let most = 5e-3 + 30.0 / pixel_m / cos + 0.03 * (right.hypot(up) / out);
                assert!(
                    (30.0 * east + right / out).abs() < most,
                    "{east} {}",
                    right / out
                );
                assert!(
                    (30.0 * north + up / out).abs() < most,
                    "{north} {}",
                    up / out
                );
            }
        }
    }
}

#[test]
fn threads_change_no_byte_of_textures_and_models() {
    let written = [1, 3].map(|threads| {
        let folder = tempfile::tempdir().unwrap();
        let mut textures = Textures::cube(16);
        textures.threads = threads;
        textures.write(&SURFACE, folder.path()).unwrap();
        let globe = Globe {
            side: 16,
            quads: 5,
            threads,
            ..Globe::default()
        };
        globe.write(&SURFACE, folder.path()).unwrap();
        let names = names(folder.path());
        names
            .into_iter()
            .map(|name| fs::read(folder.path().join(name)).unwrap())
            .collect::<Vec<_>>()
    });
    assert_eq!(written[0].len(), 19);
    assert!(written[0] == written[1]);
}

#[test]
fn a_model_is_the_planet_in_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    let globe = Globe {
        side: 16,
        quads: 12,
        relief: Relief::exaggerated(25.0),
        ..Globe::default()
    };
    let path = globe.write(&SURFACE, folder.path()).unwrap();
    let gltf = gltf::Gltf::open(path).unwrap();
    let bin = gltf.blob.as_deref().unwrap();
    let mesh = gltf.meshes().next().unwrap();
    let extras: serde_json::Value =
        serde_json::from_str(mesh.extras().as_ref().unwrap().get()).unwrap();
    assert_eq!(extras["seed"], 3);
    assert!((extras["exaggeration"].as_f64().unwrap() - 25.0).abs() < 1e-9);
    assert_eq!(gltf.images().count(), 12);
    let raster = Raster::new(&SURFACE).unwrap();
    let mut corners = BTreeMap::<[u32; 3], usize>::new();
    for part in mesh.primitives() {
        let reader = part.reader(|_| Some(bin));
        let heights = part
            .get(&gltf::Semantic::Extras("ELEVATION".into()))
            .unwrap();
        assert_eq!(heights.count(), 13 * 13);
        let positions: Vec<_> = reader.read_positions().unwrap().collect();
        let normals: Vec<_> = reader.read_normals().unwrap().collect();
        let tangents: Vec<_> = reader.read_tangents().unwrap().collect();
        for ((position, normal), tangent) in positions.iter().zip(&normals).zip(tangents) {
            let [x, y, z] = normal.map(f64::from);
            let expected = f64::from(raster.sample(DVec3::new(x, -z, y)).elevation);
            let radius = DVec3::from(position.map(f64::from)).length();
            let drawn = (radius - 1.0) * 1000.0 * SURFACE.radius_km / 25.0;
            // Places in single precision move steep slopes a little.
            assert!((drawn - expected).abs() < 2.0, "{drawn} {expected}");
            let [tx, ty, tz, _] = tangent.map(f64::from);
            assert!(DVec3::new(tx, ty, tz).dot(DVec3::new(x, y, z)).abs() < 1e-6);
            *corners.entry(position.map(f32::to_bits)).or_default() += 1;
        }
        for triangle in reader
            .read_indices()
            .unwrap()
            .into_u32()
            .collect::<Vec<_>>()
            .chunks(3)
        {
            let [a, b, c] =
                [0, 1, 2].map(|i| DVec3::from(positions[triangle[i] as usize].map(f64::from)));
            assert!((b - a).cross(c - a).dot(a) > 0.0, "seen from outside");
        }
    }
    // Faces share the places along their edges: 12 edges with 11 inner corners twice, 8 corners thrice.
    let shared = |times: usize| corners.values().filter(|&&count| count == times).count();
    assert_eq!((shared(2), shared(3)), (12 * 11, 8));
}

#[test]
fn tables_read_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let paths = write_tables(&SURFACE, folder.path()).unwrap();
    assert_eq!(paths, TABLE_FILES.map(|name| folder.path().join(name)));
    let rows = |path: &Path| -> Vec<BTreeMap<String, String>> {
        let mut reader = csv::Reader::from_path(path).unwrap();
        reader.deserialize().map(Result::unwrap).collect()
    };
    let sub_plates = rows(&paths[0]);
    assert_eq!(sub_plates.len(), SURFACE.mesh.vertex_count());
    for (vertex, row) in sub_plates.iter().enumerate() {
        let number = |name: &str| row[name].parse::<f64>().unwrap();
        let site = SURFACE.mesh.site(vertex as u32);
        assert_eq!((number("latitude"), number("longitude")), lat_lon(site));
        assert_eq!(number("sub_plate"), vertex as f64);
        assert_eq!(row["elevation_m"].parse(), Ok(SURFACE.elevation[vertex]));
        assert_eq!(row["thickness_km"].parse(), Ok(SURFACE.thickness[vertex]));
        assert_eq!(row["age_my"].parse(), Ok(SURFACE.age[vertex]));
        assert_eq!(row["plate"].parse(), Ok(SURFACE.plate[vertex]));
        assert_eq!(row["crust"], format!("{:?}", SURFACE.crust[vertex]));
        assert_eq!(row["orogeny"], format!("{:?}", SURFACE.orogeny[vertex]));
        assert_eq!(
            row["volcanism_age_my"].parse().ok(),
            SURFACE.volcanism_age[vertex]
        );
        let (east, north) = east_north(site);
        let velocity =
            east * number("velocity_east_mm_yr") + north * number("velocity_north_mm_yr");
        assert!(velocity.distance(SURFACE.velocity[vertex].as_dvec3()) < 1e-4);
    }
    let plates = rows(&paths[1]);
    assert_eq!(plates.len(), SURFACE.plates().len());
    for (row, plate) in plates.iter().zip(SURFACE.plates()) {
        let number = |name: &str| row[name].parse::<f64>().unwrap();
        assert_eq!(row["plate"].parse(), Ok(plate.id));
        assert_eq!(number("area_km2"), plate.area_km2);
        let pole = direction_of(number("pole_latitude"), number("pole_longitude"));
        let rotation = pole * number("deg_per_my").to_radians();
        assert!(rotation.distance(plate.rotation) < 1e-12);
    }
}

#[test]
fn what_is_exported_is_a_start() {
    let folder = tempfile::tempdir().unwrap();
    Maps::new(256).write(&SURFACE, folder.path()).unwrap();
    let paths = write_geography(&SURFACE, &RotationHistory::of(&SURFACE), folder.path()).unwrap();
    assert_eq!(paths, GEOGRAPHY_FILES.map(|name| folder.path().join(name)));
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let mut recipe = recipe();
    recipe.start = Start::Image(ImageStart {
        heights: path("elevation.png"),
        plate_polygons: Some(path("plates.geojson")),
        ..ImageStart::default()
    });
    let again = import::begin(recipe, SimulationPlugins)
        .unwrap()
        .surface()
        .unwrap();
    assert_eq!(again.plates().len(), SURFACE.plates().len());
    // Ids are given anew, in the order of the file.
    let ids: BTreeMap<u16, u16> = (again.plates().iter().zip(SURFACE.plates()))
        .map(|(again, plate)| (again.id, plate.id))
        .collect();
    let same = (again.mesh.sites().iter().zip(&again.plate))
        .filter(|&(&site, id)| SURFACE.at(site).plate == ids[id]);
    let share = same.count() as f64 / again.plate.len() as f64;
    assert!(share > 0.98, "{share}");
    for (again, plate) in again.rotations.iter().zip(&SURFACE.rotations) {
        assert!(again.1.distance(plate.1) < 1e-9, "{again:?} {plate:?}");
    }
}

#[test]
fn boundaries_are_told_once_with_their_kinds() {
    let mut text = Vec::new();
    boundaries_geojson(&SURFACE, &mut text).unwrap();
    let value: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let mut lengths = BTreeMap::<&str, f64>::new();
    for feature in value["features"].as_array().unwrap() {
        let properties = &feature["properties"];
        let kind = properties["kind"].as_str().unwrap();
        *lengths.entry(kind).or_default() += properties["length_km"].as_f64().unwrap();
        assert_eq!(kind == "trench", properties["subducting"].is_number());
        assert!(properties["left"].as_u64() < properties["right"].as_u64());
        let first = &feature["geometry"]["coordinates"][0][0];
        let place = direction_of(first[1].as_f64().unwrap(), first[0].as_f64().unwrap());
        let near = SURFACE.nearest_boundary(place).unwrap();
        assert!(near.distance_km < 1e-3, "{near:?}");
    }
    let total: f64 = SURFACE
        .boundaries()
        .iter()
        .map(|segment| segment.length_km)
        .sum();
    assert!((lengths.values().sum::<f64>() / total - 1.0).abs() < 1e-9);
    assert!(lengths.len() >= 3, "{lengths:?}");
}

#[test]
fn rotations_lead_sub_plates_back_to_where_they_were() {
    /// Where a sub-plate was, if it was there.
    #[derive(Component, Default)]
    struct Then(Option<DVec3>);
    fn remember(app: &mut App) {
        app.register_required_components::<SubPlate, Then>();
    }
    let plugins = SimulationPlugins
        .build()
        .add(RotationHistoryPlugin { interval_my: 2.0 })
        .add(remember);
    let mut history = History::with_plugins(recipe(), plugins).unwrap();
    history
        .run_until(4.0, |_| ControlFlow::Continue(()))
        .unwrap();
    let world = history.world_mut();
    for (mut then, position) in world.query::<(&mut Then, &Position)>().iter_mut(world) {
        then.0 = Some(position.0.as_dvec3());
    }
    history
        .run_until(12.0, |_| ControlFlow::Continue(()))
        .unwrap();
    let world = history.world_mut();
    let now_my = world.resource::<RotationHistory>().now_my();
    assert_eq!(now_my, 12.0);
    let mut back = BTreeMap::new();
    for plate in world.resource::<RotationHistory>().plates() {
        let total = plate
            .totals
            .iter()
            .find(|total| (total.age_my - 8.0).abs() < 1.0);
        if let Some(total) = total {
            back.insert(plate.id, (total.age_my, total.rotation));
        }
    }
    let (mut near, mut all) = (0, 0);
    let mut query = world.query::<(&Then, &Position, &PlateId)>();
    for (then, position, plate) in query.iter(world) {
        let (Some(place), Some(&(age, rotation))) = (then.0, back.get(&plate.0)) else {
            continue;
        };
        if (age - 8.0).abs() > 1e-9 {
            continue;
        }
        let turned = DMat3::from_quat(DQuat::from_scaled_axis(rotation)) * position.0.as_dvec3();
        all += 1;
        near += usize::from(turned.distance(place) < 2e-5);
    }
    // Margins bend and sub-plates change hands; the inside of plates does neither.
    assert!(all > 300 && near * 10 > all * 6, "{near} of {all}");

    let folder = tempfile::tempdir().unwrap();
    let rotations = world.resource::<RotationHistory>().clone();
    // Every plate of the moment has lines, and outlines say how far back they go.
    let surface = history.surface().unwrap();
    let mut text = Vec::new();
    let whole = rotations.completed(&surface);
    plates_geojson(&surface, &whole, &mut text).unwrap();
    let value: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let totals: BTreeMap<u16, f64> = whole
        .plates()
        .map(|plate| (plate.id, plate.totals.last().unwrap().age_my))
        .collect();
    let features = value["features"].as_array().unwrap();
    assert_eq!(features.len(), surface.plates().len());
    for feature in features {
        let properties = &feature["properties"];
        let id = properties["plate"].as_u64().unwrap() as u16;
        assert_eq!(properties["FROMAGE"].as_f64(), Some(totals[&id]));
    }
    let path = write_rotations(&rotations, folder.path()).unwrap();
    assert_eq!(path, folder.path().join(ROTATIONS_FILE));
    let text = fs::read_to_string(path).unwrap();
    let lines: usize = rotations.plates().map(|plate| plate.totals.len()).sum();
    assert_eq!(text.lines().count(), lines);
    for line in text.lines() {
        let numbers: Vec<f64> = line
            .split_whitespace()
            .take(6)
            .map(|word| word.parse().unwrap())
            .collect();
        assert!(numbers[1] >= 0.0 && numbers[5] == 0.0, "{line}");
        assert!(line.contains('!'));
    }
}

#[test]
fn recording_rotations_changes_nothing() {
    let hash = |plugins| {
        let mut history = History::with_plugins(recipe(), plugins).unwrap();
        history
            .run_until(6.0, |_| ControlFlow::Continue(()))
            .unwrap();
        history.state_hash().unwrap()
    };
    let recorder = RotationHistoryPlugin { interval_my: 1.0 };
    let recorded = hash(SimulationPlugins.build().add(recorder));
    assert_eq!(recorded, hash(SimulationPlugins.build()));
}

#[test]
fn a_film_is_its_maps_in_turn() {
    let folder = tempfile::tempdir().unwrap();
    let maps = Maps::new(64);
    let mut film = Film::create(folder.path(), maps, 3).unwrap();
    let mut history = History::with_threads(recipe(), 1).unwrap();
    let mut pictures = Vec::new();
    for number in 0..3 {
        history
            .run_until(2.0 * f64::from(number), |_| ControlFlow::Continue(()))
            .unwrap();
        let surface = history.surface().unwrap();
        let frame = maps.write_frame(&surface, folder.path(), number).unwrap();
        pictures.push(read(&frame).1);
        film.add(&surface).unwrap();
    }
    assert_eq!(film.missing(), 0);
    assert!(matches!(film.add(&SURFACE), Err(ExportError::Pictures(4))));
    let path = film.finish().unwrap();
    assert_eq!(
        names(folder.path()),
        [FILM_FILE, "map_0000.png", "map_0001.png", "map_0002.png"]
    );

    let file = BufReader::new(fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    assert_eq!(reader.info().animation_control().unwrap().num_frames, 3);
    for picture in &pictures {
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        assert!(
            bytes
                .iter()
                .map(|&byte| u16::from(byte))
                .eq(picture.iter().copied())
        );
    }
    assert!(pictures[0] != pictures[2]);
}

#[test]
fn nothing_half_written_stays() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    let mut film = Film::create(out, Maps::new(64), 2).unwrap();
    film.add(&SURFACE).unwrap();
    assert!(matches!(film.finish(), Err(ExportError::Pictures(1))));
    assert!(names(out).is_empty());

    // A folder in the place of the last file of each.
    for name in [
        "colour_nz.png",
        GLOBE_FILE,
        "plates.csv",
        ROTATIONS_FILE,
        FILM_FILE,
    ] {
        fs::create_dir(out.join(name)).unwrap();
    }
    let before = names(out);
    let refused = [
        Textures::cube(8).write(&SURFACE, out).map(drop),
        Globe {
            side: 8,
            quads: 1,
            ..Globe::default()
        }
        .write(&SURFACE, out)
        .map(drop),
        write_tables(&SURFACE, out).map(drop),
        write_geography(&SURFACE, &RotationHistory::default(), out).map(drop),
        Film::create(out, Maps::new(64), 2).map(drop),
    ];
    for result in refused {
        assert!(matches!(result, Err(ExportError::Write { .. })));
    }
    assert_eq!(names(out), before);
}

#[test]
fn what_cannot_be_drawn_is_refused_with_the_range() {
    let out = Path::new("never-written");
    let mut broken = SURFACE.clone();
    broken.thickness.pop();
    let mut odd = SURFACE.clone();
    odd.elevation[5] = f32::NAN;
    let textures = |side| Textures::cube(side).write(&SURFACE, out).map(drop);
    let globe = |side, quads| {
        Globe {
            side,
            quads,
            ..Globe::default()
        }
        .write(&SURFACE, out)
        .map(drop)
    };
    for (result, expected) in [
        (textures(7), "from 8 to 8192"),
        (textures(8193), "from 8 to 8192"),
        (globe(4097, 8), "from 8 to 4096"),
        (globe(64, 0), "from 1 to 1024"),
        (
            Film::create(out, Maps::new(4098), 1).map(drop),
            "16 to 4096",
        ),
        (Film::create(out, Maps::new(64), 0).map(drop), "1 to 10000"),
        (write_tables(&broken, out).map(drop), "thickness"),
        (
            Globe::default().write(&odd, out).map(drop),
            "elevation that are not finite",
        ),
        (
            Textures::cube(8).write(&odd, out).map(drop),
            "elevation that are not finite",
        ),
        (
            write_geography(&broken, &RotationHistory::default(), out).map(drop),
            "thickness",
        ),
    ] {
        let message = result.unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
    assert!(!out.exists());
}
