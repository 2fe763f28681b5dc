//! Where crushed continental crust goes: it thickens what stays on both sides, and what fits nowhere is
//! pushed onto sea floor.

use super::super::{
    ledger::Ledger, reach::Marks, recipe::Recipe, sub_plate::*, topology::EdgeState,
};
use crate::mesh::SphereMesh;
use std::collections::VecDeque;

/// A collision spreads at least over this many spacings.
const SPREAD_SPACINGS: f64 = 1.8;
/// Crushed crust that a cell takes, as a share of the mean, beyond which it is part of the mountain belt.
const TAKES_MUCH: f64 = 0.2;
/// By how much each circle that crushed crust spreads over is wider than the one before.
const WIDER: f64 = 1.6;

/// Columns that a collision reads and writes.
pub(in crate::simulation) struct Ground<'a> {
    pub plate: &'a mut [PlateId],
    pub crust: &'a mut [Crust],
    pub thickness: &'a mut [Thickness],
    pub area: &'a mut [MaterialArea],
    pub created: &'a mut [Created],
    pub orogeny: &'a mut [Orogeny],
    pub began: &'a mut [OrogenyBegan],
    pub fold: &'a mut [FoldDirection],
    pub marks: &'a mut Marks,
}

/// Radius in km of the circle that crushed crust spreads over first.
fn first_circle(recipe: &Recipe) -> f64 {
    let constants = &recipe.constants.collisions;
    constants.spread.max(SPREAD_SPACINGS * recipe.spacing_km())
}

/// About how many sub-plates lie in such a circle.
pub(in crate::simulation) fn first_circle_cells(recipe: &Recipe) -> f64 {
    cells_within(recipe, first_circle(recipe))
}

/// About how many lie in one of this radius in km.
fn cells_within(recipe: &Recipe, reach: f64) -> f64 {
    let reach = reach / recipe.spacing_km();
    (core::f64::consts::PI * reach * reach).min(f64::from(recipe.sub_plates))
}

/// Sub-plates around a vertex, each with its share of what it would take in the middle.
pub(in crate::simulation) type Circle = Vec<(u32, f64)>;

/// The first circle around a vertex, itself included.
pub(in crate::simulation) fn circle_around(
    recipe: &Recipe,
    mesh: &SphereMesh<EdgeState>,
    marks: &mut Marks,
    from: u32,
) -> Circle {
    faded(recipe, mesh, marks, from, first_circle(recipe))
}

/// The circle of a radius in km.
fn faded(
    recipe: &Recipe,
    mesh: &SphereMesh<EdgeState>,
    marks: &mut Marks,
    from: u32,
    reach: f64,
) -> Circle {
    let origin = mesh.site(from);
    let fade = |v: u32| {
        let near = origin.distance(mesh.site(v)) * recipe.radius_km / reach;
        let fade = 1.0 - near * near;
        (v, fade * fade)
    };
    let mut circle = Vec::with_capacity(cells_within(recipe, reach) as usize);
    circle.extend(disc(mesh, marks, from, reach / recipe.radius_km).map(fade));
    circle
}

/// Hands a volume of continental crust to the continent around a vertex, more where there is room, first
/// within its [`circle`](circle_around), then in wider ones; what fits nowhere is pushed onto the nearest sea
/// floor. Returns the cells that took most.
pub(in crate::simulation) fn spread_volume(
    recipe: &Recipe,
    mesh: &SphereMesh<EdgeState>,
    ground: &mut Ground,
    ledger: &mut Ledger,
    from: u32,
    mut circle: Circle,
    volume: f64,
) -> Vec<usize> {
    let constants = &recipe.constants.collisions;
    let mut left = volume;
    let mut raised = Vec::new();
    // Rock per area, in km, were it spread evenly over the first circle that takes any.
    let mut mean = None;
    let mut reach = first_circle(recipe);
    for round in 0..3 {
        let mut takers: Vec<(usize, f64, f64)> = Vec::new();
        let mut capacity = 0.0;
        if round > 0 {
            reach *= WIDER;
            circle = faded(recipe, mesh, ground.marks, from, reach);
        }
        for (v, fade) in circle.drain(..) {
            let v = v as usize;
            if !ground.crust[v].is_continental() {
                continue;
            }
            let room = constants.thickest - ground.thickness[v].0;
            if room <= 0.0 {
                continue;
            }
            let weight = fade * room.min(constants.room) * ground.area[v].0;
            takers.push((v, weight, room * ground.area[v].0));
            capacity += room * ground.area[v].0;
        }
        if takers.is_empty() {
            continue;
        }
        let whole: f64 = takers.iter().map(|taker| taker.1).sum();
        let ground_of = |taker: &(usize, f64, f64)| ground.area[taker.0].0;
        let mean = *mean.get_or_insert_with(|| volume / takers.iter().map(ground_of).sum::<f64>());
        // A crowded place passes half of its load on to a wider circle.
        let load = left.min(0.5 * capacity);
        if whole > 0.0 && load > 0.0 {
            let mut given = 0.0;
            for &(v, weight, room) in &takers {
                let part = (load * weight / whole).min(room);
                ground.thickness[v].0 += part / ground.area[v].0;
                given += part;
                if part > TAKES_MUCH * mean * ground.area[v].0 {
                    raised.push(v);
                }
            }
            left -= given;
        }
        if left <= 1e-9 * volume {
            break;
        }
    }
    if left > 0.0 {
        obduct(recipe, mesh, ground, ledger, from, left);
    }
    raised.sort_unstable();
    raised.dedup();
    raised
}

/// Pushes a volume onto the nearest sea floor, which becomes continent.
fn obduct(
    recipe: &Recipe,
    mesh: &SphereMesh<EdgeState>,
    ground: &mut Ground,
    ledger: &mut Ledger,
    from: u32,
    mut volume: f64,
) {
    let target = recipe.constants.collisions.obduction_thickness;
    let mut last = None;
    for v in disc(mesh, ground.marks, from, core::f64::consts::PI) {
        if v == from {
            continue;
        }
        let v = v as usize;
        if ground.crust[v].is_continental() {
            last = last.or(Some(v));
            continue;
        }
        let fits = (target - ground.thickness[v].0).max(1.0) * ground.area[v].0;
        if volume < 0.25 * fits && last.is_some() {
            break;
        }
        // The sea floor beneath becomes part of the continent.
        ledger.buried_floor_km3 += ground.thickness[v].0 * ground.area[v].0;
        let part = volume.min(fits);
        ground.crust[v] = Crust::Continental;
        ground.thickness[v].0 += part / ground.area[v].0;
        volume -= part;
        last = Some(v);
        if volume <= 0.0 {
            return;
        }
    }
    if let Some(v) = last {
        ground.thickness[v].0 += volume / ground.area[v].0;
    }
}

/// Vertices within a chord of a vertex, itself included, ring by ring over the mesh.
fn disc<'a>(
    mesh: &'a SphereMesh<EdgeState>,
    marks: &'a mut Marks,
    from: u32,
    chord: f64,
) -> impl Iterator<Item = u32> + 'a {
    let origin = mesh.site(from);
    marks.wipe(mesh.vertex_count());
    marks.mark(from);
    let mut queue = VecDeque::from([from]);
    core::iter::from_fn(move || {
        let v = queue.pop_front()?;
        for w in mesh.neighbours(v) {
            if mesh.site(w).distance_squared(origin) < chord * chord && marks.mark(w) {
                queue.push_back(w);
            }
        }
        Some(v)
    })
}
