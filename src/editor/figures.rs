//! How figures are written.

/// A whole number with separators: 1,234,567. Minus is a minus, not a hyphen.
pub(super) fn whole(value: f64) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    let digits = format!("{:.0}", value.abs());
    let mut text = String::with_capacity(digits.len() + 4);
    if value < 0.0 && digits != "0" {
        text.push('−');
    }
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i) % 3 == 0 {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A number with one decimal.
pub(super) fn tenth(value: f64) -> String {
    if value.is_finite() {
        format!("{value:.1}").replace('-', "−")
    } else {
        "–".into()
    }
}

/// A share in per cent.
pub(super) fn percent(share: f64) -> String {
    format!("{} %", tenth(100.0 * share))
}

/// A whole number with its unit.
pub(super) fn whole_in(value: f64, unit: &str) -> String {
    format!("{} {unit}", whole(value))
}

/// A number with one decimal and its unit.
pub(super) fn tenth_in(value: f64, unit: &str) -> String {
    format!("{} {unit}", tenth(value))
}

/// Latitude in degrees as 47.3° N.
pub(super) fn latitude(degrees: f64) -> String {
    hemisphere(degrees, 'N', 'S')
}

/// Longitude in degrees as 8.5° E.
pub(super) fn longitude(degrees: f64) -> String {
    hemisphere(degrees, 'E', 'W')
}

fn hemisphere(degrees: f64, positive: char, negative: char) -> String {
    let size = format!("{:.1}", degrees.abs());
    if size == "0.0" {
        "0.0°".into()
    } else {
        format!(
            "{size}° {}",
            if degrees < 0.0 { negative } else { positive }
        )
    }
}

/// An azimuth in degrees from north over east as 072° ENE.
pub(super) fn azimuth(degrees: f64) -> String {
    const POINTS: [&str; 16] = [
        "N", "NNE", "NE", "ENE", "E", "ESE", "SE", "SSE", "S", "SSW", "SW", "WSW", "W", "WNW",
        "NW", "NNW",
    ];
    if !degrees.is_finite() {
        return "–".into();
    }
    // Rounded first: 359.6° is north.
    let degrees = degrees.rem_euclid(360.0).round() % 360.0;
    let point = (degrees / 22.5).round() as usize % POINTS.len();
    format!("{degrees:03.0}° {}", POINTS[point])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_separators() {
        assert_eq!(whole(0.4), "0");
        assert_eq!(whole(-0.4), "0");
        assert_eq!(whole(999.0), "999");
        assert_eq!(whole(1000.0), "1,000");
        assert_eq!(whole(-10_935.2), "−10,935");
        assert_eq!(whole(1_234_567.0), "1,234,567");
        assert_eq!(whole(f64::NAN), "–");
        assert_eq!(percent(0.294), "29.4 %");
        assert_eq!(tenth_in(-1.25, "km"), "−1.2 km");
    }

    #[test]
    fn places_have_hemispheres() {
        assert_eq!(latitude(47.26), "47.3° N");
        assert_eq!(latitude(-90.0), "90.0° S");
        assert_eq!(latitude(-0.01), "0.0°");
        assert_eq!(longitude(-179.96), "180.0° W");
        assert_eq!(longitude(8.5), "8.5° E");
    }

    #[test]
    fn azimuths_go_from_north_over_east() {
        assert_eq!(azimuth(0.0), "000° N");
        assert_eq!(azimuth(72.0), "072° ENE");
        assert_eq!(azimuth(-90.0), "270° W");
        assert_eq!(azimuth(359.6), "000° N");
        assert_eq!(azimuth(348.0), "348° NNW");
        assert_eq!(azimuth(f64::NAN), "–");
    }
}
