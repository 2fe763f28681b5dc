//! Each measure on a small world whose value can be worked out by hand, and all of them on a planet
//! that has grown.

use super::*;
use crate::simulation::{History, fixtures::even_mesh};
use core::ops::ControlFlow;
use glam::DVec3;

const RADIUS_KM: f64 = 6371.0;
/// rad/My; at 90° from its pole a plate moves at 63.71 km/My.
const TURN: f64 = 0.01;

#[derive(Clone, Copy)]
struct Cell {
    plate: u16,
    continental: bool,
    elevation: f64,
    age: f64,
}

const FLOOR: Cell = Cell {
    plate: 1,
    continental: false,
    elevation: -4000.0,
    age: 50.0,
};

/// The share of the sphere north of a place: cells with the least shares lie at the north pole.
fn north(site: DVec3) -> f64 {
    0.5 * (1.0 - site.z)
}

/// Which of bands of latitude, from the north pole on with these shares, holds a place.
fn band(site: DVec3, shares: &[f64]) -> usize {
    let mut end = 0.0;
    let inside = |share: &f64| {
        end += share;
        north(site) < end
    };
    shares.iter().position(inside).unwrap_or(shares.len() - 1)
}

/// A world of so many even cells at 100 My; plate n turns by the rotation n − 1.
fn world(cells: u32, rotations: &[DVec3], cell: impl Fn(DVec3) -> Cell) -> World {
    let recipe = Recipe::default().with_sub_plates(cells);
    let mesh = even_mesh::<EdgeState>(cells);
    let mut world = World::new();
    let rows: Vec<_> = mesh
        .sites()
        .iter()
        .map(|&site| {
            let Cell {
                plate,
                continental,
                elevation,
                age,
            } = cell(site);
            let rotation = rotations[usize::from(plate) - 1];
            let crust = if continental {
                Crust::Continental
            } else {
                Crust::Oceanic
            };
            (
                SubPlate,
                PlateId(plate),
                crust,
                Elevation(elevation as f32),
                Created((100.0 - age) as f32),
                Velocity((rotation.cross(site) * RADIUS_KM).as_vec3()),
                Thickness(if continental { 35.0 } else { 7.0 }),
                MaterialArea(recipe.cell_area_km2()),
            )
        })
        .collect();
    world.spawn_batch(rows);
    for (id, &rotation) in (1..).zip(rotations) {
        world.spawn((
            Plate { id: PlateId(id) },
            Rotation(rotation),
            PlateBorn(0.0),
        ));
    }
    world.insert_resource(Topology(mesh));
    world.insert_resource(recipe);
    world.insert_resource(Sea::default());
    world.insert_resource(Ledger::default());
    world.insert_resource(Clock {
        time_my: 100.0,
        ..default()
    });
    world
}

fn measured(cells: u32, rotations: &[DVec3], cell: impl Fn(DVec3) -> Cell) -> Statistics {
    Statistics::measure(&mut world(cells, rotations, cell)).unwrap()
}

#[track_caller]
fn near(found: f64, expected: f64, allowed: f64) {
    assert!(
        (found - expected).abs() <= allowed,
        "{found} instead of {expected} ± {allowed}"
    );
}

fn hemispheres(rotation: DVec3, continental: bool) -> Statistics {
    measured(10_000, &[rotation, DVec3::ZERO], |site| Cell {
        plate: if site.z > 0.0 { 1 } else { 2 },
        continental,
        elevation: if site.y > 0.0 { -2500.0 } else { -5000.0 },
        ..FLOOR
    })
}

