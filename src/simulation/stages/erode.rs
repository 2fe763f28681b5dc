//! Stage 9: wear, sediment, isostasy and the sea.
//!
//! Thickness and age are the state; elevation is derived from them here. Rock above the base level
//! is worn off, fills what lies below it, and a part is lost to the deep sea. Base level rises
//! inland from the crust's edge, behind the profile of a shelf or a fore-arc. Runs at the
//! pace of the geology clock.

use super::super::{
    clock::Clock,
    columns::Columns,
    constants::ErosionConstants,
    error::TectonicError,
    laws::{ErosionLaw, erosion::trench_sediment},
    ledger::{Ledger, continental_volume},
    precision::{ELEVATION_STEPS, THICKNESS_STEPS, round, round_area},
    reach::reach,
    recipe::Recipe,
    sea::Sea,
    stages::hot_spots::plume_swells,
    sub_plate::*,
    topology::{EdgeState, Topology},
    workers::Workers,
};
use super::inland::Inland;
use super::wear::{swell, wear_by_elevation, wear_by_rain};
use crate::mesh::SphereMesh;
use bevy::prelude::*;

/// Thickness of the crust that the age–depth law describes, in km.
const NORMAL_OCEANIC: f64 = 7.0;

/// Mean height of ground that volcanoes cover as a share of their summits': a cone's is a third, and they
/// cover half of it.
const VOLCANO_MEAN: f64 = 1.0 / 6.0;

/// Wears continents, lays down sediment, and derives every elevation.
pub(in crate::simulation) fn erode(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    workers: Res<Workers>,
    topology: Res<Topology>,
    mut ledger: ResMut<Ledger>,
    sea: Res<Sea>,
    mut sub_plates: Query<
        (
            &PlateId,
            &mut Crust,
            &mut Thickness,
            &MaterialArea,
            &Created,
            &mut Trench,
            &Volcanism,
        ),
        With<SubPlate>,
    >,
) -> Result<(), TectonicError> {
    let Some(time) = clock.geology.due() else {
        return Ok(());
    };
    let mesh = &topology.0;
    let (plate, mut crust, mut thickness, area, created, mut trench, volcanism) =
        sub_plates.columns(mesh.vertex_count())?;
    let crust = crust.bypass_change_detection();
    let thickness = thickness.bypass_change_detection();
    let trench = trench.bypass_change_detection();

    let growth = ledger.growth(continental_volume(crust, thickness, area));
    let lost = match recipe.laws.erosion {
        ErosionLaw::BaseLevel => {
            let age = |v: u32| clock.time_my - f64::from(created[v as usize].0);
            let inland = Inland::measure(&recipe, &workers, mesh, plate, crust, trench, age);
            let constants = &recipe.constants.erosion;
            let share = (constants.lost + constants.lost_feedback * growth).clamp(0.0, 1.0);
            wear_to_base_level(
                &recipe, &inland, crust, thickness, area, sea.level, time, share,
            )
        }
        ErosionLaw::Cortial => {
            let sediment = trench_sediment(&recipe.constants.laws, time) as f32;
            for trench in trench.iter_mut() {
                trench.0 = (trench.0 - sediment).max(0.0);
            }
            wear_by_elevation(&recipe, crust, thickness, area, sea.level, time)
        }
        ErosionLaw::Rain => wear_by_rain(&recipe, mesh, crust, thickness, area, sea.level, time),
    };
    ledger.eroded_km3 += lost;
    let mut margins = OldMargins {
        recipe: &recipe,
        mesh,
        crust,
        thickness,
        area,
        created,
        trench,
        volcanism,
    };
    margins.build_out(&workers, &mut ledger, growth, clock.time_my, time, lost);
    Ok(())
}

