//! The flow of the mantle cut into plates (Tectonics.js).
//!
//! Take the fastest place that no plate has yet, flood fill what turns within 60° of its rotation, open
//! and close the borders morphologically, and repeat; what is left over joins the nearest. With
//! this drive plates begin and end here: neither rifts nor new trenches run between segmentations, for
//! both would cut what the flow holds together. Sutures do, or continents would be crushed for as
//! long as the next segmentation is away.

use super::{
    super::{
        super::{
            clock::Clock,
            columns::Columns,
            constants::FounderingConstants,
            error::TectonicError,
            plate::{NextPlateId, Plate, PlateBorn, PlateRow, PlateTable, Rotation},
            reach::reach,
            recipe::Recipe,
            sub_plate::{Created, Crust, MaterialArea, PlateId, SubPlate},
            topology::Topology,
            workers::Workers,
        },
        apply_forces::{
            foundering::bounded,
            foundering_flow::{mantle_flow, mean_rotations},
        },
    },
    Splits,
};
use crate::mesh::{EdgePayload, NONE, SphereMesh};
use bevy::prelude::*;
use glam::DVec3;

/// Flow slower than this share of the fastest is at rest and starts no plate.
const STILL: f64 = 1e-3;
/// Borders are rounded by at least this many spacings, or not at all on a coarse mesh.
const LEAST_ROUNDING: f64 = 1.1;

/// Cuts the mantle's flow into plates, at the start and whenever its interval has gone by.
pub(in crate::simulation) fn segment(
    mut commands: Commands,
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    topology: Res<Topology>,
    mut next: ResMut<NextPlateId>,
    mut splits: ResMut<Splits>,
    plates: Query<(Entity, &Plate, &Rotation, &PlateBorn)>,
    mut sub_plates: Query<(&mut PlateId, &Crust, &Created, &MaterialArea), With<SubPlate>>,
) -> Result<(), TectonicError> {
    if clock.reorganisation.due().is_none() && clock.steps > 1 {
        return Ok(());
    }
    let table = PlateTable::gather(plates.iter());
    if !is_due(&recipe.constants.foundering, &clock, table.rows()) {
        return Ok(());
    }
    let mesh = &topology.0;
    let (mut plate, crust, created, area) = sub_plates.columns(mesh.vertex_count())?;
    let flow = mantle_flow(&recipe, &clock, mesh, crust, created);
    let segments = Segments::cut(&recipe, mesh, &flow, |v| area[v].0);
    // A mantle at rest leaves the plates as they are.
    if segments.count < 2 {
        return Ok(());
    }
    let of = |v: usize| Some(segments.of[v] as usize);
    let rotations = mean_rotations(&flow, |v| area[v].0, of, segments.count);
    let mut ids = Vec::with_capacity(segments.count);
    for rotation in rotations {
        let Some(id) = next.take() else {
            return Ok(());
        };
        ids.push((id, bounded(&recipe, rotation)));
    }
    for (plate, &segment) in plate.bypass_change_detection().iter_mut().zip(&segments.of) {
        *plate = ids[segment as usize].0;
    }
    for (id, rotation) in ids {
        commands.spawn((Plate { id }, Rotation(rotation), PlateBorn(clock.time_my)));
    }
    // The plates before have no ground left: they end where splinters are absorbed.
    splits.suspected = true;
    splits.regrouped = true;
    Ok(())
}

/// Whether plates are to be cut anew: at the start, once they are as old as the interval, or earlier
/// where sutures and trenches have left few of them.
fn is_due(constants: &FounderingConstants, clock: &Clock, plates: &[PlateRow]) -> bool {
    // All plates of a segmentation are born with it; only pieces that broke off are younger.
    let oldest = plates
        .iter()
        .map(|row| row.born)
        .fold(clock.time_my, f64::min);
    let age = clock.time_my - oldest;
    let few = (plates.len() as f64) < constants.fewest * constants.segments;
    clock.steps == 1 || age >= constants.interval || (few && age >= constants.rest)
}

/// A flow cut into connected segments that cover the sphere.
struct Segments {
    /// Segment of each vertex, if there is any.
    of: Vec<u32>,
    count: usize,
}

