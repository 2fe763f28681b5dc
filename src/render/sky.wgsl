// The glow of the air beyond the limb.
#import bevy_pbr::{
    mesh_functions,
    mesh_view_bindings::{view, lights},
    view_transformations::position_world_to_clip,
    pbr_types,
    pbr_functions,
}
#import bevy_tectonics::air

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> extent: vec4<f32>;

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
    let radius = length(world_from_local[0].xyz) / extent.x;
    let orthographic = view.clip_from_view[3].w == 1.0;
    let V = pbr_functions::calculate_view(in.world_position, orthographic);
    // Where the line of sight comes closest to the planet.
    let offset = (in.world_position.xyz - world_from_local[3].xyz) / radius;
    let nearest = offset - V * dot(offset, V);
    let distance = length(nearest);
    let up = nearest / max(distance, 1e-6);
    let thickness = 2.0 * air::slant(0.0) * exp(-max(distance - 1.0, 0.0) / air::SCALE_HEIGHT);
    var color = vec3(0.0);
    for (var i = 0u; i < lights.n_directional_lights; i += 1u) {
        let to_sun = lights.directional_lights[i].direction_to_light;
        color += lights.directional_lights[i].color.rgb
            * air::scattered(thickness, dot(up, to_sun), dot(V, to_sun));
    }
    // Fades out before the mesh ends.
    color *= view.exposure * saturate((extent.x - distance) / (0.3 * (extent.x - 1.0)));
    var pbr_input = pbr_types::pbr_input_new();
    pbr_input.frag_coord = in.position;
    pbr_input.world_position = in.world_position;
    pbr_input.material.flags = pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_ADD;
    return pbr_functions::main_pass_post_lighting_processing(pbr_input, vec4(color, 1.0));
}