#[test]
fn hemispheres_that_turn_apart_and_together() {
    // The north turns about x: at longitude φ the equator opens at ωR sin φ.
    let now = hemispheres(DVec3::X * TURN, false);
    // Half of 2πR = 40,030 km each.
    near(now.boundary_km, 40_030.0, 800.0);
    near(now.opening_km, 20_015.0, 600.0);
    near(now.closing_km, 20_015.0, 600.0);
    near(now.boundary_shares[1], 0.0, 0.02);
    // Mean of ωR sin φ over a half turn: 2/π · 63.71.
    near(now.slip_ridges, 40.56, 0.8);
    near(now.slip_trenches, 40.56, 0.8);
    // ∫ ωR sin φ R dφ = 2ωR² = 811,800 km²/My.
    near(now.spreading_km2_yr, 0.8118, 0.02);
    near(now.subduction_km2_yr, 0.8118, 0.02);
    near(now.ridge_median_m, -2500.0, 0.0);
    assert_eq!(now.slip_collisions, 0.0);

    // Half of the rotation is common to all, so both turn at ω/2: speed ωR/2 √(1 − x²), where |x| is
    // evenly distributed. Mean π/4, mean square 2/3, quantile q at x = 1 − q.
    near(now.speed_mean, 25.02, 0.1);
    near(now.speed_rms, 26.01, 0.1);
    near(now.speed_p10, 13.88, 0.2);
    near(now.speed_median, 27.59, 0.1);
    near(now.speed_p90, 31.70, 0.1);
    near(now.speed_oceanic_plates, 25.02, 0.1);
    assert_eq!(now.speed_continental_plates, 0.0);
}

#[test]
fn hemispheres_that_slide_and_continents_that_collide() {
    let sliding = hemispheres(DVec3::Z * TURN, false);
    near(sliding.sliding_km, 40_030.0, 800.0);
    near(sliding.slip_transforms, 63.71, 0.3);
    assert_eq!(sliding.spreading_km2_yr, 0.0);
    let colliding = hemispheres(DVec3::X * TURN, true);
    near(colliding.slip_collisions, 40.56, 0.8);
    near(colliding.closing_km, 20_015.0, 600.0);
    // Continents that part are no ridge yet, those that meet no trench.
    assert_eq!((colliding.slip_ridges, colliding.slip_trenches), (0.0, 0.0));
    assert_eq!(
        (colliding.spreading_km2_yr, colliding.subduction_km2_yr),
        (0.0, 0.0)
    );
}

#[test]
fn continental_plates_are_told_from_oceanic_ones() {
    // A continental cap z > 1/2 turns about z. Its moment of ω is ½∫(1 − z²) = 0.10417, the sphere's
    // 2/3, so 0.15625 ω is common. Mean ring √(1 − z²): 0.61418 in the cap, 0.84247 outside.
    let now = measured(10_000, &[DVec3::Z * TURN, DVec3::ZERO], |site| Cell {
        plate: if site.z > 0.5 { 1 } else { 2 },
        continental: site.z > 0.5,
        ..FLOOR
    });
    near(now.speed_continental_plates, 33.02, 0.3);
    near(now.speed_oceanic_plates, 8.39, 0.1);
}

#[test]
fn places_that_leave_their_plate_deform() {
    let mut world = world(10_000, &[DVec3::X * TURN, DVec3::Y * TURN], |site| Cell {
        plate: if site.z > 0.0 { 1 } else { 2 },
        ..FLOOR
    });
    let deforming = |world: &mut World| Statistics::measure(world).unwrap().deforming_share;
    assert_eq!(deforming(&mut world), 0.0);
    // A tenth by 2 mm/yr, another by half of one: only the first counts.
    let mut rows = world.query_filtered::<&mut Velocity, With<SubPlate>>();
    for (i, mut velocity) in rows.iter_mut(&mut world).enumerate() {
        velocity.0.x += [2.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0][i % 10];
    }
    near(deforming(&mut world), 0.1, 1e-3);
}

#[test]
fn plates_of_known_size() {
    const SHARES: [f64; 5] = [0.4, 0.3, 0.2, 0.0997, 0.0003];
    let plates = |shares: &'static [f64]| {
        measured(10_000, &[DVec3::ZERO; 8], move |site| Cell {
            plate: band(site, shares) as u16 + 1,
            ..FLOOR
        })
    };
    let now = plates(&SHARES);
    // The smallest has 3 of 10,000 cells: less than 0.05 %.
    assert_eq!((now.plates, now.large_plates), (5, 4));
    near(now.largest_plate, 0.4, 0.002);
    near(now.largest_7_plates, 1.0, 1e-9);
    near(now.largest_14_plates, 1.0, 1e-9);
    // A fifth of 510.06 million km².
    near(now.plate_area_median_km2, 102.0e6, 1.0e6);

    // Areas that fall as the cube of the rank: the number above A falls as its third root.
    const CUBES: [f64; 8] = [
        0.836_70, 0.104_59, 0.030_99, 0.013_07, 0.006_69, 0.003_87, 0.002_44, 0.001_63,
    ];
    near(plates(&CUBES).plate_size_exponent, -1.0 / 3.0, 0.02);
    assert_eq!(plates(&[0.5, 0.5]).plate_size_exponent, 0.0);
}

