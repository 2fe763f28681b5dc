//! A checkpoint as sections of a file, and back.

use super::{
    container::Section,
    error::{Fault, SaveError},
    numbers::{Packer, Unpacker, surprise, surprise_f32, surprised, surprised_f32},
    sites::{pack_sites, pack_tangents, unpack_sites, unpack_tangents},
    validate,
};
use crate::{
    mesh::{Edge, NONE, SphereMesh},
    simulation::{
        BoundaryKind, Created, Crust, Deviation, EdgeState, Elevation, FoldDirection, MaterialArea,
        Orogeny, OrogenyBegan, PlateId, RidgeDirection, RockColumn, Slab, Thickness, Trench,
        Velocity, Volcanism,
        checkpoint::{Checkpoint, Record, Rows},
        precision::{ELEVATION_STEPS, REST_STEPS},
    },
};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::{borrow::Borrow, collections::BTreeMap};

/// Unit of stored thicknesses, in steps per km. It belongs to the format; the simulation keeps them no finer.
const THICKNESS_STEPS: f64 = (1_u64 << 20) as f64;
/// Names of the sections.
pub(super) const RECORD: &str = "record";
const SITES: &str = "sites";
const EDGES: &str = "edges";
const ROWS: &str = "rows";

/// Largest record in bytes of text. Events and moments of statistics fill it, some hundred bytes to two thousand
/// each.
const LARGEST_RECORD: usize = 64 << 20;
/// Most sub-plates for each one that the recipe asks for: refinement keeps their number well within.
const MOST_PER_SUB_PLATE: usize = 2;

/// The record and how long the columns are.
#[derive(Serialize, Deserialize)]
struct Opening<R> {
    sub_plates: usize,
    edge_slots: usize,
    free_edges: usize,
    record: R,
}

/// The sections of a checkpoint.
pub(super) fn pack(checkpoint: &Checkpoint) -> Result<Vec<(&'static str, Vec<u8>)>, SaveError> {
    let Checkpoint { record, rows, mesh } = checkpoint;
    let opening = Opening {
        sub_plates: mesh.vertex_count(),
        edge_slots: mesh.edge_slots(),
        free_edges: mesh.free_edges().len(),
        record,
    };
    let fault = |section: &str, what: Fault| SaveError::Damaged {
        section: section.into(),
        offset: 0,
        what,
    };
    opening.validate().map_err(|what| fault(RECORD, what))?;
    validate::rows(rows, record).map_err(|what| fault(ROWS, what))?;
    let text = ron::to_string(&opening).map_err(|error| fault(RECORD, error.to_string()))?;
    if text.len() > LARGEST_RECORD {
        return Err(SaveError::TooLarge {
            what: "what is not counted by sub-plates, such as events and statistics".into(),
            bytes: text.len(),
            most: LARGEST_RECORD,
        });
    }
    let mut sites = Packer::default();
    pack_sites(&mut sites, mesh.sites()).map_err(|what| fault(SITES, what))?;
    Ok(vec![
        (RECORD, super::text::deflate(text.as_bytes())),
        (SITES, sites.finish()),
        (EDGES, pack_edges(mesh).map_err(|what| fault(EDGES, what))?),
        (
            ROWS,
            pack_rows(record, rows, mesh).map_err(|what| fault(ROWS, what))?,
        ),
    ])
}

/// The checkpoint of some sections; those of other names are left to others.
pub(super) fn unpack(sections: &[Section]) -> Result<Checkpoint, SaveError> {
    let named = |name: &str| {
        let found = sections.iter().find(|section| section.name == name);
        found.ok_or_else(|| SaveError::Damaged {
            section: name.into(),
            offset: 0,
            what: "it is missing".into(),
        })
    };
    let section = named(RECORD)?;
    let opening = open_record(section.bytes).map_err(|what| section.damaged(what))?;
    let (vertices, record) = (opening.sub_plates, opening.record);

    let section = named(SITES)?;
    let mut columns = Unpacker::new(section.bytes);
    let sites = unpack_sites(&mut columns, vertices)
        .and_then(|sites| columns.finish().map(|()| sites))
        .map_err(|what| section.damaged(what))?;

    let section = named(EDGES)?;
    let mesh = unpack_edges(section.bytes, sites, opening.edge_slots, opening.free_edges)
        .map_err(|what| section.damaged(what))?;

    let section = named(ROWS)?;
    let rows = unpack_rows(section.bytes, &record, &mesh)
        .and_then(|rows| validate::rows(&rows, &record).map(|()| rows))
        .map_err(|what| section.damaged(what))?;
    Ok(Checkpoint { record, rows, mesh })
}

