//! Live charts: where the ground lies, and how plates move.

use super::look::{self, ACCENT, FAINT, GOOD, LINE};
use super::record::{self, BIN_KM, Record};
use crate::simulation::Statistics;
use bevy_egui::egui::{Color32, FontId, Stroke, Ui, Vec2b, vec2};
use egui_plot::{
    Axis, AxisHints, Bar, BarChart, GridInput, GridMark, HLine, HoverPosition, Line, LineStyle,
    Plot, PlotPoint, PlotPoints,
};

/// Elevations in km that the charts show.
const LOWEST_KM: f64 = -9.0;
const HIGHEST_KM: f64 = 7.0;
/// Earth's colour.
const EARTH: Color32 = Color32::from_rgb(168, 130, 74);
/// Heights of the charts.
const TALL: f32 = 168.0;
const LOW: f32 = 96.0;

/// Draws the section.
pub(super) fn show(ui: &mut Ui, record: &Record) {
    if record.bins.is_empty() {
        ui.weak("There is no surface yet.");
        return;
    }
    let half = 0.5 * (ui.available_width() - ui.spacing().item_spacing.x);
    ui.horizontal(|ui| {
        for (title, lines, draw) in [
            (
                "Share of each 500 m",
                &[][..],
                bins as fn(&mut Ui, &Record, f32),
            ),
            (
                "Share above",
                &[("here", ACCENT), ("Earth", EARTH)][..],
                above,
            ),
        ] {
            ui.vertical(|ui| {
                ui.set_max_width(half);
                look::caption_with(ui, title, lines);
                draw(ui, record, half);
            });
        }
    });
    if record.mean_speed.len() < 2 {
        return;
    }
    let lines = [("mean", ACCENT), ("median", GOOD)];
    look::caption_with(ui, "Speed of plates, mm/yr", &lines);
    speeds(ui, record);
    look::caption(ui, "Number of plates");
    plates(ui, record);
}

/// A chart that is looked at, not moved: the wheel scrolls the panel.
fn plot<'a>(id: &'static str, height: f32) -> Plot<'a> {
    Plot::new(id)
        .height(height)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_axis_zoom_drag(false)
        .allow_double_click_reset(false)
        .grid_color(LINE)
        .grid_fade(0.0)
        .set_margin_fraction(vec2(0.0, 0.05))
}

/// An axis with small labels, a unit after each, no closer than so many pixels.
fn axis<'a>(axis: Axis, unit: &'static str, apart: f32) -> Vec<AxisHints<'a>> {
    let hints = match axis {
        Axis::X => AxisHints::new_x(),
        Axis::Y => AxisHints::new_y().min_thickness(30.0),
    };
    vec![
        hints
            .formatter(move |mark, _| format!("{:.0}{unit}", mark.value).replace('-', "−"))
            .label_spacing(apart..=apart + 4.0)
            .tick_label_font(FontId::proportional(10.5))
            .tick_label_color(FAINT),
    ]
}

/// A step of 1, 2 or 5 tens, hundreds, … that parts a range into so many pieces or fewer.
fn round_step((from, to): (f64, f64), pieces: f64) -> f64 {
    let least = (to - from) / pieces;
    let mut step = 1.0;
    while step < least && step < 1e9 {
        for factor in [2.0, 2.5, 2.0] {
            if step < least {
                step *= factor;
            }
        }
    }
    step
}

/// Marks at all multiples of a step.
fn every<'a>(step: f64) -> impl Fn(GridInput) -> Vec<GridMark> + 'a {
    move |input| {
        let (from, to) = input.bounds;
        let marks = (from / step).ceil() as i32..=(to / step).floor() as i32;
        // Whatever the figures are, a chart has room for few.
        marks
            .take(64)
            .map(|i| GridMark {
                value: step * f64::from(i),
                step_size: step,
            })
            .collect()
    }
}

fn heights<'a>(id: &'static str, width: f32, step: f64) -> Plot<'a> {
    plot(id, TALL)
        .width(width)
        .include_x(0.0)
        .auto_bounds(Vec2b::new(true, false))
        .default_y_bounds(LOWEST_KM, HIGHEST_KM)
        .custom_x_axes(axis(Axis::X, " %", 24.0))
        .custom_y_axes(axis(Axis::Y, " km", 12.0))
        .x_grid_spacer(every(step))
        .y_grid_spacer(every(2.0))
        .label_formatter(|position| {
            let point = point(position);
            Some(format!("{:.1} km: {:.1} %", point.y, point.x).replace('-', "−"))
        })
}

