//! How plates have turned over time, for programs that take a planet back through its history.

use super::{
    clock::Clock,
    plate::{Plate, Rotation},
    schedule::{TectonicStep, TectonicSystems, going},
    surface::Surface,
};
use bevy::prelude::*;
use glam::{DQuat, DVec3};
use std::collections::BTreeMap;

/// Time over which [`RotationHistory::of`] a moment reaches back, in My.
const MOMENT_MY: f64 = 1.0;

/// Keeps a [`RotationHistory`] as a resource of the simulation's world.
///
/// ```
/// use bevy::app::PluginGroup;
/// use bevy_tectonics::prelude::*;
/// use bevy_tectonics::simulation::{RotationHistory, RotationHistoryPlugin};
/// use core::ops::ControlFlow;
///
/// let plugins = SimulationPlugins.build().add(RotationHistoryPlugin { interval_my: 1.0 });
/// let recipe = Recipe::earth_like(7).with_sub_plates(500);
/// let mut history = History::with_plugins(recipe, plugins)?;
/// history.run_until(3.0, |_| ControlFlow::Continue(()))?;
/// let rotations = history.world_mut().resource::<RotationHistory>();
/// assert!(rotations.plates().all(|plate| plate.totals.len() >= 2));
/// # Ok::<(), TectonicError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct RotationHistoryPlugin {
    /// Time between the rotations that are kept, in My. What is no positive number keeps only the first
    /// and the last.
    pub interval_my: f64,
}

impl Plugin for RotationHistoryPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(RotationHistory::new(self.interval_my))
            .add_systems(
                TectonicStep,
                record
                    .run_if(going)
                    .after(TectonicSystems::Move)
                    .before(TectonicSystems::Uplift)
                    // Whatever a game runs without saying when may be seen or not.
                    .ambiguous_with_all(),
            );
    }
}

/// How plates have turned since they were first seen. It grows with a [`RotationHistoryPlugin`], changes
/// nothing about the planet and is no part of saves.
#[derive(Resource, Debug, Clone, Default, PartialEq)]
pub struct RotationHistory {
    interval_my: f64,
    now_my: f64,
    plates: BTreeMap<u16, Turning>,
}

/// A plate's way: its orientations at moments, in My, beginning with none.
#[derive(Debug, Clone, PartialEq)]
struct Turning {
    moments: Vec<(f64, DQuat)>,
    seen_my: f64,
    orientation: DQuat,
}

/// The rotations of a plate, the latest first.
#[derive(Debug, Clone, PartialEq)]
pub struct PlateRotations {
    /// Its id.
    pub id: u16,
    /// Back to when it came to be, or to when the record begins. The first is none, at age 0.
    pub totals: Vec<TotalRotation>,
}

/// The rotation that takes a plate from where it is back to where it was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TotalRotation {
    /// Time before the last moment in My.
    pub age_my: f64,
    /// The pole's direction with the angle in radians as its length, in the planet's frame.
    pub rotation: DVec3,
}

impl RotationHistory {
    fn new(interval_my: f64) -> Self {
        Self {
            interval_my,
            ..Self::default()
        }
    }

    /// As if the plates of a surface had turned for the last My as they do now.
    #[must_use]
    pub fn of(surface: &Surface) -> Self {
        let mut history = Self::default();
        let now = surface.time_my;
        let turns: BTreeMap<u16, DVec3> = surface.rotations.iter().copied().collect();
        history.turn(now - MOMENT_MY, now, turns.into_iter());
        history
    }

    /// The same with every plate of a surface: one that came to be at the end of the last step has not
    /// turned yet.
    #[must_use]
    pub fn completed(&self, surface: &Surface) -> Self {
        let mut history = self.clone();
        history.now_my = history.now_my.max(surface.time_my);
        let resting = surface.rotations.iter().map(|&(id, _)| id);
        for id in resting {
            history.plates.entry(id).or_insert_with(|| Turning {
                moments: Vec::new(),
                seen_my: history.now_my,
                orientation: DQuat::IDENTITY,
            });
        }
        history
    }

    /// Time of the last moment in My.
    #[must_use]
    pub fn now_my(&self) -> f64 {
        self.now_my
    }

