//! Sizes and speeds of plates.

use super::{Statistics, View, line_slope, quantile, ratio, sort};
use crate::simulation::sub_plate::PlateId;
use core::{f64::consts::PI, ops::RangeInclusive};
use glam::{DMat3, DVec3};
use std::collections::BTreeMap;

/// Share of the sphere from which a plate counts as large.
const LARGE: f64 = 5e-4;
/// Areas over which Earth's plates follow a power law, in steradians (Bird 2003).
const LAW: RangeInclusive<f64> = 0.002..=1.0;

/// Speed against its plate from which a place deforms, in km/My.
const DEFORMING: f64 = 1.0;

/// A plate's share of the sphere, and that of its continental part.
#[derive(Default, Clone, Copy)]
struct Size {
    share: f64,
    continental: f64,
}

pub(super) fn measure(view: &View, statistics: &mut Statistics) {
    let mut sizes: BTreeMap<PlateId, Size> = BTreeMap::new();
    for (v, &share) in view.share.iter().enumerate() {
        let size = sizes.entry(view.plate[v]).or_default();
        size.share += share;
        if view.crust[v].is_continental() {
            size.continental += share;
        }
    }
    measure_sizes(view, &sizes, statistics);
    measure_speeds(view, &sizes, statistics);
}

fn measure_sizes(view: &View, sizes: &BTreeMap<PlateId, Size>, statistics: &mut Statistics) {
    let mut shares: Vec<f64> = sizes.values().map(|size| size.share).collect();
    shares.sort_by(|a, b| b.total_cmp(a));
    let largest = |number: usize| shares.iter().take(number).sum();
    statistics.plates = shares.len();
    statistics.large_plates = shares.iter().filter(|&&share| share >= LARGE).count();
    statistics.largest_plate = largest(1);
    statistics.largest_7_plates = largest(7);
    statistics.largest_14_plates = largest(14);

    let radius = view.recipe.radius_km;
    let sphere_km2 = 4.0 * PI * radius * radius;
    let middle = |i: usize| shares.get(i).copied().unwrap_or_default();
    let half = shares.len() / 2;
    let median = if shares.len() % 2 == 1 {
        middle(half)
    } else {
        0.5 * (middle(half.saturating_sub(1)) + middle(half))
    };
    statistics.plate_area_median_km2 = median * sphere_km2;

    let law: Vec<[f64; 3]> = shares
        .iter()
        .enumerate()
        .map(|(smaller, share)| (share * 4.0 * PI, (smaller + 1) as f64))
        .filter(|(area, _)| LAW.contains(area))
        .map(|(area, number)| [libm::log(area), libm::log(number), 1.0])
        .collect();
    statistics.plate_size_exponent = if law.len() >= 3 {
        line_slope(law.into_iter())
    } else {
        0.0
    };
}

fn measure_speeds(view: &View, sizes: &BTreeMap<PlateId, Size>, statistics: &mut Statistics) {
    let velocity = |v: usize| view.velocity[v].0.as_dvec3();
    // The rotation that all of the surface has in common.
    let mut inertia = DMat3::ZERO;
    let mut spin = DVec3::ZERO;
    for (v, &share) in view.share.iter().enumerate() {
        let site = view.mesh.site(v as u32);
        let outer = DMat3::from_cols(site * site.x, site * site.y, site * site.z);
        inertia += (DMat3::IDENTITY - outer) * share;
        spin += site.cross(velocity(v)) * share;
    }
    let net = inertia.inverse() * spin;
    let mut squares = 0.0;
    // Oceanic, continental: sum of speeds, share.
    let mut kinds = [(0.0, 0.0); 2];
    let mut speeds: Vec<(f64, f64)> = Vec::with_capacity(view.share.len());
    for (v, &share) in view.share.iter().enumerate() {
        let speed = (velocity(v) - net.cross(view.mesh.site(v as u32))).length();
        speeds.push((speed, share));
        statistics.speed_mean += speed * share;
        squares += speed * speed * share;
        let site = view.mesh.site(v as u32);
        let rigid = view.plates.rotation(view.plate[v]).cross(site) * view.recipe.radius_km;
        if rigid.distance(velocity(v)) > DEFORMING {
            statistics.deforming_share += share;
        }
        let size = sizes.get(&view.plate[v]).copied().unwrap_or_default();
        let kind = &mut kinds[usize::from(2.0 * size.continental > size.share)];
        kind.0 += speed * share;
        kind.1 += share;
    }
    sort(&mut speeds);
    statistics.speed_rms = squares.sqrt();
    statistics.speed_p10 = quantile(&speeds, 0.1);
    statistics.speed_median = quantile(&speeds, 0.5);
    statistics.speed_p90 = quantile(&speeds, 0.9);
    let [oceanic, continental] = kinds.map(|(sum, share)| ratio(sum, share));
    statistics.speed_oceanic_plates = oceanic;
    statistics.speed_continental_plates = continental;
}
