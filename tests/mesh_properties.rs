//! The mesh keeps its promises through long random histories and on degenerate sites.

#[path = "mesh_properties/common.rs"]
mod common;
#[path = "mesh_properties/degenerate.rs"]
mod degenerate;

use bevy_tectonics::mesh::{BuildError, Edge, HalfEdge, MeshFault, SphereMesh, Vertex};
use common::{
    Dice, Mesh, build, check, check_hull, check_queries, check_renumbering, collapse, disturb,
    labels, remove_detached, repair,
};
use glam::DVec3;
use proptest::prelude::*;
use std::collections::BTreeSet;

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..Default::default() })]

    #[test]
    fn long_histories(seed: u64) {
        let mut dice = Dice(seed);
        let count = 40 + dice.below(300);
        let mut mesh = build(dice.directions(count));
        check(&mesh);
        check_hull(&mesh);
        for round in 0..60 {
            disturb(&mut mesh, &mut dice);
            repair(&mut mesh);
            check_queries(&mesh, &mut dice);
            if round % 6 == 0 {
                check_hull(&mesh);
                check_renumbering(&mut mesh, &mut dice);
            }
        }
    }

    #[test]
    fn edits_end_where_construction_does(seed: u64) {
        let mut dice = Dice(seed);
        let mut mesh = build(dice.directions(200));
        disturb(&mut mesh, &mut dice);
        repair(&mut mesh);
        let edges = |mesh: &Mesh| labels(mesh).into_iter().map(|(ends, _)| ends).collect::<Vec<_>>();
        prop_assert_eq!(edges(&build(mesh.sites().to_vec())), edges(&mesh));
    }

    #[test]
    fn sweeps_find_what_to_repair(seed: u64) {
        let mut dice = Dice(seed);
        let mut mesh = build(dice.directions(100));
        disturb(&mut mesh, &mut dice);
        let wrong = |e: &Edge| {
            !mesh.is_locally_delaunay(*e) || [2 * e, 2 * e + 1].iter().any(|&h| mesh.is_inverted(h))
        };
        let brute: Vec<Edge> = mesh.edges().filter(wrong).collect();
        let (middle, end) = (dice.below(mesh.edge_slots()), mesh.edge_slots());
        let found = [0..middle, middle..end].map(|slots| mesh.edges_to_repair(slots));
        prop_assert_eq!(found.concat(), brute);
    }

    #[test]
    fn looking_around_what_moved_finds_all_faults(seed: u64) {
        const FLAT: f64 = 0.04;
        let mut dice = Dice(seed);
        let mut mesh = build(dice.directions(300));
        // All but a few slivers are gone, and what moves is known.
        mesh.repair_slivers(FLAT, |_| true).unwrap();
        let before = mesh.slivers(FLAT);
        let moved: BTreeSet<Vertex> = (0..20).map(|_| dice.below(300) as Vertex).collect();
        for &v in &moved {
            let site = (mesh.site(v) + 0.1 * dice.vector()).normalize();
            mesh.set_site(v, site);
        }
        let moved: Vec<Vertex> = moved.into_iter().collect();
        let (some, others) = moved.split_at(dice.below(moved.len()));
        let [one, two] =
            [some, others].map(|part| mesh.faults_around(part, |v| moved.contains(&v), FLAT));
        let mut edges = [one.edges, two.edges].concat();
        edges.sort_unstable();
        edges.dedup();
        prop_assert_eq!(&edges, &mesh.edges_to_repair(0..mesh.edge_slots()));
        let small = |&h: &HalfEdge| h.min(mesh.next(h)).min(mesh.prev(h));
        let found: BTreeSet<HalfEdge> = one.slivers.into_iter().chain(two.slivers).collect();
        let at_moved = |h: &HalfEdge| mesh.triangle_vertices(*h).iter().any(|v| moved.contains(v));
        let slivers = mesh.slivers(FLAT);
        let expected: BTreeSet<HalfEdge> =
            slivers.iter().filter(|h| at_moved(h)).map(small).collect();
        prop_assert!(expected.is_subset(&found));
        let elsewhere = slivers.iter().filter(|h| !at_moved(h));
        prop_assert!(elsewhere.map(small).all(|h| before.iter().any(|b| small(b) == h)));

        let mut other = mesh.clone();
        let whole = other.repair_from(edges.clone()).unwrap();
        prop_assert_eq!(mesh.repair_locally(edges).unwrap(), whole);
        check(&mesh);
    }

    #[test]
    fn small_meshes_survive_collapses(seed: u64) {
        let mut dice = Dice(seed);
        let mut mesh = build(dice.directions(60));
        let mut idle = 0;
        while idle < 100 {
            let h = dice.half_edge(&mesh);
            if collapse(&mut mesh, h) {
                remove_detached(&mut mesh);
                let torn = matches!(
                    mesh.check(),
                    Err(MeshFault::Link(_) | MeshFault::DuplicateEdge(..) | MeshFault::Euler { .. })
                );
                prop_assert!(!torn);
                idle = 0;
            }
            idle += 1;
        }
        prop_assert_eq!(mesh.vertex_count(), 4);
    }

    #[test]
    fn slivers_are_found_and_cured(seed: u64) {
        const FLAT: f64 = 0.04;
        let mut dice = Dice(seed);
        let mut mesh = build(dice.directions(2000));
        let brute: Vec<HalfEdge> =
            mesh.triangles().filter(|&h| mesh.height_ratio(h) < FLAT).collect();
        let slivers = mesh.slivers(FLAT);
        prop_assert!(!slivers.is_empty());
        prop_assert_eq!(slivers.len(), brute.len());
        for (&h, &small) in slivers.iter().zip(&brute) {
            let triangle = [h, mesh.next(h), mesh.prev(h)];
            prop_assert_eq!(triangle.iter().min(), Some(&small));
            let length = |h| mesh.site(mesh.origin(h)).distance(mesh.site(mesh.dest(h)));
            prop_assert!(triangle.iter().all(|&side| length(side) <= length(h)));
        }
        let mut other = mesh.clone();
        mesh.repair_slivers(FLAT, |_| true).unwrap();
        other.repair_slivers_from(slivers, &[], FLAT, |_| true).unwrap();
        for mesh in [mesh, other] {
            check(&mesh);
            // Random sites are crowded in places: a few slivers resist.
            prop_assert!(mesh.slivers(FLAT).len() <= brute.len() / 4);
        }
    }

    #[test]
    fn clusters(seed: u64, exponent in 2..6_i32) {
        let mut dice = Dice(seed);
        let mut sites = dice.directions(30);
        let radius = libm::pow(10.0, f64::from(-exponent));
        for centre in dice.directions(3) {
            sites.extend((0..100).map(|_| (centre + radius * dice.vector()).normalize()));
        }
        let mut mesh = build(sites);
        check(&mesh);
        check_hull(&mesh);
        // The clusters disperse.
        for site in mesh.sites_mut() {
            *site = (*site + 0.1 * dice.vector()).normalize();
        }
        repair(&mut mesh);
    }

    #[test]
    fn too_tight_clusters_are_refused_or_resolved(seed: u64, exponent in 7..17_i32) {
        let mut dice = Dice(seed);
        let radius = libm::pow(10.0, f64::from(-exponent));
        let centre = dice.direction();
        let mut sites = dice.directions(30);
        let first = dice.below(2) * 30;
        let cluster = (0..20).map(|_| (centre + radius * dice.vector()).normalize());
        sites.splice(first..first, cluster.collect::<Vec<_>>());
        match SphereMesh::<()>::build(sites) {
            Ok(mesh) => mesh.check().unwrap(),
            Err(BuildError::Duplicate(i, j)) => prop_assert!(i < j),
            Err(BuildError::Unresolved(_)) => {}
            Err(other) => prop_assert!(false, "{}", other),
        }
    }

    #[test]
    fn single_precision(seed: u64) {
        let mut dice = Dice(seed);
        let round = |site: DVec3| site.as_vec3().as_dvec3().normalize();
        let mut mesh = build(dice.directions(500).into_iter().map(round).collect());
        check(&mesh);
        for _ in 0..10 {
            for site in mesh.sites_mut() {
                *site = round(*site + 0.03 * dice.vector());
            }
            repair(&mut mesh);
        }
        check_hull(&mesh);
    }

    #[test]
    fn hemispheres_are_refused(seed: u64, count in 4..200_usize) {
        let mut dice = Dice(seed);
        let pole = dice.direction();
        let lift = [0.0, 1.0, 30.0, 1e4, 1e7][dice.below(5)];
        let sites = dice.directions(count).into_iter().map(|p| {
            let up = if p.dot(pole) < 1e-3 { 2e-3 - p.dot(pole) } else { 0.0 };
            p + (up + lift) * pole
        });
        prop_assert_eq!(SphereMesh::<()>::build(sites.collect()), Err(BuildError::NotAroundCentre));
    }
}
