//! Stage 6: arcs, trenches and plateaus.
//!
//! Subduction feeds magma to a band inland of the trench, scrapes off the base of the fore-arc in front of
//! it, pulls the sinking plate down and draws the continental crust above it after; thick crust flows
//! outwards into plateaus. The published law raises the overriding plate by the relief of what goes under
//! instead; its uplift is booked as magma. Thickening by collision happens where crust is crushed, in
//! [`resolve_collisions`](super::resolve_collisions). Runs at the pace of the geology clock.

use super::super::{
    boundaries::Boundaries,
    clock::Clock,
    columns::Columns,
    error::TectonicError,
    laws::{UpliftLaw, uplift::uplift_rate},
    ledger::{Ledger, continental_volume},
    reach::reach,
    recipe::Recipe,
    sub_plate::*,
    topology::Topology,
    workers::Workers,
};
use bevy::prelude::*;

/// Convergence for which arc flux and trench depth are stated, in km/My.
const ARC_SPEED: f64 = 60.0;
const TRENCH_SPEED: f64 = 40.0;
/// Arcs grow at most so many times faster where continents have lost volume.
const MOST_VIGOROUS: f64 = 3.0;
/// Slower convergence raises no arc worth naming, in km/My.
const OROGENY_SPEED: f64 = 5.0;
/// A range that has not been thickened for so long is no longer held up by what pressed it, in My.
const PRESSED: f32 = 8.0;
/// Thickness of the overriding crust's tip at the trench, in km (the wedges of Chile and Japan).
const WEDGE_TIP: f64 = 12.0;
/// Flow of thick crust is stated at this spacing, in km.
const FLOW_SPACING: f64 = 226.0;

type UpliftColumns = (
    &'static PlateId,
    &'static mut Crust,
    &'static mut Thickness,
    &'static MaterialArea,
    &'static mut Created,
    &'static mut Orogeny,
    &'static mut OrogenyBegan,
    &'static mut FoldDirection,
    &'static mut Trench,
    &'static Elevation,
);

