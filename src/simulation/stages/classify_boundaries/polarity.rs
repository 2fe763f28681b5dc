//! Which side goes under, settled once for each stretch of front.
//!
//! Polarity belongs to a trench and not to a pair of plates: two plates may override each other in
//! different places, as at the two ends of New Zealand. A stretch is a chain of front edges between
//! the same two plates, with sea floor on at least one side. The slabs that hang along it hold it to
//! its polarity; without any, the pair's last polarity holds, then the older floor sinks.

use super::super::super::{
    boundaries::{Contacts, Front},
    recipe::Recipe,
    sub_plate::{Created, Crust, PlateId, Slab},
    topology::EdgeState,
    workers::{FEW, Workers},
};
use crate::mesh::SphereMesh;
use std::collections::BTreeMap;

/// Mean length of slab along a stretch that holds it to its polarity, in km.
const HOLDS: f64 = 20.0;

/// What a stretch of front knows of its two plates, the smaller id first.
#[derive(Default)]
struct Stretch {
    /// Length of all edges, and of those with sea floor on both sides, in km.
    length: f64,
    oceanic: f64,
    /// Length times slab beneath either side.
    hanging: [f64; 2],
    /// Length times date of birth of either side's floor, where both are floor.
    created: [f64; 2],
}

/// Sets the sinking end of every front that closes on sea floor. Sea floor goes under continents; between
/// floor and floor the stretch decides, and a slab that hung on the wrong side breaks off.
pub(super) fn settle(
    workers: &Workers,
    mesh: &SphereMesh<EdgeState>,
    fronts: &mut [Front],
    crust: &[Crust],
    created: &[Created],
    slab: &mut [Slab],
    recipe: &Recipe,
    contacts: &mut Contacts,
) {
    let stretch_of = stretches(workers, mesh, fronts);
    let count = stretch_of
        .iter()
        .flatten()
        .max()
        .map_or(0, |&last| last + 1);
    let mut stretches: Vec<Stretch> = Vec::new();
    stretches.resize_with(count, Stretch::default);
    let is_floor = |v: u32| !crust[v as usize].is_continental();
    for (front, &stretch) in fronts.iter().zip(&stretch_of) {
        let Some(stretch) = stretch.map(|number| &mut stretches[number]) else {
            continue;
        };
        stretch.length += front.length;
        let both = front.vertices.iter().all(|&v| is_floor(v));
        if both {
            stretch.oceanic += front.length;
        }
        for (end, &vertex) in front.vertices.iter().enumerate() {
            let side = side_of(front, end);
            stretch.hanging[side] += front.length * f64::from(slab[vertex as usize].0);
            if both {
                stretch.created[side] += front.length * f64::from(created[vertex as usize].0);
            }
        }
    }

    let mut decided: Vec<Option<((PlateId, PlateId), PlateId)>> = vec![None; count];
    for (front, &stretch) in fronts.iter_mut().zip(&stretch_of) {
        front.under = None;
        let Some(number) = stretch else {
            continue;
        };
        let [first, second] = front.vertices.map(is_floor);
        if first != second {
            front.under = Some(usize::from(second));
            continue;
        }
        let of = &stretches[number];
        let (_, sinking) = *decided[number].get_or_insert_with(|| {
            let key = Contacts::key(front.plates[0], front.plates[1]);
            let before = contacts.0.get(&key).and_then(|contact| contact.subducting);
            let reversal = recipe.constants.boundaries.reversal;
            (key, of.sinking(key, before, reversal))
        });
        let under = usize::from(sinking != front.plates[0]);
        front.under = Some(under);
        if of.hanging[side_of(front, under)] > of.hanging[side_of(front, 1 - under)] {
            slab[front.vertices[under] as usize].0 = 0.0;
        }
    }
    // Per pair, the polarity of its longest stretch of sea floor.
    let mut longest: BTreeMap<(PlateId, PlateId), (f64, PlateId)> = BTreeMap::new();
    for (stretch, decision) in stretches.iter().zip(decided) {
        if let Some((key, sinking)) = decision {
            let best = longest.entry(key).or_insert((0.0, sinking));
            if stretch.oceanic > best.0 {
                *best = (stretch.oceanic, sinking);
            }
        }
    }
    for (key, (_, sinking)) in longest {
        if let Some(contact) = contacts.0.get_mut(&key) {
            contact.subducting = Some(sinking);
        }
    }
}

