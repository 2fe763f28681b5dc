//! Terrain in batches on the GPU: what `surface::Terrain` has place by place, by a compute shader.
//!
//! The CPU looks up what the mesh says of the neighbourhood, the triangles and the kinds of the larger pieces of
//! ground, and hands it over relative to the middle of the batch. The shader does all that is done for each place:
//! noise, coasts, interpolation, pieces and grain.

use crate::surface::{Exemplars, HeightField, Terrain, TooWide, Words, vectors, weights};
use bevy::render::{
    render_resource::{
        BindGroupEntry, BindGroupLayout, Buffer, BufferDescriptor, BufferUsages,
        CommandEncoderDescriptor, ComputePassDescriptor, ComputePipeline, MapMode,
        PipelineCompilationOptions, PollType, RawComputePipelineDescriptor, ShaderModuleDescriptor,
        ShaderSource,
    },
    renderer::{RenderDevice, RenderQueue},
};
use glam::DVec3;
use std::{
    sync::{
        Arc,
        mpsc::{RecvTimeoutError, channel},
    },
    time::{Duration, Instant},
};

/// Places that are worked on at once: 13 MB.
const AT_ONCE: usize = 1 << 18;
/// Places of a workgroup. Mirrored in the shader.
const GROUP: u32 = 64;
/// Time between two looks at whether the device is done. Waiting for it would hold up the frames that Bevy submits
/// meanwhile.
const LOOK: Duration = Duration::from_micros(200);
/// After this time a device counts as gone.
const LONGEST: Duration = Duration::from_secs(60);

/// Why a batch has no heights.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GpuTerrainError {
    /// The directions do not lie close enough together.
    #[error(
        "direction {number} of the batch lies {found_km:.1} km from the middle of all: from 0 to {allowed_km:.1} km are possible"
    )]
    TooWide {
        /// The furthest of the directions, by its number in the batch.
        number: usize,
        /// How far it lies from their middle, in km.
        found_km: f64,
        /// How far it may, in km: 200, on planets of less than 6,400 km a 32nd part of the radius.
        allowed_km: f64,
    },
    /// The device did not answer: it is lost, or short of memory.
    #[error("the heights of a batch could not be read back: {0}")]
    Device(String),
}

impl From<TooWide> for GpuTerrainError {
    fn from(wide: TooWide) -> Self {
        Self::TooWide {
            number: wide.number,
            found_km: wide.found_km,
            allowed_km: wide.allowed_km,
        }
    }
}

/// Elevations of many places at once, by a compute shader: within 0.1 m those of [`Terrain::elevation`].
///
/// Bevy has the device and its queue as resources, in the main world and in the render world; `RenderDevice::from`
/// takes one of your own. It must know compute shaders with 8 storage buffers, as WebGPU promises. Made once, it
/// serves any number of planets, as long as the device lives: where that is lost, wgpu itself panics. Calls wait until
/// the device is done, so they belong on a task where frames must not wait; on the web nothing can wait for a device,
/// and every call fails.
///
/// ```no_run
/// use bevy::{prelude::*, render::renderer::{RenderDevice, RenderQueue}};
/// use bevy_tectonics::{prelude::*, render::GpuTerrain};
/// use bevy_tectonics::surface::{Terrain, direction_of};
///
/// // Where a frame may wait; otherwise on a task, with clones of all three.
/// fn stand(device: Res<RenderDevice>, queue: Res<RenderQueue>, planet: Single<&PlanetSurface>) -> Result {
///     let mut gpu = GpuTerrain::new(&device, &queue);
///     let terrain = Terrain::new(&planet, 2.0)?;
///     // 2 km around a player, a sample every 2 m.
///     let patch = gpu.patch(&terrain, direction_of(47.0, 8.5), 2.048, 1025)?;
///     assert_eq!(patch.heights.len(), 1025 * 1025);
///     Ok(())
/// }
/// ```
pub struct GpuTerrain {
    device: RenderDevice,
    queue: RenderQueue,
    pipeline: ComputePipeline,
    layout: BindGroupLayout,
    vectors: Buffer,
    exemplars: Option<(Arc<Exemplars>, Buffer)>,
}

impl GpuTerrain {
    /// Compiles the shader. A device without compute shaders says so in the log or by a panic, as it does of all
    /// errors.
    #[must_use]
    pub fn new(device: &RenderDevice, queue: &RenderQueue) -> Self {
        let module = device.create_and_validate_shader_module(ShaderModuleDescriptor {
            label: Some("terrain"),
            source: ShaderSource::Wgsl(include_str!("gpu_terrain.wgsl").into()),
        });
        let pipeline = device.create_compute_pipeline(&RawComputePipelineDescriptor {
            label: Some("terrain"),
            layout: None,
            module: &module,
            entry_point: Some("raise"),
            compilation_options: PipelineCompilationOptions::default(),
            cache: None,
        });
        Self {
            layout: pipeline.get_bind_group_layout(0).into(),
            pipeline,
            vectors: buffer(device, queue, &vectors(), BufferUsages::STORAGE),
            exemplars: None,
            device: device.clone(),
            queue: queue.clone(),
        }
    }