impl Segments {
    fn cut<E: EdgePayload>(
        recipe: &Recipe,
        mesh: &SphereMesh<E>,
        flow: &[DVec3],
        area: impl Fn(usize) -> f64,
    ) -> Self {
        let constants = &recipe.constants.foundering;
        let spacing = recipe.spacing_km();
        let rounding = if constants.rounding > 0.0 {
            constants.rounding.max(LEAST_ROUNDING * spacing)
        } else {
            0.0
        };
        let brush = Brush {
            mesh,
            radius_km: recipe.radius_km,
            width: rounding,
        };
        let sphere = 4.0 * core::f64::consts::PI * recipe.radius_km * recipe.radius_km;
        let smallest = recipe.constants.plates.orphan * sphere;
        let near = libm::cos(constants.spread.to_radians());
        let mut order: Vec<(f64, u32)> = (0..flow.len() as u32)
            .map(|v| (flow[v as usize].length(), v))
            .collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let still = STILL * order.first().map_or(0.0, |fastest| fastest.0);
        let mut of = vec![NONE; flow.len()];
        let mut tried = vec![false; flow.len()];
        let mut count = 0;
        for (speed, seed) in order {
            if speed <= still || count as f64 >= constants.segments {
                break;
            }
            if of[seed as usize] != NONE || tried[seed as usize] {
                continue;
            }
            let axis = flow[seed as usize];
            let alike = |v: usize| {
                of[v] == NONE && axis.dot(flow[v]) > near * axis.length() * flow[v].length()
            };
            let filled = flood(mesh, seed, alike);
            for (tried, filled) in tried.iter_mut().zip(&filled) {
                *tried |= *filled;
            }
            let rounded = brush.close(&brush.open(&filled), |v| of[v] == NONE);
            let Some(body) = largest_body(mesh, &rounded, &area) else {
                continue;
            };
            if body.iter().map(|&v| area(v as usize)).sum::<f64>() < smallest {
                continue;
            }
            for v in body {
                of[v as usize] = count;
            }
            count += 1;
        }
        // What is left over joins the nearest segment, along ways that stay within it.
        let sources: Vec<(u32, f64)> = (0..of.len() as u32)
            .filter(|&v| of[v as usize] != NONE)
            .map(|v| (v, 0.0))
            .collect();
        let nearest = reach(
            &Workers::default(),
            mesh,
            recipe.radius_km,
            &sources,
            f64::INFINITY,
            |_| true,
        );
        for (v, _, source) in nearest.found {
            of[v as usize] = of[sources[source as usize].0 as usize];
        }
        Self {
            of,
            count: count as usize,
        }
    }
}

/// The connected vertices around `seed` that `accept` admits, as a mask.
fn flood<E: EdgePayload>(
    mesh: &SphereMesh<E>,
    seed: u32,
    accept: impl Fn(usize) -> bool,
) -> Vec<bool> {
    let mut mask = vec![false; mesh.vertex_count()];
    mask[seed as usize] = true;
    let mut stack = vec![seed];
    while let Some(v) = stack.pop() {
        for w in mesh.neighbours(v) {
            if !mask[w as usize] && accept(w as usize) {
                mask[w as usize] = true;
                stack.push(w);
            }
        }
    }
    mask
}

/// The connected part of a mask that is largest by area; none of an empty one.
fn largest_body<E: EdgePayload>(
    mesh: &SphereMesh<E>,
    mask: &[bool],
    area: impl Fn(usize) -> f64,
) -> Option<Vec<u32>> {
    let mut left = mask.to_vec();
    let mut best: Option<(f64, Vec<u32>)> = None;
    for first in 0..left.len() {
        if !left[first] {
            continue;
        }
        let body = flood(mesh, first as u32, |v| left[v]);
        let body: Vec<u32> = (0..body.len() as u32)
            .filter(|&v| body[v as usize])
            .collect();
        let size = body.iter().map(|&v| area(v as usize)).sum();
        for &v in &body {
            left[v as usize] = false;
        }
        if best.as_ref().is_none_or(|best| size > best.0) {
            best = Some((size, body));
        }
    }
    best.map(|(_, body)| body)
}

