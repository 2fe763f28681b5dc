//! Crust becomes of another kind.

use super::{
    super::super::{
        clock::Clock,
        columns::Columns,
        events::{EventFailure, LatLon, NewCrust},
        ledger::Ledger,
        recipe::Recipe,
        stages::hot_spots::around,
        sub_plate::*,
        topology::Topology,
    },
    Verdict,
};
use bevy::prelude::*;

/// Makes all sub-plates of a disc sea floor or continent, and books the volume.
pub(super) fn set_crust(
    In((centre, radius_km, new)): In<(LatLon, f64, NewCrust)>,
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    topology: Res<Topology>,
    mut ledger: ResMut<Ledger>,
    mut sub_plates: Query<
        (
            &mut Crust,
            &mut Thickness,
            &MaterialArea,
            &mut Created,
            &mut Orogeny,
            &mut OrogenyBegan,
            &mut FoldDirection,
            &mut RidgeDirection,
            &mut Trench,
            &mut Volcanism,
        ),
        With<SubPlate>,
    >,
) -> Verdict {
    let mesh = &topology.0;
    let disc = around(mesh, centre.direction(), radius_km / recipe.radius_km);
    let inside = |&(_, angle): &(u32, f64)| angle * recipe.radius_km <= radius_km;
    if !disc.iter().any(inside) {
        return Ok(Err(EventFailure::NothingThere { centre, radius_km }));
    }
    let (
        mut crust,
        mut thickness,
        area,
        mut created,
        mut orogeny,
        mut began,
        mut fold,
        mut ridge,
        mut trench,
        mut volcanism,
    ) = sub_plates.columns(mesh.vertex_count())?;
    let crust = crust.bypass_change_detection();
    let thickness = thickness.bypass_change_detection();
    let created = created.bypass_change_detection();
    let orogeny = orogeny.bypass_change_detection();
    let began = began.bypass_change_detection();
    let fold = fold.bypass_change_detection();
    let ridge = ridge.bypass_change_detection();
    let trench = trench.bypass_change_detection();
    let volcanism = volcanism.bypass_change_detection();
    let continental = |crust: Crust, thickness: f64, area: f64| {
        if crust.is_continental() {
            thickness * area
        } else {
            0.0
        }
    };
    for (v, _) in disc.into_iter().filter(inside) {
        let v = v as usize;
        let before = continental(crust[v], thickness[v].0, area[v].0);
        (crust[v], thickness[v].0, created[v].0) = match new {
            NewCrust::Oceanic { age_my } => (
                Crust::Oceanic,
                recipe.constants.ridges.oceanic_thickness,
                (clock.began_my - age_my) as f32,
            ),
            NewCrust::Continental { thickness_km } => {
                let old = if crust[v].is_continental() {
                    created[v].0
                } else {
                    clock.began_my as f32
                };
                (Crust::Continental, thickness_km, old)
            }
        };
        // Nothing has happened to it yet.
        orogeny[v] = Orogeny::default();
        began[v] = OrogenyBegan::default();
        fold[v] = FoldDirection::default();
        ridge[v] = RidgeDirection::default();
        trench[v] = Trench::default();
        volcanism[v] = Volcanism::default();
        ledger.prescribed_km3 += continental(crust[v], thickness[v].0, area[v].0) - before;
    }
    Ok(Ok(()))
}
