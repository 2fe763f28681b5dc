//! The whole planet as one model: a glTF binary.

use super::{
    ExportError, Maps,
    chart::Chart,
    draft::{self, Draft},
    skin::{Skin, Texel},
    textures::FACES,
};
use crate::planet::to_scene;
use crate::simulation::Surface;
use crate::surface::{Relief, cube, raster::Hints};
use glam::{DVec3, Vec3};
use gltf::binary::{Glb, Header};
use png::{BitDepth, ColorType, Encoder};
use serde_json::{Value, json};
use std::{
    borrow::Cow,
    io::{self, Write},
    ops::RangeInclusive,
    path::{Path, PathBuf},
};

/// Name of the file that [`Globe::write`] writes.
pub const GLOBE_FILE: &str = "planet.glb";

/// What numbers are called in glTF.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
/// What a view of the buffer holds.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// A model of a planet: a glTF binary with heights, colours and normals, for modelling programs, engines
/// and viewers.
///
/// The planet has a radius of 1, north is `+Y`, longitude 0 `+X` and 90° east `−Z`, as in a scene with a
/// [`Planet`](crate::planet::Planet). It is one mesh of six parts, the faces of a cube blown up to a
/// sphere, each with a material of two textures. Vertex normals are those of the sphere: slopes are in
/// the texture of normals, in full. The vertex attribute `_ELEVATION` holds the heights in metres above
/// the sea, and the mesh's extras `seed`, `time_my`, `radius_km` and `exaggeration`.
///
/// ```no_run
/// # use bevy_tectonics::{export::{ExportError, Globe}, simulation::Surface};
/// # fn example(surface: &Surface) -> Result<(), ExportError> {
/// Globe::default().write(surface, "planet".as_ref())?;
/// # Ok(()) }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Globe {
    /// Texels along an edge of the cube, within [`Self::SIDES`].
    pub side: u32,
    /// Quads along an edge of the cube, within [`Self::QUADS`].
    pub quads: u32,
    /// How the ground is drawn. True to scale no mountain is to be seen on a globe.
    pub relief: Relief,
    /// Threads to sample with, within [`Maps::THREADS`]. The model does not depend on it.
    pub threads: usize,
}

impl Default for Globe {
    /// 1,024 texels, 128 quads, heights ten times too large and the sea's surface above its floor.
    fn default() -> Self {
        Self {
            side: 1024,
            quads: 128,
            relief: Relief::exaggerated(10.0).with_sea(),
            threads: Maps::new(*Maps::WIDTHS.start()).threads,
        }
    }
}

impl Globe {
    /// Allowed texels along an edge: the model is put together in memory.
    pub const SIDES: RangeInclusive<u32> = 8..=4096;
    /// Allowed quads along an edge.
    pub const QUADS: RangeInclusive<u32> = 1..=1024;

    /// Says whether the settings can be used.
    ///
    /// # Errors
    /// [`ExportError::GlobeSide`], [`ExportError::Quads`] or [`ExportError::Threads`].
    pub fn validate(&self) -> Result<(), ExportError> {
        if !Self::SIDES.contains(&self.side) {
            return Err(ExportError::GlobeSide(self.side));
        }
        if !Self::QUADS.contains(&self.quads) {
            return Err(ExportError::Quads(self.quads));
        }
        let (width, threads) = (*Maps::WIDTHS.start(), self.threads);
        Maps { width, threads }.validate()
    }

    /// Writes [`GLOBE_FILE`] into `folder`, which is created where it does not exist, and returns the
    /// file's path.
    ///
    /// # Errors
    /// [`ExportError`] names the file and the cause; nothing half-written is left behind.
    pub fn write(&self, surface: &Surface, folder: &Path) -> Result<PathBuf, ExportError> {
        self.write_with_progress(surface, folder, |_| ())
    }

