//! The tiles that a planet has: made on background tasks, drawn, kept for a while, given up.

use super::{
    Outlook, PlanetTiles, SEA, TilesDrawn,
    address::{Address, Bounds, DEEPEST, QUADS},
    choice::{Choice, Eyes, LEAST_REACH},
    tile::{Tile, grow, origin},
};
use crate::{
    planet::PlanetView,
    render::{
        globe::{exaggeration, pool, sea_level_m},
        material::PlanetMaterial,
    },
    simulation::Surface,
    surface::SurfaceError,
};
use bevy::{
    camera::{primitives::Aabb, visibility::NoAutoAabb},
    light::NotShadowCaster,
    math::DVec3,
    mesh::MeshTag,
    platform::collections::HashMap,
    prelude::*,
    tasks::{Task, futures::check_ready},
};
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::sync::Arc;

/// Seconds in which a new tile glides from its parent's shape to its own, and in which tiles take over in place.
const GLIDE_S: f32 = 0.4;
/// Altitude in radii below which coarse tiles are better than the sphere.
const COARSE_BELOW: f64 = 0.3;
/// Frames for which a tile that is not drawn is kept in any case.
const SPARED: u32 = 60;
/// Ground that is surely above this, in m.
const LOWEST_M: f32 = -12_000.0;

/// What tiles are chosen and drawn by.
pub(super) struct Scene<'a> {
    pub outlook: &'a Outlook,
    pub view: &'a PlanetView,
    pub tiles: &'a PlanetTiles,
    pub material: &'a Handle<PlanetMaterial>,
}

impl Scene<'_> {
    /// See [`PlanetTiles::reach`].
    pub fn reach(&self) -> f64 {
        let reach = f64::from(self.tiles.reach);
        if reach.is_finite() {
            reach.clamp(LEAST_REACH, 10.0)
        } else {
            LEAST_REACH
        }
    }
}

/// What the shape of tiles depends on besides their ground.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Measure {
    exaggeration: f32,
    /// Radius of the planet in m.
    radius_m: f64,
    /// Radii per m of elevation.
    scale: f64,
    /// Elevation of the sea in m, where there is one.
    sea: Option<f32>,
}

impl Measure {
    fn of(view: &PlanetView, surface: &Surface) -> Self {
        let exaggeration = exaggeration(view);
        let radius_m = 1000.0 * surface.radius_km;
        Self {
            exaggeration,
            radius_m,
            scale: f64::from(exaggeration) / radius_m,
            sea: sea_level_m(view),
        }
    }

    /// Radius of what lies at an elevation in m.
    fn radius(&self, height: f32) -> f64 {
        1.0 + self.scale * f64::from(height)
    }

    fn extent(&self, tile: &Tile) -> Extent {
        let [low, high] = tile.range;
        let sea = self.sea.unwrap_or(low);
        let address = tile.address;
        let (origin, phase) = origin(address, self.radius_m);
        let skirt = address.size() / f64::from(QUADS / 2) * f64::from(self.exaggeration).max(1.0);
        let floor = self.radius(low.min(sea)) - skirt;
        let drawn = Bounds::new(address, floor, self.radius(high.max(sea)));
        Extent {
            measure: *self,
            origin,
            phase,
            middle: address.middle(),
            steepest: tile.steepest * self.exaggeration,
            ground: Bounds::new(address, self.radius(low), self.radius(high)),
            drawn: drawn.around(origin),
            shows: match self.sea {
                Some(level) => [high >= level, low <= level],
                None => [true, false],
            },
        }
    }
}

/// Where a tile is and how far it reaches, worked out once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    measure: Measure,
    /// Where its vertices are counted from, in radii, and where in a period that is.
    pub origin: DVec3,
    phase: [u32; 3],
    middle: DVec3,
    /// Slope of its steepest triangle as it is drawn, in m per m.
    steepest: f32,
    ground: Bounds,
    /// A box around all that may be drawn of it, relative to its origin.
    pub drawn: Aabb,
    /// Whether there is ground above the sea, and sea.
    pub shows: [bool; 2],
}

