//! Half-edges: incidence, iteration and the link condition.

use std::iter;
use std::ops::Range;

use glam::DVec3;

use super::{Edge, EdgePayload, HalfEdge, NONE, SphereMesh, Vertex};

impl<E: EdgePayload> SphereMesh<E> {
    /// Number of vertices, detached ones included.
    pub fn vertex_count(&self) -> usize {
        self.sites.len()
    }

    /// Number of live edges.
    pub fn edge_count(&self) -> usize {
        self.payload.len() - self.free.len()
    }

    /// Number of edge numbers in use or waiting for reuse; every edge is below it.
    pub fn edge_slots(&self) -> usize {
        self.payload.len()
    }

    /// Whether edge number `e` is live.
    pub fn is_edge(&self, e: Edge) -> bool {
        self.origin(2 * e) != NONE
    }

    /// Sites of all vertices, unit vectors.
    pub fn sites(&self) -> &[DVec3] {
        &self.sites
    }

    /// Site of vertex `v`, a unit vector.
    #[inline]
    pub fn site(&self, v: Vertex) -> DVec3 {
        self.sites[v as usize]
    }

    /// Moves vertex `v` to the unit vector `site`; repair the mesh afterwards.
    pub fn set_site(&mut self, v: Vertex, site: DVec3) {
        self.sites[v as usize] = site;
    }

    /// Sites of all vertices, to be moved; keep them unit vectors and repair the mesh afterwards.
    pub fn sites_mut(&mut self) -> &mut [DVec3] {
        &mut self.sites
    }

    /// The vertex at which `h` starts.
    #[inline]
    pub fn origin(&self, h: HalfEdge) -> Vertex {
        self.origin[h as usize]
    }

    /// The vertex at which `h` ends.
    #[inline]
    pub fn dest(&self, h: HalfEdge) -> Vertex {
        self.origin(self.twin(h))
    }

    /// The half-edge after `h` in its triangle, counter-clockwise.
    #[inline]
    pub fn next(&self, h: HalfEdge) -> HalfEdge {
        self.next[h as usize]
    }

    /// The half-edge before `h` in its triangle.
    #[inline]
    pub fn prev(&self, h: HalfEdge) -> HalfEdge {
        self.next(self.next(h))
    }

    /// The other half of the edge of `h`.
    #[inline]
    pub fn twin(&self, h: HalfEdge) -> HalfEdge {
        h ^ 1
    }

    /// The third vertex of the triangle of `h`, opposite to `h`.
    #[inline]
    pub fn apex(&self, h: HalfEdge) -> Vertex {
        self.origin(self.prev(h))
    }

    /// The edge of which `h` is a half.
    #[inline]
    pub fn edge_of(&self, h: HalfEdge) -> Edge {
        h / 2
    }

    /// The two vertices of edge `e`: origin and destination of half-edge `2e`.
    #[inline]
    pub fn endpoints(&self, e: Edge) -> (Vertex, Vertex) {
        (self.origin(2 * e), self.origin(2 * e + 1))
    }

    /// Payload of edge `e`.
    pub fn payload(&self, e: Edge) -> &E {
        &self.payload[e as usize]
    }

    /// Payload of edge `e`, to be changed.
    pub fn payload_mut(&mut self, e: Edge) -> &mut E {
        &mut self.payload[e as usize]
    }

    /// The half-edges starting at `v`, counter-clockwise; none if `v` is detached.
    pub fn outgoing(&self, v: Vertex) -> impl Iterator<Item = HalfEdge> {
        let first = self.vertex_edge[v as usize];
        let mut current = first;
        iter::from_fn(move || {
            let h = current;
            if h == NONE {
                return None;
            }
            let ccw = self.twin(self.prev(h));
            current = if ccw == first { NONE } else { ccw };
            Some(h)
        })
    }

    /// The neighbours of `v`, counter-clockwise.
    pub fn neighbours(&self, v: Vertex) -> impl Iterator<Item = Vertex> {
        self.outgoing(v).map(|h| self.dest(h))
    }

