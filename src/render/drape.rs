//! Flat shapes laid over the ground of a planet: meshes of strips whose every corner lies on it.

use crate::planet::{PlanetView, to_scene};
use crate::simulation::Surface;
use crate::surface::raster::Hints;
use crate::surface::{Raster, SurfaceError};
use bevy::asset::RenderAssetUsages;
use bevy::color::{Color, ColorToComponents};
use bevy::math::DVec3;
use bevy::mesh::{Indices, Mesh, PrimitiveTopology};

/// Longest side of a piece of a strip, in radii: how closely shapes follow the relief.
pub(super) const STEP: f64 = 0.008;
/// Height above the ground in radii. Between its corners a shape may cut through a summit.
const LIFT: f64 = 0.002;
/// No exaggeration turns the planet inside out.
const DEEPEST: f64 = 0.1;

/// How the ground is drawn, as far as what lies on it must know.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Heights {
    exaggeration: f32,
    /// Level of the drawn sea in m.
    sea_m: Option<f32>,
}

impl From<&PlanetView> for Heights {
    fn from(view: &PlanetView) -> Self {
        let finite = |value: f32, other| if value.is_finite() { value } else { other };
        Self {
            exaggeration: finite(view.exaggeration, 1.0).clamp(0.0, 200.0),
            sea_m: view.sea.then_some(finite(view.sea_level_m, 0.0)),
        }
    }
}

/// A colour and how high above the ground it lies.
#[derive(Debug, Clone, Copy)]
pub(super) struct Paint {
    color: [f32; 4],
    lift: f64,
}

impl Paint {
    pub(super) fn new([red, green, blue]: [u8; 3]) -> Self {
        Self {
            color: Color::srgb_u8(red, green, blue).to_linear().to_f32_array(),
            lift: LIFT,
        }
    }

    /// The same on top of others.
    pub(super) fn above(self, lift: f64) -> Self {
        Self {
            lift: self.lift + lift,
            ..self
        }
    }
}

/// A place on the ground with two directions along it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub at: DVec3,
    pub ahead: DVec3,
    pub left: DVec3,
}

impl Frame {
    /// At a unit vector, looking along another vector; none if that points nowhere along the ground.
    pub(super) fn new(at: DVec3, towards: DVec3) -> Option<Self> {
        let ahead = (towards - at * at.dot(towards)).try_normalize()?;
        Some(Self {
            at,
            ahead,
            left: at.cross(ahead),
        })
    }

    /// The place so far ahead along a great circle and to the left, in radii.
    pub(super) fn place(&self, [ahead, left]: [f64; 2]) -> DVec3 {
        let (sin, cos) = libm::sincos(ahead);
        (self.at * cos + self.ahead * sin + self.left * left).normalize_or(self.at)
    }
}

/// Half of the outline of a shape that is symmetric about the way ahead: distances ahead and to the
/// left, from back to front; inside and outside of the line around it.
pub(super) type Profile = [([f64; 2], [f64; 2])];

/// A mesh that grows strip by strip.
pub(super) struct Drape<'a> {
    raster: Raster<'a>,
    hints: Hints,
    heights: Heights,
    /// Radii in a metre of elevation.
    scale: f64,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    colors: Vec<[f32; 4]>,
    indices: Vec<u32>,
}

impl<'a> Drape<'a> {
    /// Nothing yet, over the ground of `surface`.
    ///
    /// # Errors
    /// [`SurfaceError`] when a column does not have one value per sub-plate.
    pub(super) fn new(surface: &'a Surface, heights: Heights) -> Result<Self, SurfaceError> {
        Ok(Self {
            raster: Raster::new(surface)?,
            hints: Hints::default(),
            heights,
            scale: f64::from(heights.exaggeration) / (1000.0 * surface.radius_km.max(1.0)),
            positions: Vec::new(),
            normals: Vec::new(),
            colors: Vec::new(),
            indices: Vec::new(),
        })
    }

