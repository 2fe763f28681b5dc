//! Lengths, slip and turnover of the boundaries between plates.

use super::{Statistics, View, quantile, ratio, sort};
use crate::mesh::NONE;
use crate::simulation::{
    boundaries::{Boundaries, Front},
    stages::classify_boundaries::smooth_strikes,
    workers::Workers,
};

/// Part of the slip across a boundary beyond which it opens or closes: sin 30° (Bird 2003).
const ACROSS: f64 = 0.5;
/// Slip below this is none, in km/My.
const STILL: f64 = 1e-6;
/// km²/My in km²/yr.
const PER_YEAR: f64 = 1e-6;

/// A sum over the length of boundaries.
#[derive(Default)]
struct Sum {
    km: f64,
    slip: f64,
}

impl Sum {
    fn add(&mut self, km: f64, slip: f64) {
        self.km += km;
        self.slip += km * slip;
    }

    fn mean_slip(&self) -> f64 {
        ratio(self.slip, self.km)
    }
}

pub(super) fn measure(view: &View, statistics: &mut Statistics) {
    let fronts = fronts(view);
    let mut lengths = [0.0; 3];
    let (mut ridges, mut trenches, mut transforms, mut collisions) = (
        Sum::default(),
        Sum::default(),
        Sum::default(),
        Sum::default(),
    );
    let mut crests: Vec<(f64, f64)> = Vec::new();
    for front in &fronts {
        // The normals of a front's pieces sum to its chord: so do their parts along its direction,
        // while the pieces' own lengths would count the zigzag of the mesh.
        let km = front.normal.dot(front.direction).max(0.0);
        let slip = front.slip.length();
        if front.opening.abs() <= ACROSS * slip || slip < STILL {
            lengths[1] += km;
            if !front.continental {
                transforms.add(km, slip);
            }
        } else if front.opening > 0.0 {
            lengths[0] += km;
            if !front.continental {
                ridges.add(km, slip);
                statistics.spreading_km2_yr += front.opening * km * PER_YEAR;
                let ends = front.vertices.map(|v| v as usize);
                let floor = ends
                    .into_iter()
                    .filter(|&v| !view.crust[v].is_continental());
                crests.extend(floor.map(|v| (view.elevation(v), km)));
            }
        } else {
            lengths[2] += km;
            if front.continental {
                collisions.add(km, slip);
            } else {
                trenches.add(km, slip);
                statistics.subduction_km2_yr -= front.opening * km * PER_YEAR;
            }
        }
    }
    let all: f64 = lengths.iter().sum();
    statistics.boundary_km = all;
    statistics.boundary_shares = lengths.map(|km| ratio(km, all));
    [
        statistics.opening_km,
        statistics.sliding_km,
        statistics.closing_km,
    ] = lengths;
    statistics.slip_ridges = ridges.mean_slip();
    statistics.slip_trenches = trenches.mean_slip();
    statistics.slip_transforms = transforms.mean_slip();
    statistics.slip_collisions = collisions.mean_slip();
    sort(&mut crests);
    statistics.ridge_median_m = quantile(&crests, 0.5);
}

/// The fronts as stage 2 would find them now; stages after it may have moved or removed some.
fn fronts(view: &View) -> Vec<Front> {
    let mesh = view.mesh;
    let radius = view.recipe.radius_km;
    let mut boundaries = Boundaries {
        place: vec![NONE; mesh.vertex_count()],
        ..Boundaries::default()
    };
    for edge in mesh.edges() {
        let (u, v) = mesh.endpoints(edge);
        let plates = [u, v].map(|v| view.plate[v as usize]);
        if plates[0] != plates[1] {
            boundaries.place[u as usize] = 0;
            boundaries.place[v as usize] = 0;
            boundaries
                .fronts
                .push(Front::across(mesh, edge, plates, radius));
        }
    }
    boundaries.number_vertices();
    let smoothing = view.recipe.constants.boundaries.smoothing;
    smooth_strikes(
        &Workers::default(),
        mesh,
        view.plate,
        smoothing,
        &mut boundaries,
    );
    let mut fronts = core::mem::take(&mut boundaries.fronts);
    for front in &mut fronts {
        front.aim(&boundaries, mesh, &view.plates, radius);
        front.continental = front
            .vertices
            .iter()
            .all(|&v| view.crust[v as usize].is_continental());
    }
    fronts
}
