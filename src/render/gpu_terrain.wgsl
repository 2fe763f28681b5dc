// The ground of a plot, place by place, as `surface::Terrain` raises it: what is explained there is not explained
// here again. Constants are mirrored from the files named beside them; `tests/gpu_terrain.rs` holds the two together.

struct Octaves {
    frequency: f32,
    amplitude: f32,
    gain: f32,
    lacunarity: f32,
    octaves: i32,
    seed: i32,
    rest: vec2<u32>,
}

// `surface/terrain/plot.rs`.
struct Plot {
    middle: vec3<f32>,
    width: f32,
    // What 32 bits cannot say of the middle.
    middle_rest: vec3<f32>,
    unused: u32,
    east: vec3<f32>,
    piece_m: f32,
    north: vec3<f32>,
    detail_m: f32,
    corner: vec3<i32>,
    nought: u32,
    sides: vec3<u32>,
    finer: f32,
    level: u32,
    share: f32,
    grain_level: u32,
    grain_share: f32,
    grain_seed: vec2<u32>,
    unused_too: vec2<u32>,
    coast: Octaves,
    relief: Octaves,
    hills: Octaves,
    shore: Octaves,
}

struct Place {
    // The direction, the cell in which it lies, where from the cell's middle, what 32 bits cannot say.
    direction: vec3<f32>,
    cell: u32,
    within: vec3<f32>,
    unused: u32,
    rest: vec3<f32>,
    unused_too: u32,
}

struct Triangle {
    // Weights of the corners are linear in the place relative to the middle.
    weights: array<vec4<f32>, 3>,
    // Is it land, elevation, age, roughness.
    corners: array<vec4<f32>, 3>,
}

struct Piece {
    jitter: vec3<f32>,
    landform: u32,
    along: vec3<f32>,
    shift_along: f32,
    across: vec3<f32>,
    shift_across: f32,
    bits: vec2<u32>,
    unused: vec2<u32>,
}

@group(0) @binding(0) var<uniform> plot: Plot;
@group(0) @binding(1) var<storage, read> places: array<Place>;
@group(0) @binding(2) var<storage, read> vectors: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> exemplars: array<f32>;
@group(0) @binding(4) var<storage, read> triangles: array<Triangle>;
@group(0) @binding(5) var<storage, read> grid: array<u32>;
@group(0) @binding(6) var<storage, read> pieces: array<Piece>;
@group(0) @binding(7) var<storage, read> cells: array<u32>;
@group(0) @binding(8) var<storage, read_write> heights: array<f32>;

// Where in `vectors` the displacements begin, and the turns.
const DISPLACEMENTS: u32 = 64u;
const TURNS: u32 = 320u;
const GRID: u32 = 16u;
const NONE: u32 = 0xFFFFFFFFu;

// A number that must be rounded by itself, as the CPU rounds it: no compiler sees through this, so none makes one
// step of a product and a sum. Displacements come in steps of up to 0.4 m, and have to take the same ones.
fn rounded(value: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(value) ^ plot.nought);
}

fn rounded3(value: vec3<f32>) -> vec3<f32> {
    return bitcast<vec3<f32>>(bitcast<vec3<u32>>(value) ^ vec3(plot.nought));
}

// ---- Noise: OpenSimplex2 of the library fastnoise-lite, bit by bit.

const PRIMES: vec3<i32> = vec3(501125321, 1136930381, 1720413743);

fn hash(seed: i32, corner: vec3<i32>) -> i32 {
    return (seed ^ corner.x ^ corner.y ^ corner.z) * 0x27d4eb2d;
}

fn turned_lattice(at: vec3<f32>) -> vec3<f32> {
    return rounded((at.x + at.y + at.z) * (2.0 / 3.0)) - at;
}

fn nearest(at: vec3<f32>) -> vec3<i32> {
    return vec3<i32>(select(at - 0.5, at + 0.5, at >= vec3(0.0)));
}

// The axis along which a place is furthest from its corner.
fn foremost(apart: vec3<f32>) -> vec3<i32> {
    if apart.x >= apart.y && apart.x >= apart.z {
        return vec3(1, 0, 0);
    }
    if apart.y > apart.x && apart.y >= apart.z {
        return vec3(0, 1, 0);
    }
    return vec3(0, 0, 1);
}

