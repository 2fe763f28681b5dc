//! What a planet measures, beside what Earth does.

use super::figures::{percent, tenth, tenth_in, whole, whole_in};
use super::look;
use crate::simulation::Statistics;
use bevy_egui::egui::Ui;

/// One line of the table: name, figure, Earth's, and what it means.
type Line = (
    &'static str,
    fn(&Statistics) -> String,
    &'static str,
    &'static str,
);

/// The table in groups.
const GROUPS: [(&str, &[Line]); 4] = [
    (
        "Heights",
        &[
            (
                "Land",
                |s| percent(s.land_share),
                "29 %",
                "Share of the sphere above the sea.",
            ),
            (
                "Highest",
                |s| whole_in(s.highest_m, "m"),
                "8,849 m",
                "Highest sub-plate; of Earth, the highest peak.",
            ),
            (
                "Lowest",
                |s| whole_in(s.lowest_m, "m"),
                "−10,935 m",
                "Lowest sub-plate; of Earth, the deepest trench.",
            ),
            (
                "Mean of land",
                |s| whole_in(s.mean_land_m, "m"),
                "850 m",
                "",
            ),
            (
                "Mean of sea floor",
                |s| whole_in(s.mean_ocean_m, "m"),
                "−3,730 m",
                "",
            ),
            (
                "Fullest of land",
                |s| whole_in(s.land_peak_m, "m"),
                "250 m",
                "Middle of the 500 m of elevation above −2,000 m that hold most.",
            ),
            (
                "Fullest of sea floor",
                |s| whole_in(s.ocean_peak_m, "m"),
                "−4,750 m",
                "Middle of the 500 m of elevation below −2,000 m that hold most.",
            ),
            (
                "Shelf",
                |s| percent(s.shelf_500_share),
                "7.2 %",
                "Share of the sphere between −500 m and the sea.",
            ),
            (
                "Above 2 km",
                |s| percent(s.above_2_km_share),
                "3.5 %",
                "Share of the sphere; of Earth, with its ice.",
            ),
            (
                "Below −6 km",
                |s| percent(s.below_6_km_share),
                "0.5 %",
                "Share of the sphere.",
            ),
            (
                "Ridges",
                |s| whole_in(s.ridge_median_m, "m"),
                "−3,000 m",
                "Median elevation of sea floor where plates part.",
            ),
            (
                "Dimension of coasts",
                |s| tenth(s.coastline_dimension),
                "1.2",
                "1 is a smooth line, 2 fills the plane.",
            ),
        ],
    ),
    (
        "Crust",
        &[
            (
                "Continental",
                |s| percent(s.continental_share),
                "41 %",
                "Share of continental crust, shelves included.",
            ),
            (
                "Its thickness",
                |s| tenth_in(s.continental_thickness_km, "km"),
                "30–40 km",
                "Mean thickness of continental crust.",
            ),
            (
                "Gathering",
                |s| percent(s.continental_concentration),
                "",
                "How far the continents lie on one side: 100 % if all were in one place.",
            ),
            (
                "Sea floor, mean age",
                |s| whole_in(s.ocean_age_mean_my, "My"),
                "60 My",
                "",
            ),
            (
                "Sea floor, oldest",
                |s| whole_in(s.ocean_age_oldest_my, "My"),
                "180 My",
                "A few relicts on Earth are up to 340 My old.",
            ),
            (
                "Sea floor made",
                |s| tenth_in(s.spreading_km2_yr, "km²/yr"),
                "3.0 km²/yr",
                "By the plates' motions now: opening of ridges times their length.",
            ),
            (
                "Sea floor consumed",
                |s| tenth_in(s.subduction_km2_yr, "km²/yr"),
                "2.7 km²/yr",
                "By the plates' motions now: closing of trenches times their length.",
            ),
        ],
    ),
    (
        "Plates",
        &[
            (
                "Number",
                |s| whole(s.plates as f64),
                "52",
                "38 of Earth's exceed 0.05 % of the sphere.",
            ),
            (
                "Largest",
                |s| percent(s.largest_plate),
                "21 %",
                "Share of the sphere.",
            ),
            (
                "Seven largest",
                |s| percent(s.largest_7_plates),
                "81 %",
                "Share of the sphere.",
            ),
            (
                "Median area",
                |s| whole_in(1e-3 * s.plate_area_median_km2, "thousand km²"),
                "500 thousand km²",
                "",
            ),
            (
                "Mean speed",
                |s| tenth_in(s.speed_mean, "mm/yr"),
                "38 mm/yr",
                "Over the area, without net rotation.",
            ),
            (
                "Median speed",
                |s| tenth_in(s.speed_median, "mm/yr"),
                "30 mm/yr",
                "Over the area, without net rotation.",
            ),
            (
                "Oceanic plates",
                |s| tenth_in(s.speed_oceanic_plates, "mm/yr"),
                "42 mm/yr",
                "Mean speed of plates that are mostly oceanic.",
            ),
            (
                "Continental plates",
                |s| tenth_in(s.speed_continental_plates, "mm/yr"),
                "25 mm/yr",
                "Mean speed of plates that are mostly continental.",
            ),
            (
                "Deforming",
                |s| percent(s.deforming_share),
                "14 %",
                "Share of the sphere that leaves its plate's rotation by over 1 mm/yr.",
            ),
        ],
    ),
    (
        "Boundaries",
        &[
            (
                "All",
                |s| whole_in(s.boundary_km, "km"),
                "260,000 km",
                "Length of the boundaries between plates.",
            ),
            (
                "Opening",
                |s| boundary(s, 0),
                "93,600 km",
                "Where plates part: ridges and rifts.",
            ),
            (
                "Sliding",
                |s| boundary(s, 1),
                "72,800 km",
                "Where plates slide past each other: transforms.",
            ),
            (
                "Closing",
                |s| boundary(s, 2),
                "91,000 km",
                "Where plates meet: trenches and collisions.",
            ),
            (
                "Slip of ridges",
                |s| tenth_in(s.slip_ridges, "mm/yr"),
                "47 mm/yr",
                "Mean along their length.",
            ),
            (
                "Slip of trenches",
                |s| tenth_in(s.slip_trenches, "mm/yr"),
                "62 mm/yr",
                "Mean along their length.",
            ),
            (
                "Slip of transforms",
                |s| tenth_in(s.slip_transforms, "mm/yr"),
                "41 mm/yr",
                "Mean along their length.",
            ),
            (
                "Slip of collisions",
                |s| tenth_in(s.slip_collisions, "mm/yr"),
                "26 mm/yr",
                "Mean along the length of closing continents.",
            ),
        ],
    ),
];