#[test]
fn ages_of_a_known_law() {
    let ages = |age: fn(f64) -> f64| {
        measured(10_000, &[DVec3::ZERO], |site| {
            let age = age(north(site));
            Cell {
                age,
                elevation: -(2700.0 + 350.0 * age.sqrt()),
                ..FLOOR
            }
        })
    };
    // The triangular law itself: F(t) = 1 − (1 − t/180)², mean 180/3, F⁻¹(0.995) = 167.27.
    let now = ages(|u| 180.0 * (1.0 - (1.0 - u).sqrt()));
    near(now.ocean_age_distance, 0.0, 0.002);
    near(now.ocean_age_mean_my, 60.0, 0.1);
    near(now.ocean_age_995_my, 167.3, 0.5);
    near(now.ocean_age_oldest_my, 178.7, 0.5);
    // 100 m deeper than the law, with its slope.
    near(now.age_depth_bias_m, 100.0, 0.01);
    near(now.age_depth_error_m, 100.0, 0.01);
    near(now.age_depth_slope, 350.0, 0.01);
    // Even ages: u − (1 − (1 − u)²) is −1/4 at the middle.
    let even = ages(|u| 180.0 * u);
    near(even.ocean_age_distance, 0.25, 0.002);
    near(even.ocean_age_mean_my, 90.0, 0.1);
    for (i, share) in even.ocean_age_histogram_10_my.iter().enumerate() {
        near(*share, if i < 18 { 1.0 / 18.0 } else { 0.0 }, 0.002);
    }
    // Nothing beyond the last bin is lost.
    let old = ages(|_| 1000.0);
    near(old.ocean_age_histogram_10_my[29], 1.0, 1e-9);
    // Nothing young enough for the law.
    assert_eq!((old.age_depth_slope, old.age_depth_error_m), (0.0, 0.0));
}

#[test]
fn heights_of_known_shares() {
    const SHARES: [f64; 6] = [0.2, 0.1, 0.05, 0.05, 0.5, 0.1];
    const HEIGHTS: [f64; 6] = [250.0, 2500.0, -100.0, -400.0, -4750.0, -6500.0];
    let mut world = world(10_000, &[DVec3::ZERO], |site| {
        let band = band(site, &SHARES);
        Cell {
            continental: band < 4,
            elevation: HEIGHTS[band],
            ..FLOOR
        }
    });
    // 0.4 of 510.06 million km² 35 km thick, of which the books know four fifths.
    world.resource_mut::<Ledger>().initial_km3 = 0.8 * 0.4 * 510.0645e6 * 35.0;
    let now = Statistics::measure(&mut world).unwrap();
    near(now.land_share, 0.3, 0.001);
    near(now.continental_share, 0.4, 0.001);
    // (0.2 · 250 + 0.1 · 2500)/0.3, and −(5 + 20 + 2375 + 650)/0.7.
    near(now.mean_land_m, 1000.0, 3.0);
    near(now.mean_ocean_m, -4357.0, 3.0);
    assert_eq!((now.highest_m, now.lowest_m), (2500.0, -6500.0));
    near(now.shelf_200_share, 0.05, 0.001);
    near(now.shelf_500_share, 0.1, 0.001);
    near(now.above_2_km_share, 0.1, 0.001);
    near(now.below_6_km_share, 0.1, 0.001);
    assert_eq!((now.land_peak_m, now.ocean_peak_m), (250.0, -4750.0));
    near(now.land_peak_share, 0.2, 0.001);
    near(now.ocean_peak_share, 0.5, 0.001);
    near(now.hypsometry_500_m[22], 0.2, 0.001);
    near(now.hypsometry_500_m.iter().sum(), 1.0, 1e-9);
    near(now.continental_thickness_km, 35.0, 1e-9);
    near(now.oceanic_thickness_km, 7.0, 1e-9);
    // The cap z > 1/5: the mean of z is (1 + 1/5)/2.
    near(now.continental_concentration, 0.6, 0.002);
    near(now.ledger_gap, 0.25, 0.002);
    near(Statistics::EARTH_HYPSOMETRY_500_M.iter().sum(), 1.0, 1e-9);
}

