//! Where the time of a step goes.

use super::look::{ACCENT, FAINT, TEXT};
use bevy_egui::egui::{Align2, FontId, Rect, Sense, Ui, pos2, vec2};

/// Width of the names and of the figures.
const NAMES: f32 = 122.0;
const FIGURES: f32 = 96.0;

/// Milliseconds of a step, for the section's header.
pub(super) fn per_step_ms(stages: &[(&'static str, f64)], steps: u64) -> Option<f64> {
    let total: f64 = stages.iter().map(|(_, seconds)| seconds).sum();
    (steps > 0 && total > 0.0).then(|| 1000.0 * total / steps as f64)
}

/// Draws the section.
pub(super) fn show(ui: &mut Ui, stages: &[(&'static str, f64)], steps: u64) {
    let total: f64 = stages.iter().map(|(_, seconds)| seconds).sum();
    let longest = stages
        .iter()
        .map(|(_, seconds)| *seconds)
        .fold(0.0, f64::max);
    if total <= 0.0 || steps == 0 {
        ui.weak("No step has run yet.");
        return;
    }
    ui.spacing_mut().item_spacing.y = 1.0;
    for &(name, seconds) in stages {
        // The stages at both ends belong to the user and are mostly empty.
        let idle = matches!(name, "first" | "apply_events" | "last") && seconds < 1e-3 * total;
        if seconds <= 0.0 || idle {
            continue;
        }
        let size = vec2(ui.available_width(), 16.0);
        let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
        if ui.is_rect_visible(rect) {
            let share = seconds / total;
            let painter = ui.painter();
            let font = FontId::proportional(12.0);
            painter.text(
                rect.left_center(),
                Align2::LEFT_CENTER,
                title(name),
                font.clone(),
                TEXT,
            );
            let left = rect.left() + NAMES;
            let right = rect.right() - FIGURES;
            let length = (right - left).max(0.0) * (seconds / longest) as f32;
            let bar = Rect::from_min_max(
                pos2(left, rect.top() + 4.0),
                pos2(left + length.max(1.0), rect.bottom() - 4.0),
            );
            painter.rect_filled(bar, 2, ACCENT.gamma_multiply(0.8));
            let figure = format!("{:.2} ms", 1000.0 * seconds / steps as f64);
            let middle = rect.right_center() - vec2(42.0, 0.0);
            painter.text(middle, Align2::RIGHT_CENTER, figure, font.clone(), FAINT);
            let figure = format!("{:.0} %", 100.0 * share);
            painter.text(
                rect.right_center(),
                Align2::RIGHT_CENTER,
                figure,
                font,
                TEXT,
            );
        }
        response.on_hover_text("Mean time of the stage in a step, and its share.");
    }
}

/// A stage's name for people.
fn title(name: &str) -> String {
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
    fn stages_have_titles_and_means() {
        assert_eq!(title("classify_boundaries"), "Classify boundaries");
        assert_eq!(title(""), "");
        assert_eq!(
            per_step_ms(&[("move", 1.0), ("erode", 1.0)], 4),
            Some(500.0)
        );
        assert_eq!(per_step_ms(&[], 4), None);
        assert_eq!(per_step_ms(&[("move", 1.0)], 0), None);
    }
}
