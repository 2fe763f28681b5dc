//! A studio without a window: it draws one planet off screen and hands out pictures.

use bevy::{
    app::{PluginsState, TaskPoolOptions, TaskPoolPlugin, TaskPoolThreadAssignmentPolicy},
    asset::RenderAssetUsages,
    camera::RenderTarget,
    light::CascadeShadowConfigBuilder,
    math::DVec3,
    pbr::{AtmosphereMode, AtmosphereSettings},
    prelude::*,
    render::{
        RenderPlugin,
        pipelined_rendering::PipelinedRenderingPlugin,
        render_resource::TextureFormat,
        view::screenshot::{Screenshot, ScreenshotCaptured},
    },
    window::ExitCondition,
    winit::WinitPlugin,
};
use bevy_tectonics::{
    planet::to_scene,
    prelude::*,
    render::{Drawn, PlanetAtmosphere, PlanetRenderSettings, PlanetTiles, TilesDrawn, Viewpoint},
    surface::direction_of,
};
use core::time::Duration;
use std::{
    fs::File,
    io::{self, BufWriter},
    panic::catch_unwind,
    path::Path,
    sync::{Arc, Mutex, PoisonError},
    time::Instant,
};

/// Longest time to wait for a picture.
const PATIENCE: Duration = Duration::from_secs(600);
/// Meshes that are laid over the ground are built beside the frames: a moment until they are there.
const LINES: Duration = Duration::from_millis(1500);

/// One planet, one camera, one sun.
pub struct Studio {
    pub app: App,
    canvas: Handle<Image>,
    planet: Entity,
    camera: Entity,
    sun: Entity,
}

/// Where the camera and the sun stand, in degrees; the sun relative to the camera.
#[derive(Debug, Clone, Copy)]
pub struct Pose {
    pub latitude: f64,
    pub longitude: f64,
    /// Distance from the planet's centre in radii.
    pub distance: f64,
    pub sun_north: f64,
    pub sun_east: f64,
}

/// Where a camera is that looks at the ground from close by: in the planet's frame, north is +Z.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    /// From the planet's centre, in m.
    pub place_m: DVec3,
    pub forward: DVec3,
    /// Where the sun stands.
    pub sun: DVec3,
}

/// Pixels, 8-bit sRGB, three bytes each.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<u8>,
}

/// An app that draws without a window. None where there is nothing to draw with.
pub fn open() -> Option<App> {
    // Bevy says that there is no adapter by a panic.
    catch_unwind(|| {
        let mut app = App::new();
        app.add_plugins(
            DefaultPlugins
                .build()
                .disable::<WinitPlugin>()
                // Leaving while another thread renders crashes software renderers.
                .disable::<PipelinedRenderingPlugin>()
                .set(TaskPoolPlugin {
                    task_pool_options: TaskPoolOptions {
                        async_compute: TaskPoolThreadAssignmentPolicy {
                            min_threads: 2,
                            max_threads: 4,
                            percent: 0.5,
                            on_thread_spawn: None,
                            on_thread_destroy: None,
                        },
                        ..default()
                    },
                })
                .set(RenderPlugin {
                    synchronous_pipeline_compilation: true,
                    ..default()
                })
                .set(WindowPlugin {
                    primary_window: None,
                    exit_condition: ExitCondition::DontExit,
                    ..default()
                }),
        )
        .add_plugins(TectonicsPlugins)
        .insert_resource(ClearColor(Color::BLACK));
        while app.plugins_state() == PluginsState::Adding {
            bevy::tasks::tick_global_task_pools_on_main_thread();
        }
        app.finish();
        app.cleanup();
        app
    })
    .ok()
}

impl Studio {
    /// A studio for pictures of this size. None where there is nothing to draw with.
    pub fn new(width: u32, height: u32, planet: Planet) -> Option<Self> {
        let mut app = open()?;
        let mut canvas =
            Image::new_target_texture(width, height, TextureFormat::Rgba8UnormSrgb, None);
        canvas.asset_usage = RenderAssetUsages::default();
        let world = app.world_mut();
        let canvas = world.resource_mut::<Assets<Image>>().add(canvas);
        let planet = world.spawn(planet).id();
        let camera = world
            .spawn((Camera3d::default(), RenderTarget::from(canvas.clone())))
            .id();
        let sun = world.spawn(DirectionalLight::default()).id();
        let mut studio = Self {
            app,
            canvas,
            planet,
            camera,
            sun,
        };
        studio.pose(Pose::default());
        Some(studio)
    }

