//! From pieces of boundary, sides of sub-plates in any order, to smooth lines.

use crate::simulation::BoundaryKind;
use bevy::math::DVec3;
use std::collections::BTreeMap;

/// A piece of a boundary. On the way from the first end to the second, seen from outside, the plate that
/// [`BoundaryKind`] calls the origin lies to the left.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    pub ends: [DVec3; 2],
    pub kind: BoundaryKind,
}

/// A line without branches, from one junction to the next or round in a ring. The last point of a ring
/// is the first again.
#[derive(Debug, Clone, Default)]
pub(super) struct Line {
    pub points: Vec<DVec3>,
    /// Kinds between the points, one less; the origin lies to the left.
    pub kinds: Vec<BoundaryKind>,
    pub closed: bool,
}

type Node = [u64; 3];

/// Pieces share their ends bit for bit.
fn node(end: DVec3) -> Node {
    // Zero has two signs.
    (end + DVec3::ZERO).to_array().map(f64::to_bits)
}

/// Joins pieces end to end.
pub(super) fn chain(pieces: &[Piece]) -> Vec<Line> {
    let mut at: BTreeMap<Node, Vec<usize>> = BTreeMap::new();
    let mut used = vec![false; pieces.len()];
    for (number, piece) in pieces.iter().enumerate() {
        let ends = piece.ends.map(node);
        used[number] = ends[0] == ends[1] || !piece.ends.iter().all(|end| end.is_finite());
        if !used[number] {
            for end in ends {
                at.entry(end).or_default().push(number);
            }
        }
    }
    let is_junction = |end: DVec3| at.get(&node(end)).is_none_or(|pieces| pieces.len() != 2);
    let mut lines = Vec::new();
    // What is left without a junction is a ring.
    for rings in [false, true] {
        for number in 0..pieces.len() {
            for start in [0, 1] {
                let begins = rings || is_junction(pieces[number].ends[start]);
                if begins && !used[number] {
                    lines.push(follow(pieces, &at, &mut used, number, start));
                }
            }
        }
    }
    lines
}

/// Follows unused pieces from one end of a piece.
fn follow(
    pieces: &[Piece],
    at: &BTreeMap<Node, Vec<usize>>,
    used: &mut [bool],
    first: usize,
    start: usize,
) -> Line {
    let mut line = Line::default();
    let mut here = pieces[first].ends[start];
    line.points.push(here);
    let mut next = Some(first);
    while let Some(number) = next {
        used[number] = true;
        let piece = pieces[number];
        let forwards = node(piece.ends[0]) == node(here);
        here = piece.ends[usize::from(forwards)];
        line.points.push(here);
        line.kinds.push(if forwards {
            piece.kind
        } else {
            piece.kind.reversed()
        });
        next = match at.get(&node(here)).map(Vec::as_slice) {
            Some(&[a, b]) => [a, b].into_iter().find(|&other| !used[other]),
            _ => None,
        };
    }
    line.closed = line.points.len() > 3
        && line.points.first().copied().map(node) == line.points.last().copied().map(node)
        && at.get(&node(here)).is_some_and(|pieces| pieces.len() == 2);
    line
}

impl Line {
    /// Takes out the zigzag of sub-plates and rounds what remains. Junctions stay where they are.
    pub(super) fn smooth(&mut self) {
        self.relax();
        for _ in 0..2 {
            self.relax();
            self.halve();
        }
        self.relax();
    }

    /// Moves every point towards the mean of its neighbours. A zigzag is gone after the first time.
    fn relax(&mut self) {
        let old = self.points.clone();
        let mean = |a: DVec3, b: DVec3, c: DVec3| (a + 2.0 * b + c).normalize_or(b);
        for (point, around) in self.points.iter_mut().skip(1).zip(old.windows(3)) {
            *point = mean(around[0], around[1], around[2]);
        }
        if let (true, [first, second, .., last, _]) = (self.closed, old.as_slice()) {
            let seam = mean(*last, *first, *second);
            let end = self.points.len() - 1;
            self.points[0] = seam;
            self.points[end] = seam;
        }
    }

    /// Adds a point in the middle of every piece.
    fn halve(&mut self) {
        let mut points: Vec<DVec3> = self.points.first().copied().into_iter().collect();
        for pair in self.points.windows(2) {
            points.push((pair[0] + pair[1]).normalize_or(pair[0]));
            points.push(pair[1]);
        }
        self.points = points;
        self.kinds = self.kinds.iter().flat_map(|&kind| [kind; 2]).collect();
    }

