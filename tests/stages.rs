//! What each stage does, against what can be worked out by hand.

#[path = "stages/scenario.rs"]
mod scenario;
#[path = "stages/schedule.rs"]
mod schedule;

use bevy::prelude::*;
use bevy_tectonics::prelude::*;
use bevy_tectonics::simulation::{
    Clock, Created, Deviation, Drive, Elevation, ErodePlugin, FoldDirection, HeldMotion, Mantle,
    MaterialArea, OrogenyBegan, Plate, PlateId, Position, RidgeDirection, Rotation, Sea, Splits,
    SubPlate, Thickness, Topology, Trench, UpliftPlugin, Velocity, sea_floor_depth,
};
use glam::{DQuat, DVec3};
use scenario::*;
use std::collections::BTreeMap;

/// Radius of Earth in km.
const RADIUS: f64 = 6371.0;
/// Speed of each plate at its equator in the scenarios that close, in km/My.
const SPEED: f64 = 30.0;

/// Rotations that close the two plates at +x and part them at −x, by twice [`SPEED`].
fn closing() -> [DVec3; 2] {
    [DVec3::Z * (SPEED / RADIUS), DVec3::Z * (-SPEED / RADIUS)]
}

#[test]
fn sea_floor_sinks_with_age() {
    // 2600 + 365 √t up to 20 My, then 5651 − 2473 exp(−0.0278 t).
    for (age, depth) in [
        (-1.0, 2600.0),
        (0.0, 2600.0),
        (1.0, 2965.0),
        (16.0, 4060.0),
        (50.0, 5035.01),
        (100.0, 5497.58),
    ] {
        assert!(
            (sea_floor_depth(age) - depth).abs() < 0.5,
            "{age} My: {} m",
            sea_floor_depth(age)
        );
    }
}

#[test]
fn heights_follow_from_thickness_and_age() {
    let mut recipe = Recipe::earth_like(3).with_sub_plates(1_000);
    recipe.hot_spots = 0;
    let erosion = &mut recipe.constants.erosion;
    erosion.sediment_rate = 0.0;
    erosion.rise_thickest = 0.0;
    erosion.reference_thickness = 35.0;
    // What comes after the stage must leave crust alone.
    recipe.constants.step.reorganisation = 50.0;
    let mut history = History::new(recipe).unwrap();
    loop {
        history.step().unwrap();
        let clock = history.world().resource::<Clock>();
        if clock.geology.due().is_some() && clock.time_my > 20.0 {
            break;
        }
    }
    let now = history.time_my();
    let sea = *history.world().resource::<Sea>();
    let crust: Vec<Crust> = column(&mut history);
    let thickness: Vec<Thickness> = column(&mut history);
    let created: Vec<Created> = column(&mut history);
    let trench: Vec<Trench> = column(&mut history);
    let area: Vec<MaterialArea> = column(&mut history);
    let elevation: Vec<Elevation> = column(&mut history);
    let (mut depth, mut whole, mut young) = (0.0, 0.0, 0);
    for v in 0..crust.len() {
        let height = if crust[v].is_continental() {
            155.0 * (thickness[v].0 - 35.0)
        } else {
            young += usize::from(f64::from(created[v].0) > 0.0);
            155.0 * (thickness[v].0 - 7.0) - sea_floor_depth(now - f64::from(created[v].0))
        };
        let height = height - f64::from(trench[v].0) - sea.level;
        let found = f64::from(elevation[v].0);
        assert!(
            (found - height).abs() < 0.01,
            "{found} m instead of {height} m"
        );
        depth += (-found).max(0.0) * area[v].0;
        whole += area[v].0;
    }
    assert!(young > 10, "only {young} sub-plates of new sea floor");
    assert!(
        (depth / whole - sea.mean_depth).abs() < 0.1,
        "{} m of water instead of {} m",
        depth / whole,
        sea.mean_depth
    );
}

