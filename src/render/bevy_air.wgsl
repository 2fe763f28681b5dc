// Bevy's atmosphere, where a camera has it: what is left to it, and what it does to sunlight.
#define_import_path bevy_tectonics::bevy_air
#ifdef ATMOSPHERE
#import bevy_pbr::{
    atmosphere::functions::{calculate_visible_sun_ratio, clamp_to_surface},
    lighting::sample_transmittance_lut,
    mesh_view_bindings as view_bindings,
}
#endif

// Whether Bevy draws the air of the planet with this centre: that of the nearest planet alone.
fn surrounds(centre: vec3<f32>) -> bool {
#ifdef ATMOSPHERE
    let air = view_bindings::atmosphere;
    let offset = (air.world_to_atmosphere * vec4(centre, 1.0)).xyz;
    // Of several cameras that have it Bevy 0.19 tells nothing.
    return air.inner_radius == 0.0 || length(offset) < 0.1 * air.inner_radius;
#else
    return false;
#endif
}

// Share of a sun's light that comes through to a place. `size` is the sun's, in radians.
fn passes(place: vec3<f32>, to_light: vec3<f32>, size: f32) -> vec3<f32> {
#ifdef ATMOSPHERE
    let air = view_bindings::atmosphere;
    let within = clamp_to_surface(air, (air.world_to_atmosphere * vec4(place, 1.0)).xyz);
    // Below the sphere, by however little, Bevy's roots are none.
    let r = max(length(within), 1.000001 * air.inner_radius);
    // Bevy's table ends there.
    if air.inner_radius > 0.0 && r < air.outer_radius {
        let mu = dot(to_light, within / r);
        return sample_transmittance_lut(r, mu) * calculate_visible_sun_ratio(air, r, mu, size);
    }
#endif
    return vec3(1.0);
}
