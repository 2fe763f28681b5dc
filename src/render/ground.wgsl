// What the sphere and the tiles of a planet have in common: its maps, its colours, its light.
#define_import_path bevy_tectonics::ground
#import bevy_pbr::{
    mesh_view_bindings::view,
    pbr_types,
    pbr_functions,
}
#import bevy_tectonics::light

struct Tints {
    // In w: the snow line at the equator in km.
    ice: vec4<f32>,
    // In w: the latitude from which it covers the sea.
    pack_ice: vec4<f32>,
    // In w: the latitude from which ice covers the land.
    scree: vec4<f32>,
    foam: vec4<f32>,
    woods: vec4<f32>,
    clearings: vec4<f32>,
    stones: vec4<f32>,
    sand: vec4<f32>,
}

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
    tiles: f32,
    reach: f32,
    radius_km: f32,
    eye: vec3<f32>,
    air: vec4<f32>,
    tints: Tints,
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

// The ground that is now where it was in A and in B.
fn ground(in_a: vec3<f32>, in_b: vec3<f32>, level: f32) -> Ground {
    var out: Ground;
    if planet.mix < 1.0 {
        let share = 1.0 - planet.mix;
        let fine = max(level, planet.level.x);
        out.relief += share * textureSampleLevel(relief_a, smooth_sampler, in_a, fine);
        out.climate += share * textureSampleLevel(climate_a, smooth_sampler, in_a, max(level - 1.0, planet.level.x));
        if planet.overlay.x > 0.0 {
            let texel = textureSampleLevel(overlay_a, smooth_sampler, in_a, fine);
            out.overlay += share * tint(texel, planet.overlay.x);
        }
    }
    if planet.mix > 0.0 {
        let share = planet.mix;
        let fine = max(level, planet.level.y);
        out.relief += share * textureSampleLevel(relief_b, smooth_sampler, in_b, fine);
        out.climate += share * textureSampleLevel(climate_b, smooth_sampler, in_b, max(level - 1.0, planet.level.y));
        if planet.overlay.y > 0.0 {
            let texel = textureSampleLevel(overlay_b, smooth_sampler, in_b, fine);
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

// How far ice covers the sea.
fn packed(climate: vec4<f32>) -> f32 {
    let from_ = planet.tints.pack_ice.w;
    return smoothstep(from_ - 2.25, from_ + 2.25, climate.z + 3.5 * climate.w);
}

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
    let icy = planet.tints.scree.w;
    let cold = saturate((latitude - 25.0) / (icy - 24.0));
    let line = planet.tints.ice.w * (1.0 - cold * cold) - 0.2 * cold;
    let snow = smoothstep(line - 0.7, line + 0.3, height - 0.5 * tilt);
    let ice = smoothstep(icy - 2.5, icy + 2.5, latitude + 3.5 * variety);
    return mix(ground, planet.tints.ice.rgb, max(ice, 0.95 * snow));
}

// Ground up close: woods and clearings where it is moist, gravel and sand where it is dry, scree below cliffs.
// `patches` are where plants stand dense and where stones lie, from -1 to 1; `steep` is in m per m.
fn grown_over(base: vec3<f32>, patches: vec2<f32>, steep: f32, height: f32, climate: vec4<f32>) -> vec3<f32> {
    let whiteness = smoothstep(0.45, 0.7, min(base.r, min(base.g, base.b)));
    let green = saturate((base.g - 0.5 * (base.r + base.b)) / max(base.g, 0.02) * 3.0);
    // Woods shun cliffs and the driest ground.
    let wooded = smoothstep(-0.25, 0.45, patches.x - 0.35 * saturate(climate.y)) * (1.0 - smoothstep(0.45, 0.8, steep));
    var ground = base * mix(planet.tints.clearings.rgb, planet.tints.woods.rgb, wooded * green);
    // Where little grows, stones and sand differ.
    let stony = smoothstep(-0.2, 0.35, patches.y);
    ground = mix(ground, base * mix(planet.tints.sand.rgb, planet.tints.stones.rgb, stony), 1.0 - green);
    ground = mix(ground, base, whiteness);
    let rock = colour(ROCK, max(height, 0.0)) * (1.0 + 0.3 * patches.y);
    let scree = mix(rock, planet.tints.scree.rgb, 0.5);
    let high = smoothstep(0.2, 1.2, height);
    let loose = smoothstep(0.42, 0.62, steep + 0.15 * patches.y) * mix(0.35, 0.8, high) * (1.0 - 0.7 * whiteness);
    let cliff = smoothstep(0.65, 0.95, steep + 0.1 * patches.y) * 0.92;
    return mix(mix(ground, scree, loose), rock, cliff);
}

// Light towards the viewer.
fn shine(in: pbr_types::PbrInput, wet: f32) -> vec3<f32> {
    // Planets near a lamp are lit with all that Bevy has. The usual sun needs a fraction of that, and
    // to software renderers even a branch not taken is dear.
#ifdef PLANET_LAMPS
    return pbr_functions::apply_pbr_lighting(in).rgb;
#else ifdef ENVIRONMENT_MAP
    return pbr_functions::apply_pbr_lighting(in).rgb;
#else
    return view.exposure * light::lit(in, wet);
#endif
}

// Whether a pixel belongs to the tiles that take over from the sphere (interleaved gradient noise, Jimenez 2014).
fn is_tiled(pixel: vec2<f32>) -> bool {
    return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))) < planet.tiles;
}
