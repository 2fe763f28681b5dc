//! The first moment of an imported world.

use super::{
    flood_fill,
    imported::{HeightMap, ImageStart, ImportedPlate, ImportedWorld},
    outlines::Outlines,
    relief::{self, Ground},
    voronoi::join_strays,
};
use crate::{
    mesh::SphereMesh,
    simulation::{
        error::TectonicError,
        reach::reach,
        recipe::Recipe,
        stages::reorganize_plates::splinters::{Pieces, pieces},
        sub_plate::{Crust, PlateId},
        topology::EdgeState,
        workers::Workers,
    },
};
use glam::DVec3;
use std::collections::BTreeMap;

/// Samples across a cell: finer maps are read at every so many pixels.
const SAMPLES: f64 = 8.0;

/// Plates and ground of an imported world. Angular velocities in rad/My, by id from 1 on, if it says any.
pub(super) struct Imported {
    pub plate: Vec<PlateId>,
    pub ground: Ground,
    pub rotations: Option<Vec<DVec3>>,
}

/// Lays out an imported world.
pub(super) fn lay_out(
    recipe: &Recipe,
    image: &ImageStart,
    world: &ImportedWorld,
    mesh: &SphereMesh<EdgeState>,
) -> Result<Imported, TectonicError> {
    world.validate()?;
    let (elevations, crust) = sample(&world.heights, mesh, image.shelf_edge_m);
    let (plate, rotations) = if world.plates.is_empty() {
        (flood_fill::lay_out(recipe, mesh).plate, None)
    } else {
        plates(recipe, &world.plates, mesh)?
    };
    let ground = relief::raise(recipe, mesh, &plate, &elevations, crust);
    Ok(Imported {
        plate,
        ground,
        rotations,
    })
}

/// Longitude and latitude in degrees.
fn lon_lat(site: DVec3) -> (f64, f64) {
    let across = libm::hypot(site.x, site.y);
    (
        libm::atan2(site.y, site.x).to_degrees(),
        libm::atan2(site.z, across).to_degrees(),
    )
}

/// Elevation and kind of crust of every cell: the kind that most of its pixels have, and the mean
/// height of those. A mean over both would turn coasts into slopes.
fn sample(
    map: &HeightMap,
    mesh: &SphereMesh<EdgeState>,
    shelf_edge: f64,
) -> (Vec<f64>, Vec<Crust>) {
    let count = mesh.vertex_count();
    let pixel = core::f64::consts::TAU / map.width() as f64;
    let spacing = (4.0 * core::f64::consts::PI / count as f64).sqrt();
    // Weight and weighted height of sea floor and of continent.
    let mut sums = vec![[(0.0, 0.0); 2]; count];
    if pixel < 0.5 * spacing {
        let stride = ((spacing / pixel / SAMPLES) as usize).max(1);
        let columns: Vec<(usize, f64, f64)> = (0..map.width())
            .step_by(stride)
            .map(|x| {
                let lon = (x as f64 + 0.5) * pixel - core::f64::consts::PI;
                let (sin, cos) = libm::sincos(lon);
                (x, sin, cos)
            })
            .collect();
        let mut hint = 0;
        for y in (0..map.height()).step_by(stride) {
            let colatitude = (y as f64 + 0.5) * pixel;
            let (ring, z) = libm::sincos(colatitude);
            for &(x, sin, cos) in &columns {
                hint = mesh.nearest(DVec3::new(ring * cos, ring * sin, z), hint);
                let height = map.pixel(x, y);
                let sum = &mut sums[hint as usize][usize::from(height > shelf_edge)];
                sum.0 += ring;
                sum.1 += ring * height;
            }
        }
    }
    sums.iter()
        .zip(mesh.sites())
        .map(|(&[floor, continent], &site)| {
            let (kind, height) = if floor.0 + continent.0 > 0.0 {
                let kind = continent.0 > floor.0;
                let sum = if kind { continent } else { floor };
                (kind, sum.1 / sum.0)
            } else {
                // The map is coarser than the mesh.
                let (lon, lat) = lon_lat(site);
                let height = map.between(lon, lat);
                (height > shelf_edge, height)
            };
            let crust = if kind {
                Crust::Continental
            } else {
                Crust::Oceanic
            };
            (height, crust)
        })
        .unzip()
}

