//! A new world at a key press, while a graph shows that no frame waits for it.
//!
//! `cargo run --release --features editor --example regenerate`
//!
//! Space grows another planet in secret and shows it when it is done; G shows it growing.

use bevy::platform::time::Instant;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, EguiPlugin, EguiPrimaryContextPass, egui};
use bevy_panorbit_camera::{PanOrbitCamera, PanOrbitCameraPlugin};
use bevy_tectonics::prelude::*;
use egui_plot::{Line, Plot, PlotPoints, VLine};
use std::collections::VecDeque;

/// Frames in the graph.
const FRAMES: usize = 600;

fn main() -> AppExit {
    App::new()
        .add_plugins((
            DefaultPlugins,
            TectonicsPlugins,
            PanOrbitCameraPlugin,
            EguiPlugin::default(),
        ))
        .init_resource::<FrameTimes>()
        .add_systems(Startup, setup)
        .add_systems(Update, regenerate)
        .add_systems(Last, measure)
        .add_systems(EguiPrimaryContextPass, draw)
        .add_observer(
            |changed: On<SurfaceChanged>, mut times: ResMut<FrameTimes>| {
                if changed.first {
                    times.mark();
                }
            },
        )
        .run()
}

fn setup(mut commands: Commands) {
    commands.spawn(Planet::new(Recipe::earth_like(1)));
    commands.spawn((
        PanOrbitCamera::default(),
        Transform::from_xyz(0.0, 1.0, 2.8),
    ));
    commands.spawn((
        DirectionalLight::default(),
        Transform::from_xyz(-2.0, 1.5, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

fn regenerate(
    keys: Res<ButtonInput<KeyCode>>,
    mut planets: Query<&mut Planet>,
    mut times: ResMut<FrameTimes>,
) {
    let regrowth = if keys.just_pressed(KeyCode::Space) {
        Regrowth::Hidden
    } else if keys.just_pressed(KeyCode::KeyG) {
        Regrowth::Shown
    } else {
        return;
    };
    times.mark();
    for mut planet in &mut planets {
        planet.recipe.seed += 1;
        planet.regrowth = regrowth;
    }
}

/// Time of the last frames, and in which of them something began.
#[derive(Resource, Default)]
struct FrameTimes {
    last: Option<Instant>,
    frame: usize,
    milliseconds: VecDeque<[f64; 2]>,
    marks: VecDeque<f64>,
}

impl FrameTimes {
    fn mark(&mut self) {
        self.marks.push_back(self.frame as f64);
    }

    /// Median and worst of the frames in the graph, in ms.
    fn summary(&self) -> (f64, f64) {
        let mut sorted: Vec<f64> = self.milliseconds.iter().map(|[_, time]| *time).collect();
        sorted.sort_by(f64::total_cmp);
        let worst = sorted.last().copied().unwrap_or_default();
        (
            sorted.get(sorted.len() / 2).copied().unwrap_or_default(),
            worst,
        )
    }
}

fn measure(mut times: ResMut<FrameTimes>) {
    let now = Instant::now();
    if let Some(last) = times.last.replace(now) {
        let point = [times.frame as f64, (now - last).as_secs_f64() * 1e3];
        times.milliseconds.push_back(point);
        times.frame += 1;
    }
    let oldest = times.frame.saturating_sub(FRAMES) as f64;
    while times
        .milliseconds
        .front()
        .is_some_and(|point| point[0] < oldest)
    {
        times.milliseconds.pop_front();
    }
    while times.marks.front().is_some_and(|mark| *mark < oldest) {
        times.marks.pop_front();
    }
}

fn draw(
    mut contexts: EguiContexts,
    times: Res<FrameTimes>,
    planets: Query<(&Planet, &Growth)>,
) -> Result {
    let (median, worst) = times.summary();
    egui::Window::new("Frame times")
        .default_pos([12.0, 12.0])
        .default_width(460.0)
        .show(contexts.ctx_mut()?, |ui| {
            ui.label("Space: another planet, grown in secret   G: seen growing");
            for (planet, growth) in &planets {
                let done = growth.progress.fraction as f32;
                ui.add(egui::ProgressBar::new(done).text(format!(
                    "seed {}: {:.0} My",
                    planet.recipe.seed, growth.progress.time_my
                )));
            }
            ui.label(format!("median {median:.1} ms, worst {worst:.1} ms"));
            Plot::new("frames")
                .height(180.0)
                .include_y(0.0)
                .include_y(3.0 * median)
                .allow_drag(false)
                .allow_zoom(false)
                .allow_scroll(false)
                .y_axis_label("ms")
                .show(ui, |plot| {
                    for mark in &times.marks {
                        plot.vline(VLine::new("a planet begins or appears", *mark));
                    }
                    let points: PlotPoints = times.milliseconds.iter().copied().collect();
                    plot.line(Line::new("frame", points));
                });
        });
    Ok(())
}
