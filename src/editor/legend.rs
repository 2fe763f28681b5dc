//! What the colours of an overlay mean.

use super::look::{self, FAINT, LINE, TEXT};
use crate::surface::{Legend, LegendEntry, Overlay};
use bevy_egui::egui::{
    Color32, FontId, Mesh, Rect, RichText, Sense, Shape, Stroke, StrokeKind, Ui, Vec2, pos2, vec2,
};

/// Columns of kinds.
const MOST_COLUMNS: usize = 3;
/// Size of a swatch, and height of its line.
const SQUARE: f32 = 12.0;
const LINE_HEIGHT: f32 = 16.0;
/// Height of the bar of a scale.
const BAR: f32 = 12.0;

/// Legends once made: they never change.
#[derive(Debug, Default)]
pub(super) struct Legends(Vec<(Overlay, Legend)>);

impl Legends {
    /// The legend of an overlay.
    pub(super) fn of(&mut self, overlay: Overlay) -> &Legend {
        let at = self.0.iter().position(|(known, _)| *known == overlay);
        let at = at.unwrap_or_else(|| {
            self.0.push((overlay, overlay.legend()));
            self.0.len() - 1
        });
        &self.0[at].1
    }
}

/// Draws a legend: swatches, or the bar of a scale.
pub(super) fn show(ui: &mut Ui, legend: &Legend) {
    if legend.unit.is_empty() {
        look::caption(ui, legend.title);
    } else {
        look::caption(ui, &format!("{}, {}", legend.title, legend.unit));
    }
    if legend.scale && legend.entries.len() > 1 {
        scale(ui, &legend.entries);
    } else {
        swatches(ui, &legend.entries);
    }
    swatches(ui, &legend.others);
    if legend.entries.is_empty() {
        ui.label(RichText::new("Colours only tell neighbours apart.").small());
    }
}

fn color(entry: &LegendEntry) -> Color32 {
    let [r, g, b] = entry.color;
    Color32::from_rgb(r, g, b)
}

/// Kinds in as many columns as their labels leave room for.
fn swatches(ui: &mut Ui, entries: &[LegendEntry]) {
    let painter = ui.painter().clone();
    let galleys = entries.iter().map(|entry| {
        let font = FontId::proportional(11.5);
        painter.layout_no_wrap(entry.label.clone(), font, TEXT)
    });
    let galleys: Vec<_> = galleys.collect();
    let widest = galleys
        .iter()
        .map(|galley| galley.size().x)
        .fold(0.0, f32::max);
    let room = ui.available_width() / (widest + SQUARE + 14.0);
    let columns = (room as usize).clamp(1, MOST_COLUMNS);
    // Read downwards, as they are ordered.
    let rows = entries.len().div_ceil(columns);
    let size = vec2(ui.available_width(), rows as f32 * LINE_HEIGHT);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    if !ui.is_rect_visible(rect) {
        return;
    }
    let painter = painter.with_clip_rect(rect.intersect(ui.clip_rect()));
    let width = rect.width() / columns as f32;
    for (i, (entry, galley)) in entries.iter().zip(galleys).enumerate() {
        let corner = vec2((i / rows) as f32 * width, (i % rows) as f32 * LINE_HEIGHT);
        let corner = rect.min + corner;
        let square = Rect::from_min_size(corner + vec2(0.0, 2.0), Vec2::splat(SQUARE));
        let line = Stroke::new(1.0, LINE);
        painter.rect(square, 2, color(entry), line, StrokeKind::Inside);
        let height = 0.5 * (LINE_HEIGHT - galley.size().y);
        painter.galley(corner + vec2(SQUARE + 6.0, height), galley, TEXT);
    }
}

/// A bar whose entries are evenly spaced, with as many labels as fit.
fn scale(ui: &mut Ui, entries: &[LegendEntry]) {
    let size = vec2(ui.available_width(), BAR + 20.0);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    if !ui.is_rect_visible(rect) {
        return;
    }
    let bar = Rect::from_min_size(rect.min, vec2(rect.width(), BAR));
    let last = entries.len() - 1;
    let at = |i: usize| bar.left() + bar.width() * i as f32 / last as f32;
    let mut mesh = Mesh::default();
    for (i, entry) in entries.iter().enumerate() {
        mesh.colored_vertex(pos2(at(i), bar.top()), color(entry));
        mesh.colored_vertex(pos2(at(i), bar.bottom()), color(entry));
        if i < last {
            let corner = 2 * i as u32;
            mesh.add_triangle(corner, corner + 1, corner + 2);
            mesh.add_triangle(corner + 1, corner + 3, corner + 2);
        }
    }
    let painter = ui.painter();
    painter.add(Shape::mesh(mesh));
    painter.rect_stroke(bar, 0, Stroke::new(1.0, LINE), StrokeKind::Outside);

    let label = |i: usize| {
        let font = FontId::proportional(11.0);
        let galley = painter.layout_no_wrap(entries[i].label.clone(), font, FAINT);
        // The outermost labels stay within the bar.
        let half = 0.5 * galley.size().x;
        let middle = at(i).clamp(
            bar.left() + half,
            (bar.right() - half).max(bar.left() + half),
        );
        (middle - half, middle + half, galley)
    };
    let (end, _, galley) = label(last);
    let top = bar.bottom() + 4.0;
    painter.galley(pos2(end, top), galley, FAINT);
    let mut free = f32::NEG_INFINITY;
    for i in 0..last {
        let (left, right, galley) = label(i);
        if left > free && right < end - 8.0 {
            let tick = [pos2(at(i), bar.bottom()), pos2(at(i), bar.bottom() + 3.0)];
            painter.line_segment(tick, Stroke::new(1.0, FAINT));
            painter.galley(pos2(left, top), galley, FAINT);
            free = right + 8.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn legends_are_made_once() {
        let mut legends = Legends::default();
        for _ in 0..2 {
            for overlay in Overlay::ALL {
                assert_eq!(legends.of(overlay).title, overlay.legend().title);
            }
        }
        assert_eq!(legends.0.len(), Overlay::ALL.len());
    }
}
