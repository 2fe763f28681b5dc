//! Local changes: flip, split, insertion, collapse, removal, renumbering.

use glam::DVec3;
use thiserror::Error;

use super::geometry::unit;
use super::{Edge, EdgePayload, Flip, HalfEdge, NONE, RepairError, SphereMesh, Vertex};

/// Squared distance up to which two sites are the same to within rounding.
const COINCIDENT: f64 = 1e-30;

/// Why a site could not be inserted.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum EditError {
    /// The site is not a finite vector of positive length.
    #[error("site {0} has no direction")]
    NoDirection(DVec3),
    /// The site is that of an existing vertex, to within rounding.
    #[error("the site is already vertex {0}")]
    Duplicate(Vertex),
    /// The mesh around the new vertex cannot be made Delaunay.
    #[error(transparent)]
    Repair(#[from] RepairError),
}

impl<E: EdgePayload> SphereMesh<E> {
    /// Replaces the edge of `h` by the other diagonal of its two triangles and notifies its payload.
    ///
    /// Returns `false`, with nothing changed, if the other diagonal is already an edge. This
    /// includes every flip that would leave an endpoint with fewer than three neighbours.
    pub fn flip(&mut self, h: HalfEdge) -> bool {
        let twin = self.twin(h);
        let (left, right) = (self.apex(h), self.apex(twin));
        if self.half_edge_between(left, right).is_some() {
            return false;
        }
        let (a, b) = (self.origin(h), self.dest(h));
        let (b_left, left_a) = (self.next(h), self.prev(h));
        let (a_right, right_b) = (self.next(twin), self.prev(twin));
        let e = self.edge_of(h);
        let mut payload = self.payload(e).clone();
        self.set_endpoints(h, right, left);
        self.link_triangle(h, left_a, a_right);
        self.link_triangle(twin, right_b, b_left);
        self.vertex_edge[a as usize] = a_right;
        self.vertex_edge[b as usize] = b_left;
        payload.flipped();
        *self.payload_mut(e) = payload;
        true
    }

    /// Inserts a vertex with the unit vector `site` on the edge of `h`, joined to both apexes.
    ///
    /// Returns its number, the former vertex count. The half-edge `h` now ends at the new vertex; its
    /// edge and the three new ones have default payloads.
    pub fn split_edge(&mut self, h: HalfEdge, site: DVec3) -> Vertex {
        let twin = self.twin(h);
        let (end, left, right) = (self.dest(h), self.apex(h), self.apex(twin));
        let (end_left, left_start) = (self.next(h), self.prev(h));
        let (start_right, right_end) = (self.next(twin), self.prev(twin));
        let v = self.push_vertex(site, twin);
        self.origin[twin as usize] = v;
        let [to_end, to_left, to_right] = [end, left, right].map(|w| self.new_edge(v, w));
        self.link_triangle(h, to_left, left_start);
        self.link_triangle(to_end, end_left, to_left ^ 1);
        self.link_triangle(twin, start_right, to_right ^ 1);
        self.link_triangle(to_right, right_end, to_end ^ 1);
        self.vertex_edge[end as usize] = end_left;
        let e = self.edge_of(h);
        *self.payload_mut(e) = E::default();
        v
    }

    /// Inserts a vertex with the unit vector `site` into the triangle of `h`.
    ///
    /// Returns its number, the former vertex count. The three new edges have default payloads.
    pub fn split_triangle(&mut self, h: HalfEdge, site: DVec3) -> Vertex {
        let v = self.push_vertex(site, NONE);
        let spokes = [(); 3].map(|()| self.new_edge(v, NONE));
        self.attach(v, h, spokes);
        v
    }

    /// Inserts a vertex with the direction `site` and makes the mesh Delaunay around it.
    ///
    /// Returns its number, the former vertex count, and the flips made. The search for the triangle
    /// starts at vertex `hint`, best one nearby.
    ///
    /// # Errors
    ///
    /// [`EditError::NoDirection`] and [`EditError::Duplicate`] leave the mesh unchanged. After
    /// [`EditError::Repair`] the vertex is in the mesh, which is not Delaunay.
    pub fn insert(&mut self, site: DVec3, hint: Vertex) -> Result<(Vertex, Vec<Flip>), EditError> {
        let site = unit(site).ok_or(EditError::NoDirection(site))?;
        let location = self.locate(site, hint);
        let coincides = |v: &&Vertex| self.site(**v).distance_squared(site) <= COINCIDENT;
        if let Some(&twin) = location.vertices.iter().find(coincides) {
            return Err(EditError::Duplicate(twin));
        }
        // A site on an edge makes a flat triangle, whose long side is not Delaunay and flips.
        let v = self.split_triangle(location.half_edge, site);
        let flips = self.repair_from(self.star_edges(v))?;
        Ok((v, flips))
    }

