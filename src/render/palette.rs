//! Colours of a planet as seen from space, as a table that the shader looks up.

use crate::surface::tint::{Ramp, look_up};
use bevy::{
    asset::RenderAssetUsages,
    image::{Image, ImageSampler, ImageSamplerDescriptor},
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};

/// Columns of the table. Heights are spread by their square root: coasts and shelves need most.
const COLUMNS: u32 = 256;
/// Height of the last column on land and depth of that at sea, in m. Mirrored in `planet.wgsl`.
const EXTENT_M: f32 = 8000.0;

/// The rows of the table, in the order that `planet.wgsl` names them.
const ROWS: [&Ramp; 8] = [LUSH, TEMPERATE, BOREAL, TUNDRA, ARID, ROCK, SEA, BED];

const LUSH: &Ramp = &[
    (0.0, [33, 60, 26]),
    (300.0, [37, 64, 27]),
    (900.0, [60, 80, 38]),
    (1800.0, [98, 102, 58]),
    (3000.0, [120, 106, 78]),
    (4500.0, [134, 122, 108]),
    (8000.0, [160, 152, 146]),
];
const TEMPERATE: &Ramp = &[
    (0.0, [66, 84, 42]),
    (250.0, [80, 93, 48]),
    (700.0, [104, 108, 62]),
    (1500.0, [126, 116, 76]),
    (2600.0, [128, 108, 82]),
    (4000.0, [134, 120, 106]),
    (8000.0, [162, 156, 150]),
];
const BOREAL: &Ramp = &[
    (0.0, [50, 68, 42]),
    (300.0, [58, 74, 46]),
    (900.0, [82, 88, 62]),
    (1700.0, [112, 106, 86]),
    (3000.0, [132, 124, 112]),
    (8000.0, [166, 162, 158]),
];
const TUNDRA: &Ramp = &[
    (0.0, [96, 94, 70]),
    (400.0, [112, 106, 82]),
    (1200.0, [126, 118, 98]),
    (3000.0, [142, 136, 126]),
    (8000.0, [170, 166, 162]),
];
const ARID: &Ramp = &[
    (0.0, [196, 166, 116]),
    (250.0, [206, 172, 118]),
    (800.0, [200, 158, 104]),
    (1600.0, [176, 132, 86]),
    (2800.0, [142, 108, 80]),
    (4200.0, [138, 122, 106]),
    (8000.0, [164, 156, 150]),
];
const ROCK: &Ramp = &[
    (0.0, [104, 92, 72]),
    (1500.0, [108, 92, 74]),
    (3000.0, [112, 98, 84]),
    (5000.0, [126, 118, 110]),
    (8000.0, [150, 146, 142]),
];
/// By depth.
const SEA: &Ramp = &[
    (0.0, [62, 132, 142]),
    (25.0, [40, 104, 126]),
    (140.0, [22, 72, 104]),
    (350.0, [15, 57, 92]),
    (1200.0, [11, 47, 82]),
    (2600.0, [9, 41, 76]),
    (4000.0, [6, 28, 59]),
    (5500.0, [4, 20, 46]),
    (8000.0, [2, 10, 28]),
];

/// The floor of a sea that is not drawn, by depth.
const BED: &Ramp = &[
    (0.0, [176, 156, 120]),
    (200.0, [160, 142, 112]),
    (1500.0, [122, 112, 98]),
    (3500.0, [92, 88, 84]),
    (8000.0, [56, 54, 56]),
];

/// The table: a row for each kind of ground, sea level on the left.
pub(super) fn image() -> Image {
    let mut texels = Vec::new();
    for row in ROWS {
        for column in 0..COLUMNS {
            let share = column as f32 / (COLUMNS - 1) as f32;
            let colour = look_up(row, EXTENT_M * share * share);
            texels.extend(colour.to_array().map(|value| (value * 255.0 + 0.5) as u8));
            texels.push(255);
        }
    }
    Image {
        sampler: ImageSampler::Descriptor(ImageSamplerDescriptor::linear()),
        ..Image::new(
            Extent3d {
                width: COLUMNS,
                height: ROWS.len() as u32,
                depth_or_array_layers: 1,
            },
            TextureDimension::D2,
            texels,
            TextureFormat::Rgba8UnormSrgb,
            RenderAssetUsages::RENDER_WORLD,
        )
    }
}
