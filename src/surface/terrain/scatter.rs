//! Places of the pieces of ground: one in each cell of a lattice in space, moved about at random. The sphere cuts
//! through the lattice; a piece counts where it lies near, whether above or below.

use super::super::texture::mix;
use glam::{DVec3, IVec3, Vec3};

/// How far a piece lies from the middle of its cell, as a share of the cell.
const JITTER: f32 = 0.35;
/// How far a piece reaches, as a share of the cell. Up to 1.15 the 27 cells around a place are sure to hold all that
/// reach it; with 1, four do on average.
const REACH: f32 = 1.0;

/// A lattice of pieces.
pub(super) struct Scatter {
    seed: u64,
    /// Size of a cell in m.
    size: f64,
}

/// A piece that reaches a place.
#[derive(Clone, Copy)]
pub(super) struct Reached {
    pub cell: IVec3,
    /// Random bits of the piece.
    pub bits: u64,
    /// From the middle of the piece to the place, in m.
    pub offset: Vec3,
    /// 1 in the middle, 0 at the rim, and how it changes per m.
    pub weight: f32,
    pub weight_slope: Vec3,
}

impl Reached {
    /// A random shift within an exemplar, in texels.
    pub fn shift(&self) -> [f32; 2] {
        [8, 20].map(|bit| (self.bits >> bit & 0xFFF) as f32 / 16.0)
    }

    /// A number from 0 to 1 that belongs to the piece.
    pub fn chance(&self) -> f32 {
        (self.bits >> 40) as f32 / (1_u32 << 24) as f32
    }

    /// Two axes at right angles, turned by a random angle.
    pub fn turned(&self, [east, north]: [Vec3; 2]) -> [Vec3; 2] {
        let (sin, cos) = TURNS[(self.bits & 0xF) as usize];
        [east * cos + north * sin, north * cos - east * sin]
    }
}

/// Sine and cosine of multiples of 22.5°.
pub(super) const TURNS: [(f32, f32); 16] = {
    const A: f32 = 0.382_683_43;
    const B: f32 = core::f32::consts::FRAC_1_SQRT_2;
    const C: f32 = 0.923_879_5;
    [
        (0.0, 1.0),
        (A, C),
        (B, B),
        (C, A),
        (1.0, 0.0),
        (C, -A),
        (B, -B),
        (A, -C),
        (0.0, -1.0),
        (-A, -C),
        (-B, -B),
        (-C, -A),
        (-1.0, 0.0),
        (-C, A),
        (-B, B),
        (-A, C),
    ]
};

impl Scatter {
    pub fn new(seed: u64, size: f64) -> Self {
        Self { seed, size }
    }

    /// Visits all pieces that reach a place, given in m from the planet's centre, always in the same order.
    pub fn visit(&self, place: DVec3, mut visit: impl FnMut(&Reached)) {
        let scaled = place / self.size;
        let floor = scaled.floor();
        let home = floor.as_ivec3();
        let within = (scaled - floor).as_vec3() - Vec3::splat(0.5);
        let size = self.size as f32;
        // Squares of the least distances along each axis to pieces of the cells before, here and after: most cells
        // are too far away whatever their jitter.
        let least = [within.x, within.y, within.z].map(|within| {
            [-1.0, 0.0, 1.0].map(|step: f32| {
                let apart = ((within - step).abs() - JITTER).max(0.0);
                apart * apart
            })
        });
        for z in 0..3 {
            for y in 0..3 {
                for x in 0..3 {
                    if least[0][x] + least[1][y] + least[2][z] >= REACH * REACH {
                        continue;
                    }
                    let step = IVec3::new(x as i32, y as i32, z as i32) - IVec3::ONE;
                    let cell = home + step;
                    let bits = self.bits(cell);
                    let offset = within - step.as_vec3() - Self::jitter(bits);
                    let left = 1.0 - offset.length_squared() / (REACH * REACH);
                    if left > 0.0 {
                        visit(&Reached {
                            cell,
                            bits,
                            offset: offset * size,
                            weight: left * left * left,
                            weight_slope: offset * (-6.0 * left * left / (REACH * REACH * size)),
                        });
                    }
                }
            }
        }
    }

    /// Middle of a piece in m from the planet's centre.
    pub fn middle(&self, piece: &Reached) -> DVec3 {
        let jitter = Self::jitter(piece.bits).as_dvec3();
        (piece.cell.as_dvec3() + DVec3::splat(0.5) + jitter) * self.size
    }

    /// The piece of a cell, seen from its middle.
    #[cfg(feature = "render")]
    pub fn piece(&self, cell: IVec3) -> Reached {
        Reached {
            cell,
            bits: self.bits(cell),
            offset: Vec3::ZERO,
            weight: 1.0,
            weight_slope: Vec3::ZERO,
        }
    }

    /// From the middle of a cell to that of its piece, in cells.
    pub fn jitter(bits: u64) -> Vec3 {
        let part = |bit: u32| (bits >> bit & 0x3FF) as f32 / 511.5 - 1.0;
        Vec3::new(part(0), part(21), part(42)) * JITTER
    }

    fn bits(&self, cell: IVec3) -> u64 {
        let key =
            (cell.x as u32 as u64) << 42 ^ (cell.y as u32 as u64) << 21 ^ cell.z as u32 as u64;
        let bits = mix(self.seed ^ mix(key));
        bits ^ (bits >> 31)
    }
}
