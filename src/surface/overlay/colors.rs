//! The tables of colours, and the colour of every value.

use super::{Overlay, OverlayValues};
use crate::simulation::{BoundaryKind, Crust, Orogeny};
use crate::surface::ramp::{Ramp, look_up};
use glam::Vec3;

/// Age in My. The colours that maps of the sea floor have (Müller et al. 2008), brightest in the middle:
/// lightness tells young red from middle-aged green where hue does not.
pub(super) const AGE: &Ramp = &[
    (0.0, [158, 14, 30]),
    (10.0, [206, 40, 36]),
    (25.0, [236, 104, 50]),
    (40.0, [248, 170, 72]),
    (60.0, [252, 230, 110]),
    (85.0, [176, 218, 122]),
    (110.0, [98, 188, 148]),
    (140.0, [62, 146, 184]),
    (180.0, [58, 96, 170]),
    (225.0, [62, 54, 134]),
    (280.0, [46, 24, 84]),
];
/// Continents are older than any sea floor.
pub(super) const OFF_THE_AGE_SCALE: [u8; 3] = [190, 183, 168];

/// Thickness in km: "batlow" (Crameri 2018), equal steps to the eye, to the colour-blind too.
pub(super) const THICKNESS: &Ramp = &[
    (0.0, [1, 25, 89]),
    (7.0, [16, 63, 96]),
    (15.0, [28, 90, 98]),
    (23.0, [60, 109, 86]),
    (31.0, [104, 123, 62]),
    (39.0, [157, 137, 43]),
    (47.0, [210, 147, 67]),
    (55.0, [248, 161, 123]),
    (62.0, [253, 183, 188]),
    (70.0, [250, 204, 250]),
];

/// Speed in mm/yr: "viridis" (van der Walt and Smith 2015).
pub(super) const SPEED: &Ramp = &[
    (0.0, [68, 1, 84]),
    (15.0, [71, 44, 122]),
    (30.0, [59, 81, 139]),
    (45.0, [44, 113, 142]),
    (60.0, [33, 144, 141]),
    (75.0, [39, 173, 129]),
    (90.0, [92, 200, 99]),
    (105.0, [170, 220, 50]),
    (120.0, [253, 231, 37]),
];

/// Height of the steps of elevation in m.
pub(super) const STEP_M: f32 = 500.0;
/// Numbers of the lowest and the highest step: they hold what lies beyond them too.
pub(super) const STEPS: (i32, i32) = (-16, 13);
/// Colours of steps below the sea, by the elevation of their middle in m.
const SEA: &Ramp = &[
    (-7750.0, [22, 24, 70]),
    (-5750.0, [30, 62, 128]),
    (-3750.0, [58, 116, 182]),
    (-1750.0, [126, 184, 222]),
    (-250.0, [208, 236, 244]),
];
/// Colours of steps above the sea.
const LAND: &Ramp = &[
    (250.0, [74, 140, 84]),
    (750.0, [138, 178, 98]),
    (1250.0, [200, 206, 122]),
    (1750.0, [238, 220, 146]),
    (2250.0, [232, 190, 112]),
    (3250.0, [196, 134, 78]),
    (4250.0, [150, 92, 68]),
    (5250.0, [128, 96, 98]),
    (5750.0, [168, 150, 156]),
    (6750.0, [250, 248, 250]),
];

pub(super) const OCEANIC: [u8; 3] = [52, 98, 160];
pub(super) const CONTINENTAL: [u8; 3] = [222, 190, 128];
/// Continental crust below the sea.
pub(super) const SHELF: [u8; 3] = [150, 190, 190];

/// Mountain building under which the sea floor sinks, by the time since in My.
pub(super) const ANDEAN: &Ramp = &[
    (0.0, [224, 78, 10]),
    (60.0, [236, 136, 66]),
    (200.0, [240, 194, 150]),
    (500.0, [234, 218, 202]),
];
/// Mountain building by the collision of continents.
pub(super) const HIMALAYAN: &Ramp = &[
    (0.0, [92, 36, 156]),
    (60.0, [140, 98, 190]),
    (200.0, [186, 162, 214]),
    (500.0, [216, 206, 224]),
];
pub(super) const UNFOLDED_LAND: [u8; 3] = [222, 222, 214];
pub(super) const UNFOLDED_SEA: [u8; 3] = [150, 164, 178];

/// Dark lines around bright ones, which so stand out from any ground.
#[cfg(feature = "render")]
pub(crate) const OUTLINE: [u8; 3] = [22, 22, 30];
/// Colour of arrows.
pub(crate) const ARROW_COLOR: [u8; 3] = [250, 250, 246];
/// Length of an arrow in radii per mm/yr.
pub(crate) const ARROW_RADII: f32 = 0.12 / 100.0;
/// Length of the longest arrows in radii: faster plates have no longer ones.
pub(crate) const ARROW_LONGEST: f32 = 0.2;

/// Where an overlay draws nothing.
const CLEAR: [u8; 4] = [0; 4];

