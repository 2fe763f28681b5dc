//! The ground in a direction: its height, its slope and what it is made of.

use super::coordinates::{direction_of, unit};
use crate::mesh::Location;
use crate::simulation::{Crust, Orogeny, Surface};
use glam::{DVec3, Vec3};

/// How the ground is drawn: its radius is `1 + exaggeration × elevation / radius of the planet`, in
/// radii of the planet.
///
/// A bare factor does where one is asked for: `surface.normal(direction, 20.0)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relief {
    /// Factor on elevations; 1 is true to scale. Negative counts as 0, what is not finite as 1.
    pub exaggeration: f64,
    /// Whether the sea's surface covers the ground that lies below it.
    pub sea: bool,
}

impl Relief {
    /// The ground as it is, sea floors laid bare.
    pub const TRUE_SCALE: Self = Self {
        exaggeration: 1.0,
        sea: false,
    };

    /// Elevations multiplied by a factor, sea floors laid bare.
    #[must_use]
    pub fn exaggerated(exaggeration: f64) -> Self {
        Self {
            exaggeration,
            ..Self::TRUE_SCALE
        }
    }

    /// The same with the sea's surface above its floor.
    #[must_use]
    pub fn with_sea(self) -> Self {
        Self { sea: true, ..self }
    }

    /// Radii per metre of elevation.
    pub(crate) fn scale(self, radius_km: f64) -> f64 {
        let factor = if self.exaggeration.is_finite() {
            self.exaggeration.max(0.0)
        } else {
            1.0
        };
        factor / (1000.0 * radius_km)
    }

    /// The elevation that counts, in m.
    pub(crate) fn height(self, elevation: f64) -> f64 {
        if self.sea {
            elevation.max(0.0)
        } else {
            elevation
        }
    }
}

impl Default for Relief {
    fn default() -> Self {
        Self::TRUE_SCALE
    }
}

impl From<f64> for Relief {
    fn from(exaggeration: f64) -> Self {
        Self::exaggerated(exaggeration)
    }
}

/// The planet at one place. Elevation and normal are continuous; everything else is that of the nearest
/// sub-plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Where it is: a unit vector in the planet's frame.
    pub direction: DVec3,
    /// Elevation of the ground in m above the sea; that of its floor where it is negative.
    pub elevation: f32,
    /// Upward unit normal of the ground true to scale. Of exaggerated ground, or of the sea, ask
    /// [`Surface::normal`].
    pub normal: DVec3,
    /// Kind of crust.
    pub crust: Crust,
    /// Id of the plate, 0 = none.
    pub plate: u16,
    /// Age of the crust in My.
    pub age: f32,
    /// Velocity in km/My (= mm/yr), tangent here.
    pub velocity: Vec3,
    /// Thickness of the crust in km.
    pub thickness: f32,
    /// Kind of the last mountain building.
    pub orogeny: Orogeny,
    /// Time since the last mountain building in My; that of the crust where there was none.
    pub orogeny_age: f32,
    /// The nearest sub-plate: vertex of the mesh, row of every column.
    pub sub_plate: u32,
}

/// Queries of places take directions of any length; the north pole stands for those that are zero or not
/// finite.
impl Surface {
    /// Elevation of the ground in m above the sea, linear between sub-plates and continuous.
    ///
    /// Takes well under a microsecond, whatever the order of places and the size of the planet.
    #[must_use]
    pub fn elevation(&self, direction: DVec3) -> f32 {
        let direction = unit(direction);
        self.elevation_at(&self.mesh.locate(direction, self.start(direction))) as f32
    }

    /// As [`elevation`](Self::elevation) for places that follow each other closely. `hint` is any
    /// sub-plate at first, best a nearby one; each call leaves the one where the next may start.
    #[must_use]
    pub fn elevation_from(&self, direction: DVec3, hint: &mut u32) -> f32 {
        let location = self.mesh.locate(unit(direction), *hint);
        *hint = location.vertices[0];
        self.elevation_at(&location) as f32
    }

    /// Everything about the place in a direction.
    ///
    /// ```
    /// use bevy_tectonics::prelude::*;
    /// use bevy_tectonics::surface::direction_of;
    ///
    /// let surface = History::new(Recipe::earth_like(7).with_sub_plates(500))?.surface()?;
    /// let place = surface.at(direction_of(47.0, 8.5));
    /// // A tower stands upright where it does not lean with the slope:
    /// let upright = place.direction;
    /// let leaning = place.normal;
    /// assert!(upright.dot(leaning) > 0.9);
    /// # Ok::<(), TectonicError>(())
    /// ```
    #[must_use]
    pub fn at(&self, direction: DVec3) -> Place {
        let direction = unit(direction);
        let location = self.mesh.locate(direction, self.start(direction));
        let sub_plate = self.mesh.nearest(direction, foremost(&location));
        let velocity = value(&self.velocity, sub_plate);
        let up = direction.as_vec3();
        Place {
            direction,
            elevation: self.elevation_at(&location) as f32,
            normal: self.normal_at(direction, &location, Relief::TRUE_SCALE),
            crust: value(&self.crust, sub_plate),
            plate: value(&self.plate, sub_plate),
            age: value(&self.age, sub_plate),
            velocity: velocity - up * up.dot(velocity),
            thickness: value(&self.thickness, sub_plate),
            orogeny: value(&self.orogeny, sub_plate),
            orogeny_age: value(&self.orogeny_age, sub_plate),
            sub_plate,
        }
    }

