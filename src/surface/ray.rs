//! Rays against the ground: picking, shooting, lines of sight.

use super::coordinates::try_unit;
use super::crossing::Height;
use super::query::{Place, Relief, value};
use crate::simulation::Surface;
use glam::DVec3;

/// Leeway around the shell in which the ground lies, in radii.
const LEEWAY: f64 = 1e-9;
/// A ray runs along a plane through the centre rather than across if it nears it by less: such a ray would turn round a vertex for ever.
const ALONG: f64 = 2e-15;

/// Where a ray meets the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayHit {
    /// The point, in radii of the planet from its centre.
    pub point: DVec3,
    /// Its distance from the origin of the ray in radii of the planet.
    pub distance: f64,
    /// Upward unit normal of the ground as it is drawn, or of the sea.
    pub normal: DVec3,
    /// The planet there.
    pub place: Place,
}

impl Surface {
    /// The first point at which a ray crosses the ground as it is drawn.
    ///
    /// `origin` lies in the planet's frame, in radii of the planet from its centre; `direction` has any
    /// length. An origin above the ground meets it from above, one below it from below. On the ground,
    /// rounding decides: lift such an origin a little.
    ///
    /// The ground is that of [`elevation`](Self::elevation) and followed triangle by triangle, so no
    /// peak is missed, however grazing the ray.
    ///
    /// None where the ray misses, where the direction is zero, where something is not finite, and where
    /// the exaggeration is so strong that sea floors would reach the centre of the planet.
    ///
    /// ```
    /// use bevy::math::DVec3;
    /// use bevy_tectonics::prelude::*;
    /// use bevy_tectonics::surface::{Relief, lat_lon};
    ///
    /// let surface = History::new(Recipe::earth_like(7).with_sub_plates(500))?.surface()?;
    /// // From a camera three radii away, mountains drawn 20 times as high as they are.
    /// let drawn = Relief::exaggerated(20.0).with_sea();
    /// let camera = DVec3::new(3.0, 0.0, 0.2);
    /// if let Some(hit) = surface.ray(camera, DVec3::new(-1.0, 0.05, 0.0), drawn) {
    ///     let (latitude, longitude) = lat_lon(hit.point);
    ///     println!("{latitude:.1}° N, {longitude:.1}° E: {:.0} m", hit.place.elevation);
    /// }
    /// # Ok::<(), TectonicError>(())
    /// ```
    #[must_use]
    pub fn ray(
        &self,
        origin: DVec3,
        direction: DVec3,
        relief: impl Into<Relief>,
    ) -> Option<RayHit> {
        let relief = relief.into();
        let direction = try_unit(direction)?;
        // Ways are counted from the point closest to the centre.
        let before = -origin.dot(direction);
        let base = origin + direction * before;
        let course = Course {
            surface: self,
            relief,
            base,
            direction,
            closest2: base.length_squared(),
            scale: relief.scale(self.radius_km),
        };
        let [from, to] = course.shell(-before)?;
        let way = course.follow(from, to)?;
        let point = base + direction * way;
        Some(RayHit {
            point,
            distance: (way + before).max(0.0),
            normal: self.normal(point, relief),
            place: self.at(point),
        })
    }
}

/// A ray on its way.
struct Course<'a> {
    surface: &'a Surface,
    relief: Relief,
    /// The point closest to the centre.
    base: DVec3,
    direction: DVec3,
    /// Square of its distance from the centre.
    closest2: f64,
    /// Radii per metre of elevation.
    scale: f64,
}

impl Course<'_> {
    /// The part of the way from `start` on that may meet ground: in the shell of all elevations.
    fn shell(&self, start: f64) -> Option<[f64; 2]> {
        let radius = |elevation: f64| 1.0 + self.scale * self.relief.height(elevation);
        let [low, high] = self.surface.elevation_range().map(radius);
        let (low, high) = (low - LEEWAY, high + LEEWAY);
        let half_chord = |radius: f64| {
            let square = radius * radius - self.closest2;
            (square >= 0.0).then(|| square.sqrt())
        };
        let end = half_chord(high)?;
        if !(low > 0.0 && start.is_finite() && start <= end) {
            return None;
        }
        let mut from = start.max(-end);
        // Below all ground there is none to meet.
        if let Some(depth) = half_chord(low)
            && (-depth..depth).contains(&from)
        {
            from = depth;
        }
        Some([from, end])
    }

    /// Goes from triangle to triangle; the way to the first crossing.
    fn follow(&self, from: f64, to: f64) -> Option<f64> {
        let mesh = &self.surface.mesh;
        let start = self.base + self.direction * from;
        let mut h = mesh.locate(start, self.surface.start(start)).half_edge;
        let mut way = from;
        let mut side = None;
        // Half the way around the planet crosses about twice the root of their number.
        let limit = 64 + 16 * (mesh.vertex_count() as f64).sqrt() as usize;
        for _ in 0..limit {
            let corners = mesh.triangle_vertices(h);
            let [a, b, c] = corners.map(|v| mesh.site(v));
            let opposite = [b.cross(c), c.cross(a), a.cross(b)];
            // Weights along the way, linear in it; the ray leaves where one of them becomes negative.
            let weights = opposite.map(|n| [n.dot(self.base), n.dot(self.direction)]);
            let (mut exit, mut across) = (to, None);
            for (corner, [at, rise]) in weights.into_iter().enumerate() {
                if rise < -ALONG && -at / rise < exit {
                    (exit, across) = (-at / rise, Some(corner));
                }
            }
            let exit = exit.max(way);
            let height = self.height(corners, weights);
            let hit = self.meet(height, way, exit, &mut side);
            if hit.is_some() {
                return hit;
            }
            h = mesh.twin(match across? {
                0 => mesh.next(h),
                1 => mesh.prev(h),
                _ => h,
            });
            way = exit;
        }
        None
    }

    /// Height above the ground of a triangle.
    fn height(&self, corners: [u32; 3], weights: [[f64; 2]; 3]) -> Height {
        let (mut elevation, mut weight) = ([0.0; 2], [0.0; 2]);
        for (corner, part) in corners.into_iter().zip(weights) {
            let ground = f64::from(value(&self.surface.elevation, corner));
            for i in 0..2 {
                elevation[i] += ground * part[i];
                weight[i] += part[i];
            }
        }
        Height {
            closest2: self.closest2,
            scale: self.scale,
            elevation,
            weight,
        }
    }

    /// The first crossing within a triangle. `side` is where the ray set out: 1 above, −1 below.
    fn meet(&self, height: Height, from: f64, to: f64, side: &mut Option<f64>) -> Option<f64> {
        let [a, b] = height.elevation;
        // The shore parts ground from water.
        let shore = if self.relief.sea && b != 0.0 {
            (-a / b).max(from).min(to)
        } else {
            from
        };
        let mut start = from;
        for end in [shore, to] {
            let middle = 0.5 * (start + end);
            let piece = if self.relief.sea && a + b * middle < 0.0 {
                Height {
                    elevation: [0.0; 2],
                    ..height
                }
            } else {
                height
            };
            let side = *side.get_or_insert_with(|| if piece.at(start) >= 0.0 { 1.0 } else { -1.0 });
            let hit = piece.crossing(start, end, side);
            if hit.is_some() {
                return hit;
            }
            start = end;
        }
        None
    }
}
