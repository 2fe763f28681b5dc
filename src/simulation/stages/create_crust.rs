//! Stage 3: new crust where plates part.
//!
//! A boundary triangle whose circumcircle has grown too wide gets a sub-plate at its circumcentre,
//! where it can make no sliver. On sea floor that is new oceanic crust at a ridge; between three
//! continental sub-plates it is stretched continental crust, until that is too thin and breaks.
//!
//! Ridges are made of segments: stripes between circles about the Euler pole of the two plates, along
//! which transform faults run. Within a stripe, new crust goes to whichever plate lies on its side of
//! the stripe's mean axis, so that the axis straightens across the motion, while neighbouring axes may
//! keep the offset that the first break gave them.

use super::super::{
    boundaries::{Boundaries, Contacts, Front, Motion},
    clock::Clock,
    columns::Columns,
    error::TectonicError,
    ledger::Ledger,
    plate::{Plate, PlateBorn, PlateTable, Rotation},
    recipe::Recipe,
    stages::{
        Splits,
        reorganize_plates::{Carried, cut_by_flips},
    },
    sub_plate::*,
    topology::{EdgeState, Topology},
    workers::{FEW, Workers},
};
use crate::mesh::{EditError, SphereMesh};
use bevy::prelude::*;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// A segment is at least this many spacings long: shorter ones cannot be drawn.
const SEGMENT_SPACINGS: f64 = 2.0;
/// Fronts farther than this many segments belong to another ridge of the same plates.
const NEAR_SEGMENTS: f64 = 2.0;
/// Nearer to the axis than this many spacings, the older side takes the crust: both flanks grow evenly.
const ON_AXIS: f64 = 0.15;

/// A gap in the crust that is to be filled.
struct Gap {
    site: DVec3,
    corners: [u32; 3],
    /// Opening of the front through the triangle; not positive for a mere hole in the mesh.
    motion: Motion,
    strike: DVec3,
}

/// Largest share of three cells' rock that a fourth between them takes. Cells of a nominal area give up to a third.
const MOST_GIVEN: f64 = 0.6;