/// Length of a kind of boundary.
fn boundary(statistics: &Statistics, kind: usize) -> String {
    whole_in(
        statistics.boundary_km * statistics.boundary_shares[kind],
        "km",
    )
}

/// Draws the section.
pub(super) fn show(ui: &mut Ui, statistics: &Statistics) {
    ui.spacing_mut().item_spacing.y = 1.0;
    for (i, (title, lines)) in GROUPS.into_iter().enumerate() {
        if i > 0 {
            ui.add_space(4.0);
        }
        let beside = if i == 0 { "Earth" } else { "" };
        heading(ui, title, beside);
        for (name, figure, earth, hint) in lines {
            let response = look::fact(ui, name, &figure(statistics), Some(earth));
            if !hint.is_empty() {
                response.on_hover_text(*hint);
            }
        }
    }
}

fn heading(ui: &mut Ui, title: &str, beside: &str) {
    use bevy_egui::egui::{Align2, FontId, Sense, Stroke, vec2};
    let size = vec2(ui.available_width(), 18.0);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter();
    let font = FontId::proportional(11.0);
    painter.text(
        rect.left_center(),
        Align2::LEFT_CENTER,
        title,
        font.clone(),
        look::ACCENT,
    );
    painter.text(
        rect.right_center(),
        Align2::RIGHT_CENTER,
        beside,
        font,
        look::ACCENT,
    );
    painter.hline(rect.x_range(), rect.bottom(), Stroke::new(1.0, look::LINE));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_can_be_written() {
        let statistics = Statistics {
            boundary_km: 1000.0,
            boundary_shares: [0.5, 0.25, 0.25],
            ..Statistics::default()
        };
        for (_, lines) in GROUPS {
            for (name, figure, _, _) in lines {
                assert!(!figure(&statistics).is_empty(), "{name}");
            }
        }
        assert_eq!(boundary(&statistics, 0), "500 km");
    }
}
