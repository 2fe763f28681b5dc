//! Stage 2: which edges cross a boundary, how it strikes, and what kind it is.
//!
//! A state machine on every edge, primal and cross (Yggdrasill, step 2). The kind follows from the
//! share of the slip that opens or closes a *smoothed* front: the raw directions of edges zigzag,
//! and would make crust along transforms.

mod polarity;

use super::super::{
    boundaries::{Boundaries, Contacts, Front},
    clock::Clock,
    columns::Columns,
    constants::BoundaryConstants,
    error::TectonicError,
    plate::{Plate, PlateBorn, PlateTable, Rotation},
    recipe::Recipe,
    sub_plate::{Created, Crust, PlateId, Slab, SubPlate},
    topology::{BoundaryKind, EdgeState, Topology},
    workers::{FEW, Workers},
};
use crate::mesh::{NONE, SphereMesh};
use bevy::prelude::*;
use glam::DVec3;
use std::collections::BTreeMap;

/// Finds the fronts between plates, smooths their strike and names their kind.
pub(in crate::simulation) fn classify_boundaries(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    workers: Res<Workers>,
    mut topology: ResMut<Topology>,
    mut boundaries: ResMut<Boundaries>,
    mut contacts: ResMut<Contacts>,
    plates: Query<(Entity, &Plate, &Rotation, &PlateBorn)>,
    mut sub_plates: Query<(&PlateId, &Crust, &Created, &mut Slab), With<SubPlate>>,
) -> Result<(), TectonicError> {
    let mesh = &mut topology.0;
    let (plate, crust, created, mut slab) = sub_plates.columns(mesh.vertex_count())?;
    let plates = PlateTable::gather(plates.iter());
    let constants = &recipe.constants.boundaries;
    let boundaries = &mut *boundaries;

    find_fronts(&workers, mesh, plate, recipe.radius_km, boundaries);
    smooth_strikes(&workers, mesh, plate, constants.smoothing, boundaries);
    let mut fronts = core::mem::take(&mut boundaries.fronts);
    workers.run(fronts.chunks_mut(FEW), |fronts| {
        for front in fronts {
            front.aim(boundaries, mesh, &plates, recipe.radius_km);
            let continental = |&v: &u32| crust[v as usize].is_continental();
            front.continental = front.vertices.iter().all(continental);
        }
    });
    contacts.carry_rifts(&plates, clock.step_my);
    remember_contacts(&workers, &fronts, &clock, &recipe, &mut contacts);
    polarity::settle(
        &workers,
        mesh,
        &mut fronts,
        crust,
        created,
        slab.bypass_change_detection(),
        &recipe,
        &mut contacts,
    );
    boundaries.list_polarity(&workers, &fronts, crust);
    let found = workers.run(fronts.chunks(FEW), |fronts| {
        let mut kinds = Vec::with_capacity(fronts.len());
        let mut cross_kinds = Vec::with_capacity(5 * fronts.len());
        for front in fronts {
            let kind = classify(mesh.payload(front.edge).kind, front, constants);
            kinds.push(kind);
            cross_kinds.extend(cross_edges(mesh, plate, front.edge, kind));
        }
        (kinds, cross_kinds)
    });
    let (kinds, cross_kinds): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    for (front, kind) in fronts.iter().zip(kinds.into_iter().flatten()) {
        mesh.payload_mut(front.edge).kind = kind;
    }
    for (edge, kind) in cross_kinds.into_iter().flatten() {
        mesh.payload_mut(edge).cross_kind = kind;
    }
    boundaries.fronts = fronts;
    Ok(())
}

/// Collects the edges across plates with their dual normals, and the vertices at them.
fn find_fronts(
    workers: &Workers,
    mesh: &mut SphereMesh<EdgeState>,
    plate: &[PlateId],
    radius: f64,
    boundaries: &mut Boundaries,
) {
    boundaries.fronts.clear();
    boundaries.vertices.clear();
    boundaries.place.clear();
    boundaries.place.resize(mesh.vertex_count(), NONE);
    // Edges across plates, and edges that still say they were.
    let found = workers.map(mesh.edge_slots(), |slots| {
        let (mut fronts, mut healed): (Vec<Front>, Vec<u32>) = (Vec::new(), Vec::new());
        for edge in slots.start as u32..slots.end as u32 {
            if !mesh.is_edge(edge) {
                continue;
            }
            let (u, v) = mesh.endpoints(edge);
            let plates = [plate[u as usize], plate[v as usize]];
            if plates[0] != plates[1] {
                fronts.push(Front::across(mesh, edge, plates, radius));
            } else {
                let state = mesh.payload(edge);
                if state.kind != BoundaryKind::Joined || state.cross_kind != BoundaryKind::Joined {
                    healed.push(edge);
                }
            }
        }
        (fronts, healed)
    });
    for (fronts, healed) in found {
        for edge in healed {
            let state = mesh.payload_mut(edge);
            state.kind = BoundaryKind::Joined;
            state.cross_kind = BoundaryKind::Joined;
        }
        for vertex in fronts.iter().flat_map(|front| front.vertices) {
            boundaries.place[vertex as usize] = 0;
        }
        boundaries.fronts.extend(fronts);
    }
    boundaries.number_vertices();
}

