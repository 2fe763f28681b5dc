//! Every plate stays in one piece: what is cut off joins its neighbour, or becomes a plate.

use super::{
    super::super::{
        boundaries::{Contact, Contacts},
        clock::Clock,
        columns::Columns,
        error::TectonicError,
        plate::{NextPlateId, Plate, PlateArea, PlateBorn, PlateTable, Rotation},
        recipe::Recipe,
        sub_plate::{MaterialArea, PlateId, SubPlate},
        topology::Topology,
    },
    Splits, plate_areas,
};
use crate::mesh::{EdgePayload, NONE, SphereMesh};
use bevy::prelude::*;
use std::collections::BTreeMap;

/// Absorbing a piece can cut another one; more rounds than a few never happen.
const ROUNDS: usize = 16;

/// Connected pieces of equal plates.
pub(in crate::simulation) struct Pieces {
    /// Piece of each vertex.
    pub of: Vec<u32>,
    /// Plate and first vertex of each piece.
    pub pieces: Vec<(PlateId, u32)>,
}

/// Labels the connected pieces of all plates, in the order of their first vertices.
pub(in crate::simulation) fn pieces<E: EdgePayload>(
    mesh: &SphereMesh<E>,
    plate: &[PlateId],
) -> Pieces {
    let mut of = vec![NONE; plate.len()];
    let mut pieces = Vec::new();
    let mut stack = Vec::new();
    for v in 0..plate.len() as u32 {
        if of[v as usize] != NONE {
            continue;
        }
        let piece = pieces.len() as u32;
        pieces.push((plate[v as usize], v));
        of[v as usize] = piece;
        stack.push(v);
        while let Some(u) = stack.pop() {
            for w in mesh.neighbours(u) {
                if of[w as usize] == NONE && plate[w as usize] == plate[u as usize] {
                    of[w as usize] = piece;
                    stack.push(w);
                }
            }
        }
    }
    Pieces { of, pieces }
}

/// Absorbs splinters, drops plates that have no ground left or too little, and brings areas up to
/// date.
pub(in crate::simulation) fn absorb_splinters(
    mut commands: Commands,
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    topology: Res<Topology>,
    mut splits: ResMut<Splits>,
    mut contacts: ResMut<Contacts>,
    mut next: ResMut<NextPlateId>,
    mut plates: ParamSet<(
        Query<(Entity, &Plate, &Rotation, &PlateBorn)>,
        Query<&mut PlateArea>,
    )>,
    mut sub_plates: Query<(&mut PlateId, &MaterialArea), With<SubPlate>>,
) -> Result<(), TectonicError> {
    let due = clock.reorganisation.due().is_some();
    if !splits.suspected && !due {
        return Ok(());
    }
    let mesh = &topology.0;
    let (mut plate, area) = sub_plates.columns(mesh.vertex_count())?;
    let plate = plate.bypass_change_detection();
    let table = PlateTable::gather(plates.p0().iter());
    let sphere = 4.0 * core::f64::consts::PI * recipe.radius_km * recipe.radius_km;
    let constants = &recipe.constants.plates;
    // A plate too small to last would be gone again before its entity is there.
    let orphan = constants.orphan.max(constants.smallest) * sphere;

    for round in 0..ROUNDS {
        let Pieces { of, pieces } = pieces(mesh, plate);
        let mut size = vec![0.0; pieces.len()];
        for (&piece, area) in of.iter().zip(area) {
            size[piece as usize] += area.0;
        }
        // The largest piece of a plate is the plate; ties go to the first.
        let mut main: BTreeMap<PlateId, u32> = BTreeMap::new();
        for (piece, &(id, _)) in pieces.iter().enumerate() {
            let best = main.entry(id).or_insert(piece as u32);
            if size[piece] > size[*best as usize] {
                *best = piece as u32;
            }
        }
        let whole = main.len();
        let mut changed = false;
        for (piece, &(id, first)) in pieces.iter().enumerate() {
            let is_main = main[&id] == piece as u32;
            let tiny = due && is_main && size[piece] < constants.smallest * sphere && whole > 2;
            if is_main && !tiny {
                continue;
            }
            if !is_main
                && round == 0
                && size[piece] > orphan
                && let Some(new) = next.take()
            {
                claim(mesh, &of, piece as u32, first, |v| plate[v as usize] = new);
                let rotation = table.rotation(id);
                commands.spawn((
                    Plate { id: new },
                    Rotation(rotation),
                    PlateBorn(clock.time_my),
                ));
                let contact = Contact {
                    last_my: clock.time_my,
                    ..default()
                };
                contacts.0.insert(Contacts::key(id, new), contact);
                changed = true;
                continue;
            }
            // Contact with each neighbour, counted in edges.
            let mut touches: BTreeMap<PlateId, u32> = BTreeMap::new();
            claim(mesh, &of, piece as u32, first, |v| {
                for w in mesh.neighbours(v) {
                    if of[w as usize] != piece as u32 {
                        *touches.entry(plate[w as usize]).or_default() += 1;
                    }
                }
            });
            let heir = touches
                .into_iter()
                .filter(|(neighbour, _)| *neighbour != id)
                .max_by_key(|&(neighbour, count)| (count, core::cmp::Reverse(neighbour)));
            if let Some((heir, _)) = heir {
                claim(mesh, &of, piece as u32, first, |v| plate[v as usize] = heir);
                if is_main {
                    contacts.inherit(id, heir);
                }
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    splits.suspected = false;
    splits.regrouped = true;
    let areas = plate_areas(&table, plate, area);
    for (row, size) in table.rows().iter().zip(areas) {
        if size == 0.0 {
            commands.entity(row.entity).despawn();
        } else if let Ok(mut area) = plates.p1().get_mut(row.entity) {
            area.0 = size;
        }
    }
    Ok(())
}

/// Visits every vertex of a piece.
fn claim<E: EdgePayload>(
    mesh: &SphereMesh<E>,
    of: &[u32],
    piece: u32,
    first: u32,
    mut visit: impl FnMut(u32),
) {
    let mut seen = std::collections::BTreeSet::from([first]);
    let mut stack = vec![first];
    while let Some(v) = stack.pop() {
        visit(v);
        for w in mesh.neighbours(v) {
            if of[w as usize] == piece && seen.insert(w) {
                stack.push(w);
            }
        }
    }
}
