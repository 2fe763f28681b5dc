//! The materials of the ground and of the air. Both are lit by Bevy's lights.

use super::palette::Tints;
#[cfg(feature = "terrain")]
use super::tiles;
use bevy::{
    asset::embedded_asset,
    mesh::MeshVertexBufferLayoutRef,
    pbr::{Material, MaterialPipeline, MaterialPipelineKey, MaterialPlugin},
    prelude::*,
    render::render_resource::{
        AsBindGroup, Face, RenderPipelineDescriptor, ShaderType, SpecializedMeshPipelineError,
    },
    shader::{ShaderRef, load_shader_library},
};

pub(super) fn plugin(app: &mut App) {
    load_shader_library!(app, "air.wgsl");
    load_shader_library!(app, "bevy_air.wgsl");
    load_shader_library!(app, "detail.wgsl");
    load_shader_library!(app, "light.wgsl");
    load_shader_library!(app, "ground.wgsl");
    load_shader_library!(app, "lift.wgsl");
    load_shader_library!(app, "tile.wgsl");
    embedded_asset!(app, "planet.wgsl");
    embedded_asset!(app, "shadow.wgsl");
    embedded_asset!(app, "sky.wgsl");
    app.add_plugins((
        MaterialPlugin::<PlanetMaterial>::default(),
        MaterialPlugin::<SkyMaterial>::default(),
    ));
}

/// Land and sea of a planet between two snapshots, A and B.
#[derive(Asset, AsBindGroup, TypePath, Debug, Clone)]
#[bind_group_data(Lighting)]
pub(super) struct PlanetMaterial {
    pub lighting: Lighting,
    #[uniform(0)]
    pub uniform: PlanetUniform,
    #[texture(1, dimension = "cube")]
    #[sampler(2)]
    pub relief_a: Handle<Image>,
    #[texture(3, dimension = "cube")]
    pub relief_b: Handle<Image>,
    #[texture(4, dimension = "cube")]
    pub climate_a: Handle<Image>,
    #[texture(5, dimension = "cube")]
    pub climate_b: Handle<Image>,
    #[texture(6, dimension = "cube")]
    pub velocity_a: Handle<Image>,
    #[texture(7, dimension = "cube")]
    pub velocity_b: Handle<Image>,
    #[texture(8, dimension = "cube")]
    pub overlay_a: Option<Handle<Image>>,
    #[texture(9, dimension = "cube")]
    pub overlay_b: Option<Handle<Image>>,
    #[texture(10)]
    pub palette: Handle<Image>,
}

/// What lights a scene has beyond sunshine. Shaders are compiled for what is needed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub(super) struct Lighting {
    /// Lights other than directional ones.
    pub lamps: bool,
    /// Directional lights that cast shadows.
    pub shadows: bool,
}

impl From<&PlanetMaterial> for Lighting {
    fn from(material: &PlanetMaterial) -> Self {
        material.lighting
    }
}

/// What changes from frame to frame. The order is that of `planet.wgsl`.
#[derive(ShaderType, Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct PlanetUniform {
    /// Radians by which A is carried forward, and B back, per km/My.
    pub drift: Vec2,
    /// Finest level that has data.
    pub level: Vec2,
    /// Opacity of the overlay.
    pub overlay: Vec2,
    /// Share of B.
    pub mix: f32,
    /// Texels along an edge of the relief.
    pub size: f32,
    /// Radii per km of height.
    pub height: f32,
    /// Factor on slopes for shading.
    pub shade: f32,
    /// Level of the sea in km; far below the ground without one.
    pub sea: f32,
    /// Elevation in km from which the heights of land are coloured.
    pub datum: f32,
    /// Share of the picture's pixels that belong to tiles.
    pub tiles: f32,
    /// Distance within which a tile is split, in sides of it.
    pub reach: f32,
    /// Radius in km.
    pub radius_km: f32,
    /// Where the camera is that tiles are placed around, in the world, if any sun casts shadows.
    pub eye: Vec3,
    /// Optical depth of the air straight up for red, green and blue, and its scale height in radii.
    pub air: Vec4,
    pub tints: Tints,
}

impl Material for PlanetMaterial {
    fn vertex_shader() -> ShaderRef {
        shader("planet.wgsl")
    }

    fn fragment_shader() -> ShaderRef {
        shader("planet.wgsl")
    }

    /// Used for shadow maps alone.
    fn prepass_vertex_shader() -> ShaderRef {
        shader("shadow.wgsl")
    }

    // The main pass discards pixels, a prepass would not.
    fn enable_prepass() -> bool {
        false
    }

    // Tiles cast them; the sphere is marked as one that does not.
    fn enable_shadows() -> bool {
        cfg!(feature = "terrain")
    }

    fn specialize(
        _: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        layout: &MeshVertexBufferLayoutRef,
        key: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        #[cfg(feature = "terrain")]
        if layout.0.contains(tiles::UP) {
            descriptor.vertex.buffers = vec![layout.0.get_layout(&[
                Mesh::ATTRIBUTE_POSITION.at_shader_location(0),
                tiles::UP.at_shader_location(1),
                tiles::SLOPES.at_shader_location(2),
                tiles::HEIGHTS.at_shader_location(3),
            ])?];
            let tiles = bevy::shader::ShaderDefVal::from("PLANET_TILES");
            let shadows = bevy::shader::ShaderDefVal::from("PREPASS_PIPELINE");
            if descriptor.vertex.shader_defs.contains(&shadows) {
                // Only slopes that look away from the sun: ground that it shines on cannot stain itself, and what
                // lies beyond a ridge is as dark.
                descriptor.primitive.cull_mode = Some(Face::Front);
            }
            descriptor.vertex.shader_defs.push(tiles.clone());
            if let Some(fragment) = &mut descriptor.fragment {
                fragment.shader_defs.push(tiles);
            }
        }
        #[cfg(not(feature = "terrain"))]
        let _ = layout;
        if let Some(fragment) = &mut descriptor.fragment {
            let Lighting { lamps, shadows } = key.bind_group_data;
            for (needed, name) in [(lamps, "PLANET_LAMPS"), (shadows, "PLANET_SHADOWS")] {
                if needed {
                    fragment.shader_defs.push(name.into());
                }
            }
        }
        Ok(())
    }
}

/// The air beyond the limb of a planet, and above those who stand on it.
#[derive(Asset, AsBindGroup, TypePath, Debug, Clone)]
pub(super) struct SkyMaterial {
    #[uniform(0)]
    pub uniform: SkyUniform,
}

/// The order is that of `sky.wgsl`.
#[derive(ShaderType, Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct SkyUniform {
    /// See [`PlanetUniform::air`].
    pub air: Vec4,
    /// Radius of the mesh in radii of the planet.
    pub extent: f32,
}

impl Material for SkyMaterial {
    fn vertex_shader() -> ShaderRef {
        shader("sky.wgsl")
    }

    fn fragment_shader() -> ShaderRef {
        shader("sky.wgsl")
    }

    fn alpha_mode(&self) -> AlphaMode {
        AlphaMode::Add
    }

    fn enable_prepass() -> bool {
        false
    }

    fn enable_shadows() -> bool {
        false
    }

    fn specialize(
        _: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _: &MeshVertexBufferLayoutRef,
        _: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        // The far side, so that the planet hides what lies behind it, and a camera may fly inside.
        descriptor.primitive.cull_mode = Some(Face::Front);
        Ok(())
    }
}

fn shader(name: &str) -> ShaderRef {
    ShaderRef::Path(format!("embedded://bevy_tectonics/render/{name}").into())
}
