//! Distances along the surface from a set of sources.

use crate::mesh::{EdgePayload, NONE, SphereMesh};

/// Sub-plates within reach of a set of sources, each once.
#[derive(Debug, Clone, Default)]
pub struct Reach {
    /// Vertices with their distance in km and the number of their nearest source, roughly in the order of
    /// their distance.
    pub found: Vec<(u32, f64, u32)>,
}

/// Buckets that the limit is cut into: narrow ones visit few vertices twice. Without a limit there is one.
const BUCKETS: usize = 64;

/// Distances in km along the edges of the mesh, from `sources` over vertices that `passable` admits, up to
/// `limit`: shortest paths with a queue of buckets (Dial 1969; within a bucket labels are corrected, so that
/// distances are exact). Ties go to the source met first.
pub fn reach<E: EdgePayload>(
    mesh: &SphereMesh<E>,
    radius_km: f64,
    sources: &[(u32, f64)],
    limit: f64,
    passable: impl Fn(u32) -> bool,
) -> Reach {
    let mut best: Vec<(f64, u32)> = vec![(f64::INFINITY, NONE); mesh.vertex_count()];
    let mut found: Vec<u32> = Vec::new();
    let bucket_of =
        |distance: f64| ((distance * (BUCKETS as f64 / limit.max(1e-9))) as usize).min(BUCKETS - 1);
    let mut buckets: Vec<Vec<(u32, f64)>> = vec![Vec::new(); BUCKETS];
    let mut offer = |v: u32, distance: f64, source: u32, best: &mut [(f64, u32)]| {
        let known = &mut best[v as usize];
        if distance >= known.0 {
            return None;
        }
        if known.1 == NONE {
            found.push(v);
        }
        *known = (distance, source);
        Some((bucket_of(distance), (v, distance)))
    };
    for (&(v, distance), number) in sources.iter().zip(0..) {
        if let Some((bucket, entry)) = offer(v, distance, number, &mut best) {
            buckets[bucket].push(entry);
        }
    }
    for bucket in 0..BUCKETS {
        // First in, first out: what is pushed into the bucket under way is visited in the same pass.
        let mut next = 0;
        while let Some(&(v, distance)) = buckets[bucket].get(next) {
            next += 1;
            let (shortest, source) = best[v as usize];
            if distance > shortest {
                continue;
            }
            let site = mesh.site(v);
            for w in mesh.neighbours(v) {
                let further = distance + site.distance(mesh.site(w)) * radius_km;
                if further < limit
                    && further < best[w as usize].0
                    && passable(w)
                    && let Some((bucket, entry)) = offer(w, further, source, &mut best)
                {
                    buckets[bucket].push(entry);
                }
            }
        }
        buckets[bucket] = Vec::new();
    }
    let label = |v: u32| {
        let (distance, source) = best[v as usize];
        (v, distance, source)
    };
    Reach {
        found: found.into_iter().map(label).collect(),
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::fixtures::random_mesh;

    /// Against Bellman and Ford's relaxation of all edges until nothing changes.
    #[test]
    fn distances_are_the_shortest() {
        let mesh = random_mesh::<()>(1500);
        let sources: [(u32, f64); 4] = [(7, 10.0), (900, 0.0), (1400, 300.0), (7, 400.0)];
        let open = |v: u32| v % 11 != 3;
        let limit = 3000.0;
        let mut best: Vec<f64> = vec![f64::INFINITY; 1500];
        for &(v, distance) in &sources {
            best[v as usize] = distance.min(best[v as usize]);
        }
        for _ in 0..200 {
            for v in 0..1500_u32 {
                for w in mesh.neighbours(v) {
                    let step = mesh.site(v).distance(mesh.site(w)) * 6371.0;
                    let further = best[v as usize] + step;
                    if further < limit && open(w) {
                        best[w as usize] = best[w as usize].min(further);
                    }
                }
            }
        }
        let reach = reach(&mesh, 6371.0, &sources, limit, open);
        let within = best.iter().filter(|distance| distance.is_finite()).count();
        assert_eq!(reach.found.len(), within);
        for (v, distance, source) in reach.found {
            assert!((distance - best[v as usize]).abs() < 1e-9);
            assert!(source < 3 && sources[source as usize].1 <= distance);
        }
    }
}
