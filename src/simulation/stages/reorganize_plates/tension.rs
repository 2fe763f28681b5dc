//! Whether a plate would open along a cut.
//!
//! Each piece is let go: all that acts on it, the forces at its fronts and the mantle's flow at its
//! roots, is balanced against its own drag, `D ω = T`, with the resistance of its neighbours as it is
//! now. What the cut would open is under tension.

use super::{
    super::{
        super::{
            boundaries::{Front, FrontForces},
            plate::PlateRow,
            recipe::Recipe,
            sub_plate::{Crust, MaterialArea},
            topology::EdgeState,
        },
        Mantle,
        apply_forces::drag::Drag,
    },
    cut::Cut,
};
use crate::mesh::SphereMesh;
use glam::DVec3;

/// What pulls and presses at a plate.
pub(super) struct Tension<'a> {
    pub recipe: &'a Recipe,
    pub mesh: &'a SphereMesh<EdgeState>,
    pub mantle: &'a Mantle,
    pub forces: &'a FrontForces,
    pub crust: &'a [Crust],
    pub area: &'a [MaterialArea],
}

/// How two pieces would part.
pub(super) struct Parting {
    pub pieces: [usize; 2],
    /// Mean opening speed along their cut in km/My; negative where they would close.
    pub opening: f64,
}

impl Tension<'_> {
    /// Joins pieces that would close rather than part until all that is left would open.
    pub fn keep_what_opens(&self, plate: &PlateRow, cut: &mut Cut) {
        while cut.pieces.len() > 1 {
            let worst = self
                .partings(plate, cut)
                .into_iter()
                .min_by(|a, b| a.opening.total_cmp(&b.opening));
            let Some(closing) = worst.filter(|worst| worst.opening <= 0.0) else {
                return;
            };
            let [kept, joined] = closing.pieces;
            cut.join(kept, joined);
        }
    }

    /// How the neighbouring pieces of a cut through a plate would part, by the pairs' numbers. Empty
    /// where no forces are known: plates of other drives break as chance has it.
    pub fn partings(&self, plate: &PlateRow, cut: &Cut) -> Vec<Parting> {
        if self.forces.0.is_empty() {
            return Vec::new();
        }
        let count = cut.pieces.len();
        let mut drag = vec![Drag::NONE; count];
        for (drag, members) in drag.iter_mut().zip(&cut.pieces) {
            for &v in members {
                drag.add(self.crust[v], self.area[v], self.mesh.site(v as u32));
            }
        }
        let mut torque: Vec<DVec3> = drag
            .iter()
            .map(|drag| drag.pull(self.mantle, self.recipe))
            .collect();
        for force in self.forces.0.iter().filter(|force| force.plate == plate.id) {
            torque[cut.piece_at(force.place)] += force.torque;
        }
        let fronts = cut.fronts(self.mesh, self.recipe.radius_km);
        let rotation: Vec<DVec3> = drag
            .iter()
            .zip(torque)
            .map(|(drag, torque)| {
                drag.resistance(self.recipe).inverse() * torque / self.recipe.radius_km
            })
            .collect();
        self.mean_openings(&fronts, &rotation)
    }

    fn mean_openings(&self, fronts: &[([usize; 2], Front)], rotation: &[DVec3]) -> Vec<Parting> {
        let count = rotation.len();
        let mut sums = vec![(0.0, 0.0); count * count];
        for ([a, b], front) in fronts {
            let slip = (rotation[*b] - rotation[*a]).cross(front.midpoint) * self.recipe.radius_km;
            // Normals point from the first piece to the second.
            let (pair, volume) = (a.min(b) * count + a.max(b), slip.dot(front.normal));
            sums[pair].0 += volume;
            sums[pair].1 += front.length;
        }
        (0..count * count)
            .filter(|&pair| sums[pair].1 > 0.0)
            .map(|pair| Parting {
                pieces: [pair / count, pair % count],
                opening: sums[pair].0 / sums[pair].1,
            })
            .collect()
    }
}
