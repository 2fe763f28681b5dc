//! Constants of what raises and lowers the ground.

use super::{ConstantGroup, ConstantInfo, TectonicError};
use serde::{Deserialize, Serialize};

constants! {
    /// Arcs, trenches, plateaus.
    UpliftConstants("uplift") {
        /// Magma of an arc at 60 km/My of convergence, per km of trench.
        arc_flux = 80.0 in 0.0..=500.0 "km³/km/My",
        /// Distance of the arc's front from the trench: none of the magma rises nearer (Earth: slabs feed
        /// volcanoes from some 100 km of depth, 100-250 km behind the trench).
        arc_front = 140.0 in 0.0..=800.0 "km",
        /// Rock that a plate going under at 60 km/My scrapes off the fore-arc's base, per km of trench, until a
        /// wedge is left (Clift & Vannucchi 2004, Stern 2011: 1.4-1.7 km³/yr over 42,000 km of trench).
        subduction_erosion = 35.0 in 0.0..=500.0 "km³/km/My",
        /// Distance of the arc's crest from the trench.
        arc_distance = 200.0 in 50.0..=800.0 "km",
        /// Distance at which arc magmatism ends (central Andes: some 400 km). A wider band raises hills where
        /// mountains stand.
        arc_reach = 420.0 in 100.0..=2000.0 "km",
        /// Share of the flux that thickens oceanic crust.
        /// More of it stays the thicker the crust is, all of it in a whole continent.
        arc_oceanic = 0.3 in 0.0..=1.0 "",
        /// Thickness at which an oceanic arc becomes continental crust.
        arc_accretion = 18.0 in 10.0..=40.0 "km",
        /// Feedback of the continental volume on arc magmatism, so that continents neither grow nor shrink for
        /// ever. Where they have grown, rivers build margins out less by the same measure.
        arc_feedback = 14.0 in 0.0..=50.0 "per relative excess",
        /// Depth of a trench's axis below its plate at 40 km/My (Earth up to 5 km).
        trench_depth = 5000.0 in 0.0..=6000.0 "m",
        /// Distance from the axis at which the sinking plate lies undisturbed (Earth 100-200 km).
        trench_width = 150.0 in 10.0..=500.0 "km",
        /// Depth at the axis by which the slab draws down the continental crust above it at 40 km/My: the inner
        /// wall of the trench, and the basins of the fore-arc (Earth's crust lies at -2.9, -1.7, -1.0 and -0.6 km on
        /// average 25, 75, 125 and 175 km behind its edge at active margins).
        forearc_depth = 2300.0 in 0.0..=6000.0 "m",
        /// Distance from the axis at which it ends.
        forearc_reach = 350.0 in 10.0..=1500.0 "km",
        /// Time in which a trench forms or fills.
        trench_time = 2.0 in 0.5..=50.0 "My",
        /// Crust thicker than this flows outwards (Tibet stands on 70 km).
        plateau_thickness = 55.0 in 40.0..=90.0 "km",
        /// Share of the excess that flows per My at a spacing of 226 km.
        plateau_flow = 0.02 in 0.0..=1.0 "/My",
        /// Crust thicker than this flows outwards once nothing presses it any more (old ranges on Earth stand
        /// on 40-45 km).
        collapse_thickness = 44.0 in 36.0..=90.0 "km",
        /// Share of that excess that flows per My at a spacing of 226 km: ranges collapse within some
        /// 20-50 My of the end of a collision (Dewey 1988).
        collapse_flow = 0.02 in 0.0..=1.0 "/My",
    }
}

constants! {
    /// Crust that goes under or is crushed.
    CollisionConstants("collisions") {
        /// A closing edge across a front shorter than this removes its losing end.
        edge = 0.7 in 0.3..=0.9 "spacings",
        /// The same, whatever the motion.
        edge_always = 0.42 in 0.1..=0.6 "spacings",
        /// A closing vertex nearer than this to the opposite side of its triangle removes the loser.
        height = 0.5 in 0.1..=0.8 "spacings",
        /// Both are this much smaller where the motion is near transform.
        transform_factor = 0.6 in 0.2..=1.0 "times",
        /// Opening as a share of the slip below which a boundary counts as near transform.
        transform_share = 0.25 in 0.0..=0.9 "of the slip",
        /// Reach over which crushed continental crust thickens both plates (or 1.8 spacings).
        spread = 400.0 in 100.0..=3000.0 "km",
        /// No crust is thickened beyond this.
        thickest = 70.0 in 40.0..=120.0 "km",
        /// Room of one cell that attracts crust fully.
        room = 20.0 in 1.0..=60.0 "km",
        /// Thickness of continental crust that is pushed onto sea floor where no room is left.
        obduction_thickness = 30.0 in 10.0..=50.0 "km",
    }
}

