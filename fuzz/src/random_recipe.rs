//! Recipes that are valid and that nobody would write, grown for a while.

use bevy_tectonics::prelude::*;
use bevy_tectonics::simulation::laws::{CollisionLaw, ErosionLaw, SeaFloorLaw, UpliftLaw};
use bevy_tectonics::simulation::{Drive, Hypsometry, NewCrust, Normals, PlateChoice, Start};

/// Steps of a history.
const STEPS: usize = 200;

/// Bytes as choices. Where they end, everything is zero.
struct Choices<'a>(&'a [u8]);

impl Choices<'_> {
    fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else {
            return 0;
        };
        self.0 = rest;
        first
    }

    fn share(&mut self) -> f64 {
        let number = u16::from_le_bytes([self.byte(), self.byte()]);
        f64::from(number) / f64::from(u16::MAX)
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        (low + (high - low) * self.share()).clamp(low, high)
    }

    fn one_of<T: Clone>(&mut self, choices: &[T]) -> T {
        choices[usize::from(self.byte()) % choices.len()].clone()
    }
}

fn recipe(choices: &mut Choices) -> Recipe {
    let seed = u64::from_le_bytes(std::array::from_fn(|_| choices.byte()));
    let mut recipe = Recipe::earth_like(seed);
    recipe.sub_plates = 200 + u32::from(choices.byte()) * u32::from(choices.byte()) / 64;
    recipe.duration_my = 10_000.0;
    recipe.plates = 2 + u32::from(choices.byte()) % (recipe.most_plates().saturating_sub(1)).max(1);
    recipe.continental_share = choices.within(0.0, 0.9);
    recipe.land_share = choices.within(0.0, 0.9);
    recipe.hot_spots = u32::from(choices.byte()) % 201;
    recipe.radius_km = match choices.byte() {
        0..200 => recipe.radius_km,
        _ => choices.within(500.0, 50_000.0),
    };
    recipe.start = match choices.byte() % 8 {
        0..3 => Start::FloodFill,
        3..6 => Start::Voronoi,
        6 => Start::Hypsometric(Hypsometry::Normals(Normals {
            ocean_share: choices.within(0.1, 1.0),
            ..Normals::default()
        })),
        _ => {
            let low = choices.within(-12_000.0, 12_000.0);
            let high = choices.within(low, 12_000.0);
            Start::Hypsometric(Hypsometry::Curve(vec![(0.0, low), (1.0, high)]))
        }
    };
    recipe.drive = choices.one_of(&[
        Drive::Soft,
        Drive::Soft,
        Drive::Rigid,
        Drive::Foundering,
        Drive::Prescribed,
    ]);
    if choices.byte() > 127 {
        recipe.laws.sea_floor = choices.one_of(&[
            SeaFloorLaw::Gdh1,
            SeaFloorLaw::ParsonsSclater,
            SeaFloorLaw::Cortial,
            SeaFloorLaw::Yggdrasill,
        ]);
        recipe.laws.uplift = choices.one_of(&[UpliftLaw::Magma, UpliftLaw::Cortial]);
        recipe.laws.collision = choices.one_of(&[CollisionLaw::Crush, CollisionLaw::Cortial]);
        recipe.laws.erosion =
            choices.one_of(&[ErosionLaw::BaseLevel, ErosionLaw::Cortial, ErosionLaw::Rain]);
    }
    // None, some or most of the constants are odd; a part of those lies at the ends of its range.
    let odd = choices.one_of(&[0_u8, 0, 8, 40, 200]);
    for group in recipe.constants.groups_mut() {
        for (row, info) in group.info().iter().enumerate() {
            if choices.byte() < odd
                && let Some(value) = group.value_mut(row)
            {
                *value = match choices.byte() {
                    0..40 => info.lowest,
                    40..80 => info.highest,
                    _ => choices.within(info.lowest, info.highest),
                };
            }
        }
    }
    for _ in 0..choices.byte() % 8 {
        let at_my = choices.within(0.0, 60.0);
        let what = event(choices);
        recipe = recipe.with_event(at_my, what);
    }
    recipe
}

fn place(choices: &mut Choices) -> LatLon {
    LatLon {
        lat: choices.within(-90.0, 90.0),
        lon: choices.within(-180.0, 180.0),
    }
}

fn plate(choices: &mut Choices) -> PlateChoice {
    match choices.byte() {
        0..60 => PlateChoice::Id(choices.byte().into()),
        _ => PlateChoice::At(place(choices)),
    }
}

fn event(choices: &mut Choices) -> Intervention {
    match choices.byte() % 6 {
        0 => Intervention::SetMotion {
            plate: plate(choices),
            pole: place(choices),
            deg_per_my: choices.within(-5.0, 5.0),
            hold_my: choices.within(0.0, 60.0),
        },
        1 => Intervention::Rift {
            line: (0..2 + choices.byte() % 4)
                .map(|_| place(choices))
                .collect(),
        },
        2 => Intervention::SetCrust {
            centre: place(choices),
            radius_km: choices.within(1.0, 6_000.0),
            crust: match choices.byte() % 2 {
                0 => NewCrust::Oceanic {
                    age_my: choices.within(0.0, 1_000.0),
                },
                _ => NewCrust::Continental {
                    thickness_km: choices.within(10.0, 70.0),
                },
            },
        },
        3 => Intervention::StartHotSpot {
            place: place(choices),
            strength: choices.within(0.01, 10.0),
        },
        4 => Intervention::StopHotSpot {
            place: place(choices),
        },
        _ => Intervention::BreakUp {
            plate: plate(choices),
            pieces: 2 + choices.byte() % 3,
        },
    }
}

/// Any valid recipe grows for 200 steps, or says why not.
pub fn recipe_run(data: &[u8]) {
    let recipe = recipe(&mut Choices(data));
    let told = || format!("{recipe:#}");
    let mut history = match History::new(recipe.clone()) {
        Ok(history) => history,
        Err(error) => return super::read(&error),
    };
    for step in 0..STEPS {
        match history.step() {
            Ok(()) => assert_eq!(history.check(), Ok(()), "step {step} of {}", told()),
            Err(error) => return super::read(&error),
        }
    }
    match history.statistics() {
        Ok(figures) => assert!(figures.speed_mean.is_finite(), "{}", told()),
        Err(error) => super::read(&error),
    }
}
