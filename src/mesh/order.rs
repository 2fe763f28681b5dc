//! Spatial numbering along a Hilbert curve on the cube around the sphere.

use glam::DVec3;

use super::{EdgePayload, SphereMesh, Vertex};

/// Cells per side of a cube face: fine enough for tens of millions of sites, and keys of all faces fit 32 bits.
const RESOLUTION: u32 = 1 << 14;

/// The cube faces in curve order: outward normal, then the axes of the face. Each face's curve runs
/// from its corner (0, 0) to (1, 0), where the next face's begins; the tour follows a Petrie hexagon
/// of the cube and is closed.
const FACES: [[DVec3; 3]; 6] = [
    [DVec3::NEG_Z, DVec3::Y, DVec3::NEG_X],
    [DVec3::Y, DVec3::NEG_X, DVec3::Z],
    [DVec3::NEG_X, DVec3::Z, DVec3::NEG_Y],
    [DVec3::Z, DVec3::NEG_Y, DVec3::X],
    [DVec3::NEG_Y, DVec3::X, DVec3::NEG_Z],
    [DVec3::X, DVec3::NEG_Z, DVec3::Y],
];

/// The indices of `directions` in the order of a closed Hilbert curve around the sphere; ties keep
/// their order. Lengths do not matter.
pub fn hilbert_order(directions: &[DVec3]) -> Vec<u32> {
    order_by_keys(directions.iter().map(|&direction| hilbert_key(direction)))
}

/// The numbers of the given keys in the order of the keys; ties keep their order.
pub fn order_by_keys(keys: impl IntoIterator<Item = u32>) -> Vec<u32> {
    // Key and number in one word sort twice as fast as pairs.
    let word = |(i, key): (u32, u32)| u64::from(key) << 32 | u64::from(i);
    let mut words: Vec<u64> = (0..).zip(keys).map(word).collect();
    words.sort_unstable();
    words.into_iter().map(|word| word as u32).collect()
}

/// Position of a direction along the curve of [`hilbert_order`].
pub fn hilbert_key(direction: DVec3) -> u32 {
    let height = direction.abs().max_element();
    let face = FACES
        .iter()
        .position(|&[normal, ..]| direction.dot(normal) == height)
        .unwrap_or(0);
    let [_, u, v] = FACES[face];
    let cell = |axis: DVec3| {
        let across = 0.5 * (1.0 + direction.dot(axis) / height);
        ((across * f64::from(RESOLUTION)) as u32).min(RESOLUTION - 1)
    };
    face as u32 * RESOLUTION * RESOLUTION + along_face(cell(u), cell(v))
}

/// Position of a cell along the Hilbert curve of one face.
fn along_face(mut x: u32, mut y: u32) -> u32 {
    let mut position = 0;
    let mut side = RESOLUTION / 2;
    while side > 0 {
        let (right, upper) = (x & side != 0, y & side != 0);
        let quadrant = match (right, upper) {
            (false, false) => 0,
            (false, true) => 1,
            (true, true) => 2,
            (true, false) => 3,
        };
        position = 4 * position + quadrant;
        x &= side - 1;
        y &= side - 1;
        // The curve enters the first and leaves the last quadrant transposed.
        if !upper {
            if right {
                (x, y) = (side - 1 - x, side - 1 - y);
            }
            (x, y) = (y, x);
        }
        side /= 2;
    }
    position
}

impl<E: EdgePayload> SphereMesh<E> {
    /// The vertices along a Hilbert curve: `order[k]` is the current number of the vertex that
    /// [`renumber`](Self::renumber) would make number `k`.
    pub fn spatial_order(&self) -> Vec<Vertex> {
        hilbert_order(&self.sites)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_is_contiguous() {
        // Directions of a grid on the cube, visited in curve order, are neighbours on the cube.
        let side = 16;
        let mut grid = Vec::new();
        for [n, u, v] in FACES {
            for i in 0..side {
                for j in 0..side {
                    let at = |k: i32| f64::from(2 * k + 1 - side) / f64::from(side);
                    grid.push(n + u * at(i) + v * at(j));
                }
            }
        }
        let order = hilbert_order(&grid);
        let cell = 2.0 / f64::from(side);
        for (k, &i) in order.iter().enumerate() {
            let j = order[(k + 1) % order.len()];
            assert!(grid[i as usize].distance(grid[j as usize]) <= cell * 1.001);
        }
    }
}
