//! The balance of torques that turns the plates.
//!
//! Lithosphere has no inertia: at every moment drag balances drive. One linear system holds for all
//! plates together,
//!
//! `Σ c a (I − r rᵀ) ωᵢ + Σ s l q qᵀ ωᵢ + Σ η l q qᵀ (ωᵢ − ωⱼ)
//! = (1/R) (Σ r × F + Σ c a r × u + Σ s l q (n · u))`,
//!
//! u the flow of the mantle under continents and around slabs ([`mantle`](super::mantle)), the first sum over the
//! sub-plates of plate i (drag c, area a), the second over the fronts where its slabs hang (resistance s of the
//! mantle, length l, direction n), the third over all of its fronts (viscosity η; lengths scaled to a mesh of
//! 226 km; `q = r × n` for motion across the front and `r × t` along it). It is symmetric and positive definite,
//! and solved by Cholesky's method. Treating friction implicitly is what keeps collisions from ringing, and the
//! slabs' resistance what keeps small plates from racing: both nearly balance what drives.

use super::{
    super::super::{
        boundaries::{Boundaries, Contact, Contacts, Front, FrontForce, FrontForces},
        clock::Clock,
        columns::Columns,
        error::TectonicError,
        plate::{DrivingTorque, Plate, PlateBorn, PlateTable, Rotation},
        recipe::Recipe,
        stages::Mantle,
        sub_plate::{Created, Crust, MaterialArea, PlateId, Slab, SubPlate},
        topology::Topology,
        workers::{FEW, Workers},
    },
    drag::Drag,
};
use bevy::prelude::*;
use glam::{DMat3, DVec3};

/// Age at which a slab pulls with its nominal force, in My.
const SLAB_AGE: f64 = 80.0;
/// Age beyond which it pulls no harder, in My.
const SLAB_OLDEST: f64 = 120.0;
/// Opening speed at which ridge push is full, in km/My.
const RIDGE_FULL: f64 = 5.0;
/// Collisions resist a little before anything has interpenetrated.
const COLLISION_FIRST: f64 = 0.15;
/// Largest growth of the resistance of a collision.
const COLLISION_MOST: f64 = 3.0;

/// Spacing in km of the mesh for which resistances per length are stated.
const STATED_SPACING: f64 = 226.0;
/// Boundaries are rough at every scale: the finer the mesh the longer they are, by this power of its spacing
/// (192,000 km at 226 km, 229,000 km at 56, means of twenty and of ten planets), though what parts there is the same.
const ROUGHNESS: f64 = 0.126;

/// Turns the plates towards the rotations that balance all torques.
pub(in crate::simulation) fn balance_torques(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    workers: Res<Workers>,
    boundaries: Res<Boundaries>,
    contacts: Res<Contacts>,
    mantle: Res<Mantle>,
    topology: Res<Topology>,
    mut forces: ResMut<FrontForces>,
    mut plates: Query<(
        Entity,
        &Plate,
        &mut Rotation,
        &PlateBorn,
        &mut DrivingTorque,
    )>,
    mut sub_plates: Query<(&PlateId, &Crust, &Created, &MaterialArea, &Slab), With<SubPlate>>,
) -> Result<(), TectonicError> {
    let mesh = &topology.0;
    let (plate, crust, created, area, slab) = sub_plates.columns(mesh.vertex_count())?;
    let table = PlateTable::gather(
        plates
            .iter()
            .map(|(e, plate, rotation, born, _)| (e, plate, rotation, born)),
    );
    let constants = &recipe.constants.motion;

    let count = table.rows().len();
    let mut system = System::new(count);
    let mut torques = vec![DrivingTorque::default(); count];
    let drags = Drag::of_plates(&workers, mesh.sites(), plate, crust, area, &table);
    for (i, drag) in drags.iter().enumerate() {
        torques[i].mantle_drag = drag.pull(&mantle, &recipe);
        system.add(i, i, drag.resistance(&recipe));
    }
    // What rifts ask for, where they are about to be drawn.
    let told = clock.reorganisation.due().is_some();
    let smooth = libm::pow(recipe.spacing_km() / STATED_SPACING, ROUGHNESS);
    let borne = workers.run(boundaries.fronts.chunks(FEW), |fronts| {
        // Fronts that follow each other mostly part the same plates.
        let runs = fronts.chunk_by(|a, b| a.plates == b.plates);
        let bear = |run| {
            bear(
                run, &recipe, &clock, &mantle, &table, &contacts, created, slab, smooth, told,
            )
        };
        // Each is large: a vector that grows would copy them over and over.
        let mut borne = Vec::with_capacity(runs.clone().count());
        borne.extend(runs.filter_map(bear));
        borne
    });
    let mut holds = Vec::new();
    for borne in borne.into_iter().flatten() {
        let [i, j] = borne.rows;
        torques[i] += borne.driven[0];
        torques[j] += borne.driven[1];
        system.couple(i, j, borne.coupling);
        system.add(i, i, borne.sinking[0]);
        system.add(j, j, borne.sinking[1]);
        holds.extend(borne.holds);
    }
    for (i, torque) in torques.iter().enumerate() {
        system.load(i, torque.sum() / recipe.radius_km);
    }
    let target = system.solve().ok_or(TectonicError::TorqueBalance {
        time_my: clock.time_my,
    })?;

    forces.0.clear();
    for Hold {
        front,
        rows,
        driven,
        resisting,
        sinking,
    } in holds
    {
        let turn = target[rows[0]] - target[rows[1]];
        let resisted: DVec3 = resisting
            .map(|(q, strength)| q * (strength * q.dot(turn)))
            .iter()
            .sum();
        for (end, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let (across, _) = resisting[1];
            let held = across * (sinking[end] * across.dot(target[rows[end]]));
            forces.0.push(FrontForce {
                plate: front.plates[end],
                place: front.midpoint,
                torque: driven[end].sum() + (resisted * sign - held) * recipe.radius_km,
            });
        }
    }

    let share = 1.0 - libm::exp(-clock.step_my / constants.response);
    for (row, plate) in table.rows().iter().enumerate() {
        if let Ok((_, _, mut rotation, _, mut torque)) = plates.get_mut(plate.entity) {
            rotation.0 = rotation.0.lerp(target[row], share);
            *torque = torques[row];
        }
    }
    Ok(())
}

