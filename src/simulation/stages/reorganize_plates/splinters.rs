//! Every plate stays in one piece: what is cut off joins its neighbour, or becomes a plate.

use super::{
    super::super::{
        boundaries::{Contact, Contacts},
        clock::Clock,
        columns::Columns,
        error::TectonicError,
        plate::{NextPlateId, Plate, PlateArea, PlateBorn, PlateTable, Rotation},
        reach::Marks,
        recipe::Recipe,
        sub_plate::{MaterialArea, PlateId, SubPlate},
        topology::{EdgeState, Topology},
    },
    Splits, plate_areas,
};
use crate::mesh::{Components, EdgePayload, SphereMesh};
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
    let Components { of, first } = mesh.components(|a, b| plate[a as usize] == plate[b as usize]);
    let pieces = first.into_iter().map(|v| (plate[v as usize], v)).collect();
    Pieces { of, pieces }
}

/// Absorbs splinters, drops plates that have no ground left or too little, and brings areas up to
/// date. It looks only where something was cut, and everywhere where that is not known.
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
    let mut cuts = core::mem::take(&mut splits.cuts);
    if !splits.suspected && !due && cuts.is_empty() {
        return Ok(());
    }
    let mesh = &topology.0;
    let (mut plate, area) = sub_plates.columns(mesh.vertex_count())?;
    let plate = plate.bypass_change_detection();
    let table = PlateTable::gather(plates.p0().iter());
    let sphere = 4.0 * core::f64::consts::PI * recipe.radius_km * recipe.radius_km;
    let constants = &recipe.constants.plates;
    let mut estate = Estate {
        mesh,
        area,
        table: &table,
        now_my: clock.time_my,
        // A plate too small to last would be gone again before its entity is there.
        orphan: constants.orphan.max(constants.smallest) * sphere,
        commands: &mut commands,
        contacts: &mut contacts,
        next: &mut next,
    };
    // What pieces that only change hands do to the areas of plates.
    let mut shifts: Vec<(PlateId, f64)> = Vec::new();
    let mut founded = false;
    let smallest = if due {
        constants.smallest * sphere
    } else {
        0.0
    };
    let mut settled = true;
    if splits.suspected {
        settled = estate.settle_all(plate, smallest);
    } else {
        let mut marks = [Marks::default(), Marks::default()];
        for i in 0..cuts.len() {
            let Some((side, piece)) = severed(mesh, plate, cuts[i], &mut marks) else {
                continue;
            };
            let from = plate[piece[0] as usize];
            if estate.found(plate, &piece) {
                founded = true;
            } else if let Some(heir) = estate.bequeath(plate, &piece) {
                let size = estate.size(&piece);
                shifts.extend([(from, -size), (heir, size)]);
                splits.moved.extend(&piece);
            }
            // What was cut from the piece elsewhere may be cut from the rest of the plate, too.
            let rest = cuts[i][1 - side];
            let gone = |v: &&mut u32| marks[side].is_marked(**v);
            for [a, b] in &mut cuts[i + 1..] {
                [a, b].into_iter().filter(gone).for_each(|v| *v = rest);
            }
        }
        let is_small = |size: f64| size > 0.0 && size < smallest;
        if due && plate_areas(&table, plate, area).into_iter().any(is_small) {
            settled = estate.settle_all(plate, smallest);
        }
    }
    let regrouped = due || founded || splits.suspected;
    splits.suspected = !settled;
    for (id, size) in shifts {
        let mut areas = plates.p1();
        let row = table.rows().iter().find(|row| row.id == id);
        if let Some(mut area) = row.and_then(|row| areas.get_mut(row.entity).ok()) {
            area.0 += size;
        }
    }
    if !regrouped {
        return Ok(());
    }
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

