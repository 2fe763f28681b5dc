//! Scripted events: each does what it says, exactly when it says so.

#[expect(dead_code, reason = "shared with other tests")]
mod game;
#[path = "stages/scenario.rs"]
#[expect(dead_code, reason = "shared with other tests")]
mod scenario;

use bevy::prelude::*;
use bevy_tectonics::prelude::*;
use bevy_tectonics::simulation::{
    Clock, Contact, Contacts, EventFailure, HotSpot, LatLon, MaterialArea, NewCrust, Plate,
    PlateChoice, PlateId, Rotation, Thickness, Topology,
};
use core::ops::ControlFlow;
use game::Game;
use glam::DVec3;
use scenario::*;

const RADIUS: f64 = 6371.0;

fn run_until(history: &mut History, time_my: f64) {
    history
        .run_until(time_my, |_| ControlFlow::Continue(()))
        .unwrap();
    history.check().unwrap();
}

fn set_motion(plate: PlateChoice, pole: [f64; 2], deg_per_my: f64, hold_my: f64) -> Intervention {
    Intervention::SetMotion {
        plate,
        pole: pole.into(),
        deg_per_my,
        hold_my,
    }
}

fn disc(lat: f64, lon: f64, radius_km: f64, crust: NewCrust) -> Intervention {
    Intervention::SetCrust {
        centre: LatLon::new(lat, lon),
        radius_km,
        crust,
    }
}

fn rotation(history: &mut History, id: PlateId) -> Option<DVec3> {
    let world = history.world_mut();
    let mut plates = world.query::<(&Plate, &Rotation)>();
    let found = plates.iter(world).find(|(plate, _)| plate.id == id);
    found.map(|(_, rotation)| rotation.0)
}

fn plate_at(history: &mut History, lat: f64, lon: f64) -> PlateId {
    let plate: Vec<PlateId> = column(history);
    let mesh = &history.world().resource::<Topology>().0;
    plate[mesh.nearest(LatLon::new(lat, lon).direction(), 0) as usize]
}

/// Continental volume in km³.
fn volume(history: &mut History) -> f64 {
    let crust: Vec<Crust> = column(history);
    let thickness: Vec<Thickness> = column(history);
    let area: Vec<MaterialArea> = column(history);
    (0..crust.len())
        .filter(|&v| crust[v].is_continental())
        .map(|v| thickness[v].0 * area[v].0)
        .sum()
}

/// A planet with something of every kind on it.
fn eventful() -> Recipe {
    Recipe::earth_like(11)
        .with_sub_plates(1_500)
        .with_duration(40.0)
        .with_event(
            12.345,
            Intervention::BreakUp {
                plate: PlateChoice::At(LatLon::new(40.0, 10.0)),
                pieces: 2,
            },
        )
        .with_event(3.0, set_motion(PlateChoice::Id(1), [90.0, 0.0], 1.0, 7.77))
        .with_event(
            3.0,
            disc(
                0.0,
                0.0,
                2_000.0,
                NewCrust::Continental { thickness_km: 37.0 },
            ),
        )
        .with_event(
            20.1,
            disc(0.0, 180.0, 1_500.0, NewCrust::Oceanic { age_my: 30.0 }),
        )
        .with_event(
            5.5,
            Intervention::StartHotSpot {
                place: LatLon::new(-20.0, 80.0),
                strength: 1.5,
            },
        )
        .with_event(
            30.0,
            Intervention::StopHotSpot {
                place: LatLon::new(-20.0, 81.0),
            },
        )
        .with_event(
            25.0,
            Intervention::Rift {
                line: vec![LatLon::new(30.0, 100.0), LatLon::new(-30.0, 110.0)],
            },
        )
}

#[test]
fn the_same_events_make_the_same_planet() {
    let grow = |recipe: Recipe, threads| {
        let mut history = History::with_threads(recipe, threads).unwrap();
        run_until(&mut history, 40.0);
        (history.state_hash().unwrap(), history.event_log().to_vec())
    };
    let (hash, log) = grow(eventful(), 1);
    assert_eq!(grow(eventful(), 2), (hash, log.clone()));
    // In any order.
    let mut other = eventful();
    other.events.sort_by(|a, b| a.at_my.total_cmp(&b.at_my));
    assert_eq!(grow(other, 1).0, hash);
    // One of them less is another planet.
    let mut less = eventful();
    less.events.retain(|event| event.at_my != 5.5);
    assert_ne!(grow(less, 1).0, hash);

    let times: Vec<f64> = log.iter().map(|record| record.time_my).collect();
    assert_eq!(times, [3.0, 3.0, 5.5, 12.345, 20.1, 25.0, 30.0]);
    let failed: Vec<_> = log
        .iter()
        .filter(|record| record.failure.is_some())
        .collect();
    assert!(failed.is_empty(), "could not be done: {failed:?}");
}

