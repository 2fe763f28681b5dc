//! How the panel looks, and the pieces it is made of.

use bevy_egui::egui::{
    self, Align2, Button, Color32, CornerRadius, DragValue, FontFamily, FontId, Frame, Margin,
    Response, Sense, Slider, SliderClamping, Stroke, Style, TextStyle, Ui, Vec2, WidgetInfo,
    WidgetText, WidgetType,
    collapsing_header::CollapsingState,
    emath::Numeric,
    style::{HandleShape, StyleModifier, WidgetVisuals},
    vec2,
};
use core::ops::RangeInclusive;

pub(super) const GROUND: Color32 = Color32::from_rgb(20, 24, 31);
const HEADER: Color32 = Color32::from_rgb(30, 36, 46);
const HEADER_HOVERED: Color32 = Color32::from_rgb(37, 45, 57);
const WELL: Color32 = Color32::from_rgb(13, 16, 21);
const WIDGET: Color32 = Color32::from_rgb(42, 50, 63);
pub(super) const LINE: Color32 = Color32::from_rgb(47, 55, 68);
pub(super) const TEXT: Color32 = Color32::from_rgb(206, 214, 224);
pub(super) const BRIGHT: Color32 = Color32::from_rgb(240, 244, 248);
pub(super) const FAINT: Color32 = Color32::from_rgb(128, 140, 156);
pub(super) const ACCENT: Color32 = Color32::from_rgb(88, 166, 230);
pub(super) const WARM: Color32 = Color32::from_rgb(236, 178, 92);
pub(super) const GOOD: Color32 = Color32::from_rgb(106, 196, 132);
pub(super) const BAD: Color32 = Color32::from_rgb(242, 106, 94);

/// Width of the column of names.
const NAMES: f32 = 94.0;
/// Height of a row.
const ROW: f32 = 20.0;
/// Width of the button with the dice.
pub(super) const DICE: f32 = 32.0;
/// Width of the number beside a slider.
const NUMBER: f32 = 76.0;

/// The panel's own style, whatever the game's is.
pub(super) fn style(style: &mut Style) {
    let font = |size| FontId::new(size, FontFamily::Proportional);
    style.text_styles.insert(TextStyle::Body, font(13.0));
    style.text_styles.insert(TextStyle::Button, font(13.0));
    style.text_styles.insert(TextStyle::Small, font(11.0));
    style.text_styles.insert(TextStyle::Heading, font(19.0));
    let spacing = &mut style.spacing;
    spacing.item_spacing = vec2(6.0, 4.0);
    spacing.button_padding = vec2(8.0, 2.0);
    spacing.interact_size = vec2(NUMBER, ROW);
    spacing.slider_rail_height = 4.0;
    spacing.icon_width = 14.0;
    spacing.icon_width_inner = 8.0;
    spacing.tooltip_width = 280.0;
    spacing.scroll = egui::style::ScrollStyle::thin();

    let visuals = &mut style.visuals;
    *visuals = egui::Visuals::dark();
    visuals.panel_fill = GROUND;
    visuals.window_fill = HEADER;
    visuals.window_stroke = Stroke::new(1.0, LINE);
    visuals.extreme_bg_color = WELL;
    visuals.faint_bg_color = HEADER;
    visuals.weak_text_color = Some(FAINT);
    visuals.warn_fg_color = WARM;
    visuals.error_fg_color = BAD;
    visuals.selection.bg_fill = Color32::from_rgb(38, 92, 138);
    visuals.selection.stroke = Stroke::new(1.0, BRIGHT);
    visuals.slider_trailing_fill = true;
    visuals.handle_shape = HandleShape::Rect { aspect_ratio: 0.4 };
    let widget = |fill, outline, text| WidgetVisuals {
        bg_fill: fill,
        weak_bg_fill: fill,
        bg_stroke: Stroke::new(1.0, outline),
        corner_radius: CornerRadius::same(4),
        fg_stroke: Stroke::new(1.0, text),
        expansion: 0.0,
    };
    visuals.widgets.noninteractive = widget(GROUND, LINE, TEXT);
    visuals.widgets.inactive = widget(WIDGET, Color32::TRANSPARENT, TEXT);
    visuals.widgets.hovered = widget(Color32::from_rgb(54, 64, 80), ACCENT, BRIGHT);
    visuals.widgets.active = widget(Color32::from_rgb(38, 92, 138), ACCENT, BRIGHT);
    visuals.widgets.open = widget(WIDGET, LINE, BRIGHT);
}

