// A thin atmosphere, in closed form. Lengths are in radii of the planet.
#define_import_path bevy_tectonics::air

// Several times Earth's, so that the rim is seen from afar.
const SCALE_HEIGHT: f32 = 0.0055;
// Share of the air's optical depth that remains where it reaches so much higher.
const FAR_SHARE: f32 = 0.18;
const INTENSITY: f32 = 0.11;

// How much longer a slanted way through the air is than the one straight up (after Schüler 2012).
fn slant(cosine: f32) -> f32 {
    let c = sqrt(1.5707963 / SCALE_HEIGHT);
    return c / ((c - 1.0) * max(cosine, 0.0) + 1.0);
}

// What is left of the sunlight in the air above a place: red at dusk, gone in the night.
fn sunlight(depth: vec3<f32>, sun_height: f32) -> vec3<f32> {
    return exp(-0.7 * depth * slant(sun_height)) * smoothstep(-0.16, 0.10, sun_height);
}

// Light scattered towards the viewer along a way as many times longer than the one straight up.
fn scattered(depth: vec3<f32>, length: f32, sun_height: f32, sun_angle: f32) -> vec3<f32> {
    let phase = 0.75 * (1.0 + sun_angle * sun_angle);
    return INTENSITY * phase * sunlight(depth, sun_height) * (1.0 - exp(-depth * length));
}

// A column of air: optical depth straight up by colour, and scale height.
struct Air {
    depth: vec3<f32>,
    scale: f32,
}

// Altitudes of the viewer between which true air grows into the one that is seen from afar.
const NEAR: f32 = 0.03;
const FAR: f32 = 0.7;

fn seen_from(altitude: f32, depth: vec3<f32>, scale: f32) -> Air {
    let far = smoothstep(NEAR, FAR, altitude);
    return Air(depth * mix(1.0, FAR_SHARE, far), mix(scale, SCALE_HEIGHT, far));
}

// Density of the air at a distance from the centre; far below the ground as much as numbers can hold.
fn density(r: f32, scale: f32) -> f32 {
    return exp(min((1.0 - r) / scale, 20.0));
}

// Air from a place on a line outwards, in columns straight up from the ground. `x` is the distance from where the
// line comes closest to the centre, at least 0; `z` is how close. In closed form, as in Tectonics.js: the integral
// by substitution, kept finite where the line is level (Chapman's function there, after Schüler 2012). Within 1.5 %.
fn beyond(x: f32, z: f32, scale: f32) -> f32 {
    let r = max(sqrt(x * x + z * z), 1e-3);
    let level = (0.5 * scale / r + 1.0) * sqrt(1.5707963 * z / scale) + 0.67 * x / scale;
    return density(r, scale) / (x / r + 1.0 / level);
}

// Air between two places on a line.
fn between(a: f32, b: f32, z: f32, scale: f32) -> f32 {
    if a >= 0.0 {
        return max(beyond(a, z, scale) - beyond(b, z, scale), 0.0);
    }
    if b <= 0.0 {
        return max(beyond(-b, z, scale) - beyond(-a, z, scale), 0.0);
    }
    return max(2.0 * beyond(0.0, z, scale) - beyond(-a, z, scale) - beyond(b, z, scale), 0.0);
}

// Sunlight that arrives at a place, by colour.
fn arrives(place: vec3<f32>, sun: vec3<f32>, air: Air) -> vec3<f32> {
    let x = dot(place, sun);
    let z = sqrt(max(dot(place, place) - x * x, 0.0));
    var way = 0.0;
    var open = 1.0;
    if x >= 0.0 {
        way = beyond(x, z, air.scale);
    } else {
        // Through the air behind, or into the ground.
        way = 2.0 * beyond(0.0, max(z, 1.0), air.scale) - beyond(-x, max(z, 1.0), air.scale);
        open = smoothstep(1.0 - 2.0 * air.scale, 1.0, z);
    }
    return open * exp(-LOST * air.depth * way);
}

// Rayleigh's phase function, less its angle.
const PHASE: f32 = 0.0597;

// Much of what is scattered out of a beam is scattered back into it.
const LOST: f32 = 0.6;

// How much light the air sends along a line towards an eye, per light of the sun.
fn glow(eye: vec3<f32>, toward: vec3<f32>, length: f32, sun: vec3<f32>, air: Air, steps: i32) -> vec3<f32> {
    let x = dot(eye, toward);
    let z2 = max(dot(eye, eye) - x * x, 0.0);
    let z = sqrt(z2);
    // Where the line is within the air.
    let top = 1.0 + 9.0 * air.scale;
    let reach = sqrt(max(top * top - z2, 0.0));
    let from_ = max(-reach - x, 0.0);
    let to = min(reach - x, length);
    var sum = vec3(0.0);
    if z < top && to > from_ {
        var before = 0.0;
        for (var i = 1; i <= steps; i += 1) {
            // Closer together near the eye, where it is in the air.
            let share = f32(i) / f32(steps);
            let after = mix(share, share * share, f32(from_ == 0.0));
            let middle = mix(from_, to, 0.5 * (before + after));
            let place = eye + toward * middle;
            let here = density(length3(place), air.scale);
            let way = between(x + from_, x + middle, z, air.scale);
            let step = (to - from_) * (after - before) / air.scale;
            sum += here * step * exp(-LOST * air.depth * way) * arrives(place, sun, air);
            before = after;
        }
    }
    let angle = dot(toward, sun);
    return 1.8 * PHASE * (1.0 + angle * angle) * air.depth * sum;
}

// The same from the ground to an eye so far away, with as much air between: all lit as in the middle of it.
fn veil(place: vec3<f32>, toward: vec3<f32>, away: f32, way: f32, sun: vec3<f32>, air: Air) -> vec3<f32> {
    let middle = place + toward * (0.5 * min(away, air.scale));
    let angle = dot(toward, sun);
    return PHASE * (1.0 + angle * angle) * arrives(middle, sun, air) * (1.0 - exp(-air.depth * way));
}

fn length3(v: vec3<f32>) -> f32 {
    return sqrt(dot(v, v));
}
