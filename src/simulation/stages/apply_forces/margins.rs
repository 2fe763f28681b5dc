//! Soft margins: springs hold what the boundaries bend.
//!
//! Where continents collide, their fronts yield by a share of the closing speed (Yggdrasill's
//! response, with its falloff over the distance of the two ends); where a continent advances on a trench,
//! its margin is shortened into a cordillera. Springs on the edges *and cross
//! edges* of the margin carry that inland. They are solved as position constraints (XPBD), stable at
//! any length of step, where explicit springs of the published stiffness would need steps of 200
//! years; rest lengths follow slowly, so that what stays bent is bent for good.

use super::super::super::{
    boundaries::Boundaries,
    clock::Clock,
    columns::Columns,
    error::TectonicError,
    plate::{Plate, PlateBorn, PlateTable, Rotation},
    recipe::{Drive, Recipe},
    sub_plate::{Crust, Deviation, MaterialArea, PlateId, SubPlate, Thickness},
    topology::{EdgeState, Topology},
    workers::{FEW, Workers},
};
use crate::mesh::{NONE, SphereMesh};
use bevy::prelude::*;
use glam::{DVec3, Vec3};

/// Deviations below this die at once, in km/My, so that margins heal and cost nothing.
const STILL: f64 = 0.1;
/// Pushes below this bend nothing worth the work, in km/My.
const LEAST_PUSH: f64 = 1.0;
/// A cordillera yields less the nearer its margin comes to the thickness of a plateau, in km.
const ROOM: f64 = 10.0;
/// Ring of sub-plates that still move but lie behind every margin.
const FAR: u32 = NONE - 1;
/// A cell that has shrunk to this share of the nominal one shrinks no further: it is about to be crushed.
const LEAST_AREA: f64 = 0.25;
/// Passes over the springs each time, there and back. What they do not settle now, the deviations carry on to
/// the next time: a push reaches the far side of a margin of a dozen cells within some My.
const PASSES: usize = 1;
/// Largest change of a cell's area at once.
const LARGEST_STRAIN: f64 = 0.5;