/// A part of the panel that can be folded away. The summary stands in its header while it is.
pub(super) fn section(
    ui: &mut Ui,
    title: &str,
    open: bool,
    summary: &str,
    body: impl FnOnce(&mut Ui),
) {
    let id = ui.make_persistent_id(title);
    let mut state = CollapsingState::load_with_default_open(ui.ctx(), id, open);
    let size = vec2(ui.available_width(), 26.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    if response.clicked() {
        state.toggle(ui);
    }
    response.widget_info(|| {
        WidgetInfo::selected(WidgetType::CollapsingHeader, true, state.is_open(), title)
    });
    if ui.is_rect_visible(rect) {
        let fill = if response.hovered() {
            HEADER_HOVERED
        } else {
            HEADER
        };
        let painter = ui.painter();
        painter.rect_filled(rect, 5, fill);
        let left = rect.left_center();
        let font = FontId::proportional(13.0);
        painter.text(
            left + vec2(24.0, 0.0),
            Align2::LEFT_CENTER,
            title,
            font,
            BRIGHT,
        );
        let font = FontId::proportional(12.0);
        let right = rect.right_center() - vec2(9.0, 0.0);
        if !state.is_open() {
            painter.text(right, Align2::RIGHT_CENTER, summary, font, FAINT);
        }
        let mut icon = response;
        icon.rect = egui::Rect::from_center_size(left + vec2(13.0, 0.0), Vec2::splat(9.0));
        let openness = state.openness(ui.ctx());
        egui::collapsing_header::paint_default_icon(ui, openness, &icon);
    }
    state.show_body_unindented(ui, |ui| {
        Frame::new()
            .inner_margin(Margin {
                left: 8,
                right: 4,
                top: 3,
                bottom: 7,
            })
            .show(ui, |ui| {
                ui.set_width(ui.available_width());
                body(ui);
            });
    });
}

/// A line of what belongs together within a section.
pub(super) fn caption(ui: &mut Ui, text: &str) {
    ui.add_space(3.0);
    ui.label(egui::RichText::new(text).size(11.0).color(FAINT));
}

/// The same, and at its right what lines are called, in their colours.
pub(super) fn caption_with(ui: &mut Ui, text: &str, lines: &[(&str, Color32)]) {
    ui.add_space(3.0);
    let size = vec2(ui.available_width(), 15.0);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter();
    let font = FontId::proportional(11.0);
    painter.text(
        rect.left_center(),
        Align2::LEFT_CENTER,
        text,
        font.clone(),
        FAINT,
    );
    let mut right = rect.right_center();
    for (name, color) in lines.iter().rev() {
        let used = painter.text(right, Align2::RIGHT_CENTER, name, font.clone(), *color);
        right.x = used.left() - 8.0;
    }
}

/// A name, and beside it what can be changed. The hint appears over the name.
pub(super) fn row<R>(ui: &mut Ui, name: &str, hint: &str, add: impl FnOnce(&mut Ui) -> R) -> R {
    ui.horizontal(|ui| {
        let (rect, response) = ui.allocate_exact_size(vec2(NAMES, ROW), Sense::hover());
        let color = if ui.is_enabled() { TEXT } else { FAINT };
        let font = FontId::proportional(13.0);
        ui.painter()
            .text(rect.left_center(), Align2::LEFT_CENTER, name, font, color);
        if !hint.is_empty() {
            response.on_hover_text(hint);
        }
        add(ui)
    })
    .inner
}

/// A slider over the rest of the row, with its number.
pub(super) fn slider<'a, N: Numeric>(
    ui: &mut Ui,
    value: &'a mut N,
    range: RangeInclusive<N>,
    adjust: impl FnOnce(Slider<'a>) -> Slider<'a>,
) -> bool {
    let width = ui.available_width() - NUMBER - ui.spacing().item_spacing.x;
    ui.spacing_mut().slider_width = width.max(30.0);
    // What a game has set stays as it is until someone touches it.
    let slider = Slider::new(value, range).clamping(SliderClamping::Edits);
    ui.add(adjust(slider)).changed()
}

/// A slider for a share, in per cent.
pub(super) fn share(ui: &mut Ui, value: &mut f64, range: RangeInclusive<f64>) -> bool {
    slider(ui, value, range, |slider| {
        slider
            .custom_formatter(|share, _| format!("{:.1}", 100.0 * share))
            .custom_parser(|text| {
                let text = text.trim().trim_end_matches('%');
                text.trim().parse().ok().map(|percent: f64| percent / 100.0)
            })
            .suffix(" %")
    })
}

/// A number to drag or to type.
pub(super) fn number<'a, N: Numeric>(
    value: &'a mut N,
    range: RangeInclusive<N>,
    speed: f64,
) -> DragValue<'a> {
    DragValue::new(value)
        .range(range)
        .clamp_existing_to_range(false)
        .speed(speed)
}

