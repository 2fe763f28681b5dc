//! The first continents: cratons of unequal size with irregular coasts, blind to the plates, so that
//! most plates carry both kinds of crust and most coasts lie inside plates.

use crate::{
    mesh::SphereMesh,
    simulation::{
        recipe::Recipe,
        stages::reorganize_plates::Outline,
        streams::{self, Purpose},
        topology::EdgeState,
    },
};
use glam::DVec3;

/// Number of cratons.
const CRATONS: core::ops::Range<usize> = 6..12;
/// Radius of a craton before it is scaled to the wanted share, in rad.
const RADII: core::ops::Range<f64> = 0.25..0.75;
/// Amplitude of the coasts' noise, in rad.
const RAGGED: f64 = 0.45;
/// Thickness at the edge of the crust, and what is added far inland, in km.
const EDGE: f64 = 29.0;
const INLAND: f64 = 7.5;
/// Unevenness of the interior, in km.
const UNEVEN: f64 = 2.5;

/// Continental crust of the start.
pub(super) struct Ground {
    /// Thickness in km where the crust is continental.
    pub thickness: Vec<Option<f64>>,
    /// Age of continental crust in My.
    pub age: Vec<f64>,
}

/// Lays continental crust over exactly the share of the sphere that the recipe asks for.
pub(super) fn lay(recipe: &Recipe, mesh: &SphereMesh<EdgeState>) -> Ground {
    let mut rng = streams::stream(recipe.seed, Purpose::Continents, 0, 0);
    let count = CRATONS.start + streams::below(&mut rng, CRATONS.len());
    let cratons: Vec<(DVec3, f64, f64)> = (0..count)
        .map(|_| {
            let radius = RADII.start + (RADII.end - RADII.start) * streams::unit(&mut rng);
            (
                streams::direction(&mut rng),
                radius,
                600.0 + 2400.0 * streams::unit(&mut rng),
            )
        })
        .collect();
    let ragged = Outline::new(&mut rng, 1.6);
    let uneven = Outline::new(&mut rng, 3.0);

    // Height of each place above the coast, in rad; the coast is where the share is reached.
    let field: Vec<(f64, f64)> = mesh
        .sites()
        .iter()
        .map(|site| {
            let (mut best, mut age) = (f64::MIN, 0.0);
            for &(centre, radius, born) in &cratons {
                let inside = radius - libm::acos(site.dot(centre).clamp(-1.0, 1.0));
                if inside > best {
                    (best, age) = (inside, born);
                }
            }
            (best + RAGGED * ragged.at(*site), age)
        })
        .collect();
    let mut order: Vec<u32> = (0..field.len() as u32).collect();
    order.sort_by(|&a, &b| {
        field[b as usize]
            .0
            .total_cmp(&field[a as usize].0)
            .then(a.cmp(&b))
    });
    let wanted = (recipe.continental_share * field.len() as f64).round() as usize;
    let coast = order.get(wanted).map_or(f64::MIN, |&v| field[v as usize].0);

    let mut ground = Ground {
        thickness: vec![None; field.len()],
        age: vec![0.0; field.len()],
    };
    for &v in &order[..wanted.min(order.len())] {
        let (height, age) = field[v as usize];
        let inland = ((height - coast) / 0.12).clamp(0.0, 1.0);
        let inland = inland * inland * (3.0 - 2.0 * inland);
        let site = mesh.site(v);
        ground.thickness[v as usize] =
            Some(EDGE + INLAND * inland + UNEVEN * uneven.at(site) * inland);
        ground.age[v as usize] = age;
    }
    ground
}
