// Land and sea of a planet. The ground comes from cube maps of two snapshots, A and B.
#import bevy_pbr::{
    mesh_bindings::mesh,
    mesh_functions,
    mesh_view_bindings::{view, lights},
    view_transformations::position_world_to_clip,
    pbr_types,
    pbr_functions,
}
#import bevy_tectonics::{air, detail, light}

struct Planet {
    drift: vec2<f32>,
    level: vec2<f32>,
    overlay: vec2<f32>,
    mix: f32,
    size: f32,
    height: f32,
    shade: f32,
    sea: f32,
    datum: f32,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> planet: Planet;
@group(#{MATERIAL_BIND_GROUP}) @binding(1) var relief_a: texture_cube<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(2) var smooth_sampler: sampler;
@group(#{MATERIAL_BIND_GROUP}) @binding(3) var relief_b: texture_cube<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(4) var climate_a: texture_cube<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(5) var climate_b: texture_cube<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(6) var velocity_a: texture_cube<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(7) var velocity_b: texture_cube<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(8) var overlay_a: texture_cube<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(9) var overlay_b: texture_cube<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(10) var palette: texture_2d<f32>;

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
    return log2(max(planet.size / 128.0, 1.0));
}

@vertex
fn vertex(in: Vertex) -> Point {
    var out: Point;
    let direction = in.position;
    out.direction = direction;
    out.in_a = direction;
    out.in_b = direction;
    var elevation = 0.0;
    if planet.mix < 1.0 {
        let velocity = textureSampleLevel(velocity_a, smooth_sampler, direction, 0.0).xyz;
        out.in_a -= planet.drift.x * velocity;
        let level = max(mesh_level(), planet.level.x);
        elevation += (1.0 - planet.mix) * textureSampleLevel(relief_a, smooth_sampler, out.in_a, level).x;
    }
    if planet.mix > 0.0 {
        let velocity = textureSampleLevel(velocity_b, smooth_sampler, direction, 0.0).xyz;
        out.in_b += planet.drift.y * velocity;
        let level = max(mesh_level(), planet.level.y);
        elevation += planet.mix * textureSampleLevel(relief_b, smooth_sampler, out.in_b, level).x;
    }
    let height = planet.height * max(elevation, planet.sea);
    let world_from_local = mesh_functions::get_world_from_local(in.instance_index);
    out.world_position = world_from_local * vec4(direction * (1.0 + height), 1.0);
    out.position = position_world_to_clip(out.world_position.xyz);
    out.instance_index = in.instance_index;
    return out;
}

struct Ground {
    // Elevation in km, slope in m per km.
    relief: vec4<f32>,
    // Youth of mountains, aridity, latitude of the climate in degrees, variety from -1 to 1.
    climate: vec4<f32>,
    // Premultiplied.
    overlay: vec4<f32>,
}

fn tint(texel: vec4<f32>, opacity: f32) -> vec4<f32> {
    let alpha = texel.a * opacity;
    return vec4(texel.rgb * alpha, alpha);
}

fn ground(in: Point, level: f32) -> Ground {
    var out: Ground;
    if planet.mix < 1.0 {
        let share = 1.0 - planet.mix;
        let fine = max(level, planet.level.x);
        out.relief += share * textureSampleLevel(relief_a, smooth_sampler, in.in_a, fine);
        out.climate += share * textureSampleLevel(climate_a, smooth_sampler, in.in_a, max(level - 1.0, planet.level.x));
        if planet.overlay.x > 0.0 {
            let texel = textureSampleLevel(overlay_a, smooth_sampler, in.in_a, fine);
            out.overlay += share * tint(texel, planet.overlay.x);
        }
    }
    if planet.mix > 0.0 {
        let share = planet.mix;
        let fine = max(level, planet.level.y);
        out.relief += share * textureSampleLevel(relief_b, smooth_sampler, in.in_b, fine);
        out.climate += share * textureSampleLevel(climate_b, smooth_sampler, in.in_b, max(level - 1.0, planet.level.y));
        if planet.overlay.y > 0.0 {
            let texel = textureSampleLevel(overlay_b, smooth_sampler, in.in_b, fine);
            out.overlay += share * tint(texel, planet.overlay.y);
        }
    }
    return out;
}

// The palette is what eyes expect of a picture; the ground itself is darker.
const BRIGHTNESS: f32 = 0.85;

// Rows of the palette.
const LUSH: f32 = 0.0;
const TEMPERATE: f32 = 1.0;
const BOREAL: f32 = 2.0;
const TUNDRA: f32 = 3.0;
const ARID: f32 = 4.0;
const ROCK: f32 = 5.0;
const SEA: f32 = 6.0;
const BED: f32 = 7.0;

const ICE: vec3<f32> = vec3<f32>(0.80, 0.85, 0.90);
const PACK_ICE: vec3<f32> = vec3<f32>(0.62, 0.69, 0.76);

// A colour of the palette at a height or depth in km.
fn colour(row: f32, height: f32) -> vec3<f32> {
    let column = sqrt(saturate(height / 8.0)) * 255.0 + 0.5;
    return textureSampleLevel(palette, smooth_sampler, vec2(column / 256.0, (row + 0.5) / 8.0), 0.0).rgb;
}

// Belts of latitude are those of `Climate`; variety makes their edges ragged.
fn land_colour(height: f32, tilt: f32, climate: vec4<f32>) -> vec3<f32> {
    let youth = saturate(climate.x);
    let arid = climate.y;
    let latitude = climate.z;
    let variety = climate.w;
    // Old mountains are worn and grown over.
    let bare = height * mix(0.6, 1.0, youth);
    var ground: vec3<f32>;
    if arid < 1.0 {
        let lush = 1.0 - smoothstep(9.0, 25.0, latitude + 8.0 * variety);
        ground = mix(colour(TEMPERATE, bare), colour(LUSH, bare), lush);
        let boreal = smoothstep(44.0, 58.0, latitude + 4.0 * variety);
        if boreal > 0.0 {
            let tundra = smoothstep(60.0, 68.0, latitude + 5.0 * variety);
            ground = mix(ground, mix(colour(BOREAL, bare), colour(TUNDRA, bare), tundra), boreal);
        }
    }
    if arid > 0.0 {
        ground = mix(ground, colour(ARID, bare), arid);
    }
    ground *= 1.0 - 0.16 * variety;
    let rock = youth * smoothstep(0.4, 2.0, height) * (0.5 + 0.5 * smoothstep(0.1, 0.5, tilt));
    if rock > 0.0 {
        ground = mix(ground, colour(ROCK, height), 0.85 * rock);
    }
    let cold = saturate((latitude - 25.0) / 47.0);
    let line = 5.4 * (1.0 - cold * cold) - 0.2 * cold;
    let snow = smoothstep(line - 0.7, line + 0.3, height - 0.5 * tilt);
    let ice = smoothstep(68.5, 73.5, latitude + 3.5 * variety);
    return mix(ground, ICE, max(ice, 0.95 * snow));
}

@fragment
fn fragment(in: Point) -> @location(0) vec4<f32> {
    // A pixel's extent in texels. The geometric mean keeps the limb sharp.
    let direction = normalize(in.direction);
    let extent = sqrt(length(dpdx(in.direction)) * length(dpdy(in.direction)));
    let level = log2(max(extent * planet.size * 0.55, 1e-6));
    let here = ground(in, max(level, 0.0));

    let fine = detail::detail(direction, planet.size, level);
    let height = here.relief.x - planet.datum;
    let above_sea = here.relief.x - planet.sea + 0.015 * fine.w;
    // Squeezed, so that the edge of a shelf beside the deep is not taken for a coast.
    let squeezed = above_sea / (abs(above_sea) + 0.06);
    let coast = max(0.6 * fwidth(squeezed), 1e-4);
    let land = smoothstep(-coast, coast, squeezed);
    let slope = here.relief.yzw * 0.001 * planet.shade;
    // Never steeper than light can show.
    let coarse_tilt = slope / sqrt(1.0 + 0.45 * dot(slope, slope));
    let tilt = coarse_tilt + (0.03 + 0.3 * length(coarse_tilt)) * fine.xyz;

    let world_from_local = mesh_functions::get_world_from_local(in.instance_index);
    let up = normalize(mesh_functions::mesh_normal_local_to_world(direction, in.instance_index));
    let relief_normal = mesh_functions::mesh_normal_local_to_world(normalize(direction - tilt), in.instance_index);

    var base = vec3(0.0);
    if land > 0.0 {
        if height > 0.0 || planet.sea == planet.datum {
            base += land * land_colour(max(height, 0.0), length(tilt), here.climate + vec4(0.0, 0.0, 0.0, 0.25 * fine.w));
        } else {
            base = colour(BED, -height);
        }
    }
    var pack = 0.0;
    if land < 1.0 {
        var water = colour(SEA, max(-height, 0.0));
        // The sea floor shimmers through.
        let sun = lights.directional_lights[0].direction_to_light;
        let lit = dot(relief_normal, sun) - dot(up, sun);
        water *= 1.0 + clamp(2.0 * lit, -0.35, 0.6);
        pack = smoothstep(74.5, 79.0, here.climate.z + 3.5 * here.climate.w);
        base += (1.0 - land) * mix(water, PACK_ICE, 0.92 * pack);
    }
    base = BRIGHTNESS * base * (1.0 - here.overlay.a) + here.overlay.rgb;
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
    // Planets near a lamp are lit with all that Bevy has. The usual sun needs a fraction of that, and
    // to software renderers even a branch not taken is dear.
#ifdef PLANET_LAMPS
    var color = pbr_functions::apply_pbr_lighting(pbr_input);
#else ifdef ENVIRONMENT_MAP
    var color = pbr_functions::apply_pbr_lighting(pbr_input);
#else
    var color = vec4(view.exposure * light::lit(pbr_input, wet), 1.0);
#endif

    // The air between here and the viewer.
    let way = air::slant(dot(up, pbr_input.V));
    var haze = vec3(0.0);
    for (var i = 0u; i < lights.n_directional_lights; i += 1u) {
        let to_sun = lights.directional_lights[i].direction_to_light;
        haze += lights.directional_lights[i].color.rgb
            * air::scattered(way, dot(up, to_sun), dot(pbr_input.V, to_sun));
    }
    color = vec4(color.rgb * exp(-0.5 * air::DEPTH * way) + view.exposure * haze, 1.0);
    return pbr_functions::main_pass_post_lighting_processing(pbr_input, color);
}