/// Sums the normals at every vertex of a front, then blends them twice with the neighbours'.
pub(in crate::simulation) fn smooth_strikes(
    workers: &Workers,
    mesh: &SphereMesh<EdgeState>,
    plate: &[PlateId],
    weight: f64,
    boundaries: &mut Boundaries,
) {
    let Boundaries {
        fronts,
        vertices,
        strikes,
        place,
        ..
    } = boundaries;
    strikes.clear();
    strikes.resize(vertices.len(), DVec3::ZERO);
    for front in fronts.iter() {
        let [u, v] = front.vertices.map(|v| place[v as usize] as usize);
        strikes[u] += front.normal;
        strikes[v] -= front.normal;
    }
    // Neighbours at fronts, each with its sign, and where each vertex's begin.
    let around = workers.run(vertices.chunks(FEW), |vertices| {
        let mut near: Vec<(u32, f64)> = Vec::with_capacity(4 * vertices.len());
        let mut ends: Vec<u32> = Vec::with_capacity(vertices.len());
        for &v in vertices {
            for w in mesh.neighbours(v) {
                if place[w as usize] != NONE {
                    let own = plate[w as usize] == plate[v as usize];
                    near.push((place[w as usize], if own { weight } else { -weight }));
                }
            }
            ends.push(near.len() as u32);
        }
        (near, ends)
    });
    for _ in 0..2 {
        let before = strikes.clone();
        let parts = strikes
            .chunks_mut(FEW)
            .zip(vertices.chunks(FEW))
            .zip(&around);
        workers.run(parts, |((strikes, vertices), (near, ends))| {
            let mut begin = 0;
            for ((strike, &v), &end) in strikes.iter_mut().zip(vertices.iter()).zip(ends) {
                for &(place, sign) in &near[begin..end as usize] {
                    *strike += before[place as usize] * sign;
                }
                begin = end as usize;
                let site = mesh.site(v);
                *strike -= site * site.dot(*strike);
            }
        });
    }
}

/// Brings what each pair of plates remembers up to date.
fn remember_contacts(
    workers: &Workers,
    fronts: &[Front],
    clock: &Clock,
    recipe: &Recipe,
    contacts: &mut Contacts,
) {
    #[derive(Default)]
    struct Sum {
        length: f64,
        continental: f64,
        closing: f64,
        untorn: f64,
    }
    let sum = |run: &[Front]| {
        let key = Contacts::key(run[0].plates[0], run[0].plates[1]);
        let rift = contacts.0.get(&key).and_then(|contact| contact.rift);
        let mut sum = Sum::default();
        for front in run {
            sum.length += front.length;
            if rift.is_some_and(|rift| rift.holds(front, clock.time_my, recipe)) {
                sum.untorn += front.length;
            }
            if front.continental {
                sum.continental += front.length;
                sum.closing += front.length * (-front.opening).max(0.0);
            }
        }
        (key, sum)
    };
    let parts = workers.run(fronts.chunks(FEW), |fronts| {
        // Fronts that follow each other mostly part the same plates.
        let runs = fronts.chunk_by(|a, b| a.plates == b.plates);
        runs.map(sum).collect::<Vec<_>>()
    });
    let mut sums: BTreeMap<(PlateId, PlateId), Sum> = BTreeMap::new();
    for (key, part) in parts.into_iter().flatten() {
        let sum = sums.entry(key).or_default();
        sum.length += part.length;
        sum.continental += part.continental;
        sum.closing += part.closing;
        sum.untorn += part.untorn;
    }
    for (key, sum) in sums {
        let contact = contacts.0.entry(key).or_default();
        contact.last_my = clock.time_my;
        contact.continental_share = sum.continental / sum.length.max(1e-9);
        contact.closing = if sum.continental > 0.0 {
            sum.closing / sum.continental
        } else {
            0.0
        };
        contact.untorn_km = sum.untorn;
        contact.interpenetration += contact.closing * clock.step_my;
    }
    contacts
        .0
        .retain(|_, contact| clock.time_my - contact.last_my < recipe.constants.boundaries.memory);
}

/// The next state of the machine.
fn classify(before: BoundaryKind, front: &Front, constants: &BoundaryConstants) -> BoundaryKind {
    let slip = front.slip.length();
    let converging = match front.under {
        Some(0) => BoundaryKind::SubductingOrigin,
        Some(_) => BoundaryKind::SubductingDestination,
        None => BoundaryKind::Collision,
    };
    // Leaving a state takes less than entering it took.
    let threshold = |kept: bool| {
        let half = 0.5 * constants.hysteresis;
        (constants.normal_share + if kept { -half } else { half }) * slip
    };
    let was_closing = before.is_subducting() || before == BoundaryKind::Collision;
    if slip < 1e-6 {
        BoundaryKind::Transform
    } else if front.opening > threshold(before == BoundaryKind::Ridge) {
        BoundaryKind::Ridge
    } else if -front.opening > threshold(was_closing) {
        converging
    } else {
        BoundaryKind::Transform
    }
}

/// The cross edges over a front and over the other edges of its triangles: one that leaves its plate takes the
/// kind of the front.
fn cross_edges(
    mesh: &SphereMesh<EdgeState>,
    plate: &[PlateId],
    edge: u32,
    kind: BoundaryKind,
) -> [(u32, BoundaryKind); 5] {
    let [h, twin] = [2 * edge, 2 * edge + 1];
    let sides = [
        mesh.next(h),
        mesh.prev(h),
        mesh.next(twin),
        mesh.prev(twin),
        h,
    ];
    sides.map(|side| {
        let across = [mesh.apex(side), mesh.apex(mesh.twin(side))];
        let joined = plate[across[0] as usize] == plate[across[1] as usize];
        let kind = if joined { BoundaryKind::Joined } else { kind };
        (side / 2, kind)
    })
}