/// Plates that part at −x, across the plane y = 0: the ridge lies in it (Cortial et al.: `r = (p − q) × p`).
#[test]
fn new_floor_remembers_along_which_ridge_it_was_made() {
    let mut history = History::with_plugins(recipe(4_000), steady()).unwrap();
    arrange(&mut history, closing(), |_, _| SEA_FLOOR);
    run(&mut history, 15.0);
    let created: Vec<Created> = column(&mut history);
    let position: Vec<Position> = column(&mut history);
    let ridge: Vec<RidgeDirection> = column(&mut history);
    let mut along = Vec::new();
    for v in 0..created.len() {
        let site = position[v].0;
        if created[v].0 <= 0.0 || site.x > -0.7 {
            continue;
        }
        let direction = ridge[v].0;
        assert!((direction.length() - 1.0).abs() < 1e-3, "{direction}");
        assert!(direction.dot(site).abs() < 1e-2, "{direction} at {site}");
        along.push(direction.dot(site.cross(Vec3::Y).normalize()).abs());
    }
    assert!(along.len() > 20, "only {} new cells", along.len());
    let mean = along.iter().sum::<f32>() / along.len() as f32;
    assert!(mean > 0.85, "{mean}");
}

#[test]
fn plates_that_turn_together_turn_as_one_body() {
    let turn = DVec3::new(0.004, -0.003, 0.008);
    let mut history = History::with_plugins(recipe(1_000), steady()).unwrap();
    arrange(&mut history, [turn; 2], |_, _| SEA_FLOOR);
    history.step().unwrap();
    /// Where a sub-plate was at first. Rides on it, however rows are sorted.
    #[derive(Component)]
    struct Start(DVec3);
    let began = history.time_my();
    let world = history.world_mut();
    let mut all = world.query_filtered::<(Entity, &Position), With<SubPlate>>();
    let starts: Vec<(Entity, Start)> = all
        .iter(world)
        .map(|(entity, position)| (entity, Start(position.0.as_dvec3())))
        .collect();
    let count = starts.len();
    world.insert_batch(starts);
    run(&mut history, 40.0);
    let angle = turn.length() * (history.time_my() - began);
    let rotation = DQuat::from_axis_angle(turn.normalize(), angle);
    let world = history.world_mut();
    let mut all = world.query_filtered::<(&Start, &Position, &Velocity), With<SubPlate>>();
    assert_eq!(all.iter(world).count(), count, "sub-plates came or went");
    for (start, position, velocity) in all.iter(world) {
        let (place, velocity) = (position.0.as_dvec3(), velocity.0.as_dvec3());
        assert!((place - rotation * start.0).length() < 1e-5, "{place}");
        assert!((velocity - turn.cross(place) * RADIUS).length() < 1e-2);
    }
    let ledger = history.ledger();
    assert_eq!(
        (ledger.area_created_km2, ledger.area_consumed_km2),
        (0.0, 0.0)
    );
}

/// Speed of a plate in km/My that sinks at a trench along half of a great circle and meets little but this resistance of
/// the mantle there, per km and km/My, while the mantle flows at this speed in km/My towards the other plate.
fn speed_of_sinking(resistance: f64, towards: f64) -> f64 {
    let mut recipe = recipe(2_500);
    recipe.constants.mantle.slab_speed = towards.abs();
    let motion = &mut recipe.constants.motion;
    motion.slab_pull = 1e6;
    motion.slab_resistance = resistance;
    motion.slab_suction = 0.0;
    motion.ridge_push = 0.0;
    motion.friction = 0.0;
    motion.ocean_drag = 0.1;
    let mut history = History::new(recipe).unwrap();
    arrange(&mut history, closing(), |plate, _| Ground {
        created_my: if plate == SOUTH { -150.0 } else { -30.0 },
        ..SEA_FLOOR
    });
    // Without continents it stays so.
    history.world_mut().resource_mut::<Mantle>().downwelling = DVec3::Y * towards.signum();
    run(&mut history, 6.0);
    let world = history.world_mut();
    let mut plates = world.query::<(&Plate, &Rotation)>();
    let mut plates = plates.iter(world);
    let south = plates.find(|(plate, _)| plate.id == SOUTH).unwrap();
    south.1.0.length() * RADIUS
}

/// A plate that turns about a pole runs so much faster at its equator than a straight trench would have it.
const EQUATOR: f64 = 4.0 / core::f64::consts::PI;

/// Slabs of 120 My would sink at 50 km/My √(120/80) along a straight trench, and plates with them, however little
/// else holds them. Fronts zigzag and are half as long again as their trench, so they resist more.
#[test]
fn no_plate_outruns_its_slab() {
    let sinking = 50.0 * 1.5_f64.sqrt() * EQUATOR;
    let (held, free) = (speed_of_sinking(2e4, 0.0), speed_of_sinking(0.0, 0.0));
    assert!((0.5..0.8).contains(&(held / sinking)), "{held} {sinking}");
    assert!(free > 2.0 * sinking, "{free} {sinking}");
}

