//! A plot of ground as plain numbers: all that a compute shader needs to raise it as [`Terrain`] does.
//!
//! Numbers of 32 bits cannot say where something is on a planet to better than half a metre. So everything is told
//! relative to the middle of the plot, and cells of the lattices as integers.

use super::{
    Exemplars, FINER, Landform, PIECE_M, Terrain,
    exemplar::Level,
    patch::{Patch, describe},
    scatter::{Scatter, TURNS},
    shore::FURTHEST,
};
use crate::mesh::{HalfEdge, SphereMesh};
use crate::simulation::Surface;
use crate::surface::{
    HeightField,
    coordinates::{east_north, unit},
    ground::Corner,
};
use fastnoise_lite::{DomainWarpType, FastNoiseLite};
use glam::{DVec3, IVec3, Vec3};
use std::collections::HashSet;

/// How far places may lie from the middle, in m, and as a share of the planet's radius.
const WIDEST: (f64, f64) = (200_000.0, 1.0 / 32.0);
/// Cells along a side of the grid by which triangles are found. Mirrored in the shader, as what follows.
const GRID: usize = 16;
/// Stands for a cell without a piece.
const NONE: u32 = u32::MAX;
/// Stands for a piece of sea floor.
const FLOOR: u32 = Landform::ALL.len() as u32;
/// The factor of the library's hash.
const HASH: u32 = 0x27D4_EB2D;

/// Numbers for a shader: floats as their bits.
#[derive(Default)]
pub(crate) struct Words(Vec<u32>);

impl Words {
    fn float(&mut self, value: f32) -> &mut Self {
        self.0.push(value.to_bits());
        self
    }

    fn whole(&mut self, value: u32) -> &mut Self {
        self.0.push(value);
        self
    }

    fn vector(&mut self, vector: Vec3) -> &mut Self {
        self.0.extend(vector.to_array().map(f32::to_bits));
        self
    }

    fn cell(&mut self, cell: IVec3) -> &mut Self {
        self.0.extend(cell.to_array().map(|i| i as u32));
        self
    }

    /// As the device has them. Nothing is one element of nought: a buffer cannot be empty.
    pub fn bytes(&self) -> Vec<u8> {
        if self.0.is_empty() {
            return vec![0; 96];
        }
        let bytes: Vec<[u8; 4]> = self.0.iter().map(|word| word.to_ne_bytes()).collect();
        bytes.into_flattened()
    }
}

/// The ground around places that lie close together.
pub(crate) struct Plot {
    /// Everything of which there is one.
    pub head: Words,
    /// Triangles of the mesh, and a grid by which they are found.
    pub triangles: Words,
    pub grid: Words,
    /// The larger pieces, and which of them lies in which cell.
    pub pieces: Words,
    pub cells: Words,
    /// The first of the cells.
    corner: IVec3,
}