    /// Removes `origin(h)` by moving its triangles to `dest(h)`, which is returned.
    ///
    /// The removed vertex becomes detached; edges that now start elsewhere have default payloads.
    /// Three edges die: `h` and, of either triangle at `h`, the
    /// side at the removed vertex. The caller ensures [`can_collapse`](Self::can_collapse).
    pub fn collapse(&mut self, h: HalfEdge) -> Vertex {
        debug_assert!(self.can_collapse(h), "collapse violates the link condition");
        let twin = self.twin(h);
        let (removed, kept) = (self.origin(h), self.dest(h));
        let moved: Vec<HalfEdge> = self.outgoing(removed).collect();
        // If three triangles meet at the removed vertex, `left_old` and `right_old` bound the same
        // one, and the assignments below pass the links on from the one to the other.
        //
        // The sides at the kept vertex take the place of the sides at the removed one.
        let (left_new, left_old) = (self.next(h), self.twin(self.prev(h)));
        let (right_new, right_old) = (self.prev(twin), self.twin(self.next(twin)));
        let (left_before, right_before) = (self.prev(left_old), self.prev(right_old));
        let (left, right) = (self.dest(left_new), self.origin(right_new));
        for k in moved {
            let (spoke, rim) = (self.edge_of(k), self.edge_of(self.next(k)));
            self.origin[k as usize] = kept;
            *self.payload_mut(spoke) = E::default();
            self.payload_mut(rim).reshaped();
        }
        self.next[left_new as usize] = self.next(left_old);
        self.next[left_before as usize] = left_new;
        self.next[right_new as usize] = self.next(right_old);
        self.next[right_before as usize] = right_new;
        self.vertex_edge[kept as usize] = left_new;
        self.vertex_edge[left as usize] = self.twin(left_new);
        self.vertex_edge[right as usize] = right_new;
        self.vertex_edge[removed as usize] = NONE;
        for dead in [h, left_old, right_old] {
            self.kill_edge(self.edge_of(dead));
        }
        kept
    }

    /// Deletes the detached vertex `v`. The last vertex takes its number; returns the number that
    /// vertex had, or `None` if `v` was the last.
    ///
    /// # Panics
    ///
    /// If `v` is not detached.
    pub fn remove_detached(&mut self, v: Vertex) -> Option<Vertex> {
        assert!(self.is_detached(v), "vertex {v} still has edges");
        self.sites.swap_remove(v as usize);
        self.vertex_edge.swap_remove(v as usize);
        let last = self.vertex_count() as Vertex;
        if v == last {
            return None;
        }
        let outgoing: Vec<HalfEdge> = self.outgoing(v).collect();
        for h in outgoing {
            self.origin[h as usize] = v;
        }
        Some(last)
    }

    /// Renumbers the vertices: vertex `order[k]` becomes vertex `k`. Edges follow them in memory and
    /// are compacted; payloads stay with their edges, and halves of an edge keep their sense.
    ///
    /// # Panics
    ///
    /// If `order` is not a permutation of the vertex numbers.
    pub fn renumber(&mut self, order: &[Vertex]) {
        let mut place = vec![NONE; self.vertex_count()];
        for (&old, new) in order.iter().zip(0..) {
            assert_eq!(place[old as usize], NONE, "vertex {old} ordered twice");
            place[old as usize] = new;
        }
        assert_eq!(order.len(), place.len(), "order omits vertices");
        self.sites = order.iter().map(|&v| self.site(v)).collect();
        self.vertex_edge = order
            .iter()
            .map(|&v| self.vertex_edge[v as usize])
            .collect();
        for origin in self.origin.iter_mut().filter(|origin| **origin != NONE) {
            *origin = place[*origin as usize];
        }
        self.renumber_edges();
    }