#[test]
fn steps_end_exactly_when_events_are_due() {
    let mut history = History::new(eventful()).unwrap();
    let mut ends = vec![0.0];
    let mut fastest = 0.0;
    while history.time_my() < 35.0 {
        history.step().unwrap();
        history.check().unwrap();
        let clock = history.world().resource::<Clock>();
        assert_eq!(clock.began_my, ends[ends.len() - 1]);
        ends.push(clock.time_my);
        // Something fast is not given a step made for slow plates; what a step speeds up is met at the
        // next.
        let spacing = history.recipe().spacing_km();
        assert!(clock.step_my * fastest <= 0.36 * spacing, "{clock:?}");
        fastest = clock.fastest;
    }
    // 3 + 7.77 My is when the motion that was held is let go.
    for due in [3.0, 5.5, 3.0 + 7.77, 12.345, 20.1, 25.0, 30.0] {
        assert!(ends.contains(&due), "no step ends at {due} My: {ends:?}");
    }
    for record in history.event_log() {
        assert_eq!(record.time_my, record.event.at_my);
    }
}

#[test]
fn a_plate_turns_as_it_is_told_and_is_let_go() {
    let turn = DVec3::Z * 0.5_f64.to_radians();
    let recipe = recipe(1_000).with_event(
        2.0,
        set_motion(
            PlateChoice::At(LatLon::new(0.0, 90.0)),
            [90.0, 0.0],
            0.5,
            10.0,
        ),
    );
    let mut history = History::new(recipe).unwrap();
    arrange(&mut history, [DVec3::Z * 0.001; 2], |_, _| SEA_FLOOR);
    run_until(&mut history, 2.0);
    assert_ne!(rotation(&mut history, NORTH), Some(turn));
    while history.time_my() < 11.0 {
        history.step().unwrap();
        let found = rotation(&mut history, NORTH).unwrap();
        assert!((found - turn).length() < 1e-15, "{found}");
    }
    run_until(&mut history, 30.0);
    // Nothing drives it: the balance of torques has slowed it down.
    let slowed = rotation(&mut history, NORTH).unwrap();
    assert!(slowed.length() < 0.7 * turn.length(), "{slowed}");

    // Not held, the drive takes over at once; without a drive it goes on.
    let mut history = History::with_plugins(recipe_with_push(), steady()).unwrap();
    arrange(&mut history, [DVec3::Z * 0.001; 2], |_, _| SEA_FLOOR);
    run_until(&mut history, 5.0);
    let found = rotation(&mut history, SOUTH).unwrap();
    assert!((found - DVec3::X * 0.2_f64.to_radians()).length() < 1e-15);
}

fn recipe_with_push() -> Recipe {
    recipe(1_000).with_event(1.0, set_motion(PlateChoice::Id(1), [0.0, 0.0], 0.2, 0.0))
}

#[test]
fn a_rift_divides_a_plate_along_its_line_and_its_sides_part() {
    // The northern plate is the hemisphere around 90° E; the line runs south through its middle.
    let line = [[40.0, 90.0], [0.0, 90.0], [-40.0, 90.0]].map(LatLon::from);
    let recipe = recipe(2_500).with_event(1.0, Intervention::Rift { line: line.into() });
    let mut history = History::new(recipe).unwrap();
    arrange(&mut history, [DVec3::ZERO; 2], |_, _| SEA_FLOOR);
    run_until(&mut history, 2.0);
    assert_eq!(history.event_log()[0].failure, None);
    let (west, east) = (
        plate_at(&mut history, 0.0, 60.0),
        plate_at(&mut history, 0.0, 120.0),
    );
    assert_ne!(west, east);
    assert!(west != SOUTH && east != SOUTH);
    for (lat, lon, side) in [
        (60.0, 75.0, west),
        (60.0, 105.0, east),
        (-60.0, 75.0, west),
        (-60.0, 105.0, east),
    ] {
        assert_eq!(plate_at(&mut history, lat, lon), side, "[{lat}, {lon}]");
    }
    // They part across the line, at some 20 km/My at first and under the push of a young rift later.
    let middle = LatLon::new(0.0, 90.0).direction();
    let opening = |history: &mut History| {
        let [a, b] = [west, east].map(|id| rotation(history, id).unwrap());
        // East at 90° E is −x.
        (b - a).cross(middle).dot(-DVec3::X) * RADIUS
    };
    assert!(opening(&mut history) > 10.0, "{}", opening(&mut history));
    run_until(&mut history, 20.0);
    assert!(opening(&mut history) > 10.0, "{}", opening(&mut history));
    let age = history.surface().unwrap();
    let at = age.mesh.nearest(middle, 0) as usize;
    assert!(age.age[at] < 19.0, "no new sea floor: {} My", age.age[at]);
}

