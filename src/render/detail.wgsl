// Noise where the maps end.
#define_import_path bevy_tectonics::detail

fn hash(cell: vec3<i32>) -> f32 {
    var bits = bitcast<u32>(cell.x) * 0x9E3779B1u ^ bitcast<u32>(cell.y) * 0x85EBCA77u ^ bitcast<u32>(cell.z) * 0xC2B2AE3Du;
    bits = (bits ^ (bits >> 15u)) * 0x2C1B3C6Du;
    bits ^= bits >> 13u;
    return f32(bits) * (2.0 / 4294967295.0) - 1.0;
}

// Smooth noise from -1 to 1, and its gradient.
fn noise(place: vec3<f32>) -> vec4<f32> {
    return repeated(place, -1);
}

// The same, but every power of two of cells it begins anew; `mask` is that power less one.
fn repeated(place: vec3<f32>, mask: i32) -> vec4<f32> {
    let floored = floor(place);
    let cell = vec3<i32>(floored);
    let next = (cell + 1) & vec3(mask);
    let this_ = cell & vec3(mask);
    let f = place - floored;
    let u = f * f * (3.0 - 2.0 * f);
    let du = 6.0 * f * (1.0 - f);
    let a = hash(vec3(this_.x, this_.y, this_.z));
    let b = hash(vec3(next.x, this_.y, this_.z));
    let c = hash(vec3(this_.x, next.y, this_.z));
    let d = hash(vec3(next.x, next.y, this_.z));
    let e = hash(vec3(this_.x, this_.y, next.z));
    let g = hash(vec3(next.x, this_.y, next.z));
    let h = hash(vec3(this_.x, next.y, next.z));
    let i = hash(vec3(next.x, next.y, next.z));
    let x = mix(vec4(a, c, e, h), vec4(b, d, g, i), u.x);
    let dx = mix(mix(b - a, d - c, u.y), mix(g - e, i - h, u.y), u.z);
    let y = mix(x.xz, x.yw, u.y);
    let dy = mix(x.y - x.x, x.w - x.z, u.z);
    return vec4(mix(y.x, y.y, u.z), du * vec3(dx, dy, y.y - y.x));
}

// Terrain finer than the maps, for cameras that come close: slope, and height in w. `size` is that of
// the maps, `level` their level that is as fine as the picture.
fn detail(direction: vec3<f32>, size: f32, level: f32) -> vec4<f32> {
    var sum = vec4(0.0);
    var place = direction * size * 0.4;
    var height = 1.0;
    var strength = -0.7 - level;
    while strength > 0.0 && height > 0.1 {
        let here = noise(place);
        sum += saturate(strength) * vec4(here.yzw, height * here.x);
        place = 2.03 * place + 17.0;
        height *= 0.5;
        strength -= 1.0;
    }
    return sum;
}
