//! Plates, boundaries and rotations for geographic programs.

mod outlines;
mod plane;

use super::{
    ExportError, check_surface,
    draft::{self, Draft},
    rotations::{ROTATIONS_FILE, gplates_id, rotations_rot},
};
use crate::simulation::{BoundaryKind, EulerRotation, RotationHistory, Surface};
use crate::surface::{PlateSummary, lat_lon};
use geojson::{Feature, FeatureCollection, GeometryValue, JsonObject};
use serde_json::json;
use std::{
    collections::BTreeMap,
    io::{self, Write},
    path::{Path, PathBuf},
};

/// Names of the files that [`write_geography`] writes.
pub const GEOGRAPHY_FILES: [&str; 4] = [
    "plates.geojson",
    "boundaries.geojson",
    "poles.geojson",
    ROTATIONS_FILE,
];

/// Writes plates, boundaries and rotations into `folder`, which is created where it does not exist, and
/// returns the paths of the files.
///
/// | file | content |
/// |---|---|
/// | `plates.geojson` | [`plates_geojson`] |
/// | `boundaries.geojson` | [`boundaries_geojson`] |
/// | `poles.geojson` | [`poles_geojson`] |
/// | `rotations.rot` | [`rotations_rot`] |
///
/// Rotations are those that a [`RotationHistoryPlugin`](crate::simulation::RotationHistoryPlugin) has
/// recorded until this moment, or else [`RotationHistory::of`] it. Longitudes and latitudes are those of a
/// sphere. `GPlates` takes the outlines back along their rotations to when a plate came to be, and
/// [`import`](crate::import) reads outlines and motions as a start: `elevation.png` with `plates.geojson`
/// is a planet to go on from, without its history.
///
/// # Errors
/// [`ExportError`] names the file and the cause; nothing half-written is left behind.
pub fn write_geography(
    surface: &Surface,
    rotations: &RotationHistory,
    folder: &Path,
) -> Result<Vec<PathBuf>, ExportError> {
    check_surface(surface)?;
    // Plates that came to be at the end of the last step have not turned yet.
    let rotations = &rotations.completed(surface);
    let drafts = GEOGRAPHY_FILES.into_iter().map(|name| {
        let draft = Draft::create(folder, name)?;
        draft.fill(|pen| match name {
            "plates.geojson" => plates_geojson(surface, rotations, pen),
            "boundaries.geojson" => boundaries_geojson(surface, pen),
            "poles.geojson" => poles_geojson(surface, pen),
            _ => rotations_rot(rotations, pen),
        })?;
        Ok(draft)
    });
    let drafts: Result<Vec<Draft>, ExportError> = drafts.collect();
    draft::publish(drafts?)
}

/// Writes the outlines of plates as `GeoJSON`: a `MultiPolygon` each, along the sides of sub-plates, cut at
/// the antimeridian. They hold the places whose [`at`](Surface::at) lies on the plate, but for some hundred
/// metres where great circles are not straight on the plane; maps bend the same boundaries by noise finer
/// than sub-plates.
///
/// Properties: `plate` (the id), `area_km2`, `continental_share`, and `rotation` as an imported start has
/// it: `lat` and `lon` of the pole and `deg_per_my`. For `GPlates`: `PLATEID1`, the id as
/// [`rotations_rot`] has it, `FROMAGE`, the age in My back to which rotations of the plate are known, and
/// `TOAGE`, 0.
///
/// # Errors
/// What `writer` says.
pub fn plates_geojson(
    surface: &Surface,
    rotations: &RotationHistory,
    writer: impl Write,
) -> io::Result<()> {
    let from: BTreeMap<u16, f64> = rotations
        .plates()
        .filter_map(|plate| Some((plate.id, plate.totals.last()?.age_my)))
        .collect();
    let rings = outlines::rings(surface);
    let features = surface.plates().iter().map(|plate| {
        let rings = rings.get(&plate.id).map_or(&[][..], Vec::as_slice);
        let outline = GeometryValue::new_multi_polygon(plane::polygons(rings));
        let rotation = rotation(plate);
        let properties = json!({
            "plate": plate.id,
            "PLATEID1": gplates_id(plate.id),
            "FROMAGE": from.get(&plate.id).copied().unwrap_or(0.0),
            "TOAGE": 0.0,
            "area_km2": plate.area_km2,
            "continental_share": plate.continental_share,
            "rotation": rotation,
        });
        feature(outline, properties)
    });
    write(features.collect(), writer)
}

/// Writes the boundaries between plates as `GeoJSON`: a line for each stretch of one kind, in several
/// pieces where it crosses the antimeridian.
///
/// Properties: `kind` (`ridge`, `trench`, `transform` or `collision`), `left` and `right` (ids of the
/// plates), `subducting` (the id of the plate that goes under, or null), `length_km`, and means over the
/// length in mm/yr: `speed_mm_yr` of the plates past each other and `opening_mm_yr`, negative where they
/// close.
///
/// # Errors
/// What `writer` says.
pub fn boundaries_geojson(surface: &Surface, writer: impl Write) -> io::Result<()> {
    let features = outlines::fronts(surface).into_iter().map(|front| {
        let line = GeometryValue::new_multi_line_string(plane::lines(&front.points));
        let [left, right] = front.plates;
        let (kind, subducting) = match front.kind {
            BoundaryKind::Ridge => ("ridge", None),
            BoundaryKind::SubductingOrigin => ("trench", Some(left)),
            BoundaryKind::SubductingDestination => ("trench", Some(right)),
            BoundaryKind::Collision => ("collision", None),
            BoundaryKind::Transform | BoundaryKind::Joined => ("transform", None),
        };
        let properties = json!({
            "kind": kind,
            "left": left,
            "right": right,
            "subducting": subducting,
            "length_km": front.length_km,
            "speed_mm_yr": front.speed,
            "opening_mm_yr": front.opening,
        });
        feature(line, properties)
    });
    write(features.collect(), writer)
}

/// Writes how plates turn as `GeoJSON`: a point at each plate's Euler pole, with the properties `plate`,
/// `deg_per_my` (counter-clockwise seen from above) and `speed_mm_yr`, the plate's mean speed.
///
/// # Errors
/// What `writer` says.
pub fn poles_geojson(surface: &Surface, writer: impl Write) -> io::Result<()> {
    let features = surface.plates().iter().map(|plate| {
        let EulerRotation {
            lat,
            lon,
            deg_per_my,
        } = rotation(plate);
        let properties = json!({
            "plate": plate.id,
            "deg_per_my": deg_per_my,
            "speed_mm_yr": plate.speed,
        });
        feature(GeometryValue::new_point([lon, lat]), properties)
    });
    write(features.collect(), writer)
}

/// The motion of a plate about its pole. One that rests has the north pole.
pub(super) fn rotation(plate: &PlateSummary) -> EulerRotation {
    let (lat, lon) = lat_lon(plate.rotation);
    EulerRotation {
        lat,
        lon,
        deg_per_my: plate.rotation.length().to_degrees(),
    }
}

fn feature(geometry: GeometryValue, properties: serde_json::Value) -> Feature {
    let properties: Option<JsonObject> = match properties {
        serde_json::Value::Object(properties) => Some(properties),
        _ => None,
    };
    Feature {
        properties,
        ..Feature::from(geometry)
    }
}

fn write(features: Vec<Feature>, mut writer: impl Write) -> io::Result<()> {
    serde_json::to_writer(&mut writer, &FeatureCollection::new(features))?;
    writer.write_all(b"\n")
}
