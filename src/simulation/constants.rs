//! Every constant of the model, with its unit, domain, default and source.
//!
//! "Study" marks values calibrated by whole histories on one mesh, where no source publishes one.

use super::error::TectonicError;
use serde::{Deserialize, Serialize};

/// What is known of a constant besides its value, for programs that show or vary constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConstantInfo {
    /// Name of its field.
    pub name: &'static str,
    /// Unit; empty for bare numbers.
    pub unit: &'static str,
    /// Smallest value.
    pub lowest: f64,
    /// Largest value.
    pub highest: f64,
    /// Default.
    pub default: f64,
    /// What it means and where it comes from.
    pub doc: &'static str,
}

/// A group of constants as a table.
pub trait ConstantGroup {
    /// Name of its field in [`Constants`].
    fn name(&self) -> &'static str;

    /// What it is about.
    fn doc(&self) -> &'static str;

    /// What is known of each constant, in the order of the table.
    fn info(&self) -> &'static [ConstantInfo];

    /// A constant by its row in the table.
    fn value(&self, row: usize) -> Option<f64>;

    /// A constant by its row in the table, to be changed.
    fn value_mut(&mut self, row: usize) -> Option<&mut f64>;
}

/// Declares a group of constants: the struct, its defaults, its range check and what is known of them
/// in one table.
macro_rules! constants {
    ($(#[doc = $group_doc:literal])* $group:ident($path:literal) {
        $($(#[doc = $doc:literal])* $name:ident = $default:literal in $low:literal..=$high:literal $unit:literal,)*
    }) => {
        $(#[doc = $group_doc])*
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize, bevy::reflect::Reflect)]
        #[serde(default, deny_unknown_fields)]
        pub struct $group {
            $($(#[doc = $doc])*
            #[doc = concat!("\n\nUnit: ", $unit, ". Domain: ", stringify!($low), " to ", stringify!($high),
                ". Default: ", stringify!($default), ".")]
            pub $name: f64,)*
        }

        impl Default for $group {
            fn default() -> Self {
                Self { $($name: $default,)* }
            }
        }

        impl $group {
            pub(super) fn validate(&self) -> Result<(), TectonicError> {
                $(if !($low..=$high).contains(&self.$name) {
                    return Err(TectonicError::Recipe {
                        field: concat!("constants.", $path, ".", stringify!($name)).into(),
                        value: self.$name.to_string(),
                        allowed: concat!("between ", stringify!($low), " and ", stringify!($high), " ", $unit).into(),
                    });
                })*
                Ok(())
            }
        }

        crate::simulation::recipe::sparse::sparse!($group { $($name),* });

        impl ConstantGroup for $group {
            fn name(&self) -> &'static str {
                $path
            }

            fn doc(&self) -> &'static str {
                concat!($($group_doc),*).trim_ascii()
            }

            fn info(&self) -> &'static [ConstantInfo] {
                const INFO: &[ConstantInfo] = &[$(ConstantInfo {
                    name: stringify!($name),
                    unit: $unit,
                    lowest: $low,
                    highest: $high,
                    default: $default,
                    doc: concat!($($doc),*).trim_ascii(),
                },)*];
                INFO
            }

            fn value(&self, row: usize) -> Option<f64> {
                [$(self.$name),*].get(row).copied()
            }

            fn value_mut(&mut self, row: usize) -> Option<&mut f64> {
                [$(&mut self.$name),*].into_iter().nth(row)
            }
        }
    };
}

mod published;
mod relief;

pub use published::{FounderingConstants, HotSpotConstants, LawConstants, PrescribedConstants};
pub use relief::{CollisionConstants, ErosionConstants, UpliftConstants};