    /// The ground as it is sampled.
    pub(super) fn raster(&self) -> &Raster<'a> {
        &self.raster
    }

    /// A strip along rows of a left and a right place each, on the way ahead.
    pub(super) fn strip(&mut self, rows: impl IntoIterator<Item = [DVec3; 2]>, paint: Paint) {
        let mut last: Option<[u32; 2]> = None;
        for row in rows {
            let row = row.map(|place| self.vertex(place, paint));
            if let Some([left_back, right_back]) = last {
                let [left, right] = row;
                self.triangle([right_back, right, left]);
                self.triangle([right_back, left, left_back]);
            }
            last = Some(row);
        }
    }

    /// A shape with a line around it, open at its back unless `closed`.
    pub(super) fn figure(
        &mut self,
        frame: &Frame,
        profile: &Profile,
        closed: bool,
        fill: Paint,
        outline: Paint,
    ) {
        let mirror = |[ahead, left]: [f64; 2]| [ahead, -left];
        let points = divide(profile);
        let place = |point| frame.place(point);
        // Where the outline runs straight to the side, as at barbs, the filling begins anew.
        let fills = points.chunk_by(|(inside, _), (next, _)| next[0] > inside[0]);
        for rows in fills {
            let row = |&(inside, _): &_| [place(inside), place(mirror(inside))];
            self.strip(rows.iter().map(row), fill);
        }
        let rows = points.iter();
        self.strip(
            rows.clone()
                .map(|&(inside, outside)| [place(outside), place(inside)]),
            outline,
        );
        self.strip(
            rows.map(|&(inside, outside)| [place(mirror(inside)), place(mirror(outside))]),
            outline,
        );
        if let (true, Some(&(inside, outside))) = (closed, profile.first()) {
            let back = [outside, inside].map(|point| [place(point), place(mirror(point))]);
            self.strip(back, outline);
        }
    }

    /// The mesh, in the space of the planet's `Transform` for a radius of 1; none if nothing was laid.
    pub(super) fn finish(self) -> Option<Mesh> {
        if self.indices.is_empty() {
            return None;
        }
        let mesh = Mesh::new(
            PrimitiveTopology::TriangleList,
            RenderAssetUsages::RENDER_WORLD,
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, self.positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, self.normals)
        .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, self.colors)
        .with_inserted_indices(Indices::U32(self.indices));
        Some(mesh)
    }

    fn vertex(&mut self, direction: DVec3, paint: Paint) -> u32 {
        let ground = self.raster.look(direction, &mut self.hints).elevation;
        let height = match self.heights.sea_m {
            Some(sea) if ground < sea => sea,
            _ if ground.is_finite() => ground,
            _ => 0.0,
        };
        let radius = (1.0 + self.scale * f64::from(height)).max(DEEPEST) + paint.lift;
        let number = self.positions.len() as u32;
        self.positions.push(to_scene(direction * radius).to_array());
        self.normals.push(to_scene(direction).to_array());
        self.colors.push(paint.color);
        number
    }

    /// Leaves out what has no area, at the tips of shapes.
    fn triangle(&mut self, corners: [u32; 3]) {
        let [a, b, c] = corners.map(|corner| self.positions[corner as usize]);
        if a != b && b != c && c != a {
            self.indices.extend(corners);
        }
    }
}

