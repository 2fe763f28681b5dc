//! Sub-plates and plates as tables.

use super::{
    ExportError, check_surface,
    draft::{self, Draft},
    geography::rotation,
};
use crate::simulation::{Crust, Orogeny, Surface};
use crate::surface::{east_north, lat_lon};
use serde::Serialize;
use std::{
    io::{self, Write},
    path::{Path, PathBuf},
};

/// Names of the files that [`write_tables`] writes.
pub const TABLE_FILES: [&str; 2] = ["sub_plates.csv", "plates.csv"];

#[derive(Serialize)]
struct SubPlateRow {
    sub_plate: u32,
    latitude: f64,
    longitude: f64,
    plate: u16,
    crust: Crust,
    elevation_m: f32,
    thickness_km: f32,
    area_km2: f64,
    age_my: f32,
    velocity_east_mm_yr: f64,
    velocity_north_mm_yr: f64,
    orogeny: Orogeny,
    orogeny_age_my: f32,
    volcanism_age_my: Option<f32>,
}

#[derive(Serialize)]
struct PlateRow {
    plate: u16,
    sub_plates: u32,
    area_km2: f64,
    continental_share: f64,
    latitude: f64,
    longitude: f64,
    pole_latitude: f64,
    pole_longitude: f64,
    deg_per_my: f64,
    speed_mm_yr: f64,
}

/// Writes all sub-plates as CSV: a line of names, then a line each, in the order of the mesh's vertices.
///
/// `sub_plate` is the vertex; `latitude` and `longitude` are in degrees; `crust` is `Oceanic` or
/// `Continental`, `orogeny` the last mountain building, `None`, `Andean` or `Himalayan`, and
/// `orogeny_age_my` the time since, that of the crust where there was none; `volcanism_age_my` is empty
/// where no hot spot ever fed the crust. Names tell the units of the others. Numbers have as many digits as it takes to read
/// back the same bits.
///
/// # Errors
/// What `writer` says, and columns of a surface that do not have one value per sub-plate.
pub fn sub_plates_csv(surface: &Surface, writer: impl Write) -> io::Result<()> {
    check_surface(surface).map_err(io::Error::other)?;
    let mut csv = csv::Writer::from_writer(writer);
    let square_km = surface.radius_km * surface.radius_km;
    for (vertex, &site) in surface.mesh.sites().iter().enumerate() {
        let (latitude, longitude) = lat_lon(site);
        let (east, north) = east_north(site);
        let velocity = surface.velocity[vertex].as_dvec3();
        csv.serialize(SubPlateRow {
            sub_plate: vertex as u32,
            latitude,
            longitude,
            plate: surface.plate[vertex],
            crust: surface.crust[vertex],
            elevation_m: surface.elevation[vertex],
            thickness_km: surface.thickness[vertex],
            area_km2: surface.mesh.cell_area(vertex as u32) * square_km,
            age_my: surface.age[vertex],
            velocity_east_mm_yr: velocity.dot(east),
            velocity_north_mm_yr: velocity.dot(north),
            orogeny: surface.orogeny[vertex],
            orogeny_age_my: surface.orogeny_age[vertex],
            volcanism_age_my: surface.volcanism_age[vertex],
        })?;
    }
    csv.flush()
}

/// Writes all plates as CSV: a line of names, then a line each, in the order of ids.
///
/// `latitude` and `longitude` are those of the mean of the plate's places; `pole_latitude`,
/// `pole_longitude` and `deg_per_my` tell its rotation, counter-clockwise seen from above the pole;
/// `speed_mm_yr` is the mean over its area.
///
/// # Errors
/// What `writer` says.
pub fn plates_csv(surface: &Surface, writer: impl Write) -> io::Result<()> {
    let mut csv = csv::Writer::from_writer(writer);
    for plate in surface.plates() {
        let (latitude, longitude) = lat_lon(plate.centre);
        let rotation = rotation(plate);
        csv.serialize(PlateRow {
            plate: plate.id,
            sub_plates: plate.sub_plates,
            area_km2: plate.area_km2,
            continental_share: plate.continental_share,
            latitude,
            longitude,
            pole_latitude: rotation.lat,
            pole_longitude: rotation.lon,
            deg_per_my: rotation.deg_per_my,
            speed_mm_yr: plate.speed,
        })?;
    }
    csv.flush()
}

/// Writes `sub_plates.csv` and `plates.csv` into `folder`, which is created where it does not exist, and
/// returns their paths. See [`sub_plates_csv`] and [`plates_csv`] for their columns.
///
/// # Errors
/// [`ExportError`] names the file and the cause; nothing half-written is left behind.
pub fn write_tables(surface: &Surface, folder: &Path) -> Result<Vec<PathBuf>, ExportError> {
    check_surface(surface)?;
    let [sub_plates, plates] = TABLE_FILES.map(|name| Draft::create(folder, name));
    let [sub_plates, plates] = [sub_plates?, plates?];
    sub_plates.fill(|pen| sub_plates_csv(surface, pen))?;
    plates.fill(|pen| plates_csv(surface, pen))?;
    draft::publish(vec![sub_plates, plates])
}
