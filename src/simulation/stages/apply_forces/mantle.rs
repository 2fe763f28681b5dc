//! Slow convection of the mantle, which gathers continents and drives them apart again.
//!
//! Two of the longest waves are kept, and the continents choose between them (Zhong et al. 2007, EPSL
//! 261; Gurnis 1988, Nature 332; Mitchell et al. 2012, Nature 482):
//!
//! - Slabs sink where continents come together. One hemisphere's downwelling draws the rest of them in
//!   (degree 1), until they form a supercontinent over it.
//! - A supercontinent insulates the mantle, and warmth gathers under it. Once that is enough, a
//!   superplume rises there, opposite to the old upwelling, and the flow turns to the girdle between the
//!   two (degree 2). The supercontinent breaks up; what insulated is gone, and the plume dies down.
//!
//! The flow drags at what reaches into it, the deep roots of continents and slabs: oceanic plates glide on their
//! asthenosphere. What resists a slab resists its moving against the flow: plates hasten with it towards where it
//! sinks, and are held back where they go under against it.

use super::super::super::{
    clock::Clock,
    columns::Columns,
    error::TectonicError,
    recipe::Recipe,
    streams::{self, Purpose},
    sub_plate::{Crust, MaterialArea, SubPlate},
    topology::Topology,
};
use bevy::prelude::*;
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// Concentration of the continents at which a downwelling under them is well ordered.
const ORDERED: f64 = 0.1;
/// Concentration of a supercontinent. Smaller gatherings let heat out between them: they warm the
/// mantle by the square of theirs.
const SUPERCONTINENT: f64 = 0.5;
/// Warmth at which a superplume dies down, and at which one rises.
const PLUME_WARMTH: core::ops::Range<f64> = 0.3..1.0;
/// A superplume weaker than this still moves with what warms it.
const ROOTED: f64 = 0.1;

/// Heat and flow of the mantle.
#[derive(Resource, Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, Reflect)]
#[reflect(Resource)]
pub struct Mantle {
    /// Points to where the mantle sinks; of length 0 to 1, full vigour.
    pub downwelling: DVec3,
    /// Points to the middle of the superplume, opposite to another; of length 0 (none) to 1.
    pub superplume: DVec3,
    /// Warmth stored under the continents; 1 lets a superplume rise.
    pub warmth: f64,
    /// Whether a superplume is rising rather than dying down.
    pub rising: bool,
}

impl Mantle {
    /// The mantle of a new planet: it sinks somewhere.
    pub(in crate::simulation) fn new(seed: u64) -> Self {
        let mut rng = streams::stream(seed, Purpose::Mantle, 0, 0);
        Self {
            downwelling: streams::direction(&mut rng),
            ..default()
        }
    }

    /// A step of some My under continents whose mean position is `gathering`.
    fn convect(&mut self, gathering: DVec3, time: f64, recipe: &Recipe) {
        let constants = &recipe.constants.mantle;
        let concentration = gathering.length();
        // Exact where continents rest: dw/dt = (c/c₀)² / t_heat − w / t_cool.
        let kept = libm::exp(-time / constants.cooling);
        let fed = concentration / SUPERCONTINENT;
        let lasting = fed * fed * constants.cooling / constants.heating;
        self.warmth = self.warmth * kept + lasting * (1.0 - kept);
        self.rising =
            self.warmth > PLUME_WARMTH.end || (self.rising && self.warmth > PLUME_WARMTH.start);

        let turned = 1.0 - libm::exp(-time / constants.rise);
        let ordered = gathering / (concentration * concentration + ORDERED * ORDERED).sqrt();
        self.downwelling = self.downwelling.lerp(ordered, turned);
        let strength = self.superplume.length();
        let place = if strength < ROOTED {
            gathering
        } else {
            self.superplume
        };
        let target = f64::from(u8::from(self.rising));
        self.superplume = place.normalize_or_zero() * (strength + (target - strength) * turned);
    }

    /// How warm it is under a place, from −1 to 1: most over a superplume, least over a downwelling.
    #[must_use]
    pub fn warmth_at(&self, site: DVec3) -> f64 {
        let strength = self.superplume.length();
        let along = self.superplume.normalize_or_zero().dot(site);
        strength * (1.5 * along * along - 0.5) - (1.0 - strength) * self.downwelling.dot(site)
    }

    /// Flow at a place, in units of its full speed.
    pub(super) fn flow(&self, site: DVec3) -> DVec3 {
        let strength = self.superplume.length();
        let plume = self.superplume.normalize_or_zero();
        self.downwelling.reject_from_normalized(site) * (1.0 - strength)
            - plume.reject_from_normalized(site) * (2.0 * strength * site.dot(plume))
    }

