//! Exact geometric predicates (Shewchuk 1997) on the stored coordinates.

use std::ops::Range;

use glam::DVec3;
use robust::Coord3D;

use super::{Edge, EdgePayload, HalfEdge, SphereMesh};

fn coord(p: DVec3) -> Coord3D<f64> {
    Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    }
}

/// Positive if `d` lies below the plane of `a`, `b`, `c` (counter-clockwise from above), negative if
/// above, zero if on it. The sign is exact; a floating-point filter decides all but close cases.
#[inline]
pub(super) fn side_of_plane(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    robust::orient3d(coord(a), coord(b), coord(c), coord(d))
}

/// Positive if `c` lies left of the great circle from `a` to `b`, that is if the three directions run
/// counter-clockwise seen from outside; exact sign.
#[inline]
pub(super) fn orientation(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    side_of_plane(a, b, c, DVec3::ZERO)
}

impl<E: EdgePayload> SphereMesh<E> {
    /// Whether the circumcircle of one triangle at `e` does not enclose the apex of the other: the
    /// apex is not above the triangle's plane. Exact.
    #[inline]
    pub fn is_locally_delaunay(&self, e: Edge) -> bool {
        let [a, b, c] = self.triangle_sites(2 * e);
        let d = self.site(self.apex(2 * e + 1));
        side_of_plane(a, b, c, d) >= 0.0
    }

    /// Whether the triangle of `h` is clockwise seen from outside, or flat. Exact.
    #[inline]
    pub fn is_inverted(&self, h: HalfEdge) -> bool {
        let [a, b, c] = self.triangle_sites(h);
        orientation(a, b, c) <= 0.0
    }

    /// The live edges in a range of edge numbers that are not locally Delaunay, ascending.
    ///
    /// Ranges that partition `0..edge_slots` can be swept in parallel; their lists, joined in
    /// order, are a queue for [`repair_from`](Self::repair_from).
    pub fn non_delaunay_edges(&self, slots: Range<usize>) -> Vec<Edge> {
        self.live_edges(slots)
            .filter(|&e| !self.is_locally_delaunay(e))
            .collect()
    }
}
