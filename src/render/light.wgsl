// What Bevy's `apply_pbr_lighting` does, for directional and ambient light alone.
#define_import_path bevy_tectonics::light
#import bevy_pbr::{
    mesh_view_bindings::{view, lights},
    pbr_types::PbrInput,
}
#import bevy_tectonics::bevy_air
#ifdef PLANET_SHADOWS
#import bevy_pbr::{
    mesh_types::MESH_FLAGS_SHADOW_RECEIVER_BIT,
    mesh_view_types::DIRECTIONAL_LIGHT_FLAGS_SHADOWS_ENABLED_BIT,
    shadows,
}
#endif

// Roughness of the sea as Bevy counts it: waves spread the sun's reflection.
const WATER: f32 = 0.40;
const FRAC_1_PI: f32 = 0.31830989;
// Share of a light's normal bias.
const BIAS: f32 = 0.25;

// How much of the light from a direction the sea reflects to the viewer.
fn glint(N: vec3<f32>, V: vec3<f32>, to_light: vec3<f32>) -> f32 {
    let roughness = WATER * WATER;
    let middle = normalize(V + to_light);
    let cosine = saturate(dot(N, middle));
    let incoming = max(dot(N, to_light), 1e-3);
    let outgoing = max(dot(N, V), 1e-3);
    let spread = roughness * roughness;
    let peak = cosine * cosine * (spread - 1.0) + 1.0;
    let grazing = 1.0 - saturate(dot(V, middle));
    let fresnel = 0.02 + 0.98 * grazing * grazing * grazing * grazing * grazing;
    let visible = 0.5 / mix(2.0 * incoming * outgoing, incoming + outgoing, roughness);
    return fresnel * visible * spread * FRAC_1_PI / (peak * peak);
}

// Light towards the viewer, before exposure.
fn lit(in: PbrInput, wet: f32) -> vec3<f32> {
    let base = in.material.base_color.rgb;
    var color = lights.ambient_color.rgb * base;
    for (var i = 0u; i < lights.n_directional_lights; i += 1u) {
        let to_light = lights.directional_lights[i].direction_to_light;
        let height = dot(in.N, to_light);
        if height <= 0.0 {
            continue;
        }
        var share = FRAC_1_PI * base;
        if wet > 0.0 {
            share += 0.55 * wet * glint(in.N, in.V, to_light);
        }
        // Slopes do not catch light in the planet's own shadow.
        var shadow = smoothstep(-0.06, 0.06, dot(in.world_normal, to_light));
#ifdef PLANET_SHADOWS
        if (in.flags & MESH_FLAGS_SHADOW_RECEIVER_BIT) != 0u
            && (lights.directional_lights[i].flags & DIRECTIONAL_LIGHT_FLAGS_SHADOWS_ENABLED_BIT) != 0u {
            let view_z = (view.view_from_world * in.world_position).z;
            // Ground that the sun shines on is not in its maps: a fraction of Bevy's bias is enough, and all of it, as far
            // up as several texels are wide, would cut shadows short.
            shadow *= shadows::fetch_directional_shadow(
                i, in.world_position, BIAS * in.world_normal, view_z, in.frag_coord.xy,
            );
        }
#endif
        let size = lights.directional_lights[i].sun_disk_angular_size;
        let arriving = bevy_air::passes(in.world_position.xyz, to_light, size);
        color += lights.directional_lights[i].color.rgb * arriving * (height * shadow) * share;
    }
    return color;
}