    /// The same line with points at equal distances, about a step apart.
    pub(super) fn evened(&self, step: f64) -> Self {
        let mut distances = vec![0.0];
        for pair in self.points.windows(2) {
            let before = distances.last().copied().unwrap_or(0.0);
            distances.push(before + pair[0].distance(pair[1]));
        }
        let total = distances.last().copied().unwrap_or(0.0);
        let least = if self.closed { 3.0 } else { 1.0 };
        let count = (total / step).ceil().max(least) as usize;
        let piece_at = |distance: f64| {
            let after = distances.partition_point(|&d| d <= distance);
            after
                .saturating_sub(1)
                .min(self.kinds.len().saturating_sub(1))
        };
        let along = |i: f64| total * i / count as f64;
        let mut line = Self {
            closed: self.closed,
            ..Self::default()
        };
        for i in 0..=count {
            let distance = along(i as f64);
            let piece = piece_at(distance);
            let Some(&[from, to]) = self.points[piece..].first_chunk() else {
                return Self::default();
            };
            let length = distances[piece + 1] - distances[piece];
            let share = if length > 0.0 {
                ((distance - distances[piece]) / length).clamp(0.0, 1.0)
            } else {
                0.0
            };
            line.points.push(from.lerp(to, share).normalize_or(from));
            if i < count {
                line.kinds.push(self.kinds[piece_at(along(i as f64 + 0.5))]);
            }
        }
        if let (true, Some(&first)) = (self.closed, line.points.first()) {
            line.points[count] = first;
        }
        line
    }

    /// Stretches of one kind: the kind with the numbers of the first and the last point.
    pub(super) fn stretches(&self) -> Vec<(BoundaryKind, usize, usize)> {
        let mut start = 0;
        self.kinds
            .chunk_by(|a, b| a == b)
            .map(|stretch| {
                let from = start;
                start += stretch.len();
                (stretch[0], from, start)
            })
            .collect()
    }

    /// Gives stretches of fewer pieces than `least` to the longer one beside them, shortest first: they
    /// would be specks.
    pub(super) fn tidy(&mut self, least: usize) {
        loop {
            let stretches = self.stretches();
            let length = |&(_, from, to): &(BoundaryKind, usize, usize)| to - from;
            let shortest = (0..stretches.len()).min_by_key(|&i| length(&stretches[i]));
            let Some(i) =
                shortest.filter(|&i| stretches.len() > 1 && length(&stretches[i]) < least)
            else {
                return;
            };
            let before = i.checked_sub(1).and_then(|i| stretches.get(i));
            let beside = before
                .into_iter()
                .chain(stretches.get(i + 1))
                .max_by_key(|stretch| length(stretch));
            let Some(&(kind, ..)) = beside else {
                return;
            };
            let (_, from, to) = stretches[i];
            self.kinds[from..to].fill(kind);
        }
    }

