//! Where the texels of cube maps lie: on the faces of a cube in the space of a scene, whose north is `+Y`.

use glam::DVec3;

/// Faces in the order of a cube map's layers: +X, −X, +Y, −Y, +Z, −Z; the directions in which columns and
/// rows run, and the middle.
const FACES: [[DVec3; 3]; 6] = [
    [DVec3::NEG_Z, DVec3::NEG_Y, DVec3::X],
    [DVec3::Z, DVec3::NEG_Y, DVec3::NEG_X],
    [DVec3::X, DVec3::Z, DVec3::Y],
    [DVec3::X, DVec3::NEG_Z, DVec3::NEG_Y],
    [DVec3::X, DVec3::NEG_Y, DVec3::Z],
    [DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z],
];

/// The axes of a face: along columns, along rows, outwards.
pub(crate) fn axes(face: usize) -> [DVec3; 3] {
    FACES[face % FACES.len()]
}

/// A point of the cube, in the space of a scene; `s` and `t` run from −1 to 1 over the face.
pub(crate) fn point(face: usize, s: f64, t: f64) -> DVec3 {
    let [along, down, out] = axes(face);
    along * s + down * t + out
}

/// Where the centre of texel `i` of `size` lies on a face, −1 to 1. Texels beyond the edge continue
/// the face's plane.
pub(crate) fn centre(i: i32, size: u32) -> f64 {
    (2.0 * f64::from(i) + 1.0) / f64::from(size) - 1.0
}

/// The direction of the centre of a texel, in the simulation's frame.
pub(crate) fn direction(face: usize, x: i32, y: i32, size: u32) -> DVec3 {
    to_simulation(point(face, centre(x, size), centre(y, size)).normalize())
}

/// A vector of a scene in the simulation's frame: [`from_scene`](crate::planet::from_scene) in double
/// precision.
pub(crate) fn to_simulation(vector: DVec3) -> DVec3 {
    DVec3::new(vector.x, -vector.z, vector.y)
}

/// A vector of the simulation's frame in that of a scene: [`to_scene`](crate::planet::to_scene) in double
/// precision.
#[cfg(all(feature = "render", feature = "terrain"))]
pub(crate) fn from_simulation(vector: DVec3) -> DVec3 {
    DVec3::new(vector.x, vector.z, -vector.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_lie_where_the_scene_has_them() {
        for face in 0..6 {
            let [along, down, out] = axes(face);
            assert_eq!(direction(face, 2, 2, 5), to_simulation(out));
            assert_eq!(along.cross(-down), out, "seen from outside, rows run down");
        }
        assert_eq!(to_simulation(DVec3::Y), DVec3::Z, "north");
        assert_eq!(to_simulation(DVec3::NEG_Z), DVec3::Y, "90 degrees east");
    }
}
