//! What no step could start from. Files may say whatever they like.

use super::error::Fault;
use crate::simulation::checkpoint::{Record, Rows};
use std::collections::BTreeSet;

/// Beyond this nothing on a planet is measured: neither in m nor in km, km², km³, My or km/My.
const LARGEST: f64 = 1e12;
/// Radians in a My: 60 times as fast as any event may turn a plate.
const FASTEST: f64 = 20.0;
/// Most plates: the balance of their torques is a dense system of three times as many equations.
const MOST_PLATES: usize = 1_000;
/// Most steps: a history has some tens of thousands.
const MOST_STEPS: u64 = 1 << 53;
/// Largest departure of a direction's length from 1.
const UNIT: f64 = 1e-6;

fn measures(x: f64) -> bool {
    x.abs() < LARGEST
}

/// Verifies everything but the columns, for so many sub-plates.
pub(super) fn record(record: &Record, vertices: usize) -> Result<(), Fault> {
    record
        .recipe
        .validate()
        .map_err(|error| error.to_string())?;
    let clock = &record.clock;
    let figures = [
        ("time", clock.time_my),
        ("beginning of the step", clock.began_my),
        ("length of the step", clock.step_my),
        ("fastest speed", clock.fastest),
        ("depth of the sea", record.sea.mean_depth),
        ("level of the sea", record.sea.level),
        ("warmth of the mantle", record.mantle.warmth),
        ("downwelling", record.mantle.downwelling.length()),
        ("superplume", record.mantle.superplume.length()),
        // In cubic kilometres: Earth's continents have 8e9.
        ("ledger", record.ledger.booked_km3() * 1e-6),
        (
            "area of created crust",
            record.ledger.area_created_km2 * 1e-6,
        ),
        (
            "area of consumed crust",
            record.ledger.area_consumed_km2 * 1e-6,
        ),
    ];
    if let Some((name, value)) = figures.into_iter().find(|(_, value)| !measures(*value)) {
        return Err(format!("{name}: {value}"));
    }
    if clock.steps > MOST_STEPS {
        return Err(format!("{} steps", clock.steps));
    }
    let ticks = [
        clock.geology,
        clock.reorganisation,
        clock.refinement,
        clock.margins,
    ];
    if let Some(tick) = ticks
        .iter()
        .find(|tick| !(0.0..LARGEST).contains(&tick.waited()))
    {
        return Err(format!("a stage has waited for {} My", tick.waited()));
    }
    if clock.time_my < 0.0 || clock.events_done > record.recipe.events.len() {
        return Err(format!(
            "{} of {} events are over after {} My",
            clock.events_done,
            record.recipe.events.len(),
            clock.time_my
        ));
    }
    if record.plates.len() > MOST_PLATES {
        return Err(format!(
            "{} plates, of {MOST_PLATES} at most",
            record.plates.len()
        ));
    }
    if record.plates.is_empty() || !record.plates.is_sorted_by(|a, b| a.id < b.id) {
        return Err("the plates are not in the order of their ids".into());
    }
    for plate in &record.plates {
        let id = plate.id.0;
        if id == 0 || id >= record.next_plate {
            return Err(format!(
                "plate {id}, and the next one is {}",
                record.next_plate
            ));
        }
        let held = plate.held.map_or(0.0, |held| held.rotation.length());
        for (name, value, largest) in [
            ("turn", plate.rotation.0.length(), FASTEST),
            ("prescribed turn", held, FASTEST),
            ("area", plate.area.0, LARGEST),
            ("birth", plate.born.0, LARGEST),
            ("torque", plate.torque.sum().length(), 1e30),
        ] {
            // Not a number is not below anything.
            let is_sound = value.abs() < largest;
            if !is_sound {
                return Err(format!("{name} of plate {id}: {value}"));
            }
        }
    }
    let ids: BTreeSet<u16> = record.hot_spots.iter().map(|spot| spot.id).collect();
    for spot in &record.hot_spots {
        let is_placed = (spot.place.length() - 1.0).abs() < UNIT;
        if !is_placed || !measures(spot.flux) || !measures(spot.since_my) {
            return Err(format!("hot spot {} is nowhere", spot.id));
        }
    }
    if ids.len() < record.hot_spots.len() {
        return Err("two hot spots have one id".into());
    }
    for (a, b, contact) in &record.contacts {
        let from = contact.rift.map_or(1.0, |rift| rift.from.length());
        let is_known = a < b && b.0 < record.next_plate && (from - 1.0).abs() < UNIT;
        if !is_known || !measures(contact.last_my) {
            return Err(format!("contact of plates {} and {}", a.0, b.0));
        }
    }
    let splits = &record.splits;
    let mut named = splits.cuts.iter().flatten().chain(&splits.moved);
    match named.find(|v| **v as usize >= vertices) {
        Some(v) => Err(format!("sub-plate {v} of {vertices} has been cut off")),
        None => Ok(()),
    }
}

/// Verifies the columns.
pub(super) fn rows(rows: &Rows, record: &Record) -> Result<(), Fault> {
    let ids: BTreeSet<_> = record.plates.iter().map(|plate| plate.id).collect();
    let mut grounded = BTreeSet::new();
    for v in 0..rows.plate.len() {
        grounded.insert(rows.plate[v]);
        if !ids.contains(&rows.plate[v]) {
            return Err(format!(
                "sub-plate {v} is of plate {}, which is none",
                rows.plate[v].0
            ));
        }
        let volcanism = &rows.volcanism[v];
        let figures = [
            ("velocity", f64::from(rows.velocity[v].0.length())),
            ("deviation", f64::from(rows.deviation[v].0.length())),
            ("fold direction", f64::from(rows.fold[v].0.length())),
            ("ridge direction", f64::from(rows.ridge[v].0.length())),
            ("elevation", f64::from(rows.elevation[v].0)),
            ("thickness", rows.thickness[v].0),
            ("area", rows.area[v].0),
            ("creation", f64::from(rows.created[v].0)),
            ("orogeny", f64::from(rows.orogeny_began[v].0)),
            ("slab", f64::from(rows.slab[v].0)),
            ("trench", f64::from(rows.trench[v].0)),
            ("pile", f64::from(volcanism.pile_km)),
            ("volcanism", f64::from(volcanism.last_my.unwrap_or(0.0))),
        ];
        if let Some((name, value)) = figures.into_iter().find(|(_, value)| !measures(*value)) {
            return Err(format!("{name} of sub-plate {v}: {value}"));
        }
        if rows.thickness[v].0 < 0.0 || rows.area[v].0 <= 0.0 {
            return Err(format!(
                "sub-plate {v} is {} km thick on {} km²",
                rows.thickness[v].0, rows.area[v].0
            ));
        }
    }
    match ids.difference(&grounded).next() {
        Some(id) => Err(format!("plate {} has no sub-plate", id.0)),
        None => Ok(()),
    }
}
