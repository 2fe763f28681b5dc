//! Constants of the other drives, of published laws and of hot spots.

use super::{ConstantGroup, ConstantInfo, TectonicError};
use serde::{Deserialize, Serialize};

constants! {
    /// The drive by foundering sea floor (Tectonics.js).
    FounderingConstants("foundering") {
        /// Density of sea floor at the ridge.
        young_density = 2890.0 in 2500.0..=3300.0 "kg/m³",
        /// Density of the oldest sea floor.
        old_density = 3300.0 in 2900.0..=3600.0 "kg/m³",
        /// Age at which sea floor is that dense; in between its density grows evenly.
        old_age = 250.0 in 20.0..=1000.0 "My",
        /// Density of the mantle beneath: what is denser founders, here from 113 My on.
        mantle_density = 3075.0 in 2800.0..=3500.0 "kg/m³",
        /// Length over which the mantle passes the pull on, √(diffusivity × time). Shorter ones leave
        /// the middle of plates at rest (calibrated).
        diffusion_length = 2000.0 in 200.0..=8000.0 "km",
        /// Speed of the mantle for a gradient of buoyancy of 1 N/m³ per 1,000 km. Tectonics.js gives
        /// none; this one holds the mean speed near Earth's (calibrated).
        mobility = 2.0 in 0.01..=100.0 "km/My",
        /// Firmness with which plates hold each other where continents have interpenetrated by
        /// `motion.collision_length` along the whole of their front (calibrated).
        resistance = 5.0 in 0.0..=1000.0 "",
        /// Speed that no plate exceeds.
        fastest = 150.0 in 10.0..=500.0 "km/My",
        /// Time between two segmentations of the mantle's flow into plates.
        interval = 150.0 in 4.0..=2000.0 "My",
        /// Share of a segmentation's plates that must be left; where fewer are, it is repeated early.
        /// Tectonics.js has no sutures that could make them fewer.
        fewest = 0.8 in 0.0..=1.0 "of the segments",
        /// Shortest time between two segmentations.
        rest = 40.0 in 4.0..=500.0 "My",
        /// Most plates that a segmentation makes; trenches and sutures leave about 7.
        segments = 10.0 in 2.0..=60.0 "plates",
        /// Largest angle between the rotation of a place and that of its segment's fastest place.
        spread = 60.0 in 5.0..=120.0 "°",
        /// Radius by which the borders of segments are opened and closed (or 1.1 spacings): necks and
        /// bays narrower than twice as much vanish.
        rounding = 500.0 in 0.0..=3000.0 "km",
    }
}

constants! {
    /// The drive by prescribed rotations (Cortial et al. 2019, section 4.1).
    PrescribedConstants("prescribed") {
        /// Turn of a plate's axis by slab pull, ε, per length of its trenches. The paper gives none;
        /// 0.1 · plates / points, which others use, is this at 24 plates, 10,000 points and a point
        /// for every 226 km.
        slab_turn = 1.0e-6 in 0.0..=1.0e-3 "rad per km and My",
        /// Largest speed of a plate, v₀ (its Table 3).
        fastest = 100.0 in 1.0..=500.0 "km/My",
        /// Least speed at which the halves of a rift part and foundering sea floor sets out.
        first_slowest = 30.0 in 0.0..=200.0 "km/My",
        /// Largest such speed.
        first_fastest = 100.0 in 0.0..=200.0 "km/My",
    }
}

