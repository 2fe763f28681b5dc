//! Legends: the colours of chosen values, asked of the overlays themselves.

use super::colors::{
    AGE, ANDEAN, ARROW_COLOR, ARROW_LONGEST, ARROW_RADII, HIMALAYAN, SPEED, STEP_M, STEPS,
    THICKNESS,
};
use super::{Legend, LegendEntry, Overlay, OverlayValues, boundary_color};
use crate::simulation::{BoundaryKind, Crust, Orogeny};
use crate::surface::ramp::Ramp;

impl Overlay {
    /// What the colours mean. Plates have none: their colours only tell them apart.
    #[must_use]
    pub fn legend(self) -> Legend {
        let entry = |(label, values): (String, OverlayValues)| {
            let [red, green, blue, _] = self.color(&values);
            LegendEntry {
                color: [red, green, blue],
                label,
            }
        };
        let (unit, scale) = match self {
            Self::Age => ("My", true),
            Self::Thickness => ("km", true),
            Self::Speed => ("mm/yr", true),
            Self::Elevation => ("m", false),
            _ => ("", false),
        };
        let entries = match self {
            Self::Boundaries => lines(),
            Self::Velocity => arrows(),
            _ => self.specimens().into_iter().map(entry).collect(),
        };
        let others = match self {
            Self::Age => vec![entry(("Continents".into(), on_land(Orogeny::None, 0.0)))],
            _ => Vec::new(),
        };
        Legend {
            title: self.name(),
            unit,
            entries,
            scale,
            others,
        }
    }

    /// Places whose colours the legend shows, with what to call them.
    pub(super) fn specimens(self) -> Vec<(String, OverlayValues)> {
        let sea = OverlayValues::default();
        let points = |table: &Ramp, values: fn(f32) -> OverlayValues| {
            let points = table.iter();
            points
                .map(|&(value, _)| (value.to_string(), values(value)))
                .collect()
        };
        match self {
            Self::Plates | Self::Boundaries | Self::Velocity => Vec::new(),
            Self::Crust => vec![
                ("Oceanic".into(), sea),
                ("Continental".into(), on_land(Orogeny::None, 0.0)),
                (
                    "Continental, below the sea".into(),
                    OverlayValues {
                        crust: Crust::Continental,
                        elevation: -100.0,
                        ..sea
                    },
                ),
            ],
            Self::Age => points(AGE, |age| OverlayValues {
                age,
                ..OverlayValues::default()
            }),
            Self::Thickness => points(THICKNESS, |thickness| OverlayValues {
                thickness,
                ..OverlayValues::default()
            }),
            Self::Speed => points(SPEED, |speed| OverlayValues {
                speed,
                ..OverlayValues::default()
            }),
            Self::Elevation => (STEPS.0..=STEPS.1)
                .map(|step| {
                    let bottom = step as f32 * STEP_M;
                    let top = bottom + STEP_M;
                    let label = if step == STEPS.0 {
                        format!("below {top}")
                    } else if step == STEPS.1 {
                        format!("above {bottom}")
                    } else {
                        format!("{bottom} to {top}")
                    };
                    let elevation = bottom + 0.5 * STEP_M;
                    (label, OverlayValues { elevation, ..sea })
                })
                .collect(),
            Self::Orogeny => [
                ("Above a sinking plate", Orogeny::Andean, ANDEAN),
                ("Between continents", Orogeny::Himalayan, HIMALAYAN),
            ]
            .into_iter()
            .flat_map(|(name, kind, table)| {
                table.iter().map(move |&(age, _)| {
                    let label = if age > 0.0 {
                        format!("{name}, {age} My ago")
                    } else {
                        format!("{name}, now")
                    };
                    (label, on_land(kind, age))
                })
            })
            .chain([
                ("Never, land".into(), on_land(Orogeny::None, 0.0)),
                ("Never, sea floor".into(), sea),
            ])
            .collect(),
        }
    }
}

fn on_land(orogeny: Orogeny, orogeny_age: f32) -> OverlayValues {
    OverlayValues {
        elevation: 100.0,
        crust: Crust::Continental,
        orogeny,
        orogeny_age,
        ..OverlayValues::default()
    }
}

fn lines() -> Vec<LegendEntry> {
    [
        (BoundaryKind::Ridge, "Ridge or rift: plates part"),
        (BoundaryKind::Transform, "Transform: plates slide"),
        (
            BoundaryKind::SubductingOrigin,
            "Subduction: teeth point into the plate on top",
        ),
        (BoundaryKind::Collision, "Collision of continents"),
    ]
    .map(|(kind, label)| LegendEntry {
        color: boundary_color(kind),
        label: label.into(),
    })
    .into()
}

fn arrows() -> Vec<LegendEntry> {
    let degrees = |radii: f32| radii.to_degrees();
    vec![LegendEntry {
        color: ARROW_COLOR,
        label: format!(
            "100 mm/yr: {:.0}° of latitude long; {:.0} and more: {:.0}°",
            degrees(100.0 * ARROW_RADII),
            ARROW_LONGEST / ARROW_RADII,
            degrees(ARROW_LONGEST)
        ),
    }]
}
