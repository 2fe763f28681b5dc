//! Parts of the mesh that hang together.

use super::{EdgePayload, SphereMesh, Vertex};

/// Connected parts of the vertices, numbered in the order of their first vertices.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Components {
    /// Number of each vertex's part.
    pub of: Vec<u32>,
    /// First vertex of each part.
    pub first: Vec<Vertex>,
}

impl<E: EdgePayload> SphereMesh<E> {
    /// Parts that hang together over edges whose ends are `joined`. One sweep over the edges in the order of
    /// memory (union by the smaller number, with path halving; Tarjan & van Leeuwen 1984): a walk from vertex
    /// to vertex takes several times as long.
    pub fn components(&self, joined: impl Fn(Vertex, Vertex) -> bool) -> Components {
        let mut of: Vec<Vertex> = (0..self.vertex_count() as Vertex).collect();
        for e in self.edges() {
            let (a, b) = self.endpoints(e);
            if joined(a, b) {
                let (a, b) = (root(&mut of, a), root(&mut of, b));
                of[a.max(b) as usize] = a.min(b);
            }
        }
        // A part's root is its first vertex, and what a vertex points at lies before it.
        let mut first = Vec::new();
        for v in 0..of.len() {
            of[v] = if of[v] == v as Vertex {
                first.push(v as Vertex);
                first.len() as u32 - 1
            } else {
                of[of[v] as usize]
            };
        }
        Components { of, first }
    }
}

fn root(parent: &mut [Vertex], mut v: Vertex) -> Vertex {
    while parent[v as usize] != v {
        let above = parent[parent[v as usize] as usize];
        parent[v as usize] = above;
        v = above;
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Against a walk over neighbours.
    #[test]
    fn parts_are_what_a_walk_reaches() {
        let points = (0..900).map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 900.0;
            let (sin, cos) = libm::sincos(2.399_963 * f64::from(i));
            DVec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z
        });
        let mesh = SphereMesh::<()>::build(points.collect()).unwrap();
        let colour = |v: Vertex| (v.wrapping_mul(2_654_435_761) >> 16) % 3;
        let Components { of, first } = mesh.components(|a, b| colour(a) == colour(b));
        assert!(first.len() > 20 && first.is_sorted());
        let mut is_seen = vec![false; 900];
        for (number, &start) in first.iter().enumerate() {
            let mut walk = vec![start];
            while let Some(v) = walk.pop() {
                if !core::mem::replace(&mut is_seen[v as usize], true) {
                    assert_eq!(of[v as usize] as usize, number);
                    assert!(v >= start);
                    walk.extend(mesh.neighbours(v).filter(|&w| colour(w) == colour(v)));
                }
            }
        }
        assert!(is_seen.iter().all(|&seen| seen));
    }
}
