//! The last resort of repair: construction anew, under the old numbers.

use super::{Edge, EdgePayload, Flip, HalfEdge, NONE, SphereMesh, Vertex};

/// The half-edge of each edge that starts at the smaller vertex, with both vertices; ascending.
fn sorted_edges<E: EdgePayload>(
    mesh: &SphereMesh<E>,
    number: impl Fn(Vertex) -> Vertex,
) -> Vec<([Vertex; 2], HalfEdge)> {
    let mut edges: Vec<_> = mesh
        .edges()
        .map(|e| {
            let (a, b) = mesh.endpoints(e);
            let (a, b) = (number(a), number(b));
            if a < b {
                ([a, b], 2 * e)
            } else {
                ([b, a], 2 * e + 1)
            }
        })
        .collect();
    edges.sort_unstable();
    edges
}

impl<E: EdgePayload> SphereMesh<E> {
    /// Triangulates the sites anew. Edges found again keep their numbers and sense; each of the others
    /// becomes one of the new ones, is notified as flipped and recorded like a flip.
    ///
    /// Returns `false`, with nothing changed, if the sites have no triangulation.
    pub(super) fn rebuild(&mut self, flips: &mut Vec<Flip>) -> bool {
        let vertices = 0..self.vertex_count() as Vertex;
        let attached: Vec<Vertex> = vertices.filter(|&v| !self.is_detached(v)).collect();
        let sites = attached.iter().map(|&v| self.site(v)).collect();
        let Ok(fresh) = SphereMesh::<()>::build(sites) else {
            return false;
        };
        let number = |v: Vertex| attached[v as usize];
        let before = sorted_edges(self, |v| v);
        let after = sorted_edges(&fresh, number);

        // The half-edge here for each half-edge there. The two sorted lists are equally long.
        let mut place: Vec<HalfEdge> = vec![NONE; 2 * fresh.edge_slots()];
        let mut put = |there: HalfEdge, here: HalfEdge| {
            place[there as usize] = here;
            place[there as usize ^ 1] = here ^ 1;
        };
        let (mut gone, mut new) = (Vec::new(), Vec::new());
        let (mut old_edges, mut new_edges) = (before.iter().peekable(), after.iter().peekable());
        loop {
            match (old_edges.peek(), new_edges.peek()) {
                (Some(old), Some(found)) if old.0 == found.0 => {
                    put(found.1, old.1);
                    old_edges.next();
                    new_edges.next();
                }
                (Some(old), found) if found.is_none_or(|found| old.0 < found.0) => {
                    gone.extend(old_edges.next());
                }
                (_, Some(_)) => new.extend(new_edges.next()),
                _ => break,
            }
        }
        for (&(before, here), &(after, there)) in gone.into_iter().zip(new) {
            put(there, here);
            let edge: Edge = self.edge_of(here);
            self.payload_mut(edge).flipped();
            flips.push(Flip {
                edge,
                before,
                after,
                turned: false,
            });
        }
        for there in 0..2 * fresh.edge_slots() as HalfEdge {
            let here = place[there as usize];
            let origin = number(fresh.origin(there));
            self.origin[here as usize] = origin;
            self.next[here as usize] = place[fresh.next(there) as usize];
            self.vertex_edge[origin as usize] = here;
        }
        true
    }
}