#[test]
fn crust_changes_its_kind_and_the_books_stay_closed() {
    let recipe = Recipe::earth_like(4)
        .with_sub_plates(2_500)
        .with_event(
            0.0,
            disc(0.0, 0.0, 30_000.0, NewCrust::Oceanic { age_my: 60.0 }),
        )
        .with_event(
            0.0,
            disc(
                10.0,
                20.0,
                1_500.0,
                NewCrust::Continental { thickness_km: 38.0 },
            ),
        );
    let mut history = History::new(recipe).unwrap();
    let before = volume(&mut history);
    history.step().unwrap();
    history.check().unwrap();
    let ledger = history.ledger();
    assert!((ledger.prescribed_km3 - (volume(&mut history) - before)).abs() < 0.02 * before);
    // A cap of 1,500 km: 2πR²(1 − cos(1500/6371)) = 7.036e6 km², times 38 km.
    let expected = 7.036e6 * 38.0;
    let booked = ledger.initial_km3 + ledger.prescribed_km3;
    assert!(
        (booked / expected - 1.0).abs() < 0.1,
        "{booked} km³ of {expected} km³"
    );
    let surface = history.surface().unwrap();
    let mesh = &surface.mesh;
    let centre = LatLon::new(10.0, 20.0).direction();
    for v in 0..mesh.vertex_count() {
        let away = centre.angle_between(mesh.site(v as u32)) * RADIUS;
        if (away - 1_500.0).abs() > 300.0 {
            assert_eq!(
                surface.crust[v].is_continental(),
                away < 1_500.0,
                "{away} km"
            );
        }
        if away > 2_500.0 {
            assert!((surface.age[v] - 60.0).abs() < 2.0, "{} My", surface.age[v]);
        }
    }
    // The change shows at once: isostasy gives 155 m/km · (38 − 35.6) km.
    let height = surface.elevation[mesh.nearest(centre, 0) as usize];
    let plain = surface.elevation[mesh.nearest(-centre, 0) as usize];
    assert!(height - plain > 4_000.0, "{height} m over {plain} m");
    run_until(&mut history, 20.0);
}

#[test]
fn hot_spots_start_and_stop() {
    let place = LatLon::new(5.0, 60.0);
    let mut recipe = Recipe::earth_like(4)
        .with_sub_plates(500)
        .with_event(
            2.0,
            Intervention::StartHotSpot {
                place,
                strength: 3.0,
            },
        )
        .with_event(
            6.0,
            Intervention::StopHotSpot {
                place: LatLon::new(7.0, 61.0),
            },
        )
        .with_event(7.0, Intervention::StopHotSpot { place });
    recipe.hot_spots = 0;
    let mut history = History::new(recipe).unwrap();
    let hot_spots = |history: &mut History| -> Vec<HotSpot> {
        let world = history.world_mut();
        world.query::<&HotSpot>().iter(world).copied().collect()
    };
    run_until(&mut history, 2.0);
    assert_eq!(hot_spots(&mut history), []);
    run_until(&mut history, 5.0);
    let [hot_spot] = hot_spots(&mut history)[..] else {
        panic!("one hot spot")
    };
    assert!((hot_spot.place - place.direction()).length() < 1e-15);
    assert_eq!((hot_spot.flux, hot_spot.since_my), (3.0 * 1.0e5, 2.0));
    run_until(&mut history, 8.0);
    assert_eq!(hot_spots(&mut history), []);
    let failure = history.event_log()[2].failure.unwrap();
    assert_eq!(
        failure.to_string(),
        "no hot spot lies within 1000 km of [5, 60]"
    );
}

