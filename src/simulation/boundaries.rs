//! What the stages know of the boundaries between plates in this step.

use super::{
    plate::PlateTable,
    recipe::Recipe,
    sub_plate::{Crust, PlateId},
    topology::EdgeState,
    workers::{FEW, Workers},
};
use crate::mesh::{NONE, SphereMesh};
use bevy::prelude::*;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One edge whose ends lie on different plates.
#[derive(Debug, Clone, Copy)]
pub struct Front {
    /// Edge of the mesh (as it was when boundaries were classified).
    pub edge: u32,
    /// Its ends, origin first.
    pub vertices: [u32; 2],
    /// Their plates.
    pub plates: [PlateId; 2],
    /// Vector of the dual edge turned into the normal, from the first end to the second, in km.
    /// Along a front these sum to the chord, so that a zigzag costs nothing.
    pub normal: DVec3,
    /// Length of the dual edge in km.
    pub length: f64,
    /// Smoothed unit normal of the front, from the first end to the second.
    pub direction: DVec3,
    /// Unit vector to the middle of the edge.
    pub midpoint: DVec3,
    /// Velocity of the second plate relative to the first, in km/My.
    pub slip: DVec3,
    /// Its part along `direction`: opening is positive, closing negative, in km/My.
    pub opening: f64,
    /// Both ends are continental.
    pub continental: bool,
    /// Which end goes under, if one does where the front closes.
    pub under: Option<usize>,
}

impl Front {
    /// A front as the mesh alone tells it; [`aim`](Self::aim) adds how it moves.
    pub(super) fn across(
        mesh: &SphereMesh<EdgeState>,
        edge: u32,
        plates: [PlateId; 2],
        radius: f64,
    ) -> Self {
        let (u, v) = mesh.endpoints(edge);
        let h = 2 * edge;
        let (a, b) = (mesh.site(u), mesh.site(v));
        let left = mesh.site(mesh.apex(h));
        let right = mesh.site(mesh.apex(h ^ 1));
        let midpoint = (a + b).normalize();
        // From centroid to centroid: (a + b + left)/3 − (a + b + right)/3.
        let normal = ((left - right) / 3.0).cross(midpoint) * radius;
        let normal = if normal.dot(b - a) < 0.0 {
            -normal
        } else {
            normal
        };
        Self {
            edge,
            vertices: [u, v],
            plates,
            normal,
            length: normal.length(),
            direction: DVec3::ZERO,
            midpoint,
            slip: DVec3::ZERO,
            opening: 0.0,
            continental: false,
            under: None,
        }
    }

    /// Sets the direction from smoothed strikes, and how the plates move across it.
    pub(super) fn aim(
        &mut self,
        boundaries: &Boundaries,
        mesh: &SphereMesh<EdgeState>,
        plates: &PlateTable,
        radius: f64,
    ) {
        let [u, v] = self.vertices;
        self.direction = boundaries.direction((u, mesh.site(u)), (v, mesh.site(v)));
        let turn = plates.rotation(self.plates[1]) - plates.rotation(self.plates[0]);
        self.slip = turn.cross(self.midpoint) * radius;
        self.opening = self.slip.dot(self.direction);
    }
}

/// Fronts of the present step.
#[derive(Resource, Debug, Clone, Default)]
pub struct Boundaries {
    /// Edges across plates, in the order of their numbers.
    pub fronts: Vec<Front>,
    /// Vertices at a front, in the order of their numbers.
    pub vertices: Vec<u32>,
    /// Smoothed outward normal at each of `vertices`.
    pub strikes: Vec<DVec3>,
    /// Place of each vertex in `vertices`, or [`NONE`].
    pub place: Vec<u32>,
    /// Which plate goes under where floor meets floor: vertex, other plate, sinking plate; sorted.
    pub polarity: Vec<(u32, PlateId, PlateId)>,
}

/// Relative motion of two neighbouring sub-plates across a front.
#[derive(Debug, Clone, Copy, Default)]
pub struct Motion {
    /// Opening speed in km/My, negative where closing.
    pub opening: f64,
    /// Speed of the slip in km/My.
    pub slip: f64,
}

