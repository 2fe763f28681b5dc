//! Depth, age and turnover of the sea floor. Depth at ridges is measured where ridges are, in
//! `boundaries.rs`.

use super::{Statistics, View, line_slope, quantile, ratio, sort};

/// Bins of the histogram of ages.
const BINS: usize = 30;
const BIN_MY: f64 = 10.0;
/// Depth follows the root of age up to here (Parsons & Sclater 1977).
const ROOT_LAW_MY: f64 = 70.0;
/// Oldest age of Earth's nearly triangular distribution (Rowley 2002).
const OLDEST_MY: f64 = 180.0;
/// km²/My in km²/yr.
const PER_YEAR: f64 = 1e-6;

pub(super) fn measure(view: &View, before: Option<&Statistics>, statistics: &mut Statistics) {
    let mut ages: Vec<(f64, f64)> = Vec::new();
    // Root of age, depth, weight.
    let mut young: Vec<[f64; 3]> = Vec::new();
    for (v, &share) in view.share.iter().enumerate() {
        if view.crust[v].is_continental() {
            continue;
        }
        let age = view.age(v);
        ages.push((age, share));
        if (0.0..ROOT_LAW_MY).contains(&age) {
            young.push([age.sqrt(), -view.elevation(v), share]);
        }
    }
    measure_ages(ages, statistics);
    measure_depths(&young, statistics);
    measure_turnover(view, before, statistics);
}

fn measure_ages(mut ages: Vec<(f64, f64)>, statistics: &mut Statistics) {
    sort(&mut ages);
    let floor: f64 = ages.iter().map(|(_, share)| share).sum();
    let mut bins = vec![0.0; BINS];
    let (mut younger, mut distance) = (0.0, 0.0_f64);
    for &(age, share) in &ages {
        let share = ratio(share, floor);
        statistics.ocean_age_mean_my += age * share;
        let bin = (age / BIN_MY).floor().clamp(0.0, (BINS - 1) as f64);
        bins[bin as usize] += share;
        let left = 1.0 - age.clamp(0.0, OLDEST_MY) / OLDEST_MY;
        let law = 1.0 - left * left;
        // The steps of the distribution are as far from the law at their foot as at their head.
        distance = distance.max((younger - law).abs());
        younger += share;
        distance = distance.max((younger - law).abs());
    }
    statistics.ocean_age_oldest_my = ages.last().map_or(0.0, |oldest| oldest.0.max(0.0));
    statistics.ocean_age_995_my = quantile(&ages, 0.995);
    statistics.ocean_age_distance = distance;
    statistics.ocean_age_histogram_10_my = bins;
}

fn measure_depths(young: &[[f64; 3]], statistics: &mut Statistics) {
    let residual = |[root, depth, _]: &[f64; 3]| depth - (2600.0 + 350.0 * root);
    let mut residuals: Vec<(f64, f64)> = young.iter().map(|row| (residual(row), row[2])).collect();
    sort(&mut residuals);
    statistics.age_depth_bias_m = quantile(&residuals, 0.5);
    residuals.iter_mut().for_each(|row| row.0 = row.0.abs());
    sort(&mut residuals);
    statistics.age_depth_error_m = quantile(&residuals, 0.5);
    statistics.age_depth_slope = line_slope(young.iter().copied());
}

fn measure_turnover(view: &View, before: Option<&Statistics>, statistics: &mut Statistics) {
    let ledger = view.ledger;
    statistics.floor_made_km2 = ledger.area_created_km2;
    // The ledger counts continents crushed in collisions among what was consumed.
    statistics.floor_consumed_km2 = ledger.area_consumed_km2 - ledger.area_shortened_km2;
    let (since, made, consumed) = before.map_or((0.0, 0.0, 0.0), |before| {
        (
            before.time_my,
            before.floor_made_km2,
            before.floor_consumed_km2,
        )
    });
    let interval = view.time_my - since;
    statistics.interval_my = interval;
    statistics.floor_made_km2_yr = ratio(statistics.floor_made_km2 - made, interval) * PER_YEAR;
    statistics.floor_consumed_km2_yr =
        ratio(statistics.floor_consumed_km2 - consumed, interval) * PER_YEAR;
}