#[test]
fn a_supercontinent_breaks_up_and_its_pieces_part() {
    let recipe = recipe(2_500).with_event(
        10.0,
        Intervention::BreakUp {
            plate: PlateChoice::At(LatLon::new(0.0, 90.0)),
            pieces: 3,
        },
    );
    let mut history = History::new(recipe).unwrap();
    arrange(&mut history, [DVec3::ZERO; 2], |plate, site| {
        if plate == NORTH && site.y > 0.5 {
            CONTINENT
        } else {
            SEA_FLOOR
        }
    });
    run_until(&mut history, 10.0);
    // A collision that would hold it fast.
    let held = Contact {
        interpenetration: 900.0,
        ..default()
    };
    history
        .world_mut()
        .resource_mut::<Contacts>()
        .0
        .insert((SOUTH, NORTH), held);
    let plates = |history: &mut History| -> Vec<PlateId> {
        let world = history.world_mut();
        let mut ids: Vec<_> = world.query::<&Plate>().iter(world).map(|p| p.id).collect();
        ids.sort_unstable();
        ids
    };
    let first = history.surface().unwrap();
    assert_eq!(plates(&mut history).len(), 2);
    history.step().unwrap();
    history.check().unwrap();
    assert_eq!(history.event_log()[0].failure, None);
    assert_eq!(plates(&mut history).len(), 4);
    let contacts = &history.world().resource::<Contacts>().0;
    assert!(contacts[&(SOUTH, NORTH)].interpenetration < 10.0);
    let young = contacts
        .values()
        .filter(|contact| contact.rift.is_some_and(|rift| rift.began_my == 10.0));
    assert_eq!(young.count(), 3);
    run_until(&mut history, 40.0);
    // New sea lies between what was one continent.
    let spread = |surface: &Surface| {
        let mean: DVec3 = (0..surface.crust.len())
            .filter(|&v| surface.crust[v].is_continental())
            .map(|v| surface.mesh.site(v as u32))
            .sum();
        mean.length() / surface.crust.iter().filter(|c| c.is_continental()).count() as f64
    };
    let last = history.surface().unwrap();
    assert!(
        spread(&last) < spread(&first) - 0.005,
        "{} {}",
        spread(&last),
        spread(&first)
    );
}

#[test]
fn what_cannot_be_done_is_noted_and_changes_nothing() {
    let quiet = Recipe::earth_like(8)
        .with_sub_plates(800)
        .with_duration(20.0);
    let point = LatLon::new(0.0, 0.0);
    let recipe = quiet
        .clone()
        .with_event(5.0, set_motion(PlateChoice::Id(999), [0.0, 0.0], 1.0, 0.0))
        .with_event(5.0, disc(0.0, 0.0, 1.0, NewCrust::Oceanic { age_my: 0.0 }));
    let mut history = History::new(recipe).unwrap();
    run_until(&mut history, 20.0);
    let failures: Vec<_> = history
        .event_log()
        .iter()
        .map(|record| record.failure)
        .collect();
    let nothing = EventFailure::NothingThere {
        centre: point,
        radius_km: 1.0,
    };
    assert_eq!(
        failures,
        [Some(EventFailure::NoPlate { id: 999 }), Some(nothing)]
    );
    assert_eq!(failures[0].unwrap().to_string(), "there is no plate 999");
    assert_eq!(
        failures[1].unwrap().to_string(),
        "no sub-plate lies within 1 km of [0, 0]"
    );
    assert_eq!(history.ledger().prescribed_km3, 0.0);
}

