//! Cube maps: their levels and their images.

use bevy::{
    asset::RenderAssetUsages,
    image::{Image, ImageSampler, ImageSamplerDescriptor},
    render::render_resource::{
        Extent3d, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages,
        TextureViewDescriptor, TextureViewDimension,
    },
};

/// One face with all its coarser levels, as a texture wants it.
#[derive(Debug, Clone, Default)]
pub(super) struct Levels {
    /// Texels along the edge of the finest level.
    pub size: u32,
    pub texel_bytes: u32,
    pub levels: Vec<Vec<u8>>,
}

impl Levels {
    pub(super) fn halves(size: u32, finest: Vec<[f32; 4]>) -> Self {
        let levels = pyramid(size, finest, |level| {
            level
                .iter()
                .flatten()
                .flat_map(|&value| half(value).to_le_bytes())
                .collect()
        });
        Self {
            size,
            texel_bytes: 8,
            levels,
        }
    }

    /// Of sRGB colours. Coarser levels average the encoded values, which is near enough.
    pub(super) fn colours(size: u32, finest: &[[u8; 4]]) -> Self {
        let finest = finest.iter().map(|texel| texel.map(f32::from)).collect();
        let levels = pyramid(size, finest, |level| {
            level
                .iter()
                .flatten()
                .map(|&value| (value + 0.5) as u8)
                .collect()
        });
        Self {
            size,
            texel_bytes: 4,
            levels,
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.levels.iter().map(Vec::len).sum()
    }
}

fn pyramid(
    size: u32,
    finest: Vec<[f32; 4]>,
    encode: impl Fn(&[[f32; 4]]) -> Vec<u8>,
) -> Vec<Vec<u8>> {
    let mut levels = vec![encode(&finest)];
    let (mut level, mut size) = (finest, size as usize);
    while size > 1 {
        let half = size / 2;
        level = (0..half * half)
            .map(|i| {
                let corner = 2 * (i / half) * size + 2 * (i % half);
                let four = [corner, corner + 1, corner + size, corner + size + 1];
                core::array::from_fn(|c| 0.25 * four.iter().map(|&t| level[t][c]).sum::<f32>())
            })
            .collect();
        size = half;
        levels.push(encode(&level));
    }
    levels
}

/// The nearest half-precision number; what has none becomes the largest.
pub(super) fn half(value: f32) -> u16 {
    let bits = value.to_bits();
    let (sign, size) = ((bits >> 16) as u16 & 0x8000, bits & 0x7fff_ffff);
    let magnitude = if size >= 0x477f_f000 {
        0x7bff
    } else if size < 0x3880_0000 {
        (f32::from_bits(size) * 16_777_216.0 + 0.5) as u16
    } else {
        ((size - 0x3800_0000 + 0x0fff + ((size >> 13) & 1)) >> 13) as u16
    };
    sign | magnitude
}

/// An empty cube map whose faces are written later, with all levels down to one texel.
pub(super) fn image(label: &'static str, size: u32, format: TextureFormat) -> Image {
    Image {
        data: None,
        texture_descriptor: TextureDescriptor {
            label: Some(label),
            size: Extent3d {
                width: size,
                height: size,
                depth_or_array_layers: 6,
            },
            mip_level_count: size.max(1).ilog2() + 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format,
            usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
            view_formats: &[],
        },
        texture_view_descriptor: Some(TextureViewDescriptor {
            dimension: Some(TextureViewDimension::Cube),
            ..TextureViewDescriptor::default()
        }),
        sampler: ImageSampler::Descriptor(ImageSamplerDescriptor::linear()),
        asset_usage: RenderAssetUsages::RENDER_WORLD,
        ..Image::default_uninit()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_round_to_the_nearest() {
        for (value, bits) in [
            (0.0, 0),
            (-0.0, 0x8000),
            (1.0, 0x3c00),
            (-2.0, 0xc000),
            (65504.0, 0x7bff),
            (1e9, 0x7bff),
            (f32::NAN, 0x7bff),
            (6.103_515_6e-5, 0x0400),
            (5.960_464_5e-8, 0x0001),
            (1.000_488_3, 0x3c00),
            (1.001, 0x3c01),
        ] {
            assert_eq!(half(value), bits, "{value}");
        }
    }

    #[test]
    fn levels_end_at_one_texel_and_average() {
        let levels = Levels::colours(4, &[[8, 16, 24, 255]; 16]);
        let sizes: Vec<_> = levels.levels.iter().map(Vec::len).collect();
        assert_eq!(sizes, [64, 16, 4]);
        assert_eq!(levels.levels[2], [8, 16, 24, 255]);
    }
}