    /// As [`write`](Self::write), telling `progress` now and then which fraction is done, 0 to 1.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn write_with_progress(
        &self,
        surface: &Surface,
        folder: &Path,
        progress: impl FnMut(f64),
    ) -> Result<PathBuf, ExportError> {
        self.validate()?;
        let skin = Skin::new(surface, self.relief, self.threads)?;
        let draft = Draft::create(folder, GLOBE_FILE)?;
        let bytes = self.model(surface, &skin, progress)?;
        draft.fill(|pen| pen.write_all(&bytes?))?;
        draft::publish(vec![draft])?;
        Ok(folder.join(GLOBE_FILE))
    }

    /// The bytes of the file; the inner error is the encoders'.
    fn model(
        &self,
        surface: &Surface,
        skin: &Skin,
        mut progress: impl FnMut(f64),
    ) -> Result<io::Result<Vec<u8>>, ExportError> {
        let mut model = Model::new(surface, self.relief);
        for (face, name) in FACES.into_iter().enumerate() {
            let [mut colours, mut normals] = [(); 2].map(|()| Vec::new());
            skin.paint(Chart::Face(face, self.side), &mut |texels, share| {
                for texel in texels {
                    colours.extend(texel.colour);
                    normals.extend(byte_normal(texel));
                }
                progress((face as f64 + share) / 6.0);
                Ok(())
            })?;
            let part = Part::new(skin, face, self.quads);
            let pictures = picture(self.side, &colours)
                .and_then(|colours| Ok([colours, picture(self.side, &normals)?]));
            match pictures {
                Ok(pictures) => model.add(name, &part, &pictures),
                Err(error) => return Ok(Err(error)),
            }
        }
        Ok(model.finish())
    }
}

/// A normal as a texture of glTF has it.
fn byte_normal(texel: &Texel) -> [u8; 3] {
    texel
        .normal
        .to_array()
        .map(|component| ((component + 1.0) * 127.5 + 0.5) as u8)
}

/// Three bytes a texel as the bytes of a PNG. Whether they are colours in sRGB or not is the
/// material's to say.
fn picture(side: u32, texels: &[u8]) -> io::Result<Vec<u8>> {
    let mut png = Vec::new();
    let mut encoder = Encoder::new(&mut png, side, side);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(texels)?;
    writer.finish()?;
    Ok(png)
}

/// The vertices of a face.
struct Part {
    quads: u32,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    tangents: Vec<[f32; 4]>,
    uvs: Vec<[f32; 2]>,
    elevations: Vec<f32>,
}

impl Part {
    fn new(skin: &Skin, face: usize, quads: u32) -> Self {
        let count = (quads as usize + 1) * (quads as usize + 1);
        let mut part = Self {
            quads,
            positions: Vec::with_capacity(count),
            normals: Vec::with_capacity(count),
            tangents: Vec::with_capacity(count),
            uvs: Vec::with_capacity(count),
            elevations: Vec::with_capacity(count),
        };
        let along = cube::to_simulation(cube::axes(face)[0]);
        // The same on both faces of an edge, to the last bit.
        let lattice = |i: u32| (2.0 * f64::from(i) - f64::from(quads)) / f64::from(quads);
        for row in 0..=quads {
            let mut hints = Hints::default();
            for column in 0..=quads {
                let (s, t) = (lattice(column), lattice(row));
                let place: DVec3 = cube::to_simulation(cube::point(face, s, t)).normalize();
                if [0, quads].contains(&row) || [0, quads].contains(&column) {
                    // Both faces of an edge look for it from the same place.
                    hints = Hints::default();
                }
                let elevation = skin.elevation(place, &mut hints);
                let tangent = along.reject_from_normalized(place).normalize_or(along);
                let [x, y, z] = to_scene(tangent).to_array();
                part.positions.push(to_scene(skin.point(place, elevation)));
                part.normals.push(to_scene(place));
                part.tangents.push([x, y, z, 1.0]);
                part.uvs.push([s, t].map(|c| (0.5 * (c + 1.0)) as f32));
                part.elevations.push(elevation);
            }
        }
        part
    }

    /// Corners of triangles, counter-clockwise seen from outside.
    fn indices(&self) -> impl Iterator<Item = u32> {
        let wide = self.quads + 1;
        let rows = 0..self.quads;
        rows.flat_map(move |row| (0..wide - 1).map(move |column| row * wide + column))
            .flat_map(move |a| {
                let [b, c, d] = [a + wide, a + wide + 1, a + 1];
                [a, b, c, a, c, d]
            })
    }
}

/// A glTF document under construction.
struct Model {
    bin: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    images: Vec<Value>,
    textures: Vec<Value>,
    materials: Vec<Value>,
    primitives: Vec<Value>,
    extras: Value,
}

