//! Pictures of a planet, plain and with every overlay, against approved ones in `tests/pictures/`.
//!
//! They are drawn on whatever adapter there is, and compared under a tolerance. Where there is none, the
//! test says so and passes, unless `BEVY_TECTONICS_REQUIRE_GPU` is set. `BEVY_TECTONICS_APPROVE=1` writes
//! new pictures in place of comparing: look at each before you commit it.
#![cfg(all(feature = "window", feature = "export", feature = "terrain"))]

#[expect(dead_code, reason = "each uses a part of it")]
mod studio;

use bevy::{
    mesh::MeshTag, pbr::AtmosphereSettings, prelude::*, render::renderer::RenderAdapterInfo,
};
use bevy_tectonics::{
    prelude::*,
    render::{PlanetAtmosphere, PlanetClouds, PlanetRenderSettings, Preset, TilesDrawn},
    surface::direction_of,
};
use core::time::Duration;
use std::{
    env,
    fs::{self, File},
    io::{self, BufReader},
    path::Path,
    sync::{Mutex, PoisonError},
    time::Instant,
};
use studio::{Look, Picture, Pose, Studio};

const WIDTH: u32 = 640;
const HEIGHT: u32 = 400;
/// Mean difference of a channel that goes unnoticed, of 255.
const MEAN: f64 = 1.5;
/// A pixel differs if one of its channels does by more than this, of 255.
const CHANNEL: u8 = 40;
/// Share of the pixels that may differ: edges fall a pixel beside.
const SHARE: f64 = 0.01;

/// Each app draws alone: a planet's maps keep the shape of the noise that suits the first snapshot drawn, which is
/// another one where apps share threads.
static STUDIO: Mutex<()> = Mutex::new(());

fn planet() -> Planet {
    Planet::new(
        Recipe::earth_like(12)
            .with_sub_plates(4_000)
            .with_duration(120.0),
    )
}

/// Every picture: its name, how the planet is drawn, where it is seen from.
fn scenes() -> Vec<(String, PlanetView, Pose)> {
    let plain = PlanetView::default();
    let pose = |latitude, longitude| Pose {
        latitude,
        longitude,
        ..Pose::default()
    };
    let here = pose(15.0, 60.0);
    let mut scenes = vec![
        ("plain".to_owned(), plain.clone(), here),
        (
            "plain_far_side".to_owned(),
            plain.clone(),
            pose(10.0, -120.0),
        ),
        ("plain_pole".to_owned(), plain.clone(), pose(75.0, 0.0)),
        (
            "limb".to_owned(),
            PlanetView {
                exaggeration: 30.0,
                ..plain.clone()
            },
            Pose {
                distance: 1.7,
                sun_east: -80.0,
                ..here
            },
        ),
        (
            "without_sea".to_owned(),
            PlanetView {
                sea: false,
                ..plain.clone()
            },
            here,
        ),
        (
            "sea_200_m_higher".to_owned(),
            PlanetView {
                sea_level_m: 200.0,
                ..plain.clone()
            },
            here,
        ),
    ];
    for overlay in Overlay::ALL {
        let view = match overlay {
            Overlay::Boundaries => PlanetView {
                boundaries: true,
                ..plain.clone()
            },
            Overlay::Velocity => PlanetView {
                velocities: true,
                ..plain.clone()
            },
            fill => PlanetView {
                overlay: Some(fill),
                ..plain.clone()
            },
        };
        scenes.push((format!("{overlay:?}").to_lowercase(), view, here));
    }
    scenes
}

/// Reads a picture that the studio has written.
fn load(path: &Path) -> io::Result<Picture> {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path)?)).read_info()?;
    let mut pixels = vec![0; reader.output_buffer_size().unwrap_or(0)];
    let info = reader.next_frame(&mut pixels)?;
    Ok(Picture {
        width: info.width,
        height: info.height,
        pixels,
    })
}

/// Says how two pictures differ, if they do so noticeably.
fn difference(one: &Picture, other: &Picture) -> Option<String> {
    if (one.width, one.height) != (other.width, other.height) {
        return Some(format!(
            "{} × {} in place of {} × {}",
            one.width, one.height, other.width, other.height
        ));
    }
    let gaps = || {
        one.pixels
            .iter()
            .zip(&other.pixels)
            .map(|(a, b)| a.abs_diff(*b))
    };
    let mean = gaps().map(f64::from).sum::<f64>() / one.pixels.len() as f64;
    let gaps: Vec<u8> = gaps().collect();
    let differing = gaps
        .chunks(3)
        .filter(|pixel| pixel.iter().any(|gap| *gap > CHANNEL))
        .count();
    let share = differing as f64 / (one.width * one.height) as f64;
    (mean > MEAN || share > SHARE).then(|| {
        format!(
            "mean difference {mean:.2} of 255, {:.2} % of the pixels differ",
            100.0 * share
        )
    })
}

#[test]
fn comparison_notices_what_people_notice() {
    let grey = |level: u8| Picture {
        width: 20,
        height: 10,
        pixels: vec![level; 600],
    };
    assert_eq!(difference(&grey(100), &grey(101)), None);
    assert!(difference(&grey(100), &grey(103)).is_some());
    let mut spot = grey(100);
    spot.pixels[..9].fill(200);
    assert!(
        difference(&grey(100), &spot).is_some(),
        "1.5 % of the pixels"
    );
}

