//! The sea: a fixed volume of water over changing ground.

use super::{sub_plate::MaterialArea, workers::Workers};
use bevy::prelude::*;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Water of the planet, and where its surface stands.
#[derive(Resource, Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, Reflect)]
#[reflect(Resource)]
pub struct Sea {
    /// Volume of water as a mean depth over the whole sphere, in m. Kept for ever once set.
    pub mean_depth: f64,
    /// Height of the surface in m above the reference level of isostasy.
    pub level: f64,
}

impl Sea {
    /// The sea that leaves a share of the surface dry.
    pub(crate) fn for_land_share(heights: &[f64], area: &[MaterialArea], land_share: f64) -> Self {
        let mut order: Vec<usize> = (0..heights.len()).collect();
        order.sort_by(|&a, &b| heights[b].total_cmp(&heights[a]).then(a.cmp(&b)));
        let whole: f64 = area.iter().map(|area| area.0).sum();
        let mut dry = 0.0;
        let mut level = heights.iter().copied().fold(f64::MIN, f64::max) + 1.0;
        for v in order {
            level = heights[v];
            dry += area[v].0;
            if dry > land_share * whole {
                break;
            }
        }
        Self::at_level(heights, area, level)
    }

    /// The sea whose surface stands at a level in m above the reference level.
    pub(crate) fn at_level(heights: &[f64], area: &[MaterialArea], level: f64) -> Self {
        let mut sea = Self {
            mean_depth: 0.0,
            level,
        };
        sea.mean_depth = sea.depth_at(&Workers::default(), level, heights, area).0;
        sea
    }

    /// Mean depth in m over the sphere if the surface stood at `level`, and the share that is wet.
    fn depth_at(
        &self,
        workers: &Workers,
        level: f64,
        heights: &[f64],
        area: &[MaterialArea],
    ) -> (f64, f64) {
        let parts = workers.map(heights.len(), |rows| {
            let (mut volume, mut wet, mut whole) = (0.0, 0.0, 0.0);
            for (height, area) in heights[rows.clone()].iter().zip(&area[rows]) {
                whole += area.0;
                if *height < level {
                    volume += (level - height) * area.0;
                    wet += area.0;
                }
            }
            DVec3::new(volume, wet, whole)
        });
        let sum: DVec3 = parts.into_iter().sum();
        (sum.x / sum.z, sum.y / sum.z)
    }

    /// Finds the level at which the water fits, given the height of every sub-plate in m above the
    /// reference level and its area. Elevations are those heights less the new
    /// [`level`](Self::level).
    ///
    /// Newton's method on a convex, increasing function: from any start it is on the safe side after
    /// one step.
    pub fn settle(&mut self, heights: &[f64], area: &[MaterialArea]) {
        self.settle_on(&Workers::default(), heights, area);
    }

    /// [`settle`](Self::settle) on several threads.
    pub(super) fn settle_on(&mut self, workers: &Workers, heights: &[f64], area: &[MaterialArea]) {
        for _ in 0..32 {
            let (depth, wet) = self.depth_at(workers, self.level, heights, area);
            let step = (self.mean_depth - depth) / wet.max(1e-3);
            self.level += step;
            if step.abs() < 1e-6 {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn water_keeps_its_volume_when_the_ground_rises() {
        let area = [MaterialArea(1.0); 4];
        let mut sea = Sea::for_land_share(&[-4000.0, -4000.0, -100.0, 500.0], &area, 0.25);
        let depth = sea.mean_depth;
        let raised = [-4000.0, -2000.0, -100.0, 500.0];
        sea.settle(&raised, &area);
        assert!(
            (sea.depth_at(&Workers::default(), sea.level, &raised, &area)
                .0
                - depth)
                .abs()
                < 1e-3
        );
        assert!(sea.level > 0.0);
    }
}
