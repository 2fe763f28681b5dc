//! Flat pictures of the sphere: a rectangle of longitudes and latitudes, or a face of a cube.

use super::grid::{Grid, east_north};
use crate::surface::{cube, direction};
use glam::{DVec3, Vec3};

/// Which pixel lies where.
#[derive(Clone, Copy, Debug)]
pub(super) enum Chart {
    Rectangle(Grid),
    /// A face of a cube map and its texels per side.
    Face(usize, u32),
}

impl Chart {
    /// Width and height.
    pub(super) fn size(self) -> (u32, u32) {
        match self {
            Self::Rectangle(grid) => grid.size(),
            Self::Face(_, side) => (side, side),
        }
    }

    /// Unit vector of the centre of a pixel. Those one beyond the edge lie where the sphere goes on.
    pub(super) fn direction(self, x: i32, y: i32) -> DVec3 {
        match self {
            Self::Rectangle(grid) => direction(grid.longitude(x), grid.latitude(y)),
            Self::Face(face, side) => cube::direction(face, x, y, side),
        }
    }

    /// Unit vectors tangent to the sphere, to the right of the picture and to its top.
    pub(super) fn right_up(self, x: i32, y: i32, place: DVec3) -> [Vec3; 2] {
        match self {
            Self::Rectangle(grid) => east_north(grid.longitude(x), grid.latitude(y)).into(),
            Self::Face(face, _) => {
                let along = cube::to_simulation(cube::axes(face)[0]);
                let right = along.reject_from_normalized(place).normalize_or(along);
                [right.as_vec3(), place.cross(right).as_vec3()]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_and_up_lead_to_the_next_pixels() {
        let charts = (0..6).map(|face| Chart::Face(face, 64));
        for chart in charts.chain([Chart::Rectangle(Grid::new(128))]) {
            for (x, y) in [(5, 9), (31, 32), (63, 40)] {
                let place = chart.direction(x, y);
                let [right, up] = chart.right_up(x, y, place);
                let to = |x, y| (chart.direction(x, y) - place).normalize().as_vec3();
                assert!(right.dot(to(x + 1, y)) > 0.99, "{chart:?}");
                // Columns and rows of a cube are not at right angles near its corners.
                assert!(up.dot(to(x, y - 1)) > 0.7, "{chart:?}");
                assert!((right.cross(up) - place.as_vec3()).length() < 1e-6);
            }
        }
    }

    #[test]
    fn pixels_beyond_the_edge_lie_on_the_other_side() {
        let chart = Chart::Rectangle(Grid::new(128));
        let same = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-12);
        same(chart.direction(-1, 7), chart.direction(127, 7));
        same(chart.direction(128, 7), chart.direction(0, 7));
        same(chart.direction(3, -1), chart.direction(67, 0));
        same(chart.direction(3, 64), chart.direction(67, 63));
    }
}