    /// Number of neighbours of `v`.
    pub fn degree(&self, v: Vertex) -> usize {
        self.outgoing(v).count()
    }

    /// The half-edge from `u` to `v`, if they are neighbours.
    pub fn half_edge_between(&self, u: Vertex, v: Vertex) -> Option<HalfEdge> {
        self.outgoing(u).find(|&h| self.dest(h) == v)
    }

    /// All live edges, ascending.
    pub fn edges(&self) -> impl Iterator<Item = Edge> {
        self.live_edges(0..self.edge_slots())
    }

    /// The live edges of a range of edge numbers, ascending.
    pub(super) fn live_edges(&self, slots: Range<usize>) -> impl Iterator<Item = Edge> {
        slots.map(|e| e as Edge).filter(|&e| self.is_edge(e))
    }

    /// One half-edge per triangle, the smallest of its three; ascending.
    pub fn triangles(&self) -> impl Iterator<Item = HalfEdge> {
        (0..self.origin.len() as HalfEdge).filter(|&h| {
            self.origin(h) != NONE && {
                let next = self.next(h);
                h < next && h < self.next(next)
            }
        })
    }

    /// The half-edge that stands for the triangle of `h` among [`triangles`](Self::triangles).
    pub(super) fn smallest_half_edge(&self, h: HalfEdge) -> HalfEdge {
        h.min(self.next(h)).min(self.prev(h))
    }

    /// The vertices of the triangle of `h`: origin and destination of `h`, then the apex.
    #[inline]
    pub fn triangle_vertices(&self, h: HalfEdge) -> [Vertex; 3] {
        let next = self.next(h);
        [h, next, self.next(next)].map(|h| self.origin(h))
    }

    /// The sites of [`triangle_vertices`](Self::triangle_vertices).
    #[inline]
    pub(super) fn triangle_sites(&self, h: HalfEdge) -> [DVec3; 3] {
        self.triangle_vertices(h).map(|v| self.site(v))
    }

    /// Whether `v` has no edges, as after a [`collapse`](Self::collapse) that removed it.
    pub fn is_detached(&self, v: Vertex) -> bool {
        self.vertex_edge[v as usize] == NONE
    }

    /// Whether `origin(h)` can be collapsed onto `dest(h)` with the surface staying a triangulated
    /// sphere: the link condition (Dey et al. 1998).
    ///
    /// The two vertices may share no neighbours but the apexes of the two triangles at `h`, and
    /// more than four vertices must be left. Geometry is [`collapse_quality`](Self::collapse_quality)'s.
    pub fn can_collapse(&self, h: HalfEdge) -> bool {
        let (removed, kept) = (self.origin(h), self.dest(h));
        let shared = self
            .neighbours(kept)
            .filter(|&v| self.neighbours(removed).any(|u| u == v))
            .count();
        shared == 2 && self.attached_count() > 4
    }

    /// Number of vertices with edges, by Euler's formula.
    fn attached_count(&self) -> usize {
        self.edge_count() / 3 + 2
    }

    /// The same triangulation without payloads.
    pub fn without_payload(&self) -> SphereMesh<()> {
        self.map_payload(|_| ())
    }

    /// The same triangulation with `f` of each payload; `f` is not called for dead edges.
    pub fn map_payload<F: EdgePayload>(&self, mut f: impl FnMut(&E) -> F) -> SphereMesh<F> {
        let payload = self.payload.iter().enumerate().map(|(e, payload)| {
            if self.is_edge(e as Edge) {
                f(payload)
            } else {
                F::default()
            }
        });
        SphereMesh {
            payload: payload.collect(),
            sites: self.sites.clone(),
            vertex_edge: self.vertex_edge.clone(),
            origin: self.origin.clone(),
            next: self.next.clone(),
            free: self.free.clone(),
        }
    }
}