/// All constants, grouped by the stage that reads them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, bevy::reflect::Reflect)]
#[serde(default, deny_unknown_fields)]
pub struct Constants {
    /// Steps and clocks.
    pub step: StepConstants,
    /// Splitting and merging of cells.
    pub refine: RefineConstants,
    /// Kinds of boundary.
    pub boundaries: BoundaryConstants,
    /// Crust made at ridges and in rifts.
    pub ridges: RidgeConstants,
    /// Forces on plates.
    pub motion: MotionConstants,
    /// Slow flow of the mantle under continents and around slabs.
    pub mantle: MantleConstants,
    /// What deforms at the plates' margins.
    pub margins: MarginConstants,
    /// Arcs, trenches and mountain belts.
    pub uplift: UpliftConstants,
    /// Crust consumed and crushed.
    pub collisions: CollisionConstants,
    /// Wear, sediment and isostasy.
    pub erosion: ErosionConstants,
    /// Sutures, rifts, splinters and new trenches.
    pub plates: PlateConstants,
    /// Plates that old sea floor drags.
    pub foundering: FounderingConstants,
    /// Plates that keep their rotations.
    pub prescribed: PrescribedConstants,
    /// Published laws.
    pub laws: LawConstants,
    /// Plumes and the islands they raise.
    pub hot_spots: HotSpotConstants,
}

impl Constants {
    /// Says which constant lies outside its domain, if one does.
    ///
    /// # Errors
    /// [`TectonicError::Recipe`] with the first offending value.
    pub fn validate(&self) -> Result<(), TectonicError> {
        self.step.validate()?;
        self.refine.validate()?;
        self.boundaries.validate()?;
        self.ridges.validate()?;
        self.motion.validate()?;
        self.mantle.validate()?;
        self.margins.validate()?;
        self.uplift.validate()?;
        self.collisions.validate()?;
        self.erosion.validate()?;
        self.plates.validate()?;
        self.foundering.validate()?;
        self.prescribed.validate()?;
        self.laws.validate()?;
        self.hot_spots.validate()
    }

    /// The groups as tables.
    #[must_use]
    pub fn groups(&self) -> [&dyn ConstantGroup; 15] {
        [
            &self.step,
            &self.refine,
            &self.boundaries,
            &self.ridges,
            &self.motion,
            &self.mantle,
            &self.margins,
            &self.uplift,
            &self.collisions,
            &self.erosion,
            &self.plates,
            &self.foundering,
            &self.prescribed,
            &self.laws,
            &self.hot_spots,
        ]
    }

    /// The groups as tables whose values may be changed.
    #[must_use]
    pub fn groups_mut(&mut self) -> [&mut dyn ConstantGroup; 15] {
        [
            &mut self.step,
            &mut self.refine,
            &mut self.boundaries,
            &mut self.ridges,
            &mut self.motion,
            &mut self.mantle,
            &mut self.margins,
            &mut self.uplift,
            &mut self.collisions,
            &mut self.erosion,
            &mut self.plates,
            &mut self.foundering,
            &mut self.prescribed,
            &mut self.laws,
            &mut self.hot_spots,
        ]
    }
}

constants! {
    /// Length of a step and of the slower clocks.
    StepConstants("step") {
        /// Share of the local spacing that nothing may exceed in one step. Up to 0.35 hardly a face
        /// inverts before the collision stage looks at it; at 1.0 eleven a step do (study), and are repaired. From
        /// 0.25 to 0.8 planets of 10,000 sub-plates measure the same but for chance; at 0.7 those of 40,000 had
        /// less high ground on some seeds.
        courant = 0.6 in 0.05..=1.0 "spacings",
        /// Longest step, for planets that hardly move. At 2 some planets of 10,000 sub-plates had hardly any high
        /// ground.
        longest = 1.5 in 0.01..=5.0 "My",
        /// Interval of the slow stages (uplift, erosion). Heights change by metres in it.
        geology = 2.0 in 0.1..=20.0 "My",
        /// Interval at which plates are reorganised.
        reorganisation = 4.0 in 0.5..=50.0 "My",
    }
}

