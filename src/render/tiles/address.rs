//! Where tiles lie: squares of the faces of a cube blown up to a sphere, each split into four.

use crate::surface::cube;
use bevy::camera::primitives::Aabb;
use core::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use glam::DVec3;

/// Quads along a side of a tile.
pub(super) const QUADS: u32 = 64;
/// The finest level there can be.
pub(super) const DEEPEST: u8 = 20;

/// A square of the sphere. Level 0 is a whole face of the cube.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Address {
    pub level: u8,
    pub face: u8,
    pub x: u32,
    pub y: u32,
}

impl Address {
    /// Length of a side of a face in radii, in its middle.
    pub const SPAN: f64 = FRAC_PI_2;

    /// The whole sphere.
    pub fn roots() -> impl Iterator<Item = Self> {
        (0..6).map(|face| Self {
            level: 0,
            face,
            x: 0,
            y: 0,
        })
    }

    pub fn parent(self) -> Option<Self> {
        Some(Self {
            level: self.level.checked_sub(1)?,
            x: self.x / 2,
            y: self.y / 2,
            ..self
        })
    }

    pub fn children(self) -> [Self; 4] {
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| Self {
            level: self.level + 1,
            x: 2 * self.x + x,
            y: 2 * self.y + y,
            ..self
        })
    }

    /// Length of a side in radii: that of the middle of a face, where tiles are largest.
    pub fn size(self) -> f64 {
        Self::SPAN / f64::from(1_u32 << self.level)
    }

    /// The direction of a corner of a quad in the space of the planet's `Transform`: column and row count quads
    /// and may lie beyond the tile. The same place has the same direction in every tile of a face.
    pub fn direction(self, column: f64, row: f64) -> DVec3 {
        let quads = f64::from(QUADS << self.level);
        // Tangents space the quads evenly by angle.
        let tick = |tile: u32, at: f64| {
            let share = (f64::from(tile * QUADS) + at) / quads;
            libm::tan(FRAC_PI_4 * (2.0 * share - 1.0))
        };
        let (s, t) = (tick(self.x, column), tick(self.y, row));
        cube::point(usize::from(self.face), s, t).normalize()
    }

    pub fn middle(self) -> DVec3 {
        let half = 0.5 * f64::from(QUADS);
        self.direction(half, half)
    }
}

/// A box around the ground of a tile.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    middle: DVec3,
    axes: [DVec3; 3],
    half: DVec3,
    up: DVec3,
    /// Angle from the middle of the tile to its corners, in radians.
    angle: f64,
    highest: f64,
}

impl Bounds {
    /// `low` and `high` are the radii between which the ground lies, in radii of the planet.
    pub fn new(address: Address, low: f64, high: f64) -> Self {
        let up = address.middle();
        let (end, half) = (f64::from(QUADS), 0.5 * f64::from(QUADS));
        let rim = [(0.0, 0.0), (end, 0.0), (0.0, end), (end, end)]
            .into_iter()
            .chain([(half, 0.0), (half, end), (0.0, half), (end, half)]);
        let mut places = [up; 8];
        for (place, (column, row)) in places.iter_mut().zip(rim) {
            *place = address.direction(column, row);
        }
        let rim = places;
        let along = (rim[1] - rim[0]).reject_from(up).normalize();
        let across = up.cross(along);
        let farthest = |axis: DVec3| {
            let reach = rim.iter().map(|place| place.dot(axis).abs());
            // Edges bulge beyond these places.
            reach.fold(0.0, f64::max) * high * (1.0 + 0.05 * address.size())
        };
        let cosine = rim.iter().map(|place| place.dot(up)).fold(1.0, f64::min);
        let (bottom, top) = (low * cosine, high);
        Self {
            middle: up * (0.5 * (bottom + top)),
            axes: [along, across, up],
            half: DVec3::new(farthest(along), farthest(across), 0.5 * (top - bottom)),
            up,
            angle: libm::acos(cosine.clamp(-1.0, 1.0)),
            highest: high,
        }
    }

    /// A box with its sides along the axes that holds this one, relative to a point.
    pub fn around(&self, point: DVec3) -> Aabb {
        let [along, across, up] = self.axes.map(DVec3::abs);
        let half = along * self.half.x + across * self.half.y + up * self.half.z;
        let middle = self.middle - point;
        Aabb::from_min_max((middle - half).as_vec3(), (middle + half).as_vec3())
    }

    /// Distance of a point from the box, in radii; 0 inside.
    pub fn distance(&self, point: DVec3) -> f64 {
        let offset = point - self.middle;
        let beyond = |axis: usize| (offset.dot(self.axes[axis]).abs() - self.half[axis]).max(0.0);
        DVec3::new(beyond(0), beyond(1), beyond(2)).length()
    }

    /// Whether something of the tile may be seen from a point above a sphere of this radius, which hides what lies
    /// behind it.
    pub fn rises(&self, eye: DVec3, radius: f64) -> bool {
        let dip = |distance: f64| libm::acos((radius / distance).clamp(0.0, 1.0));
        let between = libm::acos((eye.dot(self.up) / eye.length()).clamp(-1.0, 1.0));
        between - self.angle <= dip(eye.length()) + dip(self.highest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_fill_their_parent() {
        let parent = Address {
            level: 3,
            face: 4,
            x: 5,
            y: 2,
        };
        let [a, b, c, d] = parent.children();
        let half = f64::from(QUADS / 2);
        for (child, column, row) in [
            (a, 0.0, 0.0),
            (b, half, 0.0),
            (c, 0.0, half),
            (d, half, half),
        ] {
            assert_eq!(child.parent(), Some(parent));
            let quads = f64::from(QUADS);
            for (i, j) in [(0.0, 0.0), (quads, 0.0), (2.0, 6.0), (quads, quads)] {
                assert_eq!(
                    child.direction(i, j),
                    parent.direction(column + 0.5 * i, row + 0.5 * j)
                );
            }
        }
    }

    #[test]
    fn boxes_hold_the_ground_of_their_tiles() {
        let (low, high) = (0.998, 1.002);
        let tiles = Address::roots().chain([
            Address {
                level: 1,
                face: 2,
                x: 1,
                y: 0,
            },
            Address {
                level: 7,
                face: 5,
                x: 3,
                y: 101,
            },
        ]);
        for tile in tiles {
            let bounds = Bounds::new(tile, low, high);
            for i in 0..=16 {
                for j in 0..=16 {
                    let direction = tile.direction(4.0 * f64::from(i), 4.0 * f64::from(j));
                    for radius in [low, high] {
                        assert!(
                            bounds.distance(direction * radius) < 1e-12,
                            "{tile:?} {i} {j}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn what_lies_behind_the_horizon_is_not_seen() {
        let tile = Address {
            level: 6,
            face: 0,
            x: 32,
            y: 32,
        };
        let bounds = Bounds::new(tile, 1.0, 1.001);
        let above = tile.middle() * 1.0003;
        assert!(bounds.rises(above, 1.0));
        assert!(!bounds.rises(-above, 1.0));
        // From as low, its own summits of a thousandth of the radius stand 70 thousandths away at most.
        let turned = |angle: f64| {
            let (sin, cos) = libm::sincos(angle);
            (tile.middle() * cos + tile.middle().any_orthonormal_vector() * sin) * 1.0003
        };
        assert!(bounds.rises(turned(0.06), 1.0));
        assert!(!bounds.rises(turned(0.15), 1.0));
    }
}
