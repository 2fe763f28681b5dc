//! Plates break: along a line, or into pieces of a supercontinent.

use super::{
    super::super::{
        boundaries::{Contact, Contacts, Rift},
        clock::Clock,
        columns::Columns,
        events::{EventFailure, HeldMotion, LatLon, PlateChoice},
        plate::{NextPlateId, Plate, PlateBorn, PlateTable, Rotation},
        recipe::Recipe,
        stages::{Splits, reorganize_plates::Outline},
        streams::{self, Purpose},
        sub_plate::{Crust, MaterialArea, PlateId, SubPlate},
        topology::Topology,
    },
    Verdict, choose,
};
use bevy::prelude::*;
use glam::DVec3;

/// Speed in km/My at which two pieces begin to part; the push of young rifts keeps them going.
const PARTING: f64 = 20.0;
/// A piece is at least this many of the smallest plates large.
const LEAST: f64 = 2.0;
/// Amplitude of the wriggle of a supercontinent's rifts, in radians.
const WARP: f64 = 0.15;

type Plates<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static Plate,
        &'static mut Rotation,
        &'static mut PlateBorn,
    ),
>;

/// What breaking a plate touches.
#[derive(bevy::ecs::system::SystemParam)]
pub(super) struct Breaking<'w, 's> {
    commands: Commands<'w, 's>,
    recipe: Res<'w, Recipe>,
    clock: Res<'w, Clock>,
    contacts: ResMut<'w, Contacts>,
    next: ResMut<'w, NextPlateId>,
    splits: ResMut<'w, Splits>,
    plates: Plates<'w, 's>,
}

/// A part of a plate that is to break.
struct Piece {
    members: Vec<usize>,
    /// Area in km².
    area: f64,
    /// Rotation in rad/My that is added to the plate's.
    parting: DVec3,
}

/// Pace of a scripted tear, in km/My: the author of a scenario says when, and it is torn.
const AT_ONCE: f64 = 1e9;

impl Breaking<'_, '_> {
    fn table(&self) -> PlateTable {
        PlateTable::gather(self.plates.iter())
    }

    /// Least area of a piece in km².
    fn least(&self) -> f64 {
        LEAST * self.recipe.constants.plates.smallest * self.sphere()
    }

    fn sphere(&self) -> f64 {
        4.0 * core::f64::consts::PI * self.recipe.radius_km * self.recipe.radius_km
    }

    /// Rotation that carries what lies at `place` along `towards`, in rad/My.
    fn carry(&self, place: DVec3, towards: DVec3) -> DVec3 {
        place.cross(towards).normalize_or_zero() * (0.5 * PARTING / self.recipe.radius_km)
    }

    /// Breaks a plate, torn at once from a place on. The largest piece keeps the plate's id, the others get
    /// new ones.
    fn break_apart(
        &mut self,
        id: PlateId,
        mut pieces: Vec<Piece>,
        from: DVec3,
        plate: &mut [PlateId],
    ) -> Result<(), EventFailure> {
        let table = self.table();
        let now = self.clock.began_my;
        pieces.sort_by(|a, b| b.area.total_cmp(&a.area));
        let Some(row) = table.row(id).map(|row| table.rows()[row]) else {
            return Err(EventFailure::NoPlate { id: id.0 });
        };
        let mut ids = vec![id];
        for _ in 1..pieces.len() {
            ids.push(self.next.take().ok_or(EventFailure::NoIdLeft)?);
        }
        for (piece, &new) in pieces.iter().zip(&ids) {
            let rotation = row.rotation + piece.parting;
            if new == id {
                if let Ok((_, _, mut turn, mut born)) = self.plates.get_mut(row.entity) {
                    turn.0 = rotation;
                    born.0 = now;
                }
                self.commands.entity(row.entity).remove::<HeldMotion>();
                continue;
            }
            self.commands
                .spawn((Plate { id: new }, Rotation(rotation), PlateBorn(now)));
            for &v in &piece.members {
                plate[v] = new;
            }
        }
        for (i, &a) in ids.iter().enumerate() {
            for &b in &ids[i + 1..] {
                let contact = Contact {
                    last_my: now,
                    rift: Some(Rift {
                        began_my: now,
                        from,
                        pace: AT_ONCE,
                        stops_km: f64::INFINITY,
                    }),
                    ..default()
                };
                self.contacts.0.insert(Contacts::key(a, b), contact);
            }
        }
        self.splits.suspected = true;
        self.splits.regrouped = true;
        Ok(())
    }
}

