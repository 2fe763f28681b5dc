//! Pieces of ground that terrain is put together from: small, periodic, in units of their own deviation.

use std::sync::{Arc, OnceLock};

/// Width of a texel in m.
pub(super) const TEXEL_M: f32 = 160.0;
/// Texels along a side: a power of two.
pub(super) const SIDE: usize = 256;
/// Grey of the mean, and of one deviation.
const GREY: (f32, f32) = (32_768.0, 8_000.0);
/// Coarser versions of a piece, each with half as many texels along a side: after the last nothing is left.
const LEVELS: usize = 7;
/// No texel lies further from the mean, in deviations: one peak does not make a landscape.
const FURTHEST: f32 = 4.0;

/// Kinds of ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Landform {
    /// Ranges along the strike: young mountains over a trench.
    Cordillera,
    /// Crests between great valleys: young mountains where continents meet.
    Collision,
    /// Long low ridges: mountains worn down.
    Old,
    /// Low hills.
    Plain,
    /// Volcanoes.
    Arc,
    /// Tilted blocks of stretched crust.
    Rift,
}

impl Landform {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Cordillera,
        Self::Collision,
        Self::Old,
        Self::Plain,
        Self::Arc,
        Self::Rift,
    ];
}

/// What is wrong with an exemplar.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExemplarError {
    /// The file is no PNG image that can be read.
    #[error("not a PNG image that can be read: {0}")]
    Unreadable(String),
    /// Not of the right size.
    #[error("an exemplar needs {expected} heights, {found} were given")]
    Size {
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// Holes in the data, or numbers that are none: filling them would make plateaus.
    #[error("height {0} is not a number, or a void (-32768)")]
    Void(usize),
    /// Measured ground that no exemplar can be cut from.
    #[error("not a survey to cut an exemplar from: {0}")]
    Survey(String),
    /// All heights are alike.
    #[error("all heights are alike")]
    Flat,
}

/// How much of a piece is shown: which of its versions, and how far towards the coarser one after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Level {
    pub finer: usize,
    pub share: f32,
}

impl Level {
    /// What is larger than a texel of this width in m.
    pub fn of(texel_m: f64) -> Self {
        let level = libm::log2(texel_m / f64::from(TEXEL_M)).clamp(0.0, LEVELS as f64);
        let finer = (level as usize).min(LEVELS);
        Self {
            finer,
            share: (level - finer as f64) as f32,
        }
    }

    /// Whether anything is left.
    pub fn is_any(self) -> bool {
        self.finer < LEVELS
    }
}

/// A piece of ground, 256 × 256 heights of texels of 160 m that go on at the opposite side.
#[derive(Debug, Clone, PartialEq)]
pub struct Exemplar {
    /// From fine to coarse; weights of quadratic B-splines.
    levels: Vec<Vec<f32>>,
    /// What the versions before each lack, in deviations at most.
    errors: [f32; LEVELS + 1],
}

impl Exemplar {
    /// From heights in any unit, row by row: rows run along the fold, columns across it. The mean is taken away,
    /// the deviation becomes 1, and what lies further off than four is cut.
    ///
    /// # Errors
    /// [`ExemplarError`] if there are not 65,536 heights, if one of them is missing, or if all are alike.
    pub fn new(heights: &[f32]) -> Result<Self, ExemplarError> {
        if heights.len() != SIDE * SIDE {
            return Err(ExemplarError::Size {
                found: heights.len(),
                expected: SIDE * SIDE,
            });
        }
        let is_void = |height: &f32| !height.is_finite() || *height == -32_768.0;
        if let Some(at) = heights.iter().position(is_void) {
            return Err(ExemplarError::Void(at));
        }
        let count = heights.len() as f64;
        let mean = heights.iter().map(|&h| f64::from(h)).sum::<f64>() / count;
        let square = |h: &f32| (f64::from(*h) - mean) * (f64::from(*h) - mean);
        let deviation = (heights.iter().map(square).sum::<f64>() / count).sqrt();
        if deviation < 1e-9 {
            return Err(ExemplarError::Flat);
        }
        let scaled = heights
            .iter()
            .map(|&h| ((f64::from(h) - mean) / deviation) as f32);
        let mut levels: Vec<Vec<f32>> =
            vec![scaled.map(|h| h.clamp(-FURTHEST, FURTHEST)).collect()];
        while levels.len() < LEVELS {
            levels.push(halve(&levels[levels.len() - 1]));
        }
        let mut exemplar = Self {
            levels,
            errors: [0.0; LEVELS + 1],
        };
        exemplar.measure();
        Ok(exemplar)
    }

    /// From a grey PNG image of 256 × 256, 16 bits deep.
    ///
    /// # Errors
    /// [`ExemplarError`] if it is not that, or if all heights are alike.
    pub fn from_png(bytes: &[u8]) -> Result<Self, ExemplarError> {
        let unreadable =
            |what: &dyn core::fmt::Display| ExemplarError::Unreadable(what.to_string());
        let decoder = png::Decoder::new(std::io::Cursor::new(bytes));
        let mut reader = decoder.read_info().map_err(|error| unreadable(&error))?;
        let info = reader.info();
        if (info.color_type, info.bit_depth) != (png::ColorType::Grayscale, png::BitDepth::Sixteen)
        {
            return Err(unreadable(&"it is not grey with 16 bits"));
        }
        let found = info.width as usize * info.height as usize;
        if (info.width as usize, info.height as usize) != (SIDE, SIDE) {
            return Err(ExemplarError::Size {
                found,
                expected: SIDE * SIDE,
            });
        }
        let mut grey = vec![0; 2 * found];
        reader
            .next_frame(&mut grey)
            .map_err(|error| unreadable(&error))?;
        let (pairs, _) = grey.as_chunks::<2>();
        let heights = pairs
            .iter()
            .map(|pair| (f32::from(u16::from_be_bytes(*pair)) - GREY.0) / GREY.1);
        Self::new(&heights.collect::<Vec<f32>>())
    }

