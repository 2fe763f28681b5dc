//! Boundaries between plates as lines, and the one nearest to a place.

use super::coordinates::unit;
use super::query::value;
use crate::simulation::{
    BoundaryKind, Surface,
    surface::{Ball, BoundarySegment, SegmentTree},
};
use glam::DVec3;

/// Segments in a leaf of the tree.
const LEAF: usize = 4;

/// The boundary nearest to a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearBoundary {
    /// Distance along the surface in km.
    pub distance_km: f64,
    /// The nearest point of the boundary, a unit vector.
    pub point: DVec3,
    /// The piece of the boundary that has this point: its plates, what they do, how fast.
    pub segment: BoundarySegment,
    /// Its number among [`Surface::boundaries`].
    pub number: usize,
}

impl Surface {
    /// All boundaries between plates, in pieces as long as a side of a sub-plate. They part the places
    /// whose [`at`](Self::at) lies on different plates. Worked out once.
    ///
    /// Maps bend the same boundaries by noise finer than sub-plates (see [`Raster`](super::Raster)).
    ///
    /// Earthquakes strike where much slips, and deep ones where a plate goes under:
    ///
    /// ```
    /// use bevy_tectonics::prelude::*;
    /// use bevy_tectonics::surface::BoundarySegment;
    /// use core::ops::ControlFlow;
    ///
    /// let mut history = History::new(Recipe::earth_like(7).with_sub_plates(500))?;
    /// history.run_until(2.0, |_| ControlFlow::Continue(()))?;
    /// let surface = history.surface()?;
    ///
    /// // Area of fault that slips in a My, in km²: a fair lottery for earthquakes.
    /// let moment = |fault: &BoundarySegment| f64::from(fault.speed()) * fault.length_km;
    /// let total: f64 = surface.boundaries().iter().map(moment).sum();
    /// let mut ticket = 0.37 * total; // a random share
    /// let fault = surface.boundaries().iter().find(|fault| {
    ///     ticket -= moment(fault);
    ///     ticket <= 0.0
    /// });
    /// if let Some(fault) = fault {
    ///     let epicentre = fault.point(0.5);
    ///     let deep = fault.kind.is_subducting();
    ///     println!("{} earthquake at {epicentre}", if deep { "deep" } else { "shallow" });
    /// }
    /// # Ok::<(), TectonicError>(())
    /// ```
    #[must_use]
    pub fn boundaries(&self) -> &[BoundarySegment] {
        self.kept.segments.get_or_init(|| {
            let edges = self.mesh.edges();
            edges.filter_map(|edge| self.segment(edge)).collect()
        })
    }

    /// The boundary nearest to a direction of any length (north if it is zero or not finite); none on a
    /// planet of one plate.
    #[must_use]
    pub fn nearest_boundary(&self, direction: DVec3) -> Option<NearBoundary> {
        let direction = unit(direction);
        let segments = self.boundaries();
        let tree = self.kept.tree.get_or_init(|| SegmentTree::build(segments));
        let (number, point) = tree.nearest(segments, direction)?;
        let chord = direction.distance(point);
        Some(NearBoundary {
            distance_km: 2.0 * libm::asin((0.5 * chord).min(1.0)) * self.radius_km,
            point,
            segment: *segments.get(number)?,
            number,
        })
    }

    /// The boundary that crosses an edge of the mesh; none within a plate.
    fn segment(&self, edge: u32) -> Option<BoundarySegment> {
        let mesh = &self.mesh;
        let (u, v) = mesh.endpoints(edge);
        let mut sub_plates = [u, v];
        let mut plates = sub_plates.map(|v| value(&self.plate, v));
        if plates[0] == plates[1] {
            return None;
        }
        // On the way from the right triangle to the left one the edge's origin lies to the left.
        let mut ends = [2 * edge + 1, 2 * edge].map(|h| self.corner(h));
        let mut kind = match self.boundary.get(edge as usize) {
            None | Some(BoundaryKind::Joined) => BoundaryKind::Transform,
            Some(&kind) => kind,
        };
        if plates[0] > plates[1] {
            plates.swap(0, 1);
            sub_plates.swap(0, 1);
            ends.swap(0, 1);
            kind = kind.reversed();
        }
        let middle = (ends[0] + ends[1]).normalize_or(ends[0]);
        let [left, right] = plates.map(|plate| self.rotation(plate));
        let slip = (right - left).cross(middle) * self.radius_km;
        let across = (ends[1] - ends[0]).cross(middle).normalize_or_zero();
        let chord = ends[0].distance(ends[1]);
        Some(BoundarySegment {
            ends,
            plates,
            sub_plates,
            kind,
            slip: slip.as_vec3(),
            opening: slip.dot(across) as f32,
            length_km: 2.0 * libm::asin((0.5 * chord).min(1.0)) * self.radius_km,
        })
    }

