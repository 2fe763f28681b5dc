//! The ground between three sub-plates, and the terrain on it.

use crate::simulation::{Crust, Orogeny, Surface};

/// Land at the foot of a shelf's outer slope, metres: where a continent's margin ends.
const SHELF_EDGE_M: f32 = -130.0;
/// Share of continental weight over which the ocean's depth gives way to the continent's height.
const SLOPE: (f32, f32) = (0.25, 0.65);
/// Height of terrain detail at most, as a share of the land's height.
const ROUGHNESS: (f32, f32) = (0.03, 0.12);
/// Height of abyssal hills on new sea floor, metres.
const HILLS_M: f32 = 70.0;
/// Time in which sediment buries abyssal hills, My.
const BURIAL_MY: f32 = 60.0;
/// Time over which an inactive mountain belt loses its roughness, My.
const SMOOTHING_MY: f32 = 120.0;

/// What the ground around a sub-plate depends on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    pub land: bool,
    pub elevation: f32,
    pub age: f32,
    /// Roughness of a mountain belt, 1 while it grows, 0 where there is none.
    pub youth: f32,
}

impl Corner {
    pub(crate) fn of(surface: &Surface, vertex: usize) -> Self {
        Self {
            land: surface.crust[vertex] == Crust::Continental,
            elevation: surface.elevation[vertex],
            age: surface.age[vertex],
            youth: if surface.orogeny[vertex] == Orogeny::None {
                0.0
            } else {
                libm::expf(-surface.orogeny_age[vertex].max(0.0) / SMOOTHING_MY)
            },
        }
    }
}

/// The interpolated planet, before terrain is added.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ground {
    pub elevation: f32,
    pub continental: f32,
    pub age: f32,
    /// Age of the sea floor among the corners; 0 where there is none.
    pub floor_age: f32,
    pub rugged: f32,
}

impl Ground {
    /// Interpolates between the corners of a triangle.
    pub(crate) fn between(corners: [Corner; 3], weights: [f64; 3]) -> Self {
        let (mut land, mut sea) = (Blend::default(), Blend::default());
        let mut rugged = 0.0;
        for (corner, weight) in corners.into_iter().zip(weights) {
            let weight = (weight as f32).clamp(0.0, 1.0);
            let blend = if corner.land { &mut land } else { &mut sea };
            blend.add(weight, corner.elevation, corner.age);
            rugged += weight * corner.youth;
        }
        let continental = land.weight / (land.weight + sea.weight);
        let (shore, depth) = (land.elevation(), sea.elevation());
        let elevation = match (shore, depth) {
            (Some(height), None) => height,
            (None, Some(depth)) => depth,
            (Some(height), Some(depth)) => {
                let inland = ramp(SLOPE.1, 1.0, continental);
                let height = if height > SHELF_EDGE_M {
                    SHELF_EDGE_M + (height - SHELF_EDGE_M) * inland
                } else {
                    height
                };
                depth + (height - depth) * smooth(ramp(SLOPE.0, SLOPE.1, continental))
            }
            (None, None) => 0.0,
        };
        let age = if continental >= 0.5 {
            land.age()
        } else {
            sea.age()
        };
        Self {
            elevation,
            continental,
            age: age.unwrap_or(0.0),
            floor_age: sea.age().unwrap_or(0.0),
            rugged,
        }
    }

    /// Adds terrain to the interpolated elevation; returns it with the detail's own value for shading.
    pub(crate) fn detail(
        &self,
        terrain: impl FnOnce() -> f32,
        hills: impl FnOnce() -> f32,
    ) -> (f32, f32) {
        let height = self.elevation;
        if height > 0.0 {
            let mountain = smooth(ramp(300.0, 2500.0, height)).max(self.rugged.min(1.0));
            let rough = ROUGHNESS.0 + (ROUGHNESS.1 - ROUGHNESS.0) * mountain;
            let grain = terrain();
            (height * (1.0 + rough * grain), grain)
        } else {
            let young = libm::expf(-self.floor_age / BURIAL_MY) * (1.0 - self.continental);
            let deep = smooth(ramp(-600.0, -2000.0, height));
            // Next to nothing is nothing, without a step.
            let share = (young * deep - 0.01).max(0.0);
            let grain = if share > 0.0 { share * hills() } else { 0.0 };
            (height + HILLS_M * grain, grain)
        }
    }
}

/// A weighted mean over the vertices of one kind of crust.
#[derive(Default)]
struct Blend {
    weight: f32,
    elevation: f32,
    age: f32,
}

impl Blend {
    fn add(&mut self, weight: f32, elevation: f32, age: f32) {
        self.weight += weight;
        self.elevation += weight * elevation;
        self.age += weight * age;
    }

    fn elevation(&self) -> Option<f32> {
        (self.weight > 0.0).then(|| self.elevation / self.weight)
    }

    fn age(&self) -> Option<f32> {
        (self.weight > 0.0).then(|| self.age / self.weight)
    }
}

/// 0 at `from`, 1 at `to`, linear between, constant beyond.
pub(crate) fn ramp(from: f32, to: f32, value: f32) -> f32 {
    ((value - from) / (to - from)).clamp(0.0, 1.0)
}

/// Eases a 0–1 ramp in and out.
pub(crate) fn smooth(t: f32) -> f32 {
    t * t * (3.0 - 2.0 * t)
}
