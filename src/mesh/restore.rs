//! A mesh from what tells it apart: for meshes that were stored.

use glam::DVec3;
use thiserror::Error;

use super::{Edge, EdgePayload, HalfEdge, MeshFault, NONE, SphereMesh, Vertex};

/// Why a mesh could not be restored.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum RestoreError {
    /// The lists do not belong together.
    #[error("{what}: {found} where {expected} are needed")]
    Length {
        /// What was counted.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there must be.
        expected: usize,
    },
    /// An edge joins vertices that do not exist, or a vertex to itself.
    #[error("edge {0} has no two ends")]
    Ends(Edge),
    /// A dead edge is listed as free twice or not at all, or a live one once.
    #[error("edge {0} is listed wrongly among the free ones")]
    Free(Edge),
    /// The first half-edge of a vertex does not start there.
    #[error("half-edge {1} does not start at vertex {0}")]
    First(Vertex, HalfEdge),
    /// The edges do not form a triangulated sphere.
    #[error(transparent)]
    Fault(#[from] MeshFault),
}

impl<E: EdgePayload> SphereMesh<E> {
    /// The half-edge at which the fan of vertex `v` begins, [`NONE`] if it is detached.
    pub fn first_outgoing(&self, v: Vertex) -> HalfEdge {
        self.vertex_edge[v as usize]
    }

    /// Numbers of dead edges; the last is reused first.
    pub fn free_edges(&self) -> &[Edge] {
        &self.free
    }

    /// The mesh whose vertex `v` has the site `sites[v]` and a fan that begins at half-edge `first[v]`, whose
    /// edge `e` runs from `ends[e][0]` to `ends[e][1]` ([`NONE`] twice on dead ones) with `payload[e]`, and
    /// whose dead edges will be reused from the end of `free`.
    ///
    /// Given back what another mesh says of itself, it is that mesh, numbers included.
    ///
    /// # Errors
    /// [`RestoreError`] unless the edges form a triangulated sphere without folds. Whether they are Delaunay
    /// is for [`check`](Self::check) to say.
    pub fn restore(
        sites: Vec<DVec3>,
        first: Vec<HalfEdge>,
        ends: &[[Vertex; 2]],
        payload: Vec<E>,
        free: Vec<Edge>,
    ) -> Result<Self, RestoreError> {
        let length = |what, found, expected| {
            if found == expected {
                Ok(())
            } else {
                Err(RestoreError::Length {
                    what,
                    found,
                    expected,
                })
            }
        };
        let vertices = sites.len();
        length("first half-edges", first.len(), vertices)?;
        length("payloads", payload.len(), ends.len())?;
        length("free edges", free.len().min(ends.len()), free.len())?;
        // Euler's formula, so that nothing below grows beyond what was given.
        let live = ends.len() - free.len();
        length("edges", live, (3 * vertices).saturating_sub(6))?;
        let mut is_free = vec![false; ends.len()];
        for &e in &free {
            match is_free.get_mut(e as usize) {
                Some(listed) if !*listed => *listed = true,
                _ => return Err(RestoreError::Free(e)),
            }
        }
        for ((e, &[a, b]), &free) in (0..).zip(ends).zip(&is_free) {
            if free != (a == NONE && b == NONE) {
                return Err(RestoreError::Free(e));
            }
            if !free && (a.max(b) as usize >= vertices || a == b) {
                return Err(RestoreError::Ends(e));
            }
        }
        for (v, &h) in (0..).zip(&first) {
            let origin = ends.as_flattened().get(h as usize);
            if origin != Some(&v) {
                return Err(RestoreError::First(v, h));
            }
        }
        let mut mesh = Self {
            sites,
            vertex_edge: first,
            origin: ends.as_flattened().to_vec(),
            next: vec![NONE; 2 * ends.len()],
            payload,
            free,
        };
        mesh.check_sites()?;
        mesh.link_fans();
        mesh.check_surface()?;
        Ok(mesh)
    }

    /// Links every vertex's half-edges counter-clockwise, as their directions lie around it.
    fn link_fans(&mut self) {
        let halves = 0..self.origin.len() as HalfEdge;
        let live = |mesh: &Self, h: &HalfEdge| mesh.is_half_edge(*h);
        // All half-edges by the vertex at which they start.
        let mut starts = vec![0_usize; self.vertex_count() + 1];
        for h in halves.clone().filter(|h| live(self, h)) {
            starts[self.origin(h) as usize + 1] += 1;
        }
        for v in 0..self.vertex_count() {
            starts[v + 1] += starts[v];
        }
        let mut fans = vec![NONE; starts[self.vertex_count()]];
        let mut filled = starts.clone();
        for h in halves.filter(|h| live(self, h)) {
            let place = &mut filled[self.origin(h) as usize];
            fans[*place] = h;
            *place += 1;
        }
        let mut around = Vec::new();
        for v in 0..self.vertex_count() {
            let site = self.sites[v];
            let (east, north) = site.any_orthonormal_pair();
            around.clear();
            around.extend(fans[starts[v]..starts[v + 1]].iter().map(|&h| {
                let way = self.site(self.dest(h)) - site;
                (turn(way.dot(east), way.dot(north)), h)
            }));
            // Total, for sites may coincide until that is refused.
            around.sort_by(|a, b| a.0.total_cmp(&b.0));
            for (i, &(_, h)) in around.iter().enumerate() {
                let ccw = around[(i + 1) % around.len()].1;
                // The triangle between the two comes in along the one and leaves along the other.
                let inward = self.twin(ccw) as usize;
                self.next[inward] = h;
            }
        }
    }
}

