//! Meshes for unit tests.

use super::streams::{self, Purpose};
use crate::mesh::{EdgePayload, SphereMesh};
use glam::DVec3;

/// A mesh of evenly spread sites: a golden spiral from pole to pole.
pub(super) fn even_mesh<E: EdgePayload>(n: u32) -> SphereMesh<E> {
    let golden = core::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let sites = (0..n)
        .map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n);
            let (sin, cos) = libm::sincos(golden * f64::from(i));
            let ring = (1.0 - z * z).sqrt();
            DVec3::new(ring * cos, ring * sin, z)
        })
        .collect();
    SphereMesh::build(sites).unwrap()
}

/// A mesh of random sites, the same ones every time.
pub(super) fn random_mesh<E: EdgePayload>(n: u32) -> SphereMesh<E> {
    let mut rng = streams::stream(1, Purpose::Points, 0, 0);
    let sites = (0..n).map(|_| streams::direction(&mut rng)).collect();
    SphereMesh::build(sites).unwrap()
}