    /// Numbers the edges in the order in which the vertices meet them, without gaps.
    pub(super) fn renumber_edges(&mut self) {
        let mut place: Vec<Edge> = vec![NONE; self.edge_slots()];
        let mut order: Vec<Edge> = Vec::with_capacity(self.edge_count());
        for v in 0..self.vertex_count() as Vertex {
            for h in self.outgoing(v) {
                let e = self.edge_of(h);
                if place[e as usize] == NONE {
                    place[e as usize] = order.len() as Edge;
                    order.push(e);
                }
            }
        }
        let moved = |h: HalfEdge| 2 * place[h as usize / 2] + h % 2;
        let halves = || order.iter().flat_map(|&e| [2 * e, 2 * e + 1]);
        // One after the other, so that only one lies in memory twice.
        self.origin = halves().map(|h| self.origin(h)).collect();
        self.next = halves().map(|h| moved(self.next(h))).collect();
        self.payload = order
            .iter()
            .map(|&e| std::mem::take(&mut self.payload[e as usize]))
            .collect();
        for h in self.vertex_edge.iter_mut().filter(|h| **h != NONE) {
            *h = moved(*h);
        }
        self.free.clear();
    }

    /// Joins the detached vertex `v` to the corners of the triangle of `h` by three edges, given by
    /// their halves that start at `v`.
    pub(super) fn attach(&mut self, v: Vertex, h: HalfEdge, spokes: [HalfEdge; 3]) {
        let sides = [h, self.next(h), self.prev(h)];
        let corners = self.triangle_vertices(h);
        for (spoke, corner) in spokes.into_iter().zip(corners) {
            self.set_endpoints(spoke, v, corner);
        }
        for i in 0..3 {
            self.link_triangle(spokes[i], sides[i], self.twin(spokes[(i + 1) % 3]));
        }
        self.vertex_edge[v as usize] = spokes[0];
    }

    /// Takes vertex `v` of degree three out of the mesh. Returns a side of the triangle it leaves
    /// and the half-edges of its former edges that started at `v`, which are dead, but not free, until
    /// [`attach`](Self::attach) reuses them.
    pub(super) fn detach(&mut self, v: Vertex) -> (HalfEdge, [HalfEdge; 3]) {
        let first = self.vertex_edge[v as usize];
        let second = self.twin(self.prev(first));
        let third = self.twin(self.prev(second));
        let spokes = [first, second, third];
        let sides = spokes.map(|h| self.next(h));
        for (side, h) in sides.into_iter().zip(spokes) {
            let corner = self.dest(h) as usize;
            self.vertex_edge[corner] = side;
        }
        self.link_triangle(sides[0], sides[1], sides[2]);
        self.vertex_edge[v as usize] = NONE;
        for h in spokes {
            self.set_endpoints(h, NONE, NONE);
        }
        (sides[0], spokes)
    }

    /// The edges at `v` and those opposite to it.
    pub(super) fn star_edges(&self, v: Vertex) -> Vec<Edge> {
        self.outgoing(v)
            .flat_map(|h| [self.edge_of(h), self.edge_of(self.next(h))])
            .collect()
    }

    /// Makes three half-edges a triangle, and notifies their edges.
    pub(super) fn link_triangle(&mut self, a: HalfEdge, b: HalfEdge, c: HalfEdge) {
        self.next[a as usize] = b;
        self.next[b as usize] = c;
        self.next[c as usize] = a;
        for side in [a, b, c] {
            let e = self.edge_of(side);
            self.payload_mut(e).reshaped();
        }
    }

    fn push_vertex(&mut self, site: DVec3, outgoing: HalfEdge) -> Vertex {
        self.sites.push(site);
        self.vertex_edge.push(outgoing);
        (self.sites.len() - 1) as Vertex
    }

    /// An edge from `a` to `b` that is in no triangle yet; its half-edge from `a`.
    fn new_edge(&mut self, a: Vertex, b: Vertex) -> HalfEdge {
        let e = self.free.pop().unwrap_or_else(|| {
            self.origin.extend([NONE; 2]);
            self.next.extend([NONE; 2]);
            self.payload.push(E::default());
            (self.payload.len() - 1) as Edge
        });
        self.set_endpoints(2 * e, a, b);
        2 * e
    }

    fn set_endpoints(&mut self, h: HalfEdge, origin: Vertex, dest: Vertex) {
        self.origin[h as usize] = origin;
        self.origin[h as usize ^ 1] = dest;
    }

    fn kill_edge(&mut self, e: Edge) {
        self.set_endpoints(2 * e, NONE, NONE);
        for h in [2 * e, 2 * e + 1] {
            self.next[h as usize] = NONE;
        }
        self.payload[e as usize] = E::default();
        self.free.push(e);
    }
}
