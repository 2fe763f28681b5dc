//! Recipes without what is as usual.

use serde::Serialize;

/// Serialises the fields that differ from their defaults and leaves the others out.
pub(crate) struct Sparse<'a, T>(pub &'a T);

/// Implements [`Sparse`] for a struct with defaults: plain fields first, then those that are sparse themselves.
macro_rules! sparse {
    ($type:ident { $($field:ident),* $(,)? } $({ $($group:ident),* $(,)? })?) => {
        impl serde::Serialize for $crate::simulation::recipe::sparse::Sparse<'_, $type> {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                use serde::ser::SerializeStruct;
                let (this, usual) = (self.0, $type::default());
                // A field that is missing above would be lost from every code.
                let $type { $($field: _,)* $($($group: _,)*)? } = this;
                let differing = [
                    $(this.$field != usual.$field,)*
                    $($(this.$group != usual.$group,)*)?
                ];
                let count = differing.into_iter().filter(|differs| *differs).count();
                let mut fields = serializer.serialize_struct(stringify!($type), count)?;
                $(if this.$field != usual.$field {
                    fields.serialize_field(stringify!($field), &this.$field)?;
                })*
                $($(if this.$group != usual.$group {
                    let group = $crate::simulation::recipe::sparse::Sparse(&this.$group);
                    fields.serialize_field(stringify!($group), &group)?;
                })*)?
                fields.end()
            }
        }
    };
}
pub(crate) use sparse;

use super::super::{constants::Constants, laws::Laws};
use super::Recipe;

sparse!(Recipe {
    seed, sub_plates, duration_my, radius_km, start, plates, continental_share, land_share, drive, hot_spots,
    events,
} {
    laws, constants,
});
sparse!(Laws {
    sea_floor,
    uplift,
    collision,
    erosion,
});
sparse!(Constants {} {
    step, refine, boundaries, ridges, motion, mantle, margins, uplift, collisions, erosion, plates,
    foundering, prescribed, laws, hot_spots,
});

/// As text in RON, over several lines or on one.
pub(super) fn text<T>(value: &T, pretty: bool) -> Result<String, ron::Error>
where
    for<'a> Sparse<'a, T>: Serialize,
{
    if pretty {
        ron::ser::to_string_pretty(&Sparse(value), ron::ser::PrettyConfig::new())
    } else {
        ron::to_string(&Sparse(value))
    }
}