constants! {
    /// Published laws: the constants of Cortial et al. 2019, Table 3, of Yggdrasill and of Tectonics.js.
    LawConstants("laws") {
        /// Highest elevation of a ridge, `z_r`.
        ridge_elevation = -1.0 in -5.0..=0.0 "km",
        /// Elevation of abyssal plains, `z_a` (Yggdrasill's is the same).
        abyss_elevation = -6.0 in -9.0..=-2.0 "km",
        /// Elevation of trenches, `z_t`.
        trench_elevation = -10.0 in -20.0..=-6.0 "km",
        /// Highest elevation of continents, `z_c`.
        highest_elevation = 10.0 in 2.0..=30.0 "km",
        /// Damping of the elevation of sea floor, `ε_o`.
        sea_floor_damping = 0.04 in 0.0..=10.0 "km/My",
        /// Uplift at subduction, u₀.
        uplift = 0.6 in 0.0..=10.0 "km/My",
        /// Distance from the trench at which that uplift is largest. The paper draws it without a
        /// figure; this is what others have used.
        uplift_peak = 640.0 in 50.0..=2000.0 "km",
        /// Distance from the trench at which it ends, `r_s`.
        subduction_distance = 1800.0 in 100.0..=5000.0 "km",
        /// Speed to which speeds are compared, v₀.
        reference_speed = 100.0 in 10.0..=500.0 "km/My",
        /// Largest reach of a collision, `r_c`.
        collision_distance = 4200.0 in 100.0..=10000.0 "km",
        /// Surge of elevation in a collision, `Δ_c`, per area of the terrane.
        collision = 1.3e-5 in 0.0..=1.0e-3 "km/km²",
        /// Erosion of the highest land, `ε_c`.
        erosion = 0.03 in 0.0..=5.0 "km/My",
        /// Sediment that trenches take, `ε_t`.
        sediment = 0.3 in 0.0..=5.0 "km/My",
        /// Amplitude of the low-frequency noise. The paper gives none; on Earth the mantle's flow lifts
        /// and lowers the surface by about as much.
        noise = 250.0 in 0.0..=2000.0 "m",
        /// Mean rain (Tectonics.js: the mean over Earth's land).
        precipitation = 7.8e5 in 0.0..=1.0e7 "m/My",
        /// Share of a difference in height that a metre of rain carries off (Tectonics.js).
        rain_erosion = 1.8e-7 in 0.0..=1.0e-5 "/m",
    }
}

constants! {
    /// Plumes, and the islands they raise.
    HotSpotConstants("hot_spots") {
        /// Magma that a hot spot could deliver onto normal sea floor. A volcano's own height holds half
        /// of it back, which leaves less than Hawaii's 0.1-0.2 km³ a year (Poland et al. 2012), the strongest.
        flux = 1.0e5 in 0.0..=5.0e6 "km³/My",
        /// How much stronger or weaker than that hot spots are at most.
        flux_spread = 0.5 in 0.0..=0.95 "of the flux",
        /// Radius (standard deviation) of the ground that a hot spot feeds, or half a spacing where that
        /// is more: then the chain is as high, but wider. The feet of the Hawaiian
        /// ridge lie 150-200 km apart.
        radius = 70.0 in 20.0..=600.0 "km",
        /// Height of volcanoes per km of lava spread evenly. Cones stand three times their mean height
        /// and cover half of the ground, less what the plate yields under them (Hawaii: 9 km above its
        /// floor on 11 km of added crust).
        relief = 750.0 in 100.0..=2000.0 "m/km",
        /// Height above the sea that volcanoes approach but do not reach (Mauna Kea 4.2 km, as the mean
        /// of a chain's crest less).
        highest = 3000.0 in 0.0..=10000.0 "m",
        /// Height of the swell of hot mantle beneath the youngest islands (Crough 1983: 0.5-1.5 km).
        swell = 1000.0 in 0.0..=3000.0 "m",
        /// Distance from the hot spot at which the swell has run out (Crough 1983: swells are 1,000-1,500 km
        /// across).
        swell_radius = 600.0 in 0.0..=3000.0 "km",
        /// Time in which the swell cools away behind the hot spot (Detrick & Crough 1978: some 40 My
        /// to the last tenth).
        swell_time = 20.0 in 1.0..=200.0 "My",
        /// Time in which rain and waves wear an island down to the sea (Hawaiian islands drown 7 to 10 My
        /// after their last lava).
        wear_time = 5.0 in 0.5..=100.0 "My",
        /// Share of the flux that thickens a continent.
        continental = 0.05 in 0.0..=1.0 "",
    }
}