/// Breaks the plate under the middle of a line along it.
pub(super) fn rift_along(
    In(line): In<Vec<LatLon>>,
    topology: Res<Topology>,
    mut breaking: Breaking,
    mut sub_plates: Query<(&mut PlateId, &MaterialArea), With<SubPlate>>,
) -> Verdict {
    let mesh = &topology.0;
    let (mut plate, area) = sub_plates.columns(mesh.vertex_count())?;
    let plate = plate.bypass_change_detection();
    let Some(first) = line.first().map(|place| place.direction()) else {
        return Ok(Err(EventFailure::NoPlate { id: 0 }));
    };
    let line = Line::through(line.into_iter().map(LatLon::direction));
    let (middle, right) = line.middle();
    let under = PlateChoice::At(LatLon::of(middle));
    let id = match choose(under, mesh, plate, &breaking.table()) {
        Ok(id) => id,
        Err(failure) => return Ok(Err(failure)),
    };
    let mut pieces = [right, -right].map(|towards| Piece {
        members: Vec::new(),
        area: 0.0,
        parting: breaking.carry(middle, towards),
    });
    for v in (0..plate.len()).filter(|&v| plate[v] == id) {
        let piece = &mut pieces[usize::from(line.is_left(mesh.site(v as u32)))];
        piece.members.push(v);
        piece.area += area[v].0;
    }
    let (smaller, least) = (pieces[0].area.min(pieces[1].area), breaking.least());
    if smaller < least {
        return Ok(Err(EventFailure::Undivided {
            plate: id.0,
            share: smaller / breaking.sphere(),
            least: least / breaking.sphere(),
        }));
    }
    Ok(breaking.break_apart(id, pieces.into(), first, plate))
}

/// Breaks a supercontinent's plate into pieces around far places on its continents, and lets it forget
/// the collisions that hold it.
pub(super) fn break_up(
    In((choice, count)): In<(PlateChoice, usize)>,
    topology: Res<Topology>,
    mut breaking: Breaking,
    mut sub_plates: Query<(&mut PlateId, &Crust, &MaterialArea), With<SubPlate>>,
) -> Verdict {
    let mesh = &topology.0;
    let (mut plate, crust, area) = sub_plates.columns(mesh.vertex_count())?;
    let plate = plate.bypass_change_detection();
    let id = match choose(choice, mesh, plate, &breaking.table()) {
        Ok(id) => id,
        Err(failure) => return Ok(Err(failure)),
    };
    let members: Vec<usize> = (0..plate.len()).filter(|&v| plate[v] == id).collect();
    let size: f64 = members.iter().map(|&v| area[v].0).sum();
    let too_small = Ok(Err(EventFailure::TooSmall { plate: id.0 }));
    if size < breaking.least() * count as f64 {
        return too_small;
    }
    let land: Vec<usize> = members
        .iter()
        .copied()
        .filter(|&v| crust[v].is_continental())
        .collect();
    let places = if land.len() >= count { &land } else { &members };
    let site = |v: usize| mesh.site(v as u32);
    let middle = places
        .iter()
        .map(|&v| site(v) * area[v].0)
        .sum::<DVec3>()
        .normalize_or_zero();
    let mut rng = streams::stream(
        breaking.recipe.seed,
        Purpose::Events,
        breaking.clock.events_done as u64,
        id.0.into(),
    );
    // Each centre as far from the others as it can be, the first as far from the middle.
    let mut centres: Vec<DVec3> = Vec::new();
    let mut far: Vec<f64> = places.iter().map(|&v| site(v).distance(middle)).collect();
    while centres.len() < count {
        let best = (0..places.len()).max_by(|&a, &b| far[a].total_cmp(&far[b]).then(b.cmp(&a)));
        let Some(centre) = best.map(|best| site(places[best])) else {
            return too_small;
        };
        for (far, &v) in far.iter_mut().zip(places) {
            let distance = site(v).distance(centre);
            *far = if centres.is_empty() {
                distance
            } else {
                far.min(distance)
            };
        }
        centres.push(centre);
    }
    let outlines: Vec<Outline> = centres
        .iter()
        .map(|_| Outline::new(&mut rng, 1.5))
        .collect();
    let mut pieces: Vec<Piece> = centres
        .iter()
        .map(|&centre| Piece {
            members: Vec::new(),
            area: 0.0,
            parting: breaking.carry(middle, centre - middle),
        })
        .collect();
    for &v in &members {
        let from = |i: usize| site(v).distance(centres[i]) + WARP * outlines[i].at(site(v));
        let nearest = (0..count).min_by(|&a, &b| from(a).total_cmp(&from(b)));
        let piece = &mut pieces[nearest.unwrap_or(0)];
        piece.members.push(v);
        piece.area += area[v].0;
    }
    if pieces.iter().any(|piece| piece.area < breaking.least()) {
        return too_small;
    }
    let of_plate = |pair: &(PlateId, PlateId)| pair.0 == id || pair.1 == id;
    let contacts = &mut breaking.contacts.0;
    for (_, contact) in contacts.iter_mut().filter(|(pair, _)| of_plate(pair)) {
        contact.interpenetration = 0.0;
    }
    Ok(breaking.break_apart(id, pieces, middle, plate))
}

