//! The surge of elevation around a terrane that docks (Cortial et al. 2019, section 4.2), as
//! thickness by isostasy. It is booked as magma: the paper adds it without taking it from anywhere.

use super::super::super::{
    laws::collision::{collision_fold, collision_reach, collision_surge},
    ledger::Ledger,
    reach::reach,
    recipe::Recipe,
    sub_plate::{Crust, FoldDirection, MaterialArea, Orogeny, OrogenyBegan, Thickness},
    topology::EdgeState,
    workers::Workers,
};
use crate::mesh::SphereMesh;
use glam::DVec3;

/// Columns that a surge writes.
pub(super) struct Uplands<'a> {
    pub thickness: &'a mut [Thickness],
    pub orogeny: &'a mut [Orogeny],
    pub began: &'a mut [OrogenyBegan],
    pub fold: &'a mut [FoldDirection],
}

/// Raises the continent around a terrane that arrives with a speed in km/My.
pub(super) fn raise(
    recipe: &Recipe,
    mesh: &SphereMesh<EdgeState>,
    terrane: &[u32],
    speed: f64,
    now: f64,
    crust: &[Crust],
    area: &[MaterialArea],
    uplands: &mut Uplands,
    ledger: &mut Ledger,
) {
    let laws = &recipe.constants.laws;
    let size: f64 = terrane.iter().map(|&v| area[v as usize].0).sum();
    let sphere = 4.0 * core::f64::consts::PI * recipe.radius_km * recipe.radius_km;
    let far = collision_reach(laws, speed, size, sphere / f64::from(recipe.plates));
    let centroid: DVec3 = terrane
        .iter()
        .map(|&v| mesh.site(v) * area[v as usize].0)
        .sum();
    let centroid = centroid.normalize_or_zero();
    let sources: Vec<(u32, f64)> = terrane.iter().map(|&v| (v, 0.0)).collect();
    let around = reach(
        &Workers::default(),
        mesh,
        recipe.radius_km,
        &sources,
        far,
        |v| crust[v as usize].is_continental(),
    );
    for (v, distance, _) in around.found {
        let site = mesh.site(v);
        let v = v as usize;
        let surge = collision_surge(laws, size, distance, far);
        if surge <= 0.0 {
            continue;
        }
        let room = (recipe.constants.collisions.thickest - uplands.thickness[v].0).max(0.0);
        let fresh = (1e3 * surge / recipe.constants.erosion.isostasy).min(room);
        uplands.thickness[v].0 += fresh;
        ledger.arc_magma_km3 += fresh * area[v].0;
        uplands.orogeny[v] = Orogeny::Himalayan;
        uplands.began[v].0 = now as f32;
        uplands.fold[v].0 = collision_fold(site, centroid).as_vec3();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::fixtures::random_mesh;

    #[test]
    fn the_surge_is_highest_at_the_terrane_and_booked() {
        let mesh = random_mesh::<EdgeState>(2000);
        let mut recipe = Recipe::earth_like(1).with_sub_plates(2000);
        recipe.plates = 10;
        let crust: Vec<Crust> = mesh
            .sites()
            .iter()
            .map(|site| {
                if site.x > 0.0 {
                    Crust::Continental
                } else {
                    Crust::Oceanic
                }
            })
            .collect();
        // A terrane of some 20 cells of 5,000 km²: 1.3e-5 · 1e5 = 1.3 km of surge at its places.
        let terrane: Vec<u32> = (0..2000)
            .filter(|&v| mesh.site(v).distance(DVec3::X) < 0.2)
            .collect();
        let area = vec![MaterialArea(1e5 / terrane.len() as f64); 2000];
        recipe.constants.laws.collision_distance = 1e4;
        recipe.radius_km = 1000.0;
        let mut thickness = vec![Thickness(35.0); 2000];
        let mut orogeny = vec![Orogeny::default(); 2000];
        let mut began = vec![OrogenyBegan::default(); 2000];
        let mut fold = vec![FoldDirection::default(); 2000];
        let mut ledger = Ledger::default();
        let mut uplands = Uplands {
            thickness: &mut thickness,
            orogeny: &mut orogeny,
            began: &mut began,
            fold: &mut fold,
        };
        raise(
            &recipe,
            &mesh,
            &terrane,
            100.0,
            50.0,
            &crust,
            &area,
            &mut uplands,
            &mut ledger,
        );
        let risen: Vec<f64> = thickness.iter().map(|t| t.0 - 35.0).collect();
        let expected = 1300.0 / recipe.constants.erosion.isostasy;
        for &v in &terrane {
            assert!((risen[v as usize] - expected).abs() < 1e-9);
            assert_eq!(orogeny[v as usize], Orogeny::Himalayan);
        }
        // 1e4 · 1 · 1e5/(4π · 1e6/10) = 795.8 km: less beyond the terrane, nothing on sea floor.
        let mut outside = 0;
        for v in (0..2000).filter(|v| !terrane.contains(v)) {
            let land = crust[v as usize].is_continental();
            let gained = risen[v as usize];
            assert!(gained < expected && (land || gained == 0.0));
            if gained > 0.0 {
                outside += 1;
                let away = mesh.site(v) - DVec3::X;
                assert!(fold[v as usize].0.as_dvec3().dot(away) > 0.0);
            }
        }
        assert!(outside > 20, "{outside}");
        let booked: f64 = risen.iter().map(|gain| gain * area[0].0).sum();
        assert!((ledger.arc_magma_km3 - booked).abs() < 1e-6 * booked);
    }
}
