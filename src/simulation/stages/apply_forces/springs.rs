//! The springs of the soft margins.
//!
//! Each plate's margin is bent by itself: everything within the margin's width of a push, and all that still
//! moves. Springs on edges *and cross edges* are solved as position constraints (XPBD), stable at any length of
//! step, where explicit springs of the published stiffness would need steps of 200 years; rest lengths follow
//! slowly, so that what stays bent is bent for good.

use super::super::super::{
    precision::{REST_STEPS, round},
    recipe::Recipe,
    sub_plate::{Deviation, PlateId},
    topology::EdgeState,
};
use crate::mesh::{NONE, SphereMesh};
use core::sync::atomic::{AtomicU32, Ordering};
use glam::{DVec3, Vec3};

/// Deviations below this die at once, in km/My, so that margins heal and cost nothing.
const STILL: f64 = 0.1;
/// Ring of sub-plates that still move but lie behind every margin.
const FAR: u32 = NONE - 1;
/// Passes over the springs each time, there and back. What they do not settle now, the deviations carry on to
/// the next time: a push reaches the far side of a margin of a dozen cells within some My.
const PASSES: usize = 1;

/// Strain at which a spring is slack and forgotten: it is measured anew when it is next bent.
const SLACK: f64 = 2e-3;

/// Springs behind the margins follow their lengths, too, for some My.
pub(super) fn relax(
    mesh: &mut SphereMesh<EdgeState>,
    deviation: &[Deviation],
    time: f64,
    flow: f64,
) {
    let kept = libm::exp(-time / flow);
    let is_still = |v: u32| deviation[v as usize].0 == Vec3::ZERO;
    for edge in 0..mesh.edge_slots() as u32 {
        let EdgeState {
            rest, cross_rest, ..
        } = *mesh.payload(edge);
        if rest == 0.0 && cross_rest == 0.0 {
            continue;
        }
        let relaxed = |rest: f32, [a, b]: [u32; 2]| {
            if rest == 0.0 || !is_still(a) || !is_still(b) {
                return rest;
            }
            let length = mesh.site(a).distance(mesh.site(b));
            let strain = (length - f64::from(rest)) * kept;
            if strain.abs() < SLACK * length {
                0.0
            } else {
                round(length - strain, REST_STEPS) as f32
            }
        };
        let (a, b) = mesh.endpoints(edge);
        let across = [mesh.apex(2 * edge), mesh.apex(2 * edge + 1)];
        let (rest, cross_rest) = (relaxed(rest, [a, b]), relaxed(cross_rest, across));
        let state = mesh.payload_mut(edge);
        (state.rest, state.cross_rest) = (rest, cross_rest);
    }
}

/// What margins are bent from.
pub(super) struct Ground<'a> {
    pub recipe: &'a Recipe,
    pub mesh: &'a SphereMesh<EdgeState>,
    pub plate: &'a [PlateId],
    pub deviation: &'a [Deviation],
    /// Time for which margins are bent, in My.
    pub time: f64,
}

/// Place of each vertex in the margin of its plate, or [`NONE`]. Each plate writes its own vertices alone, so
/// that plates may share it and nothing depends on their order.
pub(super) struct Places(Vec<AtomicU32>);

impl Places {
    pub(super) fn new(vertices: usize) -> Self {
        Self((0..vertices).map(|_| AtomicU32::new(NONE)).collect())
    }

    fn get(&self, v: u32) -> u32 {
        self.0[v as usize].load(Ordering::Relaxed)
    }

    fn set(&self, v: u32, place: u32) {
        self.0[v as usize].store(place, Ordering::Relaxed);
    }
}

/// The sub-plates of one plate that may leave its rigid rotation.
pub(super) struct Margin {
    plate: PlateId,
    /// Speeds in km/My with which fronts are pushed inward, by vertex.
    pushes: Vec<(u32, DVec3)>,
    /// In the order of their rows.
    pub vertices: Vec<u32>,
    /// Edges between each vertex and the nearest push.
    ring: Vec<u32>,
    /// The vertex that is pushed there; [`NONE`] behind the margin.
    pushed: Vec<u32>,
}

/// What bending does to a margin.
pub(super) struct Bent {
    /// Of each vertex.
    pub deviation: Vec<Deviation>,
    /// Relative growth of the ground of each vertex.
    pub strain: Vec<f64>,
    /// Rest lengths by edge, in radii.
    pub rests: Vec<(u32, f32)>,
    /// Rest lengths of cross edges.
    pub cross_rests: Vec<(u32, f32)>,
}

