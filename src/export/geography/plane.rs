//! Lines and regions of the sphere on the plane of longitudes and latitudes, cut at the antimeridian as
//! RFC 7946 (section 3.1.9) asks for.

use crate::surface::lat_lon;
use glam::DVec3;
use std::cmp::Ordering;

/// Longitude and latitude in degrees.
pub(super) type Corner = [f64; 2];
/// An outer ring, counter-clockwise, and the holes in it, clockwise. The first corner comes again as the
/// last.
pub(super) type Polygon = Vec<Vec<Corner>>;

/// Longest step in degrees of longitude: on the plane pieces of great circles are not straight.
const LONGEST_STEP: f64 = 1.0;
/// Halvings of a piece at most; the twentieth part of a piece's millionth is beneath notice.
const HALVINGS: u32 = 20;
/// Decimals of a degree that are kept: a centimetre.
const UNIT: f64 = 1e-7;
/// Distance in radii within which a corner counts as on the antimeridian: six centimetres.
const OFF_BORDER: f64 = 1e-8;

/// A line on the plane, in as many pieces as the antimeridian makes of it.
pub(super) fn lines(points: &[DVec3]) -> Vec<Vec<Corner>> {
    let mut lines = vec![Vec::new()];
    if let Some(&first) = points.first() {
        add(&mut lines, corner(first));
    }
    for pair in points.windows(2) {
        follow(&mut lines, pair[0], pair[1], HALVINGS);
    }
    lines.retain(|line| line.len() > 1);
    lines
}

/// The region to the left of rings, seen from outside. Rings do not cross each other and do not name
/// their first point twice. Without rings it is the whole sphere.
pub(super) fn polygons(rings: &[Vec<DVec3>]) -> Vec<Polygon> {
    let mut arcs: Vec<Vec<Corner>> = Vec::new();
    let mut closed: Vec<Vec<Corner>> = Vec::new();
    for ring in rings {
        let mut round: Vec<DVec3> = ring.iter().copied().map(off_border).collect();
        round.extend(round.first().copied());
        let mut pieces = lines(&round);
        // The ring was begun somewhere in the middle of a piece.
        if pieces.len() > 1
            && let Some(last) = pieces.pop()
        {
            let start = pieces[0].split_off(1);
            pieces[0] = last;
            pieces[0].extend(start);
            arcs.append(&mut pieces);
        } else {
            closed.append(&mut pieces);
        }
    }
    // What is smaller than the unit has no area left.
    closed.retain(|ring| ring.len() > 3 && signed_area(ring) != 0.0);
    // Where no ring meets the border, it lies inside if the widest ring has its inside out.
    let widest = closed.iter().max_by(|a, b| by_area(a, b));
    let holds_border = arcs.is_empty() && widest.is_none_or(|ring| signed_area(ring) < 0.0);
    let mut outers = join(arcs);
    let (islands, holes): (Vec<_>, Vec<_>) =
        closed.into_iter().partition(|ring| signed_area(ring) > 0.0);
    outers.extend(islands);
    if holds_border && (rings.is_empty() || !holes.is_empty()) {
        outers.push(vec![
            [-180.0, -90.0],
            [180.0, -90.0],
            [180.0, 90.0],
            [-180.0, 90.0],
            [-180.0, -90.0],
        ]);
    }
    let mut polygons: Vec<Polygon> = outers.into_iter().map(|outer| vec![outer]).collect();
    for hole in holes {
        // A lake on an island in a lake belongs to the smallest of the three.
        let owner = (0..polygons.len())
            .filter(|&i| contains(&polygons[i][0], hole[0]))
            .min_by(|&a, &b| by_area(&polygons[a][0], &polygons[b][0]))
            .or_else(|| {
                (0..polygons.len()).max_by(|&a, &b| by_area(&polygons[a][0], &polygons[b][0]))
            });
        if let Some(owner) = owner {
            polygons[owner].push(hole);
        }
    }
    polygons
}

/// A corner on the antimeridian moved off it, by less than matters, so that only sides meet it.
fn off_border(point: DVec3) -> DVec3 {
    if point.x < 0.0 && point.y.abs() < OFF_BORDER {
        return DVec3::new(point.x, OFF_BORDER, point.z).normalize_or(point);
    }
    point
}

fn corner(point: DVec3) -> Corner {
    let (lat, lon) = lat_lon(point);
    [lon, lat]
}

/// To [`UNIT`], which no border of the plane is moved by.
fn rounded([lon, lat]: Corner) -> Corner {
    [lon, lat].map(|c| (c / UNIT).round() * UNIT)
}

fn add(lines: &mut [Vec<Corner>], corner: Corner) {
    let corner = rounded(corner);
    if let Some(line) = lines.last_mut()
        && line.last() != Some(&corner)
    {
        line.push(corner);
    }
}