constants! {
    /// Resolution. A contrast of 1 keeps the mesh even; more makes dull sea floor coarse.
    RefineConstants("refine") {
        /// Area of a cell in dull places as a multiple of one at boundaries, coasts and mountains.
        /// Yggdrasill spans 10 to 1,000; an even mesh is the default because the start is even.
        contrast = 1.0 in 1.0..=16.0 "times",
        /// A cell larger than this many of its target is split.
        split_above = 2.4 in 1.5..=10.0 "targets",
        /// A cell smaller than this many of its target is merged into its neighbours.
        merge_below = 0.3 in 0.02..=0.6 "targets",
        /// Interval between sweeps for a spacing of 226 km, shorter in proportion on finer meshes: cells of bent
        /// margins shrink to nothing in some times this.
        interval = 4.0 in 0.5..=50.0 "My",
    }
}

constants! {
    /// The state machine of boundary kinds.
    BoundaryConstants("boundaries") {
        /// Opening or closing as a share of the slip beyond which a boundary is a ridge or a trench
        /// rather than a transform. sin 30° is the convention for Earth's plates (Bird 2003).
        normal_share = 0.5 in 0.05..=0.95 "of the slip",
        /// Hysteresis around that share: class changes fall from 0.066 to 0.035 per vertex and My (study).
        hysteresis = 0.15 in 0.0..=0.5 "of the slip",
        /// Weight of neighbours when the strike of a front is smoothed (two passes). Raw directions
        /// of edges make and eat crust at transforms at 20 % of their slip; smoothed ones 5 % (study).
        smoothing = 0.7 in 0.0..=1.0 "",
        /// A trench turns round where the overriding sea floor has become older than the sinking one
        /// by this much (as at the Solomon Islands). Less makes fronts flicker; without it small old
        /// plates override for ever.
        reversal = 90.0 in 10.0..=1000.0 "My",
        /// A front without contact for this long forgets which side subducts.
        memory = 20.0 in 1.0..=200.0 "My",
    }
}

constants! {
    /// New crust.
    RidgeConstants("ridges") {
        /// A boundary triangle whose circumradius exceeds this gets a new sub-plate. Decides the
        /// balance of crust made and consumed: 0.96 holds the number of sub-plates (study).
        gap = 0.94 in 0.7..=1.4 "spacings",
        /// Feedback of the number of sub-plates on that gap, so that their number stays.
        feedback = 3.0 in 0.0..=10.0 "per relative excess",
        /// Smallest distance between two new sub-plates.
        apart = 0.6 in 0.3..=0.9 "spacings",
        /// Length of ridge segments between transform faults (Earth: 50-1,000 km, slow ridges shorter).
        segment = 450.0 in 0.0..=5000.0 "km",
        /// The gap is this much wider where the motion is near transform.
        transform_factor = 1.25 in 1.0..=3.0 "times",
        /// The gap is this much wider where the boundary closes (a hole in the mesh, no ridge).
        closing_factor = 1.6 in 1.0..=4.0 "times",
        /// Opening as a share of the slip below which a boundary counts as near transform.
        transform_share = 0.25 in 0.0..=0.9 "of the slip",
        /// Thickness of new oceanic crust (Earth 6-7 km).
        oceanic_thickness = 7.0 in 3.0..=12.0 "km",
        /// How much thinner than its flanks stretched crust in a tearing rift is, at a spacing of 226 km.
        rift_thinning = 8.0 in 1.0..=30.0 "km",
        /// Stretched continental crust thinner than this breaks and sea floor begins.
        breakup_thickness = 17.0 in 8.0..=30.0 "km",
    }
}