/// Bends the margins: sets the deviation of every sub-plate from its plate's rotation, and thickens
/// or thins the crust by what its cell loses or gains in area.
pub(in crate::simulation) fn bend_margins(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    workers: Res<Workers>,
    boundaries: Res<Boundaries>,
    mut topology: ResMut<Topology>,
    plates: Query<(Entity, &Plate, &Rotation, &PlateBorn)>,
    mut sub_plates: Query<
        (
            &PlateId,
            &Crust,
            &mut Deviation,
            &mut Thickness,
            &mut MaterialArea,
        ),
        With<SubPlate>,
    >,
) -> Result<(), TectonicError> {
    let mesh = &mut topology.0;
    let (plate, crust, mut deviation, mut thickness, mut area) =
        sub_plates.columns(mesh.vertex_count())?;
    let deviation = deviation.bypass_change_detection();
    let constants = &recipe.constants.margins;
    if recipe.drive != Drive::Soft || constants.rigidity >= 1.0 {
        return Ok(());
    }
    let Some(time) = clock.margins.due() else {
        return Ok(());
    };
    let radius = recipe.radius_km;

    let table = PlateTable::gather(plates.iter());
    let mut pushes = collision_pushes(&recipe, &boundaries, mesh, plate);
    pushes.extend(cordillera_pushes(
        &recipe,
        &boundaries,
        &table,
        crust,
        thickness.bypass_change_detection(),
    ));
    pushes.sort_by(|a, b| {
        a.0.cmp(&b.0)
            .then(b.1.length_squared().total_cmp(&a.1.length_squared()))
    });
    pushes.dedup_by_key(|(vertex, _)| *vertex);
    let margin = Margin::around(&recipe, mesh, plate, deviation, &pushes);
    if margin.vertices.is_empty() {
        return Ok(());
    }
    // Displacements until the next time, in radii, relative to the plate's rigid rotation.
    let kept = libm::exp(-time / constants.drag);
    let mut shift: Vec<Vec3> = margin
        .vertices
        .iter()
        .map(|&v| deviation[v as usize].0 * (kept * time / radius) as f32)
        .collect();
    for &(v, push) in &pushes {
        shift[margin.place[v as usize] as usize] = (push * (time / radius)).as_vec3();
    }
    margin.relax_springs(&recipe, &workers, mesh, plate, &mut shift, time);

    for ((shift, &v), &ring) in shift.iter_mut().zip(&margin.vertices).zip(&margin.ring) {
        let site = mesh.site(v);
        // Fronts are as soft as their springs; plates stiffen across the margin's width.
        let inland = (f64::from(ring) * recipe.spacing_km() / constants.width.max(1.0)).min(1.0);
        let soft = shift.as_dvec3() * (1.0 - constants.rigidity * inland);
        let soft = soft - site * site.dot(soft);
        *shift = soft.as_vec3();
        let speed = soft * (radius / time);
        let still = speed.length() < STILL;
        deviation[v as usize].0 = if still { Vec3::ZERO } else { speed.as_vec3() };
    }
    let mesh = &*mesh;
    let strains = workers.run(margin.vertices.chunks(FEW), |part| {
        let strain = |&v: &u32| margin.strain(mesh, plate, &shift, v);
        part.iter().map(strain).collect::<Vec<f64>>()
    });
    let (thickness, area) = (
        thickness.bypass_change_detection(),
        area.bypass_change_detection(),
    );
    for (&v, strain) in margin.vertices.iter().zip(strains.into_iter().flatten()) {
        // Volume = thickness × area stays exactly.
        let ratio = 1.0 + strain.clamp(-LARGEST_STRAIN, LARGEST_STRAIN);
        let fits = thickness[v as usize].0 / ratio <= recipe.constants.collisions.thickest
            && area[v as usize].0 * ratio >= LEAST_AREA * recipe.cell_area_km2();
        if ratio > 1.0 || fits {
            let volume = thickness[v as usize].0 * area[v as usize].0;
            area[v as usize].0 *= ratio;
            thickness[v as usize].0 = volume / area[v as usize].0;
        }
    }
    Ok(())
}

/// Speeds in km/My with which colliding fronts yield, inward, by vertex.
fn collision_pushes(
    recipe: &Recipe,
    boundaries: &Boundaries,
    mesh: &SphereMesh<EdgeState>,
    plate: &[PlateId],
) -> Vec<(u32, DVec3)> {
    let spacing = recipe.spacing_km();
    let mut pushes: Vec<(u32, DVec3)> = Vec::new();
    for front in &boundaries.fronts {
        if !front.continental || front.opening >= 0.0 {
            continue;
        }
        let [u, v] = front.vertices;
        let distance = mesh.site(u).distance(mesh.site(v)) * recipe.radius_km;
        // Yggdrasill: 1 / (1 + (max(0, d − d_min) / d_min)²), with d_min at the local scale.
        let far = (distance - 0.7 * spacing).max(0.0) / (0.7 * spacing);
        let falloff = 1.0 / (1.0 + far * far);
        let speed = 0.5 * recipe.constants.margins.shortening * -front.opening * falloff;
        if speed < LEAST_PUSH {
            continue;
        }
        for (vertex, inward) in [(u, -front.direction), (v, front.direction)] {
            if plate[vertex as usize].0 != 0 {
                pushes.push((vertex, inward * speed));
            }
        }
    }
    pushes
}

