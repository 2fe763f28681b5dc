//! What lies under the pointer.

use super::figures::{azimuth, latitude, longitude, tenth_in, whole, whole_in};
use super::look::{self, FAINT};
use crate::planet::{Planet, PlanetSurface, from_scene};
use crate::simulation::{Crust, Orogeny, Surface};
use bevy::camera::{Camera, NormalizedRenderTarget, RenderTarget};
use bevy::math::{DVec3, Ray3d};
use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use bevy_egui::{
    egui::{RichText, Ui},
    input::EguiWantsInput,
};

/// What the pointer was last over.
#[derive(Resource, Debug, Default)]
pub(super) struct Pointer(pub Option<Spot>);

/// A place on a planet in figures.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spot {
    pub planet: Entity,
    /// Degrees.
    pub latitude: f64,
    pub longitude: f64,
    pub elevation_m: f64,
    pub crust: Crust,
    /// Id, 0 = none.
    pub plate: u16,
    pub age_my: f64,
    pub thickness_km: f64,
    /// mm/yr.
    pub speed: f64,
    /// Degrees from north over east.
    pub azimuth: f64,
    pub orogeny: Orogeny,
    pub orogeny_age_my: f64,
    /// What the nearest boundary is, and how far in km.
    pub boundary: Option<(&'static str, f64)>,
}

type Cameras<'w, 's> = Query<
    'w,
    's,
    (
        &'static Camera,
        &'static RenderTarget,
        &'static GlobalTransform,
    ),
    With<Camera3d>,
>;

type Targets<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static Planet,
        &'static GlobalTransform,
        &'static PlanetSurface,
    ),
>;

/// Looks along the pointer's ray, unless it is the panel's.
pub(super) fn look_under_pointer(
    wants: Option<Res<EguiWantsInput>>,
    window: Option<Single<(Entity, &Window), With<PrimaryWindow>>>,
    cameras: Cameras,
    planets: Targets,
    mut pointer: ResMut<Pointer>,
) {
    // What was last seen stays while the panel is used.
    if wants.is_some_and(|wants| wants.wants_any_pointer_input()) {
        return;
    }
    let spot = window
        .and_then(|window| cast(window.0, window.1, &cameras))
        .and_then(|ray| pick(ray, &planets));
    if pointer.0 != spot {
        pointer.0 = spot;
    }
}

/// The ray of the pointer through the foremost camera of the window under it.
fn cast(window: Entity, properties: &Window, cameras: &Cameras) -> Option<Ray3d> {
    let cursor = properties.cursor_position()?;
    let foremost = cameras
        .iter()
        .filter(|(camera, target, _)| {
            camera.is_active
                && matches!(
                    target.normalize(Some(window)),
                    Some(NormalizedRenderTarget::Window(seen)) if seen.entity() == window
                )
                && camera
                    .logical_viewport_rect()
                    .is_some_and(|rect| rect.contains(cursor))
        })
        .max_by_key(|(camera, _, _)| camera.order)?;
    let (camera, _, transform) = foremost;
    camera.viewport_to_world(transform, cursor).ok()
}

/// The one place that asks what a ray meets.
fn pick(ray: Ray3d, planets: &Targets) -> Option<Spot> {
    // PLUG: `let pick = planets.pick(ray)?; Some(describe(pick.planet, surface, &pick.place))`, with the
    // parameter `planets: crate::planet::Planets`, in place of everything below.
    let mut nearest: Option<(f32, Spot)> = None;
    for (entity, planet, transform, surface) in planets {
        let back = transform.affine().inverse();
        let origin = back.transform_point3(ray.origin);
        let direction = back.transform_vector3(*ray.direction).normalize_or_zero();
        let Some(distance) = meet_sphere(origin, direction, planet.radius) else {
            continue;
        };
        if nearest.as_ref().is_none_or(|(best, _)| distance < *best) {
            let place = from_scene(origin + direction * distance).normalize_or(DVec3::Z);
            nearest = Some((distance, describe(entity, surface, place)));
        }
    }
    nearest.map(|(_, spot)| spot)
}

/// Distance at which a ray from outside meets a sphere around the origin.
fn meet_sphere(origin: Vec3, direction: Vec3, radius: f32) -> Option<f32> {
    let along = origin.dot(direction);
    let root = along * along - origin.length_squared() + radius * radius;
    let distance = -along - root.max(0.0).sqrt();
    (root >= 0.0 && distance > 0.0).then_some(distance)
}