/// What fronts that part the same two plates do to them.
struct Borne {
    rows: [usize; 2],
    driven: [DrivingTorque; 2],
    /// Resistance to the plates' turning against each other.
    coupling: DMat3,
    /// Resistance of the mantle to the slabs of either plate.
    sinking: [DMat3; 2],
    holds: Vec<Hold>,
}

/// The forces at one front.
struct Hold {
    front: Front,
    rows: [usize; 2],
    driven: [DrivingTorque; 2],
    /// Directions about which it resists, along and across it, and how strongly.
    resisting: [(DVec3, f64); 2],
    /// How strongly the mantle resists the slab of either plate, across it.
    sinking: [f64; 2],
}

/// Sums what fronts between two plates do to them, their lengths times `smooth`; none where a plate is gone. Keeps
/// each where it is `told`.
fn bear(
    run: &[Front],
    recipe: &Recipe,
    clock: &Clock,
    mantle: &Mantle,
    table: &PlateTable,
    contacts: &Contacts,
    created: &[Created],
    slab: &[Slab],
    smooth: f64,
    told: bool,
) -> Option<Borne> {
    let constants = &recipe.constants.motion;
    let [first, second] = run[0].plates;
    let rows = [table.row(first)?, table.row(second)?];
    let contact = contacts.get(first, second);
    let rift = contact.and_then(|contact| contact.rift);
    let mut borne = Borne {
        rows,
        driven: [DrivingTorque::default(); 2],
        coupling: DMat3::ZERO,
        sinking: [DMat3::ZERO; 2],
        holds: Vec::new(),
    };
    for front in run {
        let length = front.length * smooth;
        let held = rift.is_some_and(|rift| rift.holds(front, clock.time_my, recipe));
        let mut driven = if held {
            [DrivingTorque::default(); 2]
        } else {
            drive(front, recipe, clock, contact, created, slab)
        };
        let along = front.midpoint.cross(front.direction);
        let sliding = if held {
            constants.untorn
        } else {
            constants.friction
        };
        let sliding = (front.midpoint.cross(along), sliding * length);
        let across = if held {
            constants.untorn
        } else if front.opening >= 0.0 {
            0.0
        } else if front.continental {
            let depth = contact.map_or(0.0, |contact| {
                contact.interpenetration / constants.collision_length
            });
            constants.collision * (COLLISION_FIRST + depth.min(COLLISION_MOST))
        } else {
            constants.friction
        };
        let across = (along, across * length);
        for resistance in [sliding, across] {
            borne.coupling += about(resistance);
        }
        let mut sinking = [0.0; 2];
        if let Some(under) = front.under.filter(|_| !held) {
            let strength = constants.slab_resistance * hanging(front, under, recipe, slab) * length;
            let flow = mantle.flow(front.midpoint) * recipe.constants.mantle.slab_speed;
            driven[under].mantle_drag = along * (strength * flow.dot(front.direction));
            borne.sinking[under] += about((along, strength));
            sinking[under] = strength;
        }
        borne.driven[0] += driven[0];
        borne.driven[1] += driven[1];
        if told {
            borne.holds.push(Hold {
                front: *front,
                rows,
                driven,
                resisting: [sliding, across],
                sinking,
            });
        }
    }
    Some(borne)
}

/// Resistance, so strong, to turning about a direction.
fn about((q, strength): (DVec3, f64)) -> DMat3 {
    DMat3::from_cols(q * q.x, q * q.y, q * q.z) * strength
}

/// Share of a full slab that hangs where an end of a front goes under.
fn hanging(front: &Front, under: usize, recipe: &Recipe, slab: &[Slab]) -> f64 {
    let length = f64::from(slab[front.vertices[1 - under] as usize].0);
    (length / recipe.constants.motion.slab_full).min(1.0)
}