impl Terrain<'_> {
    /// The plot on which all of some directions lie, of which there is at least one.
    ///
    /// # Errors
    /// [`TooWide`] if one of them lies too far from their middle.
    pub(crate) fn plot(&self, directions: &[DVec3]) -> Result<Plot, TooWide> {
        let radius_m = self.radius_m();
        let sum: DVec3 = directions.iter().map(|&direction| unit(direction)).sum();
        let middle = unit(sum);
        let allowed = (WIDEST.0 / radius_m).min(WIDEST.1);
        let mut furthest = (0, 0.0);
        let mut homes = Block::NONE;
        for (number, &direction) in directions.iter().enumerate() {
            let direction = unit(direction);
            let apart = direction.distance(middle);
            if apart > furthest.1 {
                furthest = (number, apart);
            }
            homes.include(home(direction * radius_m).0);
        }
        if furthest.1 > allowed {
            return Err(TooWide {
                number: furthest.0,
                found_km: 0.001 * furthest.1 * radius_m,
                allowed_km: 0.001 * allowed * radius_m,
            });
        }
        let (pieces, cells) = self.pieces_near(directions, homes);
        let [coast, relief, hills] = self.raster.texture().noises();
        let shore = self.shore.warp.as_ref();
        let bent = coast.domain_warp_amp + shore.map_or(0.0, |warp| warp.domain_warp_amp);
        let reach = 1.02 * (furthest.1 + FURTHEST * f64::from(bent)) + 1e-4;
        let axes = Axes::at(middle, reach);
        let (triangles, grid) = triangles(self.surface, &axes, reach);
        let mut head = Words::default();
        let coarse = middle.as_vec3();
        let rest = (middle - coarse.as_dvec3()).as_vec3();
        let grain = self.grains.as_ref().map_or(Level::of(1e9), |grain| grain.1);
        let seed = self.surface.seed ^ 1;
        head.vector(coarse).float(axes.width as f32);
        head.vector(rest).whole(0);
        head.vector(axes.east.as_vec3()).float(PIECE_M as f32);
        head.vector(axes.north.as_vec3())
            .float(self.detail_m as f32);
        // The last word is nought for ever, which no compiler of shaders can know.
        head.cell(homes.low - IVec3::ONE).whole(0);
        head.cell(homes.sides()).float(FINER as f32);
        for level in [self.level, grain] {
            head.whole(level.finer as u32).float(level.share);
        }
        head.whole(seed as u32).whole((seed >> 32) as u32);
        head.whole(0).whole(0);
        octaves(&mut head, Some(coast), true);
        octaves(&mut head, Some(relief), false);
        octaves(&mut head, Some(hills), false);
        octaves(&mut head, shore, true);
        Ok(Plot {
            head,
            triangles,
            grid,
            pieces,
            cells,
            corner: homes.low - IVec3::ONE,
        })
    }

    /// Directions of a plot as the shader reads them.
    pub(crate) fn samples(&self, plot: &Plot, directions: &[DVec3]) -> Words {
        let mut words = Words(Vec::with_capacity(12 * directions.len()));
        for &direction in directions {
            let direction = unit(direction);
            let coarse = direction.as_vec3();
            let (cell, within) = home(direction * self.radius_m());
            let [x, y, z] = (cell - plot.corner).to_array().map(|i| i as u32 & 0x3FF);
            words.vector(coarse).whole(x | y << 10 | z << 20);
            words.vector(within).whole(0);
            words
                .vector((direction - coarse.as_dvec3()).as_vec3())
                .whole(0);
        }
        words
    }

    /// A square of the tangent plane without heights.
    pub(crate) fn level_patch(&self, centre: DVec3, size_km: f64, samples: usize) -> HeightField {
        HeightField::over(self.surface.radius_km, centre, size_km, samples, |_| 0.0)
    }

    /// The ground that pieces show.
    pub(crate) fn exemplars(&self) -> &std::sync::Arc<Exemplars> {
        &self.exemplars
    }

    fn radius_m(&self) -> f64 {
        1000.0 * self.surface.radius_km
    }

    /// The pieces around all cells in which one of the directions lies, and the number of each cell's piece.
    fn pieces_near(&self, directions: &[DVec3], homes: Block) -> (Words, Words) {
        let (corner, sides) = (homes.low - IVec3::ONE, homes.sides());
        let number = |cell: IVec3| {
            let at = cell - corner;
            ((at.z * sides.y + at.y) * sides.x + at.x) as usize
        };
        let mut cells = vec![NONE; (sides.x * sides.y * sides.z) as usize];
        let mut pieces = Words::default();
        let mut count = 0;
        let mut last = None;
        let mut seen = HashSet::new();
        let hint = self.surface.start(directions[0]);
        for &direction in directions {
            let (home, _) = home(unit(direction) * self.radius_m());
            if last == Some(home) || !seen.insert(home) {
                continue;
            }
            last = Some(home);
            for i in 0..27 {
                let cell = home + IVec3::new(i % 3, i / 3 % 3, i / 9) - IVec3::ONE;
                let slot = &mut cells[number(cell)];
                if *slot == NONE {
                    *slot = count;
                    count += 1;
                    let reached = self.pieces.piece(cell);
                    let patch = describe(&reached, &self.pieces, self.surface, &self.raster, hint);
                    describe_piece(&mut pieces, &patch);
                }
            }
        }
        (pieces, Words(cells))
    }
}

/// A direction lies too far from the middle of the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TooWide {
    pub number: usize,
    pub found_km: f64,
    pub allowed_km: f64,
}

/// What is the same for every plot: the vectors that noise is made of, the turns of pieces.
pub(crate) fn vectors() -> Words {
    let mut words = Words::default();
    for gradient in gradients() {
        words.vector(gradient).whole(0);
    }
    for vector in displacements() {
        words.vector(vector).whole(0);
    }
    for (sin, cos) in TURNS {
        words.float(sin).float(cos).whole(0).whole(0);
    }
    words
}

