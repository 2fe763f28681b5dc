//! One tile: its ground, and the mesh that is drawn of it.

use super::address::{Address, QUADS};
use crate::{
    simulation::Surface,
    surface::{SurfaceError, Terrain, cube},
};
use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, Mesh, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues},
    render::render_resource::VertexFormat,
};
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Upward unit vectors in the space of the planet's `Transform`.
pub(in super::super) const UP: MeshVertexAttribute =
    MeshVertexAttribute::new("Tile_Up", 0x7EC7_0001, VertexFormat::Float32x3);
/// Slope of the ground uphill and that of the parent's ground, along both axes of a [`frame`], as shares of
/// [`STEEPEST`].
pub(in super::super) const SLOPES: MeshVertexAttribute =
    MeshVertexAttribute::new("Tile_Slopes", 0x7EC7_0002, VertexFormat::Snorm16x4);
/// Elevation and the parent's, both in km, and how far the parent's flat triangles lie below the sphere, in radii. At
/// the lower end of walls, -1 less that.
pub(in super::super) const HEIGHTS: MeshVertexAttribute =
    MeshVertexAttribute::new("Tile_Heights", 0x7EC7_0004, VertexFormat::Float32x3);

/// The steepest slope that vertices can have, in m per m. Mirrored in `lift.wgsl`.
const STEEPEST: f32 = 8.0;
/// Patterns finer than tiles repeat after this distance in m. Mirrored in `lift.wgsl`.
const PERIOD_M: f64 = 8192.0;
/// Tiles have their origins at multiples of this length in m, of which [`PERIOD_M`] is one: so they know where in a
/// period they lie. Mirrored in `lift.wgsl`.
const PACE_M: f64 = 128.0;
/// Vertices along a side.
const SIDE: usize = QUADS as usize + 1;
/// Quads along a side of the blocks in which triangles are drawn. GPUs work on some 32 vertices at a time: blocks use
/// each vertex of theirs more often than rows do.
const BLOCK: usize = 4;

/// Where the vertices of a tile are counted from, in radii, and where in a period that is, in [`PACE_M`].
pub(super) fn origin(address: Address, radius_m: f64) -> (DVec3, [u32; 3]) {
    let paces = (address.middle() * (radius_m / PACE_M)).floor();
    let phase = paces.rem_euclid(DVec3::splat(PERIOD_M / PACE_M));
    (paces * (PACE_M / radius_m), phase.as_uvec3().to_array())
}

/// Two level axes at a place (Duff et al. 2017). Mirrored in `lift.wgsl`.
fn frame(up: Vec3) -> [Vec3; 2] {
    // Shaders do not tell -0 from 0.
    (up + Vec3::ZERO).any_orthonormal_pair().into()
}

/// The ground of a tile, kept for its children.
#[derive(Debug)]
pub(super) struct Tile {
    pub address: Address,
    /// Elevation in m, row by row.
    heights: Vec<f32>,
    slopes: Vec<Vec3>,
    /// Lowest and highest elevation in m, the parent's within the tile included.
    pub range: [f32; 2],
    /// Slope of the steepest triangle in m per m, and the same with the parent's included.
    own_steepest: f32,
    pub steepest: f32,
}

/// Samples a tile and builds its mesh. The vertices are relative to its [`origin`], in radii.
///
/// # Errors
/// [`SurfaceError`] when a column does not have one value per sub-plate.
pub(super) fn grow(
    surface: &Surface,
    address: Address,
    parent: Option<Arc<Tile>>,
) -> Result<(Tile, Mesh), SurfaceError> {
    let radius_m = 1000.0 * surface.radius_km;
    let mut terrain = Terrain::new(surface, address.size() * radius_m / f64::from(QUADS))?;
    // One more all around, for slopes.
    let wide = SIDE + 2;
    let places = (0..wide * wide).map(|i| {
        let at = |i: usize| i as f64 - 1.0;
        address.direction(at(i % wide), at(i / wide))
    });
    let places: Vec<DVec3> = places.collect();
    let raised: Vec<f32> = places
        .iter()
        .map(|&place| terrain.elevation(cube::to_simulation(place)))
        .collect();
    let inner = || (0..SIDE * SIDE).map(|i| (i / SIDE + 1) * wide + i % SIDE + 1);
    let slopes = inner().map(|i| {
        let along = (places[i + 1] - places[i - 1]) * radius_m;
        let down = (places[i + wide] - places[i - wide]) * radius_m;
        let rise = |step: usize| f64::from(raised[i + step] - raised[i - step]);
        gradient(along, down, rise(1), rise(wide)).as_vec3()
    });
    let slopes: Vec<Vec3> = slopes.collect();
    let heights: Vec<f32> = inner().map(|i| raised[i]).collect();
    let low = heights.iter().copied().fold(f32::INFINITY, f32::min);
    let high = heights.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let directions: Vec<DVec3> = inner().map(|i| places[i]).collect();
    let own_steepest = steepest(&directions, &heights, radius_m);
    let mut tile = Tile {
        address,
        heights,
        slopes,
        range: [low, high],
        own_steepest,
        steepest: own_steepest,
    };
    if let Some(parent) = &parent {
        tile.steepest = own_steepest.max(parent.own_steepest);
        let [low, high] = &mut tile.range;
        for height in parent.quarter(address) {
            (*low, *high) = (low.min(height), high.max(height));
        }
    }
    let mesh = tile.mesh(&directions, radius_m, parent.as_deref());
    Ok((tile, mesh))
}

