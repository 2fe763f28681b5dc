//! Places on the sphere and vectors along it. Of three components two are stored, and what the third
//! departs from where the sphere would have it.

use super::{
    error::Fault,
    numbers::{Packer, Unpacker, surprise, surprise_f32, surprised, surprised_f32},
};
use crate::simulation::precision::SITE_STEPS;
use glam::{DVec3, Vec3};

fn steps(x: f64) -> i64 {
    (x * SITE_STEPS).round_ties_even() as i64
}

fn place(steps: i64) -> f64 {
    steps as f64 / SITE_STEPS
}

/// The longest component of a unit vector, and the two others in turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Face {
    long: usize,
    negative: bool,
}

impl Face {
    pub fn of(site: DVec3) -> Self {
        let size = site.abs();
        let long = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        Self {
            long,
            negative: site[long] < 0.0,
        }
    }

    fn others(self) -> [usize; 2] {
        [(self.long + 1) % 3, (self.long + 2) % 3]
    }

    fn number(self) -> u16 {
        2 * self.long as u16 + u16::from(self.negative)
    }

    fn numbered(number: u16) -> Result<Self, Fault> {
        if number < 6 {
            Ok(Self {
                long: usize::from(number / 2),
                negative: number % 2 == 1,
            })
        } else {
            Err(format!("a cube has no face {number}"))
        }
    }

    /// Longest component of the unit vector with these two others, in steps.
    fn longest(self, [a, b]: [f64; 2]) -> i64 {
        let length = (1.0 - a * a - b * b).max(0.0).sqrt();
        steps(if self.negative { -length } else { length })
    }

    /// Longest component of a tangent at `site` with these two others.
    fn along(self, site: DVec3, [a, b]: [f32; 2]) -> f32 {
        if a == 0.0 && b == 0.0 {
            return 0.0;
        }
        let [i, j] = self.others();
        let radial = f64::from(a) * site[i] + f64::from(b) * site[j];
        (-radial / site[self.long]) as f32
    }
}

/// Stores unit vectors, best in an order in which neighbours follow each other.
pub(super) fn pack_sites(packer: &mut Packer, sites: &[DVec3]) -> Result<(), Fault> {
    let mut faces = Vec::with_capacity(sites.len());
    let mut moves = [const { Vec::new() }; 3];
    let mut rests = [const { Vec::new() }; 3];
    let mut before = [0_i64; 3];
    for &site in sites {
        let face = Face::of(site);
        let [i, j] = face.others();
        let now = site.to_array().map(steps);
        moves[0].push(now[i].wrapping_sub(before[i]));
        moves[1].push(now[j].wrapping_sub(before[j]));
        let longest = face.longest([site[i], site[j]]);
        moves[2].push(now[face.long].wrapping_sub(longest));
        for k in 0..3 {
            rests[k].push(surprise(site[k], place(now[k])));
        }
        faces.push(face.number());
        before = now;
    }
    packer.put(&faces)?;
    for column in moves.iter().chain(&rests) {
        packer.put_remainders(column)?;
    }
    Ok(())
}

/// Takes out what [`pack_sites`] stored.
pub(super) fn unpack_sites(unpacker: &mut Unpacker, count: usize) -> Result<Vec<DVec3>, Fault> {
    let faces = unpacker.take::<u16>(count)?;
    let mut column = || unpacker.take::<i64>(count);
    let moves = [column()?, column()?, column()?];
    let rests = [column()?, column()?, column()?];
    let mut before = [0_i64; 3];
    let mut sites = Vec::with_capacity(count);
    for v in 0..count {
        let face = Face::numbered(faces[v])?;
        let [i, j] = face.others();
        let mut site = DVec3::ZERO;
        let mut now = [0; 3];
        for (k, moves) in [(i, &moves[0]), (j, &moves[1])] {
            now[k] = before[k].wrapping_add(moves[v]);
            site[k] = surprised(rests[k][v], place(now[k]));
        }
        let k = face.long;
        now[k] = face.longest([site[i], site[j]]).wrapping_add(moves[2][v]);
        site[k] = surprised(rests[k][v], place(now[k]));
        sites.push(site);
        before = now;
    }
    Ok(sites)
}

/// Unit of stored directions, in steps per one; what crust carries is no finer.
const DIRECTION_STEPS: f32 = (1_u32 << 20) as f32;

fn turns(x: f32) -> i32 {
    (x * DIRECTION_STEPS).round_ties_even() as i32
}

fn direction(turns: i32) -> f32 {
    turns as f32 / DIRECTION_STEPS
}