/// Thickens arcs, bends trenches and lets plateaus flow.
pub(in crate::simulation) fn uplift(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    workers: Res<Workers>,
    boundaries: Res<Boundaries>,
    topology: Res<Topology>,
    mut ledger: ResMut<Ledger>,
    mut sub_plates: Query<UpliftColumns, With<SubPlate>>,
) -> Result<(), TectonicError> {
    let Some(time) = clock.geology.due() else {
        return Ok(());
    };
    let mesh = &topology.0;
    let (
        plate,
        mut crust,
        mut thickness,
        area,
        mut created,
        mut orogeny,
        mut began,
        mut fold,
        mut trench,
        elevation,
    ) = sub_plates.columns(mesh.vertex_count())?;
    let crust = crust.bypass_change_detection();
    let thickness = thickness.bypass_change_detection();
    let created = created.bypass_change_detection();
    let orogeny = orogeny.bypass_change_detection();
    let began = began.bypass_change_detection();
    let fold = fold.bypass_change_detection();
    let trench = trench.bypass_change_detection();
    let constants = &recipe.constants.uplift;
    let now = clock.time_my as f32;

    // Trenches and the fronts that feed arcs: overriding vertex, speed, direction of convergence, and
    // the elevation in km of what goes under, as it was before the trench bent it.
    let mut arcs: Vec<(u32, f64, glam::DVec3, f64)> = Vec::new();
    let mut sinking_fronts: Vec<(u32, f64)> = Vec::new();
    for front in &boundaries.fronts {
        let (Some(under), true) = (front.under, front.opening < 0.0) else {
            continue;
        };
        let (sinking, over) = (front.vertices[under], front.vertices[1 - under]);
        sinking_fronts.push((sinking, -front.opening));
        let relief = f64::from(elevation[sinking as usize].0 + trench[sinking as usize].0);
        arcs.push((over, -front.opening, front.slip, 1e-3 * relief));
    }
    let fastest_first = |a: &(u32, f64), b: &(u32, f64)| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1));
    sinking_fronts.sort_by(fastest_first);
    sinking_fronts.dedup_by_key(|(v, _)| *v);
    let healed = libm::exp(-time / constants.trench_time) as f32;
    for trench in trench.iter_mut().filter(|trench| trench.0 > 0.0) {
        trench.0 = if trench.0 < 1.0 {
            0.0
        } else {
            trench.0 * healed
        };
    }
    arcs.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    arcs.dedup_by_key(|(v, ..)| *v);
    // The trench runs half a cell in front of either plate's front.
    let half = 0.5 * recipe.spacing_km();
    let growth = ledger.growth(continental_volume(crust, thickness, area));
    let vigour = (1.0 - constants.arc_feedback * growth).clamp(0.0, MOST_VIGOROUS);
    let law = recipe.laws.uplift;
    let published = &recipe.constants.laws;
    let arc = in_order([
        constants.arc_front,
        constants.arc_distance,
        constants.arc_reach,
    ]);
    let (crest, end) = match law {
        // Cells beyond the end may still have a part of it.
        UpliftLaw::Magma => (arc[1], arc[2] + half),
        UpliftLaw::Cortial => (published.uplift_peak, published.subduction_distance),
    };
    let before: Vec<(u32, f64)> = sinking_fronts.iter().map(|&(v, _)| (v, half)).collect();
    let behind: Vec<(u32, f64)> = arcs.iter().map(|&(v, ..)| (v, half)).collect();
    let is_land = |v: u32| crust[v as usize].is_continental();
    let search = |sources: &[(u32, f64)], limit: f64, passable: &(dyn Fn(u32) -> bool + Sync)| {
        reach(&workers, mesh, recipe.radius_km, sources, limit, passable).found
    };
    let bent = search(&before, constants.trench_width + half, &|v| !is_land(v));
    let drawn = search(&behind, constants.forearc_reach + half, &is_land);
    let raised = search(&behind, end, &|_| true);

    for (v, distance, source) in bent {
        let (front, speed) = sinking_fronts[source as usize];
        if plate[v as usize] != plate[front as usize] {
            continue;
        }
        let share = trench_profile(distance, half, constants.trench_width);
        let depth = share * constants.trench_depth * (speed / TRENCH_SPEED).min(1.0);
        trench[v as usize].0 += depth as f32 * (1.0 - healed);
    }
    for (v, distance, source) in drawn {
        let (front, speed, ..) = arcs[source as usize];
        let v = v as usize;
        // Fronts of sea floor are found, too.
        if plate[v] != plate[front as usize] || !crust[v].is_continental() {
            continue;
        }
        let share = trench_profile(distance, half, constants.forearc_reach);
        let depth = share * constants.forearc_depth * (speed / TRENCH_SPEED).min(1.0);
        trench[v].0 += depth as f32 * (1.0 - healed);
    }
    for (v, distance, source) in raised {
        let (front, speed, slip, relief) = arcs[source as usize];
        let v = v as usize;
        if plate[v] != plate[front as usize] {
            continue;
        }
        let fresh = match law {
            UpliftLaw::Magma => {
                let profile = arc_profile(distance, half, arc);
                let flux = constants.arc_flux * speed / ARC_SPEED * vigour;
                flux * profile * time
            }
            UpliftLaw::Cortial => {
                let rate = uplift_rate(published, distance, slip.length(), relief);
                1e3 * rate / recipe.constants.erosion.isostasy * vigour * time
            }
        };
        if crust[v].is_continental() {
            if law == UpliftLaw::Magma {
                let (share, ramp) = fore_arc(distance, half, constants.arc_front);
                let whole = recipe.constants.erosion.reference_thickness;
                let wedge = WEDGE_TIP + (whole - WEDGE_TIP) * ramp;
                let gnawed = constants.subduction_erosion * speed / ARC_SPEED * share * time;
                let gnawed = gnawed.min((thickness[v].0 - wedge).max(0.0));
                thickness[v].0 -= gnawed;
                ledger.scraped_km3 += gnawed * area[v].0;
            }
            let fresh = match law {
                UpliftLaw::Magma => fresh * stays(&recipe, thickness[v].0),
                UpliftLaw::Cortial => fresh,
            };
            let fresh = fresh.min((recipe.constants.collisions.thickest - thickness[v].0).max(0.0));
            thickness[v].0 += fresh;
            ledger.arc_magma_km3 += fresh * area[v].0;
            if speed > OROGENY_SPEED && distance < crest * 1.5 {
                orogeny[v] = Orogeny::Andean;
                began[v].0 = now;
                fold[v].0 = folded(fold[v].0, slip, mesh.site(v as u32), time);
            }
        } else {
            thickness[v].0 += fresh * constants.arc_oceanic;
            if thickness[v].0 >= constants.arc_accretion {
                crust[v] = Crust::Continental;
                created[v].0 = now;
                orogeny[v] = Orogeny::Andean;
                began[v].0 = now;
                ledger.island_arcs_km3 += thickness[v].0 * area[v].0;
            }
        }
    }
    let idle = |v: usize| now - began[v].0 > PRESSED;
    flow_plateaus(&recipe, &topology, time, idle, crust, area, thickness);
    Ok(())
}

