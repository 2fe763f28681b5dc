//! Point location and nearest-site queries by walking.

use glam::DVec3;

use super::geometry::unit;
use super::{EdgePayload, HalfEdge, SphereMesh, Vertex};

/// A point within a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Location {
    /// A half-edge of the triangle.
    pub half_edge: HalfEdge,
    /// The corners of the triangle, counter-clockwise from the origin of `half_edge`.
    pub vertices: [Vertex; 3],
    /// Barycentric coordinates, in the plane of the corners, of the point where the ray from the
    /// centre meets it; none negative, their sum is 1.
    pub weights: [f64; 3],
}

impl<E: EdgePayload> SphereMesh<E> {
    /// The triangle in which `direction` lies (any positive length), with weights of its corners.
    ///
    /// Walks from triangle to triangle, starting at vertex `hint`; any will do, one nearby is
    /// fastest. Directions on an edge or vertex belong to one of the triangles there.
    pub fn locate(&self, direction: DVec3, hint: Vertex) -> Location {
        let direction = unit(direction).unwrap_or(direction);
        let h = self
            .walk(direction, self.start_at(hint))
            .unwrap_or_else(|| self.search(direction));
        let [a, b, c] = self.triangle_sites(h).map(|site| site - direction);
        // Relative to the direction, the triple products do not cancel for small triangles.
        let opposite = [b.cross(c), c.cross(a), a.cross(b)];
        let weights = opposite.map(|normal| normal.dot(direction).max(0.0));
        // Smallest first: the same sum whichever corner comes first.
        let mut ascending = weights;
        ascending.sort_unstable_by(f64::total_cmp);
        let sum: f64 = ascending.iter().sum();
        Location {
            half_edge: h,
            vertices: self.triangle_vertices(h),
            weights: if sum > 0.0 {
                weights.map(|weight| weight / sum)
            } else {
                [1.0 / 3.0; 3]
            },
        }
    }

    /// The vertex nearest to `direction` (any positive length).
    ///
    /// Walks from vertex to vertex, starting at `hint`; exact on a Delaunay mesh.
    pub fn nearest(&self, direction: DVec3, hint: Vertex) -> Vertex {
        let direction = unit(direction).unwrap_or(direction);
        // Differences discriminate close sites that dot products no longer do.
        let distance = |v: Vertex| self.site(v).distance_squared(direction);
        let start = self.origin(self.start_at(hint));
        let mut nearest = (start, distance(start));
        loop {
            let candidate = self.neighbours(nearest.0).map(|v| (v, distance(v))).fold(
                nearest,
                |best, other| {
                    if other.1 < best.1 { other } else { best }
                },
            );
            if candidate.0 == nearest.0 {
                return nearest.0;
            }
            nearest = candidate;
        }
    }

    /// An outgoing half-edge of `hint`, or of another vertex if `hint` is not in the mesh.
    fn start_at(&self, hint: Vertex) -> HalfEdge {
        match self.vertex_edge.get(hint as usize) {
            Some(&h) if self.is_half_edge(h) => h,
            _ => self.triangles().next().unwrap_or(0),
        }
    }

    /// Remembering walk (Devillers et al. 2002): leaves a triangle by any side that has the direction
    /// on its far side. `None` if it gets lost, as it may where the mesh is not Delaunay.
    fn walk(&self, direction: DVec3, start: HalfEdge) -> Option<HalfEdge> {
        let mut entry = start;
        if self.is_beyond(start, &direction) {
            entry = self.twin(start);
        }
        for _ in 0..self.step_limit() {
            let (next, prev) = (self.next(entry), self.prev(entry));
            entry = if self.is_beyond(next, &direction) {
                self.twin(next)
            } else if self.is_beyond(prev, &direction) {
                self.twin(prev)
            } else {
                // An inverted triangle passes the tests for directions opposite to it.
                let found = !self.is_inverted(entry) && self.contains(entry, &direction);
                return found.then_some(entry);
            };
        }
        None
    }

    /// Far more steps than it takes to cross a mesh of evenly spread sites.
    fn step_limit(&self) -> usize {
        64 + 16 * (self.vertex_count() as f64).sqrt() as usize
    }

    /// Tries all triangles. Some triangle contains the direction, as the mesh covers the sphere: where
    /// it is folded, those that are not inverted outnumber the inverted ones by one.
    fn search(&self, direction: DVec3) -> HalfEdge {
        self.triangles()
            .find(|&h| !self.is_inverted(h) && self.contains(h, &direction))
            .unwrap_or_else(|| self.start_at(self.nearest(direction, 0)))
    }
}
