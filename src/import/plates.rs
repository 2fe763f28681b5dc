//! Outlines and motions of plates.

use super::fault;
use crate::simulation::{EulerRotation, ImportedPlate, PlatePolygon, TectonicError};
use geojson::{Feature, FeatureCollection, GeometryValue, Position, feature::Id};
use serde_json::Value;
use std::collections::BTreeMap;

/// Properties that may name a plate, the first that is there.
const NAMES: [&str; 6] = ["plate", "Code", "code", "name", "PlateName", "id"];
/// What files must be.
pub(super) const OUTLINES: &str = "a GeoJSON collection of polygons, each named after its plate";
const NAME: &str = "named by a property `plate`, `Code`, `name` or `id`, or by its own id";
const ROTATION: &str = r#"like {"lat": 12.5, "lon": -70, "deg_per_my": 0.6}"#;
pub(super) const ROTATIONS: &str =
    r#"rotations by plate, like {"AF": {"lat": 12.5, "lon": -70, "deg_per_my": 0.6}}"#;

/// Reads the outlines of plates, in the order in which the file names them first.
pub(super) fn polygons(path: &str, text: &str) -> Result<Vec<ImportedPlate>, TectonicError> {
    let collection: FeatureCollection = text.parse().map_err(|error: geojson::Error| {
        let found = match &error {
            geojson::Error::MalformedGeoJson(error) => fault(error),
            _ => format!("it cannot be read ({error})"),
        };
        TectonicError::import(path, found, OUTLINES)
    })?;
    let mut plates: Vec<ImportedPlate> = Vec::new();
    for (number, feature) in collection.features.into_iter().enumerate() {
        let refuse = |found: String, allowed: &str| {
            let feature = format!("{path}, feature {}", number + 1);
            TectonicError::import(feature, found, allowed)
        };
        let name = name(&feature).ok_or_else(|| refuse("it has no name".into(), NAME))?;
        let rotation = match feature.property("rotation") {
            None | Some(Value::Null) => None,
            Some(value) => Some(
                serde_json::from_value::<EulerRotation>(value.clone()).map_err(|error| {
                    refuse(format!("its rotation is wrong ({error})"), ROTATION)
                })?,
            ),
        };
        let polygons = match feature.geometry.map(|geometry| geometry.value) {
            Some(GeometryValue::Polygon { coordinates }) => vec![polygon(&coordinates)],
            Some(GeometryValue::MultiPolygon { coordinates }) => {
                coordinates.iter().map(|rings| polygon(rings)).collect()
            }
            Some(other) => {
                let found = format!("it is a {}", other.type_name());
                return Err(refuse(found, "a Polygon or a MultiPolygon"));
            }
            None => {
                return Err(refuse(
                    "it has no geometry".into(),
                    "a Polygon or a MultiPolygon",
                ));
            }
        };
        let polygons: Option<Vec<PlatePolygon>> = polygons.into_iter().collect();
        let polygons = polygons
            .filter(|polygons| !polygons.is_empty())
            .ok_or_else(|| {
                let found = "it is empty, or a corner is no longitude and latitude".into();
                refuse(found, "closed rings of [longitude, latitude]")
            })?;
        match plates.iter_mut().find(|plate| plate.name == name) {
            Some(plate) => {
                plate.polygons.extend(polygons);
                plate.rotation = plate.rotation.or(rotation);
            }
            None => plates.push(ImportedPlate {
                name,
                polygons,
                rotation,
            }),
        }
    }
    if plates.is_empty() {
        return Err(TectonicError::import(path, "it is empty", OUTLINES));
    }
    Ok(plates)
}

/// What a feature is called.
fn name(feature: &Feature) -> Option<String> {
    let named = |value: &Value| match value {
        Value::String(name) if !name.is_empty() => Some(name.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    };
    let property = NAMES
        .iter()
        .find_map(|key| feature.property(key).and_then(named));
    property.or_else(|| match feature.id.as_ref()? {
        Id::String(name) => Some(name.clone()),
        Id::Number(number) => Some(number.to_string()),
    })
}

/// Rings of longitudes and latitudes; none if a corner lacks one or there is no ring.
fn polygon(rings: &[Vec<Position>]) -> Option<PlatePolygon> {
    let corner = |corner: &Position| match *corner.as_slice() {
        [lon, lat, ..] => Some([lon, lat]),
        _ => None,
    };
    let rings: Option<Vec<Vec<[f64; 2]>>> = rings
        .iter()
        .map(|ring| ring.iter().map(corner).collect())
        .collect();
    rings.filter(|rings| !rings.is_empty()).map(PlatePolygon)
}

/// Reads the motions of plates by name; they count more than those of the outlines.
pub(super) fn turn(
    path: &str,
    text: &str,
    plates: &mut [ImportedPlate],
) -> Result<(), TectonicError> {
    let rotations: BTreeMap<String, EulerRotation> = serde_json::from_str(text)
        .map_err(|error| TectonicError::import(path, fault(&error), ROTATIONS))?;
    for (name, rotation) in rotations {
        let Some(plate) = plates.iter_mut().find(|plate| plate.name == name) else {
            let names: Vec<&str> = plates.iter().map(|plate| plate.name.as_str()).collect();
            return Err(TectonicError::import(
                path,
                format!("it turns {name}, which has no outline"),
                format!("one of {}", names.join(", ")),
            ));
        };
        plate.rotation = Some(rotation);
    }
    Ok(())
}
