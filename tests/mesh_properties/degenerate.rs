//! Cocircular, crowded, coplanar, coinciding and few sites.

use std::f64::consts::{PI, TAU};

use bevy_tectonics::mesh::{
    BuildError, EditError, MeshFault, NONE, SphereMesh, Vertex, hilbert_order,
};
use glam::DVec3;

use super::common::{Dice, Mesh, build, check, check_hull, check_queries, flip, repair};

/// The grid of `side`² quadrilaterals on each face of the cube.
fn cube_grid(side: i32) -> Vec<DVec3> {
    let mut grid = Vec::new();
    for x in -side..=side {
        for y in -side..=side {
            for z in -side..=side {
                let on_grid = [x, y, z].iter().all(|k| (k + side) % 2 == 0);
                if on_grid && [x, y, z].iter().any(|k| k.abs() == side) {
                    grid.push(DVec3::new(x.into(), y.into(), z.into()).normalize());
                }
            }
        }
    }
    grid
}

fn icosphere(levels: u32) -> Vec<DVec3> {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut corners = Vec::new();
    for (s, t) in [(1., 1.), (1., -1.), (-1., 1.), (-1., -1.)] {
        corners.push(DVec3::new(0., s, t * golden).normalize());
        corners.push(DVec3::new(s, t * golden, 0.).normalize());
        corners.push(DVec3::new(t * golden, 0., s).normalize());
    }
    let mut mesh = SphereMesh::<()>::build(corners).unwrap();
    for _ in 0..levels {
        let middles: Vec<DVec3> = mesh
            .edges()
            .map(|e| mesh.endpoints(e))
            .map(|(a, b)| (mesh.site(a) + mesh.site(b)).normalize())
            .collect();
        mesh = SphereMesh::build([mesh.sites(), &middles].concat()).unwrap();
    }
    mesh.sites().to_vec()
}

/// Parallels and meridians, with both poles.
fn geographic_grid(rows: u32, columns: u32) -> Vec<DVec3> {
    let mut grid = vec![DVec3::Z, DVec3::NEG_Z];
    for row in 1..rows {
        let (ring, z) = libm::sincos(PI * f64::from(row) / f64::from(rows));
        for column in 0..columns {
            let (sin, cos) = libm::sincos(TAU * f64::from(column) / f64::from(columns));
            grid.push(DVec3::new(ring * cos, ring * sin, z));
        }
    }
    grid
}

#[test]
fn cocircular_grids() {
    let octahedron = cube_grid(1);
    assert_eq!(octahedron.len(), 8);
    let grids = [
        octahedron,
        cube_grid(2),
        cube_grid(9),
        icosphere(3),
        geographic_grid(12, 24),
    ];
    for (i, grid) in grids.into_iter().enumerate() {
        let mut mesh = build(grid.clone());
        check(&mesh);
        check_hull(&mesh);
        assert_eq!(mesh.repair_delaunay(), Ok(vec![]));
        // In another order, along the curve.
        let sorted = hilbert_order(&grid)
            .into_iter()
            .map(|i| grid[i as usize])
            .collect();
        check(&build(sorted));
        // By insertion into the tetrahedron.
        let mut grown = build(vec![
            DVec3::new(0.9, 1.1, 1.2).normalize(),
            DVec3::new(-1.2, -1.1, 1.0).normalize(),
            DVec3::new(-1.0, 1.3, -1.1).normalize(),
            DVec3::new(1.2, -0.9, -1.1).normalize(),
        ]);
        let mut hint = 0;
        for &site in &grid {
            hint = grown.insert(site, hint).unwrap().0;
        }
        check(&grown);
        check_hull(&grown);
        // Out of the tie, and back into it.
        let mut dice = Dice(i as u64);
        for site in mesh.sites_mut() {
            *site = (*site + 0.05 * dice.vector()).normalize();
        }
        repair(&mut mesh);
        mesh.sites_mut().copy_from_slice(&grid);
        repair(&mut mesh);
        check_hull(&mesh);
        let mut dice = Dice(i as u64);
        check_queries(&mesh, &mut dice);
    }
}

#[test]
fn few_sites() {
    let mut dice = Dice(5);
    let (mut built, mut refused) = (0, 0);
    for i in 0..600 {
        let sites = dice.directions(4 + i % 3);
        match SphereMesh::<()>::build(sites) {
            Ok(mesh) => {
                check(&mesh);
                check_hull(&mesh);
                built += 1;
            }
            Err(error) => {
                assert_eq!(error, BuildError::NotAroundCentre);
                refused += 1;
            }
        }
    }
    assert!(built > 100 && refused > 100);
}

/// Where triangles are large, an inverted one may have locally Delaunay edges only.
#[test]
fn few_sites_are_unfolded() {
    let mut hidden = 0;
    let mut look = |mesh: &Mesh| {
        let convex = |h| mesh.is_locally_delaunay(mesh.edge_of(h));
        hidden += mesh
            .triangles()
            .filter(|&h| mesh.is_inverted(h))
            .filter(|&h| [h, mesh.next(h), mesh.prev(h)].into_iter().all(convex))
            .count();
    };
    for seed in 0..3000 {
        let mut dice = Dice(seed);
        if let Ok(mut mesh) = Mesh::build(dice.directions(10)) {
            for _ in 0..40 {
                let h = dice.half_edge(&mesh);
                flip(&mut mesh, h);
            }
            look(&mesh);
            repair(&mut mesh);
        }
        if let Ok(mut mesh) = Mesh::build(dice.directions(8)) {
            mesh.sites_mut().copy_from_slice(&dice.directions(8));
            look(&mesh);
            match mesh.repair_delaunay() {
                Ok(_) => check(&mesh),
                Err(_) => assert!(Mesh::build(mesh.sites().to_vec()).is_err()),
            }
        }
    }
    assert!(hidden > 100, "{hidden}");
}

