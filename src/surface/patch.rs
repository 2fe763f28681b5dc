//! Square pieces of ground on a tangent plane: colliders, navigation meshes, local terrain.

use super::coordinates::{east_north, unit};
use super::query::Relief;
use crate::simulation::Surface;
use glam::{DMat3, DQuat, DVec3, Vec3};
use std::ops::RangeInclusive;

/// A square grid of heights around a place.
///
/// Its own frame is that of Bevy's scenes: x east, y up, z south, in metres, with the origin at sea level
/// in the middle. Samples lie in rows from north to south, each from west to east.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightField {
    /// The middle, a unit vector in the planet's frame.
    pub centre: DVec3,
    /// East at the middle, a unit vector in the planet's frame. At the poles as on longitude 0.
    pub east: DVec3,
    /// North at the middle, a unit vector in the planet's frame.
    pub north: DVec3,
    /// Length of a side in m.
    pub size_m: f64,
    /// Samples along a side, at least 2.
    pub samples: usize,
    /// Radius of the planet in m.
    pub radius_m: f64,
    /// Elevation in m above the sea, `samples × samples`.
    pub heights: Vec<f32>,
}

/// Samples along a side of a patch.
const SAMPLES: RangeInclusive<usize> = 2..=4097;

impl Surface {
    /// Heights on a square of the tangent plane at a direction, sides along east and north.
    ///
    /// A sample's place is where the line from the planet's centre through its point of the plane meets
    /// the ground ([`HeightField::direction`]). `size_km` is the length of a side: what is not positive
    /// counts as 1 km, and it ends at twice the radius. There are at least 2 and at most 4,097 samples
    /// along a side. A direction that is zero or not finite stands for the north pole.
    ///
    /// Heights are those of [`elevation`](Self::elevation): smooth between sub-plates. `Terrain::patch` (feature
    /// `terrain`) has the rough ground.
    ///
    /// ```
    /// use bevy_tectonics::prelude::*;
    /// use bevy_tectonics::surface::direction_of;
    ///
    /// let surface = History::new(Recipe::earth_like(7).with_sub_plates(500))?.surface()?;
    /// let patch = surface.patch(direction_of(47.0, 8.5), 20.0, 65);
    /// // A triangle mesh for a physics engine or a navigation mesh.
    /// let (vertices, triangles) = (patch.positions(), patch.triangles());
    /// assert_eq!((vertices.len(), triangles.len()), (65 * 65, 2 * 64 * 64));
    /// # Ok::<(), TectonicError>(())
    /// ```
    #[must_use]
    pub fn patch(&self, centre: DVec3, size_km: f64, samples: usize) -> HeightField {
        let mut hint = self.start(centre);
        HeightField::over(self.radius_km, centre, size_km, samples, |direction| {
            self.elevation_from(direction, &mut hint)
        })
    }
}

impl HeightField {
    /// Samples a square of a sphere.
    pub(super) fn over(
        radius_km: f64,
        centre: DVec3,
        size_km: f64,
        samples: usize,
        elevation: impl FnMut(DVec3) -> f32,
    ) -> Self {
        let centre = unit(centre);
        let (east, north) = east_north(centre);
        let size_km = if size_km > 0.0 { size_km } else { 1.0 };
        let mut patch = Self {
            centre,
            east,
            north,
            size_m: 1000.0 * size_km.min(2.0 * radius_km),
            samples: samples.clamp(*SAMPLES.start(), *SAMPLES.end()),
            radius_m: 1000.0 * radius_km,
            heights: Vec::new(),
        };
        let heights = patch.directions().map(elevation).collect();
        patch.heights = heights;
        patch
    }

    /// Distance of neighbouring samples in m.
    #[must_use]
    pub fn spacing_m(&self) -> f64 {
        self.size_m / (self.samples.max(2) - 1) as f64
    }

    /// Elevation of a sample in m; none outside of the grid.
    #[must_use]
    pub fn height(&self, row: usize, column: usize) -> Option<f32> {
        if row >= self.samples || column >= self.samples {
            return None;
        }
        self.heights.get(row * self.samples + column).copied()
    }

    /// Where a sample lies on the planet: a unit vector in its frame. Rows and columns outside of the
    /// grid continue it.
    #[must_use]
    pub fn direction(&self, row: usize, column: usize) -> DVec3 {
        let [x, z] = self.offset(row, column);
        unit(self.centre * self.radius_m + self.east * x - self.north * z)
    }

    /// [`direction`](Self::direction) of every sample, in the order of `heights`.
    pub fn directions(&self) -> impl Iterator<Item = DVec3> {
        self.places()
            .map(|(row, column)| self.direction(row, column))
    }

    /// Vertices on a flat plane, in m in the patch's own frame: x east, y elevation, z south.
    ///
    /// For colliders and terrains of a few dozen km, whose own world is flat.
    #[must_use]
    pub fn positions(&self) -> Vec<Vec3> {
        let heights = self.heights.iter();
        self.places()
            .zip(heights)
            .map(|((row, column), &height)| {
                let [x, z] = self.offset(row, column);
                Vec3::new(x as f32, height, z as f32)
            })
            .collect()
    }

    /// Vertices where the ground is on the round planet, in m in the patch's own frame.
    ///
    /// `rotation() × position + centre × radius_m` are points of [`Surface::point`] times the radius:
    /// for patches that lie on a drawn planet.
    #[must_use]
    pub fn curved_positions(&self, relief: impl Into<Relief>) -> Vec<Vec3> {
        let relief = relief.into();
        let scale = relief.scale(0.001 * self.radius_m) * self.radius_m;
        self.places()
            .zip(&self.heights)
            .map(|((row, column), &height)| {
                let [x, z] = self.offset(row, column);
                // The point of the plane, drawn in to the sphere; the drop is small beside the radius.
                let plane = (self.radius_m * self.radius_m + x * x + z * z).sqrt();
                let up = scale * relief.height(f64::from(height));
                let share = (self.radius_m + up) / plane;
                let drop = -(x * x + z * z) / (plane * (plane + self.radius_m)) * self.radius_m;
                let y = drop + up * self.radius_m / plane;
                DVec3::new(x * share, y, z * share).as_vec3()
            })
            .collect()
    }

    /// Triangles between the vertices, counter-clockwise seen from above.
    #[must_use]
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let side = self.samples as u32;
        let last = side.saturating_sub(1);
        let cells = (0..last).flat_map(|row| (0..last).map(move |column| row * side + column));
        cells
            .flat_map(|i| [[i, i + side, i + 1], [i + 1, i + side, i + side + 1]])
            .collect()
    }

    /// Turns directions of the patch's own frame (x east, y up, z south) into the planet's.
    #[must_use]
    pub fn rotation(&self) -> DQuat {
        DQuat::from_mat3(&DMat3::from_cols(self.east, self.centre, -self.north))
    }

    fn places(&self) -> impl Iterator<Item = (usize, usize)> {
        let side = self.samples;
        (0..side).flat_map(move |row| (0..side).map(move |column| (row, column)))
    }

    /// East and south of the middle on the tangent plane, in m.
    fn offset(&self, row: usize, column: usize) -> [f64; 2] {
        let half = 0.5 * self.size_m;
        [column, row].map(|place| self.spacing_m() * place as f64 - half)
    }
}