constants! {
    /// Driving and resisting forces. One unit of force drags 1 km² of sea floor at 1 km/My.
    MotionConstants("motion") {
        /// Basal drag of oceanic lithosphere. The unit of all forces.
        ocean_drag = 1.0 in 0.1..=10.0 "per km² and km/My",
        /// Basal drag of continents, whose roots reach deeper. At 1.7 fine meshes have a median speed of 20 km/My.
        continent_drag = 1.2 in 0.1..=20.0 "per km² and km/My",
        /// Pull of a full slab of 80 My on its plate, per km of trench (Yggdrasill's 5e-8 m/yr² acts on single vertices
        /// and dilutes as the mesh is refined). Over the resistance that it meets it is the speed at which a slab
        /// sinks by itself where the mantle rests: 85 km/My, or some 60 as fronts zigzag and are longer than their
        /// trench. Earth's surface moves at 38 km/My on average and at 29 in the median. Less of it drives continents
        /// together with less force: at 1.8e6 a third less land lies above 2 km.
        slab_pull = 2.2e6 in 0.0..=1.0e7 "per km",
        /// Resistance of the mantle to a full slab that is drawn through it. It nearly balances the pull, so that
        /// plates with slabs move at the speed of sinking whatever their size (Forsyth & Uyeda 1975: 60-90 km/My).
        /// Without it small plates run at 90-240 km/My. At 2.0e4, beside a mantle that flows, the floor is too young;
        /// at 3.2e4 less land is high, and continents gather and part twice on half as many seeds.
        slab_resistance = 2.6e4 in 0.0..=1.0e6 "per km and km/My",
        /// Suction of the same slab on the overriding plate.
        slab_suction = 2.85e5 in 0.0..=1.0e7 "per km",
        /// Length of slab that pulls with full force.
        slab_full = 300.0 in 50.0..=2000.0 "km",
        /// Longest slab that is remembered.
        slab_longest = 600.0 in 50.0..=4000.0 "km",
        /// Share of the convergence that lengthens the slab.
        slab_growth = 0.6 in 0.0..=1.0 "",
        /// Time in which a slab that is no longer fed is lost.
        slab_decay = 15.0 in 1.0..=200.0 "My",
        /// Ridge push per km (Yggdrasill 2e-8 m/yr²; a twentieth of slab pull on Earth).
        ridge_push = 4.0e4 in 0.0..=1.0e6 "per km",
        /// Push that drives the halves of a new rift apart. Below 5e5 continents stay gathered (study).
        rift_push = 5.0e5 in 0.0..=5.0e6 "per km",
        /// How long it lasts.
        rift_push_time = 40.0 in 0.0..=200.0 "My",
        /// Resistance of a front that a rift has not torn yet, along and across it: strong enough to be
        /// the hinge about which the two sides turn.
        untorn = 1.0e5 in 0.0..=1.0e7 "per km and km/My",
        /// Friction along every front, and across trenches; like the two resistances beside it on a mesh of 226 km.
        friction = 2350.0 in 0.0..=1.0e5 "per km and km/My",
        /// Resistance of continental collision. A tenth loses continents, ten times makes shards (study).
        collision = 4.0e4 in 0.0..=1.0e6 "per km and km/My",
        /// Interpenetration at which the resistance has grown by its own size.
        collision_length = 300.0 in 50.0..=2000.0 "km",
        /// Time in which a plate takes up a new balance. 10 My leaves old floor, 50 My sluggish plates.
        response = 2.0 in 0.05..=100.0 "My",
    }
}

constants! {
    /// The slow convection that gathers and disperses continents.
    MantleConstants("mantle") {
        /// Speed of the flow under continents, a quarter of the way round from where it sinks. With the drag of
        /// continents it says how hard they are drawn together.
        speed = 195.0 in 0.0..=500.0 "km/My",
        /// Speed of the same flow where slabs hang: deeper, where it turns round to sink, and so slower. Continents gather
        /// and part twice in 2,000 My on 10 of 10 tuning seeds. With a resistance of 2.0e4 they did so on 4 at a speed of
        /// 0, and the floor was too young at 100.
        slab_speed = 40.0 in 0.0..=500.0 "km/My",
        /// Time in which a supercontinent would warm the mantle enough for a superplume if none were
        /// lost (Gurnis 1988: 100-200 My until the mantle below has turned from cold to hot).
        heating = 130.0 in 10.0..=5000.0 "My",
        /// Time in which stored warmth is lost.
        cooling = 150.0 in 10.0..=10000.0 "My",
        /// Time in which the flow takes up a new order.
        rise = 60.0 in 1.0..=1000.0 "My",
    }
}

