//! How the mantle drags at plates: at rest it resists them, and its flow pulls at continents' roots.

use super::{
    super::super::{
        plate::PlateTable,
        recipe::Recipe,
        sub_plate::{Crust, MaterialArea, PlateId},
        workers::Workers,
    },
    mantle::Mantle,
};
use glam::{DMat3, DVec3};

/// Added to each plate's drag, as a share of its trace: a plate of a few cells cannot balance its
/// spin about its own centre.
const SPIN_DRAG: f64 = 0.02;

/// Moments of areas: their sum, and those times the place once and twice.
#[derive(Debug, Clone, Copy)]
struct Moments {
    zeroth: f64,
    first: DVec3,
    second: DMat3,
}

impl Moments {
    const NONE: Self = Self {
        zeroth: 0.0,
        first: DVec3::ZERO,
        second: DMat3::ZERO,
    };

    fn add(&mut self, area: f64, site: DVec3) {
        let weighted = site * area;
        self.zeroth += area;
        self.first += weighted;
        self.second.x_axis += weighted * site.x;
        self.second.y_axis += weighted * site.y;
        self.second.z_axis += weighted * site.z;
    }

    fn join(&mut self, other: &Self) {
        self.zeroth += other.zeroth;
        self.first += other.first;
        self.second += other.second;
    }

    /// `Σ a (I − r rᵀ)`.
    fn resistance(&self) -> DMat3 {
        DMat3::IDENTITY * self.zeroth - self.second
    }
}

/// What drags at a plate, or at a piece of one.
#[derive(Debug, Clone, Copy)]
pub(in crate::simulation) struct Drag {
    floor: Moments,
    roots: Moments,
}

impl Drag {
    pub(in crate::simulation) const NONE: Self = Self {
        floor: Moments::NONE,
        roots: Moments::NONE,
    };

    /// Adds a sub-plate.
    pub(in crate::simulation) fn add(&mut self, crust: Crust, area: MaterialArea, site: DVec3) {
        if crust.is_continental() {
            self.roots.add(area.0, site);
        } else {
            self.floor.add(area.0, site);
        }
    }

    fn join(&mut self, other: &Self) {
        self.floor.join(&other.floor);
        self.roots.join(&other.roots);
    }

    /// Torque per angular velocity, `Σ c a (I − r rᵀ)`, for a sphere of radius 1. Never singular.
    pub(in crate::simulation) fn resistance(&self, recipe: &Recipe) -> DMat3 {
        let constants = &recipe.constants.motion;
        let drag = self.floor.resistance() * constants.ocean_drag
            + self.roots.resistance() * constants.continent_drag;
        let spin = SPIN_DRAG * (drag.x_axis.x + drag.y_axis.y + drag.z_axis.z);
        drag + DMat3::from_diagonal(DVec3::splat(spin.max(1.0)))
    }

    /// Torque of the mantle's flow.
    pub(in crate::simulation) fn pull(&self, mantle: &Mantle, recipe: &Recipe) -> DVec3 {
        mantle.torque(self.roots.first, self.roots.second)
            * (recipe.constants.motion.continent_drag * recipe.constants.mantle.speed)
    }

    /// What drags at every plate of a table.
    pub(in crate::simulation) fn of_plates(
        workers: &Workers,
        sites: &[DVec3],
        plate: &[PlateId],
        crust: &[Crust],
        area: &[MaterialArea],
        table: &PlateTable,
    ) -> Vec<Self> {
        let parts = workers.map(plate.len(), |range| {
            // One more for what no plate carries.
            let mut sums = vec![Self::NONE; table.rows().len() + 1];
            let (mut of, mut run) = (plate[range.start], Self::NONE);
            let mut close = |of, run: Self| {
                sums[table.row(of).unwrap_or(table.rows().len())].join(&run);
            };
            // Neighbours in memory nearly always lie on one plate.
            for v in range {
                if plate[v] != of {
                    close(of, core::mem::replace(&mut run, Self::NONE));
                    of = plate[v];
                }
                run.add(crust[v], area[v], sites[v]);
            }
            close(of, run);
            sums
        });
        // Added up in the order of the rows, whoever summed them.
        let mut sums = vec![Self::NONE; table.rows().len()];
        for part in parts {
            for (sum, part) in sums.iter_mut().zip(part) {
                sum.join(&part);
            }
        }
        sums
    }
}
