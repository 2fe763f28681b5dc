//! Plates of a surface, and its coasts.

use super::query::value;
use crate::simulation::{Crust, Surface, surface::PlateSummary};
use glam::DVec3;
use std::collections::BTreeMap;

impl Surface {
    /// All plates in the order of their ids. Worked out once.
    #[must_use]
    pub fn plates(&self) -> &[PlateSummary] {
        self.kept.plates.get_or_init(|| self.sum_up_plates())
    }

    /// A plate by its id; none for an id that no plate has.
    #[must_use]
    pub fn plate(&self, id: u16) -> Option<&PlateSummary> {
        let plates = self.plates();
        let row = plates.binary_search_by_key(&id, |plate| plate.id).ok()?;
        plates.get(row)
    }

    /// Sub-plates of land next to the sea, ascending.
    ///
    /// Cities like coasts that are neither high nor young:
    ///
    /// ```
    /// use bevy_tectonics::prelude::*;
    ///
    /// let surface = History::new(Recipe::earth_like(7).with_sub_plates(500))?.surface()?;
    /// let cities: Vec<_> = surface
    ///     .coasts()
    ///     .map(|sub_plate| surface.at(surface.mesh.site(sub_plate)))
    ///     .filter(|place| place.elevation < 800.0)
    ///     .filter(|place| {
    ///         let fault = surface.nearest_boundary(place.direction);
    ///         fault.is_none_or(|fault| fault.distance_km > 100.0)
    ///     })
    ///     .take(12)
    ///     .collect();
    /// for city in &cities {
    ///     let (here, up) = (surface.point(city.direction, 1.0), city.direction);
    ///     println!("at {here}, upright along {up}");
    /// }
    /// # Ok::<(), TectonicError>(())
    /// ```
    pub fn coasts(&self) -> impl Iterator<Item = u32> {
        let is_land = |v: u32| value(&self.elevation, v) > 0.0;
        (0..self.mesh.vertex_count() as u32)
            .filter(move |&v| is_land(v) && self.mesh.neighbours(v).any(|w| !is_land(w)))
    }

    fn sum_up_plates(&self) -> Vec<PlateSummary> {
        let mut plates: BTreeMap<u16, PlateSummary> = BTreeMap::new();
        let square_km = self.radius_km * self.radius_km;
        for (vertex, &id) in (0..self.mesh.vertex_count() as u32).zip(&self.plate) {
            let area = self.mesh.cell_area(vertex) * square_km;
            let plate = plates.entry(id).or_insert_with(|| PlateSummary {
                id,
                sub_plates: 0,
                area_km2: 0.0,
                continental_share: 0.0,
                centre: DVec3::ZERO,
                rotation: self.rotation(id),
                speed: 0.0,
            });
            plate.sub_plates += 1;
            plate.area_km2 += area;
            plate.centre += self.mesh.site(vertex) * area;
            plate.speed += f64::from(value(&self.velocity, vertex).length()) * area;
            if value(&self.crust, vertex) == Crust::Continental {
                plate.continental_share += area;
            }
        }
        let means = plates.into_values().map(|plate| PlateSummary {
            continental_share: plate.continental_share / plate.area_km2.max(1e-9),
            speed: plate.speed / plate.area_km2.max(1e-9),
            centre: plate.centre.normalize_or(DVec3::Z),
            ..plate
        });
        means.collect()
    }
}