constants! {
    /// Soft margins: springs on joined edges and their cross edges (Yggdrasill).
    MarginConstants("margins") {
        /// Stiffness of plates behind their margins: fronts give way freely, and what lies behind them stiffens
        /// to this across the margin's width. 0 lets the springs alone hold plates together, 1 keeps them
        /// exactly rigid.
        rigidity = 0.85 in 0.0..=1.0 "",
        /// Reach of the soft margin behind a front.
        width = 600.0 in 0.0..=3000.0 "km",
        /// Softness of springs that are stretched (the inverse of stiffness, per pass).
        compliance = 0.25 in 0.0..=10.0 "",
        /// Stiffness of compressed springs over that of stretched ones (Yggdrasill 1e-4 : 5e-5).
        compressed_ratio = 2.0 in 0.1..=20.0 "times",
        /// Time in which rest lengths follow a lasting deformation.
        flow = 10.0 in 0.5..=500.0 "My",
        /// Strain at which springs yield: the rest length follows the length at once beyond it.
        /// Crust stores little strain; what exceeds a few per cent is flow.
        yield_strain = 0.03 in 0.001..=0.5 "",
        /// Share of the closing speed of continents that their margins take up by shortening.
        shortening = 0.5 in 0.0..=0.9 "of the closing speed",
        /// Share of its own advance towards a trench by which a continent's margin is shortened where the slab is
        /// young (South America: 25-30 km/My to the west, Andes 5-12 km/My).
        cordillera = 0.4 in 0.0..=0.9 "of the advance",
        /// Speed at which an old slab rolls back and draws the margin above it seaward; 0 turns this off. A mean over
        /// phases of fast opening, up to 50 km/My, and of rest (Japan moved some 400 km against Asia, most of it
        /// between 25 and 12 My ago, over floor that had been old for long: Jolivet & Tamaki 1992).
        rollback = 8.0 in 0.0..=200.0 "km/My",
        /// Age of sea floor at a trench up to which its slab presses against the margin (back-arc basins open where
        /// it is older than 55 My: Sdrolias & Müller 2006).
        rollback_from = 50.0 in 0.0..=500.0 "My",
        /// Age from which a slab no longer presses and rolls back at full speed (Molnar & Atwater 1978: Andean margins
        /// where it is younger than 50 My, spreading behind arcs where it is older, in many cases than 100).
        rollback_full = 80.0 in 0.0..=500.0 "My",
        /// Distance from the trench up to which the margin is stretched (arcs of the Aegean and of the Ryukyus, with
        /// the troughs behind them: 300-400 km).
        rollback_reach = 400.0 in 10.0..=2000.0 "km",
        /// Mean thickness of that strip's crust at which stretching ends, weaker and weaker from 10 km more
        /// (the Aegean's is 22-25 km thick: Tirel et al. 2004).
        rollback_thinnest = 24.0 in 5.0..=60.0 "km",
        /// Interval at which margins are bent anew; between, deviations stay as they are. Fronts yield by some
        /// 40 km in it: so much more, and cells fold. For a spacing of 226 km, shorter in proportion on finer meshes.
        interval = 1.5 in 0.05..=5.0 "My",
        /// Time in which a deviation from rigid motion dies out at rigidity 0.
        drag = 20.0 in 0.1..=1000.0 "My",
    }
}