fn open_record(bytes: &[u8]) -> Result<Opening<Record>, Fault> {
    let text = super::text::inflate(bytes, LARGEST_RECORD)?;
    let text = String::from_utf8(text).map_err(|error| error.to_string())?;
    let opening: Opening<Record> = ron::from_str(&text).map_err(|error| error.to_string())?;
    opening.validate()?;
    Ok(opening)
}

impl<R: Borrow<Record>> Opening<R> {
    /// Verifies lengths and figures, before anything is allocated by them and before anything is written.
    fn validate(&self) -> Result<(), Fault> {
        let record = self.record.borrow();
        validate::record(record, self.sub_plates)?;
        let asked = record.recipe.sub_plates as usize;
        if self.sub_plates < 4 || self.sub_plates > MOST_PER_SUB_PLATE * asked {
            return Err(format!(
                "{} sub-plates, of {asked} in the recipe",
                self.sub_plates
            ));
        }
        // Euler's formula; and free edges are compacted long before they are many.
        let live = 3 * self.sub_plates - 6;
        if self.edge_slots.checked_sub(self.free_edges) != Some(live) || self.free_edges > live {
            return Err(format!(
                "{} places for edges, {} of them free",
                self.edge_slots, self.free_edges
            ));
        }
        Ok(())
    }
}

/// What springs are expected to be as long as: chords, in radii.
fn chord(mesh: &SphereMesh<EdgeState>, edge: Edge, cross: bool) -> f64 {
    let (mut a, mut b) = mesh.endpoints(edge);
    if cross {
        (a, b) = (mesh.apex(2 * edge), mesh.apex(2 * edge + 1));
    }
    mesh.site(a).distance(mesh.site(b))
}

fn pack_edges(mesh: &SphereMesh<EdgeState>) -> Result<Vec<u8>, Fault> {
    let (mut lower, mut across, mut flags) = (Vec::new(), Vec::new(), Vec::new());
    let mut rests = Vec::new();
    let mut before = 0;
    for edge in mesh.edges() {
        let (a, b) = mesh.endpoints(edge);
        let state = mesh.payload(edge);
        lower.push((a.min(b) as i32).wrapping_sub(before));
        before = a.min(b) as i32;
        across.push(a.abs_diff(b));
        let kinds = state.kind as u16 | (state.cross_kind as u16) << 3;
        let sense = u16::from(a > b) << 6;
        let mut springs = 0;
        for (bit, rest) in [(7, state.rest), (8, state.cross_rest)] {
            // Not zero itself: the sign of a zero is kept, too.
            if rest.to_bits() != 0 {
                springs |= 1 << bit;
                rests.push((f64::from(rest), chord(mesh, edge, bit == 8)));
            }
        }
        flags.push(kinds | sense | springs);
    }
    // The half-edge at which each fan begins, by its place among those of the vertex.
    let first: Vec<u16> = (0..mesh.vertex_count() as u32)
        .map(|v| {
            let first = mesh.first_outgoing(v);
            mesh.outgoing(v).filter(|&h| h < first).count() as u16
        })
        .collect();
    let mut packer = Packer::default();
    packer.put_remainders(&lower)?;
    packer.put_remainders(&across)?;
    packer.put_remainders(&flags)?;
    packer.put(mesh.free_edges())?;
    packer.put_remainders(&first)?;
    packer.put_stepped(REST_STEPS, rests.into_iter())?;
    Ok(packer.finish())
}

