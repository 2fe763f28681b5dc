//! Stage 5: plates turn, margins bend, and every sub-plate stays on the sphere.
//!
//! The rigid part of the motion is an exact rotation, so that plates keep their shape over any
//! number of steps; the deviation is added to it, and the sum is normalised.

use super::super::{
    clock::Clock,
    columns::Columns,
    error::TectonicError,
    plate::{Plate, PlateBorn, PlateTable, Rotation},
    precision::{round_direction, round_site},
    recipe::Recipe,
    stages::Splits,
    sub_plate::*,
    topology::Topology,
    workers::{CHUNK, Workers},
};
use bevy::prelude::*;
use glam::{DMat3, DVec3, Mat3, Vec3};

/// Rotation matrix of a turn by the length of `turn` (rad) about its direction.
fn rotation_matrix(turn: DVec3) -> DMat3 {
    let angle = turn.length();
    if angle == 0.0 {
        return DMat3::IDENTITY;
    }
    let axis = turn / angle;
    let (sin, cos) = libm::sincos(angle);
    let outer = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
    let cross = DMat3::from_cols(
        DVec3::new(0.0, axis.z, -axis.y),
        DVec3::new(-axis.z, 0.0, axis.x),
        DVec3::new(axis.y, -axis.x, 0.0),
    );
    DMat3::IDENTITY * cos + cross * sin + outer * (1.0 - cos)
}

/// Moves every sub-plate, the directions it carries and its vertex of the mesh by one step.
///
/// The mesh's `f64` sites are what turns, and positions are their rounded copies: rounding to `f32` in every
/// step would break hundreds of edges of a large mesh far from every front.
pub(in crate::simulation) fn move_sub_plates(
    recipe: Res<Recipe>,
    mut clock: ResMut<Clock>,
    workers: Res<Workers>,
    mut topology: ResMut<Topology>,
    plates: Query<(Entity, &Plate, &Rotation, &PlateBorn)>,
    mut sub_plates: Query<
        (
            &PlateId,
            &mut Position,
            &mut Velocity,
            &mut Deviation,
            &mut FoldDirection,
            &mut RidgeDirection,
        ),
        With<SubPlate>,
    >,
) -> Result<(), TectonicError> {
    let sites = topology.0.sites_mut();
    let (plate, mut position, mut velocity, mut deviation, mut fold, mut ridge) =
        sub_plates.columns(sites.len())?;
    let plates = PlateTable::gather(plates.iter());
    let (radius, step) = (recipe.radius_km, clock.step_my);
    // One more for sub-plates that no plate carries.
    let mut turns: Vec<(DVec3, DMat3, Mat3)> = plates
        .rows()
        .iter()
        .map(|plate| {
            let matrix = rotation_matrix(plate.rotation * step);
            (plate.rotation, matrix, matrix.as_mat3())
        })
        .collect();
    turns.push((DVec3::ZERO, DMat3::IDENTITY, Mat3::IDENTITY));

    let bodies = (sites.chunks_mut(CHUNK))
        .zip(plate.chunks(CHUNK))
        .zip(position.bypass_change_detection().chunks_mut(CHUNK))
        .zip(velocity.bypass_change_detection().chunks_mut(CHUNK));
    let carried = (deviation.bypass_change_detection().chunks_mut(CHUNK))
        .zip(fold.bypass_change_detection().chunks_mut(CHUNK))
        .zip(ridge.bypass_change_detection().chunks_mut(CHUNK));
    let fastest = workers.run(bodies.zip(carried), |part| {
        let ((((sites, plate), position), velocity), ((deviation, fold), ridge)) = part;
        let mut fastest = 0.0_f64;
        for v in 0..sites.len() {
            let (rotation, matrix, single) =
                &turns[plates.row(plate[v]).unwrap_or(turns.len() - 1)];
            let mut place = *matrix * sites[v];
            // One step of Newton's keeps the length at 1.
            place *= 1.5 - 0.5 * place.length_squared();
            let bent = deviation[v].0;
            let soft = bent != Vec3::ZERO;
            if soft {
                let bent = *matrix * bent.as_dvec3();
                place = (place + bent * (step / radius)).normalize();
                deviation[v].0 = (bent - place * place.dot(bent)).as_vec3();
            }
            place = place.map(round_site);
            let mut speed = rotation.cross(place) * radius;
            if soft {
                speed += deviation[v].0.as_dvec3();
            }
            fastest = fastest.max(speed.length_squared());
            sites[v] = place;
            position[v].0 = place.as_vec3();
            velocity[v].0 = speed.as_vec3();
            for direction in [&mut fold[v].0, &mut ridge[v].0] {
                if *direction != Vec3::ZERO {
                    let turned = *single * *direction;
                    *direction = turned.map(round_direction);
                }
            }
        }
        fastest
    });
    clock.fastest = fastest.into_iter().fold(0.0, f64::max).sqrt();
    Ok(())
}

/// Gives sub-plates that changed plates, or whose plate changed its motion, the velocity of their
/// plate. Runs at the end of the step.
pub(in crate::simulation) fn follow_plates(
    recipe: Res<Recipe>,
    workers: Res<Workers>,
    mut splits: ResMut<Splits>,
    topology: Res<Topology>,
    plates: Query<(Entity, &Plate, &Rotation, &PlateBorn)>,
    mut sub_plates: Query<(&PlateId, &Deviation, &mut Velocity), With<SubPlate>>,
) -> Result<(), TectonicError> {
    let moved = core::mem::take(&mut splits.moved);
    let all = core::mem::take(&mut splits.regrouped);
    if !all && moved.is_empty() {
        return Ok(());
    }
    let mesh = &topology.0;
    let (plate, deviation, mut velocity) = sub_plates.columns(mesh.vertex_count())?;
    let velocity = velocity.bypass_change_detection();
    let plates = PlateTable::gather(plates.iter());
    let follow = |v: usize| {
        let rigid = plates.rotation(plate[v]).cross(mesh.site(v as u32)) * recipe.radius_km;
        Velocity((rigid + deviation[v].0.as_dvec3()).as_vec3())
    };
    if all {
        workers.run(velocity.chunks_mut(CHUNK).enumerate(), |(part, rows)| {
            for (i, velocity) in rows.iter_mut().enumerate() {
                *velocity = follow(part * CHUNK + i);
            }
        });
    } else {
        for v in moved {
            velocity[v as usize] = follow(v as usize);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_the_pole_carries_x_to_y() {
        let turned = rotation_matrix(DVec3::Z * core::f64::consts::FRAC_PI_2) * DVec3::X;
        assert!((turned - DVec3::Y).length() < 1e-15);
    }

    #[test]
    fn rotations_keep_lengths() {
        let turned = rotation_matrix(DVec3::new(0.3, -0.2, 0.9)) * DVec3::new(0.6, 0.0, 0.8);
        assert!((turned.length() - 1.0).abs() < 1e-15);
    }
}