/// The weights of all exemplars, kind by kind.
pub(crate) fn weights(exemplars: &Exemplars) -> Words {
    let mut words = Words::default();
    for landform in Landform::ALL {
        for weight in exemplars.get(landform).weights() {
            words.float(weight);
        }
    }
    words
}

/// The gradients of the library's noise: towards the edges of a cube, five times over, and four of them once more.
fn gradients() -> impl Iterator<Item = Vec3> {
    let sides = [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    let axes = [
        |a, b| Vec3::new(0.0, a, b),
        |a, b| Vec3::new(a, 0.0, b),
        |a, b| Vec3::new(a, b, 0.0),
    ];
    let edges = (0..60).map(move |i: usize| {
        let (a, b) = sides[i % 4];
        axes[i / 4 % 3](a, b)
    });
    edges.chain([
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::new(0.0, -1.0, 1.0),
        Vec3::new(-1.0, 1.0, 0.0),
        Vec3::new(0.0, -1.0, -1.0),
    ])
}

/// The library keeps the vectors by which it displaces to itself, but a displacement on a grid shows them: at the
/// corner of a cell it is one of them, and the seed says which.
fn displacements() -> impl Iterator<Item = Vec3> {
    // Whose product with the factor of the hash ends in 1.
    let mut inverse = 1_u32;
    for _ in 0..5 {
        inverse = inverse.wrapping_mul(2_u32.wrapping_sub(HASH.wrapping_mul(inverse)));
    }
    (0..256).map(move |number: u32| {
        let seed = (number << 2).wrapping_mul(inverse) & 0x3FF;
        let mut warp = FastNoiseLite::with_seed(seed as i32);
        warp.set_domain_warp_type(Some(DomainWarpType::BasicGrid));
        warp.set_fractal_octaves(Some(1));
        warp.set_frequency(Some(1.0));
        warp.set_domain_warp_amp(Some(1.0));
        warp.domain_warp_3d(0.0, 0.0, 0.0).into()
    })
}

/// The cell of the larger pieces in which a place lies, given in m, and where from the cell's middle, in cells.
fn home(place: DVec3) -> (IVec3, Vec3) {
    let scaled = place / PIECE_M;
    let floor = scaled.floor();
    let within = (scaled - floor).as_vec3() - Vec3::splat(0.5);
    (floor.as_ivec3(), within)
}

fn describe_piece(words: &mut Words, patch: &Patch) {
    words.vector(Scatter::jitter(patch.bits));
    words.whole(patch.landform.map_or(FLOOR, |landform| landform as u32));
    words.vector(patch.along).float(patch.shift[0]);
    words.vector(patch.across).float(patch.shift[1]);
    words.whole(patch.bits as u32);
    words.whole((patch.bits >> 32) as u32);
    words.whole(0).whole(0);
}

/// A noise of octaves, as the library reckons with it; one without octaves in place of none.
fn octaves(words: &mut Words, noise: Option<&FastNoiseLite>, is_warp: bool) {
    let Some(noise) = noise else {
        for _ in 0..8 {
            words.whole(0);
        }
        return;
    };
    // In the library's own order, to the last bit.
    let (mut sum, mut amplitude) = (1.0, noise.gain);
    for _ in 1..noise.octaves {
        sum += amplitude;
        amplitude *= noise.gain;
    }
    let bounding = 1.0 / sum;
    words.float(noise.frequency);
    words.float(if is_warp {
        noise.domain_warp_amp * bounding
    } else {
        bounding
    });
    words.float(noise.gain).float(noise.lacunarity);
    words
        .whole(noise.octaves as u32)
        .whole(noise.seed as u32)
        .whole(0)
        .whole(0);
}

/// Cells between two corners, both included.
#[derive(Clone, Copy)]
struct Block {
    low: IVec3,
    high: IVec3,
}

impl Block {
    const NONE: Self = Self {
        low: IVec3::MAX,
        high: IVec3::MIN,
    };

    fn include(&mut self, cell: IVec3) {
        self.low = self.low.min(cell);
        self.high = self.high.max(cell);
    }

    /// Cells along each side, with one more all around.
    fn sides(&self) -> IVec3 {
        (self.high - self.low).saturating_add(IVec3::splat(3))
    }
}

/// The plane that touches the sphere in the middle of a plot.
struct Axes {
    middle: DVec3,
    east: DVec3,
    north: DVec3,
    /// Half of a side of the grid, in radii.
    width: f64,
}

impl Axes {
    fn at(middle: DVec3, reach: f64) -> Self {
        let (east, north) = east_north(middle);
        Self {
            middle,
            east,
            north,
            width: libm::tan(reach.min(1.2)),
        }
    }

    /// Middle of a cell of the grid, and a distance from it that no place of the cell exceeds.
    fn cell(&self, number: usize) -> (DVec3, f64) {
        let at = |i: usize| (2 * i + 1) as f64 / GRID as f64 - 1.0;
        let (x, y) = (at(number % GRID), at(number / GRID));
        let place = self.middle + (self.east * x + self.north * y) * self.width;
        let half = core::f64::consts::SQRT_2 * self.width / GRID as f64;
        (place.normalize(), 1.02 * half)
    }
}

/// The triangles within reach of the middle, and those in each cell of the grid: where in the list they begin, how
/// many there are, and then the list.
fn triangles(surface: &Surface, axes: &Axes, reach: f64) -> (Words, Words) {
    let mut words = Words::default();
    let mut lists = vec![Vec::new(); GRID * GRID];
    let cells: Vec<(DVec3, f64)> = (0..GRID * GRID).map(|i| axes.cell(i)).collect();
    let mut count = 0;
    for h in within(&surface.mesh, axes.middle, reach, surface) {
        let vertices = surface.mesh.triangle_vertices(h);
        let [a, b, c] = vertices.map(|vertex| surface.mesh.site(vertex));
        let normals = [b.cross(c), c.cross(a), a.cross(b)];
        let volume = normals[0].dot(a);
        if volume <= 0.0 {
            continue;
        }
        for normal in normals {
            let normal = normal / volume;
            words
                .vector(normal.as_vec3())
                .float(normal.dot(axes.middle) as f32);
        }
        for vertex in vertices {
            let corner = Corner::of(surface, vertex as usize);
            words
                .float(if corner.land { 1.0 } else { 0.0 })
                .float(corner.elevation)
                .float(corner.age)
                .float(corner.youth);
        }
        let sides = normals.map(DVec3::normalize_or_zero);
        for (list, (place, radius)) in lists.iter_mut().zip(&cells) {
            if sides.iter().all(|side| side.dot(*place) >= -radius) {
                list.push(count);
            }
        }
        count += 1;
    }
    let mut grid = Words::default();
    let mut start = 2 * lists.len() as u32;
    for list in &lists {
        grid.whole(start).whole(list.len() as u32);
        start += list.len() as u32;
    }
    grid.0.extend(lists.iter().flatten());
    (words, grid)
}

/// The triangles of which some place lies within reach of the middle: from one to the next across edges that do.
fn within(mesh: &SphereMesh, middle: DVec3, reach: f64, surface: &Surface) -> Vec<HalfEdge> {
    let first = mesh.locate(middle, surface.start(middle)).half_edge;
    let mut open = vec![first];
    let mut seen = HashSet::new();
    let mut found = Vec::new();
    while let Some(h) = open.pop() {
        let sides = [h, mesh.next(h), mesh.prev(h)];
        if !seen.insert(sides.into_iter().min()) {
            continue;
        }
        found.push(h);
        for side in sides {
            let (a, b) = (mesh.site(mesh.origin(side)), mesh.site(mesh.dest(side)));
            if is_near(a, b, middle, reach) {
                open.push(mesh.twin(side));
            }
        }
    }
    found
}

/// Whether the edge between two sites comes within so many radii of a place.
fn is_near(a: DVec3, b: DVec3, place: DVec3, reach: f64) -> bool {
    let normal = a.cross(b);
    let beside = normal.cross(a).dot(place) >= 0.0 && b.cross(normal).dot(place) >= 0.0;
    let to_circle = normal.dot(place).abs() <= reach * normal.length();
    let to_ends = [a, b]
        .iter()
        .any(|end| end.distance_squared(place) <= reach * reach);
    to_ends || (beside && to_circle && place.dot(a) > 0.0)
}