#[test]
fn a_round_coast_is_a_line_and_scattered_land_fills_the_plane() {
    for cells in [2_500, 10_000] {
        let coast = |dry: &dyn Fn(DVec3) -> f64| {
            let cell = |site| Cell {
                elevation: 1000.0 * dry(site),
                ..FLOOR
            };
            measured(cells, &[DVec3::ZERO], cell).coastline_dimension
        };
        let axis = DVec3::new(2.0, -1.0, 2.0) / 3.0;
        near(coast(&|site| site.dot(axis) - 0.4), 1.0, 0.06);
        let scattered = |site: DVec3| (site * 1e4).element_sum().rem_euclid(2.0) - 1.0;
        assert!(coast(&scattered) > 1.6);
        assert_eq!(coast(&|_| -1.0), 0.0);
    }
}

#[test]
fn ground_of_a_known_spectrum() {
    // Legendre functions about scattered axes: the mean square of one of degree l is 1/(2l + 1), so
    // that these have a power of 10⁶ l⁻² m² each.
    let height = |site: DVec3| {
        let mut sum = 0.0;
        for degree in 1..=40 {
            let angle = f64::from(degree);
            let axis = DVec3::new(libm::cos(angle), libm::sin(angle), libm::sin(2.3 * angle));
            let t = site.dot(axis.normalize());
            let (mut before, mut legendre) = (1.0, t);
            for l in 1..degree {
                let l = f64::from(l);
                let next = ((2.0 * l + 1.0) * t * legendre - l * before) / (l + 1.0);
                (before, legendre) = (legendre, next);
            }
            sum += 1000.0 * (2.0 * angle + 1.0).sqrt() / angle * legendre;
        }
        sum
    };
    for cells in [2_500, 10_000] {
        let cell = |site| Cell {
            elevation: height(site) - 3000.0,
            ..FLOOR
        };
        near(
            measured(cells, &[DVec3::ZERO], cell).power_slope,
            -2.0,
            0.05,
        );
    }
    assert_eq!(measured(2_500, &[DVec3::ZERO], |_| FLOOR).power_slope, 0.0);
}

#[test]
fn turnover_is_taken_since_the_moment_before() {
    let mut world = world(1_000, &[DVec3::ZERO], |_| FLOOR);
    let books = |made: f64, consumed: f64, shortened: f64| Ledger {
        area_created_km2: made,
        area_consumed_km2: consumed,
        area_shortened_km2: shortened,
        ..default()
    };
    world.insert_resource(books(300e6, 250e6, 10e6));
    // Nothing was recorded: since the start, 100 My ago.
    let first = record(&mut world).unwrap();
    assert_eq!(first.interval_my, 100.0);
    near(first.floor_made_km2_yr, 3.0, 1e-9);
    near(first.floor_consumed_km2_yr, 2.4, 1e-9);
    // 34 million km² made in 10 My, and 36 consumed besides 4 of continent.
    world.resource_mut::<Clock>().time_my = 110.0;
    world.insert_resource(books(334e6, 290e6, 14e6));
    for _ in 0..2 {
        let now = record(&mut world).unwrap();
        assert_eq!(now.interval_my, 10.0);
        near(now.floor_made_km2_yr, 3.4, 1e-9);
        near(now.floor_consumed_km2_yr, 3.6, 1e-9);
        assert_eq!(world.resource::<Statistics>(), &now);
    }
    let moments = world.resource::<StatisticsHistory>().moments();
    assert_eq!(moments.len(), 2);
    assert!(
        moments
            .iter()
            .all(|moment| moment.hypsometry_500_m.is_empty())
    );
}