/// Adds the way to the end of a piece of a great circle.
fn follow(lines: &mut Vec<Vec<Corner>>, from: DVec3, to: DVec3, halvings: u32) {
    let (start, end) = (corner(from), corner(to));
    let step = (end[0] - start[0]).abs();
    let short = step.min(360.0 - step);
    if short > LONGEST_STEP && halvings > 0 {
        let middle = (from + to).normalize_or(from);
        follow(lines, from, middle, halvings - 1);
        follow(lines, middle, to, halvings - 1);
        return;
    }
    if step > 180.0 {
        // Where the chord meets the antimeridian's plane.
        let share = from.y / (from.y - to.y);
        let share = if share.is_finite() {
            share.clamp(0.0, 1.0)
        } else {
            0.0
        };
        let (lat, _) = lat_lon(from + share * (to - from));
        let side = 180.0_f64.copysign(start[0]);
        add(lines, [side, lat]);
        lines.push(Vec::new());
        add(lines, [-side, lat]);
    }
    add(lines, end);
}

/// Joins arcs from border to border of the plane into rings, along the border with the plane to the left.
fn join(arcs: Vec<Vec<Corner>>) -> Vec<Vec<Corner>> {
    let place = |corner: Option<&Corner>| corner.map_or(0.0, along_border);
    let mut starts: Vec<(f64, usize)> = arcs
        .iter()
        .enumerate()
        .map(|(i, arc)| (place(arc.first()), i))
        .collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut used = vec![false; arcs.len()];
    let mut rings = Vec::new();
    for first in 0..arcs.len() {
        if used[first] {
            continue;
        }
        let mut ring: Vec<Corner> = Vec::new();
        let mut arc = first;
        while !used[arc] {
            used[arc] = true;
            ring.extend(&arcs[arc]);
            let end = place(arcs[arc].last());
            let after = starts.partition_point(|&(start, _)| start < end);
            let (start, next) = starts[after % starts.len()];
            // The corners that are passed on the way: north after half, south after the whole.
            let way = if after < starts.len() {
                start
            } else {
                start + ROUND
            };
            for (at, corners) in [
                (0.5 * ROUND, [[180.0, 90.0], [-180.0, 90.0]]),
                (ROUND, [[-180.0, -90.0], [180.0, -90.0]]),
                (1.5 * ROUND, [[180.0, 90.0], [-180.0, 90.0]]),
            ] {
                if end < at && at <= way {
                    ring.extend(corners);
                }
            }
            arc = next;
        }
        ring.extend(ring.first().copied());
        rings.push(ring);
    }
    rings
}

/// Length of the border: east side up, west side down; the poles have none.
const ROUND: f64 = 360.0;

/// How far along the border a corner on it lies.
fn along_border(&[lon, lat]: &Corner) -> f64 {
    if lon > 0.0 { lat + 90.0 } else { 270.0 - lat }
}

/// Area on the plane, positive for counter-clockwise rings.
fn signed_area(ring: &[Corner]) -> f64 {
    let [x, y] = ring.first().copied().unwrap_or_default();
    let crosses = ring
        .windows(2)
        .map(|pair| (pair[0][0] - x) * (pair[1][1] - y) - (pair[1][0] - x) * (pair[0][1] - y));
    0.5 * crosses.sum::<f64>()
}

fn by_area(a: &[Corner], b: &[Corner]) -> Ordering {
    signed_area(a).abs().total_cmp(&signed_area(b).abs())
}

