//! Writes baked faces into textures that exist already, a few megabytes a frame, so that no frame
//! stutters.

use super::cube::Levels;
use bevy::{
    asset::AssetId,
    image::Image,
    prelude::*,
    render::{
        MainWorld, Render, RenderApp, RenderSystems,
        render_asset::{RenderAssets, prepare_assets},
        render_resource::{
            Extent3d, Origin3d, TexelCopyBufferLayout, TexelCopyTextureInfo, TextureAspect,
        },
        renderer::RenderQueue,
        texture::GpuImage,
    },
    time::Real,
};
use core::sync::atomic::{AtomicU32, Ordering};
use std::{
    collections::VecDeque,
    sync::{Arc, Weak},
};

/// Bytes written in a second of slow frames, and in a short frame at least, or one face where that is
/// more: what takes a millisecond or two.
const SECOND_BYTES: f32 = 150e6;
const FRAME_BYTES: usize = 2_500_000;
/// Frames after which a texture that never appears is given up.
const PATIENCE: u32 = 600;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Uploads>();
    if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
        render_app
            .init_resource::<Arrived>()
            .add_systems(ExtractSchedule, extract)
            .add_systems(
                Render,
                write
                    .in_set(RenderSystems::PrepareAssets)
                    .after(prepare_assets::<GpuImage>),
            );
    }
}

/// Counts what is still to be written. When the owner is gone, so is the reason to write it.
#[derive(Debug, Clone, Default)]
pub(super) struct Ticket(Arc<AtomicU32>);

impl Ticket {
    pub(super) fn is_done(&self) -> bool {
        self.0.load(Ordering::Acquire) == 0
    }
}

/// One face on its way to a texture.
pub(super) struct Upload {
    pub image: AssetId<Image>,
    pub layer: u32,
    /// Level of the texture that receives the finest of these.
    pub level: u32,
    pub face: Levels,
}

/// What the coming frames write.
#[derive(Resource, Default)]
pub(super) struct Uploads(VecDeque<Pending>);

struct Pending {
    upload: Upload,
    ticket: Weak<AtomicU32>,
    frames: u32,
}

impl Uploads {
    pub(super) fn push(&mut self, upload: Upload, ticket: &Ticket) {
        ticket.0.fetch_add(1, Ordering::Relaxed);
        self.0.push_back(Pending {
            upload,
            ticket: Arc::downgrade(&ticket.0),
            frames: 0,
        });
    }
}

#[derive(Resource, Default)]
struct Arrived(Vec<Pending>);

fn extract(mut main: ResMut<MainWorld>, mut arrived: ResMut<Arrived>) {
    let seconds = main
        .get_resource::<Time<Real>>()
        .map_or(0.0, Time::delta_secs);
    let Some(mut uploads) = main.get_resource_mut::<Uploads>() else {
        return;
    };
    if uploads.0.is_empty() {
        return;
    }
    let most = FRAME_BYTES.max((seconds.min(1.0) * SECOND_BYTES) as usize);
    let mut bytes = 0;
    while bytes < most {
        let Some(pending) = uploads.0.pop_front() else {
            break;
        };
        if pending.ticket.strong_count() > 0 {
            bytes += pending.upload.face.bytes();
            arrived.0.push(pending);
        }
    }
}

fn write(
    mut arrived: ResMut<Arrived>,
    images: Res<RenderAssets<GpuImage>>,
    queue: Res<RenderQueue>,
) {
    arrived.0.retain_mut(|pending| {
        let Some(ticket) = pending.ticket.upgrade() else {
            return false;
        };
        pending.frames += 1;
        let Some(image) = images.get(pending.upload.image) else {
            return pending.frames < PATIENCE;
        };
        pending.upload.write(image, &queue);
        ticket.fetch_sub(1, Ordering::Release);
        false
    });
}

impl Upload {
    fn write(&self, image: &GpuImage, queue: &RenderQueue) {
        let mut size = self.face.size;
        let levels = image.texture_descriptor.mip_level_count;
        for (bytes, mip_level) in self.face.levels.iter().zip(self.level..levels) {
            queue.write_texture(
                TexelCopyTextureInfo {
                    texture: &image.texture,
                    mip_level,
                    origin: Origin3d {
                        x: 0,
                        y: 0,
                        z: self.layer,
                    },
                    aspect: TextureAspect::All,
                },
                bytes,
                TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(size * self.face.texel_bytes),
                    rows_per_image: Some(size),
                },
                Extent3d {
                    width: size,
                    height: size,
                    depth_or_array_layers: 1,
                },
            );
            size = (size / 2).max(1);
        }
    }
}
