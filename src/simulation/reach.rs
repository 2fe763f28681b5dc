//! Distances along the surface from a set of sources.

use crate::mesh::{EdgePayload, NONE, SphereMesh};
use core::cmp::Reverse;
use std::collections::BinaryHeap;

/// Sub-plates within reach of a set of sources, in the order of their distance.
#[derive(Debug, Clone, Default)]
pub struct Reach {
    /// Vertices with their distance in km and the number of their nearest source.
    pub found: Vec<(u32, f64, u32)>,
}

/// Distances in km along the edges of the mesh (Dijkstra), from `sources` over vertices that
/// `passable` admits, up to `limit`. Ties go to the lower vertex, so that the result is reproducible.
pub fn reach<E: EdgePayload>(
    mesh: &SphereMesh<E>,
    radius_km: f64,
    sources: &[(u32, f64)],
    limit: f64,
    passable: impl Fn(u32) -> bool,
) -> Reach {
    let mut best = vec![f64::INFINITY; mesh.vertex_count()];
    let mut nearest = vec![NONE; mesh.vertex_count()];
    let mut queue = BinaryHeap::new();
    for (number, &(v, distance)) in sources.iter().enumerate() {
        if distance < best[v as usize] {
            best[v as usize] = distance;
            nearest[v as usize] = number as u32;
            queue.push(Reverse((distance.to_bits(), v)));
        }
    }
    let mut found = Vec::new();
    while let Some(Reverse((bits, v))) = queue.pop() {
        let distance = f64::from_bits(bits);
        if distance > best[v as usize] {
            continue;
        }
        found.push((v, distance, nearest[v as usize]));
        for w in mesh.neighbours(v) {
            let step = mesh.site(v).distance(mesh.site(w)) * radius_km;
            let further = distance + step;
            if further < limit && further < best[w as usize] && passable(w) {
                best[w as usize] = further;
                nearest[w as usize] = nearest[v as usize];
                queue.push(Reverse((further.to_bits(), w)));
            }
        }
    }
    Reach { found }
}

/// Marks on vertices that are wiped all at once, for walks that visit a few of many again and again.
#[derive(Debug, Clone, Default)]
pub struct Marks {
    round: u32,
    marked: Vec<u32>,
}

impl Marks {
    /// Wipes all marks, and makes room for this many vertices.
    pub fn wipe(&mut self, count: usize) {
        self.round = self.round.wrapping_add(1);
        if self.round == 0 {
            self.marked.clear();
            self.round = 1;
        }
        if self.marked.len() < count {
            self.marked.resize(count, 0);
        }
    }

    /// Whether a vertex is marked.
    #[must_use]
    pub fn is_marked(&self, v: u32) -> bool {
        self.marked[v as usize] == self.round
    }

    /// Marks a vertex; whether it was not marked before.
    pub fn mark(&mut self, v: u32) -> bool {
        core::mem::replace(&mut self.marked[v as usize], self.round) != self.round
    }
}