#[test]
fn coplanar_sites_are_refused() {
    for (height, count) in [(0.0, 4), (0.0, 50), (0.3, 4), (0.3, 50), (-0.9, 7)] {
        let circle = (0..count).map(|i| {
            let (sin, cos) = libm::sincos(TAU * f64::from(i) / f64::from(count));
            DVec3::new(cos, sin, height)
        });
        let built = SphereMesh::<()>::build(circle.collect());
        assert_eq!(built, Err(BuildError::NotAroundCentre));
    }
}

#[test]
fn duplicates_are_named() {
    let grid = cube_grid(6);
    for (i, j) in [(0, 1), (0, 217), (3, 100), (7, 8), (100, 217)] {
        let mut sites = grid.clone();
        sites.insert(j, sites[i]);
        assert_eq!(
            SphereMesh::<()>::build(sites),
            Err(BuildError::Duplicate(i, j))
        );
    }
    // Apart by less than the projection tells.
    for tiny in [1e-17, 1e-30, 1e-160, 1e-300] {
        let sites = [
            [1., 0., 0.],
            [0., 1., 0.],
            [-1., -1., 1.],
            [-1., -1., -1.],
            [1., 0., tiny],
        ];
        for first in 0..5 {
            let mut sites: Vec<DVec3> = sites.into_iter().map(DVec3::from).collect();
            sites.rotate_left(first);
            let (i, j) = ((5 - first) % 5, (9 - first) % 5);
            match SphereMesh::<()>::build(sites) {
                Ok(mesh) => mesh.check().unwrap(),
                Err(BuildError::Unresolved(_)) => {}
                Err(error) => assert_eq!(error, BuildError::Duplicate(i.min(j), i.max(j))),
            }
        }
    }
}

#[test]
fn insertion_refuses_what_is_there() {
    let mut mesh = build(cube_grid(4));
    let before = mesh.clone();
    for v in 0..mesh.vertex_count() as Vertex {
        for hint in [0, v, NONE] {
            assert_eq!(
                mesh.insert(mesh.site(v), hint),
                Err(EditError::Duplicate(v))
            );
        }
    }
    for bad in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
        assert!(matches!(
            mesh.insert(bad, 0),
            Err(EditError::NoDirection(_))
        ));
    }
    assert_eq!(mesh, before);
    // Lengths of every magnitude name a direction.
    for length in [1e-300, 1e-3, 1e3, 1e300] {
        assert_eq!(mesh.nearest(length * mesh.site(9), 0), 9);
        assert!(mesh.locate(length * mesh.site(9), 0).vertices.contains(&9));
    }
}

#[test]
fn vertices_that_meet_are_reported() {
    let mut mesh = build(Dice(8).directions(100));
    mesh.set_site(40, mesh.site(77));
    assert!(mesh.repair_delaunay().is_err());
    assert!(matches!(
        mesh.check(),
        Err(MeshFault::Inverted(_) | MeshFault::NotDelaunay { .. })
    ));
    // Apart again, all is well.
    mesh.set_site(40, Dice(9).direction());
    repair(&mut mesh);
}

#[test]
fn sites_may_be_exchanged_altogether() {
    for count in [8, 12, 400] {
        let mut dice = Dice(count as u64);
        let mut mesh = build(cube_grid(1));
        while mesh.vertex_count() < count {
            mesh.insert(dice.direction(), 0).unwrap();
        }
        // Turned by a half turn about an axis, shuffled.
        let mut sites: Vec<DVec3> = mesh
            .sites()
            .iter()
            .map(|p| DVec3::new(-p.x, -p.y, p.z))
            .collect();
        for i in (1..count).rev() {
            sites.swap(i, dice.below(i + 1));
        }
        mesh.sites_mut().copy_from_slice(&sites);
        repair(&mut mesh);
        check_hull(&mesh);
    }
}

#[test]
fn check_sees_what_is_wrong() {
    let mesh = build(Dice(1).directions(50));
    let mut long = mesh.clone();
    long.set_site(7, 1.001 * mesh.site(7));
    assert_eq!(long.check(), Err(MeshFault::Site(7)));
    let mut detached = mesh.clone();
    let h = detached.best_collapse(12, |_| true).unwrap();
    assert!(detached.collapse_quality(h) > 0.0);
    detached.collapse(h);
    assert_eq!(detached.check(), Err(MeshFault::Detached(12)));
    let mut moved = mesh.clone();
    moved.set_site(30, -mesh.site(30));
    assert!(matches!(moved.check(), Err(MeshFault::Inverted(_))));
    let mut flipped = mesh;
    while !flipped.flip(6) {}
    assert!(flipped.check().is_err());
}
