//! What is drawn of one planet: its textures, and the way of a snapshot into them.

use super::{
    Drawn, PlanetAir, PlanetRenderSettings,
    bake::{Face, Scene, VELOCITY_SIZE},
    blend::Blend,
    cube,
    grain::Grain,
    material::{Lighting, PlanetMaterial, PlanetUniform, SkyUniform},
    paint::paint,
    palette::{Palette, Tints},
    upload::{Ticket, Upload, Uploads},
};
use crate::{
    planet::{PlanetSurface, PlanetView},
    simulation::Surface,
    surface::Overlay,
};
use bevy::{
    prelude::*,
    render::render_resource::TextureFormat,
    tasks::{AsyncComputeTaskPool, Task, TaskPool, futures::check_ready},
};
use std::sync::Arc;

/// Texels of the first, quick bake.
const COARSE: u32 = 128;
/// Shading of slopes in units of the exaggeration of heights: light shows relief that outlines do not.
const SHADE: f32 = 4.5;
/// Ground that moves further between two snapshots than this, in radians, is not carried along.
const FURTHEST: f64 = 0.25;
/// What moves fast on a planet, in km/My.
const FAST: f64 = 150.0;

/// The drawn side of a planet; lives on the planet's entity.
#[derive(Component)]
pub(super) struct Globe {
    /// The entity of the ground, a child of the planet.
    pub body: Entity,
    /// The entity of the air, another child.
    pub sky: Entity,
    pub material: Handle<PlanetMaterial>,
    /// How the air is drawn, once it is.
    pub air: Option<SkyUniform>,
    /// The palette that it is drawn with, once it is there, and what shaders know of that.
    pub palette: Option<AssetId<Palette>>,
    pub tints: Tints,
    /// What tiles of the ground want of the material.
    pub close: Close,
    size: u32,
    maps: [Maps; 3],
    blend: Blend,
    coarse: Arc<Grain>,
    fine: Arc<Grain>,
    warming: Vec<Task<()>>,
    job: Option<Job>,
    baked: Option<(Stamp, Vec<Face>)>,
    arriving: Option<(Stamp, Ticket)>,
    /// Whether the newest snapshot waits to be baked.
    stale: bool,
    overlay: Option<Overlay>,
}

/// How tiles of the ground are drawn.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Close {
    /// Share of pixels that belong to tiles.
    pub share: f32,
    /// Distance within which a tile is split, in sides of it.
    pub reach: f32,
    /// Where the camera is that they are placed around, in the world.
    pub eye: Vec3,
}

/// One set of textures.
struct Maps {
    relief: Handle<Image>,
    climate: Handle<Image>,
    velocity: Handle<Image>,
    overlay: Option<Handle<Image>>,
    stamp: Stamp,
}

/// What a set of textures shows.
#[derive(Debug, Clone, Copy, Default)]
struct Stamp {
    seed: u64,
    radius_km: f64,
    time_my: f64,
    /// Finest level with data.
    level: u32,
    overlay: bool,
}

/// A bake under way. Dropping it stops it.
struct Job {
    stamp: Stamp,
    tasks: Vec<Task<Face>>,
    faces: Vec<Option<Face>>,
}

impl Maps {
    fn new(size: u32, images: &mut Assets<Image>) -> Self {
        let mut add =
            |label, size| images.add(cube::image(label, size, TextureFormat::Rgba16Float));
        Self {
            relief: add("planet relief", size),
            climate: add("planet climate", size / 2),
            velocity: add("planet velocity", VELOCITY_SIZE),
            overlay: None,
            stamp: Stamp::default(),
        }
    }
}

impl Globe {
    pub(super) fn new(
        surface: &PlanetSurface,
        settings: &PlanetRenderSettings,
        images: &mut Assets<Image>,
        materials: &mut Assets<PlanetMaterial>,
    ) -> (Self, Handle<PlanetMaterial>) {
        let size = settings.texels();
        let maps: [Maps; 3] = core::array::from_fn(|_| Maps::new(size, images));
        let [first, ..] = &maps;
        let material = materials.add(PlanetMaterial {
            lighting: Lighting::default(),
            uniform: PlanetUniform::default(),
            relief_a: first.relief.clone(),
            relief_b: first.relief.clone(),
            climate_a: first.climate.clone(),
            climate_b: first.climate.clone(),
            velocity_a: first.velocity.clone(),
            velocity_b: first.velocity.clone(),
            overlay_a: None,
            overlay_b: None,
            palette: Handle::default(),
        });
        let mut globe = Self {
            body: Entity::PLACEHOLDER,
            sky: Entity::PLACEHOLDER,
            material: material.clone(),
            air: None,
            palette: None,
            tints: Tints::default(),
            close: Close::default(),
            size,
            maps,
            blend: Blend::default(),
            coarse: Arc::new(Grain::new(surface, COARSE.min(size))),
            fine: Arc::new(Grain::new(surface, size)),
            warming: Vec::new(),
            job: None,
            baked: None,
            arriving: None,
            stale: true,
            overlay: None,
        };
        globe.warm();
        (globe, material)
    }

