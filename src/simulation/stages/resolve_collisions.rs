//! Stage 7: crust that goes under or is crushed.
//!
//! A sub-plate leaves the mesh *before* its faces invert, when it comes too close to the other plate
//! while closing. Sea floor is consumed; continental crust is never lost: its volume thickens what
//! stays on both sides.

use super::{
    super::{
        boundaries::{Boundaries, Contacts, Motion, Unsettled},
        clock::Clock,
        columns::Columns,
        error::TectonicError,
        ledger::Ledger,
        plate::{Plate, PlateBorn, PlateTable, Rotation},
        reach::Marks,
        recipe::Recipe,
        stages::{
            Splits,
            reorganize_plates::{Carried, cut_by_flips, leave_plate},
        },
        sub_plate::*,
        topology::{EdgeState, Topology},
        workers::Workers,
    },
    crushed_crust::{Circle, Ground, circle_around, first_circle_cells, spread_volume},
    uplift::folded,
};
use crate::mesh::SphereMesh;
use bevy::prelude::*;
use std::collections::BTreeMap;

/// Removals open new contacts; more sweeps than this never found any (study).
const SWEEPS: usize = 4;
/// Pieces in which circles are looked for: each has marks of its own, of four bytes for every sub-plate.
const CIRCLES: usize = 4;
/// Sub-plates that they hold together at most.
const MOST_HELD: f64 = 2e7;

/// A continental sub-plate that has this much more of its neighbours on other plates than the one it meets
/// is the one that goes.
const JUTTING: f64 = 0.1;

/// Marks that are kept from step to step: making them anew would cost as much as some sweeps do.
#[derive(Default)]
pub(in crate::simulation) struct Scratch {
    walked: Marks,
    walks: [Marks; CIRCLES],
    watched: Marks,
    touched: Marks,
}

type CollisionColumns = (
    Entity,
    &'static mut PlateId,
    &'static mut Crust,
    &'static mut Thickness,
    &'static mut MaterialArea,
    &'static mut Created,
    &'static mut Orogeny,
    &'static mut OrogenyBegan,
    &'static mut FoldDirection,
);

/// Removes what the last move pushed under or crushed.
pub(in crate::simulation) fn resolve_collisions(
    mut commands: Commands,
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    workers: Res<Workers>,
    boundaries: Res<Boundaries>,
    contacts: Res<Contacts>,
    mut topology: ResMut<Topology>,
    mut ledger: ResMut<Ledger>,
    mut splits: ResMut<Splits>,
    mut unsettled: ResMut<Unsettled>,
    mut scratch: Local<Scratch>,
    plates: Query<(Entity, &Plate, &Rotation, &PlateBorn)>,
    mut sub_plates: Query<CollisionColumns, With<SubPlate>>,
) -> Result<(), TectonicError> {
    let mesh = &mut topology.0;
    let (
        entity,
        mut plate,
        mut crust,
        mut thickness,
        mut area,
        mut created,
        mut orogeny,
        mut began,
        mut fold,
    ) = sub_plates.columns(mesh.vertex_count())?;
    let Scratch {
        walked,
        walks,
        watched,
        touched,
    } = &mut *scratch;
    let mut ground = Ground {
        plate: plate.bypass_change_detection(),
        crust: crust.bypass_change_detection(),
        thickness: thickness.bypass_change_detection(),
        area: area.bypass_change_detection(),
        created: created.bypass_change_detection(),
        orogeny: orogeny.bypass_change_detection(),
        began: began.bypass_change_detection(),
        fold: fold.bypass_change_detection(),
        marks: walked,
    };
    let judge = Judge {
        recipe: &recipe,
        boundaries: &boundaries,
        contacts: &contacts,
        plates: PlateTable::gather(plates.iter()),
    };

    // Where to look: around every front, and wherever the last sweep changed something.
    let mut watch: Vec<u32> = boundaries
        .vertices
        .iter()
        .copied()
        .chain(boundaries.place.len() as u32..mesh.vertex_count() as u32)
        .collect();
    unsettled.0.clone_from(&watch);
    let mut gone: Vec<u32> = Vec::new();
    let mut cuts: Vec<[u32; 2]> = Vec::new();
    for _ in 0..SWEEPS {
        let victims = judge.find_victims(mesh, &ground, &watch, [watched, touched], &workers);
        let circles = circles(&recipe, mesh, &ground, &victims, walks, &workers);
        touched.wipe(mesh.vertex_count());
        let mut dirty: Vec<u32> = Vec::new();
        for (victim, circle) in victims.into_iter().zip(circles) {
            let v = victim.vertex;
            let is_near = touched.is_marked(v) || touched.is_marked(victim.against);
            if is_near || mesh.degree(v) <= 3 {
                continue;
            }
            let Some(h) = mesh.best_collapse(v, |_| true) else {
                continue;
            };
            let ring: Vec<u32> = mesh.neighbours(v).collect();
            let own = ground.plate[v as usize];
            // The last sub-plate of a plate takes the plate along.
            let others = || (0..).zip(&*ground.plate).filter(|(_, id)| **id == own);
            splits.suspected |= !leave_plate(&mut cuts, &mut splits.cuts, v, &ring, ground.plate)
                && others().all(|(w, _)| w == v || mesh.is_detached(w));
            judge.bury(
                mesh,
                &mut ground,
                &mut ledger,
                victim,
                circle,
                clock.time_my,
                clock.step_my,
            );
            mesh.collapse(h);
            for w in ring {
                touched.mark(w);
                dirty.push(w);
            }
            gone.push(v);
        }
        if dirty.is_empty() {
            break;
        }
        dirty.sort_unstable();
        dirty.dedup();
        let queue = edges_around(mesh, &dirty);
        let flips = mesh
            .repair_locally(queue)
            .map_err(|source| TectonicError::Repair {
                time_my: clock.time_my,
                source,
            })?;
        cuts.extend(cut_by_flips(&flips, Carried::by(ground.plate)));
        unsettled.0.extend(&dirty);
        unsettled.0.extend(flips.iter().flat_map(|flip| flip.after));
        watch = dirty;
    }
    splits.note_cuts(mesh, Carried::by(ground.plate), &cuts);
    // Row = vertex: both tables swap-remove in the same order, from the back.
    gone.sort_unstable_by(|a, b| b.cmp(a));
    for v in gone {
        commands.entity(entity[v as usize]).despawn();
    }
    Ok(())
}

