//! A cut through a plate: its pieces are cells of random places under noise-warped distance, and a tear
//! runs along it from one end, or outwards from the place where three pieces meet.

use super::{
    super::super::{
        boundaries::Front, recipe::Recipe, streams, sub_plate::PlateId, topology::EdgeState,
        workers::Workers,
    },
    Outline,
};
use crate::mesh::SphereMesh;
use glam::DVec3;
use rand_chacha::ChaCha8Rng;

/// Places among which each further centre of a piece is chosen, the farthest from those before.
const TRIES: usize = 6;
/// Amplitude of the rift's wriggle, as a share of the distance between the first two centres.
const WARP: f64 = 0.25;
/// Chances of three and of four pieces: plumes break continents in three arms, rarely more.
const THREE_PIECES: f64 = 0.22;
const FOUR_PIECES: f64 = 0.08;
/// Share of its cut after which a failing rift stalls.
const STALLS: core::ops::Range<f64> = 0.3..0.7;

/// How a plate is to be broken.
pub(super) struct Cut {
    /// Sub-plates of each piece.
    pub pieces: Vec<Vec<usize>>,
    /// Where the tear begins.
    pub from: DVec3,
    /// Pace of the tear, in km/My.
    pub pace: f64,
    /// Distance from there at which it stops, in km.
    pub stops_km: f64,
    cells: Vec<Cell>,
}

/// The surroundings of a random place, and the piece that they belong to.
struct Cell {
    centre: DVec3,
    outline: Outline,
    piece: usize,
}

impl Cut {
    /// A cut into two to four cells of random places.
    pub fn draw(
        mesh: &SphereMesh<EdgeState>,
        workers: &Workers,
        rng: &mut ChaCha8Rng,
        members: &[usize],
        places: &[usize],
    ) -> Self {
        let fate = streams::unit(rng);
        let count = if fate < FOUR_PIECES {
            4
        } else if fate < FOUR_PIECES + THREE_PIECES {
            3
        } else {
            2
        };
        let cells: Vec<Cell> = centres(mesh, rng, places, count)
            .into_iter()
            .enumerate()
            .map(|(piece, centre)| Cell {
                centre,
                outline: Outline::new(rng, 1.5),
                piece,
            })
            .collect();
        let mut cut = Self {
            pieces: vec![Vec::new(); count],
            from: cells.iter().map(|cell| cell.centre).sum::<DVec3>(),
            pace: 0.0,
            stops_km: f64::INFINITY,
            cells,
        };
        let pieces = workers.map(members.len(), |range| {
            let sites = members[range].iter().map(|&v| mesh.site(v as u32));
            sites.map(|site| cut.piece_at(site)).collect::<Vec<_>>()
        });
        for (&v, piece) in members.iter().zip(pieces.into_iter().flatten()) {
            cut.pieces[piece].push(v);
        }
        cut
    }

    /// The piece that a place belongs to.
    pub fn piece_at(&self, site: DVec3) -> usize {
        let apart = self.cells[0].centre.distance(self.cells[1].centre);
        // Noise is dear, and between -1 and 1: what is too far for any is not asked for its own.
        let far = |cell: &Cell| site.distance(cell.centre);
        let nearest = self.cells.iter().map(far).fold(f64::MAX, f64::min);
        let within = nearest + 2.0 * WARP * apart;
        let mut near = self.cells.iter().filter(|cell| far(cell) <= within);
        if let (Some(cell), None) = (near.clone().next(), near.nth(1)) {
            return cell.piece;
        }
        let mut best = (f64::MAX, 0);
        for cell in self.cells.iter().filter(|cell| far(cell) <= within) {
            let far = far(cell) + WARP * apart * cell.outline.at(site);
            if far < best.0 {
                best = (far, cell.piece);
            }
        }
        best.1
    }

