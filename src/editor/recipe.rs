//! What a planet grows from: a draft that is edited, and applied when it is finished.

use super::figures::whole;
use super::{constants, look, time::sentence};
use crate::planet::{Planet, Regrowth};
use crate::simulation::laws::{CollisionLaw, ErosionLaw, Laws, SeaFloorLaw, UpliftLaw};
use crate::simulation::{Drive, Hypsometry, ImageStart, Recipe, Start};
use bevy_egui::egui::{TextEdit, Ui};
use core::hash::{BuildHasher, Hasher};

/// Seeds that the dice throws lie below this: short enough to be remembered.
const SEEDS: u64 = 1_000_000;

/// A recipe that is being edited.
#[derive(Debug, Clone, Default)]
pub(super) struct Draft {
    /// What is edited.
    pub recipe: Recipe,
    /// The planet's recipe when it was last looked at.
    base: Recipe,
    /// The seed as it is typed; numbers beyond 2⁵³ would lose digits in a number field.
    seed: String,
    /// What the recipe lacks to be grown.
    problem: Option<String>,
}

impl Draft {
    pub(super) fn new(recipe: &Recipe) -> Self {
        let mut draft = Self {
            recipe: recipe.clone(),
            base: recipe.clone(),
            ..Self::default()
        };
        draft.check();
        draft
    }

    /// Follows a recipe that was changed elsewhere, unless something was edited.
    pub(super) fn follow(&mut self, recipe: &Recipe) {
        if self.base != *recipe {
            let edited = self.is_edited();
            self.base = recipe.clone();
            if !edited {
                self.revert();
            }
        }
    }

    /// Whether the draft differs from the planet's recipe.
    pub(super) fn is_edited(&self) -> bool {
        self.recipe != self.base
    }

    /// Whether there is something to apply that can be grown.
    pub(super) fn is_ready(&self) -> bool {
        self.is_edited() && self.problem.is_none()
    }

    /// Why it cannot be grown.
    pub(super) fn problem(&self) -> Option<&str> {
        self.problem.as_deref()
    }

    /// To be called after every edit.
    pub(super) fn check(&mut self) {
        if self.seed.parse() != Ok(self.recipe.seed) {
            self.seed = self.recipe.seed.to_string();
        }
        let verdict = self.recipe.validate();
        self.problem = verdict.err().map(|error| sentence(&error.to_string()));
    }

    /// Back to the planet's recipe.
    pub(super) fn revert(&mut self) {
        self.recipe = self.base.clone();
        self.check();
    }

    /// Gives the planet the draft, if it is ready. True if it was.
    pub(super) fn apply(&mut self, planet: &mut Planet) -> bool {
        let ready = self.is_ready();
        if ready {
            planet.recipe = self.recipe.clone();
            // An end of another history may lie anywhere in this one.
            planet.until_my = None;
            self.base = self.recipe.clone();
        }
        ready
    }

    /// Takes the seed as it was typed. True if it is a number.
    fn read_seed(&mut self) -> bool {
        let seed = self.seed.trim().parse();
        if let Ok(seed) = seed {
            self.recipe.seed = seed;
        }
        seed.is_ok()
    }
}

/// A seed that nobody can foresee.
fn throw_dice() -> u64 {
    // Each state is keyed anew by the system's own source of chance.
    let state = std::hash::RandomState::new();
    state.build_hasher().finish() % SEEDS
}