fn fourth_power(value: f32) -> f32 {
    let square = value * value;
    return square * square;
}

fn slope_at(seed: i32, corner: vec3<i32>, offset: vec3<f32>) -> f32 {
    let key = hash(seed, corner);
    let gradient = vectors[u32((key ^ (key >> 15u)) >> 2u) & 63u].xyz;
    return offset.x * gradient.x + offset.y * gradient.y + offset.z * gradient.z;
}

fn push_at(seed: i32, corner: vec3<i32>, offset: vec3<f32>) -> vec3<f32> {
    let key = hash(seed, corner);
    let gradient = vectors[u32(key >> 2u) & 63u].xyz;
    let value = offset.x * gradient.x + offset.y * gradient.y + offset.z * gradient.z;
    return value * vectors[DISPLACEMENTS + (u32(key >> 8u) & 255u)].xyz;
}

fn simplex(first_seed: i32, at: vec3<f32>) -> f32 {
    var seed = first_seed;
    let home = nearest(at);
    var offset = at - vec3<f32>(home);
    var sign = vec3<i32>(-1.0 - offset) | vec3(1);
    var apart = vec3<f32>(sign) * -offset;
    var corner = home * PRIMES;
    let squares = rounded3(offset * offset);
    var near = (0.6 - squares.x) - (squares.y + squares.z);
    var value = 0.0;
    for (var lattice = 0; lattice < 2; lattice++) {
        if near > 0.0 {
            value += fourth_power(near) * slope_at(seed, corner, offset);
        }
        let axis = foremost(apart);
        let far = dot(vec3<f32>(axis), apart);
        let other = near + far + far;
        if other > 1.0 {
            let next = offset + vec3<f32>(axis * sign);
            value += fourth_power(other - 1.0) * slope_at(seed, corner - axis * sign * PRIMES, next);
        }
        apart = 0.5 - apart;
        offset = vec3<f32>(sign) * apart;
        near = near + (0.75 - apart.x) - (apart.y + apart.z);
        corner += (sign >> vec3(1u)) & PRIMES;
        sign = -sign;
        seed = ~seed;
    }
    return value * 32.69428253173828125;
}

fn push(first_seed: i32, at: vec3<f32>) -> vec3<f32> {
    var seed = first_seed;
    let home = nearest(at);
    var offset = at - vec3<f32>(home);
    var sign = vec3<i32>(-1.0 - offset) | vec3(1);
    var apart = vec3<f32>(sign) * -offset;
    var corner = home * PRIMES;
    let squares = rounded3(offset * offset);
    var near = (0.6 - squares.x) - (squares.y + squares.z);
    var sum = vec3(0.0);
    for (var lattice = 0; lattice < 2; lattice++) {
        if near > 0.0 {
            sum += rounded3(fourth_power(near) * push_at(seed, corner, offset));
        }
        let axis = foremost(apart);
        let far = dot(vec3<f32>(axis), apart);
        let other = near + far + far;
        if other > 1.0 {
            let next = offset + vec3<f32>(axis * sign);
            let weight = fourth_power(other - 1.0);
            sum += rounded3(weight * push_at(seed, corner - axis * sign * PRIMES, next));
        }
        apart = 0.5 - apart;
        offset = vec3<f32>(sign) * apart;
        near += (0.75 - apart.x) - (apart.y + apart.z);
        corner += (sign >> vec3(1u)) & PRIMES;
        sign = -sign;
        seed += 1293373;
    }
    return sum;
}

// How far a noise displaces a place.
fn warp(noise: Octaves, at: vec3<f32>) -> vec3<f32> {
    let turned = turned_lattice(at);
    var displaced = at;
    var amplitude = noise.amplitude;
    var frequency = noise.frequency;
    for (var octave = 0; octave < noise.octaves; octave++) {
        let sum = push(noise.seed + octave, rounded3(turned * frequency));
        displaced += rounded3(sum * rounded(amplitude * 32.69428253173828125));
        amplitude = rounded(amplitude * noise.gain);
        frequency = rounded(frequency * noise.lacunarity);
    }
    return displaced - at;
}