/// Wears what stands above its base level and fills what lies below, but for the share that is lost
/// at least; returns the volume in km³ that is lost to the deep sea.
fn wear_to_base_level(
    recipe: &Recipe,
    inland: &Inland,
    crust: &[Crust],
    thickness: &mut [Thickness],
    area: &[MaterialArea],
    sea_level: f64,
    time: f64,
    share_lost: f64,
) -> f64 {
    let constants = &recipe.constants.erosion;
    let mut pool = 0.0;
    let mut room = Vec::new();
    for v in 0..crust.len() {
        if !crust[v].is_continental() {
            continue;
        }
        let base = inland.base_level(v, constants);
        let height = continental_height(constants, thickness[v].0) - sea_level;
        let above = height - base;
        if above > 0.0 {
            let mut worn = constants.rate * 1e-3 * above * time;
            let width = inland.width[v];
            if inland.distance[v] < width {
                // Waves and short rivers plane a margin down to its shelf, from its edge inwards: narrow
                // arcs are kept low by them.
                let excess = above / constants.isostasy;
                let lasts = constants.shelf_time * 2.0 * inland.distance[v] / width;
                worn += (excess - worn).max(0.0) * (1.0 - libm::exp(-time / lasts));
            }
            // Under a deep sea the base level may lie below the foot of the crust.
            let worn = worn.min(above / constants.isostasy).min(thickness[v].0);
            thickness[v].0 -= worn;
            pool += worn * area[v].0;
            continue;
        }
        let below = base - inland.slope(v, constants) - height;
        if below > 0.0 {
            room.push((v, below / constants.isostasy * area[v].0));
        }
    }
    let lost = share_lost * pool;
    let whole: f64 = room.iter().map(|(_, room)| room).sum();
    // A basin takes at most this share of its room, so that it does not fill in one tick.
    let laid = (pool - lost).min(whole * (1.0 - libm::exp(-time / constants.basin_time)));
    if whole > 0.0 {
        for (v, room) in room {
            thickness[v].0 += laid * room / whole / area[v].0;
        }
    }
    pool - if whole > 0.0 { laid } else { 0.0 }
}

/// Age after [`margin_age`](ErosionConstants::margin_age) at which margins grow at nominal speed, in My.
const MARGIN_RIPE: f64 = 40.0;

/// Ripeness at which even floor at a trench is buried.
const STALLED: f64 = 2.5;

/// Sea floor beside continents that sediment may turn into continent.
struct OldMargins<'a> {
    recipe: &'a Recipe,
    mesh: &'a SphereMesh<EdgeState>,
    crust: &'a mut [Crust],
    thickness: &'a mut [Thickness],
    area: &'a [MaterialArea],
    created: &'a [Created],
    trench: &'a [Trench],
    volcanism: &'a [Volcanism],
}

impl OldMargins<'_> {
    /// Lays what rivers carry to the sea on the oldest floor beside the land. What has grown as thick
    /// as an arc is continent; the pile of a volcano does not count, or shores would run out along
    /// island chains.
    fn build_out(
        &mut self,
        workers: &Workers,
        ledger: &mut Ledger,
        growth: f64,
        now: f64,
        time: f64,
        mut sediment: f64,
    ) {
        let constants = &self.recipe.constants.erosion;
        // Continents that have grown drown their own margins, which then keep what rivers bring.
        let thrift = (1.0 - self.recipe.constants.uplift.arc_feedback * growth).clamp(0.0, 1.0);
        let target = self.recipe.constants.uplift.arc_accretion;
        let missing = (target - self.recipe.constants.ridges.oceanic_thickness).max(0.0);
        // Ripe floor beside land, with its speed of growth.
        let ripe_at = |v: usize| {
            let ripe = (now - f64::from(self.created[v].0) - constants.margin_age) / MARGIN_RIPE;
            // A trench swallows what rivers bring, unless it has hardly moved for an age.
            let swallowed = self.trench[v].0 > 0.0 && ripe < STALLED;
            if self.crust[v].is_continental() || ripe <= 0.0 || swallowed {
                return None;
            }
            let (mut land, mut degree) = (0.0, 0.0);
            for w in self.mesh.neighbours(v as u32) {
                degree += 1.0;
                land += f64::from(u8::from(self.crust[w as usize].is_continental()));
            }
            let speed = thrift * constants.margin_growth * ripe * ripe * 2.0 * land / degree;
            (land > 0.0).then_some((v, speed))
        };
        let found = workers.map(self.crust.len(), |rows| {
            rows.filter_map(ripe_at).collect::<Vec<(usize, f64)>>()
        });
        let mut grown = Vec::new();
        for (v, speed) in found.into_iter().flatten() {
            let rate = missing * speed / self.recipe.spacing_km();
            let layer = (rate * time).min(missing).min(sediment / self.area[v].0);
            self.thickness[v].0 += layer;
            sediment -= layer * self.area[v].0;
            if self.thickness[v].0 - f64::from(self.volcanism[v].pile_km) >= target {
                grown.push(v);
            }
        }
        for v in grown {
            self.crust[v] = Crust::Continental;
            ledger.built_margins_km3 += self.thickness[v].0 * self.area[v].0;
        }
    }
}

/// Height of continental crust in m above the reference level (Airy isostasy).
pub(in crate::simulation) fn continental_height(
    constants: &ErosionConstants,
    thickness: f64,
) -> f64 {
    constants.isostasy * (thickness - constants.reference_thickness)
}