/// A line of great circles, which goes on straight beyond its ends.
struct Line {
    legs: Vec<Leg>,
}

/// The part of a line between two of its places.
struct Leg {
    from: DVec3,
    /// Tangent at `from` along the leg.
    along: DVec3,
    /// Unit vector to the left.
    left: DVec3,
    /// Length in radians.
    length: f64,
    /// Where it may end beyond its places, in radians from `from`.
    reach: [f64; 2],
}

impl Line {
    fn through(places: impl Iterator<Item = DVec3>) -> Self {
        let places: Vec<DVec3> = places.collect();
        let mut legs: Vec<Leg> = places
            .windows(2)
            .map(|pair| {
                let left = pair[0].cross(pair[1]).normalize_or_zero();
                let along = left.cross(pair[0]);
                let length = libm::atan2(pair[1].dot(along), pair[1].dot(pair[0]));
                Leg {
                    from: pair[0],
                    along,
                    left,
                    length,
                    reach: [0.0, length],
                }
            })
            .collect();
        if let Some(first) = legs.first_mut() {
            first.reach[0] = -core::f64::consts::PI;
        }
        if let Some(last) = legs.last_mut() {
            last.reach[1] = core::f64::consts::PI;
        }
        Self { legs }
    }

    /// The place half-way along the line, and the direction to its right there.
    fn middle(&self) -> (DVec3, DVec3) {
        let mut left = 0.5 * self.legs.iter().map(|leg| leg.length).sum::<f64>();
        for leg in &self.legs {
            if left <= leg.length {
                return (leg.at(left), -leg.left);
            }
            left -= leg.length;
        }
        (DVec3::Z, DVec3::X)
    }

    fn is_left(&self, place: DVec3) -> bool {
        let mut nearest = (f64::INFINITY, 0.0);
        for leg in &self.legs {
            let angle = libm::atan2(place.dot(leg.along), place.dot(leg.from));
            let distance = place.distance(leg.at(angle.clamp(leg.reach[0], leg.reach[1])));
            let side = place.dot(leg.left);
            // Around a bend both legs are as near; the one that sees the place from the side is right.
            let equal = (distance - nearest.0).abs() < 1e-12;
            if (equal && side.abs() > f64::abs(nearest.1)) || (!equal && distance < nearest.0) {
                nearest = (distance, side);
            }
        }
        nearest.1 > 0.0
    }
}

impl Leg {
    fn at(&self, angle: f64) -> DVec3 {
        let (sin, cos) = libm::sincos(angle);
        self.from * cos + self.along * sin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bent_line_has_two_sides() {
        // East along the equator to 30° E, then north.
        let places = [(0.0, 0.0), (0.0, 30.0), (30.0, 30.0)];
        let line = Line::through(
            places
                .into_iter()
                .map(|(lat, lon)| LatLon::new(lat, lon).direction()),
        );
        for (lat, lon, left) in [
            (10.0, 10.0, true),
            (-10.0, 10.0, false),
            (10.0, 40.0, false),
            (-5.0, 35.0, false),
            (5.0, 29.0, true),
            // Beyond both ends.
            (50.0, 20.0, true),
            (50.0, 40.0, false),
            (5.0, -40.0, true),
            (-5.0, -40.0, false),
        ] {
            let place = LatLon::new(lat, lon);
            assert_eq!(line.is_left(place.direction()), left, "{place}");
        }
        let (middle, right) = line.middle();
        assert!((middle - LatLon::new(0.0, 30.0).direction()).length() < 1e-12);
        assert!((right + DVec3::Z).length() < 1e-12);
    }
}
