//! Hot spots leave chains of islands whose ages tell how fast the plate went.

#[path = "stages/scenario.rs"]
mod scenario;

use bevy_tectonics::prelude::*;
use bevy_tectonics::simulation::{
    HotSpot, Intervention, LatLon, MaterialArea, Sea, Surface, Thickness, Volcanism,
};
use core::ops::ControlFlow;
use glam::DVec3;
use scenario::*;

const RADIUS: f64 = 6371.0;
/// Speed of the plate at its equator, in km/My.
const SPEED: f64 = 70.0;
/// Where the hot spot lies: on the equator, far from both plate boundaries.
const PLACE: LatLon = LatLon::new(0.0, 90.0);

/// A planet that turns eastwards as one body over one hot spot, all of it sea floor of 40 My under a sea
/// that stands at the reference level.
fn ocean(sub_plates: u32) -> History {
    // As strong as Hawaii's.
    let recipe = recipe(sub_plates).with_event(
        0.0,
        Intervention::StartHotSpot {
            place: PLACE,
            strength: 2.0,
        },
    );
    let mut history = History::with_plugins(recipe, steady()).unwrap();
    arrange(&mut history, [DVec3::Z * (SPEED / RADIUS); 2], |_, _| {
        Ground {
            created_my: -40.0,
            ..SEA_FLOOR
        }
    });
    // 5651 − 2473 exp(−0.0278 · 40) = 4837.6 m.
    history.world_mut().insert_resource(Sea {
        mean_depth: 4837.6,
        level: 0.0,
    });
    history
}

fn run_to(history: &mut History, time_my: f64) -> Surface {
    history
        .run_until(time_my, |_| ControlFlow::Continue(()))
        .unwrap();
    history.surface().unwrap()
}

/// A sub-plate of the chain.
#[derive(Debug, Clone, Copy)]
struct Link {
    /// Way from the hot spot along the track, in km.
    way: f64,
    /// Distance from the track in km.
    aside: f64,
    age: f64,
    elevation: f64,
}

fn chain(surface: &Surface) -> Vec<Link> {
    let mut links: Vec<Link> = (0..surface.elevation.len())
        .filter_map(|v| {
            let site = surface.mesh.site(v as u32);
            let place = LatLon::of(site);
            Some(Link {
                way: (place.lon - PLACE.lon).rem_euclid(360.0).to_radians() * RADIUS,
                aside: place.lat.to_radians().abs() * RADIUS,
                age: surface.volcanism_age[v]?.into(),
                elevation: surface.elevation[v].into(),
            })
        })
        .collect();
    links.sort_by(|a, b| a.way.total_cmp(&b.way));
    links
}

/// Slope of way over age, in km/My, by least squares.
fn speed(links: &[Link]) -> f64 {
    let n = links.len() as f64;
    let mean = |of: fn(&Link) -> f64| links.iter().map(of).sum::<f64>() / n;
    let (way, age) = (mean(|link| link.way), mean(|link| link.age));
    let covariance: f64 = links.iter().map(|l| (l.way - way) * (l.age - age)).sum();
    let variance: f64 = links.iter().map(|l| (l.age - age) * (l.age - age)).sum();
    covariance / variance
}

#[test]
fn ages_along_a_chain_tell_the_plates_speed() {
    for sub_plates in [2_500, 10_000] {
        let mut history = ocean(sub_plates);
        let surface = run_to(&mut history, 50.0);
        assert_eq!(surface.hot_spots.len(), 1);
        let links = chain(&surface);
        let reach = 0.5 * surface.spacing_km().max(240.0);
        // What lies at the hot spot itself is still being fed.
        let crest: Vec<Link> = links
            .iter()
            .copied()
            .filter(|link| (300.0..4000.0).contains(&link.way) && link.aside < reach)
            .collect();
        assert!(crest.len() >= 6, "{sub_plates}: only {} links", crest.len());
        let found = speed(&crest);
        assert!(
            (found / SPEED - 1.0).abs() < 0.1,
            "{sub_plates} sub-plates: {found} km/My instead of {SPEED}"
        );
        // As long as the way in 50 My, and no longer.
        let longest = links
            .iter()
            .map(|link| link.way)
            .filter(|way| *way < 20_000.0);
        let longest = longest.fold(0.0, f64::max);
        assert!(
            (longest / (SPEED * 50.0) - 1.0).abs() < 0.15,
            "{longest} km"
        );
    }
}

