//! Thin triangles, which the Delaunay property alone does not exclude.

use glam::DVec3;

use super::{EdgePayload, Flip, HalfEdge, RepairError, SphereMesh, Vertex};

/// Rounds of moving and flipping after which remaining slivers are left alone.
const ROUNDS: usize = 16;

/// How much taller than asked a sliver is made, so that small moves nearby do not undo it.
const MARGIN: f64 = 1.1;

/// Keeps rounding from dropping slivers in the coarse test.
const SLACK: f64 = 1.0 + 1e-9;

/// What [`SphereMesh::repair_slivers`] did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SliverRepair {
    /// The vertices moved, in order; one may occur repeatedly.
    pub moved: Vec<Vertex>,
    /// The flips made, in order.
    pub flips: Vec<Flip>,
}

#[inline(always)]
fn doubled_area_squared(a: &DVec3, b: &DVec3, c: &DVec3) -> f64 {
    (*b - *a).cross(*c - *a).length_squared()
}

impl<E: EdgePayload> SphereMesh<E> {
    /// Smallest height of the triangle of `h` as a fraction of its longest side: at most √3/2
    /// (equilateral), 0 if flat.
    pub fn height_ratio(&self, h: HalfEdge) -> f64 {
        let [a, b, c] = self.triangle_sites(h);
        let longest = a
            .distance_squared(b)
            .max(b.distance_squared(c))
            .max(c.distance_squared(a));
        (b - a).cross(c - a).length() / longest
    }

    /// Whether the triangle of `h` has a [`height_ratio`](Self::height_ratio) below a limit, or nearly so.
    #[inline]
    pub(super) fn is_flatter(&self, h: HalfEdge, ratio: f64) -> bool {
        let next = self.next(h);
        let (a, b, c) = (self.start(h), self.start(next), self.start(self.next(next)));
        let longest = a
            .distance_squared(*b)
            .max(b.distance_squared(*c))
            .max(c.distance_squared(*a));
        doubled_area_squared(a, b, c) <= SLACK * ratio * ratio * longest * longest
    }

    /// The triangles whose [`height_ratio`](Self::height_ratio) is below `min_ratio`, each as its
    /// longest half-edge; in the order of [`triangles`](Self::triangles).
    pub fn slivers(&self, min_ratio: f64) -> Vec<HalfEdge> {
        // Half-edge by half-edge the test needs no root, no quotient, and no hardly predictable
        // choice of one half-edge per triangle. The longest side of a sliver always passes it.
        let squared_ratio = SLACK * min_ratio * min_ratio;
        let mut slivers: Vec<HalfEdge> = Vec::new();
        for e in self.edges() {
            let (h, twin) = (2 * e, 2 * e + 1);
            let (a, b) = (self.start(h), self.start(twin));
            let (c, d) = (self.start(self.prev(h)), self.start(self.prev(twin)));
            let length_squared = a.distance_squared(*b);
            let limit = squared_ratio * length_squared * length_squared;
            if doubled_area_squared(a, b, c) <= limit {
                slivers.push(self.smallest_half_edge(h));
            }
            if doubled_area_squared(a, b, d) <= limit {
                slivers.push(self.smallest_half_edge(twin));
            }
        }
        slivers.sort_unstable();
        slivers.dedup();
        slivers.retain(|&h| self.height_ratio(h) < min_ratio);
        slivers.iter().map(|&h| self.longest_side(h)).collect()
    }

    /// Moves vertices so that no triangle is left with a [`height_ratio`](Self::height_ratio) below
    /// `min_ratio`, and keeps the mesh Delaunay.
    ///
    /// In each sliver the vertex nearest to the longest side moves away from it; if `movable` does
    /// not admit that vertex, an end of the side moves the other way. Slivers without a movable
    /// vertex remain, as do those which resist repeated moves: [`slivers`](Self::slivers) tells.
    /// The mesh must be Delaunay; `min_ratio` is a few hundredths at most for displacements to be
    /// small.
    ///
    /// # Errors
    ///
    /// [`RepairError`] as for [`repair_from`](Self::repair_from).
    pub fn repair_slivers(
        &mut self,
        min_ratio: f64,
        movable: impl Fn(Vertex) -> bool,
    ) -> Result<SliverRepair, RepairError> {
        let slivers = self.slivers(min_ratio);
        self.heighten_all(slivers, min_ratio, movable)
    }

