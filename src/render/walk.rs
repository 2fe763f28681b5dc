//! Point location for whole maps: many directions, each near the last.

use crate::mesh::{HalfEdge, SphereMesh, Vertex};
use bevy::math::DVec3;
use core::{iter::Sum, ops::Mul};

/// Steps after which a walk is taken for lost, as it may be where the mesh is folded.
const STEPS: usize = 256;

/// Remembers the triangle of the last direction. Plain floating point: on the border of two triangles
/// either will do. Where that gets lost, the mesh's exact walk takes over.
#[derive(Clone, Copy)]
pub(super) struct Walk<'a> {
    mesh: &'a SphereMesh,
    at: HalfEdge,
}

impl<'a> Walk<'a> {
    pub(super) fn new(mesh: &'a SphereMesh) -> Self {
        Self {
            mesh,
            at: mesh.triangles().next().unwrap_or(0),
        }
    }

    /// The corners of the triangle around a unit vector, and their weights.
    pub(super) fn locate(&mut self, direction: DVec3) -> ([Vertex; 3], [f64; 3]) {
        let mesh = self.mesh;
        for _ in 0..STEPS {
            let corners = mesh.triangle_vertices(self.at);
            // Relative to the direction, the triple products do not cancel for small triangles.
            let [a, b, c] = corners.map(|vertex| mesh.site(vertex) - direction);
            let weights = [b.cross(c), c.cross(a), a.cross(b)].map(|normal| normal.dot(direction));
            let [u, v, w] = weights;
            // The side opposite to the least weight is the one that the direction lies beyond.
            let (least, side) = if u <= v && u <= w {
                (u, mesh.next(self.at))
            } else if v <= w {
                (v, mesh.prev(self.at))
            } else {
                (w, self.at)
            };
            let sum = u + v + w;
            if least >= 0.0 && sum > 0.0 {
                return (corners, weights.map(|weight| weight / sum));
            }
            self.at = mesh.twin(side);
        }
        let place = mesh.locate(direction, mesh.origin(self.at));
        self.at = place.half_edge;
        (place.vertices, place.weights)
    }
}

/// The mean of a value over the corners of a triangle.
pub(super) fn mean<T>(vertices: [Vertex; 3], weights: [f64; 3], value: impl Fn(usize) -> T) -> T
where
    T: Mul<f32, Output = T> + Sum,
{
    vertices
        .into_iter()
        .zip(weights)
        .map(|(vertex, weight)| value(vertex as usize) * weight as f32)
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_finds_what_the_exact_walk_finds() {
        let sites = (0..500).map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 500.0;
            let (sin, cos) = libm::sincos(f64::from(i) * 2.399_963_229_728_653);
            let r = (1.0 - z * z).sqrt();
            DVec3::new(r * cos, r * sin, z)
        });
        let mesh: SphereMesh = SphereMesh::build(sites.collect()).unwrap();
        let mut walk = Walk::new(&mesh);
        for i in 0..5000 {
            let angle = f64::from(i) * 0.37;
            let direction = DVec3::new(
                libm::sin(angle),
                libm::cos(1.7 * angle),
                libm::sin(0.3 * angle + 1.0),
            )
            .normalize_or(DVec3::X);
            let (mut found, weights) = walk.locate(direction);
            let mut exact = mesh.locate(direction, 0).vertices;
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-9);
            found.sort_unstable();
            exact.sort_unstable();
            assert_eq!(found, exact);
        }
    }
}