/// Adds points to a profile wherever two are further apart than a step.
fn divide(profile: &Profile) -> Vec<([f64; 2], [f64; 2])> {
    let mix = |a: [f64; 2], b: [f64; 2], share: f64| {
        [0, 1].map(|axis| a[axis] + (b[axis] - a[axis]) * share)
    };
    let mut points: Vec<_> = profile.first().copied().into_iter().collect();
    for pair in profile.windows(2) {
        let [(from, from_outside), (to, to_outside)] = [pair[0], pair[1]];
        let length = libm::hypot(to[0] - from[0], to[1] - from[1]);
        let count = (length / STEP).ceil().max(1.0);
        points.extend((1..=count as usize).map(|i| {
            let share = i as f64 / count;
            (mix(from, to, share), mix(from_outside, to_outside, share))
        }));
    }
    points
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::simulation::{History, Recipe};
    use bevy::math::Vec3;

    pub(in crate::render) fn surface() -> Surface {
        let mut history = History::new(Recipe::earth_like(7).with_sub_plates(600)).unwrap();
        history
            .run_until(4.0, |_| core::ops::ControlFlow::Continue(()))
            .unwrap();
        history.surface().unwrap()
    }

    pub(in crate::render) fn flat() -> Heights {
        Heights {
            exaggeration: 0.0,
            sea_m: Some(0.0),
        }
    }

    pub(in crate::render) fn positions(mesh: &Mesh) -> Vec<Vec3> {
        let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).unwrap();
        let positions = positions.as_float3().unwrap();
        positions.iter().map(|&p| Vec3::from_array(p)).collect()
    }

    pub(in crate::render) fn colors(mesh: &Mesh) -> Vec<[f32; 4]> {
        match mesh.attribute(Mesh::ATTRIBUTE_COLOR).unwrap() {
            bevy::mesh::VertexAttributeValues::Float32x4(colors) => colors.clone(),
            other => panic!("{other:?}"),
        }
    }

    pub(in crate::render) fn triangles(mesh: &Mesh) -> Vec<[usize; 3]> {
        let indices: Vec<usize> = mesh.indices().unwrap().iter().collect();
        indices.as_chunks().0.to_vec()
    }

    /// Finite, near the ground, all corners used in range, (nearly) everything seen from outside.
    pub(in crate::render) fn assert_sound(mesh: &Mesh) {
        let positions = positions(mesh);
        assert!(positions.iter().all(|p| (0.9..1.1).contains(&p.length())));
        let triangles = triangles(mesh);
        assert!(!triangles.is_empty());
        let outwards = triangles.iter().filter(|corners| {
            let [a, b, c] = corners.map(|corner| positions[corner]);
            (b - a).cross(c - a).dot(a) > 0.0
        });
        let share = outwards.count() as f32 / triangles.len() as f32;
        assert!(share > 0.995, "{share} of the triangles face outwards");
    }

    #[test]
    fn figures_are_closed_and_symmetric() {
        let surface = surface();
        let mut drape = Drape::new(&surface, flat()).unwrap();
        let frame = Frame::new(DVec3::X, DVec3::Y).unwrap();
        let paint = Paint::new([255, 0, 0]);
        let profile = [([0.0, 0.01], [-0.002, 0.012]), ([0.1, 0.0], [0.103, 0.0])];
        drape.figure(&frame, &profile, true, paint, paint);
        let mesh = drape.finish().unwrap();
        assert_sound(&mesh);
        let positions = positions(&mesh);
        let area: f32 = triangles(&mesh)
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(|corner| positions[corner]);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum();
        // The outer triangle has no holes.
        assert!((area - 0.5 * 0.105 * 0.024).abs() < 3e-5, "{area}");
        let lean: f32 = positions.iter().map(|p| p.y).sum();
        assert!(lean.abs() < 1e-3, "{lean}");
    }

    #[test]
    fn views_without_numbers_are_flat() {
        let surface = surface();
        for exaggeration in [f32::NAN, f32::INFINITY, -3.0, 1e9] {
            let view = PlanetView {
                exaggeration,
                sea_level_m: f32::NAN,
                ..PlanetView::default()
            };
            let mut drape = Drape::new(&surface, Heights::from(&view)).unwrap();
            let row = |x: f64| [DVec3::new(x, 1.0, 0.1), DVec3::new(x, 1.0, 0.0)];
            drape.strip(
                [0.0, 0.1].map(row).map(|row| row.map(DVec3::normalize)),
                Paint::new([0; 3]),
            );
            let positions = positions(&drape.finish().unwrap());
            assert!(positions.iter().all(|p| p.is_finite() && p.length() > 0.09));
        }
    }
}
