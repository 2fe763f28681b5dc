//! The whole panel without a window.

use super::panel::{Notes, Panel, forget_planet, record_surface};
use super::pointer::{Pointer, Spot};
use super::*;
use crate::planet::{
    Growth, GrowthFailure, GrowthState, Pace, Planet, PlanetPlugin, PlanetSurface, PlanetView,
    Regrowth, SurfaceChanged,
};
use crate::simulation::{Progress, Recipe};
use crate::surface::Overlay;
use bevy_egui::egui::{self, Event, Modifiers, PointerButton, RawInput, pos2, vec2};

/// An app with the panel's state and no window.
fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, PlanetPlugin::default().with_threads(0)))
        .init_resource::<Editor>()
        .init_resource::<Notes>()
        .init_resource::<Pointer>()
        .add_observer(record_surface)
        .add_observer(forget_planet);
    app
}

fn small(seed: u64) -> Planet {
    Planet::new(
        Recipe::earth_like(seed)
            .with_sub_plates(300)
            .with_duration(4.0),
    )
}

/// One frame of the panel, with every section open.
fn draw(app: &mut App, context: &egui::Context, events: Vec<Event>) -> egui::FullOutput {
    // New areas are measured before they are seen.
    if context.cumulative_pass_nr() == 0 {
        let _ = context.run_ui(RawInput::default(), |_| {});
        draw(app, context, Vec::new());
    }
    let screen = egui::Rect::from_min_size(pos2(0.0, 0.0), vec2(1200.0, 3000.0));
    let input = RawInput {
        screen_rect: Some(screen),
        events,
        ..RawInput::default()
    };
    context.run_ui(input, |ui| {
        let context = ui.ctx().clone();
        let drawn = app.world_mut().run_system_cached_with(
            |In(context): In<egui::Context>, mut panel: Panel| panel.show(&context),
            context,
        );
        assert!(drawn.is_ok());
    })
}

/// All words of a frame with where they stand.
fn words(output: &egui::FullOutput) -> Vec<(String, egui::Pos2)> {
    fn collect(shape: &egui::Shape, words: &mut Vec<(String, egui::Pos2)>) {
        match shape {
            egui::Shape::Text(text) => {
                words.push((
                    text.galley.text().to_owned(),
                    text.visual_bounding_rect().center(),
                ));
            }
            egui::Shape::Vec(shapes) => shapes.iter().for_each(|shape| collect(shape, words)),
            _ => {}
        }
    }
    let mut words = Vec::new();
    for clipped in &output.shapes {
        collect(&clipped.shape, &mut words);
    }
    words
}

fn shows(output: &egui::FullOutput, text: &str) -> bool {
    words(output).iter().any(|(word, _)| word.contains(text))
}

/// Clicks on a word.
fn click(app: &mut App, context: &egui::Context, text: &str) {
    let output = draw(app, context, Vec::new());
    let found = words(&output)
        .into_iter()
        .find(|(word, _)| word.contains(text));
    let Some((_, pos)) = found else {
        panic!("no {text} in the panel");
    };
    let button = |pressed| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    draw(app, context, vec![Event::PointerMoved(pos)]);
    draw(app, context, vec![button(true)]);
    draw(app, context, vec![button(false)]);
    // Sections that open take a while.
    for _ in 0..40 {
        draw(app, context, Vec::new());
    }
}

#[test]
fn no_planets_one_planet_three_planets() {
    for count in [0, 1, 3] {
        let mut app = app();
        let context = egui::Context::default();
        for seed in 0..count {
            app.world_mut().spawn(small(seed));
        }
        for _ in 0..3 {
            app.update();
            let output = draw(&mut app, &context, Vec::new());
            assert_eq!(shows(&output, "There is no planet."), count == 0);
            assert_eq!(shows(&output, "Planet 1"), count > 0);
            assert!(!shows(&output, "Planet 2") && !shows(&output, "Planet 3"));
        }
        for side in [EditorSide::Right, EditorSide::Left] {
            for folded in [true, false] {
                let mut editor = app.world_mut().resource_mut::<Editor>();
                (editor.side, editor.folded) = (side, folded);
                draw(&mut app, &context, Vec::new());
            }
        }
    }
}

