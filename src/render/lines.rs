//! Boundaries and arrows over the ground of planets: meshes that come, change and go with the view.
//!
//! A mesh is built on a background task; until it is there the one before stays.

use super::{
    arrows, boundaries,
    drape::{Drape, Heights},
};
use crate::planet::{Planet, PlanetSurface, PlanetView};
use crate::simulation::Surface;
use bevy::{
    asset::AssetEventSystems,
    camera::visibility::VisibilitySystems,
    ecs::change_detection::Tick,
    light::{NotShadowCaster, NotShadowReceiver},
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, TaskPool, futures::check_ready},
    transform::TransformSystems,
};

/// Brings lines towards the camera, in units of the depth buffer's last place: the ground as it is drawn
/// is not quite the ground as it is sampled.
const DEPTH_BIAS: f32 = 4000.0;

/// What is laid over a planet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Layer {
    Boundaries,
    Velocities,
}

impl Layer {
    const ALL: [Self; 2] = [Self::Boundaries, Self::Velocities];

    fn name(self) -> &'static str {
        match self {
            Self::Boundaries => "Boundaries",
            Self::Velocities => "Velocities",
        }
    }

    fn is_wanted(self, view: &PlanetView) -> bool {
        match self {
            Self::Boundaries => view.boundaries,
            Self::Velocities => view.velocities,
        }
    }

    /// None where there is nothing to draw.
    fn mesh(self, surface: &Surface, heights: Heights) -> Option<Mesh> {
        let mut drape = Drape::new(surface, heights).ok()?;
        match self {
            Self::Boundaries => {
                let pieces: Vec<_> = surface.boundaries().iter().map(Into::into).collect();
                boundaries::lay(&mut drape, &pieces);
            }
            Self::Velocities => arrows::lay(&mut drape),
        }
        drape.finish()
    }
}

/// What a mesh depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stamp {
    surface: Tick,
    heights: Heights,
}

/// A layer of the planet whose child the entity is.
#[derive(Component)]
#[require(NotShadowCaster, NotShadowReceiver)]
struct Laid {
    layer: Layer,
    shown: Option<Stamp>,
    /// Dropping it stops it.
    task: Option<(Stamp, Task<Option<Mesh>>)>,
}

/// The material of all lines: their vertices have the colours.
#[derive(Resource)]
struct LineMaterial(Handle<StandardMaterial>);

/// Draws lines in an app that has meshes and materials.
pub(super) fn plugin(app: &mut App) {
    let world = app.world_mut();
    if !world.contains_resource::<Assets<Mesh>>() {
        return;
    }
    let Some(mut materials) = world.get_resource_mut::<Assets<StandardMaterial>>() else {
        return;
    };
    let material = materials.add(StandardMaterial {
        unlit: true,
        depth_bias: DEPTH_BIAS,
        ..StandardMaterial::default()
    });
    world.insert_resource(LineMaterial(material));
    app.add_systems(
        PostUpdate,
        tend.before(TransformSystems::Propagate)
            .before(VisibilitySystems::VisibilityPropagate)
            .before(VisibilitySystems::CalculateBounds)
            // A mesh is on the screen in the frame in which it is ready: no gap after the old one.
            .before(AssetEventSystems),
    );
}

fn tend(
    mut commands: Commands,
    material: Res<LineMaterial>,
    mut meshes: ResMut<Assets<Mesh>>,
    planets: Query<(Entity, &Planet, &PlanetView, Ref<PlanetSurface>)>,
    mut laid: Query<(Entity, &ChildOf, &mut Laid, &mut Transform), Without<Planet>>,
) {
    let mut present = Vec::new();
    for (entity, planet_of, mut laid, mut transform) in &mut laid {
        let owner = planets.get(planet_of.parent()).ok();
        let Some((owner, planet, view, surface)) =
            owner.filter(|(_, _, view, _)| laid.layer.is_wanted(view))
        else {
            commands.entity(entity).despawn();
            continue;
        };
        present.push((owner, laid.layer));
        transform.set_if_neq(scale(planet));
        if let Some((stamp, mesh)) = laid.tend(view, &surface) {
            laid.shown = Some(stamp);
            let mut entity = commands.entity(entity);
            match mesh {
                Some(mesh) => entity.insert(Mesh3d(meshes.add(mesh))),
                None => entity.remove::<Mesh3d>(),
            };
        }
    }
    for (owner, planet, view, surface) in &planets {
        for layer in Layer::ALL {
            if !layer.is_wanted(view) || present.contains(&(owner, layer)) {
                continue;
            }
            let mut laid = Laid {
                layer,
                shown: None,
                task: None,
            };
            laid.tend(view, &surface);
            commands.spawn((
                Name::new(layer.name()),
                laid,
                MeshMaterial3d(material.0.clone()),
                scale(planet),
                Visibility::default(),
                ChildOf(owner),
            ));
        }
    }
}