    /// Like [`repair_slivers`](Self::repair_slivers), but starts from the given triangles, which may have
    /// been flipped away or be no slivers, and looks for others only where it, or one of the flips,
    /// changed something.
    ///
    /// # Errors
    ///
    /// [`RepairError`] as for [`repair_from`](Self::repair_from).
    pub fn repair_slivers_from(
        &mut self,
        triangles: Vec<HalfEdge>,
        flips: &[Flip],
        min_ratio: f64,
        movable: impl Fn(Vertex) -> bool,
    ) -> Result<SliverRepair, RepairError> {
        let changed = flips.iter().flat_map(|flip| flip.after);
        let mut slivers = self.slivers_at(changed, min_ratio);
        let flat = |&h: &HalfEdge| self.is_half_edge(h) && self.height_ratio(h) < min_ratio;
        let given = triangles.into_iter().filter(flat);
        slivers.extend(given.map(|h| self.longest_side(h)));
        slivers.sort_unstable();
        slivers.dedup();
        self.heighten_all(slivers, min_ratio, movable)
    }

    fn heighten_all(
        &mut self,
        mut slivers: Vec<HalfEdge>,
        min_ratio: f64,
        movable: impl Fn(Vertex) -> bool,
    ) -> Result<SliverRepair, RepairError> {
        let mut repair = SliverRepair::default();
        for _ in 0..ROUNDS {
            let mut moved: Vec<Vertex> = Vec::new();
            for &h in &slivers {
                // A vertex moved in this round may already have cured its other slivers.
                if self.height_ratio(h) < min_ratio {
                    moved.extend(self.heighten(h, MARGIN * min_ratio, &movable));
                }
            }
            if moved.is_empty() {
                break;
            }
            let queue = moved.iter().flat_map(|&v| self.star_edges(v)).collect();
            let flips = self.repair_locally(queue)?;
            let changed = flips
                .iter()
                .flat_map(|flip| flip.after)
                .chain(moved.iter().copied());
            slivers = self.slivers_at(changed, min_ratio);
            repair.moved.extend(moved);
            repair.flips.extend(flips);
        }
        Ok(repair)
    }

    /// The slivers that have one of the given vertices as a corner.
    fn slivers_at(
        &self,
        vertices: impl IntoIterator<Item = Vertex>,
        min_ratio: f64,
    ) -> Vec<HalfEdge> {
        let mut slivers: Vec<HalfEdge> = vertices
            .into_iter()
            .flat_map(|v| self.outgoing(v))
            .filter(|&h| self.height_ratio(h) < min_ratio)
            .map(|h| self.longest_side(h))
            .collect();
        slivers.sort_unstable();
        slivers.dedup();
        slivers
    }

    /// Moves one corner of the triangle whose longest side is `h`, to make it `ratio` times as high
    /// as long. Returns the vertex moved, if one is movable.
    fn heighten(
        &mut self,
        h: HalfEdge,
        ratio: f64,
        movable: impl Fn(Vertex) -> bool,
    ) -> Option<Vertex> {
        let [a, b, apex] = self.triangle_vertices(h);
        let [pa, pb, pc] = self.triangle_sites(h);
        let (near, far) = if pc.distance_squared(pa) <= pc.distance_squared(pb) {
            (a, b)
        } else {
            (b, a)
        };
        let v = [apex, near, far].into_iter().find(|&v| movable(v))?;
        let inward = pa.cross(pb).normalize();
        let lack = ratio * pa.distance(pb) - inward.dot(pc);
        let step = if v == apex { lack } else { -lack };
        self.set_site(v, (self.site(v) + step * inward).normalize());
        Some(v)
    }

    fn longest_side(&self, h: HalfEdge) -> HalfEdge {
        let length = |h: HalfEdge| {
            let (a, b) = (self.origin(h), self.dest(h));
            self.site(a).distance_squared(self.site(b))
        };
        let mut longest = h;
        for side in [self.next(h), self.prev(h)] {
            if length(side) > length(longest) {
                longest = side;
            }
        }
        longest
    }
}
