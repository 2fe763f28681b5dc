//! Places worth a look, by what a history did there.

use super::{coordinates::east_north, query::value};
use crate::simulation::{BoundaryKind, Crust, Orogeny, Surface, surface::BoundarySegment};
use glam::DVec3;
use std::collections::BTreeMap;

/// What makes a place worth a look.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Landmark {
    /// The highest ground of ranges that continents have raised within the last 50 My.
    HighestRange,
    /// The highest continental ground of ranges over a trench that is active.
    Cordillera,
    /// The ground, still a kilometre high or else half a kilometre, that nothing has raised for longest.
    OldestRange,
    /// The highest land over an active trench on crust that is oceanic or younger than 300 My.
    IslandArc,
    /// The middle of the longest ridge between two plates.
    LongestRidge,
    /// The middle of the longest line along which a continent is torn.
    Rift,
    /// The coast farthest from all boundaries of plates.
    PassiveMargin,
    /// The coast whose hinterland is lowest.
    FlatCoast,
    /// The highest island that a hot spot has fed within the last 10 My.
    VolcanicIsland,
    /// The deepest trench.
    Trench,
}

impl Landmark {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::HighestRange,
        Self::Cordillera,
        Self::OldestRange,
        Self::IslandArc,
        Self::LongestRidge,
        Self::Rift,
        Self::PassiveMargin,
        Self::FlatCoast,
        Self::VolcanicIsland,
        Self::Trench,
    ];

    /// What it is called.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::HighestRange => "highest range",
            Self::Cordillera => "cordillera",
            Self::OldestRange => "oldest range",
            Self::IslandArc => "island arc",
            Self::LongestRidge => "longest ridge",
            Self::Rift => "rift",
            Self::PassiveMargin => "passive margin",
            Self::FlatCoast => "flat coast",
            Self::VolcanicIsland => "volcanic island",
            Self::Trench => "deepest trench",
        }
    }
}

/// A range that has been raised within this time in My is young.
const YOUNG: f32 = 50.0;
/// A range that nothing has raised for this long is old.
const OLD: f32 = 100.0;
/// An arc that was fed within this time is active.
const ACTIVE: f32 = 6.0;
/// A hot spot that has fed an island within this time still does.
const FED: f32 = 10.0;
/// Crust of arcs that is no older than this is not yet a continent.
const NEW_LAND: f32 = 300.0;

impl Surface {
    /// Where the planet has such a place, and a unit tangent across it: across the range, the ridge or the
    /// rift, from the land to the sea. None where the planet has no such place.
    ///
    /// Places are those of sub-plates or boundaries: the very summit may lie up to a spacing away.
    ///
    /// ```
    /// use bevy_tectonics::{prelude::*, surface::{Landmark, lat_lon}};
    ///
    /// let surface = History::new(Recipe::earth_like(7).with_sub_plates(500))?.surface()?;
    /// for landmark in Landmark::ALL {
    ///     if let Some((place, _)) = surface.landmark(landmark) {
    ///         let (latitude, longitude) = lat_lon(place);
    ///         println!("{}: {latitude:.1}°, {longitude:.1}°", landmark.name());
    ///     }
    /// }
    /// # Ok::<(), TectonicError>(())
    /// ```
    #[must_use]
    pub fn landmark(&self, landmark: Landmark) -> Option<(DVec3, DVec3)> {
        let height = |v: u32| value(&self.elevation, v);
        match landmark {
            Landmark::HighestRange => self.range(Orogeny::Himalayan, YOUNG, |_| true),
            Landmark::Cordillera => self.range(Orogeny::Andean, ACTIVE, |v| !self.is_new(v)),
            Landmark::OldestRange => [1000.0, 500.0].into_iter().find_map(|least| {
                let is = |v: u32| self.raised(v).is_some_and(|age| age >= OLD) && height(v) > least;
                let oldest = self.best(is, |v| value(&self.orogeny_age, v))?;
                Some((self.mesh.site(oldest), self.across_folds(oldest)))
            }),
            Landmark::IslandArc => self.range(Orogeny::Andean, ACTIVE, |v| self.is_new(v)),
            Landmark::LongestRidge => self.longest(|segment| {
                let kinds = segment.sub_plates.map(|v| value(&self.crust, v));
                segment.kind == BoundaryKind::Ridge && kinds == [Crust::Oceanic; 2]
            }),
            Landmark::Rift => self.longest(|segment| {
                let kinds = segment.sub_plates.map(|v| value(&self.crust, v));
                segment.kind == BoundaryKind::Ridge && kinds == [Crust::Continental; 2]
            }),
            Landmark::PassiveMargin => {
                let is = |v: u32| value(&self.crust, v) == Crust::Continental;
                let quiet = |v: u32| {
                    let near = self.nearest_boundary(self.mesh.site(v));
                    near.map_or(f64::INFINITY, |near| near.distance_km) as f32
                };
                self.coast(is, quiet)
            }
            Landmark::FlatCoast => {
                let is = |v: u32| value(&self.crust, v) == Crust::Continental;
                let highest_near = |v: u32| {
                    let land = self.mesh.neighbours(v).map(height);
                    land.fold(height(v), f32::max)
                };
                self.coast(is, |v| -highest_near(v))
            }
            Landmark::VolcanicIsland => {
                let is = |v: u32| {
                    value(&self.crust, v) == Crust::Oceanic
                        && value(&self.volcanism_age, v).is_some_and(|age| age < FED)
                        && height(v) > 0.0
                };
                let best = self.best(is, height)?;
                Some((self.mesh.site(best), self.ahead(best)))
            }
            Landmark::Trench => {
                let trenches = self.boundaries().iter();
                let trenches = trenches.filter(|segment| segment.kind.is_subducting());
                let floor = |segment: &BoundarySegment| {
                    let first = segment.kind == BoundaryKind::SubductingOrigin;
                    segment.sub_plates[usize::from(!first)]
                };
                let deepest = trenches.min_by(|a, b| height(floor(a)).total_cmp(&height(floor(b))));
                let deepest = deepest.filter(|segment| height(floor(segment)) < 0.0)?;
                let place = self.mesh.site(floor(deepest));
                Some((place, tangent(across(deepest), place)))
            }
        }
    }

