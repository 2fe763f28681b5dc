//! Exact geometric predicates (Shewchuk 1997) on the stored coordinates.

use std::ops::Range;

use glam::DVec3;
use robust::Coord3D;

use super::{Edge, EdgePayload, HalfEdge, SphereMesh, Vertex};

/// A rounded determinant of points within the unit ball has the right sign if it is larger.
///
/// Shewchuk's bound is (7 + 56 ε) ε times the permanent, with ε = 2⁻⁵³. The nine differences of
/// coordinates are at most 2 in size, so the permanent is at most 6 · 2³ = 48, and the bound 3.731e-14.
/// The rest leaves room for sites that are unit vectors to within 0.6 %.
const STATIC_BOUND: f64 = 3.8e-14;

/// Positive if `d` lies below the plane of `a`, `b`, `c` (counter-clockwise from above), negative if
/// above, zero if on it. The sign is exact for points within the unit ball; a floating-point filter
/// decides all but close cases.
///
/// Inlined and by reference, for copies on the stack would take longer than the arithmetic.
#[inline(always)]
fn side_of_plane(a: &DVec3, b: &DVec3, c: &DVec3, d: &DVec3) -> f64 {
    let (ax, ay, az) = (a.x - d.x, a.y - d.y, a.z - d.z);
    let (bx, by, bz) = (b.x - d.x, b.y - d.y, b.z - d.z);
    let (cx, cy, cz) = (c.x - d.x, c.y - d.y, c.z - d.z);
    let determinant =
        az * (bx * cy - cx * by) + bz * (cx * ay - ax * cy) + cz * (ax * by - bx * ay);
    // Not a number fails the comparison, too.
    if determinant.abs() > STATIC_BOUND {
        determinant
    } else {
        exact_side_of_plane(a, b, c, d)
    }
}

#[cold]
#[inline(never)]
fn exact_side_of_plane(a: &DVec3, b: &DVec3, c: &DVec3, d: &DVec3) -> f64 {
    let [a, b, c, d] = [a, b, c, d].map(|&DVec3 { x, y, z }| Coord3D { x, y, z });
    robust::orient3d(a, b, c, d)
}

/// Positive if `c` lies left of the great circle from `a` to `b`, that is if the three directions run
/// counter-clockwise seen from outside; exact sign.
#[inline]
fn orientation(a: &DVec3, b: &DVec3, c: &DVec3) -> f64 {
    side_of_plane(a, b, c, &DVec3::ZERO)
}

impl<E: EdgePayload> SphereMesh<E> {
    /// The site at which `h` starts.
    #[inline]
    pub(super) fn start(&self, h: HalfEdge) -> &DVec3 {
        &self.sites[self.origin(h) as usize]
    }

    /// The sites of the two ends of `e` and of the apexes left and right of it.
    #[inline(always)]
    fn kite(&self, e: Edge) -> [&DVec3; 4] {
        let (h, twin) = (2 * e, 2 * e + 1);
        let (a, b) = (self.start(h), self.start(twin));
        let (c, d) = (self.start(self.prev(h)), self.start(self.prev(twin)));
        [a, b, c, d]
    }

    /// Whether the circumcircle of one triangle at `e` does not enclose the apex of the other: the
    /// apex is not above the triangle's plane. Exact.
    pub fn is_locally_delaunay(&self, e: Edge) -> bool {
        let [a, b, c, d] = self.kite(e);
        side_of_plane(a, b, c, d) >= 0.0
    }

    /// Whether `e` is locally Delaunay and neither of its triangles inverted. Exact.
    #[inline(always)]
    fn is_sound(&self, e: Edge) -> bool {
        let [a, b, c, d] = self.kite(e);
        // Hardly ever false, so short circuits would only be in the way.
        (side_of_plane(a, b, c, d) >= 0.0)
            & (orientation(a, b, c) > 0.0)
            & (orientation(b, a, d) > 0.0)
    }

    /// Positive if `direction` is left of the great circle along `h`; exact sign.
    #[inline]
    fn side(&self, h: HalfEdge, direction: &DVec3) -> f64 {
        orientation(self.start(h), self.start(self.twin(h)), direction)
    }

    /// Whether the direction is right of the great circle along `h`. Exact.
    #[inline]
    pub(super) fn is_beyond(&self, h: HalfEdge, direction: &DVec3) -> bool {
        self.side(h, direction) < 0.0
    }