/// Gives the rows of removed sub-plates to the last ones, as the table did when they despawned.
pub(in crate::simulation) fn close_ranks(
    workers: Res<Workers>,
    mut topology: ResMut<Topology>,
    mut boundaries: ResMut<Boundaries>,
    mut unsettled: ResMut<Unsettled>,
    mut splits: ResMut<Splits>,
) {
    let mesh = &mut topology.0;
    let gone = workers.map(mesh.vertex_count(), |rows| {
        let rows = rows.start as u32..rows.end as u32;
        rows.filter(|&v| mesh.is_detached(v)).collect::<Vec<u32>>()
    });
    unsettled.0.retain(|&v| !mesh.is_detached(v));
    splits.suspected |= (splits.cuts.iter().flatten()).any(|&v| mesh.is_detached(v));
    if splits.suspected {
        splits.cuts.clear();
    }
    // First number of what has been given another one, by its present number.
    let mut first: BTreeMap<u32, u32> = BTreeMap::new();
    for v in gone.into_iter().flatten().rev() {
        if let Some(last) = mesh.remove_detached(v) {
            let number = first.remove(&last).unwrap_or(last);
            first.insert(v, number);
        }
    }
    let now: BTreeMap<u32, u32> = first.into_iter().map(|(now, first)| (first, now)).collect();
    for v in unsettled.0.iter_mut().chain(splits.cuts.as_flattened_mut()) {
        *v = now.get(v).copied().unwrap_or(*v);
    }
    // Vertices have new numbers: what was known by number is void.
    boundaries.fronts.clear();
    boundaries.vertices.clear();
    boundaries.strikes.clear();
    boundaries.place.clear();
    boundaries.polarity.clear();
}

/// Edges at the given vertices and of the triangles around them.
pub(in crate::simulation) fn edges_around(
    mesh: &SphereMesh<EdgeState>,
    vertices: &[u32],
) -> Vec<u32> {
    let mut edges: Vec<u32> = Vec::new();
    for &v in vertices {
        if mesh.is_detached(v) {
            continue;
        }
        for h in mesh.outgoing(v) {
            edges.extend([h / 2, mesh.next(h) / 2]);
        }
    }
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// A sub-plate that must go, and the one it came too close to.
#[derive(Clone, Copy)]
struct Victim {
    vertex: u32,
    against: u32,
}

/// Decides who goes under.
struct Judge<'a> {
    recipe: &'a Recipe,
    boundaries: &'a Boundaries,
    contacts: &'a Contacts,
    plates: PlateTable,
}

