//! Plate boundaries, drawn as thin lines whose colour says what the two plates do.

use std::ops::Range;

use glam::{Vec2, Vec3};

use super::window::Window;
use crate::export::grid::{Grid, east_north};
use crate::surface::ground::ramp;

/// Opening or closing counts where it makes up this share of the relative motion.
const OBLIQUE: f32 = 0.35;

#[derive(Clone, Copy, PartialEq)]
enum Motion {
    Ridge,
    Trench,
    Transform,
}

impl Motion {
    /// Colour and opacity.
    fn ink(self) -> (Vec3, f32) {
        match self {
            Self::Ridge => (Vec3::new(0.93, 0.47, 0.22), 0.72),
            Self::Trench => (Vec3::new(0.42, 0.05, 0.13), 0.72),
            Self::Transform => (Vec3::new(0.24, 0.25, 0.30), 0.45),
        }
    }
}

/// What a boundary adds to a pixel.
#[derive(Clone, Copy)]
pub(super) struct Line {
    colour: Vec3,
    opacity: f32,
}

impl Line {
    /// The line drawn over `ground`; it is fainter where `land` (0–1) should be read first.
    pub(super) fn over(self, ground: Vec3, land: f32) -> Vec3 {
        ground.lerp(self.colour, self.opacity * (1.0 - 0.35 * land))
    }
}

pub(super) struct Boundaries {
    grid: Grid,
    /// Half the width of a line, pixels.
    half_width: f32,
    /// Pixels around a boundary that decide on its direction.
    neighbourhood: i64,
}

impl Boundaries {
    /// `spacing` is that of sub-plates, in pixels: boundaries zigzag around them.
    pub(super) fn new(grid: Grid, spacing: f64) -> Self {
        let half_width = ((grid.width as f32 / 2048.0).sqrt() * 0.85).clamp(0.5, 3.0);
        let most = i64::from(grid.width / 40).max(2);
        Self {
            grid,
            half_width,
            neighbourhood: (spacing.ceil() as i64).clamp(2, most),
        }
    }

    /// Rows on either side that a row's lines depend on.
    pub(super) fn reach(&self) -> u32 {
        self.brush() as u32 + self.neighbourhood as u32 + 1
    }

    fn brush(&self) -> i64 {
        self.half_width.ceil() as i64 + 1
    }

    /// One line element per pixel of the rows.
    pub(super) fn draw(&self, window: &Window, rows: Range<u32>) -> Vec<Line> {
        let width = self.grid.width as usize;
        let mut lines = vec![
            Line {
                colour: Vec3::ZERO,
                opacity: 0.0
            };
            width * rows.len()
        ];
        let brush = self.brush();
        let from = i64::from(rows.start) - brush;
        let to = i64::from(rows.end) + brush;
        for y in from.max(0)..to.min(i64::from(self.grid.height)) {
            for x in 0..i64::from(self.grid.width) {
                let here = window.at(x, y).plate;
                // The boundary runs along the edge between two pixels.
                for (dx, dy) in [(1, 0), (0, 1)] {
                    if y + dy < i64::from(self.grid.height)
                        && window.at(x + dx, y + dy).plate != here
                    {
                        let (colour, opacity) = self.motion(window, (x, y), (x + dx, y + dy)).ink();
                        let edge = Vec2::new(dx as f32 * 0.5, dy as f32 * 0.5);
                        self.dab(&mut lines, &rows, (x, y), edge, Line { colour, opacity });
                    }
                }
            }
        }
        lines
    }

    fn dab(
        &self,
        lines: &mut [Line],
        rows: &Range<u32>,
        (x, y): (i64, i64),
        edge: Vec2,
        ink: Line,
    ) {
        let (width, brush) = (i64::from(self.grid.width), self.brush());
        let north = (y - brush).max(i64::from(rows.start));
        let south = (y + brush + 1).min(i64::from(rows.end));
        for row in north..south {
            for column in x - brush..=x + brush {
                let distance = (Vec2::new((column - x) as f32, (row - y) as f32) - edge).length();
                let opacity =
                    ink.opacity * ramp(self.half_width + 0.5, self.half_width - 0.5, distance);
                let at = (row - i64::from(rows.start)) * width + column.rem_euclid(width);
                let line = &mut lines[at as usize];
                if opacity > line.opacity {
                    *line = Line {
                        colour: ink.colour,
                        opacity,
                    };
                }
            }
        }
    }

    /// What the plates at two neighbouring pixels do to each other. The direction of the boundary is
    /// that of its surroundings: between two pixels there are only two.
    fn motion(&self, window: &Window, a: (i64, i64), b: (i64, i64)) -> Motion {
        let (one, other) = (window.at(a.0, a.1), window.at(b.0, b.1));
        let latitude = self.grid.latitude(a.1 as u32);
        // Pixels shrink towards the poles: look at more of them, in as many samples.
        let stretch = (1.0 / libm::cos(latitude)).min(8.0);
        let reach = self.neighbourhood;
        let stride = (reach / 8).max(1);
        let mut across = Vec2::ZERO;
        for dy in (-reach..=reach).step_by(stride as usize) {
            for dx in (-reach..=reach).step_by(stride as usize) {
                let column = a.0 + (dx as f64 * stretch) as i64;
                let plate = window.at(column, a.1 + dy).plate;
                let offset = Vec2::new(dx as f32, -dy as f32);
                if plate == other.plate {
                    across += offset;
                } else if plate == one.plate {
                    across -= offset;
                }
            }
        }
        let longitude = self.grid.longitude(a.0 as u32);
        let (east, north) = east_north(longitude, latitude);
        let relative = other.velocity - one.velocity;
        let drift = Vec2::new(relative.dot(east), relative.dot(north));
        let opening = drift.dot(across.normalize_or_zero());
        if opening > OBLIQUE * drift.length() {
            Motion::Ridge
        } else if opening < -OBLIQUE * drift.length() {
            Motion::Trench
        } else {
            Motion::Transform
        }
    }
}