fn unpack_edges(
    bytes: &[u8],
    sites: Vec<DVec3>,
    slots: usize,
    free: usize,
) -> Result<SphereMesh<EdgeState>, Fault> {
    let (vertices, live) = (sites.len(), slots - free);
    let mut columns = Unpacker::new(bytes);
    let lower = columns.take::<i32>(live)?;
    let across = columns.take::<u32>(live)?;
    let flags = columns.take::<u16>(live)?;
    let free = columns.take::<u32>(free)?;
    let first = columns.take::<u16>(vertices)?;
    let mut ends = vec![[0; 2]; slots];
    for &edge in &free {
        *ends
            .get_mut(edge as usize)
            .ok_or_else(|| format!("edge {edge} of {slots} is free"))? = [NONE; 2];
    }
    let mut payload = vec![EdgeState::default(); slots];
    let mut low = 0_i32;
    let mut rows = lower.into_iter().zip(across).zip(&flags);
    let mut edges = Vec::with_capacity(live);
    // Outgoing half-edges of each vertex in the order of their numbers.
    let mut degree = vec![0_u32; vertices + 1];
    for (edge, ends) in ends
        .iter_mut()
        .enumerate()
        .filter(|(_, ends)| ends[0] != NONE)
    {
        let Some(((lower, across), &flags)) = rows.next() else {
            return Err("an edge is free twice".into());
        };
        low = low.wrapping_add(lower);
        let a = u32::try_from(low).map_err(|_| format!("an edge begins at vertex {low}"))?;
        let b = a.saturating_add(across);
        if b as usize >= vertices {
            return Err(format!("an edge ends at vertex {b} of {vertices}"));
        }
        *ends = if flags >> 6 & 1 == 0 { [a, b] } else { [b, a] };
        degree[a as usize + 1] += 1;
        degree[b as usize + 1] += 1;
        payload[edge].kind = kind(flags & 7)?;
        payload[edge].cross_kind = kind(flags >> 3 & 7)?;
        edges.push(edge);
    }
    for v in 0..vertices {
        degree[v + 1] += degree[v];
    }
    let mut outgoing = vec![NONE; 2 * live];
    let mut filled = degree.clone();
    for &edge in &edges {
        for (half, &end) in ends[edge].iter().enumerate() {
            let place = &mut filled[end as usize];
            outgoing[*place as usize] = (2 * edge + half) as u32;
            *place += 1;
        }
    }
    let first = first.into_iter().enumerate().map(|(v, nth)| {
        let own = &outgoing[degree[v] as usize..degree[v + 1] as usize];
        let found = own.get(usize::from(nth)).copied();
        found.ok_or_else(|| format!("vertex {v} has no edge {nth}"))
    });
    let first = first.collect::<Result<Vec<u32>, Fault>>()?;
    let mut mesh = SphereMesh::restore(sites, first, &ends, payload, free)
        .map_err(|error| error.to_string())?;

    let mut springs = Vec::new();
    for (&edge, &flags) in edges.iter().zip(&flags) {
        let stored = [false, true]
            .into_iter()
            .filter(|&cross| flags >> (7 + u16::from(cross)) & 1 == 1);
        springs.extend(stored.map(|cross| (edge as u32, cross)));
    }
    let expected = springs
        .iter()
        .map(|&(edge, cross)| chord(&mesh, edge, cross));
    let rests = columns.take_stepped(REST_STEPS, expected)?;
    columns.finish()?;
    for ((edge, cross), rest) in springs.into_iter().zip(rests) {
        // A chord of the sphere has two radii at most.
        if !(0.0..=2.0).contains(&rest) {
            return Err(format!("a spring of {rest} radii"));
        }
        let state = mesh.payload_mut(edge);
        *if cross {
            &mut state.cross_rest
        } else {
            &mut state.rest
        } = rest as f32;
    }
    Ok(mesh)
}

