//! Verification of everything the mesh promises.

use thiserror::Error;

use super::{Edge, EdgePayload, HalfEdge, NONE, SphereMesh, Vertex};

/// Largest deviation of a squared site length from 1.
const UNIT_TOLERANCE: f64 = 1e-12;

/// A violated promise of a [`SphereMesh`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum MeshFault {
    /// A site is not finite or not of unit length.
    #[error("the site of vertex {0} is not a unit vector")]
    Site(Vertex),
    /// A vertex has no edges.
    #[error("vertex {0} is detached")]
    Detached(Vertex),
    /// The links of a half-edge do not form a triangle, or its edge is not in its origin's fan.
    #[error("half-edge {0} is linked inconsistently")]
    Link(HalfEdge),
    /// Two edges join the same vertices, or an edge joins a vertex to itself.
    #[error("vertices {0} and {1} are joined more than once")]
    DuplicateEdge(Vertex, Vertex),
    /// The surface is not a sphere.
    #[error("{vertices} vertices and {edges} edges do not form a triangulated sphere")]
    Euler {
        /// Number of vertices.
        vertices: usize,
        /// Number of live edges.
        edges: usize,
    },
    /// A triangle is clockwise seen from outside, or flat.
    #[error("the triangle of vertices {0:?} is inverted")]
    Inverted([Vertex; 3]),
    /// The triangle lies over another one: the mesh winds around the sphere more than once.
    #[error("the triangle of vertices {0:?} overlaps another one")]
    Overlap([Vertex; 3]),
    /// An edge is not locally Delaunay.
    #[error("edge {edge} between vertices {vertices:?} is not Delaunay")]
    NotDelaunay {
        /// The edge.
        edge: Edge,
        /// Its endpoints.
        vertices: [Vertex; 2],
    },
}

impl<E: EdgePayload> SphereMesh<E> {
    /// Verifies that the mesh is the Delaunay triangulation of its sites: unit sites, consistent
    /// links, a simple triangulated sphere, no inverted triangle, the sphere covered once, every edge locally Delaunay.
    ///
    /// # Errors
    ///
    /// The first [`MeshFault`] found.
    pub fn check(&self) -> Result<(), MeshFault> {
        self.check_within(0.0)
    }

    /// As [`check`](Self::check), but an edge may be wrong by a hair: by so much, in radii, at most lies the
    /// vertex on one side of it within the circle through the three on the other. What turns as one body stays
    /// Delaunay, but for the rounding of its sites.
    ///
    /// # Errors
    ///
    /// As [`check`](Self::check).
    pub fn check_within(&self, hair: f64) -> Result<(), MeshFault> {
        self.check_sites()?;
        self.check_surface()?;
        let is_wrong = |e: &Edge| !self.is_locally_delaunay(*e) && self.intrusion(*e) > hair;
        match self.edges().find(is_wrong) {
            Some(edge) => Err(MeshFault::NotDelaunay {
                edge,
                vertices: self.endpoints(edge).into(),
            }),
            None => Ok(()),
        }
    }

    /// How far the vertex on one side of an edge lies within the circle through the three on the other.
    fn intrusion(&self, edge: Edge) -> f64 {
        let (one, other) = (2 * edge, 2 * edge + 1);
        let centre = self.circumcentre(one);
        let distance = |h: HalfEdge| centre.distance(self.site(self.apex(h)));
        let depth = distance(one) - distance(other);
        // Of a flat triangle there is no centre.
        if depth.is_finite() {
            depth
        } else {
            f64::INFINITY
        }
    }

    /// Verifies that the mesh is a triangulated sphere without folds.
    pub(super) fn check_surface(&self) -> Result<(), MeshFault> {
        self.check_links()?;
        self.check_fans()?;
        let (vertices, edges) = (self.vertex_count(), self.edge_count());
        // With E = 3F/2, Euler's V - E + F = 2.
        if edges + 6 != 3 * vertices {
            return Err(MeshFault::Euler { vertices, edges });
        }
        if let Some(h) = self.triangles().find(|&h| self.is_inverted(h)) {
            return Err(MeshFault::Inverted(self.triangle_vertices(h)));
        }
        if let Some(h) = self.first_overlap() {
            return Err(MeshFault::Overlap(self.triangle_vertices(h)));
        }
        Ok(())
    }

    /// Whether `h` is a half of a live edge.
    pub(super) fn is_half_edge(&self, h: HalfEdge) -> bool {
        self.origin.get(h as usize).is_some_and(|&v| v != NONE)
    }

    pub(super) fn check_sites(&self) -> Result<(), MeshFault> {
        let is_unit = |v: &Vertex| {
            // Not a number fails the comparison, too.
            (self.site(*v).length_squared() - 1.0).abs() <= UNIT_TOLERANCE
        };
        match (0..self.vertex_count() as Vertex).find(|v| !is_unit(v)) {
            Some(v) => Err(MeshFault::Site(v)),
            None => Ok(()),
        }
    }

    /// Every half-edge is in a triangle of three, each starting where the one before ends.
    fn check_links(&self) -> Result<(), MeshFault> {
        for h in self.edges().flat_map(|e| [2 * e, 2 * e + 1]) {
            let next = self.next(h);
            let linked = (self.origin(h) as usize) < self.vertex_count()
                && self.is_half_edge(next)
                && self.is_half_edge(self.next(next))
                && self.origin(next) == self.dest(h)
                && self.next(self.prev(h)) == h
                && next != h;
            if !linked {
                return Err(MeshFault::Link(h));
            }
        }
        Ok(())
    }

    /// Each vertex has one fan, which holds all its half-edges and reaches no neighbour twice.
    fn check_fans(&self) -> Result<(), MeshFault> {
        let mut reached_from = vec![NONE; self.vertex_count()];
        let mut fan_total = 0;
        for (v, &first) in (0..).zip(&self.vertex_edge) {
            if first == NONE {
                return Err(MeshFault::Detached(v));
            }
            if !self.is_half_edge(first) || self.origin(first) != v {
                return Err(MeshFault::Link(first));
            }
            // Links are bijective here, so the fan closes.
            for u in self.neighbours(v) {
                if u == v || reached_from[u as usize] == v {
                    return Err(MeshFault::DuplicateEdge(v, u));
                }
                reached_from[u as usize] = v;
                fan_total += 1;
            }
        }
        if fan_total != 2 * self.edge_count() {
            let stray = self.edges().map(|e| 2 * e).find(|&h| {
                self.outgoing(self.origin(h)).all(|k| k != h)
                    || self.outgoing(self.dest(h)).all(|k| k != h + 1)
            });
            return Err(MeshFault::Link(stray.unwrap_or(0)));
        }
        Ok(())
    }

    /// A triangle that overlaps another one, if the mesh, which has no inverted triangles, winds
    /// around the sphere more than once.
    ///
    /// It then covers all points equally often: as often as one within some triangle.
    pub(super) fn first_overlap(&self) -> Option<HalfEdge> {
        let middle = |h: HalfEdge| {
            let [a, b, c] = self.triangle_sites(h);
            (a + b + c) / 3.0
        };
        // Rounding may put the middle of a thin triangle outside.
        let (inner, point) = self
            .triangles()
            .map(|h| (h, middle(h)))
            .find(|(h, middle)| self.encloses(*h, middle))?;
        self.triangles()
            .find(|&h| h != inner && self.contains(h, &point))
    }
}
