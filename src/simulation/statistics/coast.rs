//! How rough the coast is.

use super::{View, line_slope};
use glam::DVec3;

/// Box sizes in spacings of the sub-plates. From finer ones every coast looks straight, being made of
/// straight pieces; in coarser ones whole continents fit. Over this range smooth caps give 1.0 and
/// Earth 1.2 at any number of sub-plates from 2,500 to 160,000 (measured on ETOPO1).
const FINEST: f64 = 1.5;
const COARSEST: f64 = 6.0;
const SIZES: usize = 6;
/// Counts are means over grids shifted by these shares of a box, so that no coast happens to lie well.
const SHIFTS: [f64; 3] = [0.0, 0.37, 0.71];
/// Points on each piece of coast: closer than a quarter of the smallest box.
const POINTS: u32 = 5;
/// Fewer boxes than this tell no dimension.
const FEWEST_BOXES: f64 = 8.0;

/// Box dimension of the coast: how fast the number of boxes that it crosses grows as boxes shrink.
/// The coast is where elevation, linear in every triangle of the mesh, is 0. Boxes are cubes in space,
/// which know no poles.
pub(super) fn dimension(view: &View) -> f64 {
    let coast = trace(view);
    let spacing = (4.0 * core::f64::consts::PI / view.share.len().max(1) as f64).sqrt();
    let ratio = libm::pow(COARSEST / FINEST, 1.0 / (SIZES - 1) as f64);
    let mut size = FINEST * spacing;
    let mut points = [[0.0; 3]; SIZES];
    for point in &mut points {
        let mean = SHIFTS
            .iter()
            .map(|&shift| boxes(&coast, size, shift) as f64)
            .sum::<f64>()
            / SHIFTS.len() as f64;
        if mean < FEWEST_BOXES {
            return 0.0;
        }
        *point = [libm::log(size), libm::log(mean), 1.0];
        size *= ratio;
    }
    -line_slope(points.into_iter())
}

/// Points along the coast.
fn trace(view: &View) -> Vec<DVec3> {
    let mesh = view.mesh;
    let mut points = Vec::new();
    for h in mesh.triangles() {
        let corners = mesh.triangle_vertices(h);
        let dry = corners.map(|v| view.elevation[v as usize].0 > 0.0);
        // The corner that is on a side of its own.
        let Some(lone) = (0..3).find(|&i| dry[i] != dry[(i + 1) % 3] && dry[i] != dry[(i + 2) % 3])
        else {
            continue;
        };
        let [from, to] = [1, 2].map(|next| {
            let [a, b] = [corners[lone], corners[(lone + next) % 3]];
            let [low, high] = [a, b].map(|v| view.elevation(v as usize));
            // Not through a corner, where pieces of coast would shrink to nothing.
            let along = (low / (low - high)).clamp(0.05, 0.95);
            mesh.site(a).lerp(mesh.site(b), along)
        });
        points.extend((0..POINTS).map(|i| from.lerp(to, f64::from(i) / f64::from(POINTS - 1))));
    }
    points
}

/// Number of boxes that hold a point.
fn boxes(points: &[DVec3], size: f64, shift: f64) -> usize {
    let mut boxes: Vec<[i32; 3]> = points
        .iter()
        .map(|point| (*point / size + shift).floor().as_ivec3().to_array())
        .collect();
    // Neighbours along the coast mostly share a box.
    boxes.dedup();
    boxes.sort_unstable();
    boxes.dedup();
    boxes.len()
}
