// Tiles of the ground up close, and of the sea above it.
#define_import_path bevy_tectonics::tile
#import bevy_pbr::{
    mesh_bindings::mesh,
    mesh_functions,
    mesh_view_bindings::{view, lights, globals},
    view_transformations::position_world_to_clip,
    pbr_types,
    pbr_functions,
}
#import bevy_tectonics::{air, bevy_air, detail, ground, lift, light}
#import bevy_tectonics::ground::planet

struct Point {
    @builtin(position) position: vec4<f32>,
    @location(0) world_position: vec4<f32>,
    @location(1) direction: vec3<f32>,
    @location(2) slope: vec3<f32>,
    // In m, modulo the period.
    @location(3) place: vec3<f32>,
    // Elevation of the ground in km.
    @location(4) height: f32,
    @location(5) @interpolate(flat) instance_index: u32,
}

fn raise(in: lift::Vertex) -> Point {
    var out: Point;
    let here = lift::tile(mesh_functions::get_tag(in.instance_index));
    let seen = lift::shape(in, here, view.world_position);
    out.world_position = seen.world_position;
    out.position = position_world_to_clip(out.world_position.xyz);
    out.direction = in.up;
    out.slope = lift::slope(in, seen.coarse);
    out.place = here.origin + 1000.0 * planet.radius_km * in.position;
    out.height = seen.height;
    out.instance_index = in.instance_index;
    return out;
}

// What is too small to be in the tiles: slope, and height in w. It is colour and light alone.
fn grain(place: vec3<f32>, footprint: f32) -> vec4<f32> {
    var sum = vec4(0.0);
    for (var cells = 128; cells <= 8192; cells *= 4) {
        let size = lift::PERIOD / f32(cells);
        let strength = saturate(1.0 - 2.0 * footprint / size);
        if strength > 0.0 {
            let here = detail::repeated(place / size, cells - 1);
            sum += strength * vec4(here.yzw, here.x);
        }
    }
    return sum;
}

// Turned from octave to octave, or noise shows its lattice.
const TURN: mat3x3<f32> = mat3x3(0.00, 0.80, 0.60, -0.80, 0.36, -0.48, -0.60, -0.48, 0.64);

// Patches of ground from 50 km down to 150 m, from -1 to 1: where plants stand dense, where stones lie.
fn patches(direction: vec3<f32>, footprint: f32) -> vec2<f32> {
    var sum = vec2(0.0);
    var size = 50000.0;
    var weight = 0.24;
    var turned = direction;
    for (var i = 0; i < 5 && size > 2.0 * footprint; i += 1) {
        turned = TURN * turned;
        let strength = weight * saturate(1.0 - 2.0 * footprint / size);
        let place = turned * (1000.0 * planet.radius_km / size) + 31.0 * f32(i);
        // Where noise is steep is not where it is high: one lookup for both.
        let here = detail::noise(place);
        sum += strength * vec2(here.x, 0.6 * here.y);
        size *= 0.23;
        weight = min(1.25 * weight, 0.45);
    }
    return clamp(sum, vec2(-1.0), vec2(1.0));
}

// Where the wind blows: easterly in the tropics and near the poles, westerly between, calm where they meet.
fn wind(direction: vec3<f32>) -> vec3<f32> {
    let north = vec3(0.0, 1.0, 0.0);
    let east = normalize(cross(north, direction) + vec3(1e-5, 0.0, 0.0));
    let latitude = abs(direction.y);
    let westerly = smoothstep(0.42, 0.58, latitude) - smoothstep(0.82, 0.92, latitude);
    let poleward = cross(direction, east) * (2.0 * smoothstep(-0.1, 0.1, direction.y) - 1.0);
    return (0.9 * east + 0.44 * poleward) * (2.0 * westerly - 1.0);
}