impl Extent {
    /// Whether a sun in this direction, in the space of the planet's `Transform`, leaves any of its ground in the dark.
    pub fn has_shade(&self, address: Address, sun: DVec3) -> bool {
        let height = libm::asin(self.middle.dot(sun).clamp(-1.0, 1.0)) - address.size();
        height <= 0.0 || libm::tan(height) <= f64::from(self.steepest)
    }
}

pub(super) struct Forest {
    pub surface: Arc<Surface>,
    pub nodes: HashMap<Address, Node>,
    tasks: HashMap<Address, Growing>,
    /// Seconds for which tiles have been missing.
    waiting: HashMap<Address, f32>,
    pub frame: u32,
    made: u32,
    /// Whether tiles once covered what was in view as well as the sphere does.
    complete: bool,
    /// Whether the surface turned out to have columns of uneven length: it is drawn as a sphere.
    failed: bool,
    /// Share of the picture that tiles have taken over.
    pub share: f32,
}

/// A tile that is there.
pub(super) struct Node {
    tile: Arc<Tile>,
    pub extent: Extent,
    mesh: Handle<Mesh>,
    pub ground: Option<Entity>,
    pub sea: Option<Entity>,
    /// The last frame in which it was drawn; 0 if it never was.
    pub frame: u32,
    /// The last frame in which anything depended on it.
    used: AtomicU32,
    /// Seconds since it took over from its parent.
    seconds: f32,
}

/// A tile in the making. Dropping it stops it.
struct Growing(Task<Result<(Tile, Mesh), SurfaceError>>);

impl Node {
    /// What the shader wants to know of a tile: its level, how far it has come from its parent's shape, and where in
    /// a period its origin lies. Mirrored in `lift.wgsl`.
    pub fn tag(&self, address: Address) -> u32 {
        let glide = (self.seconds / GLIDE_S).clamp(0.0, 1.0);
        let [x, y, z] = self.extent.phase;
        u32::from(address.level) | ((255.0 * glide) as u32) << 5 | x << 13 | y << 19 | z << 25
    }
}

impl Forest {
    pub fn new(surface: Arc<Surface>) -> Self {
        Self {
            surface,
            nodes: HashMap::default(),
            tasks: HashMap::default(),
            waiting: HashMap::default(),
            frame: 0,
            made: 0,
            complete: false,
            failed: false,
            share: 0.0,
        }
    }

    /// Takes what is ready, chooses what is drawn, and has the missing made.
    pub fn tend(
        &mut self,
        scene: &Scene,
        share: f32,
        seconds: f32,
        meshes: &mut Assets<Mesh>,
        commands: &mut Commands,
    ) -> TilesDrawn {
        let measure = Measure::of(scene.view, &self.surface);
        for node in self.nodes.values_mut() {
            if node.extent.measure != measure {
                node.extent = measure.extent(&node.tile);
            }
        }
        self.receive(scene.tiles.per_frame, measure, meshes);
        if self.failed {
            return TilesDrawn::default();
        }
        let choice = self.choose(scene, measure);
        self.wait(&choice, seconds);
        self.order(&choice, scene.tiles.per_frame);
        self.draw(scene, &choice, seconds, commands);
        self.thin(scene.tiles.kept, commands);
        let in_view = choice.wanted.iter().filter(|wanted| wanted.in_view);
        let late = in_view.clone().map(|wanted| self.waiting[&wanted.address]);
        let late_s = late.fold(0.0, f32::max);
        let is_covered = choice.wanted.iter().all(|wanted| wanted.address.level > 0);
        let is_fine = in_view.clone().next().is_none() || scene.outlook.altitude() < COARSE_BELOW;
        self.complete |= is_covered && is_fine;
        let goal = if self.complete { share } else { 0.0 };
        let step = seconds / GLIDE_S;
        self.share += (goal - self.share).clamp(-step, step);
        TilesDrawn {
            drawn: choice.drawn.len() as u32,
            triangles: choice.drawn.len() as u32 * 2 * QUADS * QUADS,
            kept: self.nodes.len() as u32,
            missing: choice.wanted.len() as u32,
            missing_in_view: in_view.count() as u32,
            late_s,
            made: self.made,
            share: self.share,
        }
    }

