//! Makes the small pieces of eroded ground that terrain is put together from, `assets/terrain/*.png`:
//! `cargo run --release --example exemplars [FOLDER]`
//!
//! A piece is a square that goes on at its opposite side, 256 texels of 160 m wide. Rock rises, faster where the
//! kind of ground says so, rivers cut down by the stream power law (Howard 1994) while slopes creep, and what stands
//! after that is written in units of its own standard deviation: grey 32,768 is the mean, 8,000 further up is one
//! deviation higher. Rows run along the fold, columns across it.

use png::{BitDepth, ColorType, Encoder};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::{
    cmp::Reverse, collections::BinaryHeap, error::Error, f64::consts::TAU, fs::File, path::PathBuf,
};

/// Texels along a side.
const SIDE: usize = 256;
/// Width of a texel in m.
const TEXEL: f64 = 160.0;
/// Grey values of one standard deviation.
const DEVIATION: f64 = 8000.0;
/// Exponent of drainage area in the stream power law; 0.35 to 0.6 are found (Whipple & Tucker 1999).
const AREA_EXPONENT: f64 = 0.45;

/// What makes one kind of ground different from another.
struct Kind {
    name: &'static str,
    /// Rate at which rock rises, 0 to 1, at a place in texels.
    uplift: fn(&Noise, f64, f64) -> f64,
    /// How easily rivers cut, relative to what balances uplift.
    softness: fn(&Noise, f64, f64) -> f64,
    /// Where the rivers that leave the piece run: below 0.
    trunk: fn(&Noise, f64, f64) -> f64,
    /// Creep of slopes: how many texels wide hilltops are rounded.
    creep: f64,
    /// Steps of the erosion: few leave the first shape.
    steps: u32,
}

const KINDS: [Kind; 6] = [
    // Ranges along the strike with deep gorges across.
    Kind {
        name: "cordillera",
        uplift: |n, x, y| 0.5 + 0.5 * bands(n, x, y, 3.0, 0.35),
        softness: |n, x, y| 1.0 + 0.4 * n.at(2, x, y),
        trunk: |n, x, y| {
            ((y / SIDE as f64 - 0.5 + 0.09 * n.at(0, x, 0.0)).abs() - 0.006).abs() - 0.006
        },
        creep: 0.5,
        steps: 160,
    },
    // Sharp crests between great valleys.
    Kind {
        name: "collision",
        uplift: |n, x, y| 0.7 + 0.3 * n.at(1, x, y),
        softness: |n, x, y| 1.0 + 0.25 * n.at(2, x, y),
        trunk: |n, x, y| {
            let valley = (y / SIDE as f64 - 0.5 + 0.12 * n.at(0, x, 0.0)).abs() - 0.008;
            let cross = (x / SIDE as f64 - 0.5 + 0.10 * n.at(3, 0.0, y)).abs() - 0.008;
            valley.min(cross)
        },
        creep: 0.25,
        steps: 220,
    },
    // Long ridges of hard rock, and streams that follow the soft.
    Kind {
        name: "old",
        uplift: |n, x, y| 0.6 + 0.2 * n.at(1, x, y),
        softness: |n, x, y| 1.0 + 0.85 * bands(n, x, y, 7.0, 0.25),
        trunk: |n, x, y| (x / SIDE as f64 - 0.5 + 0.15 * n.at(3, 0.0, y)).abs() - 0.006,
        creep: 1.6,
        steps: 260,
    },
    // Low hills in all directions.
    Kind {
        name: "plain",
        uplift: |n, x, y| 0.6 + 0.3 * n.at(1, x, y),
        softness: |n, x, y| 1.0 + 0.3 * n.at(2, x, y),
        trunk: |n, x, y| n.at(0, x, y) + 1.9,
        creep: 2.5,
        steps: 160,
    },
    // Cones, and ravines that run away from them.
    Kind {
        name: "arc",
        uplift: |n, x, y| 0.15 + n.cones(x, y),
        softness: |n, x, y| 0.8 + 0.2 * n.at(2, x, y),
        trunk: |n, x, y| n.at(0, x, y) + 2.3,
        creep: 0.8,
        steps: 90,
    },
    // Tilted blocks: steep on one side, gentle on the other.
    Kind {
        name: "rift",
        uplift: |n, x, y| blocks(n, x, y),
        softness: |n, x, y| 0.5 + 0.2 * n.at(2, x, y),
        trunk: |n, x, y| (y / SIDE as f64 - 0.5 + 0.05 * n.at(0, x, 0.0)).abs() - 0.01,
        creep: 0.7,
        steps: 60,
    },
];

