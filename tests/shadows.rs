//! Mountains cast shadows where the ground between a place and the sun says so, and nowhere else.
//!
//! They are drawn on whatever adapter there is. Where there is none, the test says so and passes, unless
//! `BEVY_TECTONICS_REQUIRE_GPU` is set.
#![cfg(all(feature = "window", feature = "terrain"))]

#[expect(dead_code, reason = "each uses a part of it")]
mod studio;

use bevy::prelude::*;
use bevy_tectonics::{
    planet::from_scene,
    prelude::*,
    surface::{Landmark, Terrain},
};
use glam::DVec3;
use libm::{asin, cos, sin, tanf};
use std::{env, path::Path};
use studio::{Look, Picture, Studio};

const RADIUS: f64 = 6.371e6;
/// Pixels.
const SIZE: (u32, u32) = (160, 100);
/// Height of the camera above the ground in m.
const HEIGHT: f64 = 12_000.0;
/// Size of the ground's quads down there, in m.
const DETAIL: f64 = 70.0;
/// In degrees: how clearly ground lies above or below the line to the sun for its shadow to be foretold.
const MARGIN: f64 = 2.0;

/// Light of a pixel, 1 for white.
fn light(picture: &Picture, index: usize) -> f32 {
    let channel = |at: usize| f32::from(picture.pixels[3 * index + at]) / 255.0;
    LinearRgba::from(Srgba::rgb(channel(0), channel(1), channel(2))).luminance()
}

/// Mean change of the light from one picture to another, and the share of pixels that lose a fifth of it.
fn change(from: &Picture, to: &Picture) -> (f32, f32) {
    let pixels = (SIZE.0 * SIZE.1) as usize;
    let (mut apart, mut all, mut darker) = (0.0, 0.0, 0.0);
    for index in 0..pixels {
        let (before, after) = (light(from, index), light(to, index));
        apart += (before - after).abs();
        all += before;
        darker += f32::from(u8::from(after < 0.8 * before));
    }
    (apart / all, darker / pixels as f32)
}

struct Ground<'a> {
    terrain: Terrain<'a>,
    eye: DVec3,
    rotation: Quat,
    sun: DVec3,
}

impl Ground<'_> {
    fn height(&mut self, direction: DVec3) -> f64 {
        f64::from(self.terrain.elevation(direction)).max(0.0)
    }

    /// What a pixel shows, in m from the planet's centre.
    fn seen(&mut self, x: u32, y: u32) -> Option<DVec3> {
        let at = |pixel: u32, size: u32| 2.0 * (pixel as f32 + 0.5) / size as f32 - 1.0;
        let half = tanf(core::f32::consts::FRAC_PI_8);
        let aspect = SIZE.0 as f32 / SIZE.1 as f32;
        let way = Vec3::new(half * aspect * at(x, SIZE.0), -half * at(y, SIZE.1), -1.0);
        let way = from_scene(self.rotation * way).normalize();
        let below = |ground: &mut Self, far: f64| {
            let place = ground.eye + way * far;
            place.length() - RADIUS < ground.height(place.normalize())
        };
        let step = 0.02 * HEIGHT;
        let first = (1..200).find(|&i| below(self, step * f64::from(i)))?;
        let (mut near, mut far) = (step * f64::from(first - 1), step * f64::from(first));
        for _ in 0..12 {
            let middle = 0.5 * (near + far);
            if below(self, middle) {
                far = middle;
            } else {
                near = middle;
            }
        }
        Some(self.eye + way * far)
    }

    /// By how many degrees the sun stands above the ground that lies before it.
    fn clearance(&mut self, place: DVec3) -> f64 {
        let up = place.normalize();
        let along = (self.sun - up * self.sun.dot(up)).normalize();
        let mut highest = f64::MIN;
        for i in 1..400 {
            let far = 100.0 * f64::from(i);
            let direction = up * cos(far / RADIUS) + along * sin(far / RADIUS);
            let way = direction * (RADIUS + self.height(direction)) - place;
            highest = highest.max(asin(way.dot(up) / way.length()));
        }
        (asin(self.sun.dot(up)) - highest).to_degrees()
    }
}