#[test]
fn islands_stand_over_the_hot_spot_and_guyots_behind_it() {
    let mut peaks = Vec::new();
    for sub_plates in [10_000, 20_000] {
        let mut history = ocean(sub_plates);
        let surface = run_to(&mut history, 60.0);
        let links = chain(&surface);
        let within = |from: f64, to: f64| {
            let links = links
                .iter()
                .filter(move |link| (from..to).contains(&link.age));
            links.map(|link| link.elevation)
        };
        for l in &links {
            eprintln!("{l:.0?}");
        }
        let islands = within(0.0, 4.0).fold(f64::MIN, f64::max);
        assert!(
            (200.0..3500.0).contains(&islands),
            "{sub_plates}: {islands} m"
        );
        // Every old summit has gone under, the oldest deepest, but all stand high above the floor.
        let drowned = within(25.0, 60.0).fold(f64::MIN, f64::max);
        assert!(drowned < -100.0, "{sub_plates}: a guyot at {drowned} m");
        let tops = |from, to| {
            let mut heights: Vec<f64> = within(from, to).collect();
            heights.sort_by(f64::total_cmp);
            heights[heights.len() * 3 / 4]
        };
        assert!(tops(40.0, 58.0) < tops(10.0, 25.0));
        assert!(tops(40.0, 58.0) > -3800.0, "{}", tops(40.0, 58.0));
        peaks.push(islands);
    }
    // Heights do not depend on the spacing.
    assert!((peaks[0] - peaks[1]).abs() < 900.0, "{peaks:?}");
}

#[test]
fn a_pile_is_part_of_the_crust_and_no_continent() {
    let mut history = ocean(2_500);
    run(&mut history, 30.0);
    let pile: Vec<Volcanism> = column(&mut history);
    let thickness: Vec<Thickness> = column(&mut history);
    let area: Vec<MaterialArea> = column(&mut history);
    let crust: Vec<Crust> = column(&mut history);
    let mut volume = 0.0;
    for v in 0..pile.len() {
        assert!(!crust[v].is_continental());
        let normal = thickness[v].0 - f64::from(pile[v].pile_km);
        assert!((normal - 7.0).abs() < 1e-3, "{normal} km without the pile");
        volume += f64::from(pile[v].pile_km) * area[v].0;
    }
    // No more than what the hot spot could deliver on cells so wide: flux · radius of a cell / 70 km.
    let widened = (0.5 * history.recipe().spacing_km() / 70.0).max(1.0);
    let most = 2.0 * 1.0e5 * 30.0 * widened;
    assert!(
        volume > 0.15 * most && volume < most * 1.05,
        "{volume} km³ of {most} km³"
    );
    assert_eq!(history.ledger().plume_magma_km3, 0.0);
}

#[test]
fn a_continent_gains_what_is_booked() {
    let recipe = recipe(2_500).with_event(
        2.0,
        Intervention::StartHotSpot {
            place: PLACE,
            strength: 2.0,
        },
    );
    let plugins = steady().disable::<bevy_tectonics::simulation::ErodePlugin>();
    let mut history = History::with_plugins(recipe, plugins).unwrap();
    arrange(&mut history, [DVec3::Z * 0.001; 2], |_, _| CONTINENT);
    run(&mut history, 12.0);
    let booked = history.ledger().plume_magma_km3;
    // Twice 1.0e5 km³/My on ground as wide as half a cell of 451 km, a twentieth of it, for 10 My.
    let expected = 2.0 * 1.0e5 * 0.05 * (225.8 / 70.0) * 10.0;
    assert!(
        (booked / expected - 1.0).abs() < 0.15,
        "{booked} km³ instead of {expected} km³"
    );
    let world = history.world_mut();
    let mut hot_spots = world.query::<&HotSpot>();
    assert_eq!(hot_spots.single(world).unwrap().since_my, 2.0);
}

#[test]
fn recipes_scatter_hot_spots_by_their_seed() {
    let places = |seed: u64, hot_spots: u32| {
        let recipe = Recipe {
            hot_spots,
            ..Recipe::earth_like(seed).with_sub_plates(400)
        };
        History::new(recipe).unwrap().surface().unwrap().hot_spots
    };
    assert_eq!(places(1, 20), places(1, 20));
    assert_ne!(places(1, 20), places(2, 20));
    assert_eq!(
        places(1, 20)[..5],
        places(1, 5)[..],
        "more leave the first ones alone"
    );
    for hot_spot in places(3, 200) {
        assert!((hot_spot.place.length() - 1.0).abs() < 1e-12);
        assert!((0.5e5..=1.5e5).contains(&hot_spot.flux));
    }
    let mut many = Recipe::earth_like(1);
    many.hot_spots = 201;
    let error = many.validate().unwrap_err().to_string();
    assert_eq!(error, "hot_spots is 201, but must be between 0 and 200");
}
