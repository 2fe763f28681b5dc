//! Published ways to wear land down, beside the base level of [`erode`](super::erode).

use super::{
    super::{
        laws::erosion::{continental_wear, rain_share},
        recipe::Recipe,
        streams::{self, Purpose},
        sub_plate::{Crust, MaterialArea, Thickness},
        topology::EdgeState,
    },
    erode::continental_height,
    reorganize_plates::Outline,
};
use crate::mesh::SphereMesh;

/// Spacing in km at which the share that rain carries is stated: Tectonics.js has 10,000 cells.
const RAIN_SPACING: f64 = 226.0;
/// Largest share of a difference that one round carries; more would overshoot.
const MOST_SHARE: f64 = 0.25;
/// Most rounds in one tick: enough for the finest meshes, and an end for the wildest constants.
const MOST_ROUNDS: f64 = 256.0;
/// Frequency of the low-frequency noise, per radius.
const SWELL_FREQUENCY: f32 = 1.0;

/// Wears continents in proportion to their elevation and raises what is submerged by the same law, as
/// far as the rock goes (Cortial et al. 2019, section 4.5). Returns the volume in km³ that is lost to
/// the deep sea.
pub(in crate::simulation) fn wear_by_elevation(
    recipe: &Recipe,
    crust: &[Crust],
    thickness: &mut [Thickness],
    area: &[MaterialArea],
    sea_level: f64,
    time: f64,
) -> f64 {
    let constants = &recipe.constants.erosion;
    let mut pool = 0.0;
    let mut room = Vec::new();
    for v in 0..crust.len() {
        if !crust[v].is_continental() {
            continue;
        }
        let height = continental_height(constants, thickness[v].0) - sea_level;
        let wear = continental_wear(&recipe.constants.laws, 1e-3 * height, time);
        let rock = 1e3 * wear / constants.isostasy;
        if rock > 0.0 {
            let rock = rock.min(thickness[v].0);
            thickness[v].0 -= rock;
            pool += rock * area[v].0;
        } else {
            room.push((v, -rock * area[v].0));
        }
    }
    let whole: f64 = room.iter().map(|(_, room)| room).sum();
    let laid = pool.min(whole);
    if whole > 0.0 {
        for (v, room) in room {
            thickness[v].0 += laid * room / whole / area[v].0;
        }
    }
    pool - laid
}

/// Carries a share of every difference in height to the lower neighbours, by the rain that falls there
/// (Tectonics.js). Below the sea all is level. Returns the volume in km³ that is lost to the deep sea.
pub(in crate::simulation) fn wear_by_rain(
    recipe: &Recipe,
    mesh: &SphereMesh<EdgeState>,
    crust: &[Crust],
    thickness: &mut [Thickness],
    area: &[MaterialArea],
    sea_level: f64,
    time: f64,
) -> f64 {
    let scale = RAIN_SPACING / recipe.spacing_km();
    let shares: Vec<f64> = mesh
        .sites()
        .iter()
        .map(|site| {
            let latitude = libm::asin(site.z.clamp(-1.0, 1.0));
            rain_share(&recipe.constants.laws, latitude, time) * scale * scale
        })
        .collect();
    let most = shares.iter().copied().fold(0.0, f64::max);
    let rounds = (most / MOST_SHARE).ceil().clamp(1.0, MOST_ROUNDS);
    let mut lost = 0.0;
    for _ in 0..rounds as usize {
        let heights: Vec<f64> = crust
            .iter()
            .zip(thickness.iter())
            .map(|(crust, thickness)| {
                let height = continental_height(&recipe.constants.erosion, thickness.0);
                if crust.is_continental() {
                    (1e-3 * (height - sea_level)).max(0.0)
                } else {
                    0.0
                }
            })
            .collect();
        for v in (0..heights.len()).filter(|&v| heights[v] > 0.0) {
            let degree = mesh.neighbours(v as u32).count() as f64;
            for w in mesh.neighbours(v as u32).map(|w| w as usize) {
                let drop = heights[v] - heights[w];
                if drop <= 0.0 {
                    continue;
                }
                // Of the smaller cell, so that neither is turned upside down.
                let share = (shares[v] / rounds).min(MOST_SHARE);
                let volume = share * drop / degree * area[v].0.min(area[w].0);
                // Above a deep sea land may stand higher than its crust is thick.
                let volume = volume.min(thickness[v].0 * area[v].0);
                thickness[v].0 -= volume / area[v].0;
                if crust[w].is_continental() {
                    thickness[w].0 += volume / area[w].0;
                } else {
                    lost += volume;
                }
            }
        }
    }
    lost
}

