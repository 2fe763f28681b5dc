//! Slabs: how much crust hangs beneath each overriding front.

use super::super::super::{
    boundaries::Boundaries,
    clock::Clock,
    columns::Columns,
    error::TectonicError,
    recipe::Recipe,
    sub_plate::{Slab, SubPlate},
    topology::Topology,
    workers::{CHUNK, Workers},
};
use bevy::prelude::*;

/// Slab that hangs from the start where random plates happen to converge, in km. Without it the
/// first 30 My stand nearly still.
const FIRST_SLAB: f32 = 400.0;

/// Lengthens slabs where sea floor goes under, and lets the others decay.
pub(in crate::simulation) fn grow_slabs(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    workers: Res<Workers>,
    boundaries: Res<Boundaries>,
    topology: Res<Topology>,
    mut sub_plates: Query<&mut Slab, With<SubPlate>>,
) -> Result<(), TectonicError> {
    let mut slab = sub_plates.columns(topology.0.vertex_count())?;
    let slab = slab.bypass_change_detection();
    let constants = &recipe.constants.motion;
    let kept = libm::exp(-clock.step_my / constants.slab_decay) as f32;
    workers.run(slab.chunks_mut(CHUNK), |slabs| {
        for slab in slabs.iter_mut().filter(|slab| slab.0 > 0.0) {
            slab.0 = if slab.0 < 0.1 { 0.0 } else { slab.0 * kept };
        }
    });
    // Several edges meet at a front's vertex: the fastest feeds its slab.
    let mut fed: Vec<(u32, f64)> = boundaries
        .fronts
        .iter()
        .filter_map(|front| {
            let under = front.under?;
            (front.opening < 0.0).then(|| (front.vertices[1 - under], -front.opening))
        })
        .collect();
    fed.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    fed.dedup_by_key(|(vertex, _)| *vertex);
    for (vertex, closing) in fed {
        let slab = &mut slab[vertex as usize].0;
        let fresh = (constants.slab_growth * closing * clock.step_my) as f32;
        // Growth works against the decay of what is fed: a fed slab keeps its length.
        *slab = (*slab / kept + fresh).min(constants.slab_longest as f32);
        if clock.steps == 1 {
            *slab = slab.max(FIRST_SLAB);
        }
    }
    Ok(())
}