/// The ground of a splinter, and who gets it.
struct Estate<'a, 'w, 's> {
    mesh: &'a SphereMesh<EdgeState>,
    area: &'a [MaterialArea],
    table: &'a PlateTable,
    now_my: f64,
    /// A splinter larger than this becomes a plate, in km².
    orphan: f64,
    commands: &'a mut Commands<'w, 's>,
    contacts: &'a mut Contacts,
    next: &'a mut NextPlateId,
}

impl Estate<'_, '_, '_> {
    /// Looks at all pieces of all plates; a plate smaller than `smallest` goes as a whole. Whether nothing is left
    /// to settle.
    fn settle_all(&mut self, plate: &mut [PlateId], smallest: f64) -> bool {
        for round in 0..ROUNDS {
            let Pieces { of, pieces } = pieces(self.mesh, plate);
            let mut size = vec![0.0; pieces.len()];
            for (&piece, area) in of.iter().zip(self.area) {
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
            let leaves = |piece: usize| {
                let is_main = main[&pieces[piece].0] == piece as u32;
                !is_main || (size[piece] < smallest && main.len() > 2)
            };
            let mut members: Vec<Vec<u32>> = vec![Vec::new(); pieces.len()];
            let leaving: Vec<usize> = (0..pieces.len()).filter(|&piece| leaves(piece)).collect();
            if !leaving.is_empty() {
                for (v, &piece) in of.iter().enumerate() {
                    if leaves(piece as usize) {
                        members[piece as usize].push(v as u32);
                    }
                }
            }
            let mut changed = false;
            for piece in leaving {
                let id = pieces[piece].0;
                let is_main = main[&id] == piece as u32;
                if !is_main && round == 0 && self.found(plate, &members[piece]) {
                    changed = true;
                } else if let Some(heir) = self.bequeath(plate, &members[piece]) {
                    if is_main {
                        self.contacts.inherit(id, heir);
                    }
                    changed = true;
                }
            }
            if !changed {
                return true;
            }
        }
        false
    }

    /// Area of a piece in km².
    fn size(&self, piece: &[u32]) -> f64 {
        piece.iter().map(|&v| self.area[v as usize].0).sum()
    }

    /// Makes a large piece a plate of its own; whether it is one now.
    fn found(&mut self, plate: &mut [PlateId], piece: &[u32]) -> bool {
        if self.size(piece) <= self.orphan {
            return false;
        }
        let Some(new) = self.next.take() else {
            return false;
        };
        let id = plate[piece[0] as usize];
        for &v in piece {
            plate[v as usize] = new;
        }
        let rotation = self.table.rotation(id);
        self.commands.spawn((
            Plate { id: new },
            Rotation(rotation),
            PlateBorn(self.now_my),
        ));
        let contact = Contact {
            last_my: self.now_my,
            ..default()
        };
        self.contacts.0.insert(Contacts::key(id, new), contact);
        true
    }

    /// Gives a piece to the plate that it has most contact with, counted in edges.
    fn bequeath(&mut self, plate: &mut [PlateId], piece: &[u32]) -> Option<PlateId> {
        let id = plate[piece[0] as usize];
        let mut touches: BTreeMap<PlateId, u32> = BTreeMap::new();
        for w in piece.iter().flat_map(|&v| self.mesh.neighbours(v)) {
            if plate[w as usize] != id {
                *touches.entry(plate[w as usize]).or_default() += 1;
            }
        }
        let most = |&(neighbour, count): &(PlateId, u32)| (count, core::cmp::Reverse(neighbour));
        let (heir, _) = touches.into_iter().max_by_key(most)?;
        for &v in piece {
            plate[v as usize] = heir;
        }
        Some(heir)
    }
}

