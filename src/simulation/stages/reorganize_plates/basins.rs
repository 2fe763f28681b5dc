//! Enclosed seas: sea floor that no ridge feeds and no trench eats fills up from its rim.

use super::super::super::{
    clock::Clock,
    columns::Columns,
    error::TectonicError,
    ledger::Ledger,
    reach::reach,
    recipe::Recipe,
    sub_plate::*,
    topology::{EdgeState, Topology},
};
use crate::mesh::SphereMesh;
use bevy::prelude::*;

/// Speed of each shore of an enclosed sea, in km/My: a basin 1,000 km across is full within 100 My. No
/// source gives one; this is what a mesh of 10,000 sub-plates was calibrated with.
const FILL_SPEED: f64 = 5.0;

/// Half the width of a strait that parts two seas, in km, from the middle of the last continental cell. A mesh of
/// 10,000 sub-plates, with which the speed above was calibrated, has no narrower ones; finer meshes have many, and
/// their enclosed seas would stay for ever.
const HALF_STRAIT: f64 = 125.0;

/// How far a narrow bay still belongs to the open water before it, in km.
const BAY: f64 = 250.0;
/// A sea with younger floor than this grows, in My: a ridge feeds it, or did so until now.
const YOUNG: f64 = 20.0;

/// Thickens the rim of small enclosed seas until it becomes continental crust.
pub(in crate::simulation) fn fill_basins(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    topology: Res<Topology>,
    mut ledger: ResMut<Ledger>,
    mut sub_plates: Query<
        (&mut Crust, &mut Thickness, &MaterialArea, &mut Created),
        With<SubPlate>,
    >,
) -> Result<(), TectonicError> {
    let Some(time) = clock.reorganisation.due() else {
        return Ok(());
    };
    // What lies at the rim grows from floor to continent while the shore crosses one cell.
    let full = recipe.constants.uplift.arc_accretion;
    let missing = (full - recipe.constants.ridges.oceanic_thickness).max(0.0);
    let rate = missing * FILL_SPEED / recipe.spacing_km();
    let mesh = &topology.0;
    let (mut crust, mut thickness, area, mut created) = sub_plates.columns(mesh.vertex_count())?;
    let crust = crust.bypass_change_detection();
    let thickness = thickness.bypass_change_detection();
    let created = created.bypass_change_detection();

    for members in seas(&recipe, mesh, crust) {
        let size: f64 = members.iter().map(|&v| area[v as usize].0).sum();
        if size >= recipe.constants.plates.basin {
            continue;
        }
        let youngest = members.iter().map(|&v| created[v as usize].0);
        let youngest = f64::from(youngest.fold(f32::MIN, f32::max));
        if clock.time_my - youngest < YOUNG {
            continue;
        }
        let rim: Vec<u32> = members
            .into_iter()
            .filter(|&v| {
                mesh.neighbours(v)
                    .any(|w| crust[w as usize].is_continental())
            })
            .collect();
        for v in rim.into_iter().map(|v| v as usize) {
            thickness[v].0 += rate * time;
            if thickness[v].0 >= full {
                crust[v] = Crust::Continental;
                created[v].0 = clock.time_my as f32;
                ledger.filled_seas_km3 += thickness[v].0 * area[v].0;
            }
        }
    }
    Ok(())
}

/// Sea floor by seas. What only a strait joins is two of them: coarse meshes have no straits.
fn seas(recipe: &Recipe, mesh: &SphereMesh<EdgeState>, crust: &[Crust]) -> Vec<Vec<u32>> {
    let land = |v: u32| crust[v as usize].is_continental();
    let all = || 0..crust.len() as u32;
    let shores: Vec<(u32, f64)> = all()
        .filter(|&v| land(v) && mesh.neighbours(v).any(|w| !land(w)))
        .map(|v| (v, 0.0))
        .collect();
    let mut open: Vec<bool> = all().map(|v| !land(v)).collect();
    for (v, ..) in reach(mesh, recipe.radius_km, &shores, HALF_STRAIT, |v| !land(v)).found {
        open[v as usize] = false;
    }
    let mut seas: Vec<Vec<u32>> = Vec::new();
    let mut is_seen: Vec<bool> = all().map(land).collect();
    // Open water first; then, from its shores, bays and straits; last what is narrow everywhere.
    for first in all().filter(|&v| open[v as usize]) {
        seas.extend(connected(mesh, first, &mut is_seen, |v| open[v as usize]));
    }
    let mut sources: Vec<(u32, f64)> = Vec::new();
    let mut sea_of: Vec<usize> = Vec::new();
    for (sea, members) in seas.iter().enumerate() {
        let shores = members.iter().copied();
        for v in shores.filter(|&v| mesh.neighbours(v).any(|w| !is_seen[w as usize])) {
            sources.push((v, 0.0));
            sea_of.push(sea);
        }
    }
    let narrow = |v: u32| !land(v) && !open[v as usize];
    let reached = reach(mesh, recipe.radius_km, &sources, BAY, narrow);
    for (v, _, source) in reached.found {
        if !core::mem::replace(&mut is_seen[v as usize], true) {
            seas[sea_of[source as usize]].push(v);
        }
    }
    for first in all() {
        seas.extend(connected(mesh, first, &mut is_seen, |_| true));
    }
    seas
}

/// All that hangs together with a vertex and was not seen before, if that was not either.
fn connected(
    mesh: &SphereMesh<EdgeState>,
    first: u32,
    is_seen: &mut [bool],
    belongs: impl Fn(u32) -> bool,
) -> Option<Vec<u32>> {
    if core::mem::replace(&mut is_seen[first as usize], true) {
        return None;
    }
    let mut members = vec![first];
    let mut next = 0;
    while let Some(&v) = members.get(next) {
        next += 1;
        for w in mesh.neighbours(v) {
            if belongs(w) && !core::mem::replace(&mut is_seen[w as usize], true) {
                members.push(w);
            }
        }
    }
    Some(members)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::fixtures::random_mesh;

    /// Two caps of sea in a continent round the poles, joined by a channel, beside a bay of one of them.
    #[test]
    fn a_strait_parts_two_seas_and_a_bay_does_not() {
        let recipe = Recipe::earth_like(1).with_sub_plates(80_000);
        let mesh = random_mesh::<EdgeState>(80_000);
        let grown = |width_km: f64| {
            let half = 0.5 * width_km / recipe.radius_km;
            let crust: Vec<Crust> = mesh
                .sites()
                .iter()
                .map(|site| {
                    let is_channel = site.x > 0.0 && site.y.abs() < half;
                    // A bay of the northern sea, as narrow as a strait and 240 km long.
                    let is_bay =
                        site.x < 0.0 && site.y.abs() < 110.0 / recipe.radius_km && site.z > 0.57;
                    if site.z.abs() > 0.6 || is_channel || is_bay {
                        Crust::Oceanic
                    } else {
                        Crust::Continental
                    }
                })
                .collect();
            let seas = seas(&recipe, &mesh, &crust);
            let mut all: Vec<u32> = seas.iter().flatten().copied().collect();
            all.sort_unstable();
            let floor = (0..80_000).filter(|&v| !crust[v as usize].is_continental());
            assert!(all.into_iter().eq(floor), "every cell once");
            let mut sizes: Vec<usize> = seas.iter().map(Vec::len).collect();
            sizes.sort_unstable();
            sizes
        };
        let is_large = |size: &&usize| **size > 12_000;
        let parted = grown(200.0);
        assert_eq!(parted.iter().filter(is_large).count(), 2, "{parted:?}");
        assert_eq!(grown(600.0).len(), 1, "the bay belongs to its sea");
    }
}
