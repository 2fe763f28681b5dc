//! How a planet is drawn.

use super::legend::{self, Legends};
use super::look;
use crate::planet::PlanetView;
use crate::surface::Overlay;
use bevy_egui::egui::Ui;

/// Heights drawn at most so many times larger.
const MOST_EXAGGERATION: f32 = 100.0;
/// Reach of the level of the drawn sea in m.
const SEA_REACH_M: f32 = 6000.0;

/// Overlays that colour the ground; the others are lines and arrows.
fn fills() -> impl Iterator<Item = Overlay> {
    Overlay::ALL
        .into_iter()
        .filter(|overlay| !matches!(overlay, Overlay::Boundaries | Overlay::Velocity))
}

/// Draws the section. True if the view was changed.
pub(super) fn show(ui: &mut Ui, view: &mut PlanetView, legends: &mut Legends) -> bool {
    let mut changed = false;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = bevy_egui::egui::vec2(4.0, 4.0);
        let hint = "As seen from space.";
        changed |= look::choose(ui, &mut view.overlay, &[(None, "Natural", hint)]);
        for overlay in fills() {
            changed |= look::choose(
                ui,
                &mut view.overlay,
                &[(Some(overlay), overlay.name(), "")],
            );
        }
    });
    if view.overlay.is_some() {
        changed |= look::row(
            ui,
            "Opacity",
            "How far the colours cover the natural ones.",
            |ui| {
                let mut opacity = f64::from(view.overlay_opacity);
                let changed = look::share(ui, &mut opacity, 0.0..=1.0);
                if changed {
                    view.overlay_opacity = opacity as f32;
                }
                changed
            },
        );
    }
    ui.horizontal(|ui| {
        let hint = "Boundaries of plates as lines, coloured by kind.";
        changed |= look::switch(ui, &mut view.boundaries, "Boundaries", hint);
        ui.add_space(8.0);
        let hint = "Velocity of plates as arrows.";
        changed |= look::switch(ui, &mut view.velocities, "Velocities", hint);
        ui.add_space(8.0);
        changed |= look::switch(ui, &mut view.sea, "Sea", "Whether the sea is drawn.");
    });
    let hint = "Heights are drawn this many times larger than they are. At 1 no mountain can be seen \
                from space.";
    changed |= look::row(ui, "Exaggeration", hint, |ui| {
        look::slider(
            ui,
            &mut view.exaggeration,
            1.0..=MOST_EXAGGERATION,
            |slider| slider.logarithmic(true).max_decimals(1).suffix(" ×"),
        )
    });
    if view.sea {
        let hint =
            "Level of the drawn sea above the planet's own. The history does not know of it.";
        changed |= look::row(ui, "Sea level", hint, |ui| {
            let range = -SEA_REACH_M..=SEA_REACH_M;
            look::slider(ui, &mut view.sea_level_m, range, |slider| {
                slider.step_by(10.0).max_decimals(0).suffix(" m")
            })
        });
    }
    let lines = [
        (view.boundaries, Overlay::Boundaries),
        (view.velocities, Overlay::Velocity),
    ];
    let lines = lines
        .into_iter()
        .filter(|(on, _)| *on)
        .map(|(_, line)| line);
    for overlay in view.overlay.into_iter().chain(lines) {
        legend::show(ui, legends.of(overlay));
    }
    changed
}