// A sum of octaves.
fn fractal(noise: Octaves, at: vec3<f32>) -> f32 {
    var turned = turned_lattice(rounded3(at * noise.frequency));
    var amplitude = noise.amplitude;
    var sum = 0.0;
    for (var octave = 0; octave < noise.octaves; octave++) {
        sum += simplex(noise.seed + octave, turned) * amplitude;
        turned = rounded3(turned * noise.lacunarity);
        amplitude *= noise.gain;
    }
    return clamp(sum, -1.0, 1.0);
}

// ---- The history's ground: `surface/ground.rs`, `surface/raster.rs`.

const SHELF_EDGE_M: f32 = -130.0;
const SLOPE: vec2<f32> = vec2(0.25, 0.65);
const ROUGHNESS: vec2<f32> = vec2(0.03, 0.12);
const HILLS_M: f32 = 70.0;
const BURIAL_MY: f32 = 60.0;

struct Ground {
    elevation: f32,
    continental: f32,
    floor_age: f32,
    rugged: f32,
    grain: f32,
}

fn ramp(low: f32, high: f32, value: f32) -> f32 {
    return clamp((value - low) / (high - low), 0.0, 1.0);
}

fn eased(t: f32) -> f32 {
    return t * t * (3.0 - 2.0 * t);
}

// Weights of the triangle's corners at a place relative to the middle.
fn weigh(number: u32, at: vec3<f32>) -> vec3<f32> {
    let a = triangles[number].weights[0];
    let b = triangles[number].weights[1];
    let c = triangles[number].weights[2];
    return vec3(dot(a.xyz, at) + a.w, dot(b.xyz, at) + b.w, dot(c.xyz, at) + c.w);
}

fn interpolated(at: vec3<f32>) -> Ground {
    let up = 1.0 + dot(plot.middle, at);
    let across = vec2(dot(plot.east, at), dot(plot.north, at)) / (up * plot.width);
    let cell = vec2<u32>(clamp((across * 0.5 + 0.5) * f32(GRID), vec2(0.0), vec2(f32(GRID) - 0.5)));
    let slot = 2u * (cell.y * GRID + cell.x);
    // On an edge either triangle will do.
    var found = 0u;
    var least = -1e30;
    var weights = vec3(1.0 / 3.0);
    for (var i = 0u; i < grid[slot + 1u]; i++) {
        let number = grid[grid[slot] + i];
        let candidate = weigh(number, at);
        let lowest = min(candidate.x, min(candidate.y, candidate.z));
        if lowest > least {
            found = number;
            least = lowest;
            weights = candidate;
        }
    }
    weights = max(weights, vec3(0.0));
    weights /= weights.x + weights.y + weights.z;
    // Weight, elevation, age.
    var land = vec3(0.0);
    var sea = vec3(0.0);
    var rugged = 0.0;
    for (var i = 0u; i < 3u; i++) {
        let corner = triangles[found].corners[i];
        let weight = weights[i];
        let part = weight * vec3(1.0, corner.yz);
        if corner.x > 0.5 {
            land += part;
        } else {
            sea += part;
        }
        rugged += weight * corner.w;
    }
    let continental = land.x / (land.x + sea.x);
    var height = 0.0;
    if sea.x > 0.0 {
        height = sea.y / sea.x;
    }
    if land.x > 0.0 {
        var shore = land.y / land.x;
        if sea.x > 0.0 {
            if shore > SHELF_EDGE_M {
                shore = SHELF_EDGE_M + (shore - SHELF_EDGE_M) * ramp(SLOPE.y, 1.0, continental);
            }
            height += (shore - height) * eased(ramp(SLOPE.x, SLOPE.y, continental));
        } else {
            height = shore;
        }
    }
    var floor_age = 0.0;
    if sea.x > 0.0 {
        floor_age = sea.z / sea.x;
    }
    return Ground(height, continental, floor_age, rugged, 0.0);
}

