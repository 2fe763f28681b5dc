//! Overlays as colours of texels.

use super::walk::mean;
use crate::{
    simulation::Surface,
    surface::{Overlay, OverlayValues, Pixel},
};
use std::sync::Arc;

/// Everything about one place that an overlay may want to know.
pub(super) struct Sample {
    /// The sub-plates around it.
    pub vertices: [u32; 3],
    /// Their weights; the sum is 1.
    pub weights: [f64; 3],
    /// The sub-plate whose plate it belongs to.
    pub nearest: u32,
    /// The planet there, as [`Raster`](crate::surface::Raster) samples it.
    pub pixel: Pixel,
}

/// Colours a place: sRGB and opacity.
pub(super) type Paint = Arc<dyn Fn(&Surface, &Sample) -> [u8; 4] + Send + Sync>;

/// Colours of an overlay that fills the planet; none for those that are drawn as lines or arrows.
pub(super) fn paint(overlay: Overlay) -> Option<Paint> {
    match overlay {
        Overlay::Boundaries | Overlay::Velocity => None,
        _ => Some(Arc::new(move |surface, sample| {
            overlay.color(&values(surface, sample))
        })),
    }
}

/// What overlays want to know. Kinds are those of the nearest sub-plate: there is nothing between two.
fn values(surface: &Surface, sample: &Sample) -> OverlayValues {
    let mean = |column: &[f32]| mean(sample.vertices, sample.weights, |v| column[v]);
    let (mut nearest, mut most) = (sample.vertices[0], 0.0);
    for (vertex, weight) in sample.vertices.into_iter().zip(sample.weights) {
        if weight > most {
            (nearest, most) = (vertex, weight);
        }
    }
    OverlayValues {
        elevation: sample.pixel.elevation,
        crust: sample.pixel.crust,
        age: sample.pixel.age,
        plate: sample.pixel.plate,
        thickness: mean(&surface.thickness),
        speed: surface.velocity[sample.nearest as usize].length(),
        orogeny: surface.orogeny[nearest as usize],
        orogeny_age: mean(&surface.orogeny_age),
    }
}