    /// The sub-plate of a kind that has the most of something; the first of equals.
    fn best(&self, is: impl Fn(u32) -> bool, most: impl Fn(u32) -> f32) -> Option<u32> {
        first_most(
            (0..self.mesh.vertex_count() as u32).filter(|&v| is(v)),
            most,
        )
    }

    /// Time since a sub-plate was last raised in My, if it ever was.
    fn raised(&self, v: u32) -> Option<f32> {
        (value(&self.orogeny, v) != Orogeny::None).then(|| value(&self.orogeny_age, v))
    }

    /// Whether crust is not yet a continent's.
    fn is_new(&self, v: u32) -> bool {
        value(&self.crust, v) == Crust::Oceanic || value(&self.age, v) < NEW_LAND
    }

    /// The highest ground of a kind that was raised in such a way within so many My.
    fn range(
        &self,
        kind: Orogeny,
        age: f32,
        is_such: impl Fn(u32) -> bool,
    ) -> Option<(DVec3, DVec3)> {
        let is = |v: u32| {
            value(&self.orogeny, v) == kind
                && is_such(v)
                && value(&self.orogeny_age, v) < age
                && value(&self.elevation, v) > 0.0
        };
        let best = self.best(is, |v| value(&self.elevation, v))?;
        Some((self.mesh.site(best), self.across_folds(best)))
    }

    /// The coast of a kind that has the most of something, and the way to the sea.
    fn coast(&self, is: impl Fn(u32) -> bool, most: impl Fn(u32) -> f32) -> Option<(DVec3, DVec3)> {
        let best = first_most(self.coasts().filter(|&v| is(v)), most)?;
        let place = self.mesh.site(best);
        let wet = self.mesh.neighbours(best);
        let wet = wet.filter(|&w| value(&self.elevation, w) <= 0.0);
        let sea: DVec3 = wet.map(|w| self.mesh.site(w) - place).sum();
        Some((place, tangent(sea, place)))
    }

    /// The middle of the longest boundary of a kind between two plates, and the way across.
    fn longest(&self, is: impl Fn(&BoundarySegment) -> bool) -> Option<(DVec3, DVec3)> {
        let mut of: BTreeMap<[u16; 2], Vec<&BoundarySegment>> = BTreeMap::new();
        for segment in self.boundaries().iter().filter(|segment| is(segment)) {
            of.entry(segment.plates).or_default().push(segment);
        }
        let length = |run: &[&BoundarySegment]| run.iter().map(|s| s.length_km).sum::<f64>();
        let longest = of.into_values().reduce(|best, next| {
            if length(&next) > length(&best) {
                next
            } else {
                best
            }
        })?;
        let middle: DVec3 = longest.iter().map(|s| s.point(0.5) * s.length_km).sum();
        let nearest = longest.into_iter().min_by(|a, b| {
            let far =
                |s: &BoundarySegment| s.point(0.5).distance_squared(middle.normalize_or_zero());
            far(a).total_cmp(&far(b))
        })?;
        Some((nearest.point(0.5), across(nearest)))
    }

    /// The way across the folds of a sub-plate; of its motion where there are none.
    fn across_folds(&self, v: u32) -> DVec3 {
        let fold = value(&self.fold, v).as_dvec3();
        if fold.length_squared() > 1e-12 {
            tangent(fold, self.mesh.site(v))
        } else {
            self.ahead(v)
        }
    }

    /// The way that a sub-plate moves.
    fn ahead(&self, v: u32) -> DVec3 {
        tangent(value(&self.velocity, v).as_dvec3(), self.mesh.site(v))
    }
}

/// The sub-plate that has the most of something; the first of equals.
fn first_most(found: impl Iterator<Item = u32>, most: impl Fn(u32) -> f32) -> Option<u32> {
    let found = found.map(|v| (v, most(v)));
    let (best, _) = found.reduce(|best, next| if next.1 > best.1 { next } else { best })?;
    Some(best)
}

/// The way across a piece of a boundary.
fn across(segment: &BoundarySegment) -> DVec3 {
    let along = segment.ends[1] - segment.ends[0];
    let middle = segment.point(0.5);
    tangent(along.cross(middle), middle)
}

/// The unit tangent at a place that is nearest to a vector; east where there is none.
fn tangent(vector: DVec3, place: DVec3) -> DVec3 {
    let flat = vector - place * place.dot(vector);
    flat.normalize_or(east_north(place).0)
}