fn kind(number: u16) -> Result<BoundaryKind, Fault> {
    use BoundaryKind::{
        Collision, Joined, Ridge, SubductingDestination, SubductingOrigin, Transform,
    };
    const KINDS: [BoundaryKind; 6] = [
        Joined,
        Transform,
        Ridge,
        SubductingOrigin,
        SubductingDestination,
        Collision,
    ];
    let kind = KINDS.into_iter().find(|&kind| kind as u16 == number);
    kind.ok_or_else(|| format!("there is no boundary of kind {number}"))
}

/// Velocities as the plates' rotations and the deviations have them, in km/My.
fn expected_velocity(record: &Record) -> impl Fn(PlateId, DVec3, Deviation) -> Vec3 {
    let rotations = record
        .plates
        .iter()
        .map(|plate| (plate.id, plate.rotation.0));
    let rotations: BTreeMap<PlateId, DVec3> = rotations.collect();
    let radius = record.recipe.radius_km;
    move |plate, site, deviation| {
        let rotation = rotations.get(&plate).copied().unwrap_or_default();
        let rigid = rotation.cross(site) * radius;
        (rigid + deviation.0.as_dvec3()).as_vec3()
    }
}

/// Elevation in m as it was when the ground last settled, if nothing has happened since.
fn settled(record: &Record, rock: &RockColumn) -> f64 {
    let then = record.clock.time_my - record.clock.geology.waited();
    rock.elevation(&record.recipe, &record.sea, then)
}

fn pack_rows(record: &Record, rows: &Rows, mesh: &SphereMesh<EdgeState>) -> Result<Vec<u8>, Fault> {
    let sites = mesh.sites();
    let mut packer = Packer::default();
    let ids: Vec<u16> = rows.plate.iter().map(|plate| plate.0).collect();
    packer.put(&ids)?;
    let kinds = rows.crust.iter().zip(&rows.orogeny);
    let kinds: Vec<u16> = kinds
        .map(|(&crust, &orogeny)| crust as u16 | (orogeny as u16) << 1)
        .collect();
    packer.put(&kinds)?;
    pack_tangents(&mut packer, sites, |v| rows.deviation[v].0)?;
    let expected = expected_velocity(record);
    for k in 0..3 {
        let surprises = (0..sites.len()).map(|v| {
            let expected = expected(rows.plate[v], sites[v], rows.deviation[v]);
            surprise_f32(rows.velocity[v].0[k], expected[k])
        });
        packer.put_remainders(&surprises.collect::<Vec<i32>>())?;
    }
    pack_tangents(&mut packer, sites, |v| rows.fold[v].0)?;
    pack_tangents(&mut packer, sites, |v| rows.ridge[v].0)?;
    for column in [
        column(&rows.created, |x| x.0),
        column(&rows.orogeny_began, |x| x.0),
        column(&rows.slab, |x| x.0),
        column(&rows.trench, |x| x.0),
        column(&rows.volcanism, |x| x.pile_km),
    ] {
        packer.put(&column)?;
    }
    let thickness = rows.thickness.iter().map(|x| (x.0, 0.0));
    packer.put_stepped(THICKNESS_STEPS, thickness)?;
    packer.put(&column(&rows.area, |x| x.0 as f32))?;
    packer.put_remainders(&column(&rows.area, |x| {
        surprise(x.0, f64::from(x.0 as f32))
    }))?;
    let fed: Vec<u16> = column(&rows.volcanism, |x| u16::from(x.last_my.is_some()));
    packer.put(&fed)?;
    let times: Vec<f32> = rows.volcanism.iter().filter_map(|x| x.last_my).collect();
    packer.put(&times)?;
    let elevation = (0..sites.len()).map(|v| {
        let rock = RockColumn {
            crust: rows.crust[v],
            thickness: rows.thickness[v],
            created: rows.created[v],
            trench: rows.trench[v],
            volcanism: rows.volcanism[v],
        };
        (f64::from(rows.elevation[v].0), settled(record, &rock))
    });
    packer.put_stepped(ELEVATION_STEPS, elevation)?;
    Ok(packer.finish())
}

