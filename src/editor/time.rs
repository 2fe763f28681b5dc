//! Time: how far a planet has come, how fast it goes on, where it stops.

use super::figures::{tenth, whole};
use super::look::{self, ACCENT, BAD, BRIGHT, FAINT, GOOD, TEXT, WARM};
use crate::planet::{Growth, GrowthState, Pace, Planet};
use crate::simulation::Recipe;
use bevy_egui::egui::{Align, Color32, Layout, ProgressBar, RichText, Ui};

/// My per second that the slider offers.
const SLOWEST: f64 = 0.1;
const FASTEST: f64 = 1000.0;
/// How much the end is moved by the button that moves it, in My.
const LONGER_MY: f64 = 50.0;

/// What a state is called, and the colour of its light.
pub(super) fn describe(growth: &Growth, planet: &Planet) -> (&'static str, Color32) {
    match growth.state {
        GrowthState::Starting => ("Laying out", WARM),
        GrowthState::Growing if growth.hidden => ("Growing unseen", ACCENT),
        GrowthState::Growing => ("Growing", ACCENT),
        GrowthState::Resting if planet.paused => ("Paused", FAINT),
        GrowthState::Resting => ("Standing still", FAINT),
        GrowthState::Finished => ("Finished", GOOD),
        GrowthState::Failed(_) => ("Failed", BAD),
    }
}

/// Draws the section. `rate` is the pace to return to after the fastest one. True if the planet was
/// changed.
pub(super) fn show(ui: &mut Ui, planet: &mut Planet, growth: &Growth, rate: &mut f64) -> bool {
    let progress = &growth.progress;
    ui.horizontal(|ui| {
        let time = format!("{} My", tenth(progress.time_my));
        ui.label(RichText::new(time).heading().color(BRIGHT));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let (name, color) = describe(growth, planet);
            ui.label(RichText::new(name).color(TEXT));
            look::light(ui, color);
        });
    });
    let end_my = planet.end_my();
    let share = share(progress.time_my, end_my);
    ui.add(
        ProgressBar::new(share)
            .desired_height(5.0)
            .corner_radius(2)
            .fill(ACCENT),
    );
    ui.horizontal(|ui| {
        let small = |text: String| RichText::new(text).small().color(FAINT);
        ui.label(small(format!(
            "{:.0} % of {} My",
            100.0 * share,
            whole(end_my)
        )));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.label(small(format!("{} steps", whole(progress.steps as f64))));
        });
    });
    if let GrowthState::Failed(failure) = &growth.state {
        look::complaint(ui, &sentence(&failure.to_string()));
    } else if growth.hidden {
        let text = "The old planet stays in sight until the new one is finished.";
        ui.label(RichText::new(text).small().color(WARM));
    }
    ui.add_space(2.0);

    let mut changed = controls(ui, planet, growth);
    changed |= look::row(
        ui,
        "Pace",
        "How fast time passes. Neither pace nor pauses change the planet.",
        |ui| pace(ui, planet, rate),
    );
    changed |= look::row(ui, "Until", "Time at which the history rests.", |ui| {
        until(ui, planet)
    });
    changed
}

/// The share of the way that is done.
fn share(time_my: f64, end_my: f64) -> f32 {
    if end_my > 0.0 {
        (time_my / end_my).clamp(0.0, 1.0) as f32
    } else {
        1.0
    }
}

/// Errors begin small and end without a full stop.
pub(super) fn sentence(error: &str) -> String {
    let mut letters = error.chars();
    let Some(first) = letters.next() else {
        return String::new();
    };
    let mut text: String = first.to_uppercase().chain(letters).collect();
    if !text.ends_with('.') {
        text.push('.');
    }
    text
}

fn controls(ui: &mut Ui, planet: &mut Planet, growth: &Growth) -> bool {
    let failed = matches!(growth.state, GrowthState::Failed(_));
    let finished = growth.state == GrowthState::Finished;
    let width = (ui.available_width() - 2.0 * ui.spacing().item_spacing.x) / 3.0;
    let mut changed = false;
    ui.horizontal(|ui| {
        if planet.paused {
            let go = look::main_button(ui, !failed && !finished, width, "▶  Go on");
            if go
                .on_disabled_hover_text("Nothing is left to do.")
                .clicked()
            {
                planet.resume();
                changed = true;
            }
        } else {
            let pause = look::button(ui, !failed && !finished, width, "⏸  Pause");
            if pause.clicked() {
                planet.pause();
                changed = true;
            }
        }
        let step = look::button(ui, !failed, width, "⏭  Step");
        if step
            .on_hover_text("Pauses and runs one step, beyond the end too.")
            .clicked()
        {
            planet.step();
            changed = true;
        }
        let longer = look::button(ui, !failed, width, format!("+ {LONGER_MY:.0} My"));
        if longer
            .on_hover_text("Runs on for so long, and moves the end if it must.")
            .clicked()
        {
            let end_my = if finished || planet.paused {
                growth.progress.time_my + LONGER_MY
            } else {
                planet.end_my() + LONGER_MY
            };
            planet.run_to(end_my);
            changed = true;
        }
    });
    changed
}

fn pace(ui: &mut Ui, planet: &mut Planet, rate: &mut f64) -> bool {
    let mut fastest = planet.pace == Pace::Fastest;
    if let Pace::MyPerSecond(now) = planet.pace {
        *rate = now;
    }
    let mut changed = look::choose(
        ui,
        &mut fastest,
        &[
            (true, "Fastest", "As fast as the machine can."),
            (false, "Limited", "So many My in each second, or less."),
        ],
    );
    if changed {
        planet.pace = if fastest {
            Pace::Fastest
        } else {
            Pace::MyPerSecond(*rate)
        };
    }
    if !fastest {
        ui.spacing_mut().interact_size.x = 60.0;
        let width = ui.available_width() - 66.0;
        ui.spacing_mut().slider_width = width.max(30.0);
        let slider = bevy_egui::egui::Slider::new(rate, SLOWEST..=FASTEST)
            .logarithmic(true)
            .clamping(bevy_egui::egui::SliderClamping::Edits)
            .max_decimals(1)
            .suffix(" My/s");
        if ui.add(slider).changed() {
            planet.pace = Pace::MyPerSecond(*rate);
            changed = true;
        }
    }
    changed
}

fn until(ui: &mut Ui, planet: &mut Planet) -> bool {
    let mut end_my = planet.end_my();
    let number = look::number(&mut end_my, Recipe::DURATION_MY, 1.0)
        .max_decimals(1)
        .suffix(" My");
    let mut changed = false;
    if ui.add(number).changed() {
        planet.until_my = Some(end_my);
        changed = true;
    }
    if planet.until_my.is_some() {
        let reset = ui.button("As in the recipe");
        if reset.clicked() {
            planet.until_my = None;
            changed = true;
        }
    }
    changed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_nothing_are_done() {
        assert_eq!(share(0.0, 0.0), 1.0);
        assert_eq!(share(300.0, 200.0), 1.0);
        assert_eq!(share(50.0, 200.0), 0.25);
    }

    #[test]
    fn errors_become_sentences() {
        assert_eq!(sentence("a stage panicked"), "A stage panicked.");
        assert_eq!(sentence(""), "");
    }
}
