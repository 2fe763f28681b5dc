//! Random edits, and what must hold after them.

use std::f64::consts::PI;

use bevy_tectonics::mesh::{EdgePayload, EditError, Flip, HalfEdge, NONE, SphereMesh, Vertex};
use glam::DVec3;
use robust::{Coord3D, orient3d};

/// A label, and how often the edge was flipped.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tag {
    pub label: u32,
    pub flips: u32,
}

impl EdgePayload for Tag {
    fn flipped(&mut self) {
        self.flips += 1;
    }
}

pub type Mesh = SphereMesh<Tag>;

/// A small generator (SplitMix64): long histories must not be shrunk choice by choice.
pub struct Dice(pub u64);

impl Dice {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, limit: usize) -> usize {
        (self.bits() % limit as u64) as usize
    }

    /// In [-1, 1).
    pub fn signed(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub fn vector(&mut self) -> DVec3 {
        DVec3::new(self.signed(), self.signed(), self.signed())
    }

    pub fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.vector();
            if (0.1..1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }

    pub fn directions(&mut self, count: usize) -> Vec<DVec3> {
        (0..count).map(|_| self.direction()).collect()
    }

    pub fn half_edge(&mut self, mesh: &Mesh) -> HalfEdge {
        loop {
            let h = self.below(2 * mesh.edge_slots()) as HalfEdge;
            if mesh.is_edge(mesh.edge_of(h)) {
                return h;
            }
        }
    }
}

pub fn side(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let [a, b, c, d] = [a, b, c, d].map(|DVec3 { x, y, z }| Coord3D { x, y, z });
    orient3d(a, b, c, d)
}

/// The promises that hold for a Delaunay mesh, with the total of the cells.
pub fn check(mesh: &SphereMesh<impl EdgePayload>) {
    mesh.check().unwrap();
    let total: f64 = mesh.cell_areas().iter().sum();
    assert!((total - 4.0 * PI).abs() < 1e-9, "cells cover {total}");
    let total: f64 = mesh.triangles().map(|h| mesh.triangle_area(h)).sum();
    assert!((total - 4.0 * PI).abs() < 1e-9, "triangles cover {total}");
    assert_eq!(3 * mesh.triangles().count(), 2 * mesh.edge_count());
}

/// No site is above the plane of any triangle.
pub fn check_hull(mesh: &SphereMesh<impl EdgePayload>) {
    for h in mesh.triangles() {
        let [a, b, c] = mesh.triangle_vertices(h).map(|v| mesh.site(v));
        assert!(mesh.sites().iter().all(|&d| side(a, b, c, d) >= 0.0));
    }
}

pub fn build(sites: Vec<DVec3>) -> Mesh {
    let mut mesh = Mesh::build(sites).unwrap();
    for e in 0..mesh.edge_count() as u32 {
        mesh.payload_mut(e).label = e + 1;
    }
    mesh
}

/// Payloads with the sorted endpoints of their edges, sorted.
pub fn labels(mesh: &Mesh) -> Vec<([Vertex; 2], Tag)> {
    let mut labels: Vec<_> = mesh
        .edges()
        .map(|e| {
            let (a, b) = mesh.endpoints(e);
            ([a.min(b), a.max(b)], mesh.payload(e).clone())
        })
        .collect();
    labels.sort_by_key(|label| label.0);
    labels
}

pub fn flips_noted(mesh: &Mesh) -> u32 {
    mesh.edges().map(|e| mesh.payload(e).flips).sum()
}

/// Repairs; every recorded flip was notified, and the record leads from the old to the new edges.
pub fn repair(mesh: &mut Mesh) {
    let before = mesh.clone();
    let flips = mesh.repair_delaunay().unwrap();
    assert_eq!(flips_noted(mesh) - flips_noted(&before), flips.len() as u32);
    follow(&before, &flips, mesh);
    check(mesh);
}

pub fn follow(before: &Mesh, flips: &[Flip], after: &Mesh) {
    let sorted = |mut ends: [Vertex; 2]| {
        ends.sort_unstable();
        ends
    };
    let mut ends: Vec<_> = (0..before.edge_slots() as u32)
        .map(|e| sorted(before.endpoints(e).into()))
        .collect();
    for flip in flips {
        assert_eq!(ends[flip.edge as usize], sorted(flip.before));
        ends[flip.edge as usize] = sorted(flip.after);
    }
    for e in after.edges() {
        assert_eq!(ends[e as usize], sorted(after.endpoints(e).into()));
    }
}

