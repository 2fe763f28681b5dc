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

/// The cells around a cell, itself included, by rows.
const CELLS: usize = 27;
/// The way to each of them.
const STEPS: [[f32; CELLS]; 3] = {
    let mut steps = [[0.0; CELLS]; 3];
    let mut i = 0;
    while i < CELLS {
        steps[0][i] = (i % 3) as f32 - 1.0;
        steps[1][i] = (i / 3 % 3) as f32 - 1.0;
        steps[2][i] = (i / 9) as f32 - 1.0;
        i += 1;
    }
    steps
};

/// The pieces around the cell that was visited last.
#[derive(Default)]
pub(super) struct Around {
    home: Option<IVec3>,
    bits: [u64; CELLS],
    /// See [`Scatter::jitter`], axis by axis: distances to all are worked out side by side.
    jitter: [[f32; CELLS]; 3],
}

impl Around {
    fn move_to(&mut self, scatter: &Scatter, home: IVec3) {
        self.home = Some(home);
        for i in 0..CELLS {
            let step = STEPS.map(|axis| axis[i] as i32);
            let bits = scatter.bits(home + IVec3::from(step));
            let jitter = Scatter::jitter(bits).to_array();
            self.bits[i] = bits;
            for (of_all, jitter) in self.jitter.iter_mut().zip(jitter) {
                of_all[i] = jitter;
            }
        }
    }
}

/// Pieces that are kept: a power of two, more of the larger ones than reach a tile of a few km.
const KEPT: usize = 256;

/// What is known of pieces met lately: a place's neighbours meet the same ones.
pub(super) struct Lately<T>(Vec<Option<(IVec3, T)>>);

impl<T: Copy> Lately<T> {
    pub fn new() -> Self {
        Self(vec![None; KEPT])
    }

    /// What is known of a piece, or what is found out now.
    pub fn of(&mut self, piece: &Reached, find_out: impl FnOnce() -> T) -> T {
        let slot = &mut self.0[piece.bits as usize % KEPT];
        if let Some((cell, known)) = slot
            && *cell == piece.cell
        {
            return *known;
        }
        let found = find_out();
        *slot = Some((piece.cell, found));
        found
    }
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

    /// Visits all pieces that reach a place, given in m from the planet's centre, always in the same order. Cheap
    /// where the last place was in the same cell.
    pub fn visit(&self, around: &mut Around, place: DVec3, mut visit: impl FnMut(&Reached)) {
        let scaled = place / self.size;
        let floor = scaled.floor();
        let home = floor.as_ivec3();
        let within = (scaled - floor).as_vec3() - Vec3::splat(0.5);
        let size = self.size as f32;
        if around.home != Some(home) {
            around.move_to(self, home);
        }
        let jitter = &around.jitter;
        let mut left = [0.0; CELLS];
        for (i, left) in left.iter_mut().enumerate() {
            let x = within.x - STEPS[0][i] - jitter[0][i];
            let y = within.y - STEPS[1][i] - jitter[1][i];
            let z = within.z - STEPS[2][i] - jitter[2][i];
            *left = 1.0 - (x * x + y * y + z * z) / (REACH * REACH);
        }
        for (i, left) in left.into_iter().enumerate() {
            if left > 0.0 {
                let at = |of: &[[f32; CELLS]; 3]| Vec3::new(of[0][i], of[1][i], of[2][i]);
                let step = at(&STEPS);
                let offset = within - step - at(jitter);
                visit(&Reached {
                    cell: home + step.as_ivec3(),
                    bits: around.bits[i],
                    offset: offset * size,
                    weight: left * left * left,
                    weight_slope: offset * (-6.0 * left * left / (REACH * REACH * size)),
                });
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