// How far a direction moves that an offset is added to. Of unit length again, in a form that does not cancel.
fn moved(direction: vec3<f32>, offset: vec3<f32>) -> vec3<f32> {
    let longer = dot(direction, offset) + 0.5 * dot(offset, offset);
    let root = sqrt(1.0 + 2.0 * longer);
    let shrink = -2.0 * longer / (root * (1.0 + root));
    return offset + shrink * (direction + offset);
}

// The ground in a direction, which is longer by a rest and lies here relative to the middle.
fn base(direction: vec3<f32>, rest: vec3<f32>, at: vec3<f32>) -> Ground {
    let coast = warp(plot.coast, direction);
    var ground = interpolated(at + coast);
    let height = ground.elevation;
    if height > 0.0 {
        let mountain = max(eased(ramp(300.0, 2500.0, height)), min(ground.rugged, 1.0));
        let rough = ROUGHNESS.x + (ROUGHNESS.y - ROUGHNESS.x) * mountain;
        ground.grain = fractal(plot.relief, direction + (moved(direction, coast) + rest));
        ground.elevation = height * (1.0 + rough * ground.grain);
    } else {
        let young = exp(-ground.floor_age / BURIAL_MY) * (1.0 - ground.continental);
        let share = max(young * eased(ramp(-600.0, -2000.0, height)) - 0.01, 0.0);
        if share > 0.0 {
            ground.grain = share * fractal(plot.hills, direction);
        }
        ground.elevation = height + HILLS_M * ground.grain;
    }
    return ground;
}

// `surface/terrain/shore.rs`.
const FADES_M: f32 = 250.0;

fn ragged(place: Place) -> Ground {
    var direction = place.direction;
    var at = (direction - plot.middle) + (place.rest - plot.middle_rest);
    var ground = base(direction, place.rest, at);
    let near = 1.0 - abs(ground.elevation) / FADES_M;
    if near > 0.0 && plot.shore.octaves > 0 {
        let offset = warp(plot.shore, direction) * eased(near);
        let further = moved(direction, offset);
        at += further;
        direction += place.rest + further;
        ground = base(direction, vec3(0.0), at);
    }
    return ground;
}

// ---- Terrain on it: `surface/terrain/strength.rs`.

const PLAIN: vec2<f32> = vec2(6.0, 0.045);
const MOUNTAIN: f32 = 0.09;
const RANGES: f32 = 0.5;
const RISES: vec2<f32> = vec2(600.0, 2800.0);
const CAP: f32 = 0.22;
const FLOOR_HILLS: vec2<f32> = vec2(55.0, 60.0);
const OLD_FLOOR: f32 = 12.0;
const SLOPE_M: f32 = 60.0;
const TRENCH: vec2<f32> = vec2(-6500.0, 130.0);

fn deviation_of(ground: Ground) -> f32 {
    let height = ground.elevation;
    var wanted = 0.0;
    if height > 0.0 {
        let mountain = max(eased(ramp(RISES.x, RISES.y, height)), 0.6 * min(ground.rugged, 1.0));
        let plain = PLAIN.x + PLAIN.y * height;
        let range = 1.0 + RANGES * ground.grain;
        wanted = (plain + max(MOUNTAIN * height - plain, 0.0) * mountain) * range;
    } else {
        let hills = OLD_FLOOR + FLOOR_HILLS.x * exp2(-ground.floor_age / FLOOR_HILLS.y);
        let margin = eased(ramp(0.05, 0.5, ground.continental)) * eased(ramp(-300.0, -900.0, height));
        let trench = eased(ramp(TRENCH.x, TRENCH.x - 1500.0, height)) * TRENCH.y;
        let open = eased(ramp(-900.0, -2500.0, height));
        wanted = max(max(hills * open, SLOPE_M * margin), trench) + 3.0;
    }
    return min(wanted, CAP * abs(height));
}

fn grain_of(height: f32, deviation_m: f32, wanted: f32) -> f32 {
    let rock = select(0.2, 1.0, height > 0.0);
    return min(rock * wanted * clamp(deviation_m / 60.0, 0.1, 1.0), 0.02 * CAP * abs(height));
}

// ---- Exemplars: `surface/terrain/exemplar.rs`.

