//! The climate of a place, as far as colours want to know it.

use crate::{
    simulation::Surface,
    surface::{
        ground::{ramp, smooth},
        tint::Climate,
    },
};

/// Distance from the sea over which climates turn dry, in km.
const INTERIOR_KM: (f32, f32) = (300.0, 1500.0);

/// Aridity, latitude of the climate in degrees, and variety from −1 to 1. `wander` and `terrain` are
/// noise from −1 to 1.
pub(super) fn climate(latitude: f32, interior: f32, wander: f32, terrain: f32) -> [f32; 3] {
    let climate = Climate::at(latitude, wander);
    // Far inland it is dry outside the tropics too, and coasts of the dry belts are less so.
    let temperate = smooth(ramp(8.0, 22.0, climate.latitude))
        * (1.0 - smooth(ramp(40.0, 56.0, climate.latitude)));
    let arid = climate.arid * (0.62 + 0.6 * interior) + 0.75 * interior * temperate;
    // Ridges are greener than the plains beside them: climates have ragged edges.
    let arid = smooth(ramp(0.15, 0.85, arid - 0.17 * terrain));
    let variety = (0.7 * terrain + 0.5 * wander).clamp(-1.0, 1.0);
    [arid, climate.latitude, variety]
}

/// How far each sub-plate lies inland, 0 to 1.
pub(super) fn interior(surface: &Surface) -> Vec<f32> {
    let mesh = &surface.mesh;
    let spacing = surface.spacing_km() as f32;
    let mut steps = vec![u16::MAX; mesh.vertex_count()];
    let mut front: Vec<u32> = (0..mesh.vertex_count() as u32)
        .filter(|&vertex| surface.elevation[vertex as usize] < 0.0)
        .collect();
    for &vertex in &front {
        steps[vertex as usize] = 0;
    }
    let mut distance = 0_u16;
    while !front.is_empty() && distance < u16::MAX - 1 {
        distance += 1;
        let mut next = Vec::new();
        for &vertex in &front {
            for neighbour in mesh.neighbours(vertex) {
                if steps[neighbour as usize] == u16::MAX {
                    steps[neighbour as usize] = distance;
                    next.push(neighbour);
                }
            }
        }
        front = next;
    }
    // A step of the front leads a little less far than the spacing.
    let inland = |steps: u16| {
        ramp(
            INTERIOR_KM.0,
            INTERIOR_KM.1,
            0.9 * spacing * f32::from(steps),
        )
    };
    let mut interior: Vec<f32> = steps
        .into_iter()
        .map(|steps| smooth(inland(steps)))
        .collect();
    for _ in 0..4 {
        interior = (0..mesh.vertex_count() as u32)
            .map(|vertex| {
                let (mut sum, mut count) = (interior[vertex as usize], 1.0);
                for neighbour in mesh.neighbours(vertex) {
                    sum += interior[neighbour as usize];
                    count += 1.0;
                }
                sum / count
            })
            .collect();
    }
    interior
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::{History, Recipe};

    #[test]
    fn interiors_are_inland_and_drier() {
        let recipe = Recipe::earth_like(3).with_sub_plates(2000);
        let surface = History::with_threads(recipe, 1).unwrap().surface().unwrap();
        let interior = interior(&surface);
        assert!(interior.iter().all(|share| (0.0..=1.0).contains(share)));
        let most = interior.iter().copied().fold(0.0, f32::max);
        assert!(most > 0.5, "{most}");
        // A small sea within a continent counts as inland: its shores are as dry.
        let mean = |land: bool| {
            let shares = interior.iter().zip(&surface.elevation);
            let shares = shares.filter(|(_, elevation)| (**elevation > 0.0) == land);
            let (sum, count) = shares.fold((0.0, 0.0), |(sum, count), (share, _)| {
                (sum + share, count + 1.0)
            });
            sum / f32::max(count, 1.0)
        };
        assert!(
            mean(true) > 3.0 * mean(false),
            "{} {}",
            mean(true),
            mean(false)
        );
        let [coast, ..] = climate(40.0, 0.0, 0.0, 0.0);
        let [inland, ..] = climate(40.0, 1.0, 0.0, 0.0);
        assert!(inland > coast);
    }
}