impl Stretch {
    /// The plate that goes under where floor meets floor.
    fn sinking(&self, key: (PlateId, PlateId), before: Option<PlateId>, reversal: f64) -> PlateId {
        // How much older the first plate's floor is.
        let lead = (self.created[1] - self.created[0]) / self.oceanic.max(1e-9);
        let older = if lead >= 0.0 { key.0 } else { key.1 };
        let [first, second] = self.hanging.map(|hanging| hanging / self.length.max(1e-9));
        if lead.abs() > reversal {
            older
        } else if first.max(second) > HOLDS {
            if second > first { key.0 } else { key.1 }
        } else {
            before.unwrap_or(older)
        }
    }
}

/// Place of an edge among the edges of the fronts, which ascend, looked for from a place near it.
fn find_near(edges: &[u32], from: usize, edge: u32) -> Option<usize> {
    let mut step = 8;
    let (mut low, mut high) = (from, from);
    while low > 0 && edges[low] > edge {
        low = low.saturating_sub(step);
        step *= 4;
    }
    while high < edges.len() && edges[high] < edge {
        high += step;
        step *= 4;
    }
    let high = (high + 1).min(edges.len());
    let found = edges[low..high].binary_search(&edge);
    found.ok().map(|place| low + place)
}

/// 0 for the plate with the smaller id.
fn side_of(front: &Front, end: usize) -> usize {
    usize::from(front.plates[end] > front.plates[1 - end])
}