    fn receive(&mut self, most: u32, measure: Measure, meshes: &mut Assets<Mesh>) {
        let mut left = most.max(1);
        let (nodes, made, frame) = (&mut self.nodes, &mut self.made, self.frame);
        let failed = &mut self.failed;
        self.tasks.retain(|&address, Growing(task)| {
            if left == 0 {
                return true;
            }
            match check_ready(task) {
                None => true,
                Some(Err(_)) => {
                    *failed = true;
                    false
                }
                Some(Ok((tile, mesh))) => {
                    left -= 1;
                    *made += 1;
                    let node = Node {
                        extent: measure.extent(&tile),
                        tile: Arc::new(tile),
                        mesh: meshes.add(mesh),
                        ground: None,
                        sea: None,
                        frame: 0,
                        used: AtomicU32::new(frame),
                        seconds: GLIDE_S,
                    };
                    nodes.insert(address, node);
                    false
                }
            }
        });
    }

    fn choose(&self, scene: &Scene, measure: Measure) -> Choice {
        let radius_m = 1000.0 * self.surface.radius_km;
        let finest_m = f64::from(scene.tiles.finest_m).max(1.0);
        let level = libm::log2(Address::SPAN * radius_m / (f64::from(QUADS) * finest_m));
        let lowest = measure.sea.map_or(LOWEST_M, |level| level.min(0.0));
        Eyes {
            places: &scene.outlook.places,
            gazes: &scene.outlook.gazes,
            reach: scene.reach(),
            deepest: level.clamp(0.0, f64::from(DEEPEST)) as u8,
            horizon: measure.radius(lowest).max(0.0),
        }
        .choose(|address| {
            let node = self.nodes.get(&address)?;
            node.used.store(self.frame, Relaxed);
            Some(node.extent.ground)
        })
    }

    fn wait(&mut self, choice: &Choice, seconds: f32) {
        let before = core::mem::take(&mut self.waiting);
        let missing = choice.wanted.iter().map(|wanted| wanted.address);
        self.waiting = missing
            .map(|address| {
                (
                    address,
                    before.get(&address).map_or(0.0, |past| past + seconds),
                )
            })
            .collect();
    }

    /// Has the most urgent tiles made, and stops what nobody wants any more.
    fn order(&mut self, choice: &Choice, per_frame: u32) {
        self.tasks
            .retain(|address, _| self.waiting.contains_key(address));
        // Enough for threads to be busy until the next frame, however long that takes.
        let most = (2 * pool().thread_num()).max(per_frame as usize).max(1);
        for wanted in &choice.wanted {
            if self.tasks.len() >= most {
                break;
            }
            let address = wanted.address;
            if self.tasks.contains_key(&address) {
                continue;
            }
            let parent = address.parent().and_then(|parent| self.nodes.get(&parent));
            let parent = parent.map(|node| node.tile.clone());
            let surface = self.surface.clone();
            let task = pool().spawn(async move { grow(&surface, address, parent) });
            self.tasks.insert(address, Growing(task));
        }
    }