/// A spring between two places in the margin. Small, because they are many: single precision is a ten
/// millionth of its length.
struct Spring {
    ends: [u32; 2],
    /// From one end to the other, in radii.
    along: Vec3,
    rest: f32,
}

impl Margin {
    /// Everything on the plate within the margin's width of a push, and all that still moves.
    pub(super) fn around(
        ground: &Ground,
        places: &Places,
        plate: PlateId,
        pushes: Vec<(u32, DVec3)>,
        moving: &[u32],
    ) -> Self {
        let constants = &ground.recipe.constants.margins;
        let rings = (constants.width / ground.recipe.spacing_km())
            .round()
            .max(1.0) as u32;
        // Rings first, places once the vertices are in order.
        let mut found: Vec<(u32, u32)> = pushes.iter().map(|(v, _)| (*v, *v)).collect();
        for &(v, _) in &found {
            places.set(v, 0);
        }
        let mut ring = 0..found.len();
        for distance in 1..=rings {
            for i in ring.clone() {
                let (v, pushed) = found[i];
                for w in ground.mesh.neighbours(v) {
                    if ground.plate[w as usize] == plate && places.get(w) == NONE {
                        places.set(w, distance);
                        found.push((w, pushed));
                    }
                }
            }
            ring = ring.end..found.len();
        }
        for &v in moving {
            if places.get(v) == NONE {
                places.set(v, FAR);
                found.push((v, NONE));
            }
        }
        found.sort_unstable();
        let (vertices, pushed): (Vec<u32>, Vec<u32>) = found.into_iter().unzip();
        let ring = vertices.iter().map(|&v| places.get(v)).collect();
        for (&v, place) in vertices.iter().zip(0..) {
            places.set(v, place);
        }
        Self {
            plate,
            pushes,
            vertices,
            ring,
            pushed,
        }
    }

    /// The vertex whose push reaches the one at this place first; none behind the margin.
    pub(super) fn pushed_by(&self, place: usize) -> Option<u32> {
        Some(self.pushed[place]).filter(|&v| v != NONE)
    }

    /// Where the margin goes, and what that does to it.
    pub(super) fn bend(&self, ground: &Ground, places: &Places) -> Bent {
        let Ground { recipe, mesh, .. } = ground;
        let constants = &recipe.constants.margins;
        let (radius, time) = (recipe.radius_km, ground.time);
        // Displacements until the next time, in radii, relative to the plate's rigid rotation.
        let kept = libm::exp(-time / constants.drag);
        let mut shift: Vec<Vec3> = self
            .vertices
            .iter()
            .map(|&v| ground.deviation[v as usize].0 * (kept * time / radius) as f32)
            .collect();
        for &(v, push) in &self.pushes {
            shift[places.get(v) as usize] = (push * (time / radius)).as_vec3();
        }
        let mut bent = Bent {
            deviation: Vec::with_capacity(self.vertices.len()),
            strain: Vec::new(),
            rests: Vec::with_capacity(4 * self.vertices.len()),
            cross_rests: Vec::with_capacity(4 * self.vertices.len()),
        };
        self.relax_springs(ground, places, &mut shift, &mut bent);

        for ((shift, &v), &ring) in shift.iter_mut().zip(&self.vertices).zip(&self.ring) {
            let site = mesh.site(v);
            // Fronts are as soft as their springs; plates stiffen across the margin's width.
            let inland =
                (f64::from(ring) * recipe.spacing_km() / constants.width.max(1.0)).min(1.0);
            let soft = shift.as_dvec3() * (1.0 - constants.rigidity * inland);
            let soft = soft - site * site.dot(soft);
            *shift = soft.as_vec3();
            let speed = soft * (radius / time);
            let still = speed.length() < STILL;
            if still {
                *shift = Vec3::ZERO;
            }
            bent.deviation
                .push(Deviation(if still { Vec3::ZERO } else { speed.as_vec3() }));
        }
        let strain = |&v: &u32| self.strain(ground, places, &shift, v);
        bent.strain = self.vertices.iter().map(strain).collect();
        bent
    }