/// Whether a corner lies in a ring, by the number of sides to the east of it.
fn contains(ring: &[Corner], [x, y]: Corner) -> bool {
    let sides = ring.windows(2).filter(|pair| {
        let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
        (y0 > y) != (y1 > y) && x < x0 + (y - y0) / (y1 - y0) * (x1 - x0)
    });
    sides.count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::direction_of;

    /// A circle round a place, which lies to its left.
    fn circle(lat: f64, lon: f64, radius: f64) -> Vec<DVec3> {
        let up = direction_of(lat, lon);
        let (east, north) = crate::surface::east_north(up);
        let (sin, cos) = libm::sincos(radius.to_radians());
        (0..720)
            .map(|i| {
                let (s, c) = libm::sincos(f64::from(i) * core::f64::consts::TAU / 720.0);
                up * cos + (east * c + north * s) * sin
            })
            .collect()
    }

    fn is_in(polygons: &[Polygon], corner: Corner) -> bool {
        polygons.iter().any(|rings| {
            contains(&rings[0], corner) && !rings[1..].iter().any(|hole| contains(hole, corner))
        })
    }

    fn check(rings: &[Vec<DVec3>], is_member: impl Fn(DVec3) -> bool) -> Vec<Polygon> {
        let polygons = polygons(rings);
        for rings in &polygons {
            for (i, ring) in rings.iter().enumerate() {
                assert_eq!(ring.first(), ring.last());
                assert_eq!(
                    signed_area(ring) > 0.0,
                    i == 0,
                    "outers turn left, holes right"
                );
                for pair in ring.windows(2) {
                    assert_ne!(pair[0], pair[1]);
                }
            }
        }
        for lat in (-89..90).step_by(4) {
            for lon in (-179..180).step_by(4) {
                let (lat, lon) = (f64::from(lat), f64::from(lon));
                let expected = is_member(direction_of(lat, lon));
                assert_eq!(is_in(&polygons, [lon, lat]), expected, "{lat} {lon}");
            }
        }
        polygons
    }

    fn cap(lat: f64, lon: f64, radius: f64) -> impl Fn(DVec3) -> bool {
        let (up, cos) = (direction_of(lat, lon), libm::cos(radius.to_radians()));
        move |place| place.dot(up) > cos
    }

    #[test]
    fn caps_anywhere_are_cut_where_the_plane_ends() {
        for (lat, lon, radius, count) in [
            (10.0, 20.0, 15.3, 1),
            (10.0, 178.0, 15.3, 2),
            (-40.0, -170.0, 30.3, 2),
            (90.0, 0.0, 20.3, 1),
            (-80.0, 100.0, 20.3, 1),
            (70.0, 180.0, 33.3, 1),
        ] {
            let polygons = check(&[circle(lat, lon, radius)], cap(lat, lon, radius));
            assert_eq!(polygons.len(), count, "{lat} {lon}");
        }
    }

    #[test]
    fn what_lies_outside_of_caps_has_holes() {
        let caps = [
            (10.0, 20.0, 15.3),
            (0.0, 180.0, 20.3),
            (-85.0, 90.0, 17.3),
            (60.0, 30.0, 9.3),
        ];
        let rings: Vec<Vec<DVec3>> = caps
            .iter()
            .map(|&(lat, lon, radius)| circle(lat, lon, radius).into_iter().rev().collect())
            .collect();
        check(&rings, |place| {
            !caps
                .iter()
                .any(|&(lat, lon, radius)| cap(lat, lon, radius)(place))
        });
        check(&rings[..1], |place| !cap(10.0, 20.0, 15.3)(place));
        check(&[], |_| true);
    }

    #[test]
    fn corners_on_the_antimeridian_are_corners_like_others() {
        let square = [(0.0, 180.0), (0.0, -170.0), (10.0, -170.0), (10.0, 180.0)];
        for first in 0..4 {
            let mut ring = square.map(|(lat, lon)| direction_of(lat, lon));
            ring.rotate_left(first);
            let polygons = check(&[ring.to_vec()], |place| {
                let (lat, lon) = lat_lon(place);
                lat > 0.0 && lat < 10.0 && lon < -170.0
            });
            let area: f64 = polygons.iter().map(|rings| signed_area(&rings[0])).sum();
            assert!((area - 100.0).abs() < 1.0, "{area}");
        }
        // Round a pole, from a corner at 180 degrees.
        let cap: Vec<DVec3> = (0..36)
            .map(|i| direction_of(70.0, 180.0 + 10.0 * f64::from(i)))
            .collect();
        check(&[cap], |place| lat_lon(place).0 > 70.3);
    }

    #[test]
    fn pieces_apart_keep_the_sea_around_them() {
        let hole: Vec<DVec3> = circle(0.0, 0.0, 20.3).into_iter().rev().collect();
        let island = circle(0.0, 0.0, 5.3);
        let (wide, narrow) = (cap(0.0, 0.0, 20.3), cap(0.0, 0.0, 5.3));
        check(&[hole, island], |place| !wide(place) || narrow(place));
        // Too small to be seen.
        let speck = circle(10.0, 10.0, 1e-9);
        assert!(polygons(&[speck]).is_empty());
    }

    #[test]
    fn a_ring_in_a_ring_is_a_hole_of_it() {
        let outer = circle(0.0, 180.0, 40.3);
        let hole: Vec<DVec3> = circle(0.0, 180.0, 20.3).into_iter().rev().collect();
        let island = circle(5.0, 175.0, 4.3);
        let (wide, narrow, isle) = (
            cap(0.0, 180.0, 40.3),
            cap(0.0, 180.0, 20.3),
            cap(5.0, 175.0, 4.3),
        );
        check(&[outer, hole, island], |place| {
            wide(place) && !narrow(place) || isle(place)
        });
    }

    #[test]
    fn lines_break_at_the_antimeridian() {
        let points =
            [(0.0, 170.0), (10.0, -170.0), (20.0, 175.0)].map(|(lat, lon)| direction_of(lat, lon));
        let lines = lines(&points);
        assert_eq!(lines.len(), 3);
        assert!(lines.iter().flatten().all(|c| c[0].abs() <= 180.0));
        for pair in lines.windows(2) {
            let ([a, b], [c, d]) = (pair[0][pair[0].len() - 1], pair[1][0]);
            assert_eq!((a, b), (-c, d));
            assert_eq!(a.abs(), 180.0);
        }
        for pair in lines.iter().flat_map(|line| line.windows(2)) {
            assert!((pair[1][0] - pair[0][0]).abs() < 1.001);
        }
    }
}