impl Model {
    fn new(surface: &Surface, relief: Relief) -> Self {
        Self {
            bin: Vec::new(),
            views: Vec::new(),
            accessors: Vec::new(),
            images: Vec::new(),
            textures: Vec::new(),
            materials: Vec::new(),
            primitives: Vec::new(),
            extras: json!({
                "seed": surface.seed,
                "time_my": surface.time_my,
                "radius_km": surface.radius_km,
                "exaggeration": relief.scale(surface.radius_km) * 1000.0 * surface.radius_km,
                "sea": relief.sea,
            }),
        }
    }

    /// Adds a face with its pictures of colours and normals.
    fn add(&mut self, name: &str, part: &Part, pictures: &[Vec<u8>; 2]) {
        let floats = |vectors: &[Vec3]| vectors.iter().flat_map(|v| v.to_array()).collect();
        let positions: Vec<f32> = floats(&part.positions);
        let (low, high) = part
            .positions
            .iter()
            .fold((Vec3::MAX, Vec3::MIN), |(low, high), &p| {
                (low.min(p), high.max(p))
            });
        let position = self.vertices("VEC3", &positions);
        self.accessors[position]["min"] = json!(low.to_array());
        self.accessors[position]["max"] = json!(high.to_array());
        let normals: Vec<f32> = floats(&part.normals);
        let normal = self.vertices("VEC3", &normals);
        let tangent = self.vertices("VEC4", part.tangents.as_flattened());
        let uv = self.vertices("VEC2", part.uvs.as_flattened());
        let elevation = self.vertices("SCALAR", &part.elevations);

        let bytes: Vec<u8> = part.indices().flat_map(u32::to_le_bytes).collect();
        let indices = self.accessors.len();
        let view = self.view(&bytes, Some(INDICES));
        self.accessors.push(json!({
            "bufferView": view, "componentType": UNSIGNED_INT,
            "count": bytes.len() / 4, "type": "SCALAR",
        }));
        let [colour, slope] = ["colour", "normal"].map(|kind| format!("{kind}_{name}"));
        let colour = self.texture(&colour, &pictures[0]);
        let slope = self.texture(&slope, &pictures[1]);
        let material = self.materials.len();
        self.materials.push(json!({
            "name": format!("ground_{name}"),
            "pbrMetallicRoughness": {
                "baseColorTexture": { "index": colour },
                "metallicFactor": 0.0,
                "roughnessFactor": 1.0,
            },
            "normalTexture": { "index": slope },
        }));
        self.primitives.push(json!({
            "attributes": {
                "POSITION": position, "NORMAL": normal, "TANGENT": tangent,
                "TEXCOORD_0": uv, "_ELEVATION": elevation,
            },
            "indices": indices,
            "material": material,
        }));
    }

    /// Adds an accessor of vectors, or numbers, of so many floats each.
    fn vertices(&mut self, kind: &str, floats: &[f32]) -> usize {
        let bytes: Vec<u8> = floats.iter().flat_map(|f| f.to_le_bytes()).collect();
        let size = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            _ => 4,
        };
        let view = self.view(&bytes, Some(VERTICES));
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT,
            "count": floats.len() / size, "type": kind,
        }));
        self.accessors.len() - 1
    }

    fn texture(&mut self, name: &str, png: &[u8]) -> usize {
        let view = self.view(png, None);
        self.images
            .push(json!({ "name": name, "bufferView": view, "mimeType": "image/png" }));
        self.textures
            .push(json!({ "source": self.images.len() - 1, "sampler": 0 }));
        self.textures.len() - 1
    }

    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({
            "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len(),
        });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bin.extend(bytes);
        // Numbers must lie at multiples of their size.
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    fn finish(self) -> io::Result<Vec<u8>> {
        let document = json!({
            "asset": {
                "version": "2.0",
                "generator": concat!("bevy_tectonics ", env!("CARGO_PKG_VERSION")),
            },
            "scene": 0,
            "scenes": [{ "name": "Planet", "nodes": [0] }],
            "nodes": [{ "name": "Planet", "mesh": 0 }],
            "meshes": [{ "name": "Planet", "primitives": self.primitives, "extras": self.extras }],
            "materials": self.materials,
            "textures": self.textures,
            "images": self.images,
            // Linear, with levels, clamped to the edges.
            "samplers": [{ "magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071 }],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.bin.len() }],
        });
        let glb = Glb {
            header: Header {
                magic: *b"glTF",
                version: 2,
                length: 0,
            },
            json: Cow::Owned(serde_json::to_vec(&document)?),
            bin: Some(Cow::Owned(self.bin)),
        };
        glb.to_vec().map_err(io::Error::other)
    }
}