    /// Computes the noise of the fine bake beside the coarse ones.
    fn warm(&mut self) {
        self.warming = (0..6)
            .map(|face| {
                let grain = self.fine.clone();
                pool().spawn(async move {
                    grain.face(face).await;
                })
            })
            .collect();
    }

    /// Takes the next steps of the way. Returns whether a new snapshot begins to be seen.
    pub(super) fn tend(
        &mut self,
        surface: &PlanetSurface,
        is_new: bool,
        overlay: Option<Overlay>,
        seconds: f32,
        images: &mut Assets<Image>,
        uploads: &mut Uploads,
    ) -> bool {
        self.stale |= is_new || overlay != self.overlay;
        self.overlay = overlay;
        self.blend.advance(seconds);
        if !self.warming.is_empty() && self.fine.is_ready() {
            self.warming.clear();
            self.stale = true;
        }
        self.receive();
        self.send(images, uploads);
        if self.stale && self.job.is_none() && self.baked.is_none() {
            self.begin(surface.share());
        }
        self.turn()
    }

    fn begin(&mut self, surface: Arc<Surface>) {
        if !self.fine.suits(&surface) {
            self.coarse = Arc::new(Grain::new(&surface, COARSE.min(self.size)));
            self.fine = Arc::new(Grain::new(&surface, self.size));
            self.warm();
        }
        let grain = if self.fine.is_ready() {
            &self.fine
        } else {
            &self.coarse
        };
        let paint = self.overlay.and_then(paint);
        let stamp = Stamp {
            seed: surface.seed,
            radius_km: surface.radius_km,
            time_my: surface.time_my,
            level: self.size.ilog2() - grain.size().ilog2(),
            overlay: paint.is_some(),
        };
        let scene = Arc::new(Scene::new(surface, paint));
        let tasks = (0..6)
            .map(|face| pool().spawn(scene.clone().face(grain.clone(), face)))
            .collect();
        self.job = Some(Job {
            stamp,
            tasks,
            faces: (0..6).map(|_| None).collect(),
        });
        self.stale = false;
    }

    fn receive(&mut self) {
        let Some(job) = &mut self.job else {
            return;
        };
        for (task, face) in job.tasks.iter_mut().zip(&mut job.faces) {
            if face.is_none() {
                *face = check_ready(task);
            }
        }
        if job.faces.iter().all(Option::is_some) {
            let faces = job.faces.drain(..).flatten().collect();
            self.baked = Some((job.stamp, faces));
            self.job = None;
        }
    }

    /// Sends what is baked to the spare textures, if those are free.
    fn send(&mut self, images: &mut Assets<Image>, uploads: &mut Uploads) {
        if self.arriving.is_some() {
            return;
        }
        let Some((stamp, faces)) = self.baked.take() else {
            return;
        };
        let maps = &mut self.maps[self.blend.spare];
        maps.overlay = stamp.overlay.then(|| {
            maps.overlay.take().unwrap_or_else(|| {
                let format = TextureFormat::Rgba8UnormSrgb;
                images.add(cube::image("planet overlay", self.size, format))
            })
        });
        let ticket = Ticket::default();
        for (layer, face) in (0..).zip(faces) {
            let mut push = |image: &Handle<Image>, level, face| {
                uploads.push(
                    Upload {
                        image: image.id(),
                        layer,
                        level,
                        face,
                    },
                    &ticket,
                );
            };
            push(&maps.velocity, 0, face.velocity);
            push(&maps.climate, stamp.level, face.climate);
            if let (Some(image), Some(overlay)) = (&maps.overlay, face.overlay) {
                push(image, stamp.level, overlay);
            }
            push(&maps.relief, stamp.level, face.relief);
        }
        self.arriving = Some((stamp, ticket));
    }