const TEXEL_M: f32 = 160.0;
const SIDE: u32 = 256u;
const LEVELS: u32 = 7u;
// Weights of all versions of one.
const EXEMPLAR: u32 = 87376u;

fn knots(t: f32) -> vec3<f32> {
    let before = 0.5 - t;
    let after = 0.5 + t;
    return vec3(0.5 * before * before, 0.75 - t * t, 0.5 * after * after);
}

fn changes(t: f32) -> vec3<f32> {
    return vec3(t - 0.5, -2.0 * t, t + 0.5);
}

// Value, and slope per texel, of one version.
fn spline(first: u32, side: u32, at: vec2<f32>) -> vec3<f32> {
    let middle = floor(at + 0.5);
    let t = at - middle;
    let home = vec2<i32>(middle);
    let mask = i32(side) - 1;
    let across = knots(t.x);
    let across_change = changes(t.x);
    let along = knots(t.y);
    let along_change = changes(t.y);
    var sum = vec3(0.0);
    for (var j = 0; j < 3; j++) {
        let row = first + u32((home.y + j - 1) & mask) * side;
        let weights = vec3(
            exemplars[row + u32((home.x - 1) & mask)],
            exemplars[row + u32(home.x & mask)],
            exemplars[row + u32((home.x + 1) & mask)],
        );
        let value = dot(across, weights);
        sum += vec3(along[j] * value, along[j] * dot(across_change, weights), along_change[j] * value);
    }
    return sum;
}

fn exemplar(landform: u32, at: vec2<f32>, finer: u32, share: f32) -> vec3<f32> {
    var sum = vec3(0.0);
    for (var i = 0u; i < 2u; i++) {
        let level = finer + i;
        let part = select(1.0 - share, share, i == 1u);
        if level >= LEVELS || part <= 0.0 {
            continue;
        }
        let texels = SIDE * SIDE;
        let first = landform * EXEMPLAR + (4u * texels - ((4u * texels) >> (2u * level))) / 3u;
        let scale = 1.0 / f32(1u << level);
        let found = spline(first, SIDE >> level, (at + 0.5) * scale - 0.5);
        sum += part * found * vec3(1.0, scale, scale);
    }
    return sum;
}

// ---- Sea floor: `surface/terrain/floor.rs`.

const WAVES: u32 = 6u;
const WAVES_M: array<f32, 6> = array(11000.0, 7000.0, 4400.0, 2800.0, 1700.0, 1000.0);
const ALONG: f32 = 0.2;
const TAU: f32 = 6.283185307179586;

// Sine of an angle in turns. What comes with a shader may be as far off as 0.0005.
fn sine(turns: f32) -> f32 {
    var t = turns - floor(turns + 0.5);
    if abs(t) > 0.25 {
        t = select(-0.5, 0.5, t > 0.0) - t;
    }
    let x = TAU * t;
    let s = x * x;
    return x * (1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0 * (1.0 - s / 110.0)))));
}

// Six bits of 64 from this one on, as a share.
fn part(bits: vec2<u32>, first: u32) -> f32 {
    return f32(shifted(bits, first).x & 63u) / 64.0;
}

// Value, and slope per m.
fn abyssal(offset: vec3<f32>, piece: Piece) -> vec4<f32> {
    var lengths = WAVES_M;
    var power = 0.0;
    for (var i = 0u; i < WAVES; i++) {
        power += 0.5 * lengths[i];
    }
    var sum = vec4(0.0);
    for (var i = 0u; i < WAVES; i++) {
        let amplitude = sqrt(lengths[i] / power);
        let length = lengths[i] * (0.7 + 0.6 * part(piece.bits, 7u * i + 11u));
        let share = clamp(length / (2.0 * plot.detail_m) - 1.0, 0.0, 1.0);
        if share == 0.0 {
            continue;
        }
        let tilt = ALONG * (2.0 * part(piece.bits, 5u * i + 3u) - 1.0);
        let waves = (piece.across + piece.along * tilt) / length;
        let turns = dot(offset, waves) + part(piece.bits, 6u * i + 23u);
        let height = share * amplitude;
        sum += height * vec4(sine(turns), waves * (TAU * sine(turns + 0.25)));
    }
    return sum;
}