/// What a slab meets is the mantle: it moves with it.
#[test]
fn the_mantle_carries_slabs_along() {
    let flow = 15.0 * EQUATOR;
    let rest = speed_of_sinking(2e4, 0.0);
    for (towards, sign) in [(15.0, 1.0), (-15.0, -1.0)] {
        let gained = sign * (speed_of_sinking(2e4, towards) - rest);
        assert!((0.6..1.05).contains(&(gained / flow)), "{gained} {flow}");
    }
}

/// Area opens at −x at 2 v R ∫ cos φ dφ = 4 v R per My and closes at +x just as fast.
#[test]
fn as_much_crust_is_made_and_consumed_as_geometry_asks_for() {
    let mut history = History::with_plugins(recipe(2_500), steady()).unwrap();
    arrange(&mut history, closing(), |_, _| SEA_FLOOR);
    run(&mut history, 40.0);
    let expected = 4.0 * SPEED * RADIUS * 40.0;
    let ledger = history.ledger();
    for (name, area) in [
        ("created", ledger.area_created_km2),
        ("consumed", ledger.area_consumed_km2),
    ] {
        assert!(
            (area / expected - 1.0).abs() < 0.2,
            "{name} {area} km² instead of {expected} km²"
        );
    }
}

#[test]
fn the_older_sea_floor_goes_under() {
    /// Floor that was there at first, and its plate then; no plate's what is born.
    #[derive(Component, Default)]
    struct Old(PlateId);
    fn remember(app: &mut App) {
        app.register_required_components::<SubPlate, Old>();
    }
    for older in [SOUTH, NORTH] {
        let plugins = steady().add(remember);
        let mut history = History::with_plugins(recipe(2_500), plugins).unwrap();
        arrange(&mut history, closing(), |plate, _| Ground {
            created_my: if plate == older { -120.0 } else { -30.0 },
            ..SEA_FLOOR
        });
        let world = history.world_mut();
        let mut lost: BTreeMap<PlateId, f64> = BTreeMap::new();
        for (mut old, &plate) in world.query::<(&mut Old, &PlateId)>().iter_mut(world) {
            old.0 = plate;
            *lost.entry(plate).or_default() += 1.0;
        }
        run(&mut history, 30.0);
        let world = history.world_mut();
        for Old(plate) in world.query::<&Old>().iter(world) {
            lost.entry(*plate).and_modify(|lost| *lost -= 1.0);
        }
        let share = lost[&older] / lost.values().sum::<f64>();
        assert!(
            share > 0.9,
            "only {share} of what went was of the older plate"
        );
        // Its floor is bent down at the trench, the other plate's is not.
        let (trench, plate): (Vec<Trench>, Vec<PlateId>) =
            (column(&mut history), column(&mut history));
        let deepest = |of: PlateId| {
            let depths = trench.iter().zip(&plate).filter(|(_, plate)| **plate == of);
            depths.map(|(trench, _)| trench.0).fold(0.0, f32::max)
        };
        let other = if older == SOUTH { NORTH } else { SOUTH };
        assert!(deepest(older) > 500.0 && deepest(other) < 0.5 * deepest(older));
    }
}

/// A continent over a trench on one side, and beside an ocean that opens on the other.
fn one_continent(time_my: f64) -> History {
    let mut history = History::with_plugins(recipe(2_500), steady()).unwrap();
    arrange(&mut history, closing(), |plate, _| {
        if plate == SOUTH {
            CONTINENT
        } else {
            Ground {
                created_my: -100.0,
                ..SEA_FLOOR
            }
        }
    });
    run(&mut history, time_my);
    history
}