    /// Makes one piece of two.
    pub fn join(&mut self, kept: usize, joined: usize) {
        let members = self.pieces.remove(joined);
        self.pieces[kept].extend(members);
        self.pieces[kept].sort_unstable();
        for cell in &mut self.cells {
            if cell.piece == joined {
                cell.piece = kept;
            } else if cell.piece > joined {
                cell.piece -= 1;
            }
        }
    }

    /// Chooses where the tear begins and how far it runs.
    pub fn aim(&mut self, mesh: &SphereMesh<EdgeState>, recipe: &Recipe, rng: &mut ChaCha8Rng) {
        let constants = &recipe.constants.plates;
        self.pace = constants.tear_pace;
        self.from = self.from.normalize_or(self.cells[0].centre);
        let two = self.pieces.len() == 2;
        let along = self.places(mesh);
        let Some(&first) = along.first() else {
            return;
        };
        // In two: from the end that lies farthest from the middle. In more: from where they meet.
        let mut begin = first;
        for &place in &along {
            let nearer = place.distance(self.from) < begin.distance(self.from);
            if nearer != two {
                begin = place;
            }
        }
        self.from = begin;
        let length = along.iter().map(|p| p.distance(begin)).fold(0.0, f64::max) * recipe.radius_km;
        if two && streams::unit(rng) < constants.rift_failure {
            let share = STALLS.start + (STALLS.end - STALLS.start) * streams::unit(rng);
            self.stops_km = share * length;
        }
    }

    /// Edges across the cut, with the pieces of their ends.
    pub fn fronts(&self, mesh: &SphereMesh<EdgeState>, radius_km: f64) -> Vec<([usize; 2], Front)> {
        let piece = self.piece_of(mesh);
        let mut fronts = Vec::new();
        for members in &self.pieces {
            for &v in members {
                for h in mesh.outgoing(v as u32) {
                    let ends = [piece[v], piece[mesh.dest(h) as usize]];
                    if ends[0] < ends[1] && ends[1] != usize::MAX {
                        let edge = mesh.edge_of(h);
                        let front = Front::across(mesh, edge, [PlateId(0); 2], radius_km);
                        fronts.push((front.vertices.map(|v| piece[v as usize]), front));
                    }
                }
            }
        }
        fronts
    }

    /// Places of the sub-plates along the cut.
    fn places(&self, mesh: &SphereMesh<EdgeState>) -> Vec<DVec3> {
        let piece = self.piece_of(mesh);
        let beside = |v: &usize| {
            mesh.neighbours(*v as u32)
                .any(|w| piece[w as usize] != piece[*v] && piece[w as usize] != usize::MAX)
        };
        let members = self.pieces.iter().flatten().copied();
        members
            .filter(beside)
            .map(|v| mesh.site(v as u32))
            .collect()
    }

    /// The piece of every sub-plate, `usize::MAX` for those of other plates.
    fn piece_of(&self, mesh: &SphereMesh<EdgeState>) -> Vec<usize> {
        let mut piece = vec![usize::MAX; mesh.vertex_count()];
        for (i, members) in self.pieces.iter().enumerate() {
            for &v in members {
                piece[v] = i;
            }
        }
        piece
    }
}

/// Centres of the pieces: a random place, then each time the farthest of a few from those before.
fn centres(
    mesh: &SphereMesh<EdgeState>,
    rng: &mut ChaCha8Rng,
    places: &[usize],
    count: usize,
) -> Vec<DVec3> {
    let mut draw = || mesh.site(places[streams::below(rng, places.len())] as u32);
    let mut centres = vec![draw()];
    while centres.len() < count {
        let mut best = (-1.0, DVec3::ZERO);
        for _ in 0..TRIES {
            let place = draw();
            let near = centres
                .iter()
                .map(|centre| centre.distance_squared(place))
                .fold(f64::MAX, f64::min);
            if near > best.0 {
                best = (near, place);
            }
        }
        centres.push(best.1);
    }
    centres
}

