//! What lies under the pointer.

use super::figures::{azimuth, latitude, longitude, tenth_in, whole, whole_in};
use super::look;
use crate::planet::{PlanetSurface, Planets};
use crate::simulation::{BoundaryKind, Crust, Orogeny, Surface};
use crate::surface::{NearBoundary, Place, east_north, lat_lon};
use bevy::camera::{Camera, NormalizedRenderTarget, RenderTarget};
use bevy::math::{DVec3, Ray3d};
use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use bevy_egui::{egui::Ui, input::EguiWantsInput};

/// What the pointer was last over.
#[derive(Resource, Debug, Default)]
pub(super) struct Pointer(pub Option<Spot>);

/// A place on a planet, and what is near.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spot {
    pub planet: Entity,
    pub place: Place,
    pub boundary: Option<NearBoundary>,
}

impl Spot {
    pub(super) fn new(planet: Entity, surface: &Surface, place: Place) -> Self {
        Self {
            planet,
            place,
            boundary: surface.nearest_boundary(place.direction),
        }
    }
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

/// Looks along the pointer's ray, unless it is the panel's.
pub(super) fn look_under_pointer(
    wants: Option<Res<EguiWantsInput>>,
    window: Option<Single<(Entity, &Window), With<PrimaryWindow>>>,
    cameras: Cameras,
    planets: Planets,
    surfaces: Query<&PlanetSurface>,
    mut pointer: ResMut<Pointer>,
) {
    // What was last seen stays while the panel is used.
    if wants.is_some_and(|wants| wants.wants_any_pointer_input()) {
        return;
    }
    let spot = window
        .and_then(|window| cast(window.0, window.1, &cameras))
        .and_then(|ray| planets.pick(ray))
        .and_then(|pick| {
            let surface = surfaces.get(pick.planet).ok()?;
            Some(Spot::new(pick.planet, surface, pick.place))
        });
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

/// Azimuth of a tangent vector in degrees from north over east.
fn bearing(direction: DVec3, vector: DVec3) -> f64 {
    let (east, north) = east_north(direction);
    libm::atan2(vector.dot(east), vector.dot(north)).to_degrees()
}

/// The lines: names, and hints where names do not say it all.
const LINES: [(&str, &str); 8] = [
    ("Place", ""),
    (
        "Elevation",
        "Of the ground; of the floor where there is sea.",
    ),
    ("Crust", "Kind and thickness."),
    ("Age", "Of the crust."),
    ("Plate", ""),
    ("Velocity", "Speed, and azimuth from north over east."),
    ("Mountains", "The last mountain building."),
    (
        "Boundary",
        "The nearest boundary of plates, its distance, and how fast the plates slip.",
    ),
];

/// Draws the section.
pub(super) fn show(ui: &mut Ui, spot: Option<&Spot>) {
    ui.spacing_mut().item_spacing.y = 1.0;
    // The same lines with nothing in them, so that nothing below moves.
    let figures = spot.map(figures);
    for (i, (name, hint)) in LINES.into_iter().enumerate() {
        let figure = figures.as_ref().map_or("–", |figures| &figures[i]);
        let response = look::fact(ui, name, figure, None);
        if !hint.is_empty() {
            response.on_hover_text(hint);
        }
    }
}

/// What stands in the lines.
fn figures(spot: &Spot) -> [String; LINES.len()] {
    let place = &spot.place;
    let crust = match place.crust {
        Crust::Oceanic => "oceanic",
        Crust::Continental => "continental",
    };
    let thickness = tenth_in(f64::from(place.thickness), "km");
    let (north, east) = lat_lon(place.direction);
    [
        format!("{}, {}", latitude(north), longitude(east)),
        whole_in(f64::from(place.elevation), "m"),
        format!("{crust}, {thickness} thick"),
        whole_in(f64::from(place.age), "My"),
        plate(place.plate),
        velocity(place),
        mountains(place),
        spot.boundary
            .as_ref()
            .map_or_else(|| "none".into(), boundary),
    ]
}

fn mountains(place: &Place) -> String {
    match place.orogeny {
        Orogeny::None => "none".into(),
        kind => format!("{}, {}", belt(kind), since(f64::from(place.orogeny_age))),
    }
}

fn plate(id: u16) -> String {
    if id == 0 {
        "none".into()
    } else {
        format!("number {id}")
    }
}

fn velocity(place: &Place) -> String {
    let velocity = place.velocity.as_dvec3();
    let speed = velocity.length();
    if speed < 0.05 {
        return "at rest".into();
    }
    let direction = azimuth(bearing(place.direction, velocity));
    format!("{}, {direction}", tenth_in(speed, "mm/yr"))
}

fn boundary(near: &NearBoundary) -> String {
    let kind = match near.segment.kind {
        BoundaryKind::Ridge => "ridge",
        BoundaryKind::Joined | BoundaryKind::Transform => "transform",
        BoundaryKind::SubductingOrigin | BoundaryKind::SubductingDestination => "subduction",
        BoundaryKind::Collision => "collision",
    };
    let speed = near.segment.slip.length();
    format!(
        "{kind}, {}, {}",
        whole_in(near.distance_km, "km"),
        tenth_in(f64::from(speed), "mm/yr")
    )
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
    fn bearings_go_from_north_over_east() {
        let bearing = |vector| bearing(DVec3::X, vector);
        assert_eq!(bearing(DVec3::Z), 0.0);
        assert_eq!(bearing(DVec3::Y), 90.0);
        assert_eq!(bearing(DVec3::NEG_Y), -90.0);
        assert_eq!(azimuth(bearing(DVec3::NEG_Y)), "270° W");
    }
}
