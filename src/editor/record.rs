//! What the charts draw: kept while a planet grows, worked out once for each surface.

use crate::simulation::Statistics;
use egui_plot::PlotPoint;

/// Moments kept. Beyond that every second one is dropped, so that the whole history stays in sight.
const MOST: usize = 512;

/// Lower end and width of the bins of [`Statistics::hypsometry_500_m`] in km.
pub(super) const LOWEST_KM: f64 = -11.0;
pub(super) const BIN_KM: f64 = 0.5;

/// Figures over time.
#[derive(Debug, Clone, Default)]
pub(super) struct Record {
    pub mean_speed: Vec<PlotPoint>,
    pub median_speed: Vec<PlotPoint>,
    pub plates: Vec<PlotPoint>,
    /// Share in per cent of each bin, at its middle in km.
    pub bins: Vec<PlotPoint>,
    /// Share in per cent above an elevation in km.
    pub above: Vec<PlotPoint>,
    /// Moments are at least this far apart, in My.
    spacing_my: f64,
}

impl Record {
    /// Adds a moment. An earlier one than the last begins another history.
    pub(super) fn push(&mut self, time_my: f64, statistics: &Statistics) {
        if !time_my.is_finite() {
            return;
        }
        if self.mean_speed.last().is_some_and(|last| time_my < last.x) {
            *self = Self::default();
        }
        self.measure(&statistics.hypsometry_500_m);
        // The newest moment is always there; it gives way to the next if they are too close.
        let before = self.mean_speed.len().checked_sub(2);
        let close = before
            .and_then(|i| self.mean_speed.get(i))
            .is_some_and(|before| time_my - before.x < self.spacing_my)
            || self.mean_speed.last().is_some_and(|last| last.x >= time_my);
        let values = [
            statistics.speed_mean,
            statistics.speed_median,
            statistics.plates as f64,
        ];
        let series = [
            &mut self.mean_speed,
            &mut self.median_speed,
            &mut self.plates,
        ];
        for (series, value) in series.into_iter().zip(values) {
            if close {
                series.pop();
            }
            let value = if value.is_finite() { value } else { 0.0 };
            series.push(PlotPoint::new(time_my, value));
        }
        if self.mean_speed.len() > MOST {
            self.thin();
        }
    }

    /// Drops every second moment, but neither the first nor the last.
    fn thin(&mut self) {
        for series in [
            &mut self.mean_speed,
            &mut self.median_speed,
            &mut self.plates,
        ] {
            let last = series.len() - 1;
            let mut number = 0;
            series.retain(|_| {
                let keep = number % 2 == 0 || number == last;
                number += 1;
                keep
            });
        }
        if let [first, .., last] = &self.mean_speed[..] {
            self.spacing_my = 2.0 * (last.x - first.x) / MOST as f64;
        }
    }

    fn measure(&mut self, shares: &[f64]) {
        self.bins.clear();
        self.above.clear();
        let total: f64 = shares.iter().sum();
        let mut above = 100.0 * total;
        self.above.push(PlotPoint::new(above, LOWEST_KM));
        for (i, share) in shares.iter().enumerate() {
            let low = LOWEST_KM + BIN_KM * i as f64;
            self.bins
                .push(PlotPoint::new(low + 0.5 * BIN_KM, 100.0 * share));
            above -= 100.0 * share;
            self.above
                .push(PlotPoint::new(above.max(0.0), low + BIN_KM));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures(speed: f64) -> Statistics {
        Statistics {
            speed_mean: speed,
            plates: 12,
            hypsometry_500_m: vec![0.025; 40],
            ..Statistics::default()
        }
    }

    #[test]
    fn the_record_is_bounded_and_spans_the_history() {
        let mut record = Record::default();
        for step in 0..10_000 {
            record.push(f64::from(step) * 0.7, &figures(f64::from(step)));
            assert!(record.mean_speed.len() <= MOST);
            assert_eq!(record.mean_speed.len(), record.plates.len());
            assert_eq!(record.mean_speed.len(), record.median_speed.len());
            let last = record.mean_speed.last().map(|point| (point.x, point.y));
            assert_eq!(last, Some((f64::from(step) * 0.7, f64::from(step))));
        }
        assert_eq!(record.mean_speed[0].x, 0.0);
        assert!(record.mean_speed.len() > MOST / 4);
        assert!(record.mean_speed.is_sorted_by(|a, b| a.x < b.x));
        let gap = record
            .mean_speed
            .windows(2)
            .map(|pair| pair[1].x - pair[0].x)
            .fold(0.0, f64::max);
        assert!(gap < 7000.0 / 64.0, "{gap}");
    }

    #[test]
    fn another_history_begins_anew() {
        let mut record = Record::default();
        record.push(10.0, &figures(1.0));
        record.push(10.0, &figures(2.0));
        assert_eq!(record.mean_speed.len(), 1);
        assert_eq!(record.mean_speed[0].y, 2.0);
        record.push(0.0, &figures(f64::NAN));
        assert_eq!(record.mean_speed.len(), 1);
        assert_eq!(record.mean_speed[0].y, 0.0);
        record.push(f64::NAN, &figures(3.0));
        assert_eq!(record.mean_speed.len(), 1);
    }

    #[test]
    fn the_curve_falls_from_all_to_nothing() {
        let mut record = Record::default();
        record.push(0.0, &figures(1.0));
        assert_eq!(record.bins.len(), 40);
        assert!((record.above[0].x - 100.0).abs() < 1e-9);
        assert!(record.above[40].x.abs() < 1e-9);
        assert_eq!(record.above[22].y, 0.0);
    }
}
