//! Constants of the model, group by group.

use super::look::{self, ACCENT, FAINT, TEXT};
use crate::simulation::constants::{ConstantGroup, ConstantInfo, Constants};
use bevy_egui::egui::{
    Align, Align2, Button, CollapsingHeader, FontId, Layout, RichText, Sense, Ui, vec2,
};

/// Steps of the pointer from one end of a range to the other.
const STEPS: f64 = 400.0;

/// Draws the groups, folded away. True if a constant was changed.
pub(super) fn show(ui: &mut Ui, constants: &mut Constants) -> bool {
    let changes: usize = constants.groups().into_iter().map(differing).sum();
    let title = counted("Constants", changes);
    let header = CollapsingHeader::new(title).id_salt("constants");
    let response = header.show(ui, |ui| {
        let mut edited = false;
        for group in constants.groups_mut() {
            let title = counted(&heading(group.name()), differing(group));
            let doc = group.doc();
            let header = CollapsingHeader::new(title).id_salt(group.name());
            let response = header.show(ui, |ui| table(ui, group));
            response.header_response.on_hover_text(doc);
            edited |= response.body_returned == Some(true);
        }
        edited
    });
    response.body_returned == Some(true)
}

/// How many constants of a group are not the defaults.
fn differing(group: &(impl ConstantGroup + ?Sized)) -> usize {
    let rows = group.info().iter().enumerate();
    rows.filter(|(row, info)| group.value(*row) != Some(info.default))
        .count()
}

/// A title, with the number of changes if there are any.
fn counted(title: &str, changes: usize) -> RichText {
    if changes == 0 {
        RichText::new(title).color(TEXT)
    } else {
        RichText::new(format!("{title} ({changes} changed)")).color(ACCENT)
    }
}

fn table(ui: &mut Ui, group: &mut dyn ConstantGroup) -> bool {
    let mut edited = false;
    ui.spacing_mut().item_spacing.y = 2.0;
    for (row, info) in group.info().iter().enumerate() {
        if let Some(value) = group.value_mut(row) {
            edited |= constant(ui, info, value);
        }
    }
    edited
}

fn constant(ui: &mut Ui, info: &ConstantInfo, value: &mut f64) -> bool {
    let mut edited = false;
    let size = vec2(ui.available_width(), 20.0);
    ui.allocate_ui_with_layout(size, Layout::right_to_left(Align::Center), |ui| {
        ui.spacing_mut().interact_size.x = 66.0;
        let speed = (info.highest - info.lowest) / STEPS;
        let number = look::number(value, info.lowest..=info.highest, speed).max_decimals(4);
        edited |= ui.add(number).on_hover_ui(|ui| explain(ui, info)).changed();
        let differs = *value != info.default;
        let reset = Button::new("↺").frame(false).min_size(vec2(18.0, 18.0));
        if differs && ui.add(reset).on_hover_text("Back to the default").clicked() {
            *value = info.default;
            edited = true;
        }
        let size = ui.available_size();
        let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
        let color = if differs { ACCENT } else { TEXT };
        let font = FontId::proportional(12.5);
        let left = rect.left_center();
        let painter = ui.painter();
        let named = painter.text(left, Align2::LEFT_CENTER, heading(info.name), font, color);
        let unit = painter.layout_no_wrap(info.unit.into(), FontId::proportional(11.0), FAINT);
        // Long units stand in the hint alone.
        if named.right() + 8.0 + unit.size().x < rect.right() {
            let corner = rect.right_center() - vec2(unit.size().x + 2.0, 0.5 * unit.size().y);
            painter.galley(corner, unit, FAINT);
        }
        response.on_hover_ui(|ui| explain(ui, info));
    });
    edited
}

fn explain(ui: &mut Ui, info: &ConstantInfo) {
    ui.label(info.doc);
    ui.weak(format!(
        "{} to {} {}, by default {}",
        info.lowest, info.highest, info.unit, info.default
    ));
}

/// The name of a field for people.
fn heading(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| {
        first
            .to_uppercase()
            .chain(letters.map(|letter| if letter == '_' { ' ' } else { letter }))
            .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_counted() {
        let mut constants = Constants::default();
        let count = |constants: &Constants| -> usize {
            constants.groups().into_iter().map(differing).sum()
        };
        assert_eq!(count(&constants), 0);
        constants.step.courant = 0.2;
        constants.plates.basin = 0.0;
        assert_eq!(count(&constants), 2);
        assert_eq!(differing(&constants.step), 1);
        assert_eq!(heading("arc_flux"), "Arc flux");
    }
}