    /// Everything about the place at a latitude and longitude in degrees, as [`direction_of`] takes them.
    #[must_use]
    pub fn at_lat_lon(&self, latitude_deg: f64, longitude_deg: f64) -> Place {
        self.at(direction_of(latitude_deg, longitude_deg))
    }

    /// The sub-plate nearest to a direction.
    #[must_use]
    pub fn nearest(&self, direction: DVec3) -> u32 {
        let direction = unit(direction);
        self.mesh.nearest(direction, self.start(direction))
    }

    /// Upward unit normal of the ground as it is drawn. Continuous: slopes are interpolated between
    /// sub-plates, so it is the normal of smoothly shaded ground rather than of flat triangles.
    #[must_use]
    pub fn normal(&self, direction: DVec3, relief: impl Into<Relief>) -> DVec3 {
        let direction = unit(direction);
        let location = self.mesh.locate(direction, self.start(direction));
        self.normal_at(direction, &location, relief.into())
    }

    /// The point of the ground in a direction as it is drawn, in radii of the planet from its centre.
    #[must_use]
    pub fn point(&self, direction: DVec3, relief: impl Into<Relief>) -> DVec3 {
        let (direction, relief) = (unit(direction), relief.into());
        let location = self.mesh.locate(direction, self.start(direction));
        let height = relief.height(self.elevation_at(&location));
        direction * (1.0 + relief.scale(self.radius_km) * height)
    }

    /// Works out at once what queries would work out when first asked, so that none of them stalls a
    /// frame: call it where the surface was captured, in the background.
    pub fn prepare(&self) {
        let _ = self.start(DVec3::Z);
        let _ = self.slopes();
        let _ = self.elevation_range();
        let _ = self.plates();
        let _ = self.nearest_boundary(DVec3::Z);
    }

    fn elevation_at(&self, location: &Location) -> f64 {
        let heights = location
            .vertices
            .map(|v| f64::from(value(&self.elevation, v)));
        let [a, b, c] = heights;
        let [_, v, w] = location.weights;
        a + v * (b - a) + w * (c - a)
    }

    fn normal_at(&self, direction: DVec3, location: &Location, relief: Relief) -> DVec3 {
        let elevation = self.elevation_at(location);
        if relief.sea && elevation <= 0.0 {
            return direction;
        }
        let slopes = self.slopes();
        let mut slope = DVec3::ZERO;
        for (vertex, weight) in location.vertices.into_iter().zip(location.weights) {
            slope += value(slopes, vertex).as_dvec3() * weight;
        }
        let slope = slope - direction * direction.dot(slope);
        let scale = relief.scale(self.radius_km);
        let up = direction * (1.0 + scale * elevation);
        (up - slope * scale).normalize_or(direction)
    }

    /// Slope per vertex, tangent and uphill, in m per radian: the mean over the triangles around it,
    /// weighted by their areas.
    fn slopes(&self) -> &[Vec3] {
        self.kept.slopes.get_or_init(|| {
            let vertices = 0..self.mesh.vertex_count() as u32;
            vertices.map(|v| self.slope(v).as_vec3()).collect()
        })
    }

    fn slope(&self, v: u32) -> DVec3 {
        let mesh = &self.mesh;
        let height = |w: u32| f64::from(value(&self.elevation, w) - value(&self.elevation, v));
        let site = mesh.site(v);
        let (mut slope, mut area) = (DVec3::ZERO, 0.0);
        for h in mesh.outgoing(v) {
            let (p, q) = (mesh.dest(h), mesh.apex(h));
            let (b, c) = (mesh.site(p) - site, mesh.site(q) - site);
            let normal = b.cross(c);
            // Twice the area times the slope of the plane through three heights, the first of them 0.
            slope += normal
                .normalize_or_zero()
                .cross(b * height(q) - c * height(p));
            area += normal.length();
        }
        if area > 0.0 {
            let slope = slope / area;
            slope - site * site.dot(slope)
        } else {
            DVec3::ZERO
        }
    }

    /// Lowest and highest elevation in m.
    pub(super) fn elevation_range(&self) -> [f64; 2] {
        *self.kept.range.get_or_init(|| {
            let finite = self
                .elevation
                .iter()
                .filter(|elevation| elevation.is_finite());
            finite
                .map(|&elevation| [f64::from(elevation); 2])
                .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
                .unwrap_or_default()
        })
    }
}

/// The corner with the largest weight.
fn foremost(location: &Location) -> u32 {
    let [u, v, w] = location.weights;
    let corner = if u >= v && u >= w {
        0
    } else if v >= w {
        1
    } else {
        2
    };
    location.vertices[corner]
}

/// The value of a sub-plate; nothing where a changed column is too short.
pub(super) fn value<T: Copy + Default>(column: &[T], vertex: u32) -> T {
    column.get(vertex as usize).copied().unwrap_or_default()
}