/// Grows with the angle of a direction, from 0 to 4 in one turn.
fn turn(x: f64, y: f64) -> f64 {
    let along = x / (x.abs() + y.abs());
    if y < 0.0 { 3.0 + along } else { 1.0 - along }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::hilbert_order;
    use proptest::prelude::*;

    fn ends(mesh: &SphereMesh<u32>) -> Vec<[Vertex; 2]> {
        (0..mesh.edge_slots() as Edge)
            .map(|e| <[Vertex; 2]>::from(mesh.endpoints(e)))
            .collect()
    }

    impl EdgePayload for u32 {}

    /// A mesh with a past: vertices have come and gone, edges are free.
    fn used() -> SphereMesh<u32> {
        let spiral = (0..300).map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 300.0;
            let (sin, cos) = libm::sincos(2.399_963 * f64::from(i));
            let r = (1.0 - z * z).sqrt();
            DVec3::new(r * cos, r * sin, z)
        });
        let sites: Vec<DVec3> = spiral.collect();
        let sites = hilbert_order(&sites)
            .iter()
            .map(|&i| sites[i as usize])
            .collect();
        let mut mesh = SphereMesh::<u32>::build(sites).unwrap();
        for v in [7, 80, 200] {
            let h = mesh.outgoing(v).find(|&h| mesh.can_collapse(h)).unwrap();
            mesh.collapse(h);
            mesh.remove_detached(v);
        }
        mesh.repair_delaunay().unwrap();
        mesh.insert(DVec3::new(0.3, 0.5, -0.6), 0).unwrap();
        for e in 0..mesh.edge_slots() as Edge {
            if mesh.is_edge(e) {
                *mesh.payload_mut(e) = 7 * e;
            }
        }
        mesh.check().unwrap();
        assert!(!mesh.free_edges().is_empty());
        mesh
    }

    fn restored(
        mesh: &SphereMesh<u32>,
        ends: &[[Vertex; 2]],
    ) -> Result<SphereMesh<u32>, RestoreError> {
        let (sites, first) = (mesh.sites.clone(), mesh.vertex_edge.clone());
        SphereMesh::restore(sites, first, ends, mesh.payload.clone(), mesh.free.clone())
    }

    #[test]
    fn a_used_mesh_comes_back_with_all_its_numbers() {
        let mesh = used();
        let dead = mesh.free_edges()[0];
        let back = restored(&mesh, &ends(&mesh)).unwrap();
        // What dead half-edges are linked to means nothing.
        assert!(!back.is_edge(dead));
        assert_eq!(back, mesh);
    }

    #[test]
    fn what_is_no_sphere_is_refused() {
        let mesh = used();
        let good = ends(&mesh);
        assert!(matches!(
            restored(&mesh, &good[1..]),
            Err(RestoreError::Length { .. })
        ));
        let live = (0..).find(|&e| mesh.is_edge(e)).unwrap();
        for (bad, error) in [
            ([0, 0], RestoreError::Ends(live)),
            ([0, 9999], RestoreError::Ends(live)),
            ([NONE, NONE], RestoreError::Free(live)),
        ] {
            let mut ends = good.clone();
            ends[live as usize] = bad;
            assert_eq!(restored(&mesh, &ends), Err(error));
        }
        let (sites, mut first) = (mesh.sites.clone(), mesh.vertex_edge.clone());
        first.swap(3, 4);
        let swapped =
            SphereMesh::restore(sites, first, &good, mesh.payload.clone(), mesh.free.clone());
        assert!(matches!(swapped, Err(RestoreError::First(3, _))));
    }

    proptest! {
        /// An edge between any two vertices, in the place of any other, gives an error or the same mesh.
        #[test]
        fn no_exchange_of_an_end_passes(e in 0_usize..800, end in 0_usize..2, to in 0_u32..298) {
            let mesh = used();
            let mut ends = ends(&mesh);
            let e = e % ends.len();
            let before = ends[e][end];
            ends[e][end] = to;
            if to == before {
                prop_assert_eq!(restored(&mesh, &ends), Ok(mesh));
            } else {
                prop_assert!(restored(&mesh, &ends).is_err());
            }
        }
    }
}