/// Depth of normal sea floor in m (positive down) by its age in My: half-space cooling up to 20 My,
/// then the plate model GDH1 (Stein & Stein 1992).
#[must_use]
pub fn sea_floor_depth(age_my: f64) -> f64 {
    let age = age_my.max(0.0);
    if age < 20.0 {
        2600.0 + 365.0 * age.sqrt()
    } else {
        5651.0 - 2473.0 * libm::exp(-0.0278 * age)
    }
}

/// Height of sea floor in m above the reference level, by its age in My, its thickness in km, the wedge
/// of sediment at the foot of a margin and the depth of a trench, both in m.
pub(in crate::simulation) fn sea_floor_height(
    recipe: &Recipe,
    age: f64,
    thickness: f64,
    rise: f64,
    trench: f64,
) -> f64 {
    let erosion = &recipe.constants.erosion;
    let sediment = (erosion.sediment_rate * age.max(0.0)).min(erosion.sediment_thickest);
    let floor = -recipe.laws.sea_floor.depth(&recipe.constants.laws, age)
        + erosion.isostasy * (thickness - NORMAL_OCEANIC)
        + sediment
        + rise * (age / 60.0).clamp(0.0, 1.0)
        - trench;
    // Sea floor that arcs or sediment raised comes up to the sea, not above a plain.
    floor.min(continental_height(erosion, recipe.constants.uplift.arc_accretion).max(0.0))
}

/// What isostasy asks of a sub-plate.
pub(crate) struct RockColumn {
    pub crust: Crust,
    pub thickness: Thickness,
    pub created: Created,
    pub trench: Trench,
    pub volcanism: Volcanism,
}

impl RockColumn {
    /// Height of the ground between volcanoes in m above the reference level, at a time in My, where
    /// sediment at the foot of a margin is so many m thick at most.
    fn height(&self, recipe: &Recipe, now: f64, rise: f64) -> f64 {
        let (thickness, trench) = (self.thickness.0, f64::from(self.trench.0));
        if self.crust.is_continental() {
            return continental_height(&recipe.constants.erosion, thickness) - trench;
        }
        let age = now - f64::from(self.created.0);
        let floor = thickness - f64::from(self.volcanism.pile_km);
        sea_floor_height(recipe, age, floor, rise, trench)
    }

    /// Height of volcanoes above it in m.
    fn volcanoes(&self, recipe: &Recipe) -> f64 {
        if self.crust.is_continental() {
            0.0
        } else {
            recipe.constants.hot_spots.relief * f64::from(self.volcanism.pile_km)
        }
    }

    /// Elevation in m about as the ground would settle at a time in My, far from every margin, with swells as
    /// narrow as their volcanoes. Saves keep what differs from it, so it stays as it is.
    #[cfg(feature = "save")]
    pub(crate) fn elevation(&self, recipe: &Recipe, sea: &Sea, now: f64) -> f64 {
        let constants = &recipe.constants.hot_spots;
        let swell = match self.volcanism.last_my {
            Some(last) if !self.crust.is_continental() => {
                let since = (now - f64::from(last)).max(0.0);
                let whole = (0.5 * f64::from(self.volcanism.pile_km)).min(1.0);
                constants.swell * whole * libm::exp(-since / constants.swell_time)
            }
            _ => 0.0,
        };
        self.height(recipe, now, 0.0) + (self.volcanoes(recipe) + swell) - sea.level
    }
}

/// Derives every elevation from thickness, age, trenches and the sea.
pub(in crate::simulation) fn settle(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    workers: Res<Workers>,
    topology: Res<Topology>,
    mut sea: ResMut<Sea>,
    mut ledger: ResMut<Ledger>,
    mut sub_plates: Query<
        (
            &PlateId,
            &Crust,
            &mut Thickness,
            &mut MaterialArea,
            &Created,
            &Trench,
            &Volcanism,
            &mut Elevation,
        ),
        With<SubPlate>,
    >,
) -> Result<(), TectonicError> {
    if clock.geology.due().is_none() && clock.steps > 0 {
        return Ok(());
    }
    let mesh = &topology.0;
    let (plate, crust, mut thickness, mut area, created, trench, volcanism, mut elevation) =
        sub_plates.columns(mesh.vertex_count())?;
    let elevation = elevation.bypass_change_detection();
    let (thickness, area) = (
        thickness.bypass_change_detection(),
        area.bypass_change_detection(),
    );
    for v in 0..crust.len() {
        let before = thickness[v].0 * area[v].0;
        thickness[v].0 = round(thickness[v].0, THICKNESS_STEPS);
        area[v].0 = round_area(area[v].0);
        if crust[v].is_continental() {
            ledger.rounded_km3 += thickness[v].0 * area[v].0 - before;
        }
    }
    let rise = continental_rise(&recipe, &workers, mesh, plate, crust);
    let swells = plume_swells(&recipe, &workers, mesh, volcanism, clock.time_my);
    let column = |v: usize| RockColumn {
        crust: crust[v],
        thickness: thickness[v],
        created: created[v],
        trench: trench[v],
        volcanism: volcanism[v],
    };
    let height = |v: usize| column(v).height(&recipe, clock.time_my, rise[v]) + swells[v];
    let heights = workers.map(crust.len(), |rows| rows.map(height).collect::<Vec<f64>>());
    let mut heights = heights.concat();

    if recipe.laws.erosion == ErosionLaw::Cortial {
        swell(&recipe, mesh, &mut heights);
    }
    let volcanoes = |v: usize| column(v).volcanoes(&recipe);
    // The sea washes round volcanoes: what it gives way to is the mean of the ground, not its summits.
    let means: Vec<f64> = heights
        .iter()
        .enumerate()
        .map(|(v, height)| height + VOLCANO_MEAN * volcanoes(v))
        .collect();
    sea.settle_on(&workers, &means, area);
    for (v, (elevation, height)) in elevation.iter_mut().zip(heights).enumerate() {
        let above = height + volcanoes(v) - sea.level;
        elevation.0 = round(above, ELEVATION_STEPS) as f32;
    }
    Ok(())
}