    /// Unit vectors to the left of the way along the ground, per point.
    pub(super) fn lefts(&self) -> Vec<DVec3> {
        let last = self.points.len().saturating_sub(1);
        (0..self.points.len())
            .map(|i| {
                let before = match i.checked_sub(1) {
                    Some(before) => before,
                    None if self.closed => last - 1,
                    None => i,
                };
                let after = if i < last {
                    i + 1
                } else if self.closed {
                    1
                } else {
                    i
                };
                let ahead = self.points[after] - self.points[before];
                self.points[i].cross(ahead).normalize_or_zero()
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(x: f64, y: f64) -> DVec3 {
        DVec3::new(1.0, x, y).normalize()
    }

    /// A zigzag eastwards in pieces that run both ways.
    fn zigzag(count: usize) -> Vec<Piece> {
        let corner = |i: usize| {
            place(
                i as f64 * 0.02,
                if i.is_multiple_of(2) { 0.0 } else { 0.01 },
            )
        };
        (0..count)
            .map(|i| {
                let ends = [corner(i), corner(i + 1)];
                if i % 3 == 1 {
                    Piece {
                        ends: [ends[1], ends[0]],
                        kind: BoundaryKind::SubductingDestination,
                    }
                } else {
                    Piece {
                        ends,
                        kind: BoundaryKind::SubductingOrigin,
                    }
                }
            })
            .collect()
    }

    #[test]
    fn pieces_in_any_order_and_direction_make_one_line() {
        let mut pieces = zigzag(20);
        pieces.swap(0, 13);
        pieces.swap(7, 4);
        let lines = chain(&pieces);
        let [line] = lines.as_slice() else {
            panic!("{} lines", lines.len());
        };
        assert_eq!((line.points.len(), line.kinds.len()), (21, 20));
        // The same plate lies on the same side all along.
        assert_eq!(line.stretches().len(), 1);
        assert!(!line.closed);
    }

    #[test]
    fn smoothing_straightens_zigzags_and_keeps_ends() {
        let mut line = chain(&zigzag(20)).remove(0);
        let ends = [line.points[0], line.points[20]];
        line.smooth();
        let even = line.evened(0.008);
        assert!(even.points[0].distance(ends[0]) < 1e-9);
        assert!(even.points.last().unwrap().distance(ends[1]) < 1e-9);
        assert_eq!(even.kinds.len() + 1, even.points.len());
        let inner = &even.points[8..even.points.len() - 8];
        assert!(inner.iter().all(|p| (p.z - 0.005).abs() < 1e-3));
        for pair in even.points.windows(2) {
            assert!(pair[0].distance(pair[1]) < 0.0081);
        }
    }

    #[test]
    fn three_plates_meet_in_a_junction() {
        let mut pieces = zigzag(6);
        let branch = [place(0.04, 0.0), place(0.04, -0.05)];
        pieces.push(Piece {
            ends: branch,
            kind: BoundaryKind::Ridge,
        });
        let lines = chain(&pieces);
        assert_eq!(lines.len(), 3);
        let ends = lines
            .iter()
            .flat_map(|line| [line.points[0], *line.points.last().unwrap()]);
        assert_eq!(ends.filter(|end| *end == branch[0]).count(), 3);
    }

    #[test]
    fn rings_close() {
        let corner = |i: usize| {
            let (sin, cos) = libm::sincos(i as f64 * 0.5);
            DVec3::new(1.0, 0.2 * cos, 0.2 * sin).normalize()
        };
        let corners: Vec<_> = (0..12).map(corner).collect();
        let pieces: Vec<_> = (0..12)
            .map(|i| Piece {
                ends: [corners[i], corners[(i + 1) % 12]],
                kind: BoundaryKind::Ridge,
            })
            .collect();
        let mut line = chain(&pieces).remove(0);
        assert!(line.closed);
        line.smooth();
        let even = line.evened(0.01);
        assert_eq!(even.points.first(), even.points.last());
        let lefts = even.lefts();
        assert!(lefts[0].distance(*lefts.last().unwrap()) < 1e-12);
        // Counter-clockwise: the inside lies to the left.
        assert!(lefts.iter().zip(&even.points).all(|(left, point)| {
            left.dot(DVec3::X - *point) > 0.0 && (left.length() - 1.0).abs() < 1e-9
        }));
    }

    #[test]
    fn specks_join_what_surrounds_them() {
        use BoundaryKind::{Ridge, Transform};
        let mut line = Line {
            points: (0..11).map(|i| place(f64::from(i) * 0.01, 0.0)).collect(),
            kinds: [Ridge; 10].into(),
            closed: false,
        };
        line.kinds[0] = Transform;
        line.kinds[5] = Transform;
        line.tidy(3);
        assert_eq!(line.kinds, [Ridge; 10]);
        line.kinds[..4].fill(Transform);
        line.tidy(3);
        assert_eq!(line.stretches(), [(Transform, 0, 4), (Ridge, 4, 10)]);
        let mut nothing = Line::default();
        nothing.smooth();
        nothing.tidy(3);
        assert!(nothing.evened(0.01).points.is_empty() && nothing.lefts().is_empty());
    }

    #[test]
    fn pieces_that_are_none_are_left_out() {
        let point = place(0.1, 0.1);
        let nonsense = [
            [point, point],
            [point, DVec3::NAN],
            [DVec3::INFINITY, point],
        ];
        let pieces = nonsense.map(|ends| Piece {
            ends,
            kind: BoundaryKind::Ridge,
        });
        assert!(chain(&pieces).is_empty());
    }
}
