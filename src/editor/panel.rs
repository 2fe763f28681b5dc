//! The panel itself: finds the planet, draws the sections, hands on what was changed.

use super::legend::Legends;
use super::look::{self, BRIGHT, FAINT, GROUND, LINE};
use super::pointer::Pointer;
use super::recipe::Draft;
use super::record::Record;
use super::{Editor, EditorSide};
use super::{charts, figures, pointer, recipe, statistics, time, timings, view};
use crate::planet::{Growth, Planet, PlanetSurface, PlanetView, SurfaceChanged};
use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::EguiContexts;
use bevy_egui::egui::{
    self, Align, Align2, Area, Button, ComboBox, CursorIcon, Frame, Id, Layout, Margin, Order,
    RichText, ScrollArea, Sense, Stroke, Style, Ui, vec2,
};
use std::sync::Arc;

/// Widths that the panel may have.
const NARROWEST: f32 = 320.0;
const WIDEST: f32 = 620.0;
/// My per second after the fastest pace.
const RATE: f64 = 10.0;

/// What the panel remembers.
#[derive(Resource)]
pub(super) struct Notes {
    planets: EntityHashMap<Note>,
    legends: Legends,
    style: Arc<Style>,
}

impl Default for Notes {
    fn default() -> Self {
        let mut style = Style::default();
        look::style(&mut style);
        Self {
            planets: EntityHashMap::default(),
            legends: Legends::default(),
            style: Arc::new(style),
        }
    }
}

/// What it remembers of a planet.
struct Note {
    draft: Option<Draft>,
    record: Record,
    rate: f64,
}

impl Default for Note {
    fn default() -> Self {
        Self {
            draft: None,
            record: Record::default(),
            rate: RATE,
        }
    }
}

/// Keeps figures of every surface, whether the panel is open or not.
pub(super) fn record_surface(
    changed: On<SurfaceChanged>,
    surfaces: Query<&PlanetSurface>,
    mut notes: ResMut<Notes>,
) {
    let note = notes.planets.entry(changed.entity).or_default();
    if changed.first {
        note.record = Record::default();
    }
    if let Ok(surface) = surfaces.get(changed.entity) {
        note.record.push(changed.time_my, surface.statistics());
    }
}

pub(super) fn forget_planet(gone: On<Remove, Planet>, mut notes: ResMut<Notes>) {
    notes.planets.remove(&gone.entity);
}

pub(super) fn show_panel(mut contexts: EguiContexts, mut panel: Panel) {
    // Without a camera there is no context yet.
    if let Ok(context) = contexts.ctx_mut() {
        panel.show(context);
    }
}

type Shown = (
    Entity,
    Option<&'static Name>,
    &'static mut Planet,
    Option<&'static mut PlanetView>,
    &'static Growth,
    Option<&'static PlanetSurface>,
);

/// Everything the panel needs.
#[derive(SystemParam)]
pub(super) struct Panel<'w, 's> {
    editor: ResMut<'w, Editor>,
    notes: ResMut<'w, Notes>,
    pointer: Res<'w, Pointer>,
    planets: Query<'w, 's, Shown>,
}

impl Panel<'_, '_> {
    /// Draws the panel, or the button that unfolds it.
    pub(super) fn show(&mut self, context: &egui::Context) {
        if !self.editor.shown {
            return;
        }
        let mut editor = self.editor.clone();
        let window = context.content_rect();
        let left = editor.side == EditorSide::Left;
        // An area is what egui counts as its own: a panel in the background is not.
        let (pivot, corner) = if left {
            (Align2::LEFT_TOP, window.left_top())
        } else {
            (Align2::RIGHT_TOP, window.right_top())
        };
        let area = Area::new(Id::new("bevy_tectonics editor"))
            .order(Order::Middle)
            .pivot(pivot)
            .fixed_pos(corner)
            .movable(false)
            .constrain(false)
            .fade_in(false);
        area.show(context, |ui| {
            ui.set_style(self.notes.style.clone());
            if editor.folded {
                Frame::new().inner_margin(8).show(ui, |ui| {
                    let unfold = Button::new("☰").min_size(vec2(28.0, 28.0));
                    if ui.add(unfold).on_hover_text("Planets").clicked() {
                        editor.folded = false;
                    }
                });
                return;
            }
            let widest = WIDEST.min(window.width());
            editor.width = editor.width.clamp(NARROWEST.min(widest), widest);
            let size = vec2(editor.width, window.height());
            let (rect, _) = ui.allocate_exact_size(size, Sense::click());
            ui.painter().rect_filled(rect, 0, GROUND);
            let edge = if left { rect.right() } else { rect.left() };
            let line = Stroke::new(1.0, LINE);
            ui.painter().vline(edge, rect.y_range(), line);
            let inside = rect.shrink2(vec2(8.0, 8.0));
            let mut inside = ui.new_child(egui::UiBuilder::new().max_rect(inside));
            inside.set_clip_rect(rect);
            self.contents(&mut inside, &mut editor);
            resize(ui, edge, rect, &mut editor);
        });
        self.editor.set_if_neq(editor);
    }