/// Mean depth of a cell as a share of the axis' depth: a wedge that shallows from the axis to nothing
/// over `width`, seen by a cell from `distance − half` to `distance + half`. Its volume is the same on
/// every mesh.
fn trench_profile(distance: f64, half: f64, width: f64) -> f64 {
    let filled = |x: f64| {
        let x = (x / width.max(1e-9)).clamp(0.0, 1.0);
        width * (x - 0.5 * x * x)
    };
    over_cell(filled, distance, half)
}

/// Mean over a cell from `distance − half` to `distance + half` of what adds up to `sum` on the way there.
fn over_cell(sum: impl Fn(f64) -> f64, distance: f64, half: f64) -> f64 {
    (sum(distance + half) - sum(distance - half)) / (2.0 * half)
}

/// Share of an arc's magma that stays in crust of this thickness, in km: what crystallises first founders,
/// more of it under thin and mafic crust.
fn stays(recipe: &Recipe, thickness: f64) -> f64 {
    let constants = &recipe.constants;
    let (thin, whole) = (
        constants.uplift.arc_accretion,
        constants.erosion.reference_thickness,
    );
    let ripe = ((thickness - thin) / (whole - thin).max(1e-9)).clamp(0.0, 1.0);
    constants.uplift.arc_oceanic + (1.0 - constants.uplift.arc_oceanic) * ripe
}

/// What the fore-arc, between the trench and the arc's front, has of a cell from `distance − half` to
/// `distance + half`: its share per km, which integrates to 1 on every mesh, and the mean of a ramp that
/// rises from 0 at the trench to 1 at the front.
fn fore_arc(distance: f64, half: f64, front: f64) -> (f64, f64) {
    if front <= 0.0 {
        return (0.0, 1.0);
    }
    let inside = |x: f64| x.clamp(0.0, front);
    let risen = |x: f64| 0.5 * inside(x) * inside(x) / front + (x - front).max(0.0);
    (
        over_cell(inside, distance, half) / front,
        over_cell(risen, distance, half),
    )
}

/// Distances of an arc's front, crest and end, each at least a kilometre behind the one before.
fn in_order([front, crest, end]: [f64; 3]) -> [f64; 3] {
    let crest = crest.max(front + 1.0);
    [front, crest, end.max(crest + 1.0)]
}

/// Share of an arc's flux per km of distance from the trench that falls on a cell from `distance − half`
/// to `distance + half`: a triangle over the arc's front, crest and end that integrates to 1 on every
/// mesh. In front of the arc there is no magma.
fn arc_profile(distance: f64, half: f64, [front, crest, end]: [f64; 3]) -> f64 {
    // Share nearer than a distance.
    let nearer = |x: f64| {
        if x < crest {
            let x = (x - front).max(0.0);
            x * x / ((crest - front) * (end - front))
        } else {
            let x = (end - x).max(0.0);
            1.0 - x * x / ((end - crest) * (end - front))
        }
    };
    over_cell(nearer, distance, half)
}