constants! {
    /// Large events.
    PlateConstants("plates") {
        /// Smallest plate; smaller pieces are absorbed.
        smallest = 0.0006 in 0.0..=0.05 "of the sphere",
        /// A broken-off piece larger than this becomes a plate of its own.
        orphan = 0.008 in 0.0..=0.2 "of the sphere",
        /// Interpenetration after which a terrane goes over to the other plate (Cortial et al. 2019).
        terrane_length = 300.0 in 50.0..=1.0e6 "km",
        /// Largest terrane: 2 million km², as Avalonia or Cimmeria. Larger continents keep their sea floor and
        /// suture plate to plate; where each of them went over alone, the planet's continents came to lie on
        /// one sprawling plate that can neither round itself nor be drawn together.
        terrane_largest = 0.004 in 0.0..=1.0 "of the sphere",
        /// Interpenetration after which two continents may suture.
        suture_length = 350.0 in 50.0..=5000.0 "km",
        /// Share of continental contact in the front of the two plates that a suture needs.
        suture_share = 0.2 in 0.0..=1.0 "",
        /// Closing speed below which a collision has come to rest. Earth's ranges close for tens of My; at
        /// 3 km/My and more they are welded while still high, and stand in the middle of plates.
        suture_speed = 1.5 in 0.0..=100.0 "km/My",
        /// Plates smaller than this do not rift.
        rift_smallest = 0.03 in 0.005..=1.0 "of the sphere",
        /// Plates younger than this do not rift.
        rift_youngest = 30.0 in 0.0..=500.0 "My",
        /// Rate at which cuts are tried in a plate of a tenth of the sphere without continents, per 0.3; what is
        /// not under tension stays whole.
        rift_rate = 0.05 in 0.0..=1.0 "/My",
        /// Pace at which the tip of a rift runs on (South Atlantic 3,000 km in some 20 My).
        tear_pace = 150.0 in 10.0..=1.0e5 "km/My",
        /// How much warmth below hastens rifting and cold hinders it, at most.
        rift_warmth = 0.8 in 0.0..=10.0 "times",
        /// Share of rifts in two that stall and fail (on Earth most do: one arm of every three, the
        /// Benue Trough, the Midcontinent and North Sea rifts).
        rift_failure = 0.25 in 0.0..=1.0 "",
        /// Number of plates around which the rate of rifting is balanced.
        plate_count = 14.0 in 2.0..=60.0 "plates",
        /// Sea floor older than this may start to founder (Earth's oldest: 180 My).
        founder_age = 148.0 in 40.0..=500.0 "My",
        /// How much older floor counts over a downwelling, at most: plates are pressed together there, and
        /// forced subduction starts in younger floor. Without it inland seas hold a supercontinent apart
        /// until they have grown old.
        founder_pressed = 0.8 in 0.0..=5.0 "times",
        /// Mean time until it does.
        founder_time = 12.0 in 1.0..=500.0 "My",
        /// Smallest reach of a new subduction zone's plate.
        founder_near = 3500.0 in 200.0..=10000.0 "km",
        /// Largest reach.
        founder_far = 6000.0 in 200.0..=20000.0 "km",
        /// Share of foreign neighbours at which an ocean vertex or a continental tooth changes side.
        majority = 0.64 in 0.5..=1.0 "",
        /// Enclosed seas smaller than this fill up and become basins: pockets of up to 1,100 km, which fine meshes
        /// keep between continents. Smaller than the Gulf of Mexico (1.6e6 km² with its shelves).
        basin = 1.2e6 in 0.0..=1.0e7 "km²",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_agree_with_fields() {
        let defaults = Constants::default();
        for group in defaults.groups() {
            assert!(!group.doc().is_empty());
            for (row, info) in group.info().iter().enumerate() {
                assert_eq!(group.value(row), Some(info.default), "{}", info.name);
                assert!((info.lowest..=info.highest).contains(&info.default));
                assert!(!info.doc.is_empty() && !info.doc.starts_with(' '));
            }
            assert_eq!(group.value(group.info().len()), None);
        }
        assert_eq!(defaults.groups()[4].name(), "motion");

        let mut changed = defaults.clone();
        for group in changed.groups_mut() {
            for row in 0..group.info().len() {
                if let Some(value) = group.value_mut(row) {
                    *value = f64::MAX;
                }
            }
            assert_eq!(group.value_mut(group.info().len()), None);
        }
        assert!(changed.groups().iter().all(|group| {
            (0..group.info().len()).all(|row| group.value(row) == Some(f64::MAX))
        }));
        assert!(changed.validate().is_err());
    }
}
