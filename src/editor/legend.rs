//! What the colours of an overlay mean.

use super::look::{self, FAINT, LINE, TEXT};
use crate::surface::{Legend, LegendEntry, Overlay};
use bevy_egui::egui::{
    Align2, Color32, FontId, Grid, Mesh, Rect, Sense, Shape, Stroke, StrokeKind, Ui, pos2, vec2,
};

/// Kinds beyond this many stand in three columns.
const MANY: usize = 12;
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
            self.0.push((overlay, legend_of(overlay)));
            self.0.len() - 1
        });
        &self.0[at].1
    }
}

/// The one place that asks for a legend.
fn legend_of(overlay: Overlay) -> Legend {
    // PLUG: `overlay.legend()`.
    stub(overlay)
}

/// Draws a legend: swatches, or the bar of a scale.
pub(super) fn show(ui: &mut Ui, legend: &Legend) {
    if legend.entries.is_empty() {
        return;
    }
    if legend.unit.is_empty() {
        look::caption(ui, legend.title);
    } else {
        look::caption(ui, &format!("{}, {}", legend.title, legend.unit));
    }
    if legend.scale && legend.entries.len() > 1 {
        scale(ui, &legend.entries);
    } else {
        swatches(ui, legend);
    }
}

fn color(entry: &LegendEntry) -> Color32 {
    let [r, g, b] = entry.color;
    Color32::from_rgb(r, g, b)
}

fn swatches(ui: &mut Ui, legend: &Legend) {
    let columns = match legend.entries.len() {
        0..=2 => 1,
        3..=MANY => 2,
        _ => 3,
    };
    let gap = 6.0;
    let width = (ui.available_width() - gap * (columns - 1) as f32) / columns as f32;
    Grid::new(("legend", legend.title))
        .spacing(vec2(gap, 2.0))
        .min_row_height(15.0)
        .show(ui, |ui| {
            for row in legend.entries.chunks(columns) {
                for entry in row {
                    let (rect, _) = ui.allocate_exact_size(vec2(width, 15.0), Sense::hover());
                    let square = Rect::from_center_size(
                        rect.left_center() + vec2(6.0, 0.0),
                        vec2(12.0, 12.0),
                    );
                    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
                    painter.rect(
                        square,
                        2,
                        color(entry),
                        Stroke::new(1.0, LINE),
                        StrokeKind::Inside,
                    );
                    painter.text(
                        rect.left_center() + vec2(18.0, 0.0),
                        Align2::LEFT_CENTER,
                        &entry.label,
                        FontId::proportional(11.5),
                        TEXT,
                    );
                }
                ui.end_row();
            }
        });
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

/// Stands in until overlays explain themselves.
fn stub(overlay: Overlay) -> Legend {
    let (unit, scale, entries): (_, _, &[([u8; 3], &str)]) = match overlay {
        Overlay::Age => (
            "My",
            true,
            &[
                ([190, 20, 30], "0"),
                ([240, 150, 40], "40"),
                ([250, 230, 90], "80"),
                ([90, 190, 110], "120"),
                ([40, 90, 190], "180"),
            ],
        ),
        _ => (
            "",
            false,
            &[
                ([200, 60, 50], "one kind"),
                ([60, 140, 200], "another kind"),
                ([200, 180, 80], "a third kind"),
            ],
        ),
    };
    Legend {
        title: overlay.name(),
        unit,
        entries: entries
            .iter()
            .map(|&(color, label)| LegendEntry {
                color,
                label: label.into(),
            })
            .collect(),
        scale,
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
                assert_eq!(legends.of(overlay).title, legend_of(overlay).title);
            }
        }
        assert_eq!(legends.0.len(), Overlay::ALL.len());
    }
}