/// Speeds in km/My with which continents yield over a trench that they advance on, inward, by vertex
/// (Heuret & Lallemand 2005: what strains an overriding plate is its own motion towards the trench).
fn cordillera_pushes(
    recipe: &Recipe,
    boundaries: &Boundaries,
    table: &PlateTable,
    crust: &[Crust],
    thickness: &[Thickness],
) -> Vec<(u32, DVec3)> {
    let constants = &recipe.constants.margins;
    let highest = recipe.constants.uplift.plateau_thickness;
    let mut pushes = Vec::new();
    for front in &boundaries.fronts {
        let (Some(under), true) = (front.under, front.opening < 0.0) else {
            continue;
        };
        let over = 1 - under;
        let vertex = front.vertices[over] as usize;
        if front.continental || !crust[vertex].is_continental() {
            continue;
        }
        // From the overriding plate to the trench.
        let seaward = if over == 0 {
            front.direction
        } else {
            -front.direction
        };
        let motion = table.rotation(front.plates[over]).cross(front.midpoint) * recipe.radius_km;
        let advance = motion.dot(seaward).min(-front.opening);
        // A plateau that has grown as high as it can stand passes the push on, and it dies out.
        let room = ((highest - thickness[vertex].0) / ROOM).clamp(0.0, 1.0);
        let speed = constants.cordillera * advance * room;
        if speed >= LEAST_PUSH {
            pushes.push((vertex as u32, -seaward * speed));
        }
    }
    pushes
}

/// A spring between two places in the margin. Small, because they are many: single precision is a ten
/// millionth of its length.
struct Spring {
    ends: [u32; 2],
    /// From one end to the other, in radii.
    along: Vec3,
    rest: f32,
}

/// The sub-plates that may leave their plate's rigid rotation in this step.
struct Margin {
    vertices: Vec<u32>,
    place: Vec<u32>,
    /// Edges between each vertex and the nearest push.
    ring: Vec<u32>,
}

impl Margin {
    /// Everything on the same plate within the margin's width of a push, and all that still moves.
    fn around(
        recipe: &Recipe,
        mesh: &SphereMesh<EdgeState>,
        plate: &[PlateId],
        deviation: &[Deviation],
        pushes: &[(u32, DVec3)],
    ) -> Self {
        let rings = (recipe.constants.margins.width / recipe.spacing_km())
            .round()
            .max(1.0) as u32;
        // Rings first, places once the vertices are in order.
        let mut place = vec![NONE; mesh.vertex_count()];
        let mut vertices: Vec<u32> = pushes.iter().map(|(v, _)| *v).collect();
        for &v in &vertices {
            place[v as usize] = 0;
        }
        let mut ring = 0..vertices.len();
        for distance in 1..=rings {
            for i in ring.clone() {
                let v = vertices[i];
                for w in mesh.neighbours(v) {
                    if place[w as usize] == NONE && plate[w as usize] == plate[v as usize] {
                        place[w as usize] = distance;
                        vertices.push(w);
                    }
                }
            }
            ring = ring.end..vertices.len();
        }
        for (v, deviation) in deviation.iter().enumerate() {
            if deviation.0 != Vec3::ZERO && place[v] == NONE {
                place[v] = FAR;
            }
        }
        // In the order of their rows.
        vertices.clear();
        let mut ring = Vec::new();
        for (place, v) in place.iter_mut().zip(0..) {
            if *place != NONE {
                ring.push(core::mem::replace(place, vertices.len() as u32));
                vertices.push(v);
            }
        }
        Self {
            vertices,
            place,
            ring,
        }
    }

    /// Place of a vertex in the margin, if it belongs to it.
    fn place(&self, v: u32) -> Option<usize> {
        let place = self.place[v as usize];
        (place != NONE).then_some(place as usize)
    }