#[test]
fn slabs_draw_the_crust_above_them_down() {
    let mut history = one_continent(20.0);
    let depths = |history: &mut History, near: f64, far: f64| -> Vec<f32> {
        let crust: Vec<Crust> = column(history);
        let trench: Vec<Trench> = column(history);
        let place: Vec<Position> = column(history);
        let at = |v: &usize| {
            let place = place[*v].0.as_dvec3();
            let inland = -RADIUS * libm::asin(place.y);
            place.x > 0.8 && (near..far).contains(&inland) && crust[*v].is_continental()
        };
        (0..crust.len()).filter(at).map(|v| trench[v].0).collect()
    };
    // 60 km/My: 2,300 m at the trench, nothing 400 km and half a cell behind it.
    let mean = |depths: &[f32]| depths.iter().sum::<f32>() / depths.len() as f32;
    let deepest = depths(&mut history, -2000.0, 2500.0)
        .into_iter()
        .fold(0.0, f32::max);
    assert!((800.0..2300.0).contains(&deepest), "{deepest}");
    let inland = depths(&mut history, 2500.0, 6000.0);
    assert!(inland.len() > 20 && mean(&inland) == 0.0, "{inland:?}");
}

#[test]
fn a_continent_is_stretched_before_an_ocean_opens_beside_it() {
    let mut history = one_continent(25.0);
    let crust: Vec<Crust> = column(&mut history);
    let thickness: Vec<Thickness> = column(&mut history);
    let place: Vec<Position> = column(&mut history);
    let area: Vec<MaterialArea> = column(&mut history);
    let opening = |v: &usize| place[*v].0.x < -0.8;
    let thin = |v: &usize| crust[*v].is_continental() && thickness[*v].0 < 30.0;
    let stretched: Vec<usize> = (0..crust.len()).filter(opening).filter(thin).collect();
    assert!(stretched.len() > 10, "{}", stretched.len());
    let thinnest = stretched
        .iter()
        .map(|&v| thickness[v].0)
        .fold(f64::MAX, f64::min);
    assert!((8.0..25.0).contains(&thinnest), "{thinnest}");
    // Then it has let go.
    let young: f64 = (0..crust.len())
        .filter(opening)
        .filter(|&v| !crust[v].is_continental() && thickness[v].0 == 7.0)
        .map(|v| area[v].0)
        .sum();
    assert!(young > 1e6, "{young}");
    assert!(history.ledger().area_stretched_km2 > 1e5);
}

#[test]
fn colliding_continents_thicken_and_keep_their_volume() {
    let collide = |rotations| {
        // Nothing but the collision changes continents.
        let plugins = steady().disable::<ErodePlugin>().disable::<UpliftPlugin>();
        let mut history = History::with_plugins(recipe(2_500), plugins).unwrap();
        arrange(&mut history, rotations, |_, site| {
            if site.x > 0.8 { CONTINENT } else { SEA_FLOOR }
        });
        run(&mut history, 20.0);
        history
    };
    let mut history = collide(closing());
    let ledger = history.ledger();
    let crust: Vec<Crust> = column(&mut history);
    let thickness: Vec<Thickness> = column(&mut history);
    let area: Vec<MaterialArea> = column(&mut history);
    let orogeny: Vec<Orogeny> = column(&mut history);
    let (mut volume, mut extent, mut thickest) = (0.0, 0.0, 0.0_f64);
    for v in (0..crust.len()).filter(|&v| crust[v].is_continental()) {
        volume += thickness[v].0 * area[v].0;
        extent += area[v].0;
        thickest = thickest.max(thickness[v].0);
        // One cell has 40.9 km without a mountain building; what thickened it is not known.
        if thickness[v].0 > 42.0 {
            assert_eq!(
                orogeny[v],
                Orogeny::Himalayan,
                "thick without a mountain building"
            );
        }
    }
    assert!((volume / (ledger.initial_km3 + ledger.accreted_km3()) - 1.0).abs() < 1e-9);
    assert!(thickest > 40.0 && thickest <= 70.0 + 1e-9, "{thickest} km");
    // 60 km/My over the front's 73.7°, 2 R sin 36.9° in its projection, for 20 My.
    let swept = 2.0 * SPEED * 20.0 * 2.0 * RADIUS * 0.6;
    let shortened = ledger.area_shortened_km2;
    assert!(
        (shortened / swept - 1.0).abs() < 0.4,
        "{shortened} km² shortened, {swept} km² swept"
    );
    assert!((extent - (ledger.initial_km3 / 35.0 - shortened)).abs() / extent < 0.15);

    let resting = collide([DVec3::ZERO; 2]);
    assert_eq!(resting.ledger().area_shortened_km2, 0.0);
    assert_eq!(resting.ledger().booked_km3(), resting.ledger().initial_km3);
}