/// Waves along the strike, −1 to 1, that bend and end as folds do.
fn bands(noise: &Noise, x: f64, y: f64, count: f64, bend: f64) -> f64 {
    libm::sin(TAU * (count * y / SIDE as f64 + bend * noise.at(0, x, y)))
        * (0.7 + 0.3 * noise.at(1, x, y))
}

/// Saw teeth along the strike, 0 to 1.
fn blocks(noise: &Noise, x: f64, y: f64) -> f64 {
    let phase = 2.0 * y / SIDE as f64 + 0.12 * noise.at(0, x, y);
    let tooth = phase.rem_euclid(1.0);
    // A scarp is not quite a wall.
    if tooth < 0.08 {
        1.0 - tooth / 0.08
    } else {
        (tooth - 0.08) / 0.92
    }
}

/// Smooth random fields that go on at the opposite side: sums of waves.
struct Noise {
    fields: Vec<Vec<[f64; 4]>>,
    cones: Vec<[f64; 4]>,
}

impl Noise {
    fn new(rng: &mut ChaCha8Rng) -> Self {
        let fields = [3, 5, 24, 3].map(|highest| {
            let mut waves: Vec<[f64; 4]> = (0..40)
                .map(|_| {
                    let mut wave = || f64::from(rng.random_range(-highest..=highest));
                    let (i, j) = (wave(), wave());
                    let length = libm::hypot(i, j).max(1.0);
                    [i, j, TAU * rng.random::<f64>(), 1.0 / length]
                })
                .filter(|[i, j, ..]| *i != 0.0 || *j != 0.0)
                .collect();
            let power: f64 = waves.iter().map(|wave| 0.5 * wave[3] * wave[3]).sum();
            waves.iter_mut().for_each(|wave| wave[3] /= power.sqrt());
            waves
        });
        let cones = (0..9).map(|_| {
            let mut place = || SIDE as f64 * rng.random::<f64>();
            let (x, y) = (place(), place());
            [
                x,
                y,
                12.0 + 26.0 * rng.random::<f64>(),
                0.4 + 0.6 * rng.random::<f64>(),
            ]
        });
        Self {
            fields: fields.into(),
            cones: cones.collect(),
        }
    }

    /// One of the fields: mean 0, standard deviation 1.
    fn at(&self, field: usize, x: f64, y: f64) -> f64 {
        let (x, y) = (TAU * x / SIDE as f64, TAU * y / SIDE as f64);
        self.fields[field]
            .iter()
            .map(|[i, j, phase, amplitude]| amplitude * libm::sin(i * x + j * y + phase))
            .sum()
    }

    /// Height of the highest cone.
    fn cones(&self, x: f64, y: f64) -> f64 {
        let apart = |a: f64, b: f64| {
            let d = (a - b).rem_euclid(SIDE as f64);
            d.min(SIDE as f64 - d)
        };
        let height = |[cx, cy, radius, height]: &[f64; 4]| {
            // Steep at the top, as ash and lava pile up.
            height * libm::exp(-2.2 * libm::hypot(apart(x, *cx), apart(y, *cy)) / radius)
        };
        self.cones.iter().map(height).fold(0.0, f64::max)
    }
}

/// The eight texels around one, and their distances.
fn around(i: usize) -> impl Iterator<Item = (usize, f64)> {
    let (x, y) = (i % SIDE, i / SIDE);
    (0..9).filter(|k| *k != 4).map(move |k| {
        let (dx, dy) = (k % 3, k / 3);
        let j = (x + SIDE + dx - 1) % SIDE + (y + SIDE + dy - 1) % SIDE * SIDE;
        (
            j,
            if dx == 1 || dy == 1 {
                1.0
            } else {
                std::f64::consts::SQRT_2
            },
        )
    })
}

/// Where water goes from each texel, and an order in which it goes from later ones to earlier ones. Hollows fill
/// until they overflow (Barnes et al. 2014).
fn drain(height: &[f64], is_outlet: &[bool]) -> (Vec<usize>, Vec<(usize, f64)>) {
    // Heights are positive, so their bits are in their order.
    let mut queue: BinaryHeap<Reverse<(u64, usize)>> = BinaryHeap::new();
    let mut level: Vec<f64> = vec![f64::INFINITY; height.len()];
    let mut is_done = vec![false; height.len()];
    for i in (0..height.len()).filter(|&i| is_outlet[i]) {
        level[i] = height[i];
        queue.push(Reverse((level[i].to_bits(), i)));
    }
    let mut order = Vec::with_capacity(height.len());
    let mut to: Vec<(usize, f64)> = (0..height.len()).map(|i| (i, 1.0)).collect();
    while let Some(Reverse((_, i))) = queue.pop() {
        if std::mem::replace(&mut is_done[i], true) {
            continue;
        }
        if !is_outlet[i] {
            let lower = around(i).filter(|(j, _)| is_done[*j]);
            let steepest = lower.max_by(|a, b| {
                let slope = |(j, far): &(usize, f64)| (level[i] - level[*j]) / far;
                slope(a).total_cmp(&slope(b))
            });
            to[i] = steepest.expect("water came from somewhere");
        }
        order.push(i);
        for (j, _) in around(i) {
            let filled = height[j].max(level[i] + 1e-6);
            if !is_done[j] && filled < level[j] {
                level[j] = filled;
                queue.push(Reverse((filled.to_bits(), j)));
            }
        }
    }
    (order, to)
}