    /// Projects all springs of the margin; ends outside it do not give.
    fn relax_springs(
        &self,
        recipe: &Recipe,
        workers: &Workers,
        mesh: &mut SphereMesh<EdgeState>,
        plate: &[PlateId],
        shift: &mut Vec<Vec3>,
        time: f64,
    ) {
        let constants = &recipe.constants.margins;
        // Fronts go where they are pushed, whatever stands behind them, and so does nothing outside, which
        // is one more place.
        let mut gives: Vec<f32> = self.ring.iter().map(|&ring| ring.min(1) as f32).collect();
        gives.push(0.0);
        shift.push(Vec3::ZERO);
        let outside = self.vertices.len() as u32;
        let place = |v: u32| self.place[v as usize].min(outside);

        // The rest length follows what lasts, and is measured anew where there was none.
        let flow = 1.0 - libm::exp(-time / constants.flow);
        let (low, high) = (1.0 - constants.yield_strain, 1.0 + constants.yield_strain);
        let settle = |rest: f32, length: f64| {
            let old = if rest > 0.0 { f64::from(rest) } else { length };
            let relaxed = old + (length - old) * flow;
            relaxed.clamp(length * low, length * high) as f32
        };
        let springs_at = |mesh: &SphereMesh<EdgeState>, vertices: &[u32]| {
            let mut springs = Vec::with_capacity(7 * vertices.len());
            let mut rests = Vec::with_capacity(4 * vertices.len());
            for h in vertices.iter().flat_map(|&v| mesh.outgoing(v)) {
                // Each edge once: by its origin where that lies in the margin, else by its other end.
                let (u, v) = (mesh.origin(h), mesh.dest(h));
                if h % 2 == 1 && place(v) != outside {
                    continue;
                }
                let across = [mesh.apex(h), mesh.apex(h ^ 1)];
                let state = mesh.payload(h / 2);
                let rest =
                    [([u, v], state.rest), (across, state.cross_rest)].map(|(ends, rest)| {
                        let [a, b] = ends;
                        if plate[a as usize] != plate[b as usize] {
                            return 0.0;
                        }
                        let along = mesh.site(b) - mesh.site(a);
                        let rest = settle(rest, along.length());
                        let ends = ends.map(place);
                        let free = gives[ends[0] as usize] + gives[ends[1] as usize];
                        if free > 0.0 {
                            springs.push(Spring {
                                ends,
                                along: along.as_vec3(),
                                rest,
                            });
                        }
                        rest
                    });
                rests.push((h / 2, rest));
            }
            (springs, rests)
        };
        let found = {
            let mesh = &*mesh;
            workers.run(self.vertices.chunks(FEW), |part| springs_at(mesh, part))
        };
        for (edge, [rest, cross_rest]) in found.iter().flat_map(|(_, rests)| rests) {
            let state = mesh.payload_mut(*edge);
            (state.rest, state.cross_rest) = (*rest, *cross_rest);
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
            let there = found.iter().flat_map(|(springs, _)| springs);
            there.for_each(|spring| project(spring, shift));
            let back = found
                .iter()
                .rev()
                .flat_map(|(springs, _)| springs.iter().rev());
            back.for_each(|spring| project(spring, shift));
        }
        shift.pop();
    }

    /// Relative growth of the triangles of its plate around a vertex under the displacements: what lies
    /// beyond a front is not its ground.
    fn strain(
        &self,
        mesh: &SphereMesh<EdgeState>,
        plate: &[PlateId],
        shift: &[Vec3],
        v: u32,
    ) -> f64 {
        let moved = |w: u32| {
            mesh.site(w)
                + self
                    .place(w)
                    .map_or(DVec3::ZERO, |place| shift[place].as_dvec3())
        };
        let (mut before, mut after) = (0.0, 0.0);
        for h in mesh.outgoing(v) {
            let [a, b, c] = mesh.triangle_vertices(h);
            if [a, b, c]
                .iter()
                .any(|&w| plate[w as usize] != plate[v as usize])
            {
                continue;
            }
            let area = |a: DVec3, b: DVec3, c: DVec3| (b - a).cross(c - a).length();
            before += area(mesh.site(a), mesh.site(b), mesh.site(c));
            after += area(moved(a), moved(b), moved(c));
        }
        if before > 0.0 {
            after / before - 1.0
        } else {
            0.0
        }
    }
}
