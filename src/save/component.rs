//! Components of a game, saved with the sub-plates that carry them.

use super::{
    container::Section,
    error::SaveError,
    text::{deflate, inflate},
};
use crate::simulation::SubPlate;
use bevy::ecs::component::Mutable;
use bevy::prelude::*;
use core::marker::PhantomData;
use serde::{Serialize, de::DeserializeOwned};
use std::collections::BTreeMap;

/// Prefix of the names of sections that hold components.
const PREFIX: &str = "+";
/// Longest name in characters.
const LONGEST_NAME: usize = 15;
/// Most bytes of a component on one sub-plate, before they are compressed.
const MOST_BYTES: usize = 256;

/// A component of your own on every sub-plate that saves carry along. Add a [`SavedComponentPlugin`] for it to
/// the stages.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_tectonics::prelude::*;
/// use bevy_tectonics::save::{self, SavedComponent, SavedComponentPlugin};
/// use bevy_tectonics::simulation::SubPlate;
/// use serde::{Deserialize, Serialize};
///
/// #[derive(Component, Default, Serialize, Deserialize)]
/// struct Ore {
///     gold: f32,
/// }
///
/// impl SavedComponent for Ore {
///     const NAME: &'static str = "ore";
/// }
///
/// fn stages() -> impl bevy::app::PluginGroup {
///     SimulationPlugins.build().add(SavedComponentPlugin::<Ore>::default())
/// }
///
/// let mut history = History::with_plugins(Recipe::earth_like(7).with_sub_plates(500), stages())?;
/// let world = history.world_mut();
/// for mut ore in world.query_filtered::<&mut Ore, With<SubPlate>>().iter_mut(world) {
///     ore.gold = 0.5;
/// }
/// let bytes = save::to_bytes(&mut history)?;
/// let mut loaded = save::from_bytes(&bytes, stages())?;
/// let world = loaded.world_mut();
/// assert!(world.query::<&Ore>().iter(world).all(|ore| ore.gold == 0.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait SavedComponent:
    Component<Mutability = Mutable> + Default + Serialize + DeserializeOwned
{
    /// What it is called in the file: 1 to 15 characters of ASCII, never to be changed.
    const NAME: &'static str;
}

/// Puts a component on every sub-plate, with its default on new ones, and into every save.
///
/// A save from before the component was there loads with its default; one with components that are not there
/// any more loads without them.
#[derive(Debug, Clone, Copy)]
pub struct SavedComponentPlugin<C>(PhantomData<fn() -> C>);

impl<C> Default for SavedComponentPlugin<C> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<C: SavedComponent> Plugin for SavedComponentPlugin<C> {
    fn build(&self, app: &mut App) {
        let is_name = !C::NAME.is_empty() && C::NAME.len() <= LONGEST_NAME && C::NAME.is_ascii();
        assert!(
            is_name,
            "the name of a saved component has 1 to {LONGEST_NAME} characters of ASCII, not {:?}",
            C::NAME
        );
        let world = app.world_mut();
        // It may be required already; only that it is matters.
        let _ = world.try_register_required_components::<SubPlate, C>();
        let codec = Codec {
            encode: encode::<C>,
            decode: decode::<C>,
        };
        world
            .get_resource_or_init::<SavedComponents>()
            .0
            .insert(C::NAME, codec);
    }
}

/// All components that are saved, by name.
#[derive(Resource, Default, Clone)]
struct SavedComponents(BTreeMap<&'static str, Codec>);

#[derive(Clone, Copy)]
struct Codec {
    encode: fn(&mut World) -> Result<Vec<u8>, String>,
    decode: fn(&mut World, &[u8]) -> Result<(), String>,
}

fn encode<C: SavedComponent>(world: &mut World) -> Result<Vec<u8>, String> {
    let mut query = world.query_filtered::<&C, With<SubPlate>>();
    let rows: Vec<&C> = query.iter(world).collect();
    postcard::to_allocvec(&rows).map_err(|error| error.to_string())
}

fn decode<C: SavedComponent>(world: &mut World, bytes: &[u8]) -> Result<(), String> {
    let mut query = world.query_filtered::<&mut C, With<SubPlate>>();
    let rows = query.iter(world).count();
    // A list is its length and its elements.
    let (count, mut bytes) =
        postcard::take_from_bytes::<u64>(bytes).map_err(|error| error.to_string())?;
    if count != rows as u64 {
        return Err(format!("{count} values for {rows} sub-plates"));
    }
    for mut row in query.iter_mut(world) {
        (*row, bytes) = postcard::take_from_bytes(bytes).map_err(|error| error.to_string())?;
    }
    if bytes.is_empty() {
        Ok(())
    } else {
        Err("more than its values".into())
    }
}

/// The sections of all components of a world.
pub(super) fn pack(world: &mut World) -> Result<Vec<(String, Vec<u8>)>, SaveError> {
    let components = world.get_resource::<SavedComponents>().cloned();
    let mut sections = Vec::new();
    for (name, codec) in components.unwrap_or_default().0 {
        let bytes = (codec.encode)(world).map_err(|what| SaveError::Component {
            name: name.into(),
            what,
        })?;
        let most = largest(world);
        if bytes.len() > most {
            return Err(SaveError::TooLarge {
                what: format!("component \"{name}\""),
                bytes: bytes.len(),
                most,
            });
        }
        sections.push((format!("{PREFIX}{name}"), deflate(&bytes)));
    }
    Ok(sections)
}

/// Gives sub-plates back what sections say of the world's components.
pub(super) fn unpack(world: &mut World, sections: &[Section]) -> Result<(), SaveError> {
    let components = world.get_resource::<SavedComponents>().cloned();
    for (name, codec) in components.unwrap_or_default().0 {
        let is_named = |section: &&Section| section.name.strip_prefix(PREFIX) == Some(name);
        let Some(section) = sections.iter().find(is_named) else {
            continue;
        };
        inflate(section.bytes, largest(world))
            .and_then(|bytes| (codec.decode)(world, &bytes))
            .map_err(|what| section.damaged(what))?;
    }
    Ok(())
}

/// Most bytes of a component on all sub-plates.
fn largest(world: &mut World) -> usize {
    let count = world
        .query_filtered::<(), With<SubPlate>>()
        .iter(world)
        .count();
    count.saturating_mul(MOST_BYTES).saturating_add(MOST_BYTES)
}