/// The one place that asks a surface what is where.
fn describe(planet: Entity, surface: &Surface, direction: DVec3) -> Spot {
    // PLUG: the fields of `surface.at(direction)`, and of `surface.nearest_boundary(direction)`.
    let here = surface.mesh.nearest(direction, 0) as usize;
    let velocity = surface
        .velocity
        .get(here)
        .map_or(DVec3::ZERO, |v| v.as_dvec3());
    let value = |column: &[f32]| column.get(here).copied().map_or(0.0, f64::from);
    Spot {
        planet,
        latitude: libm::asin(direction.z.clamp(-1.0, 1.0)).to_degrees(),
        longitude: libm::atan2(direction.y, direction.x).to_degrees(),
        elevation_m: value(&surface.elevation),
        crust: surface.crust.get(here).copied().unwrap_or_default(),
        plate: surface.plate.get(here).copied().unwrap_or_default(),
        age_my: value(&surface.age),
        thickness_km: value(&surface.thickness),
        speed: velocity.length(),
        azimuth: bearing(direction, velocity),
        orogeny: surface.orogeny.get(here).copied().unwrap_or_default(),
        orogeny_age_my: value(&surface.orogeny_age),
        boundary: None,
    }
}

/// Azimuth of a tangent vector in degrees from north over east.
fn bearing(place: DVec3, vector: DVec3) -> f64 {
    let east = DVec3::Z.cross(place).normalize_or(DVec3::Y);
    let north = place.cross(east);
    libm::atan2(vector.dot(east), vector.dot(north)).to_degrees()
}

/// Draws the section.
pub(super) fn show(ui: &mut Ui, spot: Option<&Spot>) {
    ui.spacing_mut().item_spacing.y = 1.0;
    let Some(spot) = spot else {
        ui.label(RichText::new("Move the pointer over the planet.").color(FAINT));
        return;
    };
    let crust = match spot.crust {
        Crust::Oceanic => "oceanic",
        Crust::Continental => "continental",
    };
    let plate = if spot.plate == 0 {
        "none".to_owned()
    } else {
        format!("number {}", spot.plate)
    };
    let mountains = match spot.orogeny {
        Orogeny::None => "none".to_owned(),
        kind => format!("{}, {}", belt(kind), since(spot.orogeny_age_my)),
    };
    let velocity = if spot.speed < 0.05 {
        "at rest".to_owned()
    } else {
        format!(
            "{} towards {}",
            tenth_in(spot.speed, "mm/yr"),
            azimuth(spot.azimuth)
        )
    };
    let boundary = spot.boundary.map_or_else(
        || "–".to_owned(),
        |(kind, distance)| format!("{kind}, {} away", whole_in(distance, "km")),
    );
    let place = format!("{}, {}", latitude(spot.latitude), longitude(spot.longitude));
    look::fact(ui, "Place", &place, None);
    let height = whole_in(spot.elevation_m, "m");
    look::fact(ui, "Elevation", &height, None);
    let thickness = tenth_in(spot.thickness_km, "km");
    look::fact(ui, "Crust", &format!("{crust}, {thickness} thick"), None);
    look::fact(ui, "Age", &whole_in(spot.age_my, "My"), None);
    look::fact(ui, "Plate", &plate, None);
    look::fact(ui, "Velocity", &velocity, None)
        .on_hover_text("Speed, and azimuth from north over east.");
    look::fact(ui, "Mountains", &mountains, None).on_hover_text("The last mountain building.");
    look::fact(ui, "Boundary", &boundary, None).on_hover_text("The nearest boundary of plates.");
}

fn belt(orogeny: Orogeny) -> &'static str {
    match orogeny {
        Orogeny::None => "none",
        Orogeny::Andean => "Andean",
        Orogeny::Himalayan => "Himalayan",
    }
}

fn since(age_my: f64) -> String {
    if age_my < 0.5 {
        "rising now".into()
    } else {
        format!("{} My ago", whole(age_my))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_meet_spheres_from_outside() {
        let from = Vec3::new(0.0, 0.0, 3.0);
        assert_eq!(meet_sphere(from, Vec3::NEG_Z, 1.0), Some(2.0));
        assert_eq!(meet_sphere(from, Vec3::Z, 1.0), None);
        assert_eq!(meet_sphere(from, Vec3::X, 1.0), None);
    }

    #[test]
    fn bearings_go_from_north_over_east() {
        let bearing = |vector| bearing(DVec3::X, vector);
        assert_eq!(bearing(DVec3::Z), 0.0);
        assert_eq!(bearing(DVec3::Y), 90.0);
        assert_eq!(bearing(DVec3::NEG_Y), -90.0);
        assert_eq!(azimuth(bearing(DVec3::NEG_Y)), "270° W");
    }
}
