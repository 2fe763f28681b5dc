//! A dynamic Delaunay triangulation of the unit sphere.
//!
//! The Delaunay triangulation of sites on a sphere is their convex hull. [`SphereMesh`] keeps it as
//! a doubly connected edge list (DCEL) whose sites may move, appear and vanish:
//!
//! * [`SphereMesh::build`] triangulates a set of sites;
//! * [`SphereMesh::insert`], [`SphereMesh::collapse`] and [`SphereMesh::flip`] edit it locally;
//! * after sites moved, [`SphereMesh::repair_delaunay`] flips edges (Lawson 1977) until every edge
//!   is locally Delaunay again;
//! * [`SphereMesh::locate`] and [`SphereMesh::nearest`] answer point queries by walking;
//! * [`SphereMesh::check`] verifies everything the mesh promises.
//!
//! # Numbering
//!
//! Vertices are dense rows `0..vertex_count`. An undirected edge `e` consists of the half-edges
//! `2e` and `2e + 1`. Edge numbers stay put while the edge lives; numbers of removed edges are
//! reused. Triangles have no number: any of their three half-edges stands for them. Triangles run
//! counter-clockwise seen from outside the sphere.
//!
//! # Exactness
//!
//! All decisions about topology use exact predicates on the `f64` coordinates, so the same sites
//! and the same operations give the same mesh on every platform. A flip of an edge which is not
//! locally Delaunay strictly increases the volume enclosed by the mesh, folded triangles counted
//! negatively. Hence Lawson's algorithm terminates from any state, tangled ones included.
//!
//! # Panics
//!
//! Methods panic when given a vertex or edge number that is out of range.

mod build;
mod check;
mod components;
mod edit;
mod geometry;
mod locate;
mod order;
mod predicates;
mod rebuild;
mod repair;
mod restore;
mod sliver;
mod topology;

use glam::DVec3;

pub use build::BuildError;
pub use check::MeshFault;
pub use components::Components;
pub use edit::EditError;
pub use locate::Location;
pub use order::{hilbert_key, hilbert_order, order_by_keys};
pub use predicates::Faults;
pub use repair::{Flip, RepairError};
pub use restore::RestoreError;
pub use sliver::SliverRepair;

/// The number that stands for "none" among vertices, half-edges and edges.
pub const NONE: u32 = u32::MAX;

/// Vertex number, `0..vertex_count`.
pub type Vertex = u32;

/// Half-edge number; `2e` and `2e + 1` are the halves of edge `e`.
pub type HalfEdge = u32;

/// Undirected edge number.
pub type Edge = u32;

/// Data carried by each undirected edge.
pub trait EdgePayload: Clone + Default + Send + Sync + 'static {
    /// Called when the edge is flipped, that is when it joins two other vertices than before.
    fn flipped(&mut self) {}

    /// Called when a triangle beside the edge was replaced, that is when the two vertices opposite
    /// to the edge are others than before. A flip does so to the four edges around the flipped one.
    fn reshaped(&mut self) {}
}

impl EdgePayload for () {}

/// Delaunay triangulation of the unit sphere with a payload `E` on each edge.
///
/// The mesh is a closed triangulated surface at all times. It is Delaunay after
/// [`build`](Self::build), [`insert`](Self::insert) into a Delaunay mesh and the repair methods;
/// moving sites, flips, splits and collapses leave that to the next repair.
#[derive(Clone, Debug, PartialEq)]
pub struct SphereMesh<E: EdgePayload = ()> {
    /// Unit vector per vertex.
    sites: Vec<DVec3>,
    /// One outgoing half-edge per vertex, [`NONE`] when detached.
    vertex_edge: Vec<HalfEdge>,
    /// Origin per half-edge, [`NONE`] on dead edges.
    origin: Vec<Vertex>,
    /// Next half-edge of the same triangle, per half-edge.
    next: Vec<HalfEdge>,
    /// Payload per edge.
    payload: Vec<E>,
    /// Dead edges, reused last in, first out.
    free: Vec<Edge>,
}