/// Draws the section. True if the planet was changed.
pub(super) fn show(ui: &mut Ui, planet: &mut Planet, draft: &mut Draft) -> bool {
    draft.follow(&planet.recipe);
    let mut edited = seed(ui, draft);
    edited |= form(ui, &mut draft.recipe);
    edited |= constants::show(ui, &mut draft.recipe.constants);
    if edited {
        draft.check();
    }
    let mut changed = look::row(
        ui,
        "Meanwhile",
        "What is seen while another recipe grows.",
        |ui| {
            look::choose(
                ui,
                &mut planet.regrowth,
                &[
                    (
                        Regrowth::Hidden,
                        "Old planet",
                        "The old surface, until the new history is finished.",
                    ),
                    (
                        Regrowth::Shown,
                        "New planet",
                        "The new surface, from its first moment.",
                    ),
                ],
            )
        },
    );
    if let Some(problem) = draft.problem() {
        look::complaint(ui, problem);
    }
    ui.add_space(2.0);
    let width = 0.5 * (ui.available_width() - ui.spacing().item_spacing.x);
    ui.horizontal(|ui| {
        if look::main_button(ui, draft.is_ready(), width, "⟲  Regenerate")
            .on_hover_text("Grows another planet from this recipe.")
            .on_disabled_hover_text(if draft.is_edited() {
                "This recipe cannot be grown."
            } else {
                "The planet grows from this recipe already."
            })
            .clicked()
        {
            changed |= draft.apply(planet);
        }
        if look::button(ui, draft.is_edited(), width, "Revert")
            .on_hover_text("Back to the planet's recipe.")
            .clicked()
        {
            draft.revert();
        }
    });
    changed
}

fn seed(ui: &mut Ui, draft: &mut Draft) -> bool {
    let hint = "Seed of every random stream. The same recipe grows the same planet, bit for bit.";
    look::row(ui, "Seed", hint, |ui| {
        let width = ui.available_width() - look::DICE - ui.spacing().item_spacing.x;
        let edit = TextEdit::singleline(&mut draft.seed).desired_width(width);
        let response = ui.add(edit);
        let mut edited = response.changed() && draft.read_seed();
        if response.lost_focus() {
            // What is no number is taken back.
            edited = true;
        }
        if look::dice(ui, "Another seed").clicked() {
            draft.recipe.seed = throw_dice();
            edited = true;
        }
        edited
    })
}

fn form(ui: &mut Ui, recipe: &mut Recipe) -> bool {
    let mut edited = false;
    let hint = format!(
        "Number of sub-plates: the resolution. Here they are {} km apart. Twice as many take more \
         than twice the time.",
        whole(recipe.spacing_km())
    );
    edited |= look::row(ui, "Sub-plates", &hint, |ui| {
        let range = Recipe::SUB_PLATES;
        look::slider(ui, &mut recipe.sub_plates, range, |s| {
            s.logarithmic(true)
                .custom_formatter(|n, _| whole(n))
                .custom_parser(parse_whole)
        })
    });
    edited |= look::row(ui, "Duration", "Length of the history.", |ui| {
        let range = Recipe::DURATION_MY;
        look::slider(ui, &mut recipe.duration_my, range, |s| {
            s.logarithmic(true)
                .smallest_positive(10.0)
                .max_decimals(0)
                .suffix(" My")
        })
    });
    edited |= look::row(ui, "Radius", "Earth's is 6,371 km.", |ui| {
        look::slider(ui, &mut recipe.radius_km, Recipe::RADIUS_KM, |s| {
            s.logarithmic(true)
                .max_decimals(0)
                .custom_formatter(|n, _| whole(n))
                .custom_parser(parse_whole)
                .suffix(" km")
        })
    });
    edited |= look::row(ui, "Start", "Layout of the first moment.", |ui| {
        start(ui, &mut recipe.start)
    });
    if let Start::Image(image) = &mut recipe.start {
        let hint = "Path of the PNG. Black is −32,768 m and white 32,767 m, as in elevation.png, unless \
                    the recipe says otherwise.";
        edited |= look::row(ui, "Height map", hint, |ui| {
            let edit = TextEdit::singleline(&mut image.heights).desired_width(ui.available_width());
            ui.add(edit).changed()
        });
    }
    let most = recipe.most_plates().min(*Recipe::PLATES.end());
    let hint = "Number of plates at the start: at most one for every 20 sub-plates.";
    edited |= look::row(ui, "Plates", hint, |ui| {
        let range = *Recipe::PLATES.start()..=most;
        look::slider(ui, &mut recipe.plates, range, |s| s)
    });
    if recipe.start.reads_shares() {
        let hint = "Share of the sphere that is continental crust at the start. Earth's is 41 %.";
        edited |= look::row(ui, "Continents", hint, |ui| {
            look::share(ui, &mut recipe.continental_share, Recipe::SHARES)
        });
        let hint = "Share of the sphere that is dry at the start; it fixes the volume of the sea. Earth's \
                    is 29 %.";
        edited |= look::row(ui, "Land", hint, |ui| {
            look::share(ui, &mut recipe.land_share, Recipe::SHARES)
        });
    }
    let hint = "Number of hot spots under the plates. Earth has some 20 to 50.";
    edited |= look::row(ui, "Hot spots", hint, |ui| {
        look::slider(ui, &mut recipe.hot_spots, Recipe::HOT_SPOTS, |s| s)
    });
    edited |= laws(ui, &mut recipe.laws);
    edited |= look::row(ui, "Drive", "What turns the plates.", |ui| {
        let soft = "Torque balance of the forces at the boundaries, with soft margins.";
        let rigid = "The same balance on exactly rigid plates.";
        let foundering =
            "Old sea floor founders and drags the mantle; plates are what moves alike.";
        let prescribed = "Plates keep their rotations; slabs turn their axes.";
        let drives = [
            (Drive::Soft, "Soft", soft),
            (Drive::Rigid, "Rigid", rigid),
            (Drive::Foundering, "Foundering", foundering),
            (Drive::Prescribed, "Prescribed", prescribed),
        ];
        // Four long names: a narrow panel has a second line of them.
        let choose = |ui: &mut Ui| look::choose(ui, &mut recipe.drive, &drives);
        ui.horizontal_wrapped(choose).inner
    });
    edited
}