    /// Value in deviations and slope per texel of the finest version, at a place in its texels. Both are
    /// continuous.
    pub(super) fn at(&self, [x, y]: [f32; 2], level: Level) -> (f32, [f32; 2]) {
        let mut sum = (0.0, [0.0; 2]);
        let shares = [
            (level.finer, 1.0 - level.share),
            (level.finer + 1, level.share),
        ];
        for (number, share) in shares.into_iter().filter(|(_, share)| *share > 0.0) {
            let Some(texels) = self.levels.get(number) else {
                continue;
            };
            let side = SIDE >> number;
            let scale = 1.0 / (1_u32 << number) as f32;
            // Texels are squares: coarse ones have their middles between those of the fine ones.
            let (value, slope) = spline(texels, side, [x, y].map(|x| (x + 0.5) * scale - 0.5));
            sum.0 += share * value;
            sum.1[0] += share * scale * slope[0];
            sum.1[1] += share * scale * slope[1];
        }
        sum
    }

    /// Weights of the splines of all versions, the finest first, row by row.
    #[cfg(feature = "render")]
    pub(super) fn weights(&self) -> impl Iterator<Item = f32> {
        self.levels.iter().flatten().copied()
    }

    /// What finer versions could add, in deviations.
    pub(super) fn error(&self, level: Level) -> f32 {
        let last = self.errors[(level.finer + 1).min(LEVELS)];
        self.errors[level.finer] * (1.0 - level.share) + last * level.share
    }

    /// Measures what each version lacks.
    fn measure(&mut self) {
        let alone = |finer: usize| Level { finer, share: 0.0 };
        // Corners of texels and their middles.
        for i in 0..2 * SIDE * SIDE {
            let shift = if i < SIDE * SIDE { 0.5 } else { 0.0 };
            let at = [(i % SIDE) as f32 + shift, (i / SIDE % SIDE) as f32 + shift];
            let full = self.at(at, alone(0)).0;
            for number in 1..=LEVELS {
                let lacking = (full - self.at(at, alone(number)).0).abs();
                self.errors[number] = self.errors[number].max(lacking);
            }
        }
        // A quarter for what lies between the places measured.
        self.errors.iter_mut().for_each(|error| *error *= 1.25);
    }
}

/// Means of four.
fn halve(texels: &[f32]) -> Vec<f32> {
    let side = texels.len().isqrt();
    let half = side / 2;
    (0..half * half)
        .map(|i| {
            let corner = 2 * (i / half) * side + 2 * (i % half);
            0.25 * (texels[corner]
                + texels[corner + 1]
                + texels[corner + side]
                + texels[corner + side + 1])
        })
        .collect()
}

/// The quadratic B-spline through nine texels: value, and slope per texel.
fn spline(texels: &[f32], side: usize, [x, y]: [f32; 2]) -> (f32, [f32; 2]) {
    let (column, across) = knots(x);
    let (row, along) = knots(y);
    let mask = side as i32 - 1;
    let (mut value, mut slope) = (0.0, [0.0; 2]);
    for (j, (wy, dy)) in (-1..=1).zip(along) {
        let row = ((row + j) & mask) as usize * side;
        let (mut sum, mut change) = (0.0, 0.0);
        for (i, (wx, dx)) in (-1..=1).zip(across) {
            let texel = texels[row + ((column + i) & mask) as usize];
            sum += wx * texel;
            change += dx * texel;
        }
        value += wy * sum;
        slope[0] += wy * change;
        slope[1] += dy * sum;
    }
    (value, slope)
}

/// The texel nearest to a place, and weights of it and its neighbours with their slopes.
fn knots(x: f32) -> (i32, [(f32, f32); 3]) {
    // Offsets are a few hundred texels: made positive, a cast rounds them down, faster than a call does.
    const UP: i32 = 1 << 14;
    let nearest = (x + 0.5 + UP as f32) as i32 - UP;
    let t = x - nearest as f32;
    let (before, after) = (0.5 - t, 0.5 + t);
    let weights = [
        (0.5 * before * before, -before),
        (0.75 - t * t, -2.0 * t),
        (0.5 * after * after, after),
    ];
    (nearest, weights)
}

/// One piece of each kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Exemplars([Exemplar; 6]);

impl Exemplars {
    /// Those that come with the crate, which `examples/exemplars.rs` made. Read once.
    #[must_use]
    pub fn shipped() -> Arc<Self> {
        static SHIPPED: OnceLock<Arc<Exemplars>> = OnceLock::new();
        let read = || {
            let files: [&[u8]; 6] = [
                include_bytes!("../../../assets/terrain/cordillera.png"),
                include_bytes!("../../../assets/terrain/collision.png"),
                include_bytes!("../../../assets/terrain/old.png"),
                include_bytes!("../../../assets/terrain/plain.png"),
                include_bytes!("../../../assets/terrain/arc.png"),
                include_bytes!("../../../assets/terrain/rift.png"),
            ];
            let read = |bytes| Exemplar::from_png(bytes).expect("a test reads all of them");
            Arc::new(Self(files.map(read)))
        };
        SHIPPED.get_or_init(read).clone()
    }

    /// The same with another piece for one kind.
    #[must_use]
    pub fn with(mut self, landform: Landform, exemplar: Exemplar) -> Self {
        self.0[landform as usize] = exemplar;
        self
    }

    /// The piece of a kind.
    #[must_use]
    pub fn get(&self, landform: Landform) -> &Exemplar {
        &self.0[landform as usize]
    }
}
