// The glow of the air beyond the limb.
#import bevy_pbr::{
    mesh_functions,
    mesh_view_bindings::{view, lights},
    view_transformations::position_world_to_clip,
    pbr_types,
    pbr_functions,
}
#import bevy_tectonics::{air, bevy_air}

struct Sky {
    medium: vec4<f32>,
    // Radius of the mesh in radii of the planet.
    extent: f32,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> sky: Sky;

struct Vertex {
    @builtin(instance_index) instance_index: u32,
    @location(0) position: vec3<f32>,
}

struct Point {
    @builtin(position) position: vec4<f32>,
    @location(0) world_position: vec4<f32>,
    @location(1) @interpolate(flat) instance_index: u32,
}

@vertex
fn vertex(in: Vertex) -> Point {
    var out: Point;
    let world_from_local = mesh_functions::get_world_from_local(in.instance_index);
    out.world_position = world_from_local * vec4(in.position, 1.0);
    out.position = position_world_to_clip(out.world_position.xyz);
    out.instance_index = in.instance_index;
    return out;
}

@fragment
fn fragment(in: Point) -> @location(0) vec4<f32> {
    let world_from_local = mesh_functions::get_world_from_local(in.instance_index);
    if bevy_air::surrounds(world_from_local[3].xyz) {
        discard;
    }
    let radius = length(world_from_local[0].xyz) / sky.extent;
    let orthographic = view.clip_from_view[3].w == 1.0;
    let V = pbr_functions::calculate_view(in.world_position, orthographic);
    // The eye, from the centre of the planet.
    let from_ = select(view.world_position, in.world_position.xyz + 8.0 * radius * V, orthographic);
    let eye = (from_ - world_from_local[3].xyz) / radius;
    let x = dot(eye, -V);
    let distance = sqrt(max(dot(eye, eye) - x * x, 0.0));
    let here = air::seen_from(sqrt(dot(eye, eye)) - 1.0, sky.medium.xyz, sky.medium.w);
    var color = vec3(0.0);
    for (var i = 0u; i < lights.n_directional_lights; i += 1u) {
        let to_sun = lights.directional_lights[i].direction_to_light;
        color += lights.directional_lights[i].color.rgb
            * air::glow(eye, -V, 1e6, to_sun, here, 6);
    }
    // Fades out before the mesh ends.
    let fade = saturate((sky.extent - distance) / (0.3 * (sky.extent - 1.0)));
    color *= view.exposure * select(fade, 1.0, x > 0.0);
    var pbr_input = pbr_types::pbr_input_new();
    pbr_input.frag_coord = in.position;
    pbr_input.world_position = in.world_position;
    pbr_input.material.flags = pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_ADD;
    return pbr_functions::main_pass_post_lighting_processing(pbr_input, vec4(color, 1.0));
}
