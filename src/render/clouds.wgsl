// Clouds: a thin shell around the planet. How many there are follows from the belts of the winds and from the ground
// below, vertex by vertex; how they look is noise, pixel by pixel.
#import bevy_pbr::{
    mesh_functions,
    mesh_view_bindings::{view, lights, globals},
    view_transformations::position_world_to_clip,
    pbr_types,
    pbr_functions,
}
#import bevy_tectonics::{air, detail, ground}
#import bevy_tectonics::ground::planet

struct Clouds {
    // Opacity of the thickest in w.
    color: vec4<f32>,
    // What noise has to exceed where clouds are as common as on average, in standard deviations.
    threshold: f32,
    // Height of the shell, and distance from a camera within which it is not drawn, in radii.
    lift: f32,
    near: f32,
    // Radians per second by which belts turn.
    turn: f32,
    // Seconds until other weather follows, and how many times there is other weather.
    period: f32,
    periods: f32,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(11) var<uniform> clouds: Clouds;

struct Vertex {
    @builtin(instance_index) instance_index: u32,
    @location(0) position: vec3<f32>,
}

struct Point {
    @builtin(position) position: vec4<f32>,
    @location(0) world_position: vec4<f32>,
    @location(1) direction: vec3<f32>,
    // Where in the noise this weather and the next one are.
    @location(2) place: vec3<f32>,
    @location(3) next: vec3<f32>,
    // What noise has to exceed, and how even the sky is.
    @location(4) weather: vec2<f32>,
    @location(5) @interpolate(flat) instance_index: u32,
}

// Turned from octave to octave, or noise shows its lattice.
const TURN: mat3x3<f32> = mat3x3(0.00, 0.80, 0.60, -0.80, 0.36, -0.48, -0.60, -0.48, 0.64);
// Clouds are longer along the belts than across.
const STRETCH: vec3<f32> = vec3<f32>(1.0, 1.5, 1.0);
// Lows and highs along a radius; cells of the largest clouds, and of the curls that bend them.
const LOWS: f32 = 4.3;
const LARGEST: f32 = 8.0;
const CURLS: f32 = 13.0;
// Cells of the smallest clouds in km.
const SMALLEST: f32 = 0.15;
// About the standard deviation of the sum of all octaves.
const SPREAD: f32 = 0.44;
const FRAC_1_PI: f32 = 0.31830989;

// Share of westerlies in the winds of a latitude, given as its sine.
fn westerly(y: f32) -> f32 {
    return smoothstep(0.42, 0.58, abs(y)) - smoothstep(0.82, 0.92, abs(y));
}

// Where storms cross.
fn stormy(y: f32) -> f32 {
    return smoothstep(0.55, 0.72, abs(y)) * (1.0 - smoothstep(0.88, 0.95, abs(y)));
}

// The wind, as tiles have it over their seas.
fn blown(direction: vec3<f32>) -> vec3<f32> {
    let east = normalize(cross(vec3(0.0, 1.0, 0.0), direction) + vec3(1e-5, 0.0, 0.0));
    let poleward = cross(direction, east) * (2.0 * smoothstep(-0.1, 0.1, direction.y) - 1.0);
    return (0.9 * east + 0.44 * poleward) * (2.0 * westerly(direction.y) - 1.0);
}

// How much cloudier a place is than the average, in standard deviations of the noise. `beside` is the ground to the
// east of it.
fn cloudiness(direction: vec3<f32>, here: ground::Ground, beside: ground::Ground) -> f32 {
    let latitude = here.climate.z;
    // The rain of the tropics wavers about the equator as the climates do.
    let north = degrees(asin(clamp(direction.y, -1.0, 1.0)));
    let from_equator = (north + latitude - abs(north)) / 7.0;
    let belts = 0.65 * exp(-from_equator * from_equator)
        - 0.60 * smoothstep(9.0, 18.0, latitude) * (1.0 - smoothstep(30.0, 42.0, latitude))
        + 0.45 * smoothstep(38.0, 52.0, latitude) * (1.0 - smoothstep(62.0, 76.0, latitude))
        + 0.25 * smoothstep(62.0, 76.0, latitude);
    let land = smoothstep(-0.15, 0.15, here.relief.x - planet.sea);
    // Air that is pushed up a slope rains out; beyond the crest it sinks and clears.
    let rise = dot(blown(direction), here.relief.yzw) / 9.0;
    // Off the western coasts of the subtropics the sea is cold, and low cloud lies on it.
    let cold = smoothstep(10.0, 17.0, latitude) * (1.0 - smoothstep(28.0, 36.0, latitude));
    let deck = cold * (1.0 - land) * smoothstep(-0.3, 0.3, beside.relief.x - planet.sea);
    return 0.14 + belts - 0.8 * land * here.climate.y + 0.9 * rise / (1.0 + abs(rise)) + 1.1 * deck;
}

fn about_axis(v: vec3<f32>, angle: f32) -> vec3<f32> {
    let c = cos(angle);
    let s = sin(angle);
    return vec3(c * v.x + s * v.z, v.y, c * v.z - s * v.x);
}

// Angle by which a latitude, given as its sine, is turned: fronts lean towards the pole and the east.
fn lean(y: f32) -> f32 {
    return 0.6 * sqrt(y * y + 0.01);
}

// The same, and how far winds have blown in some seconds.
fn turned(y: f32, seconds: f32) -> f32 {
    return lean(y) + clouds.turn * seconds * (2.0 * westerly(y) - 1.0);
}

// Place in the noise from where the weather of a direction comes. In w: from highs, -1, to lows, 1.
fn carried(direction: vec3<f32>, angle: f32, seed: f32) -> vec4<f32> {
    var place = about_axis(direction, -angle);
    // Around lows winds go to the left in the north, and faster near the middle: clouds wind up.
    let curl = 0.15 / LOWS * mix(0.3, 1.0, stormy(direction.y)) * clamp(4.0 * direction.y, -1.0, 1.0);
    var low = 0.0;
    for (var i = 0; i < 2; i += 1) {
        let here = detail::noise(LOWS * place + seed);
        place += curl * cross(place, here.yzw);
        low = here.x;
    }
    return vec4(place, low);
}

// Noise of standard deviation 1, and in y its slope per radius towards the sun. Octaves end where pixels do; `pixel` is
// in radii.
fn shapes(place: vec3<f32>, seed: f32, to_sun: vec3<f32>, pixel: f32) -> vec2<f32> {
    let curls = detail::noise(CURLS * place + seed).yzw;
    var at = STRETCH * (place + 0.17 / CURLS * cross(place, curls));
    var sun = STRETCH * to_sun;
    var sum = vec2(0.0);
    var cells = LARGEST;
    var weight = 1.0;
    for (var i = 0; i < 12; i += 1) {
        let strength = weight * saturate(1.6 - 2.0 * pixel * cells);
        if strength <= 0.0 || cells * SMALLEST > planet.radius_km {
            break;
        }
        at = TURN * at;
        sun = TURN * sun;
        let here = detail::noise(cells * at + seed + 31.0 * f32(i));
        let steep = cells * dot(here.yzw, sun);
        // The small ones are heaps with creases between.
        let heap = sqrt(here.x * here.x + 0.004);
        let heaped = 1.8 * vec2(heap - 0.30, here.x / heap * steep);
        sum += strength * select(vec2(here.x, steep), heaped, i > 4);
        cells *= 2.3;
        // Heaps of a few km stand out; what is smaller frays them.
        weight = select(max(0.66 * weight, 0.22), 0.5 * weight, cells > 0.4 * planet.radius_km);
    }
    return sum / SPREAD;
}

// Winds would shear one weather to threads, so another follows: at the end of a period it fades in.
fn fade(time: f32) -> f32 {
    return select(0.0, smoothstep(0.6, 1.0, fract(time)), clouds.turn > 0.0);
}

// Clocks of shaders begin anew every hour, and weather with them.
fn seed(time: f32) -> f32 {
    return 7.3 * (floor(time) % clouds.periods);
}

@vertex
fn vertex(in: Vertex) -> Point {
    var out: Point;
    let direction = in.position;
    // The ground that is below, as in `planet.wgsl`, and about as coarse as the mesh: weather is larger.
    let velocity_a = textureSampleLevel(ground::velocity_a, ground::smooth_sampler, direction, 0.0).xyz;
    let velocity_b = textureSampleLevel(ground::velocity_b, ground::smooth_sampler, direction, 0.0).xyz;
    let in_a = direction - planet.drift.x * velocity_a;
    let in_b = direction + planet.drift.y * velocity_b;
    let level = log2(max(planet.size / 128.0, 1.0));
    let east = 0.12 * cross(vec3(0.0, 1.0, 0.0), direction);
    let here = ground::ground(in_a, in_b, level);
    let beside = ground::ground(in_a + east, in_b + east, level);

    let time = globals.time / clouds.period;
    let now = carried(direction, turned(direction.y, fract(time) * clouds.period), seed(time));
    out.place = now.xyz;
    out.next = now.xyz;
    var low = now.w;
    let follows = fade(time);
    if follows > 0.0 {
        let angle = turned(direction.y, (fract(time) - 1.0) * clouds.period);
        let next = carried(direction, angle, seed(time + 1.0));
        out.next = next.xyz;
        low = mix(low, next.w, follows);
    }
    // Air rises in lows.
    let cloudier = cloudiness(direction, here, beside) + 0.8 * stormy(direction.y) * low;
    out.weather = vec2(clouds.threshold - cloudier, smoothstep(60.0, 82.0, here.climate.z));

    let world_from_local = mesh_functions::get_world_from_local(in.instance_index);
    out.world_position = world_from_local * vec4(direction * (1.0 + clouds.lift), 1.0);
    out.position = position_world_to_clip(out.world_position.xyz);
    out.direction = direction;
    out.instance_index = in.instance_index;
    return out;
}

@fragment
fn fragment(in: Point, @builtin(front_facing) is_front: bool) -> @location(0) vec4<f32> {
    let pixel = max(sqrt(length(dpdx(in.direction)) * length(dpdy(in.direction))), 1e-9);
    let world_from_local = mesh_functions::get_world_from_local(in.instance_index);
    let radius = length(world_from_local[0].xyz);
    let direction = normalize(in.direction);
    let up = normalize(mesh_functions::mesh_normal_local_to_world(direction, in.instance_index));
    let orthographic = view.clip_from_view[3].w == 1.0;
    let V = pbr_functions::calculate_view(in.world_position, orthographic);
    // Lengths are in radii, places are from the centre.
    let away = select(distance(view.world_position, in.world_position.xyz) / radius, 8.0, orthographic);
    let place = (in.world_position.xyz - world_from_local[3].xyz) / radius;
    let eye = place + V * away;
    let altitude = sqrt(dot(eye, eye)) - 1.0;
    // From above the far side is not seen, even beyond the limb.
    if !is_front && altitude > clouds.lift {
        discard;
    }

    let time = globals.time / clouds.period;
    let sun = lights.directional_lights[0].direction_to_light;
    let local_sun = (vec4(sun, 0.0) * world_from_local).xyz / radius;
    let level_sun = about_axis(local_sun - direction * dot(direction, local_sun), -lean(direction.y));
    var shape = shapes(in.place, seed(time), level_sun, pixel);
    let follows = fade(time);
    if follows > 0.0 {
        let next = shapes(in.next, seed(time + 1.0), level_sun, pixel);
        // Two that know nothing of each other: their mean would be dull.
        shape = mix(shape, next, follows) / sqrt(follows * follows + (1.0 - follows) * (1.0 - follows));
    }
    // The sky of the poles is even and grey.
    let even = in.weather.y;
    // Edges are as sharp as they can be seen.
    let close = saturate(0.5 - 0.25 * log2(pixel * planet.radius_km));
    let sharp = mix(1.0, 2.5, close) * mix(1.0, 0.7, even);
    let thick = max(sharp * (shape.x - in.weather.x) + 0.95, 0.0);
    var alpha = 1.0 - exp(-0.9 * thick * thick);
    // Towards the limb the shell thins out, and a camera may fly through.
    let grazing = abs(dot(up, V));
    if is_front {
        alpha *= smoothstep(0.0, sqrt(clouds.lift), grazing);
    }
    alpha *= clouds.color.w * smoothstep(0.2 * clouds.near, clouds.near, away);
    if alpha < 0.004 {
        discard;
    }

    // As steep as it can be seen, from wherever.
    let steep = clamp(3.5 * max(pixel, SMALLEST / planet.radius_km) * shape.y, -1.5, 1.5);
    let tilt = steep * mix(0.28, 1.0, close) * (1.0 - 0.6 * even);
    let deep = 1.0 - exp(-0.3 * thick);
    let here_air = air::seen_from(altitude, planet.air.xyz, planet.air.w);
    let x = dot(place, -V);
    let z = sqrt(max(dot(place, place) - x * x, 0.0));
    let way = air::between(x - away, x, z, here_air.scale);
    var light = lights.ambient_color.rgb;
    var haze = vec3(0.0);
    for (var i = 0u; i < lights.n_directional_lights; i += 1u) {
        let to_sun = lights.directional_lights[i].direction_to_light;
        let sunshine = lights.directional_lights[i].color.rgb;
        let arriving = sunshine * air::arrives(place, to_sun, here_air);
        let height = dot(up, to_sun);
        // Thick clouds are bright above and dark below.
        let above = saturate(0.06 + 0.94 * height - 0.35 * tilt) * mix(0.68, 1.05, deep);
        let below = saturate(0.25 + 0.75 * height - 0.15 * tilt) * mix(0.22, 0.90, exp(-0.55 * thick));
        light += FRAC_1_PI * arriving * select(below, above, is_front);
        // The light of the sky, as on the ground.
        let blue = 3.1415927 * air::PHASE * (1.0 - exp(-2.0 * here_air.depth));
        light += select(0.8, 1.6, is_front) * arriving * blue;
        haze += sunshine * air::veil(place, V, away, way, to_sun, here_air);
    }
    let color = view.exposure * (clouds.color.rgb * light * exp(-air::LOST * here_air.depth * way) + haze);
    var pbr_input = pbr_types::pbr_input_new();
    pbr_input.frag_coord = in.position;
    pbr_input.world_position = in.world_position;
    pbr_input.material.flags = pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_BLEND;
    return pbr_functions::main_pass_post_lighting_processing(pbr_input, vec4(color, alpha));
}
