// A thin atmosphere, in closed form. Lengths are in radii of the planet.
#define_import_path bevy_tectonics::air

// Several times Earth's, so that the rim is seen from afar.
const SCALE_HEIGHT: f32 = 0.0055;
// Optical depth straight up, by colour: the sky is blue.
const DEPTH: vec3<f32> = vec3<f32>(0.009, 0.021, 0.050);
const INTENSITY: f32 = 0.11;

// How much longer a slanted way through the air is than the one straight up (after Schüler 2012).
fn slant(cosine: f32) -> f32 {
    let c = sqrt(1.5707963 / SCALE_HEIGHT);
    return c / ((c - 1.0) * max(cosine, 0.0) + 1.0);
}

// What is left of the sunlight in the air above a place: red at dusk, gone in the night.
fn sunlight(sun_height: f32) -> vec3<f32> {
    return exp(-0.7 * DEPTH * slant(sun_height)) * smoothstep(-0.16, 0.10, sun_height);
}

// Light scattered towards the viewer along a way as many times longer than the one straight up.
fn scattered(length: f32, sun_height: f32, sun_angle: f32) -> vec3<f32> {
    let phase = 0.75 * (1.0 + sun_angle * sun_angle);
    return INTENSITY * phase * sunlight(sun_height) * (1.0 - exp(-DEPTH * length));
}
