// Tiles in shadow maps: where the light of a sun ends.
#import bevy_pbr::{
    mesh_functions,
    prepass_io::VertexOutput,
    view_transformations::position_world_to_clip,
}
#import bevy_tectonics::{ground::planet, lift}

@vertex
fn vertex(in: lift::Vertex) -> VertexOutput {
    var out: VertexOutput;
    // The view is the light's: tiles have the shape that the camera sees.
    let here = lift::tile(mesh_functions::get_tag(in.instance_index));
    out.world_position = lift::shape(in, here, planet.eye).world_position;
    out.position = position_world_to_clip(out.world_position.xyz);
#ifdef UNCLIPPED_DEPTH_ORTHO_EMULATION
    // What stands between the sun and the map is not cut off, as in Bevy's `prepass.wgsl`.
    out.unclipped_depth = out.position.z;
    out.position.z = min(out.position.z, 1.0);
#endif
#ifdef VERTEX_OUTPUT_INSTANCE_INDEX
    out.instance_index = in.instance_index;
#endif
    return out;
}