    /// `Σ w r × u` for the flow u, in units of its full speed, from the moments `Σ w r` and
    /// `Σ w r rᵀ` of what it drags at.
    ///
    /// Degree 1: `u = d − r (r·d)`, so `(Σ w r) × d`. Degree 2: `u = −2 (r·p) (p − r (r·p))`, which is 1
    /// half-way to the girdle, so `−2 (Σ w r rᵀ p) × p`.
    pub(super) fn torque(&self, first: DVec3, second: DMat3) -> DVec3 {
        let strength = self.superplume.length();
        let plume = self.superplume.normalize_or_zero();
        first.cross(self.downwelling) * (1.0 - strength)
            - (second * plume).cross(plume) * (2.0 * strength)
    }
}

/// Warms the mantle under continents and lets it flow.
pub(in crate::simulation) fn convect_mantle(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    topology: Res<Topology>,
    mut mantle: ResMut<Mantle>,
    mut sub_plates: Query<(&Crust, &MaterialArea), With<SubPlate>>,
) -> Result<(), TectonicError> {
    let Some(time) = clock.geology.due() else {
        return Ok(());
    };
    let mesh = &topology.0;
    let (crust, area) = sub_plates.columns(mesh.vertex_count())?;
    let (mut sum, mut whole) = (DVec3::ZERO, 0.0);
    for v in (0..crust.len()).filter(|&v| crust[v].is_continental()) {
        sum += mesh.site(v as u32) * area[v].0;
        whole += area[v].0;
    }
    if whole > 0.0 {
        mantle.convect(sum / whole, time, &recipe);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rest(mantle: &mut Mantle, recipe: &Recipe, gathering: DVec3, time: f64) {
        for _ in 0..(time / 4.0) as u32 {
            mantle.convect(gathering, 4.0, recipe);
        }
    }

    #[test]
    fn a_supercontinent_raises_a_superplume_and_its_breakup_ends_it() {
        let mut recipe = Recipe::default();
        recipe.constants.mantle.heating = 100.0;
        recipe.constants.mantle.cooling = 200.0;
        recipe.constants.mantle.rise = 50.0;
        let mut mantle = Mantle::new(1);
        // w = 2 (1 − e^(−t/200)) reaches 1 after 200 ln 2 = 139 My.
        rest(&mut mantle, &recipe, DVec3::X * 0.5, 136.0);
        assert!((mantle.warmth - 2.0 * (1.0 - libm::exp(-0.68))).abs() < 1e-9);
        assert!(!mantle.rising && mantle.downwelling.x > 0.8, "{mantle:?}");
        rest(&mut mantle, &recipe, DVec3::X * 0.5, 200.0);
        assert!(mantle.rising && mantle.superplume.x > 0.9, "{mantle:?}");
        assert!(mantle.warmth_at(DVec3::X) > 0.8 && mantle.warmth_at(DVec3::Y) < 0.0);
        // It stays rooted when the continents leave, and dies when its warmth is spent.
        rest(&mut mantle, &recipe, DVec3::Y * 0.1, 100.0);
        assert!(mantle.rising && mantle.superplume.y == 0.0);
        rest(&mut mantle, &recipe, DVec3::Y * 0.1, 500.0);
        assert!(
            !mantle.rising && mantle.superplume.length() < 0.05,
            "{mantle:?}"
        );
    }

    #[test]
    fn the_flow_draws_in_and_drives_apart() {
        let site = DVec3::new(0.6, 0.8, 0.0);
        let outer = DMat3::from_cols(site * site.x, site * site.y, site * site.z);
        let mut mantle = Mantle {
            downwelling: DVec3::X,
            ..default()
        };
        // Towards X: r × u = r × X = −0.8 Z.
        let drawn = mantle.torque(site, outer);
        assert!((drawn - DVec3::Z * -0.8).length() < 1e-12);
        // Away from X: −2 (r·X)(r × X) = −2 · 0.6 · −0.8 Z = 0.96 Z.
        mantle.superplume = DVec3::X;
        let driven = mantle.torque(site, outer);
        assert!((driven - DVec3::Z * 0.96).length() < 1e-12);
        // Half-way through, each place turns as it flows there.
        mantle.superplume = DVec3::new(0.3, 0.0, 0.4);
        let flow = mantle.flow(site);
        assert!((site.cross(flow) - mantle.torque(site, outer)).length() < 1e-12);
        assert!(flow.dot(site).abs() < 1e-12 && flow.length() > 0.3);
    }
}