    fn contents(&mut self, ui: &mut Ui, editor: &mut Editor) {
        let mut entities: Vec<Entity> = self.planets.iter().map(|planet| planet.0).collect();
        // As they were spawned: entities themselves are in no order that people know.
        entities.sort_unstable_by_key(|entity| (entity.index_u32(), entity.to_bits()));
        let chosen = editor.planet.filter(|planet| entities.contains(planet));
        let chosen = chosen.or(entities.first().copied());
        ui.horizontal(|ui| {
            let number = |entity| entities.iter().position(|known| *known == entity);
            self.header(ui, &entities, chosen, number, editor);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let fold = if editor.side == EditorSide::Left {
                    "⏴"
                } else {
                    "⏵"
                };
                let fold = Button::new(fold).frame(false).min_size(vec2(22.0, 22.0));
                if ui.add(fold).on_hover_text("Fold the panel away").clicked() {
                    editor.folded = true;
                }
            });
        });
        ui.add_space(2.0);
        let Some(chosen) = chosen else {
            ui.label(RichText::new("There is no planet.").color(FAINT));
            return;
        };
        ScrollArea::vertical()
            .auto_shrink(false)
            .content_margin(Margin::ZERO)
            .show(ui, |ui| self.sections(ui, chosen));
    }

    /// The planet's name, or a choice of planets.
    fn header(
        &self,
        ui: &mut Ui,
        entities: &[Entity],
        chosen: Option<Entity>,
        number: impl Fn(Entity) -> Option<usize>,
        editor: &mut Editor,
    ) {
        let name = |entity: Entity| {
            let name = self.planets.get(entity).ok().and_then(|planet| planet.1);
            name.map_or_else(
                || format!("Planet {}", number(entity).unwrap_or(0) + 1),
                |name| name.as_str().to_owned(),
            )
        };
        let title = chosen.map_or_else(|| "Planets".to_owned(), &name);
        if entities.len() < 2 {
            ui.label(RichText::new(title).size(16.0).color(BRIGHT));
            return;
        }
        ComboBox::from_id_salt("planet")
            .selected_text(RichText::new(title).size(15.0).color(BRIGHT))
            .width(0.6 * ui.available_width())
            .popup_style(look::popup_style())
            .show_ui(ui, |ui| {
                for &entity in entities {
                    let taken = Some(entity) == chosen;
                    if ui.selectable_label(taken, name(entity)).clicked() {
                        editor.planet = Some(entity);
                    }
                }
            });
    }

    fn sections(&mut self, ui: &mut Ui, entity: Entity) {
        let notes = &mut *self.notes;
        let note = notes.planets.entry(entity).or_default();
        let Ok((_, _, mut planet, mut planet_view, growth, surface)) = self.planets.get_mut(entity)
        else {
            return;
        };
        let mut wish = planet.clone();
        let mut changed = false;
        let (state, _) = time::describe(growth, &wish);
        let time_my = figures::tenth(growth.progress.time_my);
        let summary = format!("{time_my} My, {}", state.to_lowercase());
        look::section(ui, "Time", true, &summary, |ui| {
            changed |= time::show(ui, &mut wish, growth, &mut note.rate);
        });
        let draft = note.draft.get_or_insert_with(|| Draft::new(&wish.recipe));
        let summary = if draft.is_edited() { "edited" } else { "" };
        look::section(ui, "Recipe", true, summary, |ui| {
            changed |= recipe::show(ui, &mut wish, draft);
        });
        if changed && *planet != wish {
            *planet = wish;
        }

        if let Some(planet_view) = &mut planet_view {
            let mut wish = PlanetView::clone(planet_view);
            let mut changed = false;
            let summary = wish.overlay.map_or("", |overlay| overlay.name());
            look::section(ui, "View", true, summary, |ui| {
                changed = view::show(ui, &mut wish, &mut notes.legends);
            });
            if changed {
                planet_view.set_if_neq(wish);
            }
        }
        let spot = self.pointer.0.as_ref().filter(|spot| spot.planet == entity);
        look::section(ui, "Under the pointer", true, "", |ui| {
            pointer::show(ui, spot);
        });

        let moment = surface.map_or_else(String::new, |surface| {
            format!("at {} My", figures::tenth(surface.time_my))
        });
        look::section(ui, "Statistics", false, &moment, |ui| {
            if let Some(surface) = surface {
                statistics::show(ui, surface.statistics());
            } else {
                ui.weak("There is no surface yet.");
            }
        });
        look::section(ui, "Charts", false, "", |ui| charts::show(ui, &note.record));
        let (stages, steps) = (&growth.stage_seconds, growth.progress.steps);
        let summary = timings::per_step_ms(stages, steps)
            .map_or_else(String::new, |ms| format!("{ms:.1} ms a step"));
        look::section(ui, "Timings", false, &summary, |ui| {
            timings::show(ui, stages, steps);
        });
    }
}

/// The inner edge can be dragged.
fn resize(ui: &Ui, edge: f32, rect: egui::Rect, editor: &mut Editor) {
    let handle = egui::Rect::from_x_y_ranges(edge - 3.0..=edge + 3.0, rect.y_range());
    let response = ui.interact(handle, ui.id().with("edge"), Sense::drag());
    let response = response.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
    if let Some(pointer) = response.interact_pointer_pos()
        && response.dragged()
    {
        let width = match editor.side {
            EditorSide::Left => pointer.x - rect.left(),
            EditorSide::Right => rect.right() - pointer.x,
        };
        editor.width = width.clamp(NARROWEST, WIDEST);
    }
    if response.hovered() || response.dragged() {
        let line = Stroke::new(2.0, look::ACCENT);
        ui.painter().vline(edge, rect.y_range(), line);
    }
}
