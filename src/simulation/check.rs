//! What must hold after every step, and the hash that tells planets apart.

use super::{
    clock::Clock,
    columns::Columns,
    error::TectonicError,
    ledger::Ledger,
    plate::{Plate, Rotation},
    recipe::Recipe,
    stages::{Mantle, reorganize_plates::splinters::pieces},
    sub_plate::*,
    topology::Topology,
};
use bevy::ecs::system::RunSystemOnce;
use bevy::prelude::*;
use glam::Vec3;
use std::collections::BTreeMap;
use xxhash_rust::xxh3::Xxh3;

/// Largest relative gap of the ledger.
const LEDGER_GAP: f64 = 1e-6;
/// Largest relative gap of the cells' areas.
const AREA_GAP: f64 = 1e-6;
/// How far the mesh may be from Delaunay, in radii: half a millimetre. All edges are looked at whenever plates are
/// reorganised; until then the inside of a plate turns as a body, and each turn rounds its sites to 6 nm.
const HAIR: f64 = 1e-10;
/// Largest radial part of a velocity, in km/My. f32 vectors of 100 km/My hold 1e-5.
const RADIAL: f64 = 1e-2;

type AllColumns = (
    &'static Position,
    &'static Velocity,
    &'static Deviation,
    &'static PlateId,
    &'static Crust,
    &'static Elevation,
    &'static Thickness,
    &'static MaterialArea,
    &'static Created,
    &'static Orogeny,
    &'static OrogenyBegan,
    &'static FoldDirection,
    &'static RidgeDirection,
    &'static Slab,
    (&'static Trench, &'static Volcanism),
);

/// Verifies the world: see [`History::check`](super::History::check).
pub(super) fn check(world: &mut World) -> Result<(), TectonicError> {
    run(world, check_world)
}

/// Hash of the state: see [`History::state_hash`](super::History::state_hash).
pub(super) fn state_hash(world: &mut World) -> Result<u64, TectonicError> {
    run(world, hash_world)
}

/// Runs a read-only system on a world outside its schedule.
pub(super) fn run<T: 'static, M>(
    world: &mut World,
    system: impl IntoSystem<(), Result<T, TectonicError>, M> + 'static,
) -> Result<T, TectonicError> {
    world
        .run_system_once(system)
        .unwrap_or(Err(TectonicError::Archetype {
            found: 0,
            expected: 0,
        }))
}

fn check_world(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    topology: Res<Topology>,
    ledger: Res<Ledger>,
    plates: Query<(&Plate, &Rotation)>,
    mut sub_plates: Query<AllColumns, With<SubPlate>>,
) -> Result<(), TectonicError> {
    let time_my = clock.time_my;
    let mesh = &topology.0;
    let columns = sub_plates.columns(mesh.vertex_count())?;
    let (position, velocity, _, plate, crust, elevation, thickness, area, ..) = columns;
    mesh.check_within(HAIR)
        .map_err(|source| TectonicError::Mesh { time_my, source })?;

    for v in 0..position.len() {
        let fields = [
            ("position", f64::from(position[v].0.length())),
            ("velocity", f64::from(velocity[v].0.length())),
            ("deviation", f64::from(columns.2[v].0.length())),
            ("elevation", f64::from(elevation[v].0)),
            ("thickness", thickness[v].0),
            ("material area", area[v].0),
            ("creation time", f64::from(columns.8[v].0)),
            ("fold direction", f64::from(columns.11[v].0.length())),
            ("ridge direction", f64::from(columns.12[v].0.length())),
            ("slab", f64::from(columns.13[v].0)),
            ("trench", f64::from(columns.14.0[v].0)),
            ("pile", f64::from(columns.14.1[v].pile_km)),
            (
                "time of volcanism",
                f64::from(columns.14.1[v].last_my.unwrap_or(0.0)),
            ),
        ];
        if let Some((field, _)) = fields.iter().find(|(_, value)| !value.is_finite()) {
            return Err(TectonicError::NotFinite {
                field,
                vertex: v,
                time_my,
            });
        }
        if thickness[v].0 < 0.0 {
            return Err(TectonicError::Thickness {
                vertex: v,
                thickness_km: thickness[v].0,
                time_my,
            });
        }
        let radial = mesh.site(v as u32).dot(velocity[v].0.as_dvec3());
        if radial.abs() > RADIAL {
            return Err(TectonicError::NotTangential {
                vertex: v,
                radial,
                time_my,
            });
        }
    }

    let mut count: BTreeMap<PlateId, usize> =
        plates.iter().map(|(plate, _)| (plate.id, 0)).collect();
    for (id, _) in pieces(mesh, plate).pieces {
        match count.get_mut(&id) {
            Some(count) => *count += 1,
            None => {
                return Err(TectonicError::PlateInPieces {
                    plate: id.0,
                    pieces: 0,
                    time_my,
                });
            }
        }
    }
    if let Some((id, &pieces)) = count.iter().find(|(_, pieces)| **pieces != 1) {
        return Err(TectonicError::PlateInPieces {
            plate: id.0,
            pieces,
            time_my,
        });
    }

    let volume: f64 = (0..crust.len())
        .filter(|&v| crust[v].is_continental())
        .map(|v| thickness[v].0 * area[v].0)
        .sum();
    let relative = ledger.closing_error(volume);
    // Not a number is not closed either.
    let closed = relative.abs() <= LEDGER_GAP;
    if !closed && recipe.continental_share > 0.0 {
        return Err(TectonicError::LedgerOpen { relative, time_my });
    }
    let sum = mesh.cell_areas().iter().sum::<f64>() / (4.0 * core::f64::consts::PI);
    let covered = (sum - 1.0).abs() <= AREA_GAP;
    if !covered {
        return Err(TectonicError::AreaOpen { sum, time_my });
    }
    Ok(())
}