/// Tiles take over as the camera comes near, cover what it sees, and leave nothing behind.
#[test]
fn tiles_come_and_go() {
    let _alone = STUDIO.lock().unwrap_or_else(PoisonError::into_inner);
    let planet = planet().with_radius(6.371e6);
    let Some(mut studio) = Studio::new(160, 100, planet) else {
        return;
    };
    let surface = studio.surface().unwrap();
    let tiles = |world: &mut World| {
        let mut drawn = world.query::<&TilesDrawn>();
        drawn.iter(world).next().copied()
    };
    let parts = |world: &mut World| {
        let mut parts = world.query_filtered::<(), With<MeshTag>>();
        parts.iter(world).count()
    };
    let up = direction_of(15.0, 60.0);
    let look = |altitude_m: f64| Look {
        place_m: up * (1000.0 * surface.radius_km + altitude_m),
        forward: -up,
        sun: up,
    };
    studio.look(look(300e3));
    studio.shoot().unwrap();
    let near = tiles(studio.app.world_mut()).unwrap();
    assert_eq!((near.share, near.missing, near.late_s), (1.0, 0, 0.0));
    assert!(near.drawn > 50 && near.kept >= near.drawn && near.made >= near.kept);
    assert!(parts(studio.app.world_mut()) >= near.drawn as usize);

    // From afar the planet is a sphere again.
    studio.look(look(20e6));
    let start = Instant::now();
    while parts(studio.app.world_mut()) > 0 {
        assert!(start.elapsed() < Duration::from_secs(60), "tiles stayed");
        studio.app.update();
    }
    assert_eq!(tiles(studio.app.world_mut()), Some(TilesDrawn::default()));

    studio.look(look(1e6));
    studio.shoot().unwrap();
    assert!(parts(studio.app.world_mut()) > 0);
    let planet = {
        let world = studio.app.world_mut();
        let mut planets = world.query_filtered::<Entity, With<Planet>>();
        planets.single(world).unwrap()
    };
    studio.app.world_mut().despawn(planet);
    studio.app.update();
    assert_eq!(parts(studio.app.world_mut()), 0);
}

/// Bevy draws the air in place of the planet's own, and leaves nothing behind when it no longer shall.
#[test]
fn bevys_atmosphere_comes_and_goes() {
    let _alone = STUDIO.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(mut studio) = Studio::new(160, 100, planet()) else {
        return;
    };
    let driver = &studio
        .app
        .world()
        .resource::<RenderAdapterInfo>()
        .driver_info;
    if driver.contains("Mesa 22.") {
        println!("skipped: {driver} crashes on Bevy's atmosphere");
        return;
    }
    let own = studio.shoot().unwrap();
    studio.bevy_air();
    let bevys = studio.shoot().unwrap();
    assert!(difference(&own, &bevys).is_some());
    let world = studio.app.world_mut();
    let mut planets = world.query_filtered::<Entity, With<PlanetAtmosphere>>();
    let planet = planets.single(world).unwrap();
    world.entity_mut(planet).remove::<PlanetAtmosphere>();
    assert_eq!(difference(&own, &studio.shoot().unwrap()), None);
    // The same where the camera no longer wants it.
    studio.bevy_air();
    assert_eq!(difference(&bevys, &studio.shoot().unwrap()), None);
    let world = studio.app.world_mut();
    let mut cameras = world.query_filtered::<Entity, With<AtmosphereSettings>>();
    let camera = cameras.single(world).unwrap();
    world.entity_mut(camera).remove::<AtmosphereSettings>();
    assert_eq!(difference(&own, &studio.shoot().unwrap()), None);
}

#[test]
fn planets_look_as_they_were_approved() {
    let _alone = STUDIO.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(mut studio) = Studio::new(WIDTH, HEIGHT, planet()) else {
        assert!(
            env::var_os("BEVY_TECTONICS_REQUIRE_GPU").is_none(),
            "there is no adapter to draw with"
        );
        println!("skipped: there is no adapter to draw with");
        return;
    };
    studio.settings(PlanetRenderSettings { face: 256 });
    let approved = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pictures");
    let drawn = Path::new(env!("CARGO_TARGET_TMPDIR")).join("pictures");
    fs::create_dir_all(&drawn).unwrap();
    let approve = env::var_os("BEVY_TECTONICS_APPROVE").is_some();
    let mut complaints = Vec::new();
    let mut compare = |name: &str, picture: &Picture| {
        let file = format!("{name}.png");
        picture.save(&drawn.join(&file)).unwrap();
        if approve {
            picture.save(&approved.join(&file)).unwrap();
            return;
        }
        match load(&approved.join(&file)) {
            Ok(expected) => complaints
                .extend(difference(picture, &expected).map(|how| format!("{name}: {how}"))),
            Err(error) => complaints.push(format!("{name}: {error}")),
        }
    };
    for (name, view, pose) in scenes() {
        *studio.view() = view;
        studio.pose(pose);
        compare(&name, &studio.shoot().unwrap());
    }
    // The same ground in other colours, below other skies and clouds.
    *studio.view() = PlanetView::default();
    studio.pose(scenes()[0].2);
    for preset in Preset::ALL {
        let (palette, air, clouds) = preset.look();
        let clouds = PlanetClouds {
            drift: 0.0,
            ..clouds
        };
        studio.dress((palette, air, clouds), ());
        compare(preset.name(), &studio.shoot().unwrap());
    }
    assert!(
        complaints.is_empty(),
        "pictures changed; the new ones lie in {}:\n{}",
        drawn.display(),
        complaints.join("\n")
    );
}