/// Plates by their outlines, each in one piece, and their rotations if any is given.
fn plates(
    recipe: &Recipe,
    imported: &[ImportedPlate],
    mesh: &SphereMesh<EdgeState>,
) -> Result<(Vec<PlateId>, Option<Vec<DVec3>>), TectonicError> {
    let outlines = Outlines::new(imported);
    let mut plate: Vec<PlateId> = mesh
        .sites()
        .iter()
        .map(|&site| {
            let (lon, lat) = lon_lat(site);
            let found = outlines.plate_at(lon, lat);
            PlateId(found.map_or(0, |number| number as u16 + 1))
        })
        .collect();
    join_nearest(recipe, mesh, &mut plate);
    let mut of_id: Vec<usize> = (0..imported.len()).collect();
    part_exclaves(recipe, mesh, &mut plate, &mut of_id);
    join_strays(mesh, &mut plate);
    if plate.iter().all(|&id| id == plate[0]) {
        return Err(TectonicError::import(
            "the plates",
            "sub-plates lie in one of them or in none",
            "at least two plates larger than a sub-plate",
        ));
    }
    let moves = imported.iter().any(|plate| plate.rotation.is_some());
    let rotations = of_id.iter().map(|&number| {
        let rotation = imported[number].rotation;
        rotation.map_or(DVec3::ZERO, |rotation| rotation.vector())
    });
    Ok((plate, moves.then(|| rotations.collect())))
}

/// What lies in no outline joins the plate that is nearest over the surface.
fn join_nearest(recipe: &Recipe, mesh: &SphereMesh<EdgeState>, plate: &mut [PlateId]) {
    let sources: Vec<(u32, f64)> = (0..plate.len() as u32)
        .filter(|&v| plate[v as usize] != PlateId(0))
        .map(|v| (v, 0.0))
        .collect();
    let found = reach(
        &Workers::default(),
        mesh,
        recipe.radius_km,
        &sources,
        f64::INFINITY,
        |v| plate[v as usize] == PlateId(0),
    );
    for (v, _, source) in found.found {
        plate[v as usize] = plate[sources[source as usize].0 as usize];
    }
}

/// Large pieces that lie apart from the rest of their plate become plates of their own, with the same
/// rotation.
fn part_exclaves(
    recipe: &Recipe,
    mesh: &SphereMesh<EdgeState>,
    plate: &mut [PlateId],
    of_id: &mut Vec<usize>,
) {
    let Pieces { of, pieces } = pieces(mesh, plate);
    let mut size = vec![0_u32; pieces.len()];
    for &piece in &of {
        size[piece as usize] += 1;
    }
    let mut largest: BTreeMap<PlateId, usize> = BTreeMap::new();
    for (piece, &(id, _)) in pieces.iter().enumerate() {
        let best = largest.entry(id).or_insert(piece);
        if size[piece] > size[*best] {
            *best = piece;
        }
    }
    let fewest = recipe.constants.plates.orphan * plate.len() as f64;
    let ids: Vec<PlateId> = pieces
        .iter()
        .enumerate()
        .map(|(piece, &(id, _))| {
            if largest[&id] == piece || id == PlateId(0) || f64::from(size[piece]) < fewest {
                return id;
            }
            of_id.push(of_id[usize::from(id.0) - 1]);
            PlateId(of_id.len() as u16)
        })
        .collect();
    for (plate, piece) in plate.iter_mut().zip(of) {
        *plate = ids[piece as usize];
    }
}
