//! Ragged fronts: a sub-plate that juts into another plate changes side.

use super::{
    super::{
        super::{
            clock::Clock,
            columns::Columns,
            error::TectonicError,
            ledger::Ledger,
            reach::Marks,
            recipe::Recipe,
            sub_plate::*,
            topology::{EdgeState, Topology},
            workers::Workers,
        },
        crushed_crust::{Ground, circle_around, spread_volume},
    },
    Carried, Splits, leave_plate,
};
use crate::mesh::SphereMesh;
use bevy::prelude::*;

/// Columns that change when a sub-plate changes side.
type FrontColumns = (
    &'static mut PlateId,
    &'static mut Crust,
    &'static mut Thickness,
    &'static mut MaterialArea,
    &'static mut Created,
    &'static mut Orogeny,
    &'static mut OrogenyBegan,
    &'static mut FoldDirection,
);

/// Gives sea floor that is mostly surrounded by another plate to that plate, and pushes lone teeth of
/// continent inland: oblique trenches would saw coasts otherwise.
pub(in crate::simulation) fn smooth_fronts(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    topology: Res<Topology>,
    workers: Res<Workers>,
    mut ledger: ResMut<Ledger>,
    mut splits: ResMut<Splits>,
    mut sub_plates: Query<FrontColumns, With<SubPlate>>,
) -> Result<(), TectonicError> {
    if clock.reorganisation.due().is_none() {
        return Ok(());
    }
    let mesh = &topology.0;
    let (
        mut plate,
        mut crust,
        mut thickness,
        mut area,
        mut created,
        mut orogeny,
        mut began,
        mut fold,
    ) = sub_plates.columns(mesh.vertex_count())?;
    let mut ground = Ground {
        plate: plate.bypass_change_detection(),
        crust: crust.bypass_change_detection(),
        thickness: thickness.bypass_change_detection(),
        area: area.bypass_change_detection(),
        created: created.bypass_change_detection(),
        orogeny: orogeny.bypass_change_detection(),
        began: began.bypass_change_detection(),
        fold: fold.bypass_change_detection(),
        marks: &mut Marks::default(),
    };
    let majority = recipe.constants.plates.majority;
    let mut cuts: Vec<[u32; 2]> = Vec::new();
    // Nearly all lie inside a plate.
    let fronts = workers.map(ground.plate.len(), |range| {
        let is_front = |v: &u32| {
            let mut around = mesh.neighbours(*v);
            around.any(|w| ground.plate[w as usize] != ground.plate[*v as usize])
        };
        let rows = range.start as u32..range.end as u32;
        rows.filter(is_front).collect::<Vec<u32>>()
    });
    for v in fronts.into_iter().flatten().map(|v| v as usize) {
        let tooth = ground.crust[v].is_continental();
        let Some(winner) = surrounded_by(mesh, &ground, v as u32, majority, tooth) else {
            continue;
        };
        if tooth {
            let volume = ground.thickness[v].0 * ground.area[v].0;
            ground.crust[v] = Crust::Oceanic;
            ground.orogeny[v] = Orogeny::None;
            ground.thickness[v].0 = recipe.constants.ridges.oceanic_thickness;
            let from = v as u32;
            let circle = circle_around(&recipe, mesh, ground.marks, from);
            spread_volume(
                &recipe,
                mesh,
                &mut ground,
                &mut ledger,
                from,
                circle,
                volume,
            );
            let (sum, n) = mesh
                .neighbours(v as u32)
                .map(|w| w as usize)
                .filter(|&w| ground.plate[w] == winner && !ground.crust[w].is_continental())
                .fold((0.0, 0.0), |(sum, n), w| {
                    (sum + ground.created[w].0, n + 1.0)
                });
            if n > 0.0 {
                ground.created[v].0 = sum / n;
            }
            // Unless its own rock came back over it for want of room elsewhere.
            if ground.crust[v].is_continental() {
                continue;
            }
        }
        let ring: Vec<u32> = mesh.neighbours(v as u32).collect();
        leave_plate(&mut cuts, &mut splits.cuts, v as u32, &ring, ground.plate);
        ground.plate[v] = winner;
    }
    splits.note_cuts(mesh, Carried::by(ground.plate), &cuts);
    Ok(())
}

/// The other plate that holds at least `majority` of a vertex's neighbours, as sea floor if asked.
fn surrounded_by(
    mesh: &SphereMesh<EdgeState>,
    ground: &Ground,
    v: u32,
    majority: f64,
    sea_floor: bool,
) -> Option<PlateId> {
    let own = ground.plate[v as usize];
    let other = mesh
        .neighbours(v)
        .map(|w| ground.plate[w as usize])
        .find(|id| *id != own)?;
    let mut best = (0_u32, other);
    let mut degree = 0_u32;
    let candidates: Vec<PlateId> = mesh
        .neighbours(v)
        .map(|w| ground.plate[w as usize])
        .collect();
    for &id in candidates.iter().filter(|id| **id != own) {
        let count = mesh
            .neighbours(v)
            .filter(|&w| {
                ground.plate[w as usize] == id
                    && !(sea_floor && ground.crust[w as usize].is_continental())
            })
            .count() as u32;
        if count > best.0 || (count == best.0 && id < best.1) {
            best = (count, id);
        }
    }
    degree += candidates.len() as u32;
    (f64::from(best.0) >= majority * f64::from(degree)).then_some(best.1)
}