    /// How finely the planet is drawn; before the first picture.
    pub fn settings(&mut self, settings: PlanetRenderSettings) {
        self.app.world_mut().insert_resource(settings);
    }

    pub fn view(&mut self) -> Mut<'_, PlanetView> {
        self.app.world_mut().get_mut(self.planet).unwrap()
    }

    /// Gives the planet and the camera more components.
    pub fn dress(&mut self, planet: impl Bundle, camera: impl Bundle) {
        let world = self.app.world_mut();
        world.entity_mut(self.planet).insert(planet);
        world.entity_mut(self.camera).insert(camera);
    }

    /// Has Bevy draw the planet's air.
    pub fn bevy_air(&mut self) {
        let settings = AtmosphereSettings {
            rendering_method: AtmosphereMode::Raymarched,
            sky_max_samples: 32,
            ..default()
        };
        self.dress(PlanetAtmosphere::default(), settings);
    }

    /// Whether the sun casts shadows, on ground that is so many m below the camera, in a world of metres.
    pub fn shadows(&mut self, on: bool, height_m: f32) {
        let cascades = CascadeShadowConfigBuilder {
            first_cascade_far_bound: (4.0 * height_m).max(150.0),
            maximum_distance: 60_000.0 + 20.0 * height_m,
            ..default()
        };
        let light = DirectionalLight {
            shadow_maps_enabled: on,
            ..default()
        };
        let world = self.app.world_mut();
        world.entity_mut(self.sun).insert((light, cascades.build()));
    }

    /// Moves planet and camera through the world together.
    pub fn shift(&mut self, offset: Vec3) {
        let world = self.app.world_mut();
        for entity in [self.planet, self.camera] {
            world.get_mut::<Transform>(entity).unwrap().translation += offset;
        }
    }

    /// Lights the scene in place of the sun.
    pub fn shine(&mut self, light: impl Bundle) {
        let world = self.app.world_mut();
        world.entity_mut(self.sun).remove::<DirectionalLight>();
        world.spawn(light);
    }

    /// Lets the planet's history go on until a time in My.
    pub fn run_to(&mut self, time_my: f64) {
        let world = self.app.world_mut();
        if let Some(mut planet) = world.get_mut::<Planet>(self.planet) {
            planet.run_to(time_my);
        }
    }

    pub fn growth(&self) -> &Growth {
        self.app.world().get(self.planet).unwrap()
    }

    pub fn pose(&mut self, pose: Pose) {
        let at = |latitude, longitude| -> DVec3 { direction_of(latitude, longitude) };
        let eye = to_scene(at(pose.latitude, pose.longitude) * pose.distance);
        let sun = to_scene(at(
            pose.latitude + pose.sun_north,
            pose.longitude + pose.sun_east,
        ));
        let world = self.app.world_mut();
        for (entity, place) in [(self.camera, eye), (self.sun, sun)] {
            *world.get_mut::<Transform>(entity).unwrap() =
                Transform::from_translation(place).looking_at(Vec3::ZERO, Vec3::Y);
        }
    }

    /// Draws frames until the planet has a history, and returns its surface.
    ///
    /// # Errors
    /// A sentence, if the history fails.
    pub fn surface(&mut self) -> Result<Arc<Surface>, String> {
        let start = Instant::now();
        loop {
            self.app.update();
            let world = self.app.world();
            let growth = world.get::<Growth>(self.planet).map(|growth| &growth.state);
            if let Some(GrowthState::Failed(failure)) = growth {
                return Err(failure.to_string());
            }
            let rests = matches!(growth, Some(GrowthState::Finished | GrowthState::Resting));
            let surface = world.get::<PlanetSurface>(self.planet);
            if let Some(surface) = surface.filter(|_| rests) {
                return Ok(surface.share());
            }
            if start.elapsed() > PATIENCE {
                return Err("the planet did not grow in time".into());
            }
        }
    }

    /// Puts the camera near the ground, less than half a radius above it, which is drawn in detail from now on. The
    /// planet is moved around it.
    pub fn look(&mut self, look: Look) {
        let world = self.app.world_mut();
        let radius_km = world.get::<PlanetSurface>(self.planet).unwrap().radius_km;
        let scale = f64::from(world.get::<Planet>(self.planet).unwrap().radius) / radius_km;
        let up = to_scene(look.place_m.normalize());
        *world.get_mut::<Transform>(self.planet).unwrap() =
            Transform::from_translation(-to_scene(look.place_m * (0.001 * scale)));
        world.entity_mut(self.planet).insert(PlanetTiles::default());
        world.entity_mut(self.camera).insert((
            Viewpoint {
                planet: self.planet,
                place_m: look.place_m,
            },
            Transform::default().looking_to(to_scene(look.forward), up),
        ));
        *world.get_mut::<Transform>(self.sun).unwrap() =
            Transform::default().looking_to(-to_scene(look.sun), up);
    }

    /// Draws frames until the history rests and its surface is seen in all its detail, then takes a
    /// picture.
    ///
    /// # Errors
    /// A sentence, if the history fails or nothing is drawn.
    pub fn shoot(&mut self) -> Result<Picture, String> {
        let start = Instant::now();
        let mut settled = None;
        // A change of the view is seen a frame later.
        for _ in 0..3 {
            self.app.update();
        }
        while settled.is_none_or(|since: Instant| since.elapsed() < LINES) {
            if start.elapsed() > PATIENCE {
                return Err("the planet was not drawn in time".into());
            }
            self.app.update();
            let growth = self.growth();
            if let GrowthState::Failed(failure) = &growth.state {
                return Err(failure.to_string());
            }
            let rests = matches!(growth.state, GrowthState::Finished | GrowthState::Resting);
            let time_my = growth.progress.time_my;
            let drawn = self.app.world().get::<Drawn>(self.planet).copied();
            let tiles = self.app.world().get::<TilesDrawn>(self.planet);
            let is_settled = rests
                && tiles.is_none_or(|tiles| tiles.missing == 0 && tiles.share == 1.0)
                && !self.growth().hidden
                && drawn.is_some_and(|drawn| drawn.settled && drawn.time_my == time_my);
            settled = is_settled.then(|| settled.unwrap_or_else(Instant::now));
        }
        let picture = Arc::new(Mutex::new(None));
        let taken = picture.clone();
        self.app
            .world_mut()
            .spawn(Screenshot::image(self.canvas.clone()))
            .observe(move |captured: On<ScreenshotCaptured>| {
                *taken.lock().unwrap_or_else(PoisonError::into_inner) =
                    Some(captured.image.clone());
            });
        loop {
            self.app.update();
            let image = picture
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .take();
            if let Some(image) = image {
                return Picture::from_image(&image);
            }
            if start.elapsed() > PATIENCE {
                return Err("the picture was not taken in time".into());
            }
        }
    }
}

impl Default for Pose {
    fn default() -> Self {
        Self {
            latitude: 15.0,
            longitude: 0.0,
            distance: 3.0,
            sun_north: 18.0,
            sun_east: -38.0,
        }
    }
}

impl Picture {
    fn from_image(image: &Image) -> Result<Self, String> {
        let data = image.data.as_ref().ok_or("the picture has no pixels")?;
        Ok(Self {
            width: image.width(),
            height: image.height(),
            pixels: data
                .chunks(4)
                .flat_map(|pixel| [pixel[0], pixel[1], pixel[2]])
                .collect(),
        })
    }

    /// Writes a PNG.
    ///
    /// # Errors
    /// What the operating system or the encoder says.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        let file = BufWriter::new(File::create(path)?);
        let mut encoder = png::Encoder::new(file, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        encoder.write_header()?.write_image_data(&self.pixels)?;
        Ok(())
    }
}