    /// Every plate that was ever seen, in the order of ids. One that is no more rests from its end on.
    pub fn plates(&self) -> impl Iterator<Item = PlateRotations> {
        self.plates.iter().map(|(&id, turning)| {
            let back = turning.orientation.inverse();
            let last = (turning.seen_my, turning.orientation);
            let mut totals = Vec::with_capacity(turning.moments.len() + 2);
            if turning.seen_my < self.now_my {
                totals.push(TotalRotation {
                    age_my: 0.0,
                    rotation: DVec3::ZERO,
                });
            }
            let moments = turning.moments.iter().rev();
            let earlier = moments.filter(|moment| moment.0 < turning.seen_my);
            for (time_my, orientation) in [&last].into_iter().chain(earlier) {
                totals.push(TotalRotation {
                    age_my: self.now_my - time_my,
                    rotation: if *time_my < turning.seen_my {
                        (*orientation * back).to_scaled_axis()
                    } else {
                        DVec3::ZERO
                    },
                });
            }
            PlateRotations { id, totals }
        })
    }

    /// Turns plates, by id and angular velocity in rad/My, from one time to another.
    fn turn(&mut self, from_my: f64, to_my: f64, plates: impl Iterator<Item = (u16, DVec3)>) {
        let number = |time_my: f64| (time_my / self.interval_my).floor();
        let is_due = number(to_my) > number(from_my);
        self.now_my = to_my;
        for (id, rotation) in plates {
            let turning = self.plates.entry(id).or_insert_with(|| Turning {
                moments: vec![(from_my, DQuat::IDENTITY)],
                seen_my: from_my,
                orientation: DQuat::IDENTITY,
            });
            let turn = DQuat::from_scaled_axis(rotation * (to_my - from_my));
            turning.orientation = (turn * turning.orientation).normalize();
            turning.seen_my = to_my;
            if is_due {
                turning.moments.push((to_my, turning.orientation));
            }
        }
    }
}

fn record(
    clock: Res<Clock>,
    plates: Query<(&Plate, &Rotation)>,
    mut history: ResMut<RotationHistory>,
) {
    let turns = plates
        .iter()
        .map(|(plate, rotation)| (plate.id.0, rotation.0));
    history.turn(clock.began_my, clock.time_my, turns);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn totals_lead_back_the_way_plates_came() {
        let mut history = RotationHistory::new(2.0);
        let (first, second) = (DVec3::new(0.0, 0.0, 0.1), DVec3::new(0.05, 0.0, 0.0));
        for step in 0..6 {
            let time = f64::from(step);
            let spin = if step < 3 { first } else { second };
            // The other plate is born later, the third is gone early.
            let other = (step >= 2).then_some((9, second));
            let third = (step < 4).then_some((4, first));
            let plates = [Some((7, spin)), other, third].into_iter().flatten();
            history.turn(time, time + 1.0, plates);
        }
        let ages = |id| -> Vec<f64> {
            let plate = history.plates().find(|plate| plate.id == id).unwrap();
            plate.totals.iter().map(|total| total.age_my).collect()
        };
        assert_eq!(ages(7), [0.0, 2.0, 4.0, 6.0]);
        assert_eq!(ages(9), [0.0, 2.0, 4.0]);
        assert_eq!(ages(4), [0.0, 2.0, 4.0, 6.0]);

        let plates: Vec<PlateRotations> = history.plates().collect();
        assert_eq!(plates.iter().map(|p| p.id).collect::<Vec<_>>(), [4, 7, 9]);
        let total = |row: usize, i: usize| plates[row].totals[i].rotation;
        let close = |a: DVec3, b: DVec3| assert!(a.distance(b) < 1e-12, "{a} {b}");
        close(total(0, 0), DVec3::ZERO);
        close(total(0, 1), DVec3::ZERO);
        close(total(0, 3), -4.0 * first);
        close(total(1, 0), DVec3::ZERO);
        close(total(1, 1), -2.0 * second);
        // From now back to the start: first undo the later motion, then the earlier one.
        let start = DQuat::from_scaled_axis(-3.0 * first) * DQuat::from_scaled_axis(-3.0 * second);
        close(total(1, 3), start.to_scaled_axis());
    }
}
