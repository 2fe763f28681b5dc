//! Pieces of boundary end to end: rings round plates, lines between them.

use crate::simulation::{BoundaryKind, Surface};
use crate::surface::BoundarySegment;
use glam::DVec3;
use std::collections::BTreeMap;

/// A boundary between two plates that is of one kind all along.
pub(super) struct Front {
    /// Ids of the plates to the left and to the right, the smaller first.
    pub(super) plates: [u16; 2],
    pub(super) kind: BoundaryKind,
    pub(super) points: Vec<DVec3>,
    pub(super) length_km: f64,
    /// Means over the length in km/My: relative speed, and its part that parts the plates.
    pub(super) speed: f64,
    pub(super) opening: f64,
}

/// The rings round each plate, which lies to their left. A plate without neighbours has none.
pub(super) fn rings(surface: &Surface) -> BTreeMap<u16, Vec<Vec<DVec3>>> {
    let mut sides: BTreeMap<u16, Vec<[DVec3; 2]>> = BTreeMap::new();
    for segment in surface.boundaries() {
        let ([a, b], [left, right]) = (segment.ends, segment.plates);
        sides.entry(left).or_default().push([a, b]);
        sides.entry(right).or_default().push([b, a]);
    }
    let rings = sides.into_iter().map(|(plate, sides)| {
        let rings = chains(&sides).into_iter().map(|chain| {
            let sides = chain.into_iter().map(|i| sides[i][0]);
            sides.collect()
        });
        (plate, rings.collect())
    });
    rings.collect()
}

/// All boundaries, in the order of plates and kinds.
pub(super) fn fronts(surface: &Surface) -> Vec<Front> {
    let mut groups: BTreeMap<([u16; 2], u8), Vec<&BoundarySegment>> = BTreeMap::new();
    for segment in surface.boundaries() {
        let key = (segment.plates, segment.kind as u8);
        groups.entry(key).or_default().push(segment);
    }
    let mut fronts = Vec::new();
    for ((plates, _), segments) in groups {
        let sides: Vec<[DVec3; 2]> = segments.iter().map(|segment| segment.ends).collect();
        for chain in chains(&sides) {
            let (Some(&first), Some(&last)) = (chain.first(), chain.last()) else {
                continue;
            };
            let mut points: Vec<DVec3> = chain.iter().map(|&i| sides[i][0]).collect();
            points.push(sides[last][1]);
            let sum = |figure: &dyn Fn(&BoundarySegment) -> f64| {
                chain.iter().map(|&i| figure(segments[i])).sum::<f64>()
            };
            let length_km = sum(&|s| s.length_km);
            let mean = |figure: &dyn Fn(&BoundarySegment) -> f64| {
                sum(&|s| figure(s) * s.length_km) / length_km.max(1e-9)
            };
            fronts.push(Front {
                plates,
                kind: segments[first].kind,
                points,
                length_km,
                speed: mean(&|s| f64::from(s.speed())),
                opening: mean(&|s| f64::from(s.opening)),
            });
        }
    }
    fronts
}

/// Joins sides end to start, as long as they go. Numbers of sides; what is a ring begins anywhere.
fn chains(sides: &[[DVec3; 2]]) -> Vec<Vec<usize>> {
    // Sides share their ends bit for bit; adding zero makes one of its two.
    let node = |end: DVec3| (end + DVec3::ZERO).to_array().map(f64::to_bits);
    let is_real = |side: &[DVec3; 2]| {
        node(side[0]) != node(side[1]) && side.iter().all(|end| end.is_finite())
    };
    let mut starts: BTreeMap<[u64; 3], Vec<usize>> = BTreeMap::new();
    let mut ends: BTreeMap<[u64; 3], usize> = BTreeMap::new();
    let mut used: Vec<bool> = sides.iter().map(|side| !is_real(side)).collect();
    for (i, side) in sides.iter().enumerate().filter(|(_, side)| is_real(side)) {
        starts.entry(node(side[0])).or_default().push(i);
        ends.insert(node(side[1]), i);
    }
    let mut chains = Vec::new();
    // What nothing leads to comes first, so that no line is begun in its middle.
    for begins_anywhere in [false, true] {
        for first in 0..sides.len() {
            if used[first] || !begins_anywhere && ends.contains_key(&node(sides[first][0])) {
                continue;
            }
            let mut chain = Vec::new();
            let mut next = Some(first);
            while let Some(side) = next {
                used[side] = true;
                chain.push(side);
                next = starts
                    .get(&node(sides[side][1]))
                    .and_then(|sides| sides.iter().copied().find(|&side| !used[side]));
            }
            chains.push(chain);
        }
    }
    chains
}
