//! The kind of boundary on every edge of a captured mesh.

use crate::mesh::SphereMesh;
use crate::simulation::{
    boundaries::Contacts,
    plate::PlateTable,
    recipe::Recipe,
    sub_plate::{Created, Crust, PlateId},
    topology::{BoundaryKind, EdgeState},
};

/// What decides on the kind of a boundary.
pub(super) struct Margins<'a> {
    pub(super) mesh: &'a SphereMesh<EdgeState>,
    pub(super) plate: &'a [PlateId],
    pub(super) crust: &'a [Crust],
    pub(super) created: &'a [Created],
    pub(super) plates: &'a PlateTable,
    pub(super) contacts: &'a Contacts,
    pub(super) recipe: &'a Recipe,
}

impl Margins<'_> {
    /// The kind per edge number: `Joined` within plates and on dead edges, and only there.
    pub(super) fn kinds(&self) -> Vec<BoundaryKind> {
        (0..self.mesh.edge_slots() as u32)
            .map(|edge| {
                if !self.mesh.is_edge(edge) {
                    return BoundaryKind::Joined;
                }
                let (u, v) = self.mesh.endpoints(edge);
                if self.plate[u as usize] == self.plate[v as usize] {
                    return BoundaryKind::Joined;
                }
                match self.mesh.payload(edge).kind {
                    // Younger than the last classification: a rift, a repaired or a refined mesh.
                    BoundaryKind::Joined => self.by_motion(edge),
                    kind => kind,
                }
            })
            .collect()
    }

    /// The kind that the motion suggests.
    fn by_motion(&self, edge: u32) -> BoundaryKind {
        let mesh = self.mesh;
        let (u, v) = mesh.endpoints(edge);
        let (a, b) = (mesh.site(u), mesh.site(v));
        let middle = (a + b).normalize_or(a);
        let along = mesh.site(mesh.apex(2 * edge)) - mesh.site(mesh.apex(2 * edge + 1));
        let across = along.cross(middle).normalize_or_zero();
        let across = if across.dot(b - a) < 0.0 {
            -across
        } else {
            across
        };
        let [from, to] = [u, v].map(|v| self.plate[v as usize]);
        let turn = self.plates.rotation(to) - self.plates.rotation(from);
        let slip = turn.cross(middle) * self.recipe.radius_km;
        let opening = slip.dot(across);
        let least = self.recipe.constants.boundaries.normal_share * slip.length();
        if slip.length() < 1e-6 {
            BoundaryKind::Transform
        } else if opening > least {
            BoundaryKind::Ridge
        } else if opening < -least {
            self.closing([u, v])
        } else {
            BoundaryKind::Transform
        }
    }

    /// Sea floor sinks before continents; of two, the one that its pair of plates has settled on,
    /// or the older.
    fn closing(&self, ends: [u32; 2]) -> BoundaryKind {
        let [u, v] = ends.map(|v| v as usize);
        let first = match [u, v].map(|v| self.crust[v].is_continental()) {
            [true, true] => return BoundaryKind::Collision,
            [false, true] => true,
            [true, false] => false,
            [false, false] => self
                .contacts
                .get(self.plate[u], self.plate[v])
                .and_then(|contact| contact.subducting)
                .map_or(self.created[u].0 <= self.created[v].0, |sinking| {
                    sinking == self.plate[u]
                }),
        };
        if first {
            BoundaryKind::SubductingOrigin
        } else {
            BoundaryKind::SubductingDestination
        }
    }
}
