//! Boundaries of plates as lines on the ground, drawn as geological maps draw them.

use super::chain::{Line, Piece, chain};
use super::drape::{Drape, Frame, Paint, STEP};
use crate::simulation::BoundaryKind;
use crate::surface::{BoundarySegment, OUTLINE, boundary_color};

/// Stretches shorter than this many steps are part of their neighbours.
const SPECK: usize = 3;
/// Width of the dark line on either side, in radii.
const CASING: f64 = 0.002;
/// A line of teeth has one in this many steps.
const TOOTH_STEPS: usize = 6;
/// Length of a tooth from its root within the line, and half its width, in radii.
const TOOTH: [f64; 2] = [0.018, 0.0105];
/// Where teeth are rooted, from the middle of the line, in radii.
const ROOT: f64 = 0.002;
/// Height of teeth above the line, in radii.
const ABOVE: f64 = 0.001;

impl From<&BoundarySegment> for Piece {
    fn from(segment: &BoundarySegment) -> Self {
        Self {
            ends: segment.ends,
            kind: segment.kind,
        }
    }
}

/// Lays the boundaries.
pub(super) fn lay(drape: &mut Drape, pieces: &[Piece]) {
    for mut line in chain(pieces) {
        line.smooth();
        for point in &mut line.points {
            *point = drape.raster().bend(*point);
        }
        let mut line = line.evened(STEP);
        line.tidy(SPECK);
        lay_line(drape, &line);
    }
}

fn lay_line(drape: &mut Drape, line: &Line) {
    let lefts = line.lefts();
    for (kind, from, to) in line.stretches() {
        for &(right, left, colored) in stripes(kind) {
            let paint = Paint::new(if colored {
                boundary_color(kind)
            } else {
                OUTLINE
            });
            let rows = (from..=to).map(|i| {
                let side = |offset: f64| (line.points[i] + lefts[i] * offset).normalize();
                [side(left), side(right)]
            });
            drape.strip(rows, paint);
        }
        // Teeth point into the plate on top: away from the one that goes under.
        let side = match kind {
            BoundaryKind::SubductingOrigin => -1.0,
            BoundaryKind::SubductingDestination => 1.0,
            _ => continue,
        };
        let steps = to - from;
        let count = (steps / TOOTH_STEPS).max(1);
        for tooth in 0..count {
            let i = from + steps * (2 * tooth + 1) / (2 * count);
            if let Some(frame) = Frame::new(line.points[i], lefts[i] * side) {
                let fill = Paint::new(boundary_color(kind)).above(ABOVE);
                let outline = Paint::new(OUTLINE).above(ABOVE);
                drape.figure(&frame, &tooth_profile(), false, fill, outline);
            }
        }
    }
}

/// Half the outline of a tooth.
fn tooth_profile() -> [([f64; 2], [f64; 2]); 2] {
    let [length, wide] = TOOTH;
    let slant = libm::hypot(length, wide);
    [
        ([ROOT, wide], [ROOT, wide + CASING * slant / length]),
        (
            [ROOT + length, 0.0],
            [ROOT + length + CASING * slant / wide, 0.0],
        ),
    ]
}

/// The stripes of a line: right and left edge in radii from the middle, and whether the stripe has the
/// colour of the kind or that of outlines.
fn stripes(kind: BoundaryKind) -> &'static [(f64, f64, bool)] {
    /// A single line of half this width.
    macro_rules! single {
        ($half:expr) => {
            &[
                (-$half - CASING, -$half, false),
                (-$half, $half, true),
                ($half, $half + CASING, false),
            ]
        };
    }
    match kind {
        BoundaryKind::Joined => &[],
        BoundaryKind::Transform => single!(0.0022),
        BoundaryKind::Ridge => &[
            (-0.0065 - CASING, -0.0065, false),
            (-0.0065, -0.002, true),
            (-0.002, 0.002, false),
            (0.002, 0.0065, true),
            (0.0065, 0.0065 + CASING, false),
        ],
        BoundaryKind::SubductingOrigin | BoundaryKind::SubductingDestination => single!(0.0035),
        BoundaryKind::Collision => single!(0.006),
    }
}

#[cfg(test)]
mod tests {
    use super::super::drape::tests::{assert_sound, colors, flat, positions, surface, triangles};
    use super::*;
    use crate::planet::to_scene;
    use bevy::math::DVec3;
    use bevy::mesh::Mesh;

