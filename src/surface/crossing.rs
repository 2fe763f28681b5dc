//! Where a ray crosses the ground of one triangle.

/// Halvings that bring any bracket below rounding.
const HALVINGS: usize = 60;

/// Height of a ray above the ground along its way `s`, which is 0 where the ray is closest to the
/// centre of the planet: √(closest² + s²) − 1 − scale · (a + b s)/(c + d s). All in radii.
///
/// Within a triangle the ground is linear in the corners' weights, and so a quotient of two linear
/// functions of `s`: the curvature of the whole is known in closed form.
#[derive(Clone, Copy)]
pub(super) struct Height {
    /// Square of the distance at which the ray passes the centre.
    pub(super) closest2: f64,
    /// Radii per metre of elevation.
    pub(super) scale: f64,
    /// Elevation times the sum of weights: constant and linear part, in m.
    pub(super) elevation: [f64; 2],
    /// Sum of the weights: constant and linear part; positive within the triangle.
    pub(super) weight: [f64; 2],
}

impl Height {
    pub(super) fn at(&self, s: f64) -> f64 {
        let [a, b] = self.elevation;
        let [c, d] = self.weight;
        let weight = c + d * s;
        let ground = if weight > 0.0 {
            (a + b * s) / weight
        } else {
            0.0
        };
        (self.closest2 + s * s).sqrt() - 1.0 - self.scale * ground
    }

    /// Derivative by `s`.
    fn rise(&self, s: f64) -> f64 {
        let [a, b] = self.elevation;
        let [c, d] = self.weight;
        let weight = c + d * s;
        let radius = (self.closest2 + s * s).sqrt();
        s / radius.max(f64::MIN_POSITIVE) - self.scale * (b * c - a * d) / (weight * weight)
    }

    /// Second derivative by `s`.
    fn bend(&self, s: f64) -> f64 {
        let [a, b] = self.elevation;
        let [c, d] = self.weight;
        let (weight, radius) = (c + d * s, (self.closest2 + s * s).sqrt());
        self.closest2 / (radius * radius * radius)
            + 2.0 * self.scale * d * (b * c - a * d) / (weight * weight * weight)
    }

    /// The two ways at which the curvature may change its sign, ascending; infinite where it does not.
    fn inflections(&self) -> [f64; 2] {
        const NONE: [f64; 2] = [f64::INFINITY; 2];
        let [a, b] = self.elevation;
        let [c, d] = self.weight;
        let pull = -2.0 * self.scale * d * (b * c - a * d);
        if !(pull > 0.0 && self.closest2 > 0.0) {
            return NONE;
        }
        // closest²/ρ³ = pull/weight³, that is weight = q ρ.
        let q = libm::cbrt(pull / self.closest2);
        let (x, y, z) = (d * d - q * q, 2.0 * c * d, c * c - q * q * self.closest2);
        let discriminant = y * y - 4.0 * x * z;
        if discriminant.is_nan() || discriminant < 0.0 {
            return NONE;
        }
        // The form without cancellation.
        let sum = -0.5 * (y + y.signum() * discriminant.sqrt());
        let roots = [sum / x, z / sum].map(|s| if s.is_finite() { s } else { f64::INFINITY });
        [roots[0].min(roots[1]), roots[0].max(roots[1])]
    }

    /// The first way from `from` to `to` at which a ray crosses the ground that it is above
    /// (`side` = 1) or below (−1).
    pub(super) fn crossing(&self, from: f64, to: f64, side: f64) -> Option<f64> {
        if side * self.at(from) <= 0.0 {
            return Some(from);
        }
        let [first, second] = self.inflections().map(|s| s.max(from).min(to));
        let mut start = from;
        for end in [first, second, to] {
            if end > start {
                if let Some(s) = self.crossing_of_arc(start, end, side) {
                    return Some(s);
                }
                start = end;
            }
        }
        None
    }

    /// As [`crossing`](Self::crossing) where the curvature keeps its sign and the start has not crossed.
    fn crossing_of_arc(&self, from: f64, to: f64, side: f64) -> Option<f64> {
        let height = |s: f64| side * self.at(s);
        if height(to) <= 0.0 {
            return Some(bisect(from, to, |s| height(s) <= 0.0));
        }
        // Above at both ends, a ray only touches ground that it dips towards in between.
        let rise = |s: f64| side * self.rise(s);
        let dips = side * self.bend(0.5 * (from + to)) > 0.0 && rise(from) < 0.0 && rise(to) > 0.0;
        if !dips {
            return None;
        }
        let lowest = bisect(from, to, |s| rise(s) >= 0.0);
        (height(lowest) <= 0.0).then(|| bisect(from, lowest, |s| height(s) <= 0.0))
    }
}

/// Where a condition begins to hold that does not at `from` and does at `to`; holds there.
fn bisect(mut from: f64, mut to: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (from + to);
        if middle <= from || middle >= to {
            break;
        }
        if holds(middle) {
            to = middle;
        } else {
            from = middle;
        }
    }
    to
}