    /// Circumcentre of a triangle, the same from each of its half-edges.
    fn corner(&self, h: u32) -> DVec3 {
        let mesh = &self.mesh;
        let h = h.min(mesh.next(h)).min(mesh.prev(h));
        let centre = mesh.circumcentre(h);
        if centre.is_finite() {
            return centre;
        }
        let [a, b, c] = mesh.triangle_vertices(h).map(|v| mesh.site(v));
        unit(a + b + c)
    }

    /// Angular velocity of a plate in rad/My; zero for an id that no plate has.
    pub(super) fn rotation(&self, plate: u16) -> DVec3 {
        self.rotations
            .binary_search_by_key(&plate, |&(id, _)| id)
            .ok()
            .and_then(|row| self.rotations.get(row))
            .map_or(DVec3::ZERO, |&(_, rotation)| rotation)
    }
}

impl SegmentTree {
    fn build(segments: &[BoundarySegment]) -> Self {
        let middles: Vec<DVec3> = segments.iter().map(|segment| segment.point(0.5)).collect();
        let mut tree = Self {
            order: (0..segments.len() as u32).collect(),
            balls: Vec::new(),
        };
        if !segments.is_empty() {
            tree.grow(segments, &middles, 0, segments.len());
        }
        tree
    }

    /// Adds the ball of a range of the order, and of its halves.
    fn grow(&mut self, segments: &[BoundarySegment], middles: &[DVec3], from: usize, to: usize) {
        let range = &mut self.order[from..to];
        let (mut low, mut high) = (DVec3::MAX, DVec3::MIN);
        for &segment in range.iter() {
            for end in segments[segment as usize].ends {
                (low, high) = (low.min(end), high.max(end));
            }
        }
        let centre = 0.5 * (low + high);
        let radius = range.iter().fold(0.0_f64, |radius, &segment| {
            let middle = middles[segment as usize];
            // Around its middle, the ends are the farthest of an arc.
            let reach = segments[segment as usize]
                .ends
                .map(|end| end.distance(middle));
            radius.max(centre.distance(middle) + reach[0].max(reach[1]))
        });
        let ball = self.balls.len();
        self.balls.push(Ball {
            centre,
            radius,
            segments: from as u32..to as u32,
            second: 0,
        });
        if to - from <= LEAF {
            return;
        }
        let extent = high - low;
        let axis = extent.max_position();
        let half = (to - from) / 2;
        range.select_nth_unstable_by(half, |&a, &b| {
            let place = |segment: u32| middles[segment as usize][axis];
            place(a).total_cmp(&place(b)).then(a.cmp(&b))
        });
        self.grow(segments, middles, from, from + half);
        self.balls[ball].second = self.balls.len() as u32;
        self.grow(segments, middles, from + half, to);
    }

    /// Number and nearest point of the nearest segment.
    fn nearest(&self, segments: &[BoundarySegment], direction: DVec3) -> Option<(usize, DVec3)> {
        let bound = |ball: usize| {
            let Ball { centre, radius, .. } = &self.balls[ball];
            centre.distance(direction) - radius
        };
        let mut best: Option<(usize, DVec3)> = None;
        let mut shortest = f64::INFINITY;
        // Halving never goes deeper than a number has bits.
        let mut waiting = [(0.0, 0_usize); 40];
        let mut count = usize::from(!self.balls.is_empty());
        while count > 0 {
            count -= 1;
            let (least, ball) = waiting[count];
            if least >= shortest {
                continue;
            }
            let Ball {
                segments: range,
                second,
                ..
            } = &self.balls[ball];
            if *second > 0 {
                let (near, far) = (ball + 1, *second as usize);
                let (near, far) = ((bound(near), near), (bound(far), far));
                let (near, far) = if far.0 < near.0 {
                    (far, near)
                } else {
                    (near, far)
                };
                waiting[count] = far;
                waiting[count + 1] = near;
                count += 2;
                continue;
            }
            for &number in &self.order[range.start as usize..range.end as usize] {
                let number = number as usize;
                let point = closest(segments[number].ends, direction);
                let distance = point.distance(direction);
                if distance < shortest {
                    shortest = distance;
                    best = Some((number, point));
                }
            }
        }
        best
    }
}

/// The point of an arc closest to a direction, all unit vectors.
fn closest([a, b]: [DVec3; 2], direction: DVec3) -> DVec3 {
    let normal = a.cross(b);
    let square = normal.length_squared();
    if square > 0.0 && normal.cross(a).dot(direction) > 0.0 && b.cross(normal).dot(direction) > 0.0
    {
        let foot = direction - normal * (normal.dot(direction) / square);
        return foot.normalize_or(a);
    }
    if a.distance_squared(direction) <= b.distance_squared(direction) {
        a
    } else {
        b
    }
}