/// Torques of the driving forces of one front on its two plates.
fn drive(
    front: &Front,
    recipe: &Recipe,
    clock: &Clock,
    contact: Option<&Contact>,
    created: &[Created],
    slab: &[Slab],
) -> [DrivingTorque; 2] {
    let constants = &recipe.constants.motion;
    let turn = front.midpoint.cross(front.normal);
    let mut torques = [DrivingTorque::default(); 2];
    if front.opening > 0.0 {
        let young = contact
            .and_then(|contact| contact.rift)
            .is_some_and(|rift| clock.time_my - rift.began_my < constants.rift_push_time);
        let push = constants.ridge_push * (front.opening / RIDGE_FULL).min(1.0)
            + if young { constants.rift_push } else { 0.0 };
        torques[0].ridge_push = -turn * push;
        torques[1].ridge_push = turn * push;
    }
    if let Some(under) = front.under {
        let over = 1 - under;
        let age = clock.time_my - f64::from(created[front.vertices[under] as usize].0);
        let strength =
            (age.clamp(0.0, SLAB_OLDEST) / SLAB_AGE).sqrt() * hanging(front, under, recipe, slab);
        // Towards the trench, seen from each side.
        let towards = |end: usize| if end == 0 { turn } else { -turn };
        torques[under].slab_pull = towards(under) * (constants.slab_pull * strength);
        torques[over].slab_suction = towards(over) * (constants.slab_suction * strength);
    }
    torques
}

/// A dense symmetric system of three unknowns per plate, of which the lower half is kept.
struct System {
    size: usize,
    matrix: Vec<f64>,
    right: Vec<f64>,
}

impl System {
    fn new(plates: usize) -> Self {
        let size = 3 * plates;
        Self {
            size,
            matrix: vec![0.0; size * size],
            right: vec![0.0; size],
        }
    }

    /// Adds a block at the rows of plate `i` and the columns of plate `j`.
    fn add(&mut self, i: usize, j: usize, block: DMat3) {
        for column in 0..3 {
            for row in 0..3 {
                self.matrix[(3 * i + row) * self.size + 3 * j + column] += block.col(column)[row];
            }
        }
    }

    /// Adds `block (ωᵢ − ωⱼ)` to plate i and its reaction to plate j.
    fn couple(&mut self, i: usize, j: usize, block: DMat3) {
        self.add(i, i, block);
        self.add(j, j, block);
        self.add(i, j, -block);
        self.add(j, i, -block);
    }

    fn load(&mut self, i: usize, torque: DVec3) {
        for axis in 0..3 {
            self.right[3 * i + axis] += torque[axis];
        }
    }

    /// Cholesky: `L Lᵀ x = b`. None if the matrix is not positive definite or not finite.
    fn solve(mut self) -> Option<Vec<DVec3>> {
        let n = self.size;
        let a = &mut self.matrix;
        for i in 0..n {
            for j in 0..=i {
                let (row_i, row_j) = (i * n, j * n);
                let sum = a[row_i + j] - dot(&a[row_i..row_i + j], &a[row_j..row_j + j]);
                if i == j {
                    let definite = sum > 0.0 && sum.is_finite();
                    if !definite {
                        return None;
                    }
                    a[row_i + i] = sum.sqrt();
                } else {
                    a[row_i + j] = sum / a[row_j + j];
                }
            }
        }
        let x = &mut self.right;
        for i in 0..n {
            let mut sum = x[i];
            for k in 0..i {
                sum -= a[i * n + k] * x[k];
            }
            x[i] = sum / a[i * n + i];
        }
        for i in (0..n).rev() {
            let mut sum = x[i];
            for k in i + 1..n {
                sum -= a[k * n + i] * x[k];
            }
            x[i] = sum / a[i * n + i];
        }
        let finite = x.iter().all(|value| value.is_finite());
        finite.then(|| x.chunks_exact(3).map(DVec3::from_slice).collect())
    }
}

/// Scalar product in four sums side by side: one alone would wait for each addition.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, b) in a.0.iter().zip(b.0) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a.1.iter().zip(b.1).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_coupled_plates_balance() {
        let mut system = System::new(2);
        for i in 0..2 {
            system.add(i, i, DMat3::from_diagonal(DVec3::new(2.0, 3.0, 4.0)));
        }
        system.couple(0, 1, DMat3::from_diagonal(DVec3::Z * 4.0));
        system.load(0, DVec3::new(2.0, 3.0, 12.0));
        let x = system.solve().unwrap();
        // z: 4a + 4(a − b) = 12 and 4b + 4(b − a) = 0 give a = 2, b = 1.
        assert!((x[0] - DVec3::new(1.0, 1.0, 2.0)).length() < 1e-12);
        assert!((x[1] - DVec3::new(0.0, 0.0, 1.0)).length() < 1e-12);
    }

    #[test]
    fn a_singular_system_has_no_solution() {
        let mut system = System::new(1);
        system.load(0, DVec3::X);
        assert!(system.solve().is_none());
    }
}