// ---- Pieces: `surface/terrain/scatter.rs`, `surface/terrain/mod.rs`.

const JITTER: f32 = 0.35;
const GRAIN_M: vec2<f32> = vec2(0.25, 7.0);
const SOFTEST: f32 = 4.0;
const COLLISION: u32 = 1u;

struct Sum {
    value: f32,
    slope: vec3<f32>,
    squares: f32,
    squares_slope: vec3<f32>,
}

// Adds a piece at an offset in cells of this size in m; value, and slope per m.
fn add(sum: Sum, offset: vec3<f32>, size: f32, found: vec4<f32>) -> Sum {
    let left = 1.0 - dot(offset, offset);
    let weight = left * left * left;
    let weight_slope = offset * (-6.0 * left * left / size);
    return Sum(
        sum.value + weight * found.x,
        sum.slope + found.yzw * weight + weight_slope * found.x,
        sum.squares + weight * weight,
        sum.squares_slope + weight_slope * (2.0 * weight),
    );
}

// Value and slope of pieces that overlap, in deviations.
fn blended(sum: Sum) -> vec4<f32> {
    let squares = sum.squares + 1e-4;
    let slope = sum.slope - sum.squares_slope * (0.5 * sum.value / squares);
    return vec4(sum.value, slope) / sqrt(squares);
}

// A value that never passes four deviations, and its rate of change.
fn softened(value: f32) -> vec2<f32> {
    let square = 1.0 + (value / SOFTEST) * (value / SOFTEST);
    let root = sqrt(square);
    return vec2(value / root, 1.0 / (square * root));
}

// Whether the piece of a cell may come near, wherever in the cell it lies.
fn may_reach(within: vec3<f32>, step: vec3<f32>) -> bool {
    let apart = max(abs(within - step) - JITTER, vec3(0.0));
    return dot(apart, apart) < 1.0001;
}

fn step_of(number: i32) -> vec3<i32> {
    return vec3(number % 3, number / 3 % 3, number / 9) - 1;
}

fn cell_of(place: Place) -> vec3<i32> {
    return vec3<i32>((vec3(place.cell) >> vec3(0u, 10u, 20u)) & vec3(0x3FFu));
}

// The larger pieces.
fn pile(place: Place) -> vec4<f32> {
    var sum = Sum(0.0, vec3(0.0), 0.0, vec3(0.0));
    let home = cell_of(place);
    for (var i = 0; i < 27; i++) {
        let step = step_of(i);
        if !may_reach(place.within, vec3<f32>(step)) {
            continue;
        }
        let cell = vec3<u32>(home + step);
        let number = cells[(cell.z * plot.sides.y + cell.y) * plot.sides.x + cell.x];
        if number == NONE {
            continue;
        }
        let piece = pieces[number];
        let offset = place.within - vec3<f32>(step) - piece.jitter;
        if dot(offset, offset) >= 1.0 {
            continue;
        }
        let apart = offset * plot.piece_m;
        var found = vec4(0.0);
        if piece.landform > 5u {
            found = abyssal(apart, piece);
        } else {
            let shift = vec2(piece.shift_along, piece.shift_across);
            let at = vec2(dot(apart, piece.along), dot(apart, piece.across)) / TEXEL_M + shift;
            let shown = exemplar(piece.landform, at, plot.level, plot.share);
            found = vec4(shown.x, (piece.along * shown.y + piece.across * shown.z) / TEXEL_M);
        }
        sum = add(sum, offset, plot.piece_m, found);
    }
    return blended(sum);
}

// Numbers of 64 bits, the lower half first: product, shift to the right by less than 64, and the hash of cells.
fn product(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let al = a.x & 0xFFFFu;
    let ah = a.x >> 16u;
    let bl = b.x & 0xFFFFu;
    let bh = b.x >> 16u;
    let low = al * bl;
    let one = ah * bl + (low >> 16u);
    let other = al * bh + (one & 0xFFFFu);
    let high = ah * bh + (one >> 16u) + (other >> 16u);
    return vec2(a.x * b.x, high + a.x * b.y + a.y * b.x);
}

