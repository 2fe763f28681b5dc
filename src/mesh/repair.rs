//! Restoring the Delaunay property after sites moved.

use std::collections::BTreeMap;

use thiserror::Error;

use super::{Edge, EdgePayload, HalfEdge, SphereMesh, Vertex};

/// One edge that changed its endpoints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flip {
    /// The edge.
    pub edge: Edge,
    /// The vertices it joined.
    pub before: [Vertex; 2],
    /// The vertices it joins now.
    pub after: [Vertex; 2],
    /// Whether it turned between its two triangles, so that those it joins now lie beside those it joined.
    /// Otherwise it was taken from one place and put to another.
    pub turned: bool,
}

/// Why the mesh could not be made Delaunay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum RepairError {
    /// The limit on flips was reached at an edge, given with its endpoints: the sites moved too far.
    #[error("too many flips; stopped at edge {edge} between vertices {vertices:?}")]
    TooManyFlips {
        /// The edge to be flipped next.
        edge: Edge,
        /// Its endpoints.
        vertices: [Vertex; 2],
    },
    /// A vertex stays entangled with its neighbours: it coincides with another, or all sites have
    /// gathered on one hemisphere.
    #[error("vertex {vertex} cannot be untangled")]
    Tangled {
        /// The vertex.
        vertex: Vertex,
    },
}

/// Flips allowed per edge of the mesh in one repair.
const FLIPS_PER_EDGE: usize = 64;

/// Times a repair may reinsert vertices, beyond one in sixteen of all, before it starts anew.
const REINSERTIONS: usize = 64;

/// Reinsertions of one vertex after which its neighbours are reinserted with it ...
const STUBBORN: u32 = 2;

/// ... and after which a repair starts anew.
const HOPELESS: u32 = 16;

impl<E: EdgePayload> SphereMesh<E> {
    /// Makes the mesh Delaunay and returns the flips made, in order.
    ///
    /// # Errors
    ///
    /// See [`repair_from`](Self::repair_from).
    pub fn repair_delaunay(&mut self) -> Result<Vec<Flip>, RepairError> {
        self.repair_from(self.edges_to_repair(0..self.edge_slots()))
    }

    /// Makes the mesh Delaunay by Lawson flips, starting from the given edges, and returns the flips
    /// made, in order. All edges that are not locally Delaunay must be given, and an edge of each
    /// inverted triangle, for such a triangle may have none of them; others may be.
    ///
    /// A vertex that flips cannot free from a fold is taken out and inserted where it lies. Its edges
    /// keep their numbers, are notified as flipped and recorded like flips, so that the record
    /// always tells every edge that changed its endpoints. If too many vertices are folded, the sites
    /// are triangulated anew, with such a record for every edge that is not found again.
    ///
    /// A surface that winds around the sphere more than once is put right only if it has folds, too.
    /// A [`flip`](Self::flip) can make one without, if the tetrahedron of its four vertices encloses the
    /// centre.
    ///
    /// # Errors
    ///
    /// [`RepairError`] if the sites coincide, or do not surround the centre. The mesh is then
    /// still a triangulated surface, but not Delaunay.
    pub fn repair_from(&mut self, queue: Vec<Edge>) -> Result<Vec<Flip>, RepairError> {
        self.repair(queue, true)
    }

    /// Like [`repair_from`](Self::repair_from) for a mesh that was sound before vertices moved by less than
    /// the length of an edge: folds are only looked for at the given edges and at those that change, and
    /// the sweeps of the whole mesh that end the repair of any fold are left out.
    ///
    /// # Errors
    ///
    /// See [`repair_from`](Self::repair_from).
    pub fn repair_locally(&mut self, queue: Vec<Edge>) -> Result<Vec<Flip>, RepairError> {
        self.repair(queue, false)
    }

    fn repair(&mut self, queue: Vec<Edge>, whole: bool) -> Result<Vec<Flip>, RepairError> {
        let mut flips = Vec::new();
        if let Err(error) = self.untangle(queue, &mut flips, whole) {
            if !self.rebuild(&mut flips) {
                return Err(error);
            }
            // Construction normalises sites; as they are, they may differ by some close calls.
            let queue = self.edges_to_repair(0..self.edge_slots());
            self.untangle(queue, &mut flips, true)?;
        }
        Ok(flips)
    }

