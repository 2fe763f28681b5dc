//! Terrain: what stands on the simulated ground, down to metres.
//!
//! A history knows the ground every 30 to 200 km. [`Terrain`] adds what its causes imply, as Cortial et al. (2019)
//! do: pieces of eroded ground ([`Exemplar`]) of the kind that a place's past calls for, turned to the
//! fold, on land; ripples along the ridge that made it ([`floor`]) on the sea floor; coasts that stay ragged
//! however closely one looks ([`shore`]).
//!
//! Pieces lie scattered over the sphere ([`scatter`]), each with the kind and the direction of its own place
//! ([`patch`]); how high they stand is the business of the place where one looks ([`strength`]). Pieces are much
//! wider than what they resolve, so smaller ones follow, 64 times as fine, on the slopes of the larger.

mod exemplar;
mod floor;
mod patch;
#[cfg(feature = "render")]
mod plot;
mod scatter;
mod shore;
mod strength;
mod survey;

use super::{
    HeightField, SurfaceError,
    query::value,
    raster::{Base, Raster},
};
use crate::simulation::Surface;
use bevy::prelude::*;
use exemplar::Level;
pub use exemplar::{Exemplar, ExemplarError, Exemplars, Landform};
use glam::{DVec3, Vec3};
use patch::{Patch, describe};
#[cfg(feature = "render")]
pub(crate) use plot::{TooWide, Words, vectors, weights};
use scatter::{Around, Lately, Reached, Scatter};
use shore::Shore;
use std::sync::Arc;
use strength::Strength;
pub use survey::Survey;

/// Distance between pieces of ground in m: two fit into an exemplar, so that none is seen twice by one place.
const PIECE_M: f64 = 18_000.0;
/// How much smaller the pieces are that stand on the slopes of the first.
const FINER: f64 = 64.0;
/// Metres that a place gains by the smaller pieces, on flat ground and on a slope of 45°: hillslopes are smooth,
/// rock faces and gullies are not.
const GRAIN_M: (f32, f32) = (0.25, 7.0);
/// Finest detail in m.
const FINEST_M: f64 = 1.0;
/// Ground finer than this distance in m is not felt when slopes of the history's own ground are taken.
const SLOPE_STEP_M: f64 = 400.0;

/// Terrain at one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TerrainSample {
    /// Elevation in m above the sea.
    pub elevation: f32,
    /// Upward unit normal of the ground, true to scale.
    pub normal: DVec3,
    /// What finer detail can add or take at most, in m, on ground more than 250 m above or below the sea. Closer to
    /// its level finer detail also moves the ground sideways, by up to [`Terrain::shore_error_m`].
    pub error: f32,
}

/// A planet's ground at one level of detail: the same place has the same height, whoever asks in which order and
/// on which thread. `GpuTerrain` (feature `render`) has the elevations of many places at once, equal to 0.1 m.
///
/// ```
/// use bevy_tectonics::prelude::*;
/// use bevy_tectonics::surface::{Terrain, direction_of};
///
/// let surface = History::new(Recipe::earth_like(7).with_sub_plates(500))?.surface()?;
/// let mut terrain = Terrain::new(&surface, 100.0)?;
/// let place = terrain.sample(direction_of(47.0, 8.5));
/// assert!(place.elevation.is_finite());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Terrain<'a> {
    raster: Raster<'a>,
    surface: &'a Surface,
    exemplars: Arc<Exemplars>,
    shore: Shore,
    pieces: Scatter,
    grains: Option<(Scatter, Level)>,
    level: Level,
    /// Wavelengths of the sea floor shorter than this, in m, are left out.
    detail_m: f64,
    hint: u32,
    last: DVec3,
    /// Square of the distance within which a hint is good.
    near: f64,
    patches: Lately<Patch>,
    /// Axes of the smaller pieces.
    axes: Lately<[Vec3; 2]>,
    /// The pieces around the last place, and the smaller ones.
    around: [Around; 2],
}

impl Surface {
    /// The ground in a direction with all that is larger than `detail_m` metres: [`Terrain::sample`] for those who
    /// ask once. The north pole stands for directions that are zero or not finite.
    ///
    /// # Errors
    /// [`SurfaceError`] when a column does not have one value per sub-plate.
    pub fn sample(&self, direction: DVec3, detail_m: f64) -> Result<TerrainSample, SurfaceError> {
        Ok(Terrain::new(self, detail_m)?.sample(direction))
    }
}

impl<'a> Terrain<'a> {
    /// Prepares to sample a surface with all that is larger than `detail_m` metres, best the distance between
    /// samples. Less than 1 counts as 1, what is not a number too. Cheap: exemplars are read once.
    ///
    /// # Errors
    /// [`SurfaceError`] when a column does not have one value per sub-plate.
    pub fn new(surface: &'a Surface, detail_m: f64) -> Result<Self, SurfaceError> {
        Self::with_exemplars(surface, detail_m, Exemplars::shipped())
    }