pub fn remove_detached(mesh: &mut Mesh) {
    for v in (0..mesh.vertex_count() as Vertex)
        .rev()
        .filter(|&v| mesh.is_detached(v))
        .collect::<Vec<_>>()
    {
        let (last, site) = (
            mesh.vertex_count() as Vertex - 1,
            mesh.site(mesh.vertex_count() as Vertex - 1),
        );
        match mesh.remove_detached(v) {
            Some(moved) => {
                assert_eq!(moved, last);
                assert_eq!(mesh.site(v), site);
            }
            None => assert_eq!(v, last),
        }
    }
}

/// Vertices that both ends of the half-edge have as neighbours.
pub fn shared_neighbours(mesh: &Mesh, h: HalfEdge) -> Vec<Vertex> {
    let of_dest: Vec<Vertex> = mesh.neighbours(mesh.dest(h)).collect();
    mesh.neighbours(mesh.origin(h))
        .filter(|v| of_dest.contains(v))
        .collect()
}

pub fn flip(mesh: &mut Mesh, h: HalfEdge) {
    let (e, twin) = (mesh.edge_of(h), mesh.twin(h));
    let (a, b) = (mesh.origin(h), mesh.dest(h));
    let (left, right) = (mesh.apex(h), mesh.apex(twin));
    let joined = mesh.half_edge_between(left, right).is_some();
    let noted = mesh.payload(e).flips;
    let flipped = mesh.flip(h);
    assert_eq!(flipped, !joined);
    assert_eq!(mesh.payload(e).flips, noted + u32::from(flipped));
    if flipped {
        assert_eq!((mesh.origin(h), mesh.dest(h)), (right, left));
        assert_eq!(mesh.half_edge_between(a, b), None);
        assert!(mesh.half_edge_between(a, left).is_some());
        assert!(mesh.half_edge_between(b, right).is_some());
    }
}

pub fn collapse(mesh: &mut Mesh, h: HalfEdge) -> bool {
    let (removed, kept) = (mesh.origin(h), mesh.dest(h));
    let shared = shared_neighbours(mesh, h);
    let left = (0..mesh.vertex_count() as Vertex)
        .filter(|&v| !mesh.is_detached(v))
        .count();
    assert_eq!(mesh.can_collapse(h), shared.len() == 2 && left > 4);
    if !mesh.can_collapse(h) {
        return false;
    }
    let edges = mesh.edge_count();
    let ring: Vec<Vertex> = mesh.neighbours(removed).filter(|&v| v != kept).collect();
    let degree = mesh.degree(kept);
    assert_eq!(mesh.collapse(h), kept);
    assert!(mesh.is_detached(removed));
    assert_eq!(mesh.edge_count(), edges - 3);
    assert_eq!(mesh.degree(kept), degree + ring.len() - 3);
    assert!(
        ring.iter()
            .all(|&v| mesh.half_edge_between(kept, v).is_some())
    );
    true
}

pub fn split(mesh: &mut Mesh, h: HalfEdge) {
    let [a, b, c] = mesh.triangle_vertices(h);
    let [pa, pb, pc] = [a, b, c].map(|v| mesh.site(v));
    let v = mesh.split_triangle(h, (pa + pb + pc).normalize());
    assert_eq!(v as usize, mesh.vertex_count() - 1);
    assert_eq!(mesh.degree(v), 3);
    assert!(
        [a, b, c]
            .iter()
            .all(|&u| mesh.half_edge_between(u, v).is_some())
    );
}

pub fn split_edge(mesh: &mut Mesh, h: HalfEdge) {
    let (a, b) = (mesh.origin(h), mesh.dest(h));
    let v = mesh.split_edge(h, (mesh.site(a) + mesh.site(b)).normalize());
    assert_eq!((mesh.origin(h), mesh.dest(h)), (a, v));
    assert_eq!(mesh.half_edge_between(a, b), None);
    assert_eq!(mesh.degree(v), 4);
}

