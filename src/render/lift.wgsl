// The shape of tiles, the same in pictures and in shadow maps.
#define_import_path bevy_tectonics::lift
#import bevy_pbr::mesh_functions
#import bevy_tectonics::ground::planet

// Length of a side of the largest tiles, in radii.
const SPAN: f32 = 1.5707963;
// Share of the distance at which a tile gives way to its parent where its vertices begin to glide.
const GLIDE: f32 = 0.8;

// Slope of 1 in vertices, in m per m.
const STEEPEST: f32 = 8.0;
// In m: patterns finer than tiles repeat after a period, and tiles have their origins at multiples of a pace.
const PERIOD: f32 = 8192.0;
const PACE: f32 = 128.0;
// Depth of the walls that hide cracks along the rim, in sides of a tile. Bounds in `forest.rs` leave room for them.
const WALL: f32 = 0.03125;

struct Vertex {
    @builtin(instance_index) instance_index: u32,
    @location(0) position: vec3<f32>,
    @location(1) up: vec3<f32>,
    @location(2) slopes: vec4<f32>,
    @location(3) heights: vec3<f32>,
}

struct Shape {
    world_position: vec4<f32>,
    // How far the vertex has come towards the parent's ground.
    coarse: f32,
    // Elevation of the ground in km.
    height: f32,
}

// What is known of a whole tile.
struct Tile {
    is_sea: bool,
    // Length of a side in radii.
    size: f32,
    // How far it has come from its parent's shape.
    age: f32,
    // Where in a period its origin lies, in m.
    origin: vec3<f32>,
}

fn tile(tag: u32) -> Tile {
    let phase = (vec3(tag) >> vec3(13u, 19u, 25u)) & vec3(63u);
    return Tile(
        (tag >> 31u) == 1u,
        SPAN * exp2(-f32(tag & 31u)),
        f32((tag >> 5u) & 255u) / 255.0,
        PACE * vec3<f32>(phase),
    );
}

// A vertex as an eye sees it from so far away.
fn shape(in: Vertex, seen: Tile, eye: vec3<f32>) -> Shape {
    var out: Shape;
    let world_from_local = mesh_functions::get_world_from_local(in.instance_index);
    let radius = length(world_from_local[0].xyz);
    // Towards the distance where the parent is drawn, each vertex glides to the parent's ground.
    let own = world_from_local * vec4(in.position + in.up * (planet.height * in.heights.x), 1.0);
    let distance = distance(eye, own.xyz) / (radius * seen.size * 2.0 * planet.reach);
    out.coarse = max(saturate((distance - GLIDE) / (1.0 - GLIDE)), 1.0 - seen.age);
    out.height = mix(in.heights.x, in.heights.y, out.coarse);
    let drawn = select(out.height, planet.sea, seen.is_sea);
    let is_wall = in.heights.z < 0.0;
    let sag = select(in.heights.z, -1.0 - in.heights.z, is_wall);
    let wall = select(0.0, WALL * seen.size * max(planet.height * planet.radius_km, 1.0), is_wall);
    out.world_position = world_from_local * vec4(in.position + in.up * (planet.height * drawn - out.coarse * sag - wall), 1.0);
    return out;
}

// Slope of the ground in m per m, uphill.
fn slope(in: Vertex, coarse: f32) -> vec3<f32> {
    let along = STEEPEST * mix(in.slopes.xy, in.slopes.zw, coarse);
    // The frame in which slopes are given (Duff et al. 2017).
    let up = in.up;
    let side = select(-1.0, 1.0, up.z >= 0.0);
    let a = -1.0 / (side + up.z);
    let b = up.x * up.y * a;
    return along.x * vec3(1.0 + side * up.x * up.x * a, side * b, -side * up.x)
        + along.y * vec3(b, side + up.y * up.y * a, -up.y);
}