/// The smaller of the two pieces that hold two sub-plates of one plate, and which of the two it holds, if they
/// no longer hang together. Both grow side by side, so that the work is that of the smaller one. It is marked.
fn severed(
    mesh: &SphereMesh<EdgeState>,
    plate: &[PlateId],
    [a, b]: [u32; 2],
    marks: &mut [Marks; 2],
) -> Option<(usize, Vec<u32>)> {
    let id = plate[a as usize];
    if a == b || plate[b as usize] != id {
        return None;
    }
    let mut pieces = [vec![a], vec![b]];
    for (marks, v) in marks.iter_mut().zip([a, b]) {
        marks.wipe(plate.len());
        marks.mark(v);
    }
    for next in 0.. {
        for side in 0..2 {
            let Some(&v) = pieces[side].get(next) else {
                return Some((side, core::mem::take(&mut pieces[side])));
            };
            for w in mesh.neighbours(v).filter(|&w| plate[w as usize] == id) {
                if marks[1 - side].is_marked(w) {
                    return None;
                }
                if marks[side].mark(w) {
                    pieces[side].push(w);
                }
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Flip;
    use crate::simulation::{
        fixtures::random_mesh,
        stages::reorganize_plates::{Carried, cut_by_flips, hand_on},
    };

    #[test]
    fn a_cut_finds_the_smaller_piece_or_that_there_is_none() {
        let mesh = random_mesh::<EdgeState>(2000);
        // A plate on either side of a belt: a small cap and a large one.
        let plate: Vec<PlateId> = mesh
            .sites()
            .iter()
            .map(|site| PlateId(if (0.5..0.7).contains(&site.z) { 2 } else { 1 }))
            .collect();
        let at = |inside: &dyn Fn(f64) -> bool| -> Vec<u32> {
            (0..2000_u32).filter(|&v| inside(mesh.site(v).z)).collect()
        };
        let cap = at(&|z| z >= 0.7);
        let rest = at(&|z| z < 0.5);
        let mut marks = [Marks::default(), Marks::default()];
        let (side, mut piece) = severed(&mesh, &plate, [rest[0], cap[0]], &mut marks).unwrap();
        piece.sort_unstable();
        assert_eq!((side, piece), (1, cap.clone()));
        assert!(cap.iter().all(|&v| marks[1].is_marked(v)));
        // Far apart, but of one piece; and the same place twice.
        let far = [rest[0], rest[rest.len() - 1]];
        assert!(severed(&mesh, &plate, far, &mut marks).is_none());
        assert!(severed(&mesh, &plate, [cap[0]; 2], &mut marks).is_none());
        // Two plates were never one.
        let belt = at(&|z| (0.5..0.7).contains(&z));
        assert!(severed(&mesh, &plate, [rest[0], belt[0]], &mut marks).is_none());
    }

    #[test]
    fn cuts_of_what_is_gone_go_on_to_what_it_hung_at() {
        let mut cuts = vec![[1, 2], [3, 4], [2, 5]];
        hand_on(cuts.iter_mut(), 2, Some(9));
        assert_eq!(cuts, [[9, 1], [3, 4], [9, 5]]);
        // What hung together through it alone is one another's concern now.
        let mut cuts = vec![[1, 2], [2, 5], [6, 2]];
        hand_on(cuts.iter_mut(), 2, None);
        assert_eq!(cuts, [[1, 1], [1, 5], [5, 6]]);
    }

    #[test]
    fn a_flip_goes_on_through_its_new_ends_and_a_reinsertion_does_not() {
        let (rows, newborn) = ([PlateId(1); 4], [PlateId(1), PlateId(2)]);
        let plates = Carried {
            rows: &rows,
            newborn: &newborn,
        };
        let flip = |before, after, turned| {
            let flips = [Flip {
                edge: 0,
                before,
                after,
                turned,
            }];
            cut_by_flips(&flips, plates).collect::<Vec<_>>()
        };
        assert!(flip([0, 1], [2, 5], true).is_empty());
        assert_eq!(flip([0, 1], [0, 2], false), [[0, 1]]);
        // What was born in this stage counts by its plate.
        assert_eq!(flip([0, 4], [5, 5], true), [[0, 4]]);
        assert!(flip([0, 5], [1, 2], true).is_empty());
    }
}