    /// Projects all springs of the margin; ends outside it do not give.
    fn relax_springs(
        &self,
        ground: &Ground,
        places: &Places,
        shift: &mut Vec<Vec3>,
        bent: &mut Bent,
    ) {
        let mesh = ground.mesh;
        let constants = &ground.recipe.constants.margins;
        // Fronts go where they are pushed, whatever stands behind them, and so does nothing outside, which
        // is one more place.
        let mut gives: Vec<f32> = self.ring.iter().map(|&ring| ring.min(1) as f32).collect();
        gives.push(0.0);
        shift.push(Vec3::ZERO);
        let outside = self.vertices.len() as u32;
        let is_own = |v: u32| ground.plate[v as usize] == self.plate;

        // The rest length follows what lasts, and is measured anew where there was none.
        let flow = 1.0 - libm::exp(-ground.time / constants.flow);
        let (low, high) = (1.0 - constants.yield_strain, 1.0 + constants.yield_strain);
        let settle = |rest: f32, length: f64| {
            let old = if rest > 0.0 { f64::from(rest) } else { length };
            let relaxed = old + (length - old) * flow;
            round(relaxed.clamp(length * low, length * high), REST_STEPS) as f32
        };
        let mut springs: Vec<Spring> = Vec::with_capacity(7 * self.vertices.len());
        let mut spring = |ends: [u32; 2], rest: f32| {
            let along = mesh.site(ends[1]) - mesh.site(ends[0]);
            let rest = settle(rest, along.length());
            let ends = ends.map(|v| places.get(v).min(outside));
            if gives[ends[0] as usize] + gives[ends[1] as usize] > 0.0 {
                springs.push(Spring {
                    ends,
                    along: along.as_vec3(),
                    rest,
                });
            }
            rest
        };
        for h in self.vertices.iter().flat_map(|&v| mesh.outgoing(v)) {
            // Each edge once: by its origin where that lies in the margin, else by its other end.
            let (u, v) = (mesh.origin(h), mesh.dest(h));
            let joined = is_own(v);
            if h % 2 == 1 && joined && places.get(v) != NONE {
                continue;
            }
            let edge = h / 2;
            let state = mesh.payload(edge);
            let rest = if joined {
                spring([u, v], state.rest)
            } else {
                0.0
            };
            bent.rests.push((edge, rest));
            let across = [mesh.apex(h), mesh.apex(h ^ 1)];
            let cross_joined = across.map(is_own);
            if cross_joined == [true; 2] {
                bent.cross_rests
                    .push((edge, spring(across, state.cross_rest)));
            } else if cross_joined != [false; 2] {
                bent.cross_rests.push((edge, 0.0));
            }
        }

        let stretched = constants.compliance as f32;
        let compressed = (constants.compliance / constants.compressed_ratio) as f32;
        let project = |spring: &Spring, shift: &mut [Vec3]| {
            let [i, j] = spring.ends.map(|place| place as usize);
            let along = spring.along + shift[j] - shift[i];
            let length = along.length();
            let excess = length - spring.rest;
            let softness = if excess < 0.0 { compressed } else { stretched };
            let (from, to) = (gives[i], gives[j]);
            let give = along * (excess / (length.max(1e-9) * (from + to + softness)));
            shift[i] += give * from;
            shift[j] -= give * to;
        };
        for _ in 0..PASSES {
            springs.iter().for_each(|spring| project(spring, shift));
            springs
                .iter()
                .rev()
                .for_each(|spring| project(spring, shift));
        }
        shift.pop();
    }

    /// Relative growth of the triangles of its plate around a vertex under the displacements: what lies
    /// beyond a front is not its ground.
    fn strain(&self, ground: &Ground, places: &Places, shift: &[Vec3], v: u32) -> f64 {
        let mesh = ground.mesh;
        let is_own = |w: &u32| ground.plate[*w as usize] == self.plate;
        let moved = |w: u32| {
            let shift = shift.get(places.get(w) as usize);
            mesh.site(w) + shift.map_or(DVec3::ZERO, |shift| shift.as_dvec3())
        };
        let (mut before, mut after) = (0.0, 0.0);
        for h in mesh.outgoing(v) {
            let corners = mesh.triangle_vertices(h);
            if !corners.iter().all(is_own) {
                continue;
            }
            let area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length();
            before += area(corners.map(|w| mesh.site(w)));
            after += area(corners.map(moved));
        }
        if before > 0.0 {
            after / before - 1.0
        } else {
            0.0
        }
    }
}