impl Judge<'_> {
    fn motion(&self, mesh: &SphereMesh<EdgeState>, plate: &[PlateId], a: u32, b: u32) -> Motion {
        let end = |v: u32| (v, mesh.site(v), plate[v as usize]);
        self.boundaries
            .motion(&self.plates, self.recipe.radius_km, end(a), end(b))
    }

    /// Distances that count as contact are smaller where plates slide past each other.
    fn relaxed(&self, motion: Motion) -> f64 {
        let constants = &self.recipe.constants.collisions;
        if motion.is_near_transform(constants.transform_share) {
            constants.transform_factor
        } else {
            1.0
        }
    }

    /// Who goes under of two sub-plates on different plates, and who stays.
    fn victim(&self, mesh: &SphereMesh<EdgeState>, ground: &Ground, a: u32, b: u32) -> Victim {
        let (u, v) = (a as usize, b as usize);
        let first = match (
            ground.crust[u].is_continental(),
            ground.crust[v].is_continental(),
        ) {
            (false, true) => true,
            (true, false) => false,
            (true, true) => {
                // What juts out is crushed from three sides: without this thick crust would win
                // everywhere, and fronts grow into combs.
                let jut = |v: u32| {
                    let own = ground.plate[v as usize];
                    let (mut foreign, mut all) = (0, 0);
                    for w in mesh.neighbours(v) {
                        all += 1;
                        foreign += i32::from(ground.plate[w as usize] != own);
                    }
                    f64::from(foreign) / f64::from(all)
                };
                let difference = jut(a) - jut(b);
                if difference.abs() > JUTTING {
                    difference > 0.0
                } else {
                    ground.thickness[u].0 <= ground.thickness[v].0
                }
            }
            (false, false) => match self
                .boundaries
                .sinking((a, ground.plate[u]), (b, ground.plate[v]))
                .or_else(|| {
                    let contact = self.contacts.get(ground.plate[u], ground.plate[v])?;
                    contact.subducting
                }) {
                Some(sinking) => sinking == ground.plate[u],
                None => ground.created[u].0 <= ground.created[v].0,
            },
        };
        if first {
            Victim {
                vertex: a,
                against: b,
            }
        } else {
            Victim {
                vertex: b,
                against: a,
            }
        }
    }

    /// All that must go, nearest contacts first.
    fn find_victims(
        &self,
        mesh: &SphereMesh<EdgeState>,
        ground: &Ground,
        watch: &[u32],
        [watched, seen]: [&mut Marks; 2],
        workers: &Workers,
    ) -> Vec<Victim> {
        let constants = &self.recipe.constants.collisions;
        let radius = self.recipe.radius_km;
        watched.wipe(mesh.vertex_count());
        for &v in watch {
            watched.mark(v);
        }
        let spacing =
            |u: u32, v: u32| (0.5 * (ground.area[u as usize].0 + ground.area[v as usize].0)).sqrt();
        // Motion is dear: it is asked for only where the distance could decide.
        let closes_on = |a: u32, b: u32, near: f64, limit: f64| {
            near < limit && {
                let motion = self.motion(mesh, ground.plate, a, b);
                motion.opening < 0.0 && near < limit * self.relaxed(motion)
            }
        };
        let look = |h: u32, victims: &mut Vec<(f64, Victim)>| {
            let corners = mesh.triangle_vertices(h);
            let plate = corners.map(|v| ground.plate[v as usize]);
            let inverted = mesh.is_inverted(h);
            for i in 0..3 {
                let [a, b, c] = [corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]];
                if plate[i] == plate[(i + 1) % 3] {
                    continue;
                }
                let near = mesh.site(a).distance(mesh.site(b)) * radius / spacing(a, b);
                let crushed = near < constants.edge_always
                    && near
                        < constants.edge_always
                            * self.relaxed(self.motion(mesh, ground.plate, a, b));
                if inverted || crushed || closes_on(a, b, near, constants.edge) {
                    victims.push((near, self.victim(mesh, ground, a, b)));
                }
                // A vertex that heads for the middle of an edge never comes close to its ends.
                if plate[i] == plate[(i + 2) % 3] {
                    continue;
                }
                let (p, q, r) = (mesh.site(a), mesh.site(b), mesh.site(c));
                let side = r - q;
                let along = (p - q).dot(side) / side.length_squared();
                if !(0.0..=1.0).contains(&along) {
                    continue;
                }
                let near_end = if along < 0.5 { b } else { c };
                let height = (p - (q + side * along)).length() * radius / spacing(a, near_end);
                if closes_on(a, near_end, height, constants.height) {
                    victims.push((height, self.victim(mesh, ground, a, near_end)));
                }
            }
        };
        let found = workers.map(watch.len(), |part| {
            let mut victims = Vec::new();
            for &v in watch[part].iter().filter(|&&v| !mesh.is_detached(v)) {
                for h in mesh.outgoing(v) {
                    let (b, c) = (mesh.dest(h), mesh.apex(h));
                    let [of, of_b, of_c] = [v, b, c].map(|v| ground.plate[v as usize]);
                    // Each triangle once: by the first of its corners that is watched.
                    let first = |w: u32| !watched.is_marked(w) || v < w;
                    if (of != of_b || of != of_c) && first(b) && first(c) {
                        look(h, &mut victims);
                    }
                }
            }
            victims
        });
        let mut victims = found.concat();
        victims.sort_by(|a, b| {
            a.0.total_cmp(&b.0)
                .then(a.1.vertex.cmp(&b.1.vertex))
                .then(a.1.against.cmp(&b.1.against))
        });
        seen.wipe(mesh.vertex_count());
        victims.retain(|(_, victim)| seen.mark(victim.vertex));
        victims.into_iter().map(|(_, victim)| victim).collect()
    }

    /// Books the end of a sub-plate; a continental one hands its volume to what stays.
    fn bury(
        &self,
        mesh: &SphereMesh<EdgeState>,
        ground: &mut Ground,
        ledger: &mut Ledger,
        victim: Victim,
        mut circle: Circle,
        now: f64,
        step: f64,
    ) {
        let v = victim.vertex as usize;
        ledger.area_consumed_km2 += ground.area[v].0;
        if !ground.crust[v].is_continental() {
            return;
        }
        ledger.area_shortened_km2 += ground.area[v].0;
        let volume = ground.thickness[v].0 * ground.area[v].0;
        // Nothing of it may flow back into the vertex that leaves.
        ground.thickness[v].0 = 0.0;
        ground.crust[v] = Crust::Oceanic;
        let slip = (self.plates.rotation(ground.plate[victim.against as usize])
            - self.plates.rotation(ground.plate[v]))
        .cross(mesh.site(victim.vertex))
            * self.recipe.radius_km;
        let from = victim.vertex;
        // What the crust of an earlier victim has made a continent has none yet.
        if circle.is_empty() {
            circle = circle_around(self.recipe, mesh, ground.marks, from);
        }
        for w in spread_volume(self.recipe, mesh, ground, ledger, from, circle, volume) {
            ground.orogeny[w] = Orogeny::Himalayan;
            ground.began[w].0 = now as f32;
            ground.fold[w].0 = folded(ground.fold[w].0, slip, mesh.site(w as u32), step.max(1.0));
        }
    }
}

/// The first circles around those victims that are continental; none around others, nor where all of them would be
/// too much to hold. What leaves the mesh meanwhile is no continent any more.
fn circles(
    recipe: &Recipe,
    mesh: &SphereMesh<EdgeState>,
    ground: &Ground,
    victims: &[Victim],
    walks: &mut [Marks; CIRCLES],
    workers: &Workers,
) -> Vec<Circle> {
    let is_much = victims.len() as f64 * first_circle_cells(recipe) > MOST_HELD;
    let parts = victims.chunks(victims.len().div_ceil(CIRCLES).max(1));
    let found = workers.run(parts.zip(walks), |(victims, marks)| {
        let around = |victim: &Victim| {
            if ground.crust[victim.vertex as usize].is_continental() && !is_much {
                circle_around(recipe, mesh, marks, victim.vertex)
            } else {
                Vec::new()
            }
        };
        victims.iter().map(around).collect::<Vec<_>>()
    });
    found.into_iter().flatten().collect()
}