/// Adds the relative motion to a fold direction (Cortial et al. 2019, `f ← f + β(sᵢ − sⱼ)δt`), kept
/// tangent and at most of unit length.
pub(in crate::simulation) fn folded(
    fold: glam::Vec3,
    slip: glam::DVec3,
    site: glam::DVec3,
    time: f64,
) -> glam::Vec3 {
    /// β: at 50 km/My a fold belt is fully aligned after 20 My. The paper gives no value.
    const BETA: f64 = 1e-3;
    // Folding has an axis, not a sense: add along whichever way the belt already leans.
    let lean = if slip.dot(fold.as_dvec3()) < 0.0 {
        -slip
    } else {
        slip
    };
    let sum = fold.as_dvec3() + lean * (BETA * time);
    (sum - site * site.dot(sum)).clamp_length_max(1.0).as_vec3()
}

/// Crust thicker than a plateau's moves to its thinner continental neighbours, volume for volume. Ranges
/// that nothing presses any more collapse under their own weight (Dewey 1988).
fn flow_plateaus(
    recipe: &Recipe,
    topology: &Topology,
    time: f64,
    idle: impl Fn(usize) -> bool,
    crust: &[Crust],
    area: &[MaterialArea],
    thickness: &mut [Thickness],
) {
    let constants = &recipe.constants.uplift;
    let scale = FLOW_SPACING / recipe.spacing_km();
    let share = |flow: f64| (flow * time * scale * scale).min(0.5);
    let pressed = (constants.plateau_thickness, share(constants.plateau_flow));
    let released = (constants.collapse_thickness, share(constants.collapse_flow));
    for v in 0..crust.len() {
        let (stable, share) = if idle(v) { released } else { pressed };
        let excess = thickness[v].0 - stable;
        if excess <= 0.0 || !crust[v].is_continental() {
            continue;
        }
        let lower: Vec<(usize, f64)> = topology
            .0
            .neighbours(v as u32)
            .map(|w| w as usize)
            .filter(|&w| crust[w].is_continental() && thickness[w].0 < thickness[v].0)
            .map(|w| (w, thickness[v].0 - thickness[w].0))
            .collect();
        // Filling it up by its drop, a cell takes this much: small ones take little.
        let room: f64 = lower.iter().map(|&(w, drop)| drop * area[w].0).sum();
        if room <= 0.0 {
            continue;
        }
        let volume = (share * excess * area[v].0).min(0.5 * room);
        thickness[v].0 -= volume / area[v].0;
        for (w, drop) in lower {
            thickness[w].0 += volume * drop / room;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::fixtures::random_mesh;
    use glam::{DVec3, Vec3};

    #[test]
    fn a_trench_is_as_large_on_every_mesh() {
        for spacing in [226.0, 113.0, 56.0] {
            let cells = (0..10).map(|i| (f64::from(i) + 0.5) * spacing);
            let volume: f64 = cells
                .map(|d| trench_profile(d, 0.5 * spacing, 150.0) * spacing)
                .sum();
            assert!((volume - 75.0).abs() < 1e-9, "{spacing} {volume}");
        }
    }

    #[test]
    fn an_arc_hands_out_all_of_its_magma_behind_its_front() {
        let arc = [100.0, 200.0, 420.0];
        for spacing in [226.0, 113.0, 56.0] {
            let cells = (0..10).map(|i| (f64::from(i) + 0.5) * spacing);
            let volume: f64 = cells
                .map(|d| arc_profile(d, 0.5 * spacing, arc) * spacing)
                .sum();
            assert!((volume - 1.0).abs() < 1e-9, "{spacing} {volume}");
        }
        assert_eq!(arc_profile(50.0, 40.0, arc), 0.0);
        assert_eq!(in_order([500.0, 200.0, 100.0]), [500.0, 501.0, 502.0]);
        // Height of the triangle: 2 / (420 − 100).
        assert!((arc_profile(200.0, 1e-3, arc) - 0.00625).abs() < 1e-6);
    }

    #[test]
    fn a_fore_arc_is_as_large_on_every_mesh() {
        for spacing in [226.0, 113.0, 56.0] {
            let cells: Vec<_> = (0..10)
                .map(|i| fore_arc((f64::from(i) + 0.5) * spacing, 0.5 * spacing, 100.0))
                .collect();
            let share: f64 = cells.iter().map(|cell| cell.0 * spacing).sum();
            // 100 km of a ramp, then 1.
            let missing: f64 = cells.iter().map(|cell| (1.0 - cell.1) * spacing).sum();
            assert!((share - 1.0).abs() < 1e-9, "{spacing} {share}");
            assert!((missing - 50.0).abs() < 1e-9, "{spacing} {missing}");
        }
    }

    #[test]
    fn folds_are_tangent_and_at_most_of_unit_length() {
        let near = |found: Vec3, expected: Vec3| {
            assert!((found - expected).length() < 1e-6, "{found}");
        };
        // 50 km/My · 20 My · 1e-3 = 1.
        let whole = folded(Vec3::ZERO, DVec3::X * 50.0, DVec3::Z, 20.0);
        near(whole, Vec3::X);
        // Four times as fast: 4, cut to 1. As long again: 2, cut to 1.
        near(
            folded(Vec3::ZERO, DVec3::X * 200.0, DVec3::Z, 20.0),
            Vec3::X,
        );
        near(folded(whole, DVec3::X * 50.0, DVec3::Z, 20.0), Vec3::X);
        // 0.5 x less its part along the site r, 0.3 r: (0.5 − 0.18, −0.24, 0).
        let site = DVec3::new(0.6, 0.8, 0.0);
        let fold = folded(Vec3::ZERO, DVec3::X * 50.0, site, 10.0);
        near(fold, Vec3::new(0.32, -0.24, 0.0));
        assert!(fold.as_dvec3().dot(site).abs() < 1e-6);
    }

    #[test]
    fn a_fold_grows_whichever_way_the_plates_move_across_it() {
        let half = folded(Vec3::ZERO, DVec3::X * 50.0, DVec3::Z, 10.0);
        assert!((half - Vec3::X * 0.5).length() < 1e-6, "{half}");
        // Back at 20 km/My for 10 My: 0.5 + 0.2, not 0.5 − 0.2.
        let grown = folded(half, DVec3::X * -20.0, DVec3::Z, 10.0);
        assert!((grown - Vec3::X * 0.7).length() < 1e-6, "{grown}");
    }

    /// One cell of 64 km among 35 km: while pressed, it flows above 55 km, later above 44 km.
    #[test]
    fn a_range_collapses_once_nothing_presses_it() {
        let mut recipe = Recipe::earth_like(1).with_sub_plates(2000);
        recipe.constants.uplift.plateau_flow = 0.02;
        recipe.constants.uplift.collapse_flow = 0.03;
        let topology = Topology(random_mesh(2000));
        let crust = vec![Crust::Continental; 2000];
        let area: Vec<_> = (0..2000_u32)
            .map(|v| MaterialArea(f64::from(100 + v % 7)))
            .collect();
        let scale = FLOW_SPACING / recipe.spacing_km();
        for (idle, share, stable) in [(false, 0.02 * 5.0, 55.0), (true, 0.03 * 5.0, 44.0)] {
            let mut thickness = vec![Thickness(35.0); 2000];
            thickness[9].0 = 64.0;
            let volume = |thickness: &[Thickness]| -> f64 {
                thickness.iter().zip(&area).map(|(t, a)| t.0 * a.0).sum()
            };
            let before = volume(&thickness);
            flow_plateaus(
                &recipe,
                &topology,
                5.0,
                |_| idle,
                &crust,
                &area,
                &mut thickness,
            );
            let expected = 64.0 - share * scale * scale * (64.0 - stable);
            assert!(
                (thickness[9].0 - expected).abs() < 1e-9,
                "{}",
                thickness[9].0
            );
            assert!((volume(&thickness) / before - 1.0).abs() < 1e-12);
            assert!(
                topology
                    .0
                    .neighbours(9)
                    .all(|w| thickness[w as usize].0 > 35.0)
            );
        }
    }
}
