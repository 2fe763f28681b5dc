//! A control panel for planets: what they grow from, how fast, how they are drawn, what they measure.
//!
//! Add [`EditorPlugin`], and the panel stands at a side of the window. It shows any entity that has a
//! [`Planet`](crate::planet::Planet), whoever draws it.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_tectonics::editor::EditorPlugin;
//! use bevy_tectonics::prelude::*;
//!
//! App::new()
//!     .add_plugins((DefaultPlugins, PlanetPlugin::default(), EditorPlugin))
//!     .add_systems(Startup, |mut commands: Commands| {
//!         commands.spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 3.0)));
//!         commands.spawn((Name::new("Terra"), Planet::new(Recipe::earth_like(7))));
//!     })
//!     .run();
//! ```
//!
//! # The game beside it
//!
//! A camera must not turn while a slider is dragged, and keys must not steer while a number is typed:
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_tectonics::editor::{egui_wants_any_keyboard_input, egui_wants_any_pointer_input};
//!
//! # fn orbit() {}
//! # fn steer() {}
//! App::new().add_systems(
//!     Update,
//!     (
//!         orbit.run_if(not(egui_wants_any_pointer_input)),
//!         steer.run_if(not(egui_wants_any_keyboard_input)),
//!     ),
//! );
//! ```
//!
//! [`Editor`] says which planet is shown, hides or folds the panel, and tells how much of the window it
//! covers. The panel writes [`Planet`](crate::planet::Planet) and
//! [`PlanetView`](crate::planet::PlanetView) only when someone changes something: change detection stays
//! meaningful.

mod charts;
mod constants;
mod figures;
mod legend;
mod look;
mod panel;
mod pointer;
mod recipe;
mod record;
mod statistics;
#[cfg(test)]
mod tests;
mod time;
mod timings;
mod view;

pub use bevy_egui::input::{
    EguiWantsInput, egui_wants_any_input, egui_wants_any_keyboard_input,
    egui_wants_any_pointer_input,
};

use bevy::prelude::*;
use bevy_egui::{EguiPlugin, EguiPrimaryContextPass, input::write_egui_wants_input_system};

/// Adds the panel, and [`EguiPlugin`] if it is missing: a game with settings of its own for egui adds
/// that plugin before this one.
///
/// To begin with another side or folded, insert an [`Editor`] of your own.
#[derive(Debug, Clone, Copy, Default)]
pub struct EditorPlugin;

impl Plugin for EditorPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<EguiPlugin>() {
            app.add_plugins(EguiPlugin::default());
        }
        app.init_resource::<Editor>()
            .register_type::<Editor>()
            .init_resource::<panel::Notes>()
            .init_resource::<pointer::Pointer>()
            .add_observer(panel::record_surface)
            .add_observer(panel::forget_planet)
            .add_systems(
                PostUpdate,
                // Earlier, egui would not know yet whether the pointer is the panel's.
                pointer::look_under_pointer
                    .after(write_egui_wants_input_system)
                    .after(TransformSystems::Propagate),
            )
            .add_systems(EguiPrimaryContextPass, panel::show_panel);
    }
}

/// The state of the panel, for games that steer it.
#[derive(Resource, Debug, Clone, PartialEq, Reflect)]
#[reflect(Resource, Default)]
pub struct Editor {
    /// Whether there is a panel at all.
    pub shown: bool,
    /// Whether only the button that unfolds it is there.
    pub folded: bool,
    /// Where it stands.
    pub side: EditorSide,
    /// Its width in logical pixels.
    pub width: f32,
    /// The planet it shows. None, or one that is gone: the first.
    pub planet: Option<Entity>,
}

impl Default for Editor {
    fn default() -> Self {
        Self {
            shown: true,
            folded: false,
            side: EditorSide::default(),
            width: 368.0,
            planet: None,
        }
    }
}

impl Editor {
    /// How many logical pixels of the window's width the panel covers at its side.
    #[must_use]
    pub fn covered(&self) -> f32 {
        if self.shown && !self.folded {
            self.width
        } else {
            0.0
        }
    }
}

/// A side of the window.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Reflect)]
pub enum EditorSide {
    /// The left one.
    #[default]
    Left,
    /// The right one.
    Right,
}