    /// Begins to blend towards what has arrived.
    fn turn(&mut self) -> bool {
        if !self.blend.is_over() {
            return false;
        }
        let Some((stamp, _)) = self.arriving.take_if(|(_, ticket)| ticket.is_done()) else {
            return false;
        };
        let first = self.maps[self.blend.to].stamp.radius_km == 0.0;
        self.maps[self.blend.spare].stamp = stamp;
        self.blend.arrived();
        self.blend.turn();
        if first {
            self.blend.finish();
        }
        true
    }

    /// Hands the present state to the GPU, if it has changed.
    pub(super) fn show(
        &self,
        view: &PlanetView,
        air: &PlanetAir,
        lighting: Lighting,
        materials: &mut Assets<PlanetMaterial>,
    ) {
        let Some(before) = materials.get(&self.material) else {
            return;
        };
        let (a, b) = (&self.maps[self.blend.from], &self.maps[self.blend.to]);
        let mut uniform = self.uniform(view, air, &a.stamp, &b.stamp);
        // Only shadow maps want to know: else a camera that moves would change the material in every frame.
        if lighting.shadows {
            uniform.eye = self.close.eye;
        }
        if before.uniform == uniform
            && before.lighting == lighting
            && before.relief_b == b.relief
            && before.relief_a == a.relief
        {
            return;
        }
        let Some(mut material) = materials.get_mut(&self.material) else {
            return;
        };
        material.uniform = uniform;
        material.lighting = lighting;
        material.relief_a = a.relief.clone();
        material.relief_b = b.relief.clone();
        material.climate_a = a.climate.clone();
        material.climate_b = b.climate.clone();
        material.velocity_a = a.velocity.clone();
        material.velocity_b = b.velocity.clone();
        material.overlay_a = a.overlay.clone();
        material.overlay_b = b.overlay.clone();
    }

    fn uniform(&self, view: &PlanetView, air: &PlanetAir, a: &Stamp, b: &Stamp) -> PlanetUniform {
        let share = self.blend.share;
        let radius_km = b.radius_km.max(1.0);
        let passed = b.time_my - a.time_my;
        let drifts = a.seed == b.seed
            && a.radius_km == b.radius_km
            && (0.0..FURTHEST).contains(&(passed * FAST / radius_km));
        let drift = if drifts {
            (passed / radius_km) as f32
        } else {
            0.0
        };
        let exaggeration = exaggeration(view);
        let sea = sea_level_m(view).map(|level| level / 1000.0);
        let opacity = |stamp: &Stamp| {
            if stamp.overlay {
                view.overlay_opacity.clamp(0.0, 1.0)
            } else {
                0.0
            }
        };
        PlanetUniform {
            drift: drift * Vec2::new(share, 1.0 - share),
            level: Vec2::new(a.level as f32, b.level as f32),
            overlay: Vec2::new(opacity(a), opacity(b)),
            mix: share,
            size: self.size as f32,
            height: exaggeration / radius_km as f32,
            shade: SHADE * exaggeration,
            sea: sea.unwrap_or(-1000.0),
            datum: sea.unwrap_or(0.0),
            tiles: self.close.share,
            reach: self.close.reach,
            radius_km: radius_km as f32,
            eye: Vec3::ZERO,
            air: air.uniform(radius_km),
            tints: self.tints,
        }
    }

    /// What is seen, once something is.
    pub(super) fn drawn(&self) -> Option<Drawn> {
        let seen = self.maps[self.blend.to].stamp;
        (seen.radius_km > 0.0).then(|| Drawn {
            time_my: seen.time_my,
            settled: self.blend.is_over()
                && !self.stale
                && self.warming.is_empty()
                && self.job.is_none()
                && self.baked.is_none()
                && self.arriving.is_none(),
        })
    }

    /// Radius that holds the highest mountains, in radii of the planet.
    pub(super) fn reach(&self, view: &PlanetView) -> f32 {
        let radius_km = self.maps[self.blend.to].stamp.radius_km.max(1000.0);
        1.0 + exaggeration(view) * 15.0 / radius_km as f32
    }
}

/// Where the drawn sea stands in m, if there is one.
pub(super) fn sea_level_m(view: &PlanetView) -> Option<f32> {
    let level = if view.sea_level_m.is_finite() {
        view.sea_level_m
    } else {
        0.0
    };
    view.sea.then_some(level)
}

/// As far as it makes sense.
pub(super) fn exaggeration(view: &PlanetView) -> f32 {
    if view.exaggeration.is_finite() {
        view.exaggeration.clamp(0.0, 200.0)
    } else {
        1.0
    }
}

pub(super) fn pool() -> &'static TaskPool {
    AsyncComputeTaskPool::get_or_init(TaskPool::new)
}