impl Motion {
    /// Whether the slip runs mostly along the front.
    #[must_use]
    pub fn is_near_transform(&self, share: f64) -> bool {
        self.opening.abs() < share * self.slip
    }
}

impl Boundaries {
    /// Lists the vertices whose `place` is not [`NONE`] and sets it to their place in the list.
    pub(super) fn number_vertices(&mut self) {
        for (vertex, place) in self.place.iter_mut().enumerate() {
            if *place != NONE {
                *place = self.vertices.len() as u32;
                self.vertices.push(vertex as u32);
            }
        }
    }

    /// Lists the polarity of the fronts between floor and floor.
    pub(super) fn list_polarity(&mut self, workers: &Workers, fronts: &[Front], crust: &[Crust]) {
        let found = workers.run(fronts.chunks(FEW), |fronts| {
            let mut polarity = Vec::with_capacity(2 * fronts.len());
            for front in fronts {
                let is_floor = |&v: &u32| !crust[v as usize].is_continental();
                if let (true, Some(under)) = (front.vertices.iter().all(is_floor), front.under) {
                    let sinking = front.plates[under];
                    polarity.extend([
                        (front.vertices[0], front.plates[1], sinking),
                        (front.vertices[1], front.plates[0], sinking),
                    ]);
                }
            }
            polarity.sort_unstable();
            polarity
        });
        self.polarity.clear();
        self.polarity.extend(found.into_iter().flatten());
        // A stable sort makes use of parts that are in order.
        self.polarity.sort();
        self.polarity
            .dedup_by_key(|&mut (vertex, other, _)| (vertex, other));
    }

    /// Which of two plates goes under where two sub-plates of sea floor meet, each given as vertex and
    /// plate; none away from the fronts of this step.
    #[must_use]
    pub fn sinking(&self, a: (u32, PlateId), b: (u32, PlateId)) -> Option<PlateId> {
        let known = |vertex: u32, other: PlateId| {
            self.polarity
                .binary_search_by_key(&(vertex, other), |&(vertex, other, _)| (vertex, other))
                .ok()
                .map(|at| self.polarity[at].2)
        };
        known(a.0, b.1).or_else(|| known(b.0, a.1))
    }

    /// Smoothed normal that points out of a vertex's plate; zero away from fronts.
    #[must_use]
    pub fn strike(&self, vertex: u32) -> DVec3 {
        match self.place.get(vertex as usize) {
            Some(&place) if place != NONE => self.strikes[place as usize],
            _ => DVec3::ZERO,
        }
    }

    /// Unit normal of the front from `a` to `b`, smoothed where both are known.
    #[must_use]
    pub fn direction(&self, a: (u32, DVec3), b: (u32, DVec3)) -> DVec3 {
        let middle = (a.1 + b.1).normalize();
        let tangent = |n: DVec3| n - middle * middle.dot(n);
        let smooth = tangent(self.strike(a.0) - self.strike(b.0));
        let straight = tangent(b.1 - a.1);
        // A smoothed normal that disagrees with the edge itself belongs to another front nearby.
        if smooth.length_squared() > 1e-12 && smooth.dot(straight) > 0.0 {
            smooth.normalize()
        } else {
            straight.normalize_or_zero()
        }
    }

    /// Relative motion of `b` against `a`, each given as vertex, site and plate.
    #[must_use]
    pub fn motion(
        &self,
        plates: &PlateTable,
        radius: f64,
        a: (u32, DVec3, PlateId),
        b: (u32, DVec3, PlateId),
    ) -> Motion {
        let middle = (a.1 + b.1).normalize();
        let slip = (plates.rotation(b.2) - plates.rotation(a.2)).cross(middle) * radius;
        Motion {
            opening: slip.dot(self.direction((a.0, a.1), (b.0, b.1))),
            slip: slip.length(),
        }
    }
}

/// Vertices at fronts and around what collisions took away: the mesh beside them is no longer what the last
/// repair left. From the collisions to the repair of one step.
#[derive(Resource, Debug, Clone, Default)]
pub struct Unsettled(pub Vec<u32>);