/// Fills the gaps that opened since the last step.
pub(in crate::simulation) fn create_crust(
    mut commands: Commands,
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    workers: Res<Workers>,
    boundaries: Res<Boundaries>,
    mut topology: ResMut<Topology>,
    mut ledger: ResMut<Ledger>,
    mut splits: ResMut<Splits>,
    plates: Query<(Entity, &Plate, &Rotation, &PlateBorn)>,
    mut sub_plates: Query<
        (
            &PlateId,
            &Crust,
            &Created,
            &MaterialArea,
            &Elevation,
            &mut Thickness,
        ),
        With<SubPlate>,
    >,
) -> Result<(), TectonicError> {
    let mesh = &mut topology.0;
    let (plate, crust, created, area, elevation, mut thickness) =
        sub_plates.columns(mesh.vertex_count())?;
    let thickness = thickness.bypass_change_detection();
    let plates = PlateTable::gather(plates.iter());
    let gaps = find_gaps(&workers, mesh, &recipe, &boundaries, &plates, plate, area);
    let segments = Segments::gather(&workers, &gaps, &recipe, &boundaries, &plates, plate);

    let constants = &recipe.constants.ridges;
    let spacing = recipe.spacing_km();
    let cell = recipe.cell_area_km2();
    let now = clock.time_my as f32;
    let mut cuts = Vec::new();
    let mut newborn: Vec<PlateId> = Vec::new();
    let mut born = Vec::new();
    for gap in gaps {
        // Before anything is taken or booked. Only a coincident site is refused, and the gap rule
        // keeps sites apart.
        let (vertex, flips) = match mesh.insert(gap.site, gap.corners[0]) {
            Ok(inserted) => inserted,
            Err(EditError::Repair(source)) => {
                let time_my = clock.time_my;
                return Err(TectonicError::Repair { time_my, source });
            }
            Err(_) => continue,
        };
        let corners = gap.corners.map(|v| v as usize);
        let opening = gap.motion.opening > 0.0;
        let side = segments
            .side(&gap, plate)
            .filter(|_| opening)
            .unwrap_or_else(|| older_side(corners, plate, created));
        let mut child = Child {
            plate: plate[side],
            crust: Crust::Oceanic,
            thickness: constants.oceanic_thickness,
            created: now,
            elevation: elevation[side].0,
            ridge: if opening {
                gap.site.cross(gap.strike).normalize_or_zero()
            } else {
                DVec3::ZERO
            },
        };
        // Continents are the weaker plates: where one borders on what opens, it is stretched before it lets go.
        let parting: Vec<usize> = corners
            .into_iter()
            .filter(|&v| crust[v].is_continental())
            .collect();
        let thinnest = parting
            .iter()
            .map(|&v| thickness[v].0)
            .fold(f64::MAX, f64::min);
        let volume: f64 = parting.iter().map(|&v| thickness[v].0 * area[v].0).sum();
        let stretched = if opening {
            thinnest - constants.rift_thinning * spacing / 226.0
        } else {
            thinnest
        };
        // Small neighbours give a part of what they have.
        let stretched = stretched.min(MOST_GIVEN * volume / cell);
        let is_continent = parting.len() == 3 || opening && !parting.is_empty();
        let tears = is_continent && stretched >= constants.breakup_thickness;
        if tears {
            if !parting.iter().any(|&v| plate[v] == child.plate) {
                child.plate = plate[parting[0]];
                child.elevation = elevation[parting[0]].0;
            }
            child.crust = Crust::Continental;
            child.thickness = stretched;
            child.created = parting.iter().map(|&v| created[v].0).fold(now, f32::min);
            // The new cell's rock comes out of its neighbours.
            let kept = 1.0 - stretched * cell / volume;
            for &v in &parting {
                thickness[v].0 *= kept;
            }
            ledger.area_stretched_km2 += cell;
        } else {
            if !opening {
                let of_side = corners.iter().filter(|&&v| plate[v] == child.plate);
                let (sum, n) = of_side
                    .filter(|&&v| !crust[v].is_continental())
                    .fold((0.0, 0), |(sum, n), &v| (sum + created[v].0, n + 1));
                child.created = if n > 0 { sum / n as f32 } else { now };
            }
            ledger.area_created_km2 += cell;
        }
        newborn.push(child.plate);
        let plates_now = Carried {
            rows: plate,
            newborn: &newborn,
        };
        cuts.extend(cut_by_flips(&flips, plates_now));
        let is_of_child = |w: u32| plates_now.of(w) == Some(child.plate);
        splits.suspected |= !mesh.neighbours(vertex).any(is_of_child);
        born.push((
            SubPlate,
            Position(gap.site.as_vec3()),
            Velocity((plates.rotation(child.plate).cross(gap.site) * recipe.radius_km).as_vec3()),
            child.plate,
            child.crust,
            Thickness(child.thickness),
            MaterialArea(cell),
            Created(child.created),
            Elevation(child.elevation),
            RidgeDirection(child.ridge.as_vec3()),
        ));
    }
    commands.spawn_batch(born);
    let plates_now = Carried {
        rows: plate,
        newborn: &newborn,
    };
    splits.note_cuts(mesh, plates_now, &cuts);
    Ok(())
}

/// What a new sub-plate is made of.
struct Child {
    plate: PlateId,
    crust: Crust,
    thickness: f64,
    created: f32,
    elevation: f32,
    ridge: DVec3,
}