// Slope of the waves. Each is a number of crests per period along every axis. Those that run with the wind are
// highest.
fn waves(place: vec3<f32>, direction: vec3<f32>, footprint: f32) -> vec3<f32> {
    var crests = array(
        vec3(97.0, 61.0, -73.0), vec3(-151.0, 113.0, 59.0), vec3(167.0, -241.0, 191.0), vec3(-307.0, -283.0, 401.0),
        vec3(601.0, 523.0, 457.0), vec3(-887.0, 1103.0, -641.0), vec3(1721.0, -1409.0, -1999.0),
        vec3(-2503.0, -2707.0, 1103.0), vec3(3301.0, -2203.0, 2999.0), vec3(1009.0, 4409.0, -3607.0),
        vec3(5903.0, 4507.0, 5309.0), vec3(-8111.0, 7919.0, 3001.0),
    );
    let wind = wind(direction);
    var sum = vec3(0.0);
    for (var i = 0; i < 12; i += 1) {
        let count = length(crests[i]);
        let size = lift::PERIOD / count;
        let strength = saturate(1.0 - 3.0 * footprint / size);
        if strength > 0.0 {
            // Waves in deep water; few run against the wind.
            let along = crests[i] / count;
            let lee = dot(along, wind);
            let phase = 6.2831853 * fract(dot(crests[i], place) / lift::PERIOD);
            let turn = sqrt(9.81 * 6.2831853 / size) * globals.time;
            let ahead = 0.01 + 0.07 * saturate(lee) * saturate(lee);
            let back = 0.01 + 0.07 * saturate(-lee) * saturate(-lee);
            sum += strength * (ahead * cos(phase - turn) + back * cos(phase + turn)) * along;
        }
    }
    return sum;
}