    /// Elevations in m above the sea, one for each direction and in their order: of the same surface, with the same
    /// exemplars and the same detail as a terrain's. Directions may have any length; the north pole stands for those
    /// that are zero or not finite. Each call looks up the neighbourhood anew, so a place costs less in a large batch.
    ///
    /// # Errors
    /// [`GpuTerrainError::TooWide`] if one of them lies more than 200 km from the middle of all, or more than a 32nd
    /// part of the planet's radius; [`GpuTerrainError::Device`] if the device does not answer.
    pub fn elevations(
        &mut self,
        terrain: &Terrain,
        directions: &[DVec3],
    ) -> Result<Vec<f32>, GpuTerrainError> {
        let mut heights = Vec::with_capacity(directions.len());
        if directions.is_empty() {
            return Ok(heights);
        }
        let plot = terrain.plot(directions)?;
        let exemplars = self.exemplars_of(terrain);
        let filled = |words: &Words, usage| buffer(&self.device, &self.queue, words, usage);
        let storage = |words: &Words| filled(words, BufferUsages::STORAGE);
        let head = filled(&plot.head, BufferUsages::UNIFORM);
        let [triangles, grid] = [&plot.triangles, &plot.grid].map(storage);
        let [pieces, cells] = [&plot.pieces, &plot.cells].map(storage);
        for part in directions.chunks(AT_ONCE) {
            let places = storage(&terrain.samples(&plot, part));
            let bytes = 4 * part.len() as u64;
            let empty = |label, usage| {
                self.device.create_buffer(&BufferDescriptor {
                    label: Some(label),
                    size: bytes,
                    usage,
                    mapped_at_creation: false,
                })
            };
            let raised = empty("heights", BufferUsages::STORAGE | BufferUsages::COPY_SRC);
            let read = empty(
                "heights read",
                BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            );
            let buffers = [
                &head,
                &places,
                &self.vectors,
                &exemplars,
                &triangles,
                &grid,
                &pieces,
                &cells,
                &raised,
            ];
            let entries: Vec<BindGroupEntry> = (0..)
                .zip(buffers)
                .map(|(binding, buffer)| BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                })
                .collect();
            let group = self
                .device
                .create_bind_group("terrain", &self.layout, &entries);
            let label = Some("terrain");
            let mut encoder = self
                .device
                .create_command_encoder(&CommandEncoderDescriptor { label });
            {
                let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
                    label,
                    timestamp_writes: None,
                });
                pass.set_pipeline(&self.pipeline);
                pass.set_bind_group(0, &*group, &[]);
                pass.dispatch_workgroups((part.len() as u32).div_ceil(GROUP), 1, 1);
            }
            encoder.copy_buffer_to_buffer(&raised, 0, &read, 0, bytes);
            self.queue.submit([encoder.finish()]);
            self.read(&read, &mut heights)?;
        }
        Ok(heights)
    }

    /// Heights on a square of the tangent plane, as [`Terrain::patch`] has them.
    ///
    /// # Errors
    /// As [`elevations`](Self::elevations): squares are up to 280 km wide.
    pub fn patch(
        &mut self,
        terrain: &Terrain,
        centre: DVec3,
        size_km: f64,
        samples: usize,
    ) -> Result<HeightField, GpuTerrainError> {
        let mut patch = terrain.level_patch(centre, size_km, samples);
        let directions: Vec<DVec3> = patch.directions().collect();
        patch.heights = self.elevations(terrain, &directions)?;
        Ok(patch)
    }

    /// The terrain's pieces of ground on the device; those of the last call stay there.
    fn exemplars_of(&mut self, terrain: &Terrain) -> Buffer {
        let wanted = terrain.exemplars();
        if let Some((exemplars, buffer)) = &self.exemplars
            && Arc::ptr_eq(exemplars, wanted)
        {
            return buffer.clone();
        }
        let usage = BufferUsages::STORAGE;
        let buffer = buffer(&self.device, &self.queue, &weights(wanted), usage);
        self.exemplars = Some((wanted.clone(), buffer.clone()));
        buffer
    }

    /// Waits for the device and appends what it wrote.
    fn read(&self, buffer: &Buffer, heights: &mut Vec<f32>) -> Result<(), GpuTerrainError> {
        let failed = |what: &dyn core::fmt::Display| GpuTerrainError::Device(what.to_string());
        if cfg!(target_arch = "wasm32") {
            return Err(failed(&"nothing can wait for a device on the web"));
        }
        let (told, answer) = channel();
        let slice = buffer.slice(..);
        self.device
            .map_buffer(&slice, MapMode::Read, move |mapped| {
                // Nobody listens any more where waiting has failed.
                let _ = told.send(mapped);
            });
        let start = Instant::now();
        let mapped = loop {
            (self.device.poll(PollType::Poll)).map_err(|error| failed(&error))?;
            // Whoever else looks after the device may be the one who is told.
            match answer.recv_timeout(LOOK) {
                Ok(mapped) => break mapped,
                Err(RecvTimeoutError::Timeout) if start.elapsed() < LONGEST => {}
                Err(error) => return Err(failed(&error)),
            }
        };
        mapped.map_err(|error| failed(&error))?;
        let bytes = slice.get_mapped_range();
        let (words, _) = bytes.as_chunks::<4>();
        heights.extend(words.iter().map(|&word| f32::from_ne_bytes(word)));
        Ok(())
    }
}

fn buffer(
    device: &RenderDevice,
    queue: &RenderQueue,
    words: &Words,
    usage: BufferUsages,
) -> Buffer {
    let bytes = words.bytes();
    let buffer = device.create_buffer(&BufferDescriptor {
        label: Some("terrain"),
        size: bytes.len() as u64,
        usage: usage | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    queue.write_buffer(&buffer, 0, &bytes);
    buffer
}