    /// The same, with ground of one's own.
    ///
    /// # Errors
    /// [`SurfaceError`] when a column does not have one value per sub-plate.
    pub fn with_exemplars(
        surface: &'a Surface,
        detail_m: f64,
        exemplars: Arc<Exemplars>,
    ) -> Result<Self, SurfaceError> {
        let raster = Raster::new(surface)?;
        let columns = [
            ("fold", surface.fold.len()),
            ("ridge", surface.ridge.len()),
            ("thickness", surface.thickness.len()),
            ("volcanism age", surface.volcanism_age.len()),
        ];
        let expected = surface.mesh.vertex_count();
        if let Some((field, found)) = columns.into_iter().find(|(_, found)| *found != expected) {
            return Err(SurfaceError {
                field,
                found,
                expected,
            });
        }
        let detail_m = detail_m.max(FINEST_M);
        let near = surface.spacing_km() / surface.radius_km;
        let grain = Level::of(detail_m * FINER);
        Ok(Self {
            shore: Shore::new(surface, detail_m),
            pieces: Scatter::new(surface.seed, PIECE_M),
            grains: grain
                .is_any()
                .then(|| (Scatter::new(surface.seed ^ 1, PIECE_M / FINER), grain)),
            level: Level::of(detail_m),
            hint: 0,
            last: DVec3::ZERO,
            near: near * near,
            patches: Lately::new(),
            axes: Lately::new(),
            around: default(),
            raster,
            surface,
            exemplars,
            detail_m,
        })
    }

    /// How far finer detail can move the shore, and all ground within 250 m of the sea's level, in m.
    #[must_use]
    pub fn shore_error_m(&self) -> f64 {
        self.shore.error_m()
    }

    /// Elevation in m above the sea, in a direction of any length. The north pole stands for those that are zero
    /// or not finite.
    #[must_use]
    pub fn elevation(&mut self, direction: DVec3) -> f32 {
        let direction = super::coordinates::unit(direction);
        let base = self.base(direction);
        self.raise(direction, base).0
    }

    /// The ground in a direction. Costs about three times as much as its elevation alone.
    #[must_use]
    pub fn sample(&mut self, direction: DVec3) -> TerrainSample {
        let up = super::coordinates::unit(direction);
        let base = self.base(up);
        let (elevation, slope, error) = self.raise(up, base);
        let (east, north) = super::coordinates::east_north(up);
        // The history's own ground has no slope in closed form.
        let radius_m = 1000.0 * self.surface.radius_km;
        let step = SLOPE_STEP_M.max(self.detail_m) / radius_m;
        let mut along = |axis: DVec3| {
            let ahead = self.base((up + axis * step).normalize()).elevation;
            f64::from(ahead - base.elevation) / (step * radius_m)
        };
        let broad = east * along(east) + north * along(north);
        let slope = slope.as_dvec3() + broad;
        let slope = slope - up * up.dot(slope);
        TerrainSample {
            elevation,
            normal: (up - slope).normalize_or(up),
            error,
        }
    }