/// The slope of a plane that rises by so much along two vectors.
fn gradient(a: DVec3, b: DVec3, rise_a: f64, rise_b: f64) -> DVec3 {
    let (aa, ab, bb) = (a.dot(a), a.dot(b), b.dot(b));
    let area = (aa * bb - ab * ab).max(f64::MIN_POSITIVE);
    a * ((rise_a * bb - rise_b * ab) / area) + b * ((rise_b * aa - rise_a * ab) / area)
}

/// The slope of the steepest triangle.
fn steepest(directions: &[DVec3], heights: &[f32], radius_m: f64) -> f32 {
    let slope = |at: usize, b: usize, c: usize| {
        let [along, across] = [b, c].map(|i| (directions[i] - directions[at]) * radius_m);
        let [rise, climb] = [b, c].map(|i| f64::from(heights[i] - heights[at]));
        gradient(along, across, rise, climb).length_squared()
    };
    let quads = (0..SIDE - 1).flat_map(|row| (0..SIDE - 1).map(move |x| row * SIDE + x));
    let steepest = quads.fold(0.0, |most: f64, a| {
        let (b, c, d) = (a + 1, a + SIDE, a + SIDE + 1);
        most.max(slope(a, b, c)).max(slope(d, b, c))
    });
    steepest.sqrt() as f32
}

impl Tile {
    /// Heights of a tile within that of a child.
    fn quarter(&self, child: Address) -> impl Iterator<Item = f32> {
        let half = QUADS as usize / 2;
        let [left, top] = [child.x, child.y].map(|at| half * (at % 2) as usize);
        (0..=half)
            .flat_map(move |row| (0..=half).map(move |column| (top + row) * SIDE + left + column))
            .map(|i| self.heights[i])
    }

    /// What the parent draws where this tile has a vertex: height, slope, and the place on its flat triangles.
    fn coarse(
        &self,
        parent: &Tile,
        directions: &[DVec3],
        column: usize,
        row: usize,
    ) -> (f32, Vec3, DVec3) {
        let half = QUADS as usize / 2;
        let left = half * (self.address.x % 2) as usize;
        let top = half * (self.address.y % 2) as usize;
        // The parent's vertices on both sides; its quads are cut from lower left to upper right.
        let [x0, x1] = [column / 2, column.div_ceil(2)];
        let [y1, y0] = [row / 2, row.div_ceil(2)];
        let pick = |x: usize, y: usize| (top + y) * SIDE + left + x;
        let own = |x: usize, y: usize| directions[2 * y * SIDE + 2 * x];
        let (a, b) = (pick(x0, y0), pick(x1, y1));
        (
            0.5 * (parent.heights[a] + parent.heights[b]),
            0.5 * (parent.slopes[a] + parent.slopes[b]),
            0.5 * (own(x0, y0) + own(x1, y1)),
        )
    }