    fn mesh(pieces: &[Piece]) -> Mesh {
        let surface = surface();
        let mut drape = Drape::new(&surface, flat()).unwrap();
        lay(&mut drape, pieces);
        drape.finish().unwrap()
    }

    /// Eastwards along the equator.
    fn eastwards(kind: BoundaryKind) -> Vec<Piece> {
        let place = |i: u32| {
            let (sin, cos) = libm::sincos(0.02 * f64::from(i));
            DVec3::new(cos, sin, 0.0)
        };
        (0..20)
            .map(|i| Piece {
                ends: [place(i), place(i + 1)],
                kind,
            })
            .collect()
    }

    #[test]
    fn boundaries_of_a_planet_are_sound() {
        let surface = surface();
        let pieces: Vec<Piece> = surface.boundaries().iter().map(Piece::from).collect();
        let mesh = mesh(&pieces);
        assert_sound(&mesh);
        // As long as the boundaries, give or take the zigzag.
        let length: f64 = surface.boundaries().iter().map(|s| s.length_km).sum();
        let count = triangles(&mesh).len() as f64;
        let steps = length / surface.radius_km / STEP;
        assert!((3.0..20.0).contains(&(count / steps)), "{}", count / steps);
    }

    #[test]
    fn teeth_stand_on_the_overriding_side() {
        // On the way east the origin lies to the north.
        for (kind, north) in [
            (BoundaryKind::SubductingOrigin, -1.0),
            (BoundaryKind::SubductingDestination, 1.0),
        ] {
            let mut pieces = eastwards(kind);
            let [plain, toothed] = [&eastwards(BoundaryKind::Transform), &pieces].map(|pieces| {
                let positions = positions(&mesh(pieces));
                let mean = |p: f32| f64::from(p) / positions.len() as f64;
                positions.iter().map(|p| mean(p.y)).sum::<f64>()
            });
            assert!(
                (toothed - plain) * north > 1e-3,
                "{kind:?}: {toothed} {plain}"
            );
            // Whichever way the pieces run.
            for piece in &mut pieces {
                piece.ends.swap(0, 1);
                piece.kind = piece.kind.reversed();
            }
            let reversed = positions(&mesh(&pieces));
            let mean = reversed.iter().map(|p| f64::from(p.y)).sum::<f64>() / reversed.len() as f64;
            assert!((mean - plain) * north > 1e-3);
        }
    }

    #[test]
    fn rings_are_closed() {
        let place = |i: u32| {
            let (sin, cos) = libm::sincos(core::f64::consts::TAU * f64::from(i % 60) / 60.0);
            DVec3::new(0.5 * cos, 0.5 * sin, 0.75_f64.sqrt())
        };
        let ring: Vec<_> = (0..60)
            .map(|i| Piece {
                ends: [place(i), place(i + 1)],
                kind: BoundaryKind::Collision,
            })
            .collect();
        let mesh = mesh(&ring);
        assert_sound(&mesh);
        // Every edge of the coloured stripe belongs to two triangles or to a rim, and rims have no ends.
        let (positions, colors) = (positions(&mesh), colors(&mesh));
        let bright = colors.iter().map(|c| c[0]).fold(0.0, f32::max);
        let mut ends = std::collections::BTreeMap::<[u32; 3], i32>::new();
        for corners in triangles(&mesh) {
            if colors[corners[0]][0] < bright {
                continue;
            }
            for i in 0..3 {
                let key = |corner: usize| positions[corner].to_array().map(f32::to_bits);
                let (a, b) = (key(corners[i]), key(corners[(i + 1) % 3]));
                *ends.entry(a).or_default() += 1;
                *ends.entry(b).or_default() -= 1;
            }
        }
        assert!(ends.len() > 200 && ends.values().all(|&balance| balance == 0));
    }

    #[test]
    fn lines_lie_above_the_ground_within_reach() {
        let middle = to_scene(DVec3::new(1.0, 0.2, 0.0).normalize());
        for kind in [
            BoundaryKind::Transform,
            BoundaryKind::Ridge,
            BoundaryKind::Collision,
        ] {
            let positions = positions(&mesh(&eastwards(kind)));
            assert!(positions.iter().all(|p| p.length() > 1.001));
            assert!(positions.iter().any(|p| p.distance(middle) < 0.2));
            let widest = stripes(kind).last().unwrap().1;
            assert!(widest < 0.012);
        }
    }
}