fn shifted(value: vec2<u32>, bits: u32) -> vec2<u32> {
    if bits == 0u {
        return value;
    }
    if bits >= 32u {
        return vec2(value.y >> (bits - 32u), 0u);
    }
    return vec2((value.x >> bits) | (value.y << (32u - bits)), value.y >> bits);
}

fn scrambled(value: vec2<u32>) -> vec2<u32> {
    let first = product(value ^ shifted(value, 30u), vec2(0x1CE4E5B9u, 0xBF58476Du));
    return product(first ^ shifted(first, 27u), vec2(0x133111EBu, 0x94D049BBu));
}

fn bits_of(cell: vec3<i32>) -> vec2<u32> {
    let c = bitcast<vec3<u32>>(cell);
    let key = vec2((c.y << 21u) ^ c.z, (c.x << 10u) ^ (c.y >> 11u));
    let bits = scrambled(plot.grain_seed ^ scrambled(key));
    return bits ^ shifted(bits, 31u);
}

fn jitter_of(bits: vec2<u32>) -> vec3<f32> {
    let parts = vec3(bits.x, bits.x >> 21u, bits.y >> 10u) & vec3(0x3FFu);
    return (vec3<f32>(parts) / 511.5 - 1.0) * JITTER;
}

// The smaller pieces.
fn grain(place: Place) -> vec4<f32> {
    var sum = Sum(0.0, vec3(0.0), 0.0, vec3(0.0));
    let scaled = (place.within + 0.5) * plot.finer;
    let lower = floor(scaled);
    let within = scaled - lower - 0.5;
    let home = (plot.corner + cell_of(place)) * i32(plot.finer) + vec3<i32>(lower);
    let size = plot.piece_m / plot.finer;
    let texel = TEXEL_M / plot.finer;
    for (var i = 0; i < 27; i++) {
        let step = step_of(i);
        if !may_reach(within, vec3<f32>(step)) {
            continue;
        }
        let cell = home + step;
        let bits = bits_of(cell);
        let jitter = jitter_of(bits);
        let offset = within - vec3<f32>(step) - jitter;
        if dot(offset, offset) >= 1.0 {
            continue;
        }
        // Axes of the piece, as `Vec3::any_orthonormal_pair` has them; the cell says on which side of the equator.
        let up = normalize(vec3<f32>(cell) + 0.5 + jitter);
        let side = select(-1.0, 1.0, cell.z >= 0);
        let a = -1.0 / (side + up.z);
        let b = up.x * up.y * a;
        let east = vec3(1.0 + side * up.x * up.x * a, side * b, -side * up.x);
        let north = vec3(b, side + up.y * up.y * a, -up.y);
        let turn = vectors[TURNS + (bits.x & 15u)];
        let along = east * turn.y + north * turn.x;
        let across = north * turn.y - east * turn.x;
        let shift = vec2<f32>((vec2(bits.x) >> vec2(8u, 20u)) & vec2(0xFFFu)) / 16.0;
        let apart = offset * size;
        let at = vec2(dot(apart, along), dot(apart, across)) / texel + shift;
        let shown = exemplar(COLLISION, at, plot.grain_level, plot.grain_share);
        let slope = (along * shown.y + across * shown.z) / texel;
        sum = add(sum, offset, size, vec4(shown.x, slope));
    }
    return blended(sum);
}

@compute @workgroup_size(64)
fn raise(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&heights) {
        return;
    }
    let place = places[id.x];
    let ground = ragged(place);
    let deviation_m = deviation_of(ground);
    let broad = pile(place);
    let soft = softened(broad.x);
    var height = ground.elevation + deviation_m * soft.x;
    if plot.grain_level < LEVELS {
        let slope = broad.yzw * (deviation_m * soft.y);
        let up = place.direction;
        let steep = min(length(slope - up * dot(up, slope)), 1.0);
        let wanted = GRAIN_M.x + (GRAIN_M.y - GRAIN_M.x) * steep;
        let fine = softened(grain(place).x);
        height += grain_of(ground.elevation, deviation_m, wanted) * fine.x;
    }
    heights[id.x] = height;
}
