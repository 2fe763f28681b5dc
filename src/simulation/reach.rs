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
