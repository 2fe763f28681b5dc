//! Distances along the surface from a set of sources.

use super::workers::Workers;
use crate::mesh::{EdgePayload, SphereMesh};
use core::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Sub-plates within reach of a set of sources, each once.
#[derive(Debug, Clone, Default)]
pub struct Reach {
    /// Vertices with their distance in km and the number of their nearest source, in the order of vertices.
    pub found: Vec<(u32, f64, u32)>,
}

/// Units of a label's distance to a radius of the planet: 10 cm on Earth. Whole numbers add up strictly, so that
/// labels end the same in whatever order threads meet vertices.
const UNITS: f64 = (1_u64 << 26) as f64;
/// Bands that a search is cut into. All threads finish one before they begin the next: whoever ran ahead would
/// label what others come to on shorter ways.
const BANDS: u64 = 4;
/// Buckets of a band: narrow ones visit few vertices twice.
const BUCKETS: u64 = 16;
/// Vertices that are worth a thread of their own.
const FEW: usize = 64;
/// Vertices for which a bucket has room from the start.
const MOST_AT_ONCE: usize = 4096;

/// Distance in units above the number of a source: smaller is nearer, ties go to the source listed first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Label(u64);

impl Label {
    const UNKNOWN: Self = Self(u64::MAX);

    fn new(distance: u32, source: u32) -> Self {
        Self(u64::from(distance) << 32 | u64::from(source))
    }

    fn distance(self) -> u32 {
        (self.0 >> 32) as u32
    }

    /// The same source, so much further away.
    fn after(self, way: u32) -> Self {
        Self::new(self.distance().saturating_add(way), self.0 as u32)
    }
}

/// Distances in km along the edges of the mesh, from `sources` over vertices that `passable` admits, up to
/// `limit`: shortest paths with queues of buckets (Dial 1969; within a bucket labels are corrected, so that
/// distances are exact, to 10 cm an edge on Earth). Each source comes with its own distance in km, and ties go to
/// the one listed first. `limit` may be infinite; what lies further than 64 radii along every path is not found.
/// Threads share the work ([`Workers::default`] is the caller alone); the result is the same on any number of them.
pub fn reach<E: EdgePayload + Sync>(
    workers: &Workers,
    mesh: &SphereMesh<E>,
    radius_km: f64,
    sources: &[(u32, f64)],
    limit: f64,
    passable: impl Fn(u32) -> bool + Sync,
) -> Reach {
    let units = |km: f64| (km / radius_km * UNITS).round() as u32;
    let count = mesh.vertex_count();
    let search = Search {
        mesh,
        passable,
        labels: (0..count).map(|_| AtomicU64::new(u64::MAX)).collect(),
        limit: units(limit),
    };
    let offered = (sources.iter().zip(0..)).filter_map(|(&(v, distance), source)| {
        let label = Label::new(units(distance), source);
        search.improves(v, label).then_some((v, label))
    });
    let mut front: Vec<(u32, Label)> = offered.collect();
    for band in 0..BANDS {
        let part = front.len().div_ceil(workers.threads()).max(FEW);
        let ahead = workers.run(front.chunks(part), |front| search.cross(band, front));
        front = ahead.concat();
    }
    let found = workers.map(count, |rows| {
        let labels = (rows.start as u32..).zip(&search.labels[rows]);
        let known = labels.map(|(v, label)| (v, Label(label.load(Relaxed))));
        let within = known.filter(|(_, label)| *label != Label::UNKNOWN);
        let km = |label: Label| f64::from(label.distance()) / UNITS * radius_km;
        within
            .map(|(v, label)| (v, km(label), label.0 as u32))
            .collect::<Vec<_>>()
    });
    Reach {
        found: found.concat(),
    }
}

/// A search under way.
struct Search<'a, E: EdgePayload, P> {
    mesh: &'a SphereMesh<E>,
    passable: P,
    labels: Vec<AtomicU64>,
    /// In units.
    limit: u32,
}

impl<E: EdgePayload, P: Fn(u32) -> bool> Search<'_, E, P> {
    /// Labels a vertex if that brings it nearer.
    fn improves(&self, v: u32, label: Label) -> bool {
        label.0 < self.labels[v as usize].fetch_min(label.0, Relaxed)
    }

    /// The bucket of a distance, the first of them 0; no distance lies beyond the last.
    fn bucket(&self, distance: u32) -> u64 {
        let all = BANDS * BUCKETS;
        (u64::from(distance) * all / (u64::from(self.limit) + 1)).min(all - 1)
    }

    /// Labels what lies in this band beyond `front`; returns what lies at its far side.
    fn cross(&self, band: u64, front: &[(u32, Label)]) -> Vec<(u32, Label)> {
        let room = front.len().min(MOST_AT_ONCE);
        let mut buckets: [Vec<(u32, Label)>; BUCKETS as usize] =
            core::array::from_fn(|_| Vec::with_capacity(room));
        let mut ahead = Vec::with_capacity(room);
        let first = band * BUCKETS;
        let mut put = |at: (u32, Label), buckets: &mut [Vec<(u32, Label)>]| {
            let bucket = (self.bucket(at.1.distance()) - first) as usize;
            // First in, first out: what is put into the bucket under way is visited in the same pass.
            buckets.get_mut(bucket).unwrap_or(&mut ahead).push(at);
        };
        for &at in front {
            put(at, &mut buckets);
        }
        for bucket in 0..buckets.len() {
            let mut next = 0;
            while let Some(&(v, label)) = buckets[bucket].get(next) {
                next += 1;
                if label.0 != self.labels[v as usize].load(Relaxed) {
                    continue;
                }
                let site = self.mesh.site(v);
                for w in self.mesh.neighbours(v) {
                    // What is as near has been reached on another way.
                    if self.labels[w as usize].load(Relaxed) <= label.0 || !(self.passable)(w) {
                        continue;
                    }
                    let way = site.distance(self.mesh.site(w)) * UNITS;
                    let further = label.after(way.round() as u32);
                    if further.distance() < self.limit && self.improves(w, further) {
                        put((w, further), &mut buckets);
                    }
                }
            }
            buckets[bucket] = Vec::new();
        }
        ahead
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
        let reach = [Workers::default(), Workers::new(3)]
            .map(|workers| reach(&workers, &mesh, 6371.0, &sources, limit, open));
        assert_eq!(reach[0].found, reach[1].found);
        let [reach, _] = reach;
        let within = best.iter().filter(|distance| distance.is_finite()).count();
        assert_eq!(reach.found.len(), within);
        for (v, distance, source) in reach.found {
            // Each edge is rounded to some 10 cm.
            assert!((distance - best[v as usize]).abs() < 0.01);
            assert!(source < 3 && sources[source as usize].1 < distance + 1e-4);
        }
    }
}