fn shade(in: Point) -> vec4<f32> {
    if planet.tiles < 1.0 && !ground::is_tiled(in.position.xy) {
        discard;
    }
    let sea = lift::tile(mesh_functions::get_tag(in.instance_index)).is_sea;
    // In km.
    let depth = planet.sea - in.height;
    if sea == (depth <= 0.0) {
        discard;
    }
    let world_from_local = mesh_functions::get_world_from_local(in.instance_index);
    let radius = length(world_from_local[0].xyz);
    let direction = normalize(in.direction);
    let up = normalize(mesh_functions::mesh_normal_local_to_world(direction, in.instance_index));
    let orthographic = view.clip_from_view[3].w == 1.0;
    let V = pbr_functions::calculate_view(in.world_position, orthographic);
    let away = distance(view.world_position, in.world_position.xyz) / radius;

    // Size of a pixel on the ground in m: the geometric mean keeps the limb sharp.
    let footprint = sqrt(length(dpdx(in.place)) * length(dpdy(in.place)));
    let level = log2(max(0.001 * footprint / planet.radius_km * planet.size * 0.55, 1e-6));
    let here = ground::ground(direction, direction, max(level, 0.0));

    // From afar light shows relief that outlines do not; up close it is as steep as it is.
    let far = smoothstep(9.5, 13.5, log2(max(footprint, 1.0)));
    let exaggeration = planet.height * planet.radius_km;
    let steepness = exaggeration * mix(1.0, planet.shade / max(exaggeration, 1e-3), far);
    let slope = in.slope * steepness;
    let coarse_tilt = slope / sqrt(1.0 + mix(0.0, 0.45, far) * dot(slope, slope));
    let fine = grain(in.place, footprint);
    let steep = length(in.slope);

    var base: vec3<f32>;
    var normal = up;
    var wet = 0.0;
    if sea {
        let meters = 1000.0 * depth;
        base = ground::colour(ground::SEA, depth);
        // The bed shines through shallow water.
        let clear = exp(-meters / 5.0);
        base = mix(base, 0.5 * ground::colour(ground::BED, 0.0), 0.5 * clear);
        let wave = waves(in.place, direction, footprint);
        normal = normalize(up - mesh_functions::mesh_normal_local_to_world(wave - direction * dot(wave, direction), in.instance_index));
        // Surf: about as far from the shore as the bed says.
        let shore = meters / max(steep, 0.01);
        let band = max(9.0, 1.3 * footprint);
        let surf = 0.5 + 0.5 * sin(0.35 * shore + 0.8 * globals.time + 3.0 * fine.w);
        let foam = saturate(1.2 - shore / band) * mix(surf, 0.55, saturate(footprint / 12.0)) * saturate(0.6 + fine.w);
        let pack = ground::packed(here.climate);
        base = mix(mix(base, planet.tints.foam.rgb, 0.85 * foam), planet.tints.pack_ice.rgb, 0.92 * pack);
        wet = (1.0 - foam) * (1.0 - pack) * (1.0 + 0.5 * here.climate.w);
    } else {
        let height = in.height - planet.datum;
        if height > 0.0 || planet.sea == planet.datum {
            let patch_ = patches(direction, footprint);
            let climate = here.climate + vec4(0.0, 0.0, 0.0, 0.25 * fine.w);
            // Snow and plants end at ragged lines.
            let ragged = max(height + 0.18 * (1.0 - far) * patch_.x * saturate(2.0 * height), 0.0);
            base = ground::land_colour(ragged, length(coarse_tilt), climate);
            base = mix(ground::grown_over(base, patch_, steep + 0.1 * fine.w, height, climate), base, far);
            // Beaches.
            let dry = 1000.0 * height;
            let sand = (1.0 - smoothstep(1.5, 5.0, dry + 2.0 * fine.w)) * (1.0 - smoothstep(0.08, 0.25, steep)) * (1.0 - far);
            base = mix(base, 0.8 * ground::colour(ground::BED, 0.0), sand);
        } else {
            base = ground::colour(ground::BED, -height);
        }
        base *= 1.0 + 0.16 * fine.w;
        let tilt = coarse_tilt + (0.08 + 0.14 * min(steep, 1.0)) * (fine.xyz - direction * dot(fine.xyz, direction));
        normal = normalize(mesh_functions::mesh_normal_local_to_world(normalize(direction - tilt), in.instance_index));
    }
    base = ground::BRIGHTNESS * base * (1.0 - here.overlay.a) + here.overlay.rgb;
    wet *= 1.0 - here.overlay.a;

    var pbr_input = pbr_types::pbr_input_new();
    pbr_input.flags = mesh[in.instance_index].flags;
    pbr_input.is_orthographic = orthographic;
    pbr_input.V = V;
    pbr_input.frag_coord = in.position;
    pbr_input.world_position = in.world_position;
    pbr_input.world_normal = up;
    pbr_input.N = normal;
    pbr_input.material.base_color = vec4(base, 1.0);
    pbr_input.material.metallic = 0.0;
    pbr_input.material.perceptual_roughness = mix(0.95, light::WATER, saturate(wet));
    pbr_input.material.reflectance = vec3(mix(0.1, 0.36, saturate(wet)));
    var color = ground::shine(pbr_input, wet);

    // The air in between, unless Bevy draws it, and the light of the sky.
    let drawn = select(in.height, planet.sea, sea);
    let place = up * (1.0 + planet.height * drawn);
    let eye = place + V * away;
    let altitude = sqrt(dot(eye, eye)) - 1.0;
    let here_air = air::seen_from(altitude, planet.air.xyz, planet.air.w);
    let x = dot(eye, -V);
    let z = sqrt(max(dot(eye, eye) - x * x, 0.0));
    let centre = in.world_position.xyz - radius * place;
    let way = select(air::between(x, x + away, z, here_air.scale), 0.0, bevy_air::surrounds(centre));
    var haze = vec3(0.0);
    var sky = vec3(0.0);
    for (var i = 0u; i < lights.n_directional_lights; i += 1u) {
        let to_sun = lights.directional_lights[i].direction_to_light;
        let sun = lights.directional_lights[i].color.rgb;
        haze += sun * air::veil(place, V, away, way, to_sun, here_air);
        sky += sun * 3.1415927 * air::PHASE * air::arrives(place, to_sun, here_air) * (1.0 - exp(-2.0 * here_air.depth));
    }
    // From straight ahead comes most of the sky's light, on water its mirror image.
    let facing = saturate(0.5 + 0.5 * dot(normal, up));
    let mirror = 0.02 + 0.98 * pow(1.0 - saturate(dot(normal, V)), 5.0);
    color += view.exposure * sky * mix(1.6 * facing * base, vec3(2.0 * mirror), saturate(wet));
    color = color * exp(-air::LOST * here_air.depth * way) + view.exposure * haze;
    return pbr_functions::main_pass_post_lighting_processing(pbr_input, vec4(color, 1.0));
}