    /// Flips and reinserts, starting from the given edges, until the mesh is Delaunay; `whole` also looks for
    /// folds beyond the edges that were given or changed.
    pub(super) fn untangle(
        &mut self,
        mut queue: Vec<Edge>,
        flips: &mut Vec<Flip>,
        whole: bool,
    ) -> Result<(), RepairError> {
        let mut folded = self.first_inverted(&queue).is_some();
        let mut suspects = queue.clone();
        let allowed = REINSERTIONS + self.vertex_count() / 16;
        let mut reinsertions = 0;
        let mut again: BTreeMap<Vertex, u32> = BTreeMap::new();
        loop {
            let recorded = flips.len();
            let blocked = self.lawson(queue, flips)?;
            suspects.extend(flips[recorded..].iter().map(|flip| flip.edge));
            let mut tangle: Vec<Vertex> = if let Some(&e) = blocked.first() {
                let (a, b) = self.endpoints(e);
                vec![a, b]
            } else if let Some(h) = self.first_inverted(&suspects) {
                self.triangle_vertices(h).into()
            } else if !(folded && whole) {
                return Ok(());
            } else if let Some(h) = self.triangles().find(|&h| self.is_inverted(h)) {
                // A queue for a part of the mesh leaves the folds of other parts.
                self.triangle_vertices(h).into()
            } else if let Some(h) = self.first_overlap() {
                // Unfolded, the surface may still wind around the sphere more than once.
                let vertex = self.origin(h);
                return Err(RepairError::Tangled { vertex });
            } else {
                return Ok(());
            };
            folded = true;
            // Vertices that block each other in turn: what holds them lies around them.
            let stubborn = tangle.iter().any(|v| again.get(v) > Some(&STUBBORN));
            if stubborn {
                let ring = tangle.iter().flat_map(|&v| self.neighbours(v));
                let ring: Vec<Vertex> = ring.filter(|v| !tangle.contains(v)).collect();
                tangle.extend(ring);
                tangle.sort_unstable();
                tangle.dedup();
            }
            let recorded = flips.len();
            queue = blocked;
            for vertex in tangle {
                let times = again.entry(vertex).or_insert(0);
                *times += 1;
                if reinsertions == allowed || *times > HOPELESS {
                    return Err(RepairError::Tangled { vertex });
                }
                reinsertions += 1;
                self.reinsert(vertex, flips, &mut queue);
            }
            for flip in &flips[recorded..] {
                queue.extend(self.surrounding_edges(flip.edge));
            }
            suspects.extend(&queue);
        }
    }

    /// Lawson's algorithm from the edges in `queue`. Returns the edges left that are not locally
    /// Delaunay, but whose flip is impossible.
    pub(super) fn lawson(
        &mut self,
        mut queue: Vec<Edge>,
        flips: &mut Vec<Flip>,
    ) -> Result<Vec<Edge>, RepairError> {
        let limit = flips.len() + FLIPS_PER_EDGE * self.edge_count();
        let mut blocked = Vec::new();
        loop {
            let recorded = flips.len();
            while let Some(e) = queue.pop() {
                if !self.is_edge(e) || self.is_locally_delaunay(e) {
                    continue;
                }
                if flips.len() == limit {
                    return Err(RepairError::TooManyFlips {
                        edge: e,
                        vertices: self.endpoints(e).into(),
                    });
                }
                if self.flip_recorded(e, flips) {
                    queue.extend(self.surrounding_edges(e));
                } else {
                    blocked.push(e);
                }
            }
            // Later flips may have unblocked earlier edges.
            if blocked.is_empty() || flips.len() == recorded {
                return Ok(blocked);
            }
            queue.append(&mut blocked);
        }
    }

    fn flip_recorded(&mut self, e: Edge, flips: &mut Vec<Flip>) -> bool {
        let before = self.endpoints(e).into();
        let flipped = self.flip(2 * e);
        if flipped {
            let after = self.endpoints(e).into();
            flips.push(Flip {
                edge: e,
                before,
                after,
                turned: true,
            });
        }
        flipped
    }

    /// The four other edges of the triangles at `e`.
    fn surrounding_edges(&self, e: Edge) -> [Edge; 4] {
        let (h, twin) = (2 * e, 2 * e + 1);
        [self.next(h), self.prev(h), self.next(twin), self.prev(twin)].map(|h| self.edge_of(h))
    }

    /// A half-edge of an inverted triangle at one of the edges.
    fn first_inverted(&self, edges: &[Edge]) -> Option<HalfEdge> {
        edges
            .iter()
            .filter(|&&e| self.is_edge(e))
            .flat_map(|&e| [2 * e, 2 * e + 1])
            .find(|&h| self.is_inverted(h))
    }

    /// Takes `v` out of the mesh and inserts it into the triangle which it lies in. Queues the edges
    /// around both places.
    fn reinsert(&mut self, v: Vertex, flips: &mut Vec<Flip>, queue: &mut Vec<Edge>) {
        while self.degree(v) > 3 {
            // Cutting off an ear of the star is possible at some neighbour, as the edges that
            // forbid two adjacent ones would cross.
            let ear = self
                .outgoing(v)
                .filter(|&h| {
                    let (left, right) = (self.apex(h), self.apex(self.twin(h)));
                    self.half_edge_between(left, right).is_none()
                })
                .map(|h| (h, self.ear_quality(h)))
                .reduce(|best, other| if other.1 > best.1 { other } else { best });
            let Some((h, _)) = ear else {
                queue.extend(self.star_edges(v));
                return;
            };
            self.flip_recorded(self.edge_of(h), flips);
        }
        let neighbours: Vec<Vertex> = self.neighbours(v).collect();
        let (hole, spokes) = self.detach(v);
        queue.extend([hole, self.next(hole), self.prev(hole)].map(|h| self.edge_of(h)));
        let location = self.locate(self.site(v), neighbours[0]);
        self.attach(v, location.half_edge, spokes);
        queue.extend(self.star_edges(v));
        for (h, before) in spokes.into_iter().zip(neighbours) {
            let edge = self.edge_of(h);
            self.payload_mut(edge).flipped();
            flips.push(Flip {
                edge,
                before: [v, before],
                after: [v, self.dest(h)],
                turned: false,
            });
        }
    }
}
