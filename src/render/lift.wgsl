// The shape of tiles, the same in pictures and in shadow maps.
#define_import_path bevy_tectonics::lift
#import bevy_pbr::mesh_functions
#import bevy_tectonics::ground::planet

// Length of a side of the largest tiles, in radii.
const SPAN: f32 = 1.5707963;
// Share of the distance at which a tile gives way to its parent where its vertices begin to glide.
const GLIDE: f32 = 0.8;

struct Vertex {
    @builtin(instance_index) instance_index: u32,
    @location(0) position: vec3<f32>,
    @location(1) up: vec3<f32>,
    @location(2) slope: vec3<f32>,
    @location(3) coarse_slope: vec3<f32>,
    @location(4) heights: vec4<f32>,
    @location(5) place: vec3<f32>,
}

struct Shape {
    world_position: vec4<f32>,
    // How far the vertex has come towards the parent's ground.
    coarse: f32,
    // Elevation of the ground in km.
    height: f32,
}

fn is_sea(tag: u32) -> bool {
    return (tag >> 31u) == 1u;
}

// A vertex as an eye sees it from so far away.
fn shape(in: Vertex, eye: vec3<f32>) -> Shape {
    var out: Shape;
    let tag = mesh_functions::get_tag(in.instance_index);
    let world_from_local = mesh_functions::get_world_from_local(in.instance_index);
    let radius = length(world_from_local[0].xyz);
    // Towards the distance where the parent is drawn, each vertex glides to the parent's ground.
    let own = world_from_local * vec4(in.position + in.up * (planet.height * in.heights.x), 1.0);
    let size = SPAN * exp2(-f32(tag & 31u));
    let distance = distance(eye, own.xyz) / (radius * size * 2.0 * planet.reach);
    let age = f32((tag >> 8u) & 255u) / 255.0;
    out.coarse = max(saturate((distance - GLIDE) / (1.0 - GLIDE)), 1.0 - age);
    out.height = mix(in.heights.x, in.heights.y, out.coarse);
    let drawn = select(out.height, planet.sea, is_sea(tag));
    let lifted = planet.height * drawn - out.coarse * in.heights.z - in.heights.w * max(planet.height * planet.radius_km, 1.0);
    out.world_position = world_from_local * vec4(in.position + in.up * lifted, 1.0);
    return out;
}