/// Adds low-frequency noise to heights in m. It stays where it is while plates pass over it, as the
/// swells above the mantle's flow do.
pub(in crate::simulation) fn swell(
    recipe: &Recipe,
    mesh: &SphereMesh<EdgeState>,
    heights: &mut [f64],
) {
    let mut rng = streams::stream(recipe.seed, Purpose::Swell, 0, 0);
    let noise = Outline::new(&mut rng, SWELL_FREQUENCY);
    for (height, site) in heights.iter_mut().zip(mesh.sites()) {
        *height += recipe.constants.laws.noise * noise.at(*site);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::fixtures::random_mesh;
    use glam::DVec3;

    fn octahedron() -> SphereMesh<EdgeState> {
        let [x, y, z] = DVec3::AXES;
        SphereMesh::build(vec![x, y, z, -x, -y, -z]).unwrap()
    }

    #[test]
    fn elevation_wears_high_land_and_fills_low() {
        let recipe = Recipe::default();
        // 155 m/km · (h − 34.7 km): 44.7 km stands at 1550 m, 24.7 km at −1550 m.
        let mut thickness = [Thickness(44.7), Thickness(24.7), Thickness(7.0)];
        let crust = [Crust::Continental, Crust::Continental, Crust::Oceanic];
        let area = [
            MaterialArea(300.0),
            MaterialArea(100.0),
            MaterialArea(100.0),
        ];
        let lost = wear_by_elevation(&recipe, &crust, &mut thickness, &area, 0.0, 2.0);
        // 1.55/10 · 0.03 · 2 = 0.0093 km of height, 9.3/155 = 0.06 km of rock: 18 km³. The low cell
        // takes as much per area, 6 km³.
        assert!((thickness[0].0 - 44.64).abs() < 1e-9);
        assert!((thickness[1].0 - 24.76).abs() < 1e-9);
        assert_eq!(thickness[2].0, 7.0);
        assert!((lost - 12.0).abs() < 1e-9);
    }

    #[test]
    fn rain_carries_rock_downhill_and_loses_none_unseen() {
        let mesh = octahedron();
        let recipe = Recipe::default();
        let mut crust = [Crust::Continental; 6];
        crust[3] = Crust::Oceanic;
        crust[1] = Crust::Oceanic;
        let mut thickness = [Thickness(45.6); 6];
        thickness[2] = Thickness(55.6);
        let area = [MaterialArea(1000.0); 6];
        let volume = |thickness: &[Thickness]| -> f64 {
            (0..6)
                .filter(|&v| crust[v].is_continental())
                .map(|v| thickness[v].0 * area[v].0)
                .sum()
        };
        let before = volume(&thickness);
        let lost = wear_by_rain(&recipe, &mesh, &crust, &mut thickness, &area, 0.0, 0.1);
        assert!(lost > 0.0);
        assert!((before - volume(&thickness) - lost).abs() < 1e-6);
        assert!(thickness[2].0 < 55.6 && thickness[1].0 == 45.6);
    }

    #[test]
    fn rain_shares_a_drop_out_among_the_neighbours() {
        let (mesh, recipe) = (octahedron(), Recipe::default());
        // A peak of 1.55 km at the equator, all else at the level of the sea. One of its neighbours is
        // sea floor, one a small cell.
        let mut crust = [Crust::Continental; 6];
        crust[1] = Crust::Oceanic;
        let mut thickness = [Thickness(34.7); 6];
        thickness[0] = Thickness(44.7);
        let mut area = [MaterialArea(1000.0); 6];
        area[2] = MaterialArea(400.0);
        let lost = wear_by_rain(&recipe, &mesh, &crust, &mut thickness, &area, 0.0, 0.1);
        // Rain at the equator: (0.25 + 1.65 + 0.85 e⁻⁹)/0.8536 = 2.22599 of the mean. The share of it:
        // 1.8e-7 · 7.8e5 · 2.22599 · 0.1 = 0.0312529, times (226/225.846)² = 0.0312955. A quarter of
        // 0.0312955 · 1.55 km goes to each neighbour, over the smaller of both areas.
        let layer = 0.012_127;
        let expected = [
            44.7 - 3.4 * layer,
            34.7,
            34.7 + layer,
            34.7,
            34.7 + layer,
            34.7 + layer,
        ];
        for (thickness, expected) in thickness.iter().zip(expected) {
            assert!((thickness.0 - expected).abs() < 1e-6, "{thickness:?}");
        }
        assert!((lost - 1000.0 * layer).abs() < 1e-3);
    }

    #[test]
    fn noise_is_bounded_and_belongs_to_places_and_not_to_meshes() {
        // The fine mesh has the sites of the coarse one, and more.
        let coarse = random_mesh::<EdgeState>(500);
        let fine = random_mesh::<EdgeState>(1500);
        assert_eq!(coarse.sites(), &fine.sites()[..500]);
        let raised = |recipe: &Recipe, mesh: &SphereMesh<EdgeState>| {
            let mut heights = vec![100.0; mesh.vertex_count()];
            swell(recipe, mesh, &mut heights);
            heights
        };
        let mut recipe = Recipe::default();
        recipe.constants.laws.noise = 250.0;
        let heights = raised(&recipe, &fine);
        assert!(heights.iter().all(|h| (h - 100.0).abs() <= 250.0));
        assert!(heights.iter().any(|h| (h - 100.0).abs() > 10.0));
        assert_eq!(raised(&recipe, &coarse), heights[..500]);
        recipe.constants.laws.noise = 0.0;
        assert_eq!(raised(&recipe, &coarse), [100.0; 500]);
    }
}
