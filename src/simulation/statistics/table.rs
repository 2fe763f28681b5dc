//! Every measure in one table: its name, unit, meaning, and what Earth measures.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// What is known of a measure besides its value, for tables, charts and files.
#[derive(Debug, Clone, Copy)]
pub struct Measure {
    /// Name of its field in [`Statistics`].
    pub name: &'static str,
    /// Unit; empty for bare numbers.
    pub unit: &'static str,
    /// What Earth measures, with the source; empty where nothing compares.
    pub earth: &'static str,
    /// What it means.
    pub doc: &'static str,
    /// Its value.
    pub value: fn(&Statistics) -> f64,
}

/// A number of a table, as a number of a chart.
trait Figure {
    fn figure(&self) -> f64;
}

impl Figure for f64 {
    fn figure(&self) -> f64 {
        *self
    }
}

impl Figure for usize {
    fn figure(&self) -> f64 {
        *self as f64
    }
}

/// Declares the measures: the struct and what is known of its single figures.
macro_rules! measures {
    (
        $(#[doc = $struct_doc:literal])* $table:ident {
            $($(#[doc = $doc:literal])* $name:ident: $kind:ty, $unit:literal, $earth:literal;)*
        }
        $($(#[doc = $more_doc:literal])* $more:ident: $more_kind:ty;)*
    ) => {
        $(#[doc = $struct_doc])*
        #[derive(Resource, Debug, Clone, Default, PartialEq, Serialize, Deserialize, Reflect)]
        #[reflect(Resource, Default)]
        #[serde(default)]
        pub struct $table {
            $($(#[doc = $doc])*
            #[doc = concat!("\n\nUnit: ", $unit, ". Earth: ", $earth, ".")]
            pub $name: $kind,)*
            $($(#[doc = $more_doc])*
            pub $more: $more_kind,)*
        }

        impl $table {
            /// The single figures in the order of the table; distributions are not among them.
            pub const MEASURES: &'static [Measure] = &[$(Measure {
                name: stringify!($name),
                unit: $unit,
                earth: $earth,
                doc: concat!($($doc),*).trim_ascii(),
                value: |statistics| statistics.$name.figure(),
            },)*];
        }
    };
}

measures! {
    /// Figures of a planet at one moment, in the terms in which Earth is measured.
    ///
    /// Shares are of the sphere's area unless said otherwise, areas those of the sub-plates' Voronoi
    /// cells, speeds in km/My, which are mm/yr. A figure of which the planet has nothing (the mean
    /// height of land where there is none, the exponent of two plates) is 0.
    ///
    /// As a resource of the simulation's world it is the last measurement that was recorded or asked
    /// for ([`History::statistics`](crate::simulation::History::statistics)).
    ///
    /// Sources of Earth's figures: "relief" is a 5-minute table of global relief; "ETOPO1" means
    /// computed as here from the bedrock of ETOPO1 (NOAA 2009) averaged onto 1024 × 512 cells; "PB2002"
    /// computed from the plates, poles and boundary steps of Bird 2003.
    Statistics {
        /// Time since the start.
        time_my: f64, "My", "";
        /// Time over which rates of made and consumed sea floor are taken: since the moment recorded
        /// before, or since the start. 0 at the start.
        interval_my: f64, "My", "";

        /// Share above the sea.
        land_share: f64, "of the sphere", "0.297 (relief)";
        /// Share of continental crust, shelves included.
        continental_share: f64, "of the sphere", "0.41 (Cogley 1984)";
        /// Mean elevation of land.
        mean_land_m: f64, "m", "850 (textbooks)";
        /// Mean elevation of the sea floor.
        mean_ocean_m: f64, "m", "−3,730 (textbooks)";
        /// Highest sub-plate.
        highest_m: f64, "m", "8,849, the highest peak";
        /// Lowest sub-plate.
        lowest_m: f64, "m", "−10,935, the deepest trench";
        /// Middle of the fullest 500 m of elevation above −2,000 m.
        land_peak_m: f64, "m", "250 (relief)";
        /// Share of those 500 m.
        land_peak_share: f64, "of the sphere", "0.158 (relief)";
        /// Middle of the fullest 500 m of elevation below −2,000 m.
        ocean_peak_m: f64, "m", "−4,750 (relief)";
        /// Share of those 500 m.
        ocean_peak_share: f64, "of the sphere", "0.118 (relief)";
        /// Shelf down to 200 m.
        shelf_200_share: f64, "of the sphere", "0.051 (ETOPO1)";
        /// Shelf down to 500 m.
        shelf_500_share: f64, "of the sphere", "0.072 (relief)";
        /// Share above 2 km.
        above_2_km_share: f64, "of the sphere", "0.035 (relief), 0.015 without ice (ETOPO1)";
        /// Share below −6 km.
        below_6_km_share: f64, "of the sphere", "0.005 (relief)";
        /// Height of the sea's surface above the reference level of isostasy.
        sea_level_m: f64, "m", "";
        /// Box dimension of the coast over 1.5 to 6 spacings of the sub-plates.
        coastline_dimension: f64, "", "1.2, between 1.05 and 1.5 (Mandelbrot 1967)";
        /// Slope of the power of elevation per spherical-harmonic degree against the degree, from 5 to
        /// 24, both as logarithms.
        power_slope: f64, "", "−1.74 (ETOPO1), about −2 over longer ranges";

        /// Mean thickness of continental crust.
        continental_thickness_km: f64, "km", "30–50 (textbooks)";
        /// Mean thickness of oceanic crust.
        oceanic_thickness_km: f64, "km", "6–7 (textbooks)";
        /// Gathering of the continents: length of the mean position of continental crust, 0 to 1.
        continental_concentration: f64, "", "0.27 (ETOPO1)";
        /// What the books of continental crust do not explain, as a share of its volume: see
        /// [`Ledger::closing_error`](crate::simulation::Ledger::closing_error).
        ledger_gap: f64, "of the volume", "";

        /// Median elevation of the sea floor at spreading ridges, along their length.
        ridge_median_m: f64, "m", "−3,000 (age–depth literature)";
        /// Median of the sea floor's depth less −(2600 + 350 √age) m, up to an age of 70 My (Parsons &
        /// Sclater 1977): positive where too deep.
        age_depth_bias_m: f64, "m", "−255 (ETOPO1)";
        /// Median of the size of that difference.
        age_depth_error_m: f64, "m", "330 (ETOPO1)";
        /// Slope of depth against the root of age up to 70 My, by least squares.
        age_depth_slope: f64, "m/√My", "246 (ETOPO1), 350 without sediment and plateaus (Parsons & Sclater 1977)";
        /// Mean age of the sea floor.
        ocean_age_mean_my: f64, "My", "60 (Rowley 2002)";
        /// Oldest sea floor.
        ocean_age_oldest_my: f64, "My", "180, a few relicts up to 340 (Rowley 2002)";
        /// Age that 99.5 % of the sea floor have not reached: the oldest, less the relicts.
        ocean_age_995_my: f64, "My", "180 (Rowley 2002)";
        /// Largest distance of the cumulative ages from the triangular law that ends at 180 My
        /// (Kolmogorov–Smirnov): 0 agrees, even ages give 0.25.
        ocean_age_distance: f64, "", "0.04 (ETOPO1's age grid)";
        /// Sea floor made since the start, from the ledger.
        floor_made_km2: f64, "km²", "";
        /// Sea floor consumed since the start, from the ledger.
        floor_consumed_km2: f64, "km²", "";
        /// Sea floor made in a year over the last [`interval_my`](Self::interval_my), from the ledger.
        floor_made_km2_yr: f64, "km²/yr", "3.4 (Rowley 2002)";
        /// Sea floor consumed in a year over the same interval, from the ledger.
        floor_consumed_km2_yr: f64, "km²/yr", "3.4 (Rowley 2002)";
        /// Sea floor that the plates' motions make at ridges now: opening times length.
        spreading_km2_yr: f64, "km²/yr", "3.0 (PB2002)";
        /// Sea floor that the plates' motions push into trenches now: closing times length.
        subduction_km2_yr: f64, "km²/yr", "2.7 (PB2002)";

        /// Number of plates.
        plates: usize, "", "52 (Bird 2003)";
        /// Number of plates that hold 0.05 % of the sphere or more.
        large_plates: usize, "", "38 (PB2002)";
        /// Share of the largest plate.
        largest_plate: f64, "of the sphere", "0.21 (PB2002)";
        /// Share of the seven largest plates.
        largest_7_plates: f64, "of the sphere", "0.81 (PB2002)";
        /// Share of the fourteen largest plates.
        largest_14_plates: f64, "of the sphere", "0.95 (PB2002)";
        /// Median area of a plate.
        plate_area_median_km2: f64, "km²", "500,000 (PB2002)";
        /// Exponent b of the number of plates larger than A, which goes as Aᵇ: fitted to plates of 0.002
        /// to 1 steradian.
        plate_size_exponent: f64, "", "−0.33 (Bird 2003)";
        /// Mean speed over the area, without net rotation.
        speed_mean: f64, "mm/yr", "38 (PB2002)";
        /// Root of the mean squared speed over the area, without net rotation.
        speed_rms: f64, "mm/yr", "44 (PB2002)";
        /// Speed that a tenth of the area does not reach, without net rotation.
        speed_p10: f64, "mm/yr", "13 (PB2002)";
        /// Median speed over the area, without net rotation.
        speed_median: f64, "mm/yr", "30 (PB2002)";
        /// Speed that nine tenths of the area do not reach, without net rotation.
        speed_p90: f64, "mm/yr", "71 (PB2002)";
        /// Mean speed over the area of plates that are mostly oceanic.
        speed_oceanic_plates: f64, "mm/yr", "42, the Pacific plate 65 (PB2002)";
        /// Mean speed over the area of plates that are mostly continental.
        speed_continental_plates: f64, "mm/yr", "25, the Eurasian plate 24 (PB2002)";
        /// Share that moves by more than 1 mm/yr against the rigid rotation of its plate: soft margins.
        deforming_share: f64, "of the sphere", "0.14 (Kreemer et al. 2014)";

        /// Length of the boundaries between plates, zigzags of the mesh smoothed out.
        boundary_km: f64, "km", "260,000 (PB2002)";
        /// Length of the boundaries that open: within 60° of straight apart.
        opening_km: f64, "km", "95,000 (PB2002)";
        /// Length of the boundaries that slide: within 30° of their strike.
        sliding_km: f64, "km", "74,000 (PB2002)";
        /// Length of the boundaries that close: within 60° of head-on.
        closing_km: f64, "km", "92,000 (PB2002)";
        /// Mean slip of the boundaries that open on sea floor, along their length.
        slip_ridges: f64, "mm/yr", "47 (PB2002)";
        /// Mean slip of the boundaries that close with sea floor on one side at least.
        slip_trenches: f64, "mm/yr", "62 (PB2002)";
        /// Mean slip of the boundaries that slide with sea floor on one side at least.
        slip_transforms: f64, "mm/yr", "41 (PB2002)";
        /// Mean slip of the boundaries that close between continents.
        slip_collisions: f64, "mm/yr", "26 (PB2002)";
    }
    /// Share of the sphere by elevation in bins of 500 m from −11,000 m to 9,000 m; the outermost hold
    /// all beyond. Earth: [`EARTH_HYPSOMETRY_500_M`](Self::EARTH_HYPSOMETRY_500_M).
    hypsometry_500_m: Vec<f64>;
    /// Share of the sea floor by age in bins of 10 My from 0 to 300 My; the last holds all beyond.
    ocean_age_histogram_10_my: Vec<f64>;
    /// Share of the boundaries' length which opens, slides and closes (30° rule). Earth 0.36, 0.28,
    /// 0.35 (PB2002).
    boundary_shares: [f64; 3];
}