impl Overlay {
    /// The colour of a place: sRGB with opacity, 0–255. Opacity is 0 where the overlay has nothing to show:
    /// on ground without a plate, and everywhere for [`Boundaries`](Self::Boundaries) and
    /// [`Velocity`](Self::Velocity), which are lines. Values beyond a scale have the colours of its ends.
    #[must_use]
    pub fn color(self, values: &OverlayValues) -> [u8; 4] {
        let continental = values.crust.is_continental();
        let color = match self {
            Self::Plates if values.plate == 0 => return CLEAR,
            Self::Boundaries | Self::Velocity => return CLEAR,
            Self::Plates => plate_color(values.plate),
            Self::Crust => match values.crust {
                Crust::Oceanic => OCEANIC,
                Crust::Continental if values.elevation < 0.0 => SHELF,
                Crust::Continental => CONTINENTAL,
            },
            Self::Age if continental => OFF_THE_AGE_SCALE,
            Self::Age => bytes(look_up(AGE, values.age)),
            Self::Thickness => bytes(look_up(THICKNESS, values.thickness)),
            Self::Speed => bytes(look_up(SPEED, values.speed)),
            Self::Elevation => step_color(step(values.elevation)),
            Self::Orogeny => match values.orogeny {
                Orogeny::Andean => bytes(look_up(ANDEAN, values.orogeny_age)),
                Orogeny::Himalayan => bytes(look_up(HIMALAYAN, values.orogeny_age)),
                Orogeny::None if continental => UNFOLDED_LAND,
                Orogeny::None => UNFOLDED_SEA,
            },
        };
        let [red, green, blue] = color;
        [red, green, blue, 255]
    }
}

/// Number of the step of an elevation in m; step 0 begins at the sea.
pub(super) fn step(elevation: f32) -> i32 {
    // Casts saturate, and what is not a number becomes 0.
    ((elevation / STEP_M).floor() as i32).clamp(STEPS.0, STEPS.1)
}

fn step_color(step: i32) -> [u8; 3] {
    let middle = (step as f32 + 0.5) * STEP_M;
    bytes(look_up(if step < 0 { SEA } else { LAND }, middle))
}

/// Colour of a kind of boundary, sRGB, 0–255. Hues that the colour-blind can tell apart (Okabe and Ito
/// 2008), as geological maps have them where possible: ridges red, trenches blue.
#[must_use]
pub fn boundary_color(kind: BoundaryKind) -> [u8; 3] {
    match kind {
        BoundaryKind::Joined => [128, 128, 128],
        BoundaryKind::Transform => [240, 228, 92],
        BoundaryKind::Ridge => [240, 76, 40],
        BoundaryKind::SubductingOrigin | BoundaryKind::SubductingDestination => [70, 150, 255],
        BoundaryKind::Collision => [226, 120, 206],
    }
}

/// Colour of a plate, sRGB, 0–255. It depends on the id alone, so that a plate keeps its colour while
/// others come and go. Hue and lightness follow Roberts's R₂ sequence: however many ids there have been,
/// their colours lie about evenly spread, and those of successive ids far apart.
#[must_use]
pub fn plate_color(id: u16) -> [u8; 3] {
    if id == 0 {
        return [128, 128, 128];
    }
    let place = |ratio: f64| (f64::from(id) * ratio).fract() as f32;
    let hue = core::f32::consts::TAU * place(0.569_840_290_998_053_2);
    let lightness = 0.48 + 0.4 * place(0.754_877_666_246_692_7);
    let (sin, cos) = (libm::sinf(hue), libm::cosf(hue));
    // Pale enough to let relief be seen; less so, step by step, where the screen has no such colour.
    let mut chroma = 0.12;
    loop {
        let linear = from_oklab(Vec3::new(lightness, chroma * cos, chroma * sin));
        if chroma < 0.02 || (linear.min_element() >= 0.0 && linear.max_element() <= 1.0) {
            return bytes(linear.max(Vec3::ZERO).map(encode));
        }
        chroma -= 0.005;
    }
}

/// Linear sRGB of a colour in Oklab (Ottosson 2020).
fn from_oklab(lab: Vec3) -> Vec3 {
    let long = lab.dot(Vec3::new(1.0, 0.396_337_78, 0.215_803_76));
    let medium = lab.dot(Vec3::new(1.0, -0.105_561_346, -0.063_854_17));
    let short = lab.dot(Vec3::new(1.0, -0.089_484_18, -1.291_485_5));
    let cones = Vec3::new(long, medium, short);
    let cones = cones * cones * cones;
    Vec3::new(
        cones.dot(Vec3::new(4.076_741_7, -3.307_711_6, 0.230_969_94)),
        cones.dot(Vec3::new(-1.268_438, 2.609_757_4, -0.341_319_4)),
        cones.dot(Vec3::new(-0.004_196_086_3, -0.703_418_6, 1.707_614_7)),
    )
}

/// The sRGB curve.
fn encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055
    }
}

/// Components 0–1 as 0–255.
fn bytes(color: Vec3) -> [u8; 3] {
    (color * 255.0).round().to_array().map(|part| part as u8)
}

#[cfg(test)]
mod tests;