    /// Heights on a square of the tangent plane, as [`Surface::patch`] has them of smooth ground: for colliders.
    /// Best with samples as far apart as the detail of this terrain. The example `land_here` walks on one.
    ///
    /// ```
    /// use bevy_tectonics::prelude::*;
    /// use bevy_tectonics::surface::{Terrain, direction_of};
    ///
    /// let surface = History::new(Recipe::earth_like(7).with_sub_plates(500))?.surface()?;
    /// // 256 m around a player, a sample every 2 m.
    /// let patch = Terrain::new(&surface, 2.0)?.patch(direction_of(47.0, 8.5), 0.256, 129);
    /// let (vertices, triangles) = (patch.positions(), patch.triangles());
    /// assert_eq!((vertices.len(), triangles.len()), (129 * 129, 2 * 128 * 128));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn patch(&mut self, centre: DVec3, size_km: f64, samples: usize) -> HeightField {
        HeightField::over(
            self.surface.radius_km,
            centre,
            size_km,
            samples,
            |direction| self.elevation(direction),
        )
    }

    /// The history's ground as maps show it, with coasts ragged down to the detail asked for.
    fn base(&mut self, direction: DVec3) -> Base {
        // Places that follow each other closely start where the last one ended.
        if self.last.distance_squared(direction) > self.near {
            self.hint = self.surface.start(direction);
        }
        self.last = direction;
        let base = self.raster.base(direction, &mut self.hint);
        match self.shore.displace(direction, base.elevation) {
            Some(displaced) => self.raster.base(displaced, &mut self.hint),
            None => base,
        }
    }

    /// Elevation with terrain on it, the slope of the terrain (m per m, in the planet's frame), and what finer
    /// detail can change.
    fn raise(&mut self, direction: DVec3, base: Base) -> (f32, Vec3, f32) {
        let place = direction * (1000.0 * self.surface.radius_km);
        let strength = Strength::at(&base);
        let broad = self.pile(place, strength.deviation_m);
        let (mut added, mut slope) = (broad.height, broad.slope);
        let mut error = strength.deviation_m * broad.error;
        // The smaller pieces cannot stand higher than the sea is deep or the land is high, either.
        let up = direction.as_vec3();
        let steep = (slope - up * up.dot(slope)).length().min(1.0);
        let most = strength.grain_m(GRAIN_M.0 + (GRAIN_M.1 - GRAIN_M.0) * steep);
        match &self.grains {
            Some((scatter, level)) => {
                let tile = self.exemplars.get(Landform::Collision);
                let (around, axes) = (&mut self.around[1], &mut self.axes);
                let fine = grain(scatter, around, axes, tile, *level, place);
                let (value, rate) = soften(fine.value);
                added += most * value;
                slope += fine.slope * (most * rate);
                error += most * fine.error;
                if self.level != Level::of(0.0) {
                    // Slopes that are not shown yet carry higher pieces.
                    error += (strength.grain_m(GRAIN_M.1) - most) * SOFTEST;
                }
            }
            None => error += strength.grain_m(GRAIN_M.1) * SOFTEST,
        }
        (base.elevation + added, slope, error)
    }

    /// The larger pieces at a place, with this standard deviation in m.
    fn pile(&mut self, place: DVec3, deviation_m: f32) -> Pile {
        let mut sum = Sum::default();
        let (detail_m, level, hint) = (self.detail_m as f32, self.level, self.hint);
        self.pieces.visit(&mut self.around[0], place, |piece| {
            let describe = || describe(piece, &self.pieces, self.surface, &self.raster, hint);
            let patch = self.patches.of(piece, describe);
            let (value, slope, error) = patch.at(piece.offset, &self.exemplars, level, detail_m);
            sum.add(piece, value, slope, error);
        });
        let sum = sum.finish();
        let (value, rate) = soften(sum.value);
        Pile {
            height: deviation_m * value,
            slope: sum.slope * (deviation_m * rate),
            error: sum.error,
        }
    }
}

/// The smaller pieces at a place: any ground will do, and any direction.
fn grain(
    scatter: &Scatter,
    around: &mut Around,
    axes: &mut Lately<[Vec3; 2]>,
    tile: &Exemplar,
    level: Level,
    place: DVec3,
) -> Blended {
    let mut sum = Sum::default();
    scatter.visit(around, place, |piece| {
        // Axes of the piece, not of the place: none are the same everywhere.
        let [along, across] = axes.of(piece, || {
            let up = scatter.middle(piece).normalize_or(DVec3::Z).as_vec3();
            piece.turned(up.any_orthonormal_pair().into())
        });
        let shift = piece.shift();
        let texel = exemplar::TEXEL_M / FINER as f32;
        let at = [
            piece.offset.dot(along) / texel + shift[0],
            piece.offset.dot(across) / texel + shift[1],
        ];
        let (value, [x, y]) = tile.at(at, level);
        let slope = (along * x + across * y) / texel;
        sum.add(piece, value, slope, tile.error(level));
    });
    sum.finish()
}

struct Pile {
    height: f32,
    slope: Vec3,
    error: f32,
}

/// Pieces that overlap, weighted so that their sum varies as much as each of them (Heitz & Neyret 2018).
#[derive(Default)]
struct Sum {
    value: f32,
    slope: Vec3,
    error: f32,
    squares: f32,
    squares_slope: Vec3,
}

struct Blended {
    value: f32,
    slope: Vec3,
    error: f32,
}

impl Sum {
    fn add(&mut self, piece: &Reached, value: f32, slope: Vec3, error: f32) {
        let weight = piece.weight;
        self.value += weight * value;
        self.slope += slope * weight + piece.weight_slope * value;
        self.error += weight * error;
        self.squares += weight * weight;
        self.squares_slope += piece.weight_slope * (2.0 * weight);
    }

    fn finish(self) -> Blended {
        // Where nothing reaches, nothing stands.
        let squares = self.squares + 1e-4;
        let scale = squares.sqrt().recip();
        Blended {
            value: self.value * scale,
            slope: (self.slope - self.squares_slope * (0.5 * self.value / squares)) * scale,
            error: self.error * scale,
        }
    }
}

/// Bound of what [`soften`] returns.
const SOFTEST: f32 = 4.0;

/// A value that never passes four deviations, and its rate of change.
fn soften(value: f32) -> (f32, f32) {
    let square = 1.0 + (value / SOFTEST) * (value / SOFTEST);
    let root = square.sqrt();
    (value / root, 1.0 / (square * root))
}