/// The ways to lay out a first moment; what a way has of its own is Earth's until a recipe says more.
fn start(ui: &mut Ui, start: &mut Start) -> bool {
    let mut way = match start {
        Start::FloodFill => 0,
        Start::Voronoi => 1,
        Start::Hypsometric(_) => 2,
        Start::Image(_) => 3,
    };
    let flood = "Plates grow from random seeds, one shuffled frontier a round.";
    let voronoi = "Cells of random centres, their boundaries bent by noise.";
    let curve = "Continents from random great circles, as high as a hypsometric curve says: Earth's, or \
                 that of the recipe.";
    let image = "An imported height map: a PNG, grey, equirectangular.";
    let ways = [
        (0, "Flood", flood),
        (1, "Voronoi", voronoi),
        (2, "Curve", curve),
        (3, "Image", image),
    ];
    let changed = look::choose(ui, &mut way, &ways);
    if changed {
        *start = match way {
            0 => Start::FloodFill,
            1 => Start::Voronoi,
            2 => Start::Hypsometric(Hypsometry::default()),
            _ => Start::Image(ImageStart::default()),
        };
    }
    changed
}

fn laws(ui: &mut Ui, laws: &mut Laws) -> bool {
    let mut edited = look::row(ui, "Sea floor", "Depth of sea floor by its age.", |ui| {
        let choices = [
            (SeaFloorLaw::Gdh1, "GDH1", "Stein & Stein 1992."),
            (
                SeaFloorLaw::ParsonsSclater,
                "P & S",
                "Parsons & Sclater 1977.",
            ),
            (
                SeaFloorLaw::Cortial,
                "Cortial",
                "Damping towards trenches, from high ridges.",
            ),
            (
                SeaFloorLaw::Yggdrasill,
                "Yggdrasill",
                "A fall to the plain between 2 and 4 My.",
            ),
        ];
        look::choose(ui, &mut laws.sea_floor, &choices)
    });
    edited |= look::row(
        ui,
        "Uplift",
        "What subduction does to the plate above.",
        |ui| {
            let choices = [
                (
                    UpliftLaw::Magma,
                    "Magma",
                    "In a band behind the trench, by convergence.",
                ),
                (
                    UpliftLaw::Cortial,
                    "Cortial",
                    "Wide, by the relief of what goes under.",
                ),
            ];
            look::choose(ui, &mut laws.uplift, &choices)
        },
    );
    edited |= look::row(ui, "Collision", "What continents that meet raise.", |ui| {
        let choices = [
            (
                CollisionLaw::Crush,
                "Crush",
                "Crushed crust thickens both sides.",
            ),
            (
                CollisionLaw::Cortial,
                "Cortial",
                "And a surge where a terrane docks.",
            ),
        ];
        look::choose(ui, &mut laws.collision, &choices)
    });
    edited |= look::row(ui, "Erosion", "How land is worn down.", |ui| {
        let choices = [
            (
                ErosionLaw::BaseLevel,
                "Base level",
                "By the height above a base level.",
            ),
            (
                ErosionLaw::Cortial,
                "Cortial",
                "In proportion to elevation, with swells.",
            ),
            (
                ErosionLaw::Rain,
                "Rain",
                "A share of each difference in height, by rain.",
            ),
        ];
        look::choose(ui, &mut laws.erosion, &choices)
    });
    edited
}