#[test]
fn continents_gather_and_break_up() {
    let mut history = StatisticsHistory::default();
    for (i, concentration) in [
        0.6, 0.3, 0.19, 0.1, 0.3, 0.49, 0.51, 0.45, 0.55, 0.21, 0.1, 0.6,
    ]
    .into_iter()
    .enumerate()
    {
        history.push(&Statistics {
            time_my: 10.0 * i as f64,
            continental_concentration: concentration,
            ..default()
        });
    }
    use Gathering::{BrokenUp, Gathered};
    assert_eq!(
        history.gatherings(),
        [
            BrokenUp(20.0),
            Gathered(60.0),
            BrokenUp(100.0),
            Gathered(110.0)
        ]
    );
    assert_eq!(history.before(60.0).unwrap().time_my, 50.0);
    assert!(history.before(0.0).is_none());
    assert_eq!(
        history.series(|moment| moment.time_my).last(),
        Some((110.0, 110.0))
    );
    // Measured again from the middle on.
    history.push(&Statistics {
        time_my: 45.0,
        ..default()
    });
    assert_eq!(history.moments().len(), 6);
}

#[test]
fn a_grown_planet_has_sane_figures_and_is_the_same_unmeasured() {
    let grow = |interval_my: f64| {
        let recipe = Recipe::earth_like(3).with_sub_plates(2_500);
        let plugins = crate::simulation::SimulationPlugins
            .build()
            .set(StatisticsPlugin { interval_my });
        let mut history = History::with_plugins(recipe, plugins).unwrap();
        let outcome = history.run_until(60.0, |_| ControlFlow::Continue(()));
        outcome.unwrap();
        history
    };
    let mut plain = grow(f64::INFINITY);
    let mut measured = grow(20.0);
    assert_eq!(plain.state_hash(), measured.state_hash());
    assert!(plain.statistics_history().moments().is_empty());
    let history = measured.statistics_history();
    let times: Vec<f64> = history
        .series(|moment| moment.time_my)
        .map(|m| m.0)
        .collect();
    assert_eq!((times.len(), times[0], times[3]), (4, 0.0, 60.0));
    assert!((20.0..22.0).contains(&times[1]) && (40.0..42.0).contains(&times[2]));

    let now = measured.statistics().unwrap();
    assert_eq!(&now, measured.world().resource::<Statistics>());
    near(now.interval_my, 60.0 - times[2], 1e-9);
    for (measure, value) in Statistics::MEASURES.iter().zip(now.figures()) {
        assert!(value.is_finite(), "{} is {value}", measure.name);
    }
    let within = |name: &str, low: f64, high: f64| {
        let measure = Statistics::MEASURES.iter().find(|m| m.name == name);
        let value = (measure.unwrap().value)(&now);
        assert!((low..=high).contains(&value), "{name} is {value}");
    };
    for (name, low, high) in [
        ("land_share", 0.1, 0.6),
        ("land_peak_m", -2000.0, 3000.0),
        ("ocean_peak_m", -6000.0, -2000.0),
        ("shelf_500_share", 0.001, 0.4),
        ("coastline_dimension", 0.9, 1.6),
        ("power_slope", -4.0, 0.0),
        ("oceanic_thickness_km", 4.0, 12.0),
        ("continental_thickness_km", 20.0, 50.0),
        ("continental_concentration", 0.0, 1.0),
        ("ledger_gap", -1e-6, 1e-6),
        ("ridge_median_m", -4500.0, -1000.0),
        ("age_depth_error_m", 0.0, 1500.0),
        ("age_depth_slope", 100.0, 600.0),
        ("ocean_age_995_my", 20.0, 500.0),
        ("ocean_age_distance", 0.0, 0.7),
        ("floor_made_km2_yr", 0.5, 15.0),
        ("floor_consumed_km2_yr", 0.5, 15.0),
        ("spreading_km2_yr", 0.5, 15.0),
        ("subduction_km2_yr", 0.5, 15.0),
        ("largest_plate", 0.02, 0.7),
        ("largest_14_plates", 0.5, 1.0),
        ("plate_size_exponent", -3.0, 0.0),
        ("speed_rms", 5.0, 150.0),
        ("deforming_share", 0.0, 0.4),
        ("boundary_km", 5e4, 6e5),
        ("slip_ridges", 5.0, 200.0),
        ("slip_trenches", 5.0, 200.0),
    ] {
        within(name, low, high);
    }
    near(now.boundary_shares.iter().sum(), 1.0, 1e-9);
    near(now.ocean_age_histogram_10_my.iter().sum(), 1.0, 1e-9);
    assert!(now.speed_p10 <= now.speed_median && now.speed_median <= now.speed_p90);
}