#[test]
fn rigid_plates_never_bend_and_soft_ones_do() {
    for drive in [Drive::Rigid, Drive::Soft] {
        let mut recipe = Recipe::earth_like(2).with_sub_plates(1_000);
        recipe.drive = drive;
        let mut history = History::new(recipe).unwrap();
        run(&mut history, 10.0);
        let bent = column::<Deviation>(&mut history)
            .iter()
            .filter(|deviation| deviation.0 != Vec3::ZERO)
            .count();
        assert_eq!(bent > 0, drive == Drive::Soft, "{drive:?}: {bent} bent");
    }
}

/// Keeps the two plates to their motions for 100 My.
fn hold(history: &mut History, rotations: [DVec3; 2]) {
    let world = history.world_mut();
    let mut plates = world.query::<(Entity, &Plate)>();
    let held: Vec<(Entity, HeldMotion)> = plates
        .iter(world)
        .map(|(entity, plate)| {
            let rotation = rotations[usize::from(plate.id.0) - 1];
            let until_my = 100.0;
            (entity, HeldMotion { rotation, until_my })
        })
        .collect();
    for (entity, held) in held {
        world.entity_mut(entity).insert(held);
    }
}

/// A continent advances on a trench at 30 km/My, and its margin yields by 0.4 of that; one that the
/// trench follows does not, however fast sea floor goes under it. Old floor draws it seaward by 6 km/My.
#[test]
fn young_slabs_shorten_the_margins_above_them_and_old_ones_stretch_them() {
    let retreating = [
        DVec3::Z * (-SPEED / RADIUS),
        DVec3::Z * (-3.0 * SPEED / RADIUS),
    ];
    let advancing = [DVec3::Z * (SPEED / RADIUS), DVec3::ZERO];
    for (rotations, floor, expected) in [
        (advancing, -20.0, 0.4 * SPEED),
        (retreating, -20.0, 0.0),
        (advancing, -120.0, -6.0),
        (retreating, -120.0, -6.0),
    ] {
        let mut recipe = recipe(10_000);
        recipe.constants.uplift.arc_flux = 0.0;
        recipe.constants.margins.rollback = 6.0;
        recipe.constants.erosion.rate = 0.0;
        recipe.constants.erosion.shelf_time = 500.0;
        let mut history = History::new(recipe).unwrap();
        arrange(&mut history, rotations, |_, site| {
            if site.x > 0.5 && site.y < 0.0 {
                CONTINENT
            } else {
                Ground {
                    created_my: floor,
                    ..SEA_FLOOR
                }
            }
        });
        hold(&mut history, rotations);
        run(&mut history, 8.0);
        let moved = rotations[0].z * history.time_my();
        let position: Vec<Position> = column(&mut history);
        let deviation: Vec<Deviation> = column(&mut history);
        let thickness: Vec<Thickness> = column(&mut history);
        let crust: Vec<Crust> = column(&mut history);
        // Away from the front in km, as the plate carries it; inward speed; thickness.
        let margin: Vec<(f64, f64, f64)> = (0..crust.len())
            .filter(|&v| crust[v].is_continental() && position[v].0.x > 0.75)
            .map(|v| {
                let at = position[v].0;
                let east = libm::atan2(f64::from(at.y), f64::from(at.x)) - moved;
                (-east * RADIUS, f64::from(-deviation[v].0.y), thickness[v].0)
            })
            .filter(|(inland, ..)| *inland < 300.0)
            .collect();
        assert!(margin.len() > 20);
        let count = margin.len() as f64;
        let inward = margin.iter().map(|of| of.1).sum::<f64>() / count;
        let thick = margin.iter().map(|of| of.2).sum::<f64>() / count;
        if expected > 0.0 {
            assert!(inward > 0.25 * expected && inward <= expected, "{inward}");
            // 70 km less of a margin of 600 km would be 39 km at best; the front row thins to a shelf.
            assert!(thick > 35.7, "{thick}");
        } else if expected < 0.0 {
            assert!(inward < 0.25 * expected && inward >= expected, "{inward}");
            assert!(thick < 34.5, "{thick}");
        } else {
            assert!(inward.abs() < 0.1, "{inward}");
            assert!(thick <= 35.0, "{thick}");
        }
    }
}