/// Binary morphology with a disc of this radius.
struct Brush<'a, E: EdgePayload> {
    mesh: &'a SphereMesh<E>,
    radius_km: f64,
    width: f64,
}

impl<E: EdgePayload> Brush<'_, E> {
    /// The mask and all that lies within the brush's width of it and is `allowed`.
    fn dilate(&self, mask: &[bool], allowed: impl Fn(usize) -> bool + Sync) -> Vec<bool> {
        let rim: Vec<(u32, f64)> = (0..mask.len() as u32)
            .filter(|&v| mask[v as usize])
            .filter(|&v| self.mesh.neighbours(v).any(|w| !mask[w as usize]))
            .map(|v| (v, 0.0))
            .collect();
        let passable = |v: u32| !mask[v as usize] && allowed(v as usize);
        let mut grown = mask.to_vec();
        for (v, ..) in reach(
            &Workers::default(),
            self.mesh,
            self.radius_km,
            &rim,
            self.width,
            passable,
        )
        .found
        {
            grown[v as usize] = true;
        }
        grown
    }

    /// The mask without what lies within the brush's width of its outside.
    fn erode(&self, mask: &[bool]) -> Vec<bool> {
        let outside: Vec<bool> = mask.iter().map(|inside| !inside).collect();
        let grown = self.dilate(&outside, |_| true);
        grown.iter().map(|outside| !outside).collect()
    }

    /// Removes necks: eroded, then dilated.
    fn open(&self, mask: &[bool]) -> Vec<bool> {
        self.dilate(&self.erode(mask), |v| mask[v])
    }

    /// Fills bays: dilated where it is `allowed`, then eroded, but never below what it was.
    fn close(&self, mask: &[bool], allowed: impl Fn(usize) -> bool + Sync) -> Vec<bool> {
        let closed = self.erode(&self.dilate(mask, allowed));
        closed.iter().zip(mask).map(|(a, b)| *a || *b).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::fixtures::even_mesh;

    #[test]
    fn two_streams_make_two_plates_on_any_mesh() {
        for n in [1_000, 4_000] {
            let mesh = even_mesh::<()>(n);
            let recipe = Recipe::default().with_sub_plates(n);
            // North of the equator about z, south of it the other way round, somewhat slower.
            let flow: Vec<DVec3> = mesh
                .sites()
                .iter()
                .map(|site| DVec3::Z * if site.z > 0.0 { 0.01 } else { -0.008 })
                .collect();
            let cell = recipe.cell_area_km2();
            let segments = Segments::cut(&recipe, &mesh, &flow, |_| cell);
            assert_eq!(segments.count, 2);
            for (v, site) in mesh.sites().iter().enumerate() {
                // Rounding may shift the border by a cell.
                if site.z.abs() > 0.15 {
                    assert_eq!(segments.of[v], u32::from(site.z < 0.0), "{site}");
                }
            }
        }
    }

    #[test]
    fn a_mantle_at_rest_makes_no_plates() {
        let mesh = even_mesh::<()>(500);
        let recipe = Recipe::default().with_sub_plates(500);
        let flow = vec![DVec3::ZERO; 500];
        assert_eq!(Segments::cut(&recipe, &mesh, &flow, |_| 1e6).count, 0);
    }

    #[test]
    fn opening_cuts_necks_and_closing_fills_bays() {
        let mesh = even_mesh::<()>(4_000);
        let brush = Brush {
            mesh: &mesh,
            radius_km: 6371.0,
            width: 700.0,
        };
        // Two caps joined by a neck of some 600 km along the equator.
        let mask: Vec<bool> = mesh
            .sites()
            .iter()
            .map(|p| p.x.abs() > 0.8 || (p.z.abs() < 0.05 && p.y > 0.0))
            .collect();
        let opened = brush.open(&mask);
        let closed = brush.close(&opened, |_| true);
        for (v, p) in mesh.sites().iter().enumerate() {
            if p.x.abs() < 0.6 {
                assert!(!opened[v], "neck at {p}");
            }
            if p.x.abs() > 0.9 {
                assert!(opened[v] && closed[v], "cap at {p}");
            }
            // Opening only takes, closing only gives.
            assert!(mask[v] || !opened[v]);
            assert!(closed[v] || !opened[v]);
        }
        // A bay of some 600 km in a cap is filled.
        let bay: Vec<bool> = mesh
            .sites()
            .iter()
            .map(|p| p.x > 0.2 && !(p.z.abs() < 0.05 && p.y > 0.3))
            .collect();
        let filled = brush.close(&bay, |_| true);
        let inner = DVec3::new(0.8, 0.6, 0.0);
        let nearest = (0..4_000_u32)
            .min_by(|a, b| {
                let far = |v: &u32| mesh.site(*v).distance(inner);
                far(a).total_cmp(&far(b))
            })
            .unwrap();
        assert!(!bay[nearest as usize] && filled[nearest as usize]);
    }

    #[test]
    fn segmentation_is_due_at_the_start_at_its_interval_and_where_few_plates_are_left() {
        let constants = FounderingConstants::default();
        let due = |steps, time_my, born: &[f64]| {
            let rows: Vec<PlateRow> = born
                .iter()
                .map(|&born| PlateRow {
                    id: PlateId(1),
                    entity: Entity::PLACEHOLDER,
                    rotation: DVec3::ZERO,
                    born,
                })
                .collect();
            let clock = Clock {
                steps,
                time_my,
                ..default()
            };
            is_due(&constants, &clock, &rows)
        };
        let many = [0.5; 20];
        assert!(due(1, 0.5, &[0.0; 20]));
        assert!(!due(2, 1.0, &many));
        assert!(!due(300, 150.0, &many));
        assert!(due(300, 150.6, &many));
        // Pieces that broke off later do not put it off.
        assert!(due(300, 151.0, &[149.0, 0.5, 140.0]));
        assert!(!due(20, 10.0, &[0.5, 0.5]));
        assert!(due(100, 60.0, &[0.5, 0.5]));
    }

    #[test]
    fn streams_whose_rotations_differ_by_less_than_the_spread_make_one_plate() {
        let mesh = even_mesh::<()>(1_000);
        let mut recipe = Recipe::default().with_sub_plates(1_000);
        let cell = recipe.cell_area_km2();
        let cases = [
            (50.0, 60.0, 1),
            (70.0, 60.0, 2),
            (50.0, 45.0, 2),
            (70.0, 80.0, 1),
        ];
        for (degrees, spread, expected) in cases {
            recipe.constants.foundering.spread = spread;
            // North of the equator about z, south of it about an axis so many degrees from z.
            let (sin, cos) = libm::sincos(f64::to_radians(degrees));
            let south = DVec3::new(sin, 0.0, cos) * 0.008;
            let flow: Vec<DVec3> = mesh
                .sites()
                .iter()
                .map(|site| if site.z > 0.0 { DVec3::Z * 0.01 } else { south })
                .collect();
            let segments = Segments::cut(&recipe, &mesh, &flow, |_| cell);
            assert_eq!(segments.count, expected, "{degrees}° within {spread}°");
        }
    }

    #[test]
    fn no_more_plates_are_made_than_wanted_and_the_fastest_first() {
        let mesh = even_mesh::<()>(2_000);
        let mut recipe = Recipe::default().with_sub_plates(2_000);
        let cell = recipe.cell_area_km2();
        // Six streams, one about each end of each axis; those about x are the fastest.
        let flow: Vec<DVec3> = mesh
            .sites()
            .iter()
            .map(|site| {
                let far = site.abs();
                if far.x >= far.y && far.x >= far.z {
                    DVec3::X * (0.01 * site.x.signum())
                } else if far.y >= far.z {
                    DVec3::Y * (0.009 * site.y.signum())
                } else {
                    DVec3::Z * (0.008 * site.z.signum())
                }
            })
            .collect();
        for (most, expected) in [(10.0, 6), (4.0, 4), (2.0, 2)] {
            recipe.constants.foundering.segments = most;
            let segments = Segments::cut(&recipe, &mesh, &flow, |_| cell);
            assert_eq!(segments.count, expected);
            // What is left over joins them.
            assert!(segments.of.iter().all(|&of| (of as usize) < expected));
            for (v, site) in mesh.sites().iter().enumerate() {
                if site.x.abs() > 0.9 {
                    assert!(segments.of[v] < 2, "{most}: {site}");
                }
            }
        }
    }
}