/// Triangles across plates whose circumcircles are wide enough to take a new sub-plate.
fn find_gaps(
    workers: &Workers,
    mesh: &SphereMesh<EdgeState>,
    recipe: &Recipe,
    boundaries: &Boundaries,
    plates: &PlateTable,
    plate: &[PlateId],
    area: &[MaterialArea],
) -> Vec<Gap> {
    let constants = &recipe.constants.ridges;
    let excess = mesh.vertex_count() as f64 / f64::from(recipe.sub_plates) - 1.0;
    let base = constants.gap * (1.0 + constants.feedback * excess).clamp(0.8, 1.5);
    let wide = workers.run(boundaries.fronts.chunks(FEW), |fronts| {
        let mut wide: Vec<(f64, Gap)> = Vec::new();
        for h in fronts.iter().flat_map(|f| [2 * f.edge, 2 * f.edge + 1]) {
            let h = h.min(mesh.next(h)).min(mesh.prev(h));
            let corners = mesh.triangle_vertices(h);
            let around = corners.iter().map(|&v| area[v as usize].0).sum::<f64>();
            let (radius, spacing) = (
                mesh.circumradius(h) * recipe.radius_km,
                (around / 3.0).sqrt(),
            );
            // Hardly any is wide enough.
            if radius <= base * spacing {
                continue;
            }
            let (motion, strike) =
                opening_of(mesh, recipe.radius_km, boundaries, plates, plate, corners);
            let factor = if motion.opening <= 0.0 {
                constants.closing_factor
            } else if motion.is_near_transform(constants.transform_share) {
                constants.transform_factor
            } else {
                1.0
            };
            if radius > base * factor * spacing {
                let site = mesh.circumcentre(h);
                let apart = constants.apart * spacing / recipe.radius_km;
                let gap = Gap {
                    site,
                    corners,
                    motion,
                    strike,
                };
                wide.push((apart, gap));
            }
        }
        wide
    });
    // A triangle is met once for each of its fronts, and neighbours ask for the same place.
    let mut gaps: Vec<Gap> = Vec::new();
    for (apart, gap) in wide.into_iter().flatten() {
        let is_near = |other: &Gap| other.site.distance_squared(gap.site) < apart * apart;
        if !gaps.iter().any(is_near) {
            gaps.push(gap);
        }
    }
    gaps
}

/// Mean motion over the edges of a triangle that cross plates, and the direction it opens in.
fn opening_of(
    mesh: &SphereMesh<EdgeState>,
    radius: f64,
    boundaries: &Boundaries,
    plates: &PlateTable,
    plate: &[PlateId],
    corners: [u32; 3],
) -> (Motion, DVec3) {
    let end = |v: u32| (v, mesh.site(v), plate[v as usize]);
    let mut mean = Motion::default();
    let mut strike = DVec3::ZERO;
    let mut count = 0.0;
    for i in 0..3 {
        let (a, b) = (end(corners[i]), end(corners[(i + 1) % 3]));
        if a.2 == b.2 {
            continue;
        }
        let motion = boundaries.motion(plates, radius, a, b);
        mean.opening += motion.opening;
        mean.slip += motion.slip;
        let direction = boundaries.direction((a.0, a.1), (b.0, b.1));
        strike += if direction.dot(strike) < 0.0 {
            -direction
        } else {
            direction
        };
        count += 1.0;
    }
    if count > 0.0 {
        mean.opening /= count;
        mean.slip /= count;
    }
    (mean, strike)
}

/// Opening fronts by segment: the two plates, the smaller id first, and the number of the stripe.
struct Segments<'a> {
    recipe: &'a Recipe,
    plates: &'a PlateTable,
    fronts: BTreeMap<(PlateId, PlateId, i64), Vec<&'a Front>>,
}