    /// Whether the direction is in the triangle of `h`, which is not inverted, or on its border. Exact.
    pub(super) fn contains(&self, h: HalfEdge, direction: &DVec3) -> bool {
        [h, self.next(h), self.prev(h)]
            .into_iter()
            .all(|side| self.side(side, direction) >= 0.0)
    }

    /// Whether the direction is in the triangle of `h`, which is not inverted, off its border. Exact.
    pub(super) fn encloses(&self, h: HalfEdge, direction: &DVec3) -> bool {
        [h, self.next(h), self.prev(h)]
            .into_iter()
            .all(|side| self.side(side, direction) > 0.0)
    }

    /// Whether the triangle of `h` is clockwise seen from outside, or flat. Exact.
    #[inline]
    pub fn is_inverted(&self, h: HalfEdge) -> bool {
        let next = self.next(h);
        let (a, b, c) = (self.start(h), self.start(next), self.start(self.next(next)));
        orientation(a, b, c) <= 0.0
    }

    /// The live edges in a range of edge numbers at which a repair has to start, ascending: those that
    /// are not locally Delaunay, and the sides of inverted triangles.
    ///
    /// Ranges that partition `0..edge_slots` can be swept in parallel; their lists, joined in
    /// order, are a queue for [`repair_from`](Self::repair_from).
    pub fn edges_to_repair(&self, slots: Range<usize>) -> Vec<Edge> {
        let mut found = Vec::new();
        for e in self.live_edges(slots) {
            if !self.is_sound(e) {
                found.push(e);
            }
        }
        found
    }

    /// What a repair has to start from around some vertices, for a mesh that is sound elsewhere, and the
    /// triangles there that are flatter than `min_ratio` (as [`slivers`](Self::slivers) finds them).
    ///
    /// Lists of vertices that together hold all that `unsettled` admits can be looked at in parallel;
    /// joined in order, their edges are a queue for [`repair_from`](Self::repair_from).
    pub fn faults_around(
        &self,
        vertices: &[Vertex],
        unsettled: impl Fn(Vertex) -> bool,
        min_ratio: f64,
    ) -> Faults {
        let mut faults = Faults::default();
        for &v in vertices {
            for h in self.outgoing(v) {
                let (rim, back) = (self.next(h), self.prev(h));
                let (a, b) = (self.origin(rim), self.origin(back));
                let known = [a, b].map(&unsettled);
                // Each edge and each triangle once: by its first vertex.
                let earlier = [known[0] && a < v, known[1] && b < v];
                if !earlier[0] && !self.is_locally_delaunay(self.edge_of(h)) {
                    faults.edges.push(self.edge_of(h));
                }
                if known == [false; 2] && !self.is_locally_delaunay(self.edge_of(rim)) {
                    faults.edges.push(self.edge_of(rim));
                }
                if earlier == [false; 2] {
                    if self.is_inverted(h) {
                        faults.edges.extend([h, rim, back].map(|h| self.edge_of(h)));
                    }
                    if self.is_flatter(h, min_ratio) {
                        faults.slivers.push(self.smallest_half_edge(h));
                    }
                }
            }
        }
        faults
    }
}

/// What is wrong with a part of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faults {
    /// Edges that are not locally Delaunay, and the sides of inverted triangles.
    pub edges: Vec<Edge>,
    /// Flat triangles, each as its smallest half-edge.
    pub slivers: Vec<HalfEdge>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_filter_agrees_with_the_exact_predicate() {
        // Corners of boxes are concyclic; steps of one ulp tip the balance.
        let mut decided = [0; 3];
        for i in 0..4000_u32 {
            let fraction = |k: u32| f64::from((i * k + 7) % 997 + 1) / 1000.0;
            let p = DVec3::new(fraction(131), fraction(257), fraction(389)).normalize();
            let [a, b, c] =
                [[1., 1., 1.], [-1., 1., 1.], [-1., -1., 1.]].map(|s| p * DVec3::from(s));
            let mut d = p * DVec3::new(1.0, -1.0, 1.0);
            match i % 4 {
                0 => d.z = d.z.next_up(),
                1 => d.z = d.z.next_down(),
                2 => d.z += 1e-13 * (fraction(51) - 0.5),
                _ => {}
            }
            let [fast, exact] = [side_of_plane, exact_side_of_plane]
                .map(|side| side(&a, &b, &c, &d))
                .map(|x| x.partial_cmp(&0.0).unwrap());
            assert_eq!(fast, exact);
            decided[(exact as i8 + 1) as usize] += 1;
        }
        assert!(decided.iter().all(|&count| count > 500), "{decided:?}");
    }
}
