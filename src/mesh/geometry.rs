//! Areas, circumcircles and shapes on the unit sphere.

use glam::DVec3;

use super::{EdgePayload, HalfEdge, SphereMesh, Vertex};

/// Largest deviation of a squared length from 1 at which a vector counts as normalised.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The unit vector along `vector`, which is kept bit for bit if its length is 1 to within rounding;
/// `None` if it is not finite, or zero.
pub(super) fn unit(vector: DVec3) -> Option<DVec3> {
    if (vector.length_squared() - 1.0).abs() <= ROUNDING {
        return Some(vector);
    }
    // Scaled first, the square of no length over- or underflows.
    let direction = vector / vector.abs().max_element();
    direction.is_finite().then(|| direction.normalize())
}

/// Signed area of a spherical triangle in steradians (Van Oosterom & Strackee 1983).
fn spherical_area(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    // Differences keep the triple product accurate for small triangles.
    let triple = a.dot((b - a).cross(c - a));
    2.0 * libm::atan2(triple, 1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

/// Scale-free shape of a triangle: 1 if equilateral, 0 if flat, negative if clockwise from outside.
fn shape_quality(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    const EQUILATERAL: f64 = 3.464_101_615_137_754_6; // 2√3
    let doubled_area = (b - a).cross(c - a).dot((a + b + c).normalize_or_zero());
    let squares = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
    if squares > 0.0 {
        EQUILATERAL * doubled_area / squares
    } else {
        0.0
    }
}

/// Circumcentre on the side from which `a`, `b`, `c` run counter-clockwise.
fn circumcentre([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize()
}

impl<E: EdgePayload> SphereMesh<E> {
    /// Signed area of the triangle of `h` in steradians; negative if inverted.
    pub fn triangle_area(&self, h: HalfEdge) -> f64 {
        let [a, b, c] = self.triangle_sites(h);
        spherical_area(a, b, c)
    }

    /// Circumcentre of the triangle of `h`, a unit vector: a corner of the Voronoi cells.
    ///
    /// Not a number if two of the sites coincide.
    pub fn circumcentre(&self, h: HalfEdge) -> DVec3 {
        circumcentre(self.triangle_sites(h))
    }

    /// Circumradius of the triangle of `h`, an angle in radians.
    pub fn circumradius(&self, h: HalfEdge) -> f64 {
        let chord = self.circumcentre(h).distance(self.site(self.origin(h)));
        2.0 * libm::asin((0.5 * chord).min(1.0))
    }

    /// Shape of the triangle of `h` in [-1, 1]: 1 if equilateral, 0 if flat, negative if inverted.
    pub fn triangle_quality(&self, h: HalfEdge) -> f64 {
        let [a, b, c] = self.triangle_sites(h);
        shape_quality(a, b, c)
    }

    /// Area of the Voronoi cell of `v` in steradians; 0 if detached.
    ///
    /// Parts that obtuse triangles cut off count negatively, so the cells of a Delaunay mesh cover
    /// the sphere exactly once.
    pub fn cell_area(&self, v: Vertex) -> f64 {
        let site = self.site(v);
        let mut corners = self.outgoing(v).map(|h| self.circumcentre(h));
        let Some(first) = corners.next() else {
            return 0.0;
        };
        let mut area = 0.0;
        let mut previous = first;
        for corner in corners.chain([first]) {
            area += spherical_area(site, previous, corner);
            previous = corner;
        }
        area
    }

    /// [`cell_area`](Self::cell_area) of every vertex.
    pub fn cell_areas(&self) -> Vec<f64> {
        (0..self.vertex_count() as Vertex)
            .map(|v| self.cell_area(v))
            .collect()
    }

    /// [`triangle_quality`](Self::triangle_quality) of the triangle that flipping `h` would cut off
    /// at its destination.
    pub(super) fn ear_quality(&self, h: HalfEdge) -> f64 {
        let (left, right) = (self.apex(h), self.apex(self.twin(h)));
        shape_quality(self.site(right), self.site(self.dest(h)), self.site(left))
    }

    /// Worst [`triangle_quality`](Self::triangle_quality) among the triangles that would remain of
    /// `origin(h)`'s after its collapse onto `dest(h)`; not above 0 if one would be inverted or flat.
    pub fn collapse_quality(&self, h: HalfEdge) -> f64 {
        let target = self.site(self.dest(h));
        // The two triangles at `h` vanish; they are the ones that have the target as a corner.
        self.outgoing(self.origin(h))
            .filter(|&k| k != h && self.next(self.next(k)) != self.twin(h))
            .map(|k| {
                let (a, b) = (self.site(self.dest(k)), self.site(self.apex(k)));
                shape_quality(target, a, b)
            })
            .fold(1.0, f64::min)
    }

    /// The legal collapse of `v` onto a neighbour that `accept` admits with the highest
    /// [`collapse_quality`](Self::collapse_quality), if that is positive.
    pub fn best_collapse(&self, v: Vertex, accept: impl Fn(Vertex) -> bool) -> Option<HalfEdge> {
        self.best_collapse_any(v, accept)
            .filter(|&h| self.collapse_quality(h) > 0.0)
    }

    /// Like [`best_collapse`](Self::best_collapse), but even if every collapse inverts a triangle.
    pub fn best_collapse_any(
        &self,
        v: Vertex,
        accept: impl Fn(Vertex) -> bool,
    ) -> Option<HalfEdge> {
        self.outgoing(v)
            .filter(|&h| accept(self.dest(h)) && self.can_collapse(h))
            .map(|h| (h, self.collapse_quality(h)))
            .reduce(|best, other| if other.1 > best.1 { other } else { best })
            .map(|(h, _)| h)
    }
}