    fn mesh(&self, directions: &[DVec3], radius_m: f64, parent: Option<&Tile>) -> Mesh {
        let (origin, _) = origin(self.address, radius_m);
        let mut positions = Vec::new();
        let mut ups = Vec::new();
        let mut slopes = Vec::new();
        let mut heights = Vec::new();
        let mut add = |i: usize, is_wall: bool| {
            let up = directions[i];
            let (coarse, coarse_slope, flat) = match parent {
                Some(parent) => self.coarse(parent, directions, i % SIDE, i / SIDE),
                None => (self.heights[i], self.slopes[i], up),
            };
            positions.push((up - origin).as_vec3().to_array());
            ups.push(up.as_vec3().to_array());
            slopes.push(packed(up.as_vec3(), self.slopes[i], coarse_slope));
            // Rounded, it may be less than nothing, which is what tells walls.
            let sag = (1.0 - flat.dot(up)).max(0.0) as f32;
            let depth = if is_wall { -1.0 - sag } else { sag };
            heights.push([0.001 * self.heights[i], 0.001 * coarse, depth]);
        };
        for i in 0..SIDE * SIDE {
            add(i, false);
        }
        let rim = rim();
        for &i in &rim {
            add(i, true);
        }
        Mesh::new(
            PrimitiveTopology::TriangleList,
            RenderAssetUsages::RENDER_WORLD,
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(UP, ups)
        .with_inserted_attribute(SLOPES, VertexAttributeValues::Snorm16x4(slopes))
        .with_inserted_attribute(HEIGHTS, heights)
        .with_inserted_indices(Indices::U16(indices(&rim)))
    }
}

/// Two slopes as [`SLOPES`] has them.
fn packed(up: Vec3, slope: Vec3, coarse: Vec3) -> [i16; 4] {
    let [a, b] = frame(up);
    [slope.dot(a), slope.dot(b), coarse.dot(a), coarse.dot(b)]
        .map(|along| ((along / STEEPEST).clamp(-1.0, 1.0) * f32::from(i16::MAX)).round() as i16)
}

/// The vertices along the rim, once around, counter-clockwise as seen from above.
fn rim() -> Vec<usize> {
    let last = SIDE - 1;
    let left = (0..last).map(|row| row * SIDE);
    let bottom = (0..last).map(|column| last * SIDE + column);
    let right = (0..last).map(|row| (last - row) * SIDE + last);
    let top = (0..last).map(|column| last - column);
    left.chain(bottom).chain(right).chain(top).collect()
}

fn indices(rim: &[usize]) -> Vec<u16> {
    let quads = QUADS as usize;
    let mut indices = Vec::with_capacity(6 * quads * (quads + 4));
    for left in (0..quads).step_by(BLOCK) {
        for row in 0..quads {
            for column in left..left + BLOCK {
                let a = row * SIDE + column;
                let (b, c, d) = (a + 1, a + SIDE, a + SIDE + 1);
                indices.extend([a, c, b, b, c, d]);
            }
        }
    }
    for (i, &a) in rim.iter().enumerate() {
        let next = (i + 1) % rim.len();
        let (b, below_a, below_b) = (rim[next], SIDE * SIDE + i, SIDE * SIDE + next);
        indices.extend([a, below_a, b, b, below_a, below_b]);
    }
    indices.into_iter().map(|i| i as u16).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::{History, Recipe};

    fn surface() -> Surface {
        let recipe = Recipe::earth_like(7).with_sub_plates(500);
        History::new(recipe).unwrap().surface().unwrap()
    }

    const PARENT: Address = Address {
        level: 5,
        face: 3,
        x: 14,
        y: 9,
    };

    #[test]
    fn neighbours_have_the_same_ground_along_their_edge() {
        let surface = surface();
        let beside = Address {
            x: PARENT.x + 1,
            ..PARENT
        };
        let (left, _) = grow(&surface, PARENT, None).unwrap();
        let (right, _) = grow(&surface, beside, None).unwrap();
        let last = SIDE - 1;
        for row in 0..SIDE {
            let (a, b) = (row * SIDE + last, row * SIDE);
            assert_eq!(left.heights[a], right.heights[b]);
            assert!((left.slopes[a] - right.slopes[b]).length() < 1e-5);
        }
    }

    #[test]
    fn vertices_glide_to_where_the_parent_has_its_ground() {
        let surface = surface();
        let (parent, _) = grow(&surface, PARENT, None).unwrap();
        let child = PARENT.children()[3];
        let (tile, _) = grow(&surface, child, None).unwrap();
        let directions: Vec<DVec3> = (0..SIDE * SIDE)
            .map(|i| child.direction((i % SIDE) as f64, (i / SIDE) as f64))
            .collect();
        let half = SIDE / 2;
        // Where both have a vertex, and in the middle of edges and quads between.
        for (column, row) in [(0, 0), (2, 6), (64, 64), (1, 0), (0, 5), (7, 7), (63, 1)] {
            let (height, _, flat) = tile.coarse(&parent, &directions, column, row);
            let at =
                |column: usize, row: usize| parent.heights[(half + row) * SIDE + half + column];
            let low = (column / 2, row.div_ceil(2));
            let high = (column.div_ceil(2), row / 2);
            assert_eq!(height, 0.5 * (at(low.0, low.1) + at(high.0, high.1)));
            let own = directions[row * SIDE + column];
            assert!(flat.dot(own) <= 1.0 + 1e-15, "below the sphere");
            assert!(flat.distance(own) < 0.02 * child.size() / f64::from(QUADS));
        }
    }

    #[test]
    fn walls_alone_hang_down() {
        let surface = surface();
        // So fine that the parent's triangles lie below the sphere by less than numbers can say.
        let parent = Address {
            level: 15,
            face: 1,
            x: 9_000,
            y: 20_000,
        };
        let (ground, _) = grow(&surface, parent, None).unwrap();
        let (_, mesh) = grow(&surface, parent.children()[1], Some(Arc::new(ground))).unwrap();
        let Some(VertexAttributeValues::Float32x3(heights)) = mesh.attribute(HEIGHTS) else {
            panic!("heights");
        };
        let (above, walls) = heights.split_at(SIDE * SIDE);
        assert!(above.iter().all(|&[.., depth]| (0.0..1.0).contains(&depth)));
        assert!(walls.iter().all(|&[.., depth]| depth <= -1.0));
    }

    #[test]
    fn vertices_know_where_in_a_period_they_lie() {
        let radius_m = 6.371e6;
        for address in [PARENT, PARENT.children()[2]]
            .into_iter()
            .chain(Address::roots())
        {
            let (origin, phase) = origin(address, radius_m);
            assert!(phase.iter().all(|&paces| paces < 64));
            let apart = (address.middle() - origin) * radius_m;
            assert!(apart.min_element() > -1e-6 && apart.max_element() < PACE_M + 1e-6);
            for (at, paces) in (origin * radius_m).to_array().into_iter().zip(phase) {
                let off = at - f64::from(paces) * PACE_M;
                let periods = off / PERIOD_M;
                assert!((periods - periods.round()).abs() < 1e-9, "{at} {paces}");
            }
        }
    }

    #[test]
    fn slopes_survive_packing() {
        let ups = [
            Vec3::Z,
            -Vec3::Z,
            Vec3::new(0.6, 0.0, -0.0),
            Vec3::new(-0.3, 0.5, -0.8),
        ];
        for up in ups.map(Vec3::normalize) {
            let slope = up.any_orthogonal_vector().normalize() * 1.7;
            let coarse = up.cross(slope) * 0.2;
            let [x, y, z, w] =
                packed(up, slope, coarse).map(|v| f32::from(v) / 32_767.0 * STEEPEST);
            let [a, b] = frame(up);
            assert!((a * x + b * y).distance(slope) < 5e-4, "{up}");
            assert!((a * z + b * w).distance(coarse) < 5e-4, "{up}");
        }
        assert_eq!(
            packed(Vec3::Z, Vec3::X * 1e9, Vec3::ZERO)[0].abs(),
            i16::MAX
        );
    }

    #[test]
    fn the_steepest_triangle_is_found() {
        let directions: Vec<DVec3> = (0..SIDE * SIDE)
            .map(|i| PARENT.direction((i % SIDE) as f64, (i / SIDE) as f64))
            .collect();
        let mut heights = vec![100.0; SIDE * SIDE];
        assert!(steepest(&directions, &heights, 6.371e6) < 1e-9);
        heights[7 * SIDE + 11] += 500.0;
        let quad = directions[7 * SIDE + 11].distance(directions[7 * SIDE + 12]) * 6.371e6;
        let found = f64::from(steepest(&directions, &heights, 6.371e6));
        assert!(found > 500.0 / quad && found < 1000.0 / quad, "{found}");
    }

    #[test]
    fn slopes_are_those_of_the_ground() {
        // A plane that rises by 0.3 along x and falls by 0.1 along y, on axes that are not square.
        let (a, b) = (DVec3::new(2.0, 0.0, 0.0), DVec3::new(1.0, 3.0, 0.0));
        let rise = |v: DVec3| 0.3 * v.x - 0.1 * v.y;
        let slope = gradient(a, b, rise(a), rise(b));
        assert!(slope.abs_diff_eq(DVec3::new(0.3, -0.1, 0.0), 1e-12));
    }

    #[test]
    fn meshes_face_outwards_and_their_walls_hang_from_the_rim() {
        let surface = surface();
        let (_, mesh) = grow(&surface, PARENT, None).unwrap();
        let Some(bevy::mesh::VertexAttributeValues::Float32x3(positions)) =
            mesh.attribute(Mesh::ATTRIBUTE_POSITION)
        else {
            panic!("positions");
        };
        assert_eq!(positions.len(), SIDE * SIDE + 4 * (SIDE - 1));
        let Some(Indices::U16(indices)) = mesh.indices() else {
            panic!("indices");
        };
        let up = PARENT.middle().as_vec3();
        let ground = 6 * (QUADS * QUADS) as usize;
        for triangle in indices[..ground].chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|i| Vec3::from(positions[usize::from(triangle[i])]));
            assert!((b - a).cross(c - a).dot(up) > 0.0);
        }
        assert_eq!(indices.len(), ground + 6 * 4 * QUADS as usize);
        let mut drawn: Vec<&[u16]> = indices[..ground].chunks(3).collect();
        drawn.sort_unstable();
        drawn.dedup();
        assert_eq!(3 * drawn.len(), ground);
    }
}