/// Stores a vector at each site, best ones along the sphere.
pub(super) fn pack_tangents(
    packer: &mut Packer,
    sites: &[DVec3],
    tangent: impl Fn(usize) -> Vec3,
) -> Result<(), Fault> {
    let mut parts = [const { Vec::new() }; 3];
    let mut rests = [const { Vec::new() }; 3];
    for (v, &site) in sites.iter().enumerate() {
        let face = Face::of(site);
        let tangent = tangent(v);
        let [i, j] = face.others();
        let along = turns(face.along(site, [tangent[i], tangent[j]]));
        for (k, part, expected) in [(0, i, 0), (1, j, 0), (2, face.long, along)] {
            let now = turns(tangent[part]);
            parts[k].push(now.wrapping_sub(expected));
            rests[k].push(surprise_f32(tangent[part], direction(now)));
        }
    }
    for column in parts.iter().chain(&rests) {
        packer.put_remainders(column)?;
    }
    Ok(())
}

/// Takes out what [`pack_tangents`] stored.
pub(super) fn unpack_tangents(
    unpacker: &mut Unpacker,
    sites: &[DVec3],
) -> Result<Vec<Vec3>, Fault> {
    let mut column = || unpacker.take::<i32>(sites.len());
    let parts = [column()?, column()?, column()?];
    let rests = [column()?, column()?, column()?];
    let tangents = sites.iter().enumerate().map(|(v, &site)| {
        let face = Face::of(site);
        let [i, j] = face.others();
        let part = |k: usize, expected: i32| {
            let turns = expected.wrapping_add(parts[k][v]);
            surprised_f32(rests[k][v], direction(turns))
        };
        let mut tangent = Vec3::ZERO;
        tangent[i] = part(0, 0);
        tangent[j] = part(1, 0);
        let along = turns(face.along(site, [tangent[i], tangent[j]]));
        tangent[face.long] = part(2, along);
        tangent
    });
    Ok(tangents.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::{collection::vec, prelude::*};

    fn bits(sites: &[DVec3]) -> Vec<[u64; 3]> {
        sites
            .iter()
            .map(|site| site.to_array().map(f64::to_bits))
            .collect()
    }

    proptest! {
        #[test]
        fn sites_and_tangents_come_back_whatever_they_are(
            parts in vec((any::<[f64; 3]>(), any::<[f32; 3]>()), 1..50)
        ) {
            // Unit vectors and nonsense in turn.
            let sites: Vec<DVec3> = parts
                .iter()
                .enumerate()
                .map(|(i, (site, _))| {
                    let site = DVec3::from(*site);
                    if i % 2 == 0 { site.normalize_or(DVec3::NEG_Y) } else { site }
                })
                .collect();
            let tangent = |v: usize| Vec3::from(parts[v].1);
            let mut packer = Packer::default();
            pack_sites(&mut packer, &sites).unwrap();
            pack_tangents(&mut packer, &sites, tangent).unwrap();
            let bytes = packer.finish();
            let mut unpacker = Unpacker::new(&bytes);
            let back = unpack_sites(&mut unpacker, sites.len()).unwrap();
            // What is not a number may come back as another such.
            let numbers = sites.iter().all(|site| site.is_finite());
            if numbers {
                prop_assert_eq!(bits(&back), bits(&sites));
                let tangents = unpack_tangents(&mut unpacker, &back).unwrap();
                for (v, back) in tangents.iter().enumerate() {
                    let bits = |x: Vec3| x.to_array().map(f32::to_bits);
                    prop_assert_eq!(bits(*back), bits(tangent(v)));
                }
            }
        }
    }

    #[test]
    fn what_the_sphere_says_costs_next_to_nothing() {
        // Ten thousand places on the grid, with a tangent of length one at each.
        let mut sites = Vec::new();
        for i in 0..10_000 {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 10_000.0;
            let (sin, cos) = libm::sincos(2.399_963_229_728_653 * f64::from(i));
            let r = (1.0 - z * z).sqrt();
            sites.push(DVec3::new(r * cos, r * sin, z).map(|x| place(steps(x))));
        }
        let east = |v: usize| DVec3::Z.cross(sites[v]).normalize().as_vec3();
        let mut packer = Packer::default();
        pack_sites(&mut packer, &sites).unwrap();
        let places = packer.finish().len();
        // Two components of 50 bits each, and a bit or two.
        assert!(places < 13 * sites.len(), "{places}");
        let mut packer = Packer::default();
        pack_tangents(&mut packer, &sites, east).unwrap();
        let tangents = packer.finish().len();
        assert!(tangents < 8 * sites.len(), "{tangents}");
    }
}