fn hash_world(
    clock: Res<Clock>,
    mantle: Res<Mantle>,
    topology: Res<Topology>,
    plates: Query<(&Plate, &Rotation)>,
    mut sub_plates: Query<AllColumns, With<SubPlate>>,
) -> Result<u64, TectonicError> {
    let mesh = &topology.0;
    let columns = sub_plates.columns(mesh.vertex_count())?;
    let mut hash = Xxh3::new();
    for site in mesh.sites() {
        let bytes = site.to_array().map(f64::to_le_bytes);
        hash.update(bytes.as_flattened());
    }
    let mut vector = |v: Vec3| {
        v.to_array()
            .iter()
            .for_each(|x| hash.update(&x.to_le_bytes()));
    };
    for v in 0..mesh.vertex_count() {
        vector(columns.0[v].0);
        vector(columns.1[v].0);
        vector(columns.2[v].0);
        vector(columns.11[v].0);
        vector(columns.12[v].0);
    }
    for v in 0..mesh.vertex_count() {
        hash.update(&columns.3[v].0.to_le_bytes());
        hash.update(&[columns.4[v] as u8, columns.9[v] as u8]);
        for single in [
            columns.5[v].0,
            columns.8[v].0,
            columns.10[v].0,
            columns.13[v].0,
            columns.14.0[v].0,
            columns.14.1[v].pile_km,
            columns.14.1[v].last_my.unwrap_or(f32::MAX),
        ] {
            hash.update(&single.to_le_bytes());
        }
        hash.update(&columns.6[v].0.to_le_bytes());
        hash.update(&columns.7[v].0.to_le_bytes());
    }
    for edge in mesh.edges() {
        let (u, v) = mesh.endpoints(edge);
        let state = mesh.payload(edge);
        hash.update(&u.to_le_bytes());
        hash.update(&v.to_le_bytes());
        hash.update(&[state.kind as u8, state.cross_kind as u8]);
        hash.update(&state.rest.to_le_bytes());
        hash.update(&state.cross_rest.to_le_bytes());
    }
    let mut rows: Vec<_> = plates
        .iter()
        .map(|(plate, rotation)| (plate.id, rotation.0))
        .collect();
    rows.sort_by_key(|(id, _)| *id);
    for (id, rotation) in rows {
        hash.update(&id.0.to_le_bytes());
        rotation
            .to_array()
            .iter()
            .for_each(|x| hash.update(&x.to_le_bytes()));
    }
    for vector in [mantle.downwelling, mantle.superplume] {
        vector
            .to_array()
            .iter()
            .for_each(|x| hash.update(&x.to_le_bytes()));
    }
    hash.update(&mantle.warmth.to_le_bytes());
    hash.update(&[u8::from(mantle.rising)]);
    hash.update(&clock.time_my.to_le_bytes());
    hash.update(&clock.steps.to_le_bytes());
    Ok(hash.digest())
}