/// Choices side by side, one of which is taken. True if another one was.
pub(super) fn choose<T: PartialEq + Copy>(
    ui: &mut Ui,
    value: &mut T,
    choices: &[(T, &str, &str)],
) -> bool {
    let mut changed = false;
    for &(choice, name, hint) in choices {
        let taken = *value == choice;
        let response = ui.add(chip(taken, name));
        let response = if hint.is_empty() {
            response
        } else {
            response.on_hover_text(hint)
        };
        if response.clicked() && !taken {
            *value = choice;
            changed = true;
        }
    }
    changed
}

/// A small button that is in or out.
pub(super) fn chip(taken: bool, name: &str) -> Button<'_> {
    Button::selectable(taken, name)
        .frame_when_inactive(true)
        .min_size(vec2(0.0, ROW))
}

/// A switch with its name.
pub(super) fn switch(ui: &mut Ui, on: &mut bool, name: &str, hint: &str) -> bool {
    ui.checkbox(on, name).on_hover_text(hint).changed()
}

/// A button as wide as a share of what is available.
pub(super) fn button(
    ui: &mut Ui,
    enabled: bool,
    width: f32,
    text: impl Into<WidgetText>,
) -> Response {
    let button = Button::new(text.into()).min_size(vec2(width, 24.0));
    ui.add_enabled(enabled, button)
}

/// The button of what a section is there for.
pub(super) fn main_button(ui: &mut Ui, enabled: bool, width: f32, text: &str) -> Response {
    let text = egui::RichText::new(text).color(BRIGHT);
    let button = Button::new(text)
        .fill(Color32::from_rgb(38, 92, 138))
        .min_size(vec2(width, 24.0));
    ui.add_enabled(enabled, button)
}

/// A small light that tells a state.
pub(super) fn light(ui: &mut Ui, color: Color32) {
    let (rect, _) = ui.allocate_exact_size(vec2(10.0, ROW), Sense::hover());
    let painter = ui.painter();
    painter.circle_filled(rect.center(), 6.0, color.gamma_multiply(0.2));
    painter.circle_filled(rect.center(), 3.5, color);
}

/// A button with the five of a dice: not every font has one.
pub(super) fn dice(ui: &mut Ui, hint: &str) -> Response {
    let button = Button::new("").min_size(vec2(DICE, ROW));
    let response = ui.add(button).on_hover_text(hint);
    let color = ui.style().interact(&response).fg_stroke.color;
    let centre = response.rect.center();
    let painter = ui.painter();
    let square = egui::Rect::from_center_size(centre, Vec2::splat(14.0));
    let line = Stroke::new(1.2, color);
    painter.rect_stroke(square, 3, line, egui::StrokeKind::Inside);
    for (x, y) in [
        (-1.0, -1.0),
        (1.0, -1.0),
        (0.0, 0.0),
        (-1.0, 1.0),
        (1.0, 1.0),
    ] {
        painter.circle_filled(centre + 3.6 * vec2(x, y), 1.2, color);
    }
    response
}

/// A row of a table that is only read: a name, a figure, and one to compare it with.
pub(super) fn fact(ui: &mut Ui, name: &str, figure: &str, beside: Option<&str>) -> Response {
    let size = vec2(ui.available_width(), 17.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    if ui.is_rect_visible(rect) {
        let painter = ui.painter();
        let font = FontId::proportional(12.5);
        let left = rect.left_center();
        painter.text(left, Align2::LEFT_CENTER, name, font.clone(), FAINT);
        if let Some(beside) = beside {
            let right = rect.right_center();
            let middle = right - vec2(108.0, 0.0);
            painter.text(middle, Align2::RIGHT_CENTER, figure, font.clone(), BRIGHT);
            painter.text(right, Align2::RIGHT_CENTER, beside, font, FAINT);
        } else {
            let start = left + vec2(NAMES + ui.spacing().item_spacing.x, 0.0);
            painter.text(start, Align2::LEFT_CENTER, figure, font, BRIGHT);
        }
    }
    response
}

/// A sentence about what went wrong.
pub(super) fn complaint(ui: &mut Ui, text: &str) {
    Frame::new()
        .fill(BAD.gamma_multiply(0.14))
        .stroke(Stroke::new(1.0, BAD.gamma_multiply(0.5)))
        .corner_radius(4)
        .inner_margin(Margin::symmetric(8, 5))
        .show(ui, |ui| {
            ui.set_width(ui.available_width());
            ui.colored_label(BAD, text);
        });
}

/// The style of what pops up over the panel.
pub(super) fn popup_style() -> StyleModifier {
    StyleModifier::new(style)
}