impl<'a> Segments<'a> {
    /// Sorts the fronts by segment, where there are gaps to be filled.
    fn gather(
        workers: &Workers,
        gaps: &[Gap],
        recipe: &'a Recipe,
        boundaries: &'a Boundaries,
        plates: &'a PlateTable,
        plate: &[PlateId],
    ) -> Self {
        let mut segments = Self {
            recipe,
            plates,
            fronts: BTreeMap::new(),
        };
        // Only of ridges that are to grow in this step.
        let pair = |gap: &Gap| {
            let of = gap.corners.map(|v| plate[v as usize]);
            let (first, second) = (of.iter().min().copied(), of.iter().max().copied());
            (first.unwrap_or_default(), second.unwrap_or_default())
        };
        let grow = gaps.iter().filter(|gap| gap.motion.opening > 0.0);
        let pairs: BTreeSet<(PlateId, PlateId)> = grow.map(pair).collect();
        let parts = boundaries.fronts.chunks(FEW).enumerate();
        let found = workers.run(parts, |(part, fronts)| {
            let mut found: Vec<((PlateId, PlateId, i64), usize)> = Vec::new();
            for (front, place) in fronts.iter().zip(part * FEW..) {
                let (first, second) = Contacts::key(front.plates[0], front.plates[1]);
                if front.opening > 0.0 && pairs.contains(&(first, second)) {
                    let pole = segments.pole(first, second);
                    let stripe = segments.stripe(pole, front.midpoint);
                    found.push(((first, second, stripe), place));
                }
            }
            found
        });
        for (segment, place) in found.into_iter().flatten() {
            let of_segment = segments.fronts.entry(segment).or_default();
            of_segment.push(&boundaries.fronts[place]);
        }
        segments
    }

    /// Length of a segment in km.
    fn length(&self) -> f64 {
        let shortest = SEGMENT_SPACINGS * self.recipe.spacing_km();
        self.recipe.constants.ridges.segment.max(shortest)
    }

    fn pole(&self, first: PlateId, second: PlateId) -> DVec3 {
        (self.plates.rotation(second) - self.plates.rotation(first)).normalize_or_zero()
    }

    fn stripe(&self, pole: DVec3, site: DVec3) -> i64 {
        let colatitude = libm::acos(site.dot(pole).clamp(-1.0, 1.0));
        (colatitude * self.recipe.radius_km / self.length()).floor() as i64
    }

    /// The corner whose plate takes new crust at a ridge of two plates: the one on the gap's side of the
    /// axis of its segment. None near the axis, and where three plates meet.
    fn side(&self, gap: &Gap, plate: &[PlateId]) -> Option<usize> {
        let of = gap.corners.map(|v| plate[v as usize]);
        let first = *of.iter().min()?;
        let second = *of.iter().max()?;
        if of.iter().any(|&id| id != first && id != second) {
            return None;
        }
        let pole = self.pole(first, second);
        let near = NEAR_SEGMENTS * self.length() / self.recipe.radius_km;
        let axis: DVec3 = self
            .fronts
            .get(&(first, second, self.stripe(pole, gap.site)))?
            .iter()
            .filter(|front| front.midpoint.distance(gap.site) < near)
            .map(|front| (front.midpoint - pole * front.midpoint.dot(pole)) * front.length)
            .sum();
        // The second plate moves along pole × axis.
        let ahead = pole.cross(axis).normalize_or_zero().dot(gap.site) * self.recipe.radius_km;
        if ahead.abs() < ON_AXIS * self.recipe.spacing_km() {
            return None;
        }
        let winner = if ahead > 0.0 { second } else { first };
        gap.corners
            .iter()
            .map(|&v| v as usize)
            .find(|&v| plate[v] == winner)
    }
}

/// The corner whose plate is older there: it takes the new crust, so that both flanks grow evenly.
fn older_side(corners: [usize; 3], plate: &[PlateId], created: &[Created]) -> usize {
    let mean = |id: PlateId| {
        let of = corners.iter().filter(|&&v| plate[v] == id);
        let (sum, n) = of.fold((0.0, 0.0), |(sum, n), &v| (sum + created[v].0, n + 1.0));
        sum / n
    };
    let [a, b, c] = corners;
    let mut best = a;
    for v in [b, c] {
        if mean(plate[v]) < mean(plate[best]) {
            best = v;
        }
    }
    best
}