/// Two continents close at twice 30 km/My; margins take up half of that, a half on either side.
#[test]
fn margins_yield_where_continents_collide() {
    let mut history = History::new(recipe(10_000)).unwrap();
    arrange(&mut history, closing(), |_, site| {
        if site.x > 0.5 { CONTINENT } else { SEA_FLOOR }
    });
    hold(&mut history, closing());
    run(&mut history, 8.0);
    // Inward deviations by distance from the front, in km.
    let position: Vec<Position> = column(&mut history);
    let deviation: Vec<Deviation> = column(&mut history);
    let plate_of: Vec<PlateId> = column(&mut history);
    let mean = |from: f64, to: f64| {
        let band: Vec<f64> = (0..plate_of.len())
            .filter(|&v| {
                let at = position[v].0;
                at.x > 0.7 && (from..to).contains(&(f64::from(at.y.abs()) * RADIUS))
            })
            .map(|v| f64::from(deviation[v].0.y) * if plate_of[v] == NORTH { 1.0 } else { -1.0 })
            .collect();
        assert!(band.len() > 20);
        band.iter().sum::<f64>() / band.len() as f64
    };
    // Ends of a front that lie far apart yield less.
    let bands = [(0.0, 300.0), (500.0, 800.0), (1200.0, 2000.0)].map(|(from, to)| mean(from, to));
    let [front, inland, plate] = bands;
    assert!(front > 0.2 * SPEED && front <= 0.5 * SPEED, "{bands:?}");
    assert!(inland > 0.1 * front && inland < 0.7 * front, "{bands:?}");
    assert!(plate.abs() < 1e-3 * SPEED, "{bands:?}");

    // What is shortened far behind the front is part of the belt, and still held up by what presses it.
    let orogeny: Vec<Orogeny> = column(&mut history);
    let began: Vec<OrogenyBegan> = column(&mut history);
    let fold: Vec<FoldDirection> = column(&mut history);
    let belts = |from: f64, to: f64| {
        let band: Vec<usize> = (0..plate_of.len())
            .filter(|&v| {
                let at = position[v].0;
                at.x > 0.7 && (from..to).contains(&(f64::from(at.y.abs()) * RADIUS))
            })
            .collect();
        let pressed = band.iter().filter(|&&v| {
            orogeny[v] == Orogeny::Himalayan
                && history.time_my() - f64::from(began[v].0) < 4.0
                && fold[v].0.y.abs() > 0.5 * fold[v].0.length()
        });
        pressed.count() as f64 / band.len() as f64
    };
    let belts = [(500.0, 700.0), (1200.0, 2000.0)].map(|(from, to)| belts(from, to));
    assert!(belts[0] > 0.5 && belts[1] < 0.01, "{belts:?}");
}

/// Where strips of thick crust meet strips of thin, they do not run through each other like the teeth of
/// two combs: what juts out is crushed first.
#[test]
fn fronts_of_colliding_continents_stay_smooth() {
    let mut history = History::new(recipe(10_000)).unwrap();
    arrange(&mut history, closing(), |plate, site| {
        let strip = (site.z * 12.0).floor().rem_euclid(2.0) == 0.0;
        let thickness_km = if strip == (plate == NORTH) {
            45.0
        } else {
            33.0
        };
        let ground = Ground {
            thickness_km,
            ..CONTINENT
        };
        if site.x > 0.5 { ground } else { SEA_FLOOR }
    });
    hold(&mut history, closing());
    run(&mut history, 20.0);
    let plate: Vec<PlateId> = column(&mut history);
    let mesh = &history.world().resource::<Topology>().0;
    let offsets: Vec<f64> = mesh
        .edges()
        .map(|edge| mesh.endpoints(edge))
        .filter(|&(u, v)| plate[u as usize] != plate[v as usize] && mesh.site(u).x > 0.7)
        .map(|(u, v)| 0.5 * (mesh.site(u).y + mesh.site(v).y) * RADIUS)
        .collect();
    let mean = offsets.iter().sum::<f64>() / offsets.len() as f64;
    let spread =
        offsets.iter().map(|y| (y - mean) * (y - mean)).sum::<f64>() / offsets.len() as f64;
    // Cells are 226 km wide; combs spread over 210 km and more.
    assert!(offsets.len() > 40 && spread.sqrt() < 170.0, "{spread}");
}