#[test]
fn every_state_can_be_shown() {
    let mut app = app();
    let context = egui::Context::default();
    let planet = app.world_mut().spawn((Name::new("Terra"), small(3))).id();
    app.update();
    for section in ["Statistics", "Charts", "Timings"] {
        click(&mut app, &context, section);
    }
    let states = [
        GrowthState::Starting,
        GrowthState::Growing,
        GrowthState::Resting,
        GrowthState::Finished,
        GrowthState::Failed(GrowthFailure::Panicked),
    ];
    for state in states {
        for hidden in [false, true] {
            for (steps, stage_seconds) in [(0, vec![]), (3, vec![("move", 0.25), ("erode", 0.5)])] {
                let progress = Progress {
                    time_my: 2.0,
                    end_my: 4.0,
                    steps,
                    fraction: 0.5,
                };
                app.world_mut().entity_mut(planet).insert(Growth {
                    state: state.clone(),
                    progress,
                    hidden,
                    stage_seconds,
                });
                let output = draw(&mut app, &context, Vec::new());
                assert!(shows(&output, "Terra"));
                let failed = matches!(state, GrowthState::Failed(_));
                assert_eq!(shows(&output, "A stage of the simulation panicked"), failed);
            }
        }
    }
    for overlay in Overlay::ALL {
        app.world_mut().entity_mut(planet).insert(PlanetView {
            overlay: Some(overlay),
            boundaries: true,
            velocities: true,
            ..PlanetView::default()
        });
        draw(&mut app, &context, Vec::new());
    }
    for pace in [
        Pace::MyPerSecond(f64::NAN),
        Pace::MyPerSecond(-1.0),
        Pace::MyPerSecond(1e9),
    ] {
        app.world_mut().entity_mut(planet).insert(
            small(3)
                .with_pace(pace)
                .with_end(f64::NAN)
                .with_regrowth(Regrowth::Shown),
        );
        draw(&mut app, &context, Vec::new());
    }
    app.world_mut().entity_mut(planet).remove::<PlanetView>();
    draw(&mut app, &context, Vec::new());
}

#[test]
fn a_grown_planet_is_measured_and_forgotten() {
    let mut app = app();
    let context = egui::Context::default();
    let planet = app.world_mut().spawn(small(5)).id();
    for _ in 0..2000 {
        app.update();
        let growth = app.world().get::<Growth>(planet);
        if growth.is_some_and(|growth| growth.state == GrowthState::Finished) {
            break;
        }
    }
    assert!(app.world().get::<PlanetSurface>(planet).is_some());
    for section in ["Statistics", "Charts", "Timings", "Constants"] {
        click(&mut app, &context, section);
    }
    // A moment later, so that there is a line to draw.
    app.world_mut().trigger(SurfaceChanged {
        entity: planet,
        time_my: 5.0,
        first: false,
    });
    let spot = app
        .world()
        .get::<PlanetSurface>(planet)
        .map(|surface| Spot::new(planet, surface, surface.at_lat_lon(47.0, 8.5)));
    assert!(spot.is_some());
    app.world_mut().resource_mut::<Pointer>().0 = spot;
    let output = draw(&mut app, &context, Vec::new());
    for text in [
        "47.0° N, 8.5° E",
        "260,000 km",
        "Number of plates",
        "Erode",
        "Motion",
    ] {
        assert!(shows(&output, text), "{text}");
    }
    app.world_mut().despawn(planet);
    let output = draw(&mut app, &context, Vec::new());
    assert!(shows(&output, "There is no planet."));
}

#[test]
fn looking_changes_nothing_and_clicking_does() {
    let mut app = app();
    let context = egui::Context::default();
    let planet = app.world_mut().spawn(small(3)).id();
    app.update();
    draw(&mut app, &context, Vec::new());
    app.world_mut().clear_trackers();
    let touched = |app: &mut App| {
        let world = app.world_mut();
        let planet = world.entity(planet);
        let touched = planet
            .get_ref::<Planet>()
            .is_some_and(|planet| planet.is_changed())
            || planet
                .get_ref::<PlanetView>()
                .is_some_and(|view| view.is_changed())
            || world.is_resource_changed::<Editor>();
        world.clear_trackers();
        touched
    };
    for x in 0..60 {
        let event = Event::PointerMoved(pos2(6.0 * x as f32, 17.0 * x as f32));
        draw(&mut app, &context, vec![event]);
        assert!(!touched(&mut app));
    }
    click(&mut app, &context, "Pause");
    assert!(touched(&mut app));
    assert!(
        app.world()
            .get::<Planet>(planet)
            .is_some_and(|planet| planet.paused)
    );
    click(&mut app, &context, "Age of crust");
    let view = app.world().get::<PlanetView>(planet);
    assert_eq!(view.and_then(|view| view.overlay), Some(Overlay::Age));

    click(&mut app, &context, "Voronoi");
    assert_eq!(
        app.world()
            .get::<Planet>(planet)
            .map(|planet| planet.recipe.clone()),
        Some(small(3).recipe)
    );
    click(&mut app, &context, "Regenerate");
    let start = app
        .world()
        .get::<Planet>(planet)
        .map(|planet| planet.recipe.start.clone());
    assert_eq!(start, Some(crate::simulation::Start::Voronoi));
}
