//! The mesh of every planet: a cube whose faces are blown up to a sphere. It has no poles.

use crate::surface::cube;
use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, Mesh, PrimitiveTopology},
};
use core::f64::consts::FRAC_PI_4;

/// Quads along an edge of the cube: about a degree each.
pub(super) const QUADS: u32 = 96;

/// A unit sphere. Vertices of neighbouring faces lie in the same places to the last bit.
pub(super) fn sphere() -> Mesh {
    let row = QUADS + 1;
    // Tangents space the vertices evenly by angle.
    let ticks: Vec<f64> = (0..row)
        .map(|i| match i {
            0 => -1.0,
            QUADS => 1.0,
            _ => libm::tan(FRAC_PI_4 * (2.0 * f64::from(i) / f64::from(QUADS) - 1.0)),
        })
        .collect();
    let mut positions = Vec::with_capacity((6 * row * row) as usize);
    let mut indices = Vec::with_capacity((36 * QUADS * QUADS) as usize);
    for face in 0..6 {
        for &t in &ticks {
            for &s in &ticks {
                let point = cube::point(face, s, t);
                // Summed in order of size, so that every face rounds alike.
                let mut squares = (point * point).to_array();
                squares.sort_by(f64::total_cmp);
                let length = squares.iter().sum::<f64>().sqrt();
                positions.push((point / length).as_vec3().to_array());
            }
        }
        let first = face as u32 * row * row;
        for y in 0..QUADS {
            for x in 0..QUADS {
                let a = first + y * row + x;
                let (b, c, d) = (a + 1, a + row, a + row + 1);
                // Diagonals alternate: relief shows no grain.
                let quad = if (x + y) % 2 == 0 {
                    [a, c, b, b, c, d]
                } else {
                    [a, c, d, a, d, b]
                };
                indices.extend(quad);
            }
        }
    }
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::RENDER_WORLD,
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_indices(Indices::U32(indices))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::Vec3;
    use bevy::mesh::VertexAttributeValues;
    use std::collections::HashMap;

    #[test]
    fn the_sphere_is_closed_and_faces_outwards() {
        let mesh = sphere();
        let Some(VertexAttributeValues::Float32x3(positions)) =
            mesh.attribute(Mesh::ATTRIBUTE_POSITION)
        else {
            panic!("positions");
        };
        let Some(Indices::U32(indices)) = mesh.indices() else {
            panic!("indices");
        };
        let key = |i: u32| positions[i as usize].map(f32::to_bits);
        let mut sides = HashMap::new();
        for triangle in indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|i| Vec3::from(positions[triangle[i] as usize]));
            assert!((b - a).cross(c - a).dot(a + b + c) > 0.0);
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                *sides
                    .entry((key(triangle[from]), key(triangle[to])))
                    .or_insert(0) += 1;
            }
        }
        for (&(from, to), &count) in &sides {
            assert_eq!((count, sides.get(&(to, from))), (1, Some(&1)));
        }
    }
}