#[test]
fn a_flipped_edge_swaps_its_springs() {
    let mut history = History::new(recipe(500)).unwrap();
    history.step().unwrap();
    let mut topology = history.world_mut().resource_mut::<Topology>();
    let mesh = &mut topology.0;
    let edge = mesh
        .edges()
        .find(|&edge| {
            let [u, v] = [mesh.apex(2 * edge), mesh.apex(2 * edge + 1)];
            mesh.half_edge_between(u, v).is_none()
        })
        .unwrap();
    let h = 2 * edge;
    let around = [
        mesh.next(h),
        mesh.prev(h),
        mesh.next(h ^ 1),
        mesh.prev(h ^ 1),
    ];
    for side in around {
        mesh.payload_mut(side / 2).rest = 3.0;
        mesh.payload_mut(side / 2).cross_rest = 4.0;
    }
    let (ends, apexes) = (mesh.endpoints(edge), (mesh.apex(h), mesh.apex(h ^ 1)));
    let state = mesh.payload_mut(edge);
    state.rest = 1.0;
    state.cross_rest = 2.0;
    assert!(mesh.flip(h));
    let sorted = |(a, b): (u32, u32)| (a.min(b), a.max(b));
    assert_eq!(sorted(mesh.endpoints(edge)), sorted(apexes));
    assert_eq!(sorted((mesh.apex(h), mesh.apex(h ^ 1))), sorted(ends));
    assert_eq!(mesh.payload(edge).rest, 2.0);
    assert_eq!(mesh.payload(edge).cross_rest, 1.0);
    // The edges around it join the same vertices as before, but their cross edges do not.
    for side in around {
        assert_eq!(mesh.payload(side / 2).rest, 3.0);
        assert_eq!(mesh.payload(side / 2).cross_rest, 0.0);
    }
}

/// Gives the sub-plates that `cut` picks to the other plate, which leaves the northern plate in two
/// pieces, and runs a step.
fn cut_and_step(cut: impl Fn(DVec3, PlateId) -> bool) -> (History, usize) {
    let mut history = History::with_plugins(recipe(2_500), steady()).unwrap();
    arrange(&mut history, [DVec3::Z * 0.005; 2], |_, _| SEA_FLOOR);
    history.step().unwrap();
    let world = history.world_mut();
    let sites = world.resource::<Topology>().0.sites().to_vec();
    let mut plates = world.query_filtered::<&mut PlateId, With<SubPlate>>();
    for (site, mut plate) in sites.into_iter().zip(plates.iter_mut(world)) {
        if cut(site, *plate) {
            *plate = if *plate == SOUTH { NORTH } else { SOUTH };
        }
    }
    world.resource_mut::<Splits>().suspected = true;
    let error = history.check().unwrap_err();
    let torn = matches!(
        error,
        TectonicError::PlateInPieces {
            plate: 2,
            pieces: 2,
            ..
        }
    );
    assert!(torn, "{error}");
    history.step().unwrap();
    history.check().unwrap();
    let world = history.world_mut();
    let plates = world.query::<(&Plate, &Rotation)>().iter(world).count();
    (history, plates)
}

#[test]
fn a_plate_cut_in_two_becomes_two() {
    // A band along x = 0 divides the northern hemisphere in halves.
    let (mut history, plates) = cut_and_step(|site, plate| plate == NORTH && site.x.abs() < 0.15);
    assert_eq!(plates, 3);
    let plate: Vec<PlateId> = column(&mut history);
    let count = |id: u16| plate.iter().filter(|plate| plate.0 == id).count();
    assert!(
        count(2) > 400 && count(3) > 400,
        "{} {}",
        count(2),
        count(3)
    );
    // The new plate moves on as the old one did.
    let world = history.world_mut();
    for (plate, rotation) in world.query::<(&Plate, &Rotation)>().iter(world) {
        assert_eq!(rotation.0, DVec3::Z * 0.005, "{plate:?}");
    }
}

#[test]
fn a_splinter_is_absorbed() {
    // An island of some six sub-plates in the middle of the southern plate is far less than a plate.
    let (mut history, plates) = cut_and_step(|site, _| site.y < -0.995);
    assert_eq!(plates, 2);
    let sites = history.world().resource::<Topology>().0.sites().to_vec();
    let plate: Vec<PlateId> = column(&mut history);
    for (site, plate) in sites.iter().zip(plate) {
        if site.y < -0.9 {
            assert_eq!(plate, SOUTH, "the island joins the plate around it");
        }
    }
}