#[test]
fn mountains_shadow_what_lies_behind_them() {
    let recipe = Recipe::earth_like(12)
        .with_sub_plates(4_000)
        .with_duration(120.0);
    let planet = Planet::new(recipe).with_radius(RADIUS as f32);
    let Some(mut studio) = Studio::new(SIZE.0, SIZE.1, planet) else {
        assert!(
            env::var_os("BEVY_TECTONICS_REQUIRE_GPU").is_none(),
            "there is no adapter to draw with"
        );
        println!("skipped: there is no adapter to draw with");
        return;
    };
    studio.view().exaggeration = 1.0;
    let surface = studio.surface().unwrap();
    let ranges = [Landmark::HighestRange, Landmark::Cordillera];
    let range = ranges.into_iter().find_map(|kind| surface.landmark(kind));
    let (up, across) = range.unwrap();
    let mut terrain = Terrain::new(&surface, DETAIL).unwrap();
    let eye = up * (RADIUS + f64::from(terrain.elevation(up)) + HEIGHT);
    let forward = (across * 0.3 - up).normalize();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let mut shoot = |sun_height: f64, on: bool, shift: Vec3| {
        let height = sun_height.to_radians();
        let sun = (across * cos(height) + up * sin(height)).normalize();
        studio.look(Look {
            place_m: eye,
            forward,
            sun,
        });
        studio.shift(shift);
        studio.shadows(on, HEIGHT as f32);
        let picture = studio.shoot().unwrap();
        let name = format!("shadows_{sun_height}_{on}_{}.png", shift.x);
        picture.save(&folder.join(name)).unwrap();
        let world = studio.app.world_mut();
        let mut cameras = world.query_filtered::<&Transform, With<Camera3d>>();
        (picture, sun, cameras.single(world).unwrap().rotation)
    };

    // At noon all is as bright with shadows as without: ground does not stain itself.
    let (bare, ..) = shoot(80.0, false, Vec3::ZERO);
    let (noon, ..) = shoot(80.0, true, Vec3::ZERO);
    let (apart, darker) = change(&bare, &noon);
    println!("noon: {apart} apart, {darker} darker");
    assert!(apart < 0.01 && darker < 0.01, "{apart} {darker}");

    // In the morning valleys lie in the dark.
    let (bare, ..) = shoot(9.0, false, Vec3::ZERO);
    let (dawn, sun, rotation) = shoot(9.0, true, Vec3::ZERO);
    let (apart, darker) = change(&bare, &dawn);
    println!("dawn: {apart} apart, {darker} darker");
    assert!(darker > 0.1, "{darker}");
    let mut ground = Ground {
        terrain,
        eye,
        rotation,
        sun,
    };
    let pixels = (SIZE.0 * SIZE.1) as usize;
    let mean = (0..pixels).map(|i| light(&bare, i)).sum::<f32>() / pixels as f32;
    let (mut shadowed, mut lit) = ([0, 0], [0, 0]);
    for y in (1..SIZE.1).step_by(3) {
        for x in (1..SIZE.0).step_by(3) {
            let index = (y * SIZE.0 + x) as usize;
            let (before, after) = (light(&bare, index), light(&dawn, index));
            // Slopes that look away from the sun are dark in any case: the light of the sky is all they have.
            if before < 1.1 * mean {
                continue;
            }
            let Some(place) = ground.seen(x, y) else {
                continue;
            };
            let clearance = ground.clearance(place);
            if clearance < -MARGIN {
                shadowed[usize::from(after < 0.8 * before)] += 1;
            } else if clearance > MARGIN {
                lit[usize::from(after > 0.95 * before)] += 1;
            }
        }
    }
    println!("foretold to be dark: {shadowed:?}, to be lit: {lit:?} (wrong, right)");
    // Where the sun grazes the ground, its shadow takes little.
    for ([wrong, right], times) in [(shadowed, 3), (lit, 10)] {
        assert!(right > 80 && wrong * times < right, "{wrong}, {right}");
    }

    // Wherever in the world planet and camera are. There, a `Transform` has steps of a quarter of a metre.
    let (moved, ..) = shoot(9.0, true, Vec3::new(2e6, -1e6, 1.5e6));
    let (apart, darker) = change(&dawn, &moved);
    println!("moved: {apart} apart, {darker} darker");
    assert!(apart < 0.02 && darker < 0.01, "{apart} {darker}");
}