#[test]
fn wrong_events_are_refused_with_the_place_and_the_range() {
    let hot_spot = |lat: f64, lon: f64, strength: f64| Intervention::StartHotSpot {
        place: LatLon::new(lat, lon),
        strength,
    };
    let fine = hot_spot(0.0, 0.0, 1.0);
    let id = PlateChoice::Id(1);
    for (at_my, what, message) in [
        (
            -1.0,
            fine.clone(),
            "events[1].at_my is -1, but must be between 0 and 10000 My",
        ),
        (
            f64::NAN,
            fine.clone(),
            "events[1].at_my is NaN, but must be between 0 and 10000 My",
        ),
        (
            1.0,
            hot_spot(91.0, 0.0, 1.0),
            "latitude of events[1].start-hot-spot.place is 91, but must be between -90 and 90 degrees",
        ),
        (
            1.0,
            hot_spot(0.0, f64::INFINITY, 1.0),
            "longitude of events[1].start-hot-spot.place is inf, but must be between -360 and 360 \
             degrees",
        ),
        (
            1.0,
            hot_spot(0.0, 0.0, 11.0),
            "events[1].start-hot-spot.strength is 11, but must be between 0.01 and 10",
        ),
        (
            1.0,
            set_motion(id, [0.0, 0.0], 21.0, 0.0),
            "events[1].set-motion.deg_per_my is 21, but must be between -20 and 20 degrees per My",
        ),
        (
            1.0,
            set_motion(PlateChoice::Id(0), [0.0, 0.0], 1.0, 0.0),
            "events[1].set-motion.plate.id is 0, but must be between 1 and 65535",
        ),
        (
            1.0,
            Intervention::Rift {
                line: vec![LatLon::new(0.0, 0.0)],
            },
            "events[1].rift.line is 1 places long, but must be from 2 to 1000 places long",
        ),
        (
            1.0,
            Intervention::Rift {
                line: vec![LatLon::new(10.0, 20.0), LatLon::new(-10.0, -160.0)],
            },
            "events[1].rift.line[1] is [-10, -160], but must be neither the place before it nor the \
             one opposite to that",
        ),
        (
            1.0,
            disc(0.0, 0.0, 0.0, NewCrust::Oceanic { age_my: 1.0 }),
            "events[1].set-crust.radius_km is 0, but must be between 1 and 200000 km",
        ),
        (
            1.0,
            disc(0.0, 0.0, 10.0, NewCrust::Continental { thickness_km: 71.0 }),
            "events[1].set-crust.crust.continental.thickness_km is 71, but must be between 10 and 70 \
             km",
        ),
        (
            1.0,
            Intervention::BreakUp {
                plate: id,
                pieces: 5,
            },
            "events[1].break-up.pieces is 5, but must be between 2 and 4",
        ),
    ] {
        let recipe = Recipe::earth_like(1)
            .with_event(0.0, fine.clone())
            .with_event(at_my, what);
        assert_eq!(recipe.validate().unwrap_err().to_string(), message);
    }
}

#[cfg(feature = "export")]
#[test]
fn events_are_short_in_json() {
    let recipe: Recipe = serde_json::from_str(
        r#"{ "seed": 1, "events": [
            { "at_my": 36, "what": { "set-motion": { "plate": { "at": [10, 40] }, "pole": [90, 0],
              "deg_per_my": -0.6 } } },
            { "at_my": 40, "what": { "rift": { "line": [[30, -20], [0, -10], [-30, -20]] } } },
            { "at_my": 50, "what": { "set-crust": { "centre": [0, 0], "radius_km": 500,
              "crust": { "continental": { "thickness_km": 37 } } } } },
            { "at_my": 60, "what": { "start-hot-spot": { "place": [20, -155] } } },
            { "at_my": 70, "what": { "break-up": { "plate": { "id": 3 } } } }
        ] }"#,
    )
    .unwrap();
    recipe.validate().unwrap();
    assert_eq!(
        recipe.events[0],
        bevy_tectonics::simulation::TectonicEvent::new(
            36.0,
            set_motion(
                PlateChoice::At(LatLon::new(10.0, 40.0)),
                [90.0, 0.0],
                -0.6,
                0.0
            )
        )
    );
    let text = serde_json::to_string(&recipe).unwrap();
    assert_eq!(serde_json::from_str::<Recipe>(&text).unwrap(), recipe);
    let plain = serde_json::to_string(&Recipe::default()).unwrap();
    assert!(!plain.contains("\"events\""), "{plain}");
}

/// What is done to a planet while it grows, with how far it has grown by then.
fn interventions() -> Vec<(f64, Intervention)> {
    vec![
        (0.0, set_motion(PlateChoice::Id(2), [30.0, 10.0], 0.7, 5.0)),
        (
            4.0,
            disc(
                20.0,
                20.0,
                1_200.0,
                NewCrust::Continental { thickness_km: 40.0 },
            ),
        ),
        (
            8.0,
            Intervention::StartHotSpot {
                place: LatLon::new(0.0, -60.0),
                strength: 2.0,
            },
        ),
        (
            8.0,
            set_motion(PlateChoice::Id(60_000), [0.0, 0.0], 1.0, 0.0),
        ),
        (
            11.0,
            Intervention::BreakUp {
                plate: PlateChoice::At(LatLon::new(20.0, 20.0)),
                pieces: 2,
            },
        ),
    ]
}