#[cfg(test)]
mod tests {
    use super::{super::tension::Tension, *};
    use crate::simulation::plate::PlateRow;
    use crate::simulation::{
        boundaries::{FrontForce, FrontForces},
        fixtures::random_mesh,
        stages::Mantle,
        streams::Purpose,
        sub_plate::{Crust, MaterialArea},
    };
    use bevy::prelude::Entity;

    #[test]
    fn cuts_share_out_every_sub_plate_and_begin_at_the_cut() {
        let recipe = Recipe::earth_like(3).with_sub_plates(800);
        let mesh = random_mesh::<EdgeState>(800);
        let members: Vec<usize> = (0..800).filter(|&v| mesh.site(v as u32).z > 0.0).collect();
        let mut counts = [0; 5];
        for number in 0..60 {
            let mut rng = streams::stream(3, Purpose::Rift, 0, number);
            let mut cut = Cut::draw(&mesh, &Workers::default(), &mut rng, &members, &members);
            cut.aim(&mesh, &recipe, &mut rng);
            counts[cut.pieces.len()] += 1;
            let mut all: Vec<usize> = cut.pieces.concat();
            all.sort_unstable();
            assert_eq!(all, members);
            let near = cut
                .places(&mesh)
                .iter()
                .map(|p| p.distance(cut.from))
                .fold(f64::MAX, f64::min);
            assert!(near < 1e-12, "{near}");
        }
        assert!(
            counts[2] > counts[3] && counts[3] > 0 && counts[4] > 0,
            "{counts:?}"
        );
    }

    /// Two sub-plates next to each other, each a piece, pulled apart with a force of 1000.
    #[test]
    fn what_is_pulled_apart_opens_and_what_is_pressed_stays_one() {
        let recipe = Recipe::earth_like(3).with_sub_plates(2000);
        let mesh = random_mesh::<EdgeState>(2000);
        let (a, b) = (0, mesh.neighbours(0).next().unwrap());
        let sites = [mesh.site(a), mesh.site(b)];
        let row = PlateRow {
            id: PlateId(7),
            entity: Entity::PLACEHOLDER,
            rotation: DVec3::ZERO,
            born: 0.0,
        };
        let area = vec![MaterialArea(500.0); 2000];
        let crust = vec![Crust::Oceanic; 2000];
        for pull in [1000.0, -1000.0] {
            let mut rng = streams::stream(3, Purpose::Rift, 0, 0);
            let mut cut = Cut::draw(
                &mesh,
                &Workers::default(),
                &mut rng,
                &[],
                &[a as usize, b as usize],
            );
            cut.cells.truncate(2);
            for (i, cell) in cut.cells.iter_mut().enumerate() {
                cell.centre = sites[i];
                cell.piece = i;
            }
            cut.pieces = vec![vec![a as usize], vec![b as usize]];
            let front = cut.fronts(&mesh, recipe.radius_km).remove(0).1;
            let towards = front.normal.normalize() * pull;
            let towards = if front.vertices[0] == a {
                towards
            } else {
                -towards
            };
            let force = |i: usize, force: DVec3| FrontForce {
                plate: row.id,
                place: sites[i],
                torque: front.midpoint.cross(force),
            };
            let tension = Tension {
                recipe: &recipe,
                mesh: &mesh,
                mantle: &Mantle::default(),
                forces: &FrontForces(vec![force(0, -towards), force(1, towards)]),
                crust: &crust,
                area: &area,
            };
            let found = tension.partings(&row, &cut)[0].opening;
            // Each moves at F / (c a), and spin drag adds a twenty-fifth: 2000 / (1.04 c · 500).
            let expected = 2.0 * pull / (1.04 * recipe.constants.motion.ocean_drag * 500.0);
            assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
            tension.keep_what_opens(&row, &mut cut);
            assert_eq!(cut.pieces.len(), if pull > 0.0 { 2 } else { 1 });
            assert_eq!(cut.piece_at(sites[1]), usize::from(pull > 0.0));
        }
    }
}