fn column<T, N>(rows: &[T], number: impl Fn(&T) -> N) -> Vec<N> {
    rows.iter().map(number).collect()
}

fn unpack_rows(bytes: &[u8], record: &Record, mesh: &SphereMesh<EdgeState>) -> Result<Rows, Fault> {
    let sites = mesh.sites();
    let count = sites.len();
    let mut columns = Unpacker::new(bytes);
    let plate: Vec<PlateId> = columns.take(count)?.into_iter().map(PlateId).collect();
    let kinds = columns.take::<u16>(count)?;
    let crust = kinds.iter().map(|kind| match kind & 1 {
        0 => Crust::Oceanic,
        _ => Crust::Continental,
    });
    let orogeny = kinds.iter().map(|kind| match kind >> 1 {
        0 => Ok(Orogeny::None),
        1 => Ok(Orogeny::Andean),
        2 => Ok(Orogeny::Himalayan),
        other => Err(format!("there is no orogeny of kind {other}")),
    });
    let orogeny = orogeny.collect::<Result<_, Fault>>()?;
    let deviation = unpack_tangents(&mut columns, sites)?;
    let deviation: Vec<Deviation> = deviation.into_iter().map(Deviation).collect();
    let expected = expected_velocity(record);
    let surprises = [
        columns.take::<i32>(count)?,
        columns.take::<i32>(count)?,
        columns.take::<i32>(count)?,
    ];
    let velocity = (0..count).map(|v| {
        let expected = expected(plate[v], sites[v], deviation[v]);
        let part = |k: usize| surprised_f32(surprises[k][v], expected[k]);
        Velocity(Vec3::new(part(0), part(1), part(2)))
    });
    let velocity = velocity.collect();
    let fold = unpack_tangents(&mut columns, sites)?;
    let ridge = unpack_tangents(&mut columns, sites)?;
    let mut single = || columns.take::<f32>(count);
    let (created, orogeny_began, slab) = (single()?, single()?, single()?);
    let (trench, pile) = (single()?, single()?);
    let thickness = columns.take_stepped(THICKNESS_STEPS, vec![0.0; count].into_iter())?;
    let thickness: Vec<Thickness> = thickness.into_iter().map(Thickness).collect();
    let single = columns.take::<f32>(count)?.into_iter();
    let rounding = columns.take::<i64>(count)?;
    let area = single
        .zip(rounding)
        .map(|(x, rounding)| MaterialArea(surprised(rounding, x.into())));
    let area = area.collect();
    let fed = columns.take::<u16>(count)?;
    let mut times = columns
        .take::<f32>(fed.iter().filter(|&&fed| fed != 0).count())?
        .into_iter();
    let volcanism = pile.into_iter().zip(fed).map(|(pile_km, fed)| Volcanism {
        pile_km,
        last_my: if fed == 0 { None } else { times.next() },
    });
    let volcanism: Vec<Volcanism> = volcanism.collect();
    let crust: Vec<Crust> = crust.collect();
    let expected = (0..count).map(|v| {
        let rock = RockColumn {
            crust: crust[v],
            thickness: thickness[v],
            created: Created(created[v]),
            trench: Trench(trench[v]),
            volcanism: volcanism[v],
        };
        settled(record, &rock)
    });
    let elevation = columns.take_stepped(ELEVATION_STEPS, expected)?;
    columns.finish()?;
    let elevation = elevation.into_iter().map(|x| Elevation(x as f32)).collect();
    Ok(Rows {
        velocity,
        deviation,
        plate,
        crust,
        elevation,
        thickness,
        area,
        created: created.into_iter().map(Created).collect(),
        orogeny,
        orogeny_began: orogeny_began.into_iter().map(OrogenyBegan).collect(),
        fold: fold.into_iter().map(FoldDirection).collect(),
        ridge: ridge.into_iter().map(RidgeDirection).collect(),
        slab: slab.into_iter().map(Slab).collect(),
        trench: trench.into_iter().map(Trench).collect(),
        volcanism,
    })
}
