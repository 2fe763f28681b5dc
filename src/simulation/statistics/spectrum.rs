//! How rough the ground is.

use super::{View, line_slope};

/// Degrees over which the slope is taken: below lie the continents' own shapes, and 2,500 sub-plates
/// hold no more than 25 degrees well.
const LOWEST: usize = 5;
const HIGHEST: usize = 24;
/// Sub-plates worked on at once: their fields fit the processor's first cache.
const BLOCK: usize = 512;

/// Slope of the power of elevation per degree against the degree, both as logarithms; 0 where the
/// ground is flat.
///
/// Power of a degree is the sum of its squared coefficients in 4π-normalised real spherical harmonics,
/// each by quadrature over the cells. Associated Legendre functions come from the standard recurrence by
/// degree at fixed order (Holmes & Featherstone 2002); sines and cosines of longitudes come from
/// powers of x + iy.
pub(super) fn slope(view: &View) -> f64 {
    let power = power(view);
    let all: f64 = power.iter().sum();
    if all <= 1e-9 {
        return 0.0;
    }
    let points = power.iter().enumerate().skip(LOWEST);
    line_slope(points.map(|(degree, power)| {
        [
            libm::log(degree as f64),
            libm::log(power.max(1e-12 * all)),
            1.0,
        ]
    }))
}

/// Power of elevation by degree from [`LOWEST`] to [`HIGHEST`], in m²; 0 below.
fn power(view: &View) -> [f64; HIGHEST + 1] {
    let mean: f64 = view
        .share
        .iter()
        .enumerate()
        .map(|(v, share)| view.elevation(v) * share)
        .sum();
    let mut sums = vec![[[0.0; 2]; HIGHEST + 1]; HIGHEST + 1];
    let mut block = Block::default();
    for start in (0..view.share.len()).step_by(BLOCK) {
        let rows = start..(start + BLOCK).min(view.share.len());
        block.fill(rows.map(|v| {
            let height = (view.elevation(v) - mean) * view.share[v];
            (view.mesh.site(v as u32), height)
        }));
        let mut sectoral = 1.0;
        for (order, sums) in sums.iter_mut().enumerate() {
            if order > 0 {
                let twice = 2.0 * order as f64;
                sectoral *= ((twice + 1.0) / twice).sqrt();
                block.turn();
            }
            let both = if order == 0 {
                1.0
            } else {
                core::f64::consts::SQRT_2
            };
            block.begin(both * sectoral);
            for (degree, sum) in sums.iter_mut().enumerate().skip(order) {
                if degree > order {
                    block.climb(degree as f64, order as f64);
                }
                if degree >= LOWEST {
                    let [cosine, sine] = block.project();
                    sum[0] += cosine;
                    sum[1] += sine;
                }
            }
        }
    }
    let mut power = [0.0; HIGHEST + 1];
    for order in sums {
        for (power, [cosine, sine]) in power.iter_mut().zip(order) {
            *power += cosine * cosine + sine * sine;
        }
    }
    power
}

/// Fields of some sub-plates: place, height times the powers of x + iy, and two Legendre functions.
#[derive(Default)]
struct Block {
    place: Vec<[f64; 3]>,
    turned: Vec<[f64; 2]>,
    legendre: Vec<[f64; 2]>,
}

impl Block {
    fn fill(&mut self, cells: impl Iterator<Item = (glam::DVec3, f64)>) {
        self.place.clear();
        self.turned.clear();
        for (site, height) in cells {
            self.place.push(site.to_array());
            self.turned.push([height, 0.0]);
        }
    }

    /// From one order to the next.
    fn turn(&mut self) {
        for ([re, im], [x, y, _]) in self.turned.iter_mut().zip(&self.place) {
            (*re, *im) = (*re * x - *im * y, *re * y + *im * x);
        }
    }

    /// The function whose degree equals its order.
    fn begin(&mut self, sectoral: f64) {
        self.legendre.clear();
        self.legendre.resize(self.place.len(), [0.0, sectoral]);
    }

    /// From one degree to the next.
    fn climb(&mut self, degree: f64, order: f64) {
        let l = degree * degree;
        let m = order * order;
        let before = (degree - 1.0) * (degree - 1.0);
        let a = ((4.0 * l - 1.0) / (l - m)).sqrt();
        let b = if before > m {
            ((before - m) / (4.0 * before - 1.0)).sqrt()
        } else {
            0.0
        };
        for (pair, [_, _, z]) in self.legendre.iter_mut().zip(&self.place) {
            *pair = [pair[1], a * (z * pair[1] - b * pair[0])];
        }
    }

    /// Sum of height times function, for cosine and sine.
    fn project(&self) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for ([_, legendre], [re, im]) in self.legendre.iter().zip(&self.turned) {
            sums[0] += legendre * re;
            sums[1] += legendre * im;
        }
        sums
    }
}