/// Thickness of the wedge of sediment at the foot of passive margins, in m, full when it is old.
pub(in crate::simulation) fn continental_rise(
    recipe: &Recipe,
    workers: &Workers,
    mesh: &SphereMesh<EdgeState>,
    plate: &[PlateId],
    crust: &[Crust],
) -> Vec<f64> {
    let constants = &recipe.constants.erosion;
    let mut rise = vec![0.0; crust.len()];
    if constants.rise_width <= 0.0 {
        return rise;
    }
    let half = 0.5 * recipe.spacing_km();
    let foot = |v: u32| {
        !crust[v as usize].is_continental()
            && mesh.neighbours(v).any(|w| {
                crust[w as usize].is_continental() && plate[w as usize] == plate[v as usize]
            })
    };
    let sources = workers.map(crust.len(), |rows| {
        let feet = (rows.start as u32..rows.end as u32).filter(|&v| foot(v));
        feet.map(|v| (v, half)).collect::<Vec<(u32, f64)>>()
    });
    let sources = sources.concat();
    let found = reach(
        workers,
        mesh,
        recipe.radius_km,
        &sources,
        constants.rise_width,
        |v| !crust[v as usize].is_continental(),
    );
    for (v, distance, _) in found.found {
        let near = 1.0 - distance / constants.rise_width;
        if near > 0.0 {
            rise[v as usize] = constants.rise_thickest * near * near;
        }
    }
    rise
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn the_floor_sinks_with_age_and_flattens() {
        assert!((sea_floor_depth(0.0) - 2600.0).abs() < 1e-9);
        assert!((sea_floor_depth(4.0) - 3330.0).abs() < 1e-9);
        // The two branches meet within 10 m at 20 My.
        assert!((sea_floor_depth(19.999) - sea_floor_depth(20.0)).abs() < 30.0);
        assert!(sea_floor_depth(70.0) > 5200.0 && sea_floor_depth(200.0) < 5660.0);
    }

    #[test]
    fn the_rise_is_a_quarter_as_thick_at_half_its_width() {
        let [x, y, z] = DVec3::AXES;
        let mesh = SphereMesh::build(vec![x, y, z, -x, -y, -z]).unwrap();
        // Edges of 450 km, and cells so small that margins lie at their own feet.
        let mut recipe = Recipe::default().with_sub_plates(u32::MAX);
        recipe.radius_km = 450.0 / core::f64::consts::SQRT_2;
        recipe.constants.erosion.rise_thickest = 1600.0;
        let mut crust = [Crust::Oceanic; 6];
        crust[2] = Crust::Continental;
        // The floor at y is another plate's: no passive margin.
        let plate = [1, 2, 1, 1, 1, 1].map(PlateId);
        for (width, far) in [(900.0, 400.0), (400.0, 0.0)] {
            recipe.constants.erosion.rise_width = width;
            let rise = continental_rise(&recipe, &Workers::default(), &mesh, &plate, &crust);
            for (rise, expected) in rise.iter().zip([1600.0, far, 0.0, 1600.0, 1600.0, far]) {
                assert!((rise - expected).abs() < 0.2, "{rise} {expected}");
            }
        }
    }

    #[test]
    fn continents_float_as_airy_says() {
        // Crust of 2,788.5 kg/m³ on a mantle of 3,300.
        let airy = 1e3 * (1.0 - 2788.5 / 3300.0);
        assert!((ErosionConstants::default().isostasy - airy).abs() < 0.5);
    }
}