constants! {
    /// Wear, sediment, isostasy.
    ErosionConstants("erosion") {
        /// Rock worn off per My as a share of the height above base level (Ahnert 1970: 0.15 of the
        /// local relief, which is less than that height on plateaus). At 0.07 one planet of 10,000 sub-plates
        /// in eight has hardly any land above 2 km.
        rate = 0.06 in 0.0..=2.0 "/My",
        /// Slope of the base level inland from the shelf. At 0 land swings between 12 and 38 % (study); Earth's
        /// rises by 0.5 m/km from 850 to 1,750 km behind its crust's edge.
        base_slope = 0.45 in 0.0..=2.0 "m/km",
        /// Base level at the crust's edge.
        base_edge = -10.0 in -200.0..=500.0 "m",
        /// Highest base level (Earth's land: 700-800 m on average, 1,500-3,000 km behind its crust's edge).
        base_highest = 650.0 in 0.0..=2000.0 "m",
        /// Share of eroded rock that is lost to the deep sea at least.
        lost = 0.1 in 0.0..=1.0 "",
        /// Growth of that share with the continental volume. Continents that have grown raise the sea over their
        /// own shelves, which then take in all that rivers bring: without this the sea would stay high.
        lost_feedback = 4.0 in 0.0..=50.0 "per relative excess",
        /// Height gained per km of continental crust (Airy, with a mantle of 3,300 kg/m³).
        isostasy = 155.0 in 50.0..=400.0 "m/km",
        /// Thickness of continental crust whose surface lies at the reference level.
        reference_thickness = 34.7 in 20.0..=50.0 "km",
        /// Thickness of sediment on old sea floor.
        sediment_thickest = 450.0 in 0.0..=3000.0 "m",
        /// Sediment laid down on sea floor.
        sediment_rate = 3.0 in 0.0..=100.0 "m/My",
        /// Width of the shelf profile of an old margin in front of land that is 1,000 km broad; younger margins have
        /// sunk less, and narrower land feeds less (Earth 80 km on average, up to 400). Wider than what is drawn
        /// as sea: its inner part lies within metres of the sea level, and crust thins towards its edge.
        shelf_width = 700.0 in 0.0..=2000.0 "km",
        /// Width of the shelf profile between a trench and its arc (Earth: 50-200 km of fore-arc basins, and
        /// wide flooded shelves behind the arcs of Sunda and the East China Sea, which are not modelled).
        forearc_width = 260.0 in 0.0..=1000.0 "km",
        /// Depth of a margin's edge.
        shelf_depth = 190.0 in 0.0..=1000.0 "m",
        /// Width of the continental slope, where sediment slides off: crust that rifts stretched stays as
        /// deep there as it is (Earth: 100-200 km from the edge of the crust to that of the shelf).
        slope_width = 200.0 in 0.0..=1000.0 "km",
        /// Depth of the slope's foot below the shelf's edge (Earth: the median crust at 25 km from its edge
        /// lies at -2,550 m, at 75 km at -1,400 m).
        slope_depth = 3000.0 in 0.0..=5000.0 "m",
        /// Width of the wedge of sediment at the foot of a passive margin. Earth's sea floor stands 1.4, 0.9 and
        /// 0.6 km above what its age implies, 75, 250 and 600 km from the crust's edge.
        rise_width = 900.0 in 0.0..=2000.0 "km",
        /// Height of that wedge at the margin, once it is 60 My old (Earth: up to 2 km above the plain).
        rise_thickest = 1600.0 in 0.0..=5000.0 "m",
        /// Age from which sediment builds old margins out into the sea.
        margin_age = 115.0 in 0.0..=1000.0 "My",
        /// Speed at which it does, 40 My later, where half of the neighbours are continent; it grows
        /// with the square of the time. Embayments of old floor are buried, as the Gulf of Mexico and
        /// the Caspian are, before they grow older than any sea floor on Earth.
        margin_growth = 0.5 in 0.0..=50.0 "km/My",
        /// Time in which sediment fills a basin on continental crust to its base level.
        basin_time = 15.0 in 1.0..=500.0 "My",
        /// Time in which the middle of a margin relaxes to its shelf; at its edge it is shorter in proportion.
        shelf_time = 30.0 in 1.0..=500.0 "My",
    }
}
