// Land and sea of a planet. The ground comes from cube maps of two snapshots, A and B.
#ifdef PLANET_TILES
#import bevy_tectonics::{lift, tile}

@vertex
fn vertex(in: lift::Vertex) -> tile::Point {
    return tile::raise(in);
}

@fragment
fn fragment(in: tile::Point) -> @location(0) vec4<f32> {
    return tile::shade(in);
}
#else
#import bevy_pbr::{
    mesh_bindings::mesh,
    mesh_functions,
    mesh_view_bindings::{view, lights},
    view_transformations::position_world_to_clip,
    pbr_types,
    pbr_functions,
}
#import bevy_tectonics::{air, bevy_air, detail, ground, light}

struct Vertex {
    @builtin(instance_index) instance_index: u32,
    @location(0) position: vec3<f32>,
}

struct Point {
    @builtin(position) position: vec4<f32>,
    @location(0) world_position: vec4<f32>,
    @location(1) direction: vec3<f32>,
    // Where the ground that is here now lies in A and in B.
    @location(2) in_a: vec3<f32>,
    @location(3) in_b: vec3<f32>,
    @location(4) @interpolate(flat) instance_index: u32,
}

// Level of the relief that is about as fine as the mesh.
fn mesh_level() -> f32 {
    return log2(max(ground::planet.size / 128.0, 1.0));
}

@vertex
fn vertex(in: Vertex) -> Point {
    var out: Point;
    let direction = in.position;
    out.direction = direction;
    out.in_a = direction;
    out.in_b = direction;
    var elevation = 0.0;
    if ground::planet.mix < 1.0 {
        let velocity = textureSampleLevel(ground::velocity_a, ground::smooth_sampler, direction, 0.0).xyz;
        out.in_a -= ground::planet.drift.x * velocity;
        let level = max(mesh_level(), ground::planet.level.x);
        elevation += (1.0 - ground::planet.mix) * textureSampleLevel(ground::relief_a, ground::smooth_sampler, out.in_a, level).x;
    }
    if ground::planet.mix > 0.0 {
        let velocity = textureSampleLevel(ground::velocity_b, ground::smooth_sampler, direction, 0.0).xyz;
        out.in_b += ground::planet.drift.y * velocity;
        let level = max(mesh_level(), ground::planet.level.y);
        elevation += ground::planet.mix * textureSampleLevel(ground::relief_b, ground::smooth_sampler, out.in_b, level).x;
    }
    let height = ground::planet.height * max(elevation, ground::planet.sea);
    let world_from_local = mesh_functions::get_world_from_local(in.instance_index);
    out.world_position = world_from_local * vec4(direction * (1.0 + height), 1.0);
    out.position = position_world_to_clip(out.world_position.xyz);
    out.instance_index = in.instance_index;
    return out;
}

@fragment
fn fragment(in: Point) -> @location(0) vec4<f32> {
    if ground::planet.tiles > 0.0 && ground::is_tiled(in.position.xy) {
        discard;
    }
    // A pixel's extent in texels. The geometric mean keeps the limb sharp.
    let direction = normalize(in.direction);
    let extent = sqrt(length(dpdx(in.direction)) * length(dpdy(in.direction)));
    let level = log2(max(extent * ground::planet.size * 0.55, 1e-6));
    let here = ground::ground(in.in_a, in.in_b, max(level, 0.0));

    let fine = detail::detail(direction, ground::planet.size, level);
    let height = here.relief.x - ground::planet.datum;
    let above_sea = here.relief.x - ground::planet.sea + 0.015 * fine.w;
    // Squeezed, so that the edge of a shelf beside the deep is not taken for a coast.
    let squeezed = above_sea / (abs(above_sea) + 0.06);
    let coast = max(0.6 * fwidth(squeezed), 1e-4);
    let land = smoothstep(-coast, coast, squeezed);
    let slope = here.relief.yzw * 0.001 * ground::planet.shade;
    // Never steeper than light can show.
    let coarse_tilt = slope / sqrt(1.0 + 0.45 * dot(slope, slope));
    let tilt = coarse_tilt + (0.03 + 0.3 * length(coarse_tilt)) * fine.xyz;

    let world_from_local = mesh_functions::get_world_from_local(in.instance_index);
    let up = normalize(mesh_functions::mesh_normal_local_to_world(direction, in.instance_index));
    let relief_normal = mesh_functions::mesh_normal_local_to_world(normalize(direction - tilt), in.instance_index);

    var base = vec3(0.0);
    if land > 0.0 {
        if height > 0.0 || ground::planet.sea == ground::planet.datum {
            base += land * ground::land_colour(max(height, 0.0), length(tilt), here.climate + vec4(0.0, 0.0, 0.0, 0.25 * fine.w));
        } else {
            base = ground::colour(ground::BED, -height);
        }
    }
    var pack = 0.0;
    if land < 1.0 {
        var water = ground::colour(ground::SEA, max(-height, 0.0));
        // The sea floor shimmers through.
        let sun = lights.directional_lights[0].direction_to_light;
        let lit = dot(relief_normal, sun) - dot(up, sun);
        water *= 1.0 + clamp(2.0 * lit, -0.35, 0.6);
        pack = ground::packed(here.climate);
        base += (1.0 - land) * mix(water, ground::planet.tints.pack_ice.rgb, 0.92 * pack);
    }
    base = ground::BRIGHTNESS * base * (1.0 - here.overlay.a) + here.overlay.rgb;
    // Winds roughen the sea in patches.
    let calm = 1.0 + 0.5 * here.climate.w;
    let wet = calm * (1.0 - land) * (1.0 - pack) * (1.0 - here.overlay.a);

    var pbr_input = pbr_types::pbr_input_new();
    pbr_input.flags = mesh[in.instance_index].flags;
    pbr_input.is_orthographic = view.clip_from_view[3].w == 1.0;
    pbr_input.V = pbr_functions::calculate_view(in.world_position, pbr_input.is_orthographic);
    pbr_input.frag_coord = in.position;
    pbr_input.world_position = in.world_position;
    pbr_input.world_normal = up;
    pbr_input.N = normalize(mix(up, relief_normal, max(land, 0.5 * here.overlay.a)));
    pbr_input.material.base_color = vec4(base, 1.0);
    pbr_input.material.metallic = 0.0;
    pbr_input.material.perceptual_roughness = mix(0.95, light::WATER, saturate(wet));
    pbr_input.material.reflectance = vec3(mix(0.1, 0.36, saturate(wet)));
    var color = vec4(ground::shine(pbr_input, wet), 1.0);

    // The air between here and the viewer, unless Bevy draws it.
    let depth = air::FAR_SHARE * ground::planet.air.xyz;
    let way = select(air::slant(dot(up, pbr_input.V)), 0.0, bevy_air::surrounds(world_from_local[3].xyz));
    var haze = vec3(0.0);
    for (var i = 0u; i < lights.n_directional_lights; i += 1u) {
        let to_sun = lights.directional_lights[i].direction_to_light;
        haze += lights.directional_lights[i].color.rgb
            * air::scattered(depth, way, dot(up, to_sun), dot(pbr_input.V, to_sun));
    }
    color = vec4(color.rgb * exp(-0.5 * depth * way) + view.exposure * haze, 1.0);
    return pbr_functions::main_pass_post_lighting_processing(pbr_input, color);
}
#endif