/// The number of the stretch that each front belongs to; none where continents meet.
fn stretches(
    workers: &Workers,
    mesh: &SphereMesh<EdgeState>,
    fronts: &[Front],
) -> Vec<Option<usize>> {
    // Searched four times a front: side by side they fit the caches.
    let edges: Vec<u32> = fronts.iter().map(|front| front.edge).collect();
    // The front leaves a triangle through another of its edges.
    let follow = |at: usize| {
        let front = &fronts[at];
        let pair = |front: &Front| Contacts::key(front.plates[0], front.plates[1]);
        let [h, k] = [2 * front.edge, 2 * front.edge + 1];
        [mesh.next(h), mesh.prev(h), mesh.next(k), mesh.prev(k)].map(|h| {
            let next = find_near(&edges, at, h / 2)?;
            let other = &fronts[next];
            (!other.continental && pair(other) == pair(front)).then_some(next as u32)
        })
    };
    let parts = (0..fronts.len()).step_by(FEW);
    let followers: Vec<[Option<u32>; 4]> = workers
        .run(parts, |from| {
            let part = from..fronts.len().min(from + FEW);
            part.map(follow).collect::<Vec<_>>()
        })
        .concat();

    let mut stretch_of: Vec<Option<usize>> = vec![None; fronts.len()];
    let mut count = 0;
    let mut chain = Vec::new();
    for first in 0..fronts.len() {
        if fronts[first].continental || stretch_of[first].is_some() {
            continue;
        }
        stretch_of[first] = Some(count);
        chain.push(first);
        while let Some(at) = chain.pop() {
            for next in followers[at]
                .into_iter()
                .flatten()
                .map(|next| next as usize)
            {
                if stretch_of[next].is_none() {
                    stretch_of[next] = Some(count);
                    chain.push(next);
                }
            }
        }
        count += 1;
    }
    stretch_of
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::fixtures::random_mesh;
    use bevy::utils::default;
    use glam::DVec3;

    /// Two plates on either side of the plane y = 0, with continents around both ends of the x axis: two
    /// stretches of sea floor between floor, to the north and to the south.
    struct World {
        mesh: SphereMesh<EdgeState>,
        fronts: Vec<Front>,
        crust: Vec<Crust>,
        created: Vec<Created>,
        slab: Vec<Slab>,
        contacts: Contacts,
    }

    const NORTH: PlateId = PlateId(1);
    const SOUTH: PlateId = PlateId(2);

    fn world() -> World {
        let mesh = random_mesh::<EdgeState>(3000);
        let plate: Vec<PlateId> = mesh
            .sites()
            .iter()
            .map(|site| if site.y > 0.0 { NORTH } else { SOUTH })
            .collect();
        let crust: Vec<Crust> = mesh
            .sites()
            .iter()
            .map(|site| {
                if site.x.abs() > 0.8 {
                    Crust::Continental
                } else {
                    Crust::Oceanic
                }
            })
            .collect();
        let mut fronts = Vec::new();
        for edge in (0..mesh.edge_slots() as u32).filter(|&edge| mesh.is_edge(edge)) {
            let (u, v) = mesh.endpoints(edge);
            let plates = [plate[u as usize], plate[v as usize]];
            if plates[0] != plates[1] {
                let mut front = Front::across(&mesh, edge, plates, 6371.0);
                front.continental = [u, v].iter().all(|&v| crust[v as usize].is_continental());
                fronts.push(front);
            }
        }
        let mut contacts = Contacts::default();
        contacts.0.insert((NORTH, SOUTH), default());
        // The northern plate is 40 My older.
        let created = plate
            .iter()
            .map(|&id| Created(if id == NORTH { -60.0 } else { -20.0 }))
            .collect();
        World {
            slab: vec![Slab(0.0); mesh.vertex_count()],
            mesh,
            fronts,
            crust,
            created,
            contacts,
        }
    }

    impl World {
        fn settle(&mut self) {
            settle(
                &Workers::default(),
                &self.mesh,
                &mut self.fronts,
                &self.crust,
                &self.created,
                &mut self.slab,
                &Recipe::default(),
                &mut self.contacts,
            );
        }

        /// The plates that go under where floor meets floor, on one side of the plane z = 0.
        fn sinking(&self, side: f64) -> Vec<PlateId> {
            let floor = |v: &u32| !self.crust[*v as usize].is_continental();
            let fronts = self.fronts.iter().filter(|front| {
                front.midpoint.dot(DVec3::Z) * side > 0.0 && front.vertices.iter().all(floor)
            });
            let mut sinking: Vec<PlateId> = fronts
                .map(|front| front.plates[front.under.unwrap()])
                .collect();
            assert!(sinking.len() > 10);
            sinking.dedup();
            sinking
        }

        fn hang(&mut self, plate: PlateId, side: f64) {
            for front in &self.fronts {
                let end = usize::from(front.plates[0] != plate);
                if front.midpoint.z * side > 0.0 {
                    self.slab[front.vertices[end] as usize].0 = 300.0;
                }
            }
        }
    }

    #[test]
    fn each_stretch_keeps_its_own_polarity() {
        let mut world = world();
        // Without slabs the older floor sinks everywhere; continents meet without a winner.
        world.settle();
        assert_eq!(
            [world.sinking(1.0), world.sinking(-1.0)],
            [[NORTH], [NORTH]]
        );
        assert!(world.fronts.iter().any(|front| front.continental));
        for front in &world.fronts {
            let land = front
                .vertices
                .map(|v| world.crust[v as usize].is_continental());
            match land {
                [true, true] => assert_eq!(front.under, None),
                [false, true] => assert_eq!(front.under, Some(0)),
                [true, false] => assert_eq!(front.under, Some(1)),
                [false, false] => {}
            }
        }
        // A slab beneath the north in one stretch, beneath the south in the other.
        world.hang(NORTH, 1.0);
        world.hang(SOUTH, -1.0);
        world.settle();
        assert_eq!(
            [world.sinking(1.0), world.sinking(-1.0)],
            [[SOUTH], [NORTH]]
        );
        assert!(world.slab.iter().any(|slab| slab.0 > 0.0));
    }

    #[test]
    fn a_trench_turns_round_beneath_much_older_floor_and_its_slab_breaks_off() {
        let mut world = world();
        world.hang(NORTH, 1.0);
        world.settle();
        assert_eq!(world.sinking(1.0), [SOUTH]);
        // 100 My older than the floor that sinks beneath it: more than the 90 My of a reversal.
        for created in &mut world.created {
            created.0 = if created.0 == -60.0 { -120.0 } else { -20.0 };
        }
        world.settle();
        assert_eq!(world.sinking(1.0), [NORTH]);
        let hanging = |front: &&Front| {
            let floor = |v: u32| !world.crust[v as usize].is_continental();
            front.vertices.iter().all(|&v| floor(v))
                && front
                    .vertices
                    .iter()
                    .any(|&v| world.slab[v as usize].0 > 0.0)
        };
        assert_eq!(world.fronts.iter().filter(hanging).count(), 0);
        assert_eq!(world.contacts.0[&(NORTH, SOUTH)].subducting, Some(NORTH));
    }
}