/// Reads a number with or without separators.
fn parse_whole(text: &str) -> Option<f64> {
    let digits: String = text
        .chars()
        .filter(|letter| !matches!(letter, ',' | ' ' | '_' | '\''))
        .collect();
    digits.trim_end_matches("km").parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edited_draft_can_be_applied_once() {
        let mut planet = Planet::new(Recipe::earth_like(1)).with_end(17.0);
        let mut draft = Draft::new(&planet.recipe);
        assert!(!draft.is_edited() && !draft.is_ready());
        assert!(!draft.apply(&mut planet));
        assert_eq!(planet.until_my, Some(17.0));

        draft.recipe.land_share = 0.5;
        draft.check();
        assert!(draft.is_ready());
        assert!(draft.apply(&mut planet));
        assert_eq!(planet.recipe.land_share, 0.5);
        assert_eq!(planet.until_my, None);
        assert!(!draft.is_edited());
        assert!(!draft.apply(&mut planet));
    }

    #[test]
    fn an_invalid_draft_says_why_and_stays() {
        let mut planet = Planet::default();
        let mut draft = Draft::new(&planet.recipe);
        draft.recipe.sub_plates = 200;
        draft.recipe.plates = 30;
        draft.check();
        assert!(draft.is_edited() && !draft.is_ready());
        assert!(draft.problem().is_some_and(|text| text.contains("plates")));
        assert!(!draft.apply(&mut planet));
        assert_eq!(planet, Planet::default());
        draft.revert();
        assert!(!draft.is_edited());
        assert_eq!(draft.problem(), None);
    }

    #[test]
    fn an_untouched_draft_follows_the_planet() {
        let mut draft = Draft::new(&Recipe::earth_like(1));
        draft.follow(&Recipe::earth_like(2));
        assert_eq!(draft.recipe.seed, 2);
        assert!(!draft.is_edited());

        draft.recipe.duration_my = 7.0;
        draft.follow(&Recipe::earth_like(3));
        assert_eq!((draft.recipe.seed, draft.recipe.duration_my), (2, 7.0));
        assert!(draft.is_edited());
        draft.revert();
        assert_eq!(draft.recipe, Recipe::earth_like(3));
    }

    #[test]
    fn seeds_keep_all_their_digits() {
        let mut draft = Draft::new(&Recipe::earth_like(u64::MAX));
        assert_eq!(draft.seed, "18446744073709551615");
        draft.seed = " 18446744073709551614 ".into();
        assert!(draft.read_seed());
        assert_eq!(draft.recipe.seed, u64::MAX - 1);
        draft.seed = "many".into();
        assert!(!draft.read_seed());
        draft.check();
        assert_eq!(draft.seed, "18446744073709551614");
        assert!(throw_dice() < SEEDS);
    }

    #[test]
    fn numbers_are_read_with_separators() {
        assert_eq!(parse_whole("1,234,567"), Some(1_234_567.0));
        assert_eq!(parse_whole("6 371 km"), Some(6371.0));
        assert_eq!(parse_whole("x"), None);
    }
}
