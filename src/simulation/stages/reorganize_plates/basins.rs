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
    workers::Workers,
};
use crate::mesh::{Components, NONE, SphereMesh};
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
    workers: Res<Workers>,
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

    let seas = seas(&recipe, &workers, mesh, crust);
    let mut size = vec![0.0; seas.count];
    let mut youngest = vec![f32::MIN; seas.count];
    for v in seas.floor() {
        let sea = seas.of[v] as usize;
        size[sea] += area[v].0;
        youngest[sea] = youngest[sea].max(created[v].0);
    }
    let fills = |sea: usize| {
        size[sea] < recipe.constants.plates.basin
            && clock.time_my - f64::from(youngest[sea]) >= YOUNG
    };
    let is_rim = |v: usize| {
        let mut around = mesh.neighbours(v as u32);
        around.any(|w| seas.of[w as usize] == NONE)
    };
    for v in seas.floor() {
        if !fills(seas.of[v] as usize) || !is_rim(v) {
            continue;
        }
        thickness[v].0 += rate * time;
        if thickness[v].0 >= full {
            crust[v] = Crust::Continental;
            created[v].0 = clock.time_my as f32;
            ledger.filled_seas_km3 += thickness[v].0 * area[v].0;
        }
    }
    Ok(())
}

/// Sea floor by seas.
struct Seas {
    /// Sea of each sub-plate, [`NONE`] on land.
    of: Vec<u32>,
    count: usize,
}

impl Seas {
    fn floor(&self) -> impl Iterator<Item = usize> {
        (0..self.of.len()).filter(|&v| self.of[v] != NONE)
    }
}

/// Seas by what joins them. What only a strait joins is two of them: coarse meshes have no straits.
fn seas(recipe: &Recipe, workers: &Workers, mesh: &SphereMesh<EdgeState>, crust: &[Crust]) -> Seas {
    let land: Vec<bool> = crust.iter().map(|crust| crust.is_continental()).collect();
    let shores = rims(mesh, |v| land[v as usize], |v| !land[v as usize]);
    let mut open: Vec<bool> = land.iter().map(|land| !land).collect();
    let is_water = |v: u32| !land[v as usize];
    for (v, ..) in reach(
        workers,
        mesh,
        recipe.radius_km,
        &shores,
        HALF_STRAIT,
        is_water,
    )
    .found
    {
        open[v as usize] = false;
    }
    // Open water first; then, from its shores, bays and straits; last what is narrow everywhere.
    let mut seas = Seas {
        of: vec![NONE; land.len()],
        count: 0,
    };
    seas.add(mesh, |v| open[v as usize]);
    let narrow = |v: u32| !land[v as usize] && !open[v as usize];
    let shores = rims(mesh, |v| open[v as usize], narrow);
    for (v, _, source) in reach(workers, mesh, recipe.radius_km, &shores, BAY, narrow).found {
        seas.of[v as usize] = seas.of[shores[source as usize].0 as usize];
    }
    let rest: Vec<bool> = (land.iter().zip(&seas.of))
        .map(|(land, &sea)| !land && sea == NONE)
        .collect();
    seas.add(mesh, |v| rest[v as usize]);
    seas
}

impl Seas {
    /// Makes each connected part of what `belongs` a sea.
    fn add(&mut self, mesh: &SphereMesh<EdgeState>, belongs: impl Fn(u32) -> bool) {
        let Components { of, first } = mesh.components(|a, b| belongs(a) && belongs(b));
        let mut numbers = vec![NONE; first.len()];
        for (number, _) in numbers.iter_mut().zip(&first).filter(|(_, v)| belongs(**v)) {
            *number = self.count as u32;
            self.count += 1;
        }
        for (sea, part) in self.of.iter_mut().zip(of) {
            if numbers[part as usize] != NONE {
                *sea = numbers[part as usize];
            }
        }
    }
}

/// Sources at what is `inside` with something `outside` beside it.
fn rims(
    mesh: &SphereMesh<EdgeState>,
    inside: impl Fn(u32) -> bool,
    outside: impl Fn(u32) -> bool,
) -> Vec<(u32, f64)> {
    let mut is_rim = vec![false; mesh.vertex_count()];
    for (a, b) in mesh.edges().map(|e| mesh.endpoints(e)) {
        is_rim[a as usize] |= inside(a) && outside(b);
        is_rim[b as usize] |= inside(b) && outside(a);
    }
    let rims = (0..).zip(is_rim).filter(|(_, is_rim)| *is_rim);
    rims.map(|(v, _)| (v, 0.0)).collect()
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
            let seas = seas(&recipe, &Workers::default(), &mesh, &crust);
            let floor = (0..80_000).filter(|&v| !crust[v].is_continental());
            assert!(seas.floor().eq(floor), "every cell once");
            let mut sizes = vec![0; seas.count];
            for v in seas.floor() {
                sizes[seas.of[v] as usize] += 1_usize;
            }
            sizes.sort_unstable();
            sizes
        };
        let is_large = |size: &&usize| **size > 12_000;
        let parted = grown(200.0);
        assert_eq!(parted.iter().filter(is_large).count(), 2, "{parted:?}");
        assert_eq!(grown(600.0).len(), 1, "the bay belongs to its sea");
    }
}