#[test]
fn a_history_that_was_changed_grows_again_from_its_recipe() {
    let recipe = Recipe::earth_like(6)
        .with_sub_plates(1_000)
        .with_duration(20.0)
        .with_event(
            6.5,
            disc(-40.0, 0.0, 900.0, NewCrust::Oceanic { age_my: 5.0 }),
        );
    let mut history = History::new(recipe).unwrap();
    let mut todo = interventions();
    while history.time_my() < 20.0 {
        while let Some((from, _)) = todo.first()
            && *from <= history.time_my()
        {
            let event = history.apply(todo.remove(0).1).unwrap();
            assert_eq!(event.at_my, history.time_my());
        }
        history.step().unwrap();
    }
    assert_eq!(history.event_log().len(), 6);
    let unknown = &history.event_log()[4].failure;
    assert_eq!(*unknown, Some(EventFailure::NoPlate { id: 60_000 }));
    let recipe = history.recipe().clone();
    assert_eq!(recipe.events.len(), 6);
    let mut again = History::with_threads(recipe, 2).unwrap();
    run_until(&mut again, 20.0);
    assert_eq!(again.steps(), history.steps());
    assert_eq!(again.state_hash(), history.state_hash());
    assert_eq!(again.event_log(), history.event_log());

    let refused = history.apply(set_motion(PlateChoice::Id(1), [0.0, 0.0], f64::NAN, 0.0));
    assert_eq!(
        refused.unwrap_err().to_string(),
        "event.set-motion.deg_per_my is NaN, but must be between -20 and 20 degrees per My"
    );
    assert_eq!(history.recipe().events.len(), 6);
}

#[test]
fn a_run_that_stopped_for_a_change_grows_again_too() {
    let recipe = Recipe::earth_like(6)
        .with_sub_plates(600)
        .with_duration(15.0);
    let mut history = History::new(recipe).unwrap();
    run_until(&mut history, 7.25);
    let event = history.apply(interventions().remove(1).1).unwrap();
    assert_eq!((event.at_my, event.between_steps), (7.25, false));
    run_until(&mut history, 15.0);
    let mut again = History::new(history.recipe().clone()).unwrap();
    run_until(&mut again, 15.0);
    assert_eq!(again.state_hash(), history.state_hash());
}

#[derive(Resource, Debug, Default)]
struct Heard {
    happened: Vec<Option<EventFailure>>,
    refused: Vec<String>,
}

#[test]
fn a_planet_in_a_game_is_changed_and_grows_again_from_its_recipe() {
    for threads in [0, 2] {
        let mut game = Game::new(PlanetPlugin::default().with_threads(threads));
        game.app
            .init_resource::<Heard>()
            .add_observer(|event: On<EventHappened>, mut heard: ResMut<Heard>| {
                heard.happened.push(event.record.failure);
            })
            .add_observer(|event: On<InterventionRefused>, mut heard: ResMut<Heard>| {
                heard.refused.push(event.error.to_string());
            });
        // Long enough that a slow frame does not outlast it.
        let recipe = Recipe::earth_like(3)
            .with_sub_plates(400)
            .with_duration(60.0);
        let entity = game.spawn(Planet::new(recipe).with_pace(Pace::MyPerSecond(60.0)));
        for (from, what) in interventions() {
            game.until(|game| game.growth(entity).progress.time_my >= from);
            game.app.world_mut().trigger(Intervene { entity, what });
        }
        let what = set_motion(PlateChoice::Id(1), [0.0, 0.0], 99.0, 0.0);
        game.app.world_mut().trigger(Intervene { entity, what });
        game.until(|game| game.log.finished == 1);
        assert_eq!(game.log.firsts, 1, "the planet was grown anew");
        let heard = game.app.world().resource::<Heard>();
        let unknown = Some(EventFailure::NoPlate { id: 60_000 });
        assert_eq!(heard.happened.len(), 5);
        assert_eq!(heard.happened.iter().filter(|f| **f == unknown).count(), 1);
        assert_eq!(heard.refused.len(), 1, "{:?}", heard.refused);
        assert!(heard.refused[0].contains("between -20 and 20"));

        let recipe = game.planet(entity).recipe.clone();
        assert_eq!(recipe.events.len(), 5);
        let mut alone = History::new(recipe).unwrap();
        run_until(&mut alone, 60.0);
        let (grown, again) = (game.surface(entity), alone.surface().unwrap());
        assert_eq!(*grown, again, "{threads} threads");
    }
}