/// Lets rivers and slopes work on rising rock.
fn erode(kind: &Kind, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let noise = Noise::new(rng);
    let field = |f: fn(&Noise, f64, f64) -> f64| -> Vec<f64> {
        (0..SIDE * SIDE)
            .map(|i| f(&noise, (i % SIDE) as f64, (i / SIDE) as f64))
            .collect()
    };
    let uplift = field(kind.uplift);
    // Rock is never alike: without it, valleys would stand in rows like the teeth of a comb.
    let mut softness = field(kind.softness);
    softness
        .iter_mut()
        .for_each(|softness| *softness *= 0.85 + 0.3 * rng.random::<f64>());
    let mut is_outlet: Vec<bool> = field(kind.trunk).iter().map(|trunk| *trunk < 0.0).collect();
    if !is_outlet.contains(&true) {
        is_outlet[0] = true;
    }
    let mut height: Vec<f64> = (0..SIDE * SIDE)
        .map(|_| 0.01 + 0.01 * rng.random::<f64>())
        .collect();
    for _ in 0..kind.steps {
        for i in (0..height.len()).filter(|&i| !is_outlet[i]) {
            height[i] += 0.02 * uplift[i].max(0.0);
        }
        let (order, to) = drain(&height, &is_outlet);
        let mut area = vec![1.0_f64; height.len()];
        for &i in order.iter().rev() {
            if to[i].0 != i {
                area[to[i].0] += area[i];
            }
        }
        // Implicit, from the outlets upwards: stable at any step (Braun & Willett 2013).
        for &i in order.iter().filter(|&&i| !is_outlet[i]) {
            let (j, far) = to[i];
            let rate = 0.05 * softness[i].max(0.1) * libm::pow(area[i], AREA_EXPONENT) / far;
            if height[i] > height[j] {
                height[i] = (height[i] + rate * height[j]) / (1.0 + rate);
            }
        }
        let before = height.clone();
        for i in (0..height.len()).filter(|&i| !is_outlet[i]) {
            let mean = around(i)
                .map(|(j, far)| before[j] / (far * far))
                .sum::<f64>()
                / 6.0;
            height[i] += 0.02 * kind.creep * (mean - before[i]);
        }
    }
    height
}

/// Takes away the mean, which is the history's own ground, and makes the deviation 1.
fn stand_alone(height: &mut [f64]) {
    let mean_of = |f: fn(f64) -> f64, height: &[f64]| {
        height.iter().map(|&h| f(h)).sum::<f64>() / height.len() as f64
    };
    let mean = mean_of(|h| h, height);
    height.iter_mut().for_each(|height| *height -= mean);
    let deviation = mean_of(|h| h * h, height).sqrt();
    height.iter_mut().for_each(|height| *height /= deviation);
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(
        std::env::args()
            .nth(1)
            .unwrap_or_else(|| "assets/terrain".into()),
    );
    std::fs::create_dir_all(&folder)?;
    for (number, kind) in KINDS.iter().enumerate() {
        let mut height = erode(kind, &mut ChaCha8Rng::seed_from_u64(number as u64));
        stand_alone(&mut height);
        let bytes = height.iter().flat_map(|height| {
            let grey = (32_768.0 + DEVIATION * height).round().clamp(0.0, 65_535.0);
            (grey as u16).to_be_bytes()
        });
        let path = folder.join(format!("{}.png", kind.name));
        let mut encoder = Encoder::new(File::create(&path)?, SIDE as u32, SIDE as u32);
        encoder.set_color(ColorType::Grayscale);
        encoder.set_depth(BitDepth::Sixteen);
        encoder
            .write_header()?
            .write_image_data(&bytes.collect::<Vec<u8>>())?;
        let range = height
            .iter()
            .fold([f64::MAX, f64::MIN], |[a, b], &h| [a.min(h), b.max(h)]);
        println!(
            "{}: {:.2} to {:.2} deviations, texels of {TEXEL} m",
            path.display(),
            range[0],
            range[1]
        );
    }
    Ok(())
}