/// What one front does to one of its plates.
#[derive(Debug, Clone, Copy)]
pub struct FrontForce {
    /// The plate.
    pub plate: PlateId,
    /// Unit vector to the middle of the front.
    pub place: DVec3,
    /// Torque about the planet's centre of all that drives and resists there, in the units of
    /// [`DrivingTorque`](super::DrivingTorque).
    pub torque: DVec3,
}

/// Forces at the fronts as the balance of torques left them, in steps in which plates are reorganised;
/// empty in others, and where no balance of torques drives the plates.
#[derive(Resource, Debug, Clone, Default)]
pub struct FrontForces(pub Vec<FrontForce>);

/// What two plates remember of each other.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// When they last touched, in My.
    pub last_my: f64,
    /// The plate whose sea floor goes under along most of the front where sea floor meets sea floor.
    pub subducting: Option<PlateId>,
    /// Closing of their continents summed over time, in km.
    pub interpenetration: f64,
    /// Mean closing speed of their continental fronts now, in km/My.
    pub closing: f64,
    /// Continental share of their common front now.
    pub continental_share: f64,
    /// The rift that made them; none for plates that met.
    pub rift: Option<Rift>,
    /// Length of their common front that the rift has not torn yet, in km.
    pub untorn_km: f64,
}

/// A rift that tears a plate open from a place outwards.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Rift {
    /// When it began, in My.
    pub began_my: f64,
    /// Where it began, as a unit vector; rides on the plate with the smaller id.
    pub from: DVec3,
    /// Pace at which it tears, in km/My.
    pub pace: f64,
    /// Distance from there at which the tear stops, in km; infinite for a rift that goes through. Plates
    /// that are still held together when the push is over become one again: a failed rift.
    pub stops_km: f64,
}

impl Rift {
    /// How far it has torn, in km.
    #[must_use]
    pub fn reach_km(&self, now_my: f64) -> f64 {
        (self.pace * (now_my - self.began_my)).min(self.stops_km)
    }

    /// Whether it has not torn a front of its plates yet.
    pub(super) fn holds(&self, front: &Front, now_my: f64, recipe: &Recipe) -> bool {
        let reach = self.reach_km(now_my);
        front.midpoint.distance(self.from) * recipe.radius_km > reach
    }
}

/// Contacts by pair of plates, the smaller id first.
#[derive(Resource, Debug, Clone, Default)]
pub struct Contacts(pub BTreeMap<(PlateId, PlateId), Contact>);

impl Contacts {
    /// Key of a pair.
    #[must_use]
    pub fn key(a: PlateId, b: PlateId) -> (PlateId, PlateId) {
        (a.min(b), a.max(b))
    }

    /// What a pair remembers.
    #[must_use]
    pub fn get(&self, a: PlateId, b: PlateId) -> Option<&Contact> {
        self.0.get(&Self::key(a, b))
    }

    /// Lets the origins of rifts ride on their plates for a step in My.
    pub(super) fn carry_rifts(&mut self, plates: &PlateTable, step_my: f64) {
        for (&(id, _), contact) in &mut self.0 {
            if let Some(rift) = &mut contact.rift {
                let moved = plates.rotation(id).cross(rift.from) * step_my;
                rift.from = (rift.from + moved).normalize();
            }
        }
    }

    /// Hands the contacts of a plate that ends over to the one that takes its place.
    pub fn inherit(&mut self, gone: PlateId, heir: PlateId) {
        let moved: Vec<_> = self
            .0
            .iter()
            .filter(|((a, b), _)| *a == gone || *b == gone)
            .map(|(&key, &contact)| (key, contact))
            .collect();
        for ((a, b), mut contact) in moved {
            self.0.remove(&(a, b));
            let other = if a == gone { b } else { a };
            if other == heir {
                continue;
            }
            if contact.subducting == Some(gone) {
                contact.subducting = Some(heir);
            }
            self.0.entry(Self::key(heir, other)).or_insert(contact);
        }
    }
}