/// A batch of edits of one kind, after which the mesh may be in any tangle.
pub fn disturb(mesh: &mut Mesh, dice: &mut Dice) {
    let count = mesh.vertex_count();
    let spacing = (4.0 * PI / count as f64).sqrt();
    match dice.below(6) {
        0 => {
            for _ in 0..10 + dice.below(100) {
                let h = dice.half_edge(mesh);
                flip(mesh, h);
            }
        }
        1 => {
            for _ in 0..20 {
                let h = dice.half_edge(mesh);
                split(mesh, h);
                let h = dice.half_edge(mesh);
                split_edge(mesh, h);
            }
        }
        2 if count > 90 => {
            let mut wanted = 40;
            while wanted > 0 {
                let h = dice.half_edge(mesh);
                wanted -= usize::from(collapse(mesh, h));
            }
            remove_detached(mesh);
        }
        3 => {
            let reach = spacing * [0.05, 0.3, 1.0][dice.below(3)];
            for site in mesh.sites_mut() {
                *site = (*site + reach * dice.vector()).normalize();
            }
        }
        4 => {
            // A few vertices go anywhere.
            for _ in 0..4 {
                let v = dice.below(count) as Vertex;
                mesh.set_site(v, dice.direction());
            }
        }
        _ => {
            for _ in 0..20 {
                let (site, hint) = (dice.direction(), dice.below(mesh.vertex_count()) as Vertex);
                let before = mesh.clone();
                let (v, flips) = mesh.insert(site, hint).unwrap();
                assert_eq!(v as usize, mesh.vertex_count() - 1);
                assert_eq!(flips_noted(mesh) - flips_noted(&before), flips.len() as u32);
                let again = mesh.insert(3.0 * site, 0);
                assert!(
                    matches!(again, Err(EditError::Duplicate(u)) if u == v),
                    "{again:?}"
                );
            }
            check(mesh);
        }
    }
}

pub fn check_queries(mesh: &Mesh, dice: &mut Dice) {
    for i in 0..20 {
        let hint = dice.below(mesh.vertex_count()) as Vertex;
        let direction = match i % 4 {
            0 => mesh.site(dice.below(mesh.vertex_count()) as Vertex),
            1 => {
                let (a, b) = mesh.endpoints(dice.half_edge(mesh) / 2);
                mesh.site(a) + mesh.site(b)
            }
            _ => 2.0 * dice.direction(),
        };
        let location = mesh.locate(direction, hint);
        assert_eq!(
            mesh.triangle_vertices(location.half_edge),
            location.vertices
        );
        let [a, b, c] = location.vertices.map(|v| mesh.site(v));
        let sum: f64 = location.weights.iter().sum();
        assert!((sum - 1.0).abs() < 1e-12 && location.weights.iter().all(|&w| w >= 0.0));
        let [wa, wb, wc] = location.weights;
        let rebuilt = (wa * a + wb * b + wc * c).normalize();
        assert!(rebuilt.distance(direction.normalize()) < 1e-9);
        let unit = direction.normalize();
        let unit = if i % 4 == 0 { direction } else { unit };
        let contains = |h: HalfEdge| {
            let [a, b, c] = mesh.triangle_vertices(h).map(|v| mesh.site(v));
            [(a, b), (b, c), (c, a)]
                .iter()
                .all(|&(p, q)| side(p, q, unit, DVec3::ZERO) >= -1e-15)
        };
        assert!(contains(location.half_edge));

        let nearest = mesh.nearest(direction, hint);
        let distance = |v: Vertex| mesh.site(v).distance_squared(unit);
        let best = (0..mesh.vertex_count() as Vertex)
            .map(distance)
            .fold(f64::MAX, f64::min);
        assert!(distance(nearest) <= best * (1.0 + 1e-12));
    }
    // A hint out of range is as good as any.
    assert_eq!(mesh.nearest(mesh.site(3), NONE), 3);
}

pub fn check_renumbering(mesh: &mut Mesh, dice: &mut Dice) {
    let before = mesh.clone();
    let mut order = mesh.spatial_order();
    if dice.below(2) == 0 {
        for i in (1..order.len()).rev() {
            order.swap(i, dice.below(i + 1));
        }
    }
    mesh.renumber(&order);
    check(mesh);
    assert_eq!(mesh.edge_slots(), mesh.edge_count());
    let old = |v: Vertex| order[v as usize];
    for v in 0..mesh.vertex_count() as Vertex {
        assert_eq!(mesh.site(v), before.site(old(v)));
        assert_eq!(mesh.degree(v), before.degree(old(v)));
    }
    for h in mesh.edges().flat_map(|e| [2 * e, 2 * e + 1]) {
        let k = before
            .half_edge_between(old(mesh.origin(h)), old(mesh.dest(h)))
            .unwrap();
        assert_eq!(mesh.payload(h / 2), before.payload(k / 2));
        assert_eq!(old(mesh.apex(h)), before.apex(k));
        assert_eq!(h % 2, k % 2);
    }
}