fn point(position: &HoverPosition<'_>) -> PlotPoint {
    match position {
        HoverPosition::NearDataPoint { position, .. } | HoverPosition::Elsewhere { position } => {
            *position
        }
    }
}

/// Earth is there to compare with, and stays in the background.
fn earth() -> Stroke {
    Stroke::new(1.2, EARTH)
}

fn sea_level() -> HLine {
    HLine::new("", 0.0)
        .color(ACCENT.gamma_multiply(0.6))
        .style(LineStyle::dashed_dense())
        .allow_hover(false)
}

fn bins(ui: &mut Ui, record: &Record, width: f32) {
    let land = Color32::from_rgb(124, 168, 96);
    let sea = Color32::from_rgb(66, 118, 176);
    let bars = record.bins.iter().map(|bin| {
        Bar::new(bin.x, bin.y)
            .width(0.46)
            .fill(if bin.x < 0.0 { sea } else { land })
            .stroke(Stroke::NONE)
    });
    let bars = BarChart::new("", bars.collect())
        .horizontal()
        .allow_hover(false);
    let shares = (0..).zip(Statistics::EARTH_HYPSOMETRY_500_M);
    let steps = shares.flat_map(|(i, share)| {
        let low = record::LOWEST_KM + BIN_KM * f64::from(i);
        [[100.0 * share, low], [100.0 * share, low + BIN_KM]]
    });
    let earth = Line::new("Earth", steps.collect::<PlotPoints<'_>>()).stroke(earth());
    heights("bins", width, 10.0)
        .include_x(16.0)
        .show(ui, |plot| {
            plot.bar_chart(bars);
            plot.line(earth.allow_hover(false));
            plot.hline(sea_level());
        });
}

fn above(ui: &mut Ui, record: &Record, width: f32) {
    let mut higher: f64 = 100.0;
    let mut steps = vec![[higher, record::LOWEST_KM]];
    for (i, share) in (1..).zip(Statistics::EARTH_HYPSOMETRY_500_M) {
        higher -= 100.0 * share;
        steps.push([higher.max(0.0), record::LOWEST_KM + BIN_KM * f64::from(i)]);
    }
    let earth = Line::new("Earth", PlotPoints::new(steps)).stroke(earth());
    let here = Line::new("Here", &record.above[..]).stroke(Stroke::new(2.0, ACCENT));
    heights("above", width, 25.0)
        // Room for half of the last label.
        .include_x(107.0)
        .show_axes(Vec2b::new(true, false))
        .show(ui, |plot| {
            plot.line(earth.allow_hover(false));
            plot.line(here);
            plot.hline(sea_level());
        });
}

/// Time runs to the right in both charts over time.
fn over_time<'a>(id: &'static str, unit: &'static str) -> Plot<'a> {
    plot(id, LOW)
        .include_y(0.0)
        .custom_x_axes(axis(Axis::X, " My", 48.0))
        .custom_y_axes(axis(Axis::Y, "", 12.0))
        .x_grid_spacer(|input| every(round_step(input.bounds, 4.0))(input))
        .y_grid_spacer(|input| every(round_step(input.bounds, 3.0))(input))
        .label_formatter(move |position| {
            let point = point(position);
            Some(format!("{:.0} My: {:.1} {unit}", point.x, point.y))
        })
}

fn speeds(ui: &mut Ui, record: &Record) {
    let mean = Line::new("mean", &record.mean_speed[..]).stroke(Stroke::new(1.6, ACCENT));
    let median = Line::new("median", &record.median_speed[..]).stroke(Stroke::new(1.6, GOOD));
    over_time("speeds", "mm/yr").show(ui, |plot| {
        plot.line(mean);
        plot.line(median);
    });
}

fn plates(ui: &mut Ui, record: &Record) {
    let line = Line::new("plates", &record.plates[..]).stroke(Stroke::new(1.6, FAINT));
    over_time("plates", "plates").show(ui, |plot| plot.line(line));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round() {
        assert_eq!(round_step((0.0, 2.0), 4.0), 1.0);
        assert_eq!(round_step((0.0, 60.0), 3.0), 20.0);
        assert_eq!(round_step((0.0, 250.0), 4.0), 100.0);
        assert_eq!(round_step((-100.0, 9900.0), 4.0), 5000.0);
        assert_eq!(round_step((0.0, f64::INFINITY), 4.0), 1e9);
        assert_eq!(round_step((f64::NAN, 1.0), 4.0), 1.0);
    }
}
