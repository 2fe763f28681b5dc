//! Heights and crust.

use super::{Statistics, View, ratio};
use glam::DVec3;

/// Lower end of the hypsometry and width of its bins, in m.
const LOWEST_M: f64 = -11_000.0;
const BIN_M: f64 = 500.0;
const BINS: usize = 40;
/// Between the peak of continents and that of the sea floor, in m.
const VALLEY_M: f64 = -2_000.0;

impl Statistics {
    /// Earth's [`hypsometry_500_m`](Self::hypsometry_500_m): computed from the bedrock of ETOPO1 (NOAA
    /// 2009, public domain), averaged onto 1024 × 512 cells and weighted by their areas. Without ice
    /// sheets, as planets grow here; sums to 1.
    pub const EARTH_HYPSOMETRY_500_M: [f64; BINS] = [
        0.0, 0.0, 0.0, 0.00001, 0.00003, 0.00016, 0.0002, 0.00028, 0.0006, 0.00417, 0.04054,
        0.09939, 0.1119, 0.11584, 0.09619, 0.06665, 0.03782, 0.02293, 0.01707, 0.01511, 0.01923,
        0.07229, 0.16883, 0.05659, 0.02918, 0.01038, 0.00478, 0.00212, 0.00128, 0.0014, 0.00172,
        0.00202, 0.00122, 0.00007, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    ];
}

pub(super) fn measure(view: &View, statistics: &mut Statistics) {
    let mut bins = vec![0.0; BINS];
    let (mut land, mut wet, mut oceanic, mut volume) = (0.0, 0.0, 0.0, 0.0);
    let mut continents = DVec3::ZERO;
    statistics.highest_m = f64::MIN;
    statistics.lowest_m = f64::MAX;
    for (v, &share) in view.share.iter().enumerate() {
        let z = view.elevation(v);
        let bin = ((z - LOWEST_M) / BIN_M)
            .floor()
            .clamp(0.0, (BINS - 1) as f64);
        bins[bin as usize] += share;
        statistics.highest_m = statistics.highest_m.max(z);
        statistics.lowest_m = statistics.lowest_m.min(z);
        if z > 0.0 {
            land += share;
            statistics.mean_land_m += z * share;
        } else {
            wet += share;
            statistics.mean_ocean_m += z * share;
        }
        for (measure, within) in [
            (&mut statistics.shelf_200_share, (-200.0..=0.0).contains(&z)),
            (&mut statistics.shelf_500_share, (-500.0..=0.0).contains(&z)),
            (&mut statistics.above_2_km_share, z > 2000.0),
            (&mut statistics.below_6_km_share, z < -6000.0),
        ] {
            if within {
                *measure += share;
            }
        }
        let thickness = view.thickness[v].0;
        if view.crust[v].is_continental() {
            statistics.continental_share += share;
            statistics.continental_thickness_km += thickness * share;
            continents += view.mesh.site(v as u32) * share;
            volume += thickness * view.area[v].0;
        } else {
            oceanic += share;
            statistics.oceanic_thickness_km += thickness * share;
        }
    }
    let continental = statistics.continental_share;
    statistics.land_share = land;
    statistics.mean_land_m = ratio(statistics.mean_land_m, land);
    statistics.mean_ocean_m = ratio(statistics.mean_ocean_m, wet);
    statistics.continental_thickness_km = ratio(statistics.continental_thickness_km, continental);
    statistics.oceanic_thickness_km = ratio(statistics.oceanic_thickness_km, oceanic);
    statistics.continental_concentration = ratio(continents.length(), continental);
    statistics.ledger_gap = view.ledger.closing_error(volume);

    let valley = ((VALLEY_M - LOWEST_M) / BIN_M) as usize;
    (statistics.ocean_peak_m, statistics.ocean_peak_share) = peak(&bins[..valley], 0);
    (statistics.land_peak_m, statistics.land_peak_share) = peak(&bins[valley..], valley);
    statistics.hypsometry_500_m = bins;
}

/// Middle and share of the fullest bin, the lowest of equals; zeros if all are empty.
fn peak(bins: &[f64], first: usize) -> (f64, f64) {
    let mut best = (0.0, 0.0);
    for (bin, &share) in bins.iter().enumerate() {
        if share > best.1 {
            best = (LOWEST_M + BIN_M * ((first + bin) as f64 + 0.5), share);
        }
    }
    best
}