    fn draw(&mut self, scene: &Scene, choice: &Choice, seconds: f32, commands: &mut Commands) {
        let last = self.frame;
        self.frame += 1;
        for &address in &choice.drawn {
            let was_drawn = |node: &Node| node.frame == last && last > 0;
            let parent = address.parent().and_then(|parent| self.nodes.get(&parent));
            let refines = parent.is_some_and(was_drawn);
            let Some(node) = self.nodes.get_mut(&address) else {
                continue;
            };
            node.seconds = match (was_drawn(node), refines) {
                (true, _) => (node.seconds + seconds).min(GLIDE_S),
                (false, true) => 0.0,
                (false, false) => GLIDE_S,
            };
            node.frame = self.frame;
            let [ground, sea] = node.extent.shows;
            let (tag, mesh) = (node.tag(address), node.mesh.clone());
            let transform = scene.outlook.transform(node.extent.origin);
            let mut part = |name: &'static str, flag| {
                let part = (
                    Name::new(name),
                    Mesh3d(mesh.clone()),
                    MeshMaterial3d(scene.material.clone()),
                    MeshTag(tag | flag),
                    transform,
                    Visibility::Hidden,
                    NoAutoAabb,
                    Aabb::default(),
                );
                commands.spawn(part).id()
            };
            if ground && node.ground.is_none() {
                node.ground = Some(part("Tile of ground", 0));
            }
            if sea && node.sea.is_none() {
                let sea = part("Tile of sea", SEA);
                // Nothing lies below it that light could reach.
                commands.entity(sea).insert(NotShadowCaster);
                node.sea = Some(sea);
            }
        }
    }

    /// Gives up tiles that have not been needed for longest, if there are too many.
    fn thin(&mut self, kept: u32, commands: &mut Commands) {
        let excess = self.nodes.len().saturating_sub(kept as usize);
        if excess == 0 {
            return;
        }
        let has_children = |address: Address| {
            let mut children = address.children().into_iter();
            address.level < DEEPEST && children.any(|child| self.nodes.contains_key(&child))
        };
        let idle = |node: &Node| self.frame - node.used.load(Relaxed) > SPARED;
        let mut spare: Vec<(u32, Address)> = self
            .nodes
            .iter()
            .filter(|&(&address, node)| address.level > 0 && idle(node) && !has_children(address))
            .map(|(&address, node)| (node.used.load(Relaxed), address))
            .collect();
        spare.sort_unstable();
        for (_, address) in spare.into_iter().take(excess) {
            if let Some(node) = self.nodes.remove(&address) {
                node.fell(commands);
            }
        }
    }

    pub fn fell(self, commands: &mut Commands) {
        for node in self.nodes.into_values() {
            node.fell(commands);
        }
    }
}

impl Node {
    fn fell(self, commands: &mut Commands) {
        for part in [self.ground, self.sea].into_iter().flatten() {
            if let Ok(mut part) = commands.get_entity(part) {
                part.try_despawn();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::{History, Recipe};

    #[test]
    fn only_ground_steeper_than_sunbeams_has_shade() {
        let recipe = Recipe::earth_like(7).with_sub_plates(500);
        let surface = History::new(recipe).unwrap().surface().unwrap();
        let address = Address {
            level: 9,
            face: 2,
            x: 100,
            y: 300,
        };
        let (tile, _) = grow(&surface, address, None).unwrap();
        let extent = |exaggeration| {
            let view = PlanetView {
                exaggeration,
                ..default()
            };
            Measure::of(&view, &surface).extent(&tile)
        };
        let up = address.middle();
        let east = up.any_orthonormal_vector();
        let sun = |degrees: f64| {
            up * libm::sin(degrees.to_radians()) + east * libm::cos(degrees.to_radians())
        };
        let plain = extent(1.0);
        assert!(plain.steepest > 0.0);
        let steepest = libm::atan(f64::from(plain.steepest)).to_degrees();
        assert!(!plain.has_shade(address, sun(steepest + 1.0)));
        assert!(plain.has_shade(address, sun(steepest - 1.0)));
        assert!(plain.has_shade(address, sun(-5.0)));
        assert!(extent(40.0).has_shade(address, sun(steepest + 1.0)));
    }
}
