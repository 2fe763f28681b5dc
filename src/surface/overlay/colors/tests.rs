use super::*;
use crate::surface::{Legend, LegendEntry};

const TABLES: [&Ramp; 7] = [AGE, THICKNESS, SPEED, SEA, LAND, ANDEAN, HIMALAYAN];
const ODD: [f32; 6] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    -1.0,
];

fn oklab([r, g, b]: [u8; 3]) -> Vec3 {
    let linear = Vec3::new(f32::from(r), f32::from(g), f32::from(b)) / 255.0;
    let linear = linear.map(|part| {
        if part <= 0.040_45 {
            part / 12.92
        } else {
            libm::powf((part + 0.055) / 1.055, 2.4)
        }
    });
    let cones = Vec3::new(
        linear.dot(Vec3::new(0.412_221_46, 0.536_332_55, 0.051_445_995)),
        linear.dot(Vec3::new(0.211_903_5, 0.680_699_5, 0.107_396_96)),
        linear.dot(Vec3::new(0.088_302_46, 0.281_718_85, 0.629_978_7)),
    );
    let cones = cones.map(libm::cbrtf);
    Vec3::new(
        cones.dot(Vec3::new(0.210_454_26, 0.793_617_8, -0.004_072_047)),
        cones.dot(Vec3::new(1.977_998_5, -2.428_592_2, 0.450_593_7)),
        cones.dot(Vec3::new(0.025_904_037, 0.782_771_77, -0.808_675_77)),
    )
}

fn difference(a: [u8; 3], b: [u8; 3]) -> f32 {
    oklab(a).distance(oklab(b))
}

/// Components of a look-up are bytes again where a table has an entry.
fn opaque([r, g, b]: [u8; 3]) -> [u8; 4] {
    [r, g, b, 255]
}

#[test]
fn tables_rise() {
    for table in TABLES {
        assert!(table.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }
}

#[test]
fn scales_have_about_equal_steps_and_rising_lightness() {
    for table in [THICKNESS, SPEED] {
        let steps = table.windows(2).map(|pair| {
            let [(low, a), (high, b)] = [pair[0], pair[1]];
            assert!(oklab(a).x < oklab(b).x, "{a:?} {b:?}");
            difference(a, b) / (high - low)
        });
        let (least, most) = steps.fold((f32::MAX, 0.0_f32), |(least, most), step| {
            (least.min(step), most.max(step))
        });
        assert!(most < 2.5 * least, "{least} {most}");
    }
}

#[test]
fn values_that_are_no_values_have_colours() {
    for overlay in Overlay::ALL {
        for odd in ODD {
            for crust in [Crust::Oceanic, Crust::Continental] {
                for orogeny in [Orogeny::None, Orogeny::Andean, Orogeny::Himalayan] {
                    let values = OverlayValues {
                        elevation: odd,
                        crust,
                        age: odd,
                        plate: u16::MAX,
                        thickness: odd,
                        speed: odd,
                        orogeny,
                        orogeny_age: odd,
                    };
                    let lines = matches!(overlay, Overlay::Boundaries | Overlay::Velocity);
                    assert_eq!(overlay.color(&values)[3] == 0, lines, "{overlay:?}");
                }
            }
        }
    }
    let first = |value: f32| OverlayValues {
        age: value,
        ..OverlayValues::default()
    };
    let age = |value: f32| Overlay::Age.color(&first(value));
    assert_eq!(age(f32::NAN), opaque(AGE[0].1));
    assert_eq!(age(-5.0), opaque(AGE[0].1));
    assert_eq!(age(f32::INFINITY), opaque(AGE[AGE.len() - 1].1));
}

#[test]
fn legends_have_the_colours_of_their_values() {
    for overlay in Overlay::ALL {
        let Legend {
            entries,
            scale,
            title,
            ..
        } = overlay.legend();
        assert_eq!(title, overlay.name());
        assert_eq!(entries.is_empty(), overlay == Overlay::Plates);
        let specimens = overlay.specimens();
        for (LegendEntry { color, label }, (name, values)) in entries.iter().zip(&specimens) {
            assert_eq!(label, name);
            assert_eq!(opaque(*color), overlay.color(values), "{overlay:?} {label}");
        }
        assert!(specimens.is_empty() || specimens.len() == entries.len());
        let labels: std::collections::BTreeSet<_> = entries.iter().map(|e| &e.label).collect();
        assert_eq!(labels.len(), entries.len());
        if !scale {
            continue;
        }
        // What a panel paints between two entries is what the ground shows.
        for (pair, ends) in specimens.windows(2).zip(entries.windows(2)) {
            let mean = |a: f32, b: f32| 0.5 * (a + b);
            let [a, b] = [pair[0].1, pair[1].1];
            let middle = overlay.color(&OverlayValues {
                age: mean(a.age, b.age),
                thickness: mean(a.thickness, b.thickness),
                speed: mean(a.speed, b.speed),
                ..a
            });
            for ((a, b), middle) in ends[0].color.into_iter().zip(ends[1].color).zip(middle) {
                let expected = mean(f32::from(a), f32::from(b));
                assert!((f32::from(middle) - expected).abs() <= 0.51);
            }
        }
    }
}

#[test]
fn legends_name_every_kind_of_boundary() {
    let legend = Overlay::Boundaries.legend();
    for kind in [
        BoundaryKind::Transform,
        BoundaryKind::Ridge,
        BoundaryKind::SubductingOrigin,
        BoundaryKind::SubductingDestination,
        BoundaryKind::Collision,
    ] {
        let color = boundary_color(kind);
        assert!(legend.entries.iter().any(|entry| entry.color == color));
    }
    let entries = legend.entries;
    for (i, a) in entries.iter().enumerate() {
        for b in &entries[..i] {
            assert!(difference(a.color, b.color) > 0.15, "{a:?} {b:?}");
        }
    }
}

#[test]
fn steps_of_elevation_can_be_seen() {
    let at = |elevation: f32| {
        Overlay::Elevation.color(&OverlayValues {
            elevation,
            ..OverlayValues::default()
        })
    };
    for step in STEPS.0..STEPS.1 {
        let edge = (step + 1) as f32 * STEP_M;
        let [below, above] = [at(edge - 1.0), at(edge)];
        assert_eq!(below, at(edge - STEP_M));
        let [a, b] = [below, above].map(|[r, g, b, _]| [r, g, b]);
        assert!(difference(a, b) > 0.024, "{edge} m: {}", difference(a, b));
    }
    assert_eq!(at(-1e6), at(-7_750.0));
    assert_eq!(at(1e6), at(6_750.0));
}

#[test]
fn plates_can_be_told_apart() {
    let mut least = f32::MAX;
    for id in 1..=60 {
        let here = plate_color(id);
        assert!(difference(here, plate_color(id + 1)) > 0.12, "{id}");
        for other in 1..id {
            least = least.min(difference(here, plate_color(other)));
        }
    }
    assert!(least > 0.04, "{least}");
}

#[test]
fn old_mountains_are_paler_than_young_ones() {
    for (kind, table) in [(Orogeny::Andean, ANDEAN), (Orogeny::Himalayan, HIMALAYAN)] {
        let chroma = |age: f32| {
            let [r, g, b, _] = Overlay::Orogeny.color(&OverlayValues {
                orogeny: kind,
                orogeny_age: age,
                ..OverlayValues::default()
            });
            oklab([r, g, b]).with_x(0.0).length()
        };
        assert!(
            table
                .windows(2)
                .all(|pair| chroma(pair[0].0) > chroma(pair[1].0))
        );
    }
}