fn scale(planet: &Planet) -> Transform {
    Transform::from_scale(Vec3::splat(planet.radius))
}

impl Laid {
    /// Begins what is due, and returns what has become ready.
    fn tend(
        &mut self,
        view: &PlanetView,
        surface: &Ref<PlanetSurface>,
    ) -> Option<(Stamp, Option<Mesh>)> {
        let stamp = Stamp {
            surface: surface.last_changed(),
            heights: Heights::from(view),
        };
        let Some((built, task)) = &mut self.task else {
            if self.shown != Some(stamp) {
                let (layer, surface) = (self.layer, surface.share());
                let work = async move { layer.mesh(&surface, stamp.heights) };
                let pool = AsyncComputeTaskPool::get_or_init(TaskPool::new);
                self.task = Some((stamp, pool.spawn(work)));
            }
            return None;
        };
        let ready = check_ready(task).map(|mesh| (*built, mesh));
        if ready.is_some() {
            self.task = None;
        }
        ready
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planet::PlanetPlugin;
    use crate::simulation::Recipe;
    use core::time::Duration;

    fn game() -> App {
        let mut app = App::new();
        app.add_plugins((
            MinimalPlugins,
            AssetPlugin::default(),
            PlanetPlugin::default().with_threads(1),
        ))
        .init_asset::<Mesh>()
        .init_asset::<StandardMaterial>()
        .add_plugins(plugin);
        app
    }

    /// Frames until something holds.
    fn until(app: &mut App, what: &str, mut holds: impl FnMut(&mut World) -> bool) {
        for _ in 0..20_000 {
            app.update();
            if holds(app.world_mut()) {
                return;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        panic!("never: {what}");
    }

    fn drawn(world: &mut World) -> Vec<(Layer, Handle<Mesh>)> {
        let mut query = world.query::<(&Laid, &Mesh3d)>();
        let drawn = query.iter(world);
        drawn
            .map(|(laid, mesh)| (laid.layer, mesh.0.clone()))
            .collect()
    }

    fn view(app: &mut App, planet: Entity) -> Mut<'_, PlanetView> {
        app.world_mut().get_mut(planet).unwrap()
    }

    #[test]
    fn lines_come_and_change_and_go_with_the_view() {
        let mut app = game();
        let recipe = Recipe::earth_like(7).with_sub_plates(500);
        let planet = Planet::new(recipe).with_radius(3.0).with_end(1.0);
        let planet = app.world_mut().spawn(planet).id();
        until(&mut app, "a surface", |world| {
            world.get::<PlanetSurface>(planet).is_some()
        });
        assert!(drawn(app.world_mut()).is_empty());

        view(&mut app, planet).boundaries = true;
        view(&mut app, planet).velocities = true;
        until(&mut app, "two layers", |world| drawn(world).len() == 2);
        let transforms = &mut app.world_mut().query_filtered::<&Transform, With<Laid>>();
        assert!(
            transforms
                .iter(app.world())
                .all(|t| t.scale == Vec3::splat(3.0))
        );

        view(&mut app, planet).velocities = false;
        until(&mut app, "one layer", |world| drawn(world).len() == 1);
        let (layer, before) = drawn(app.world_mut()).remove(0);
        assert_eq!(layer, Layer::Boundaries);

        view(&mut app, planet).exaggeration = 30.0;
        until(&mut app, "another mesh", |world| {
            // Never without one.
            let (_, mesh) = drawn(world).remove(0);
            mesh != before
        });
        app.world_mut().despawn(planet);
        until(&mut app, "nothing", |world| drawn(world).is_empty());
    }

    #[test]
    fn a_planet_that_is_none_any_more_has_no_lines() {
        let mut app = game();
        let planet = Planet::new(Recipe::earth_like(7).with_sub_plates(500)).with_end(1.0);
        let view = PlanetView {
            boundaries: true,
            ..PlanetView::default()
        };
        let planet = app.world_mut().spawn((planet, view)).id();
        until(&mut app, "lines", |world| drawn(world).len() == 1);
        app.world_mut().entity_mut(planet).remove::<Planet>();
        until(&mut app, "nothing", |world| drawn(world).is_empty());
    }

    #[test]
    fn apps_without_meshes_do_without_lines() {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, plugin));
        app.update();
    }
}
