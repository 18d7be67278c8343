// Owen-scrambled Sobol numbers in pairs, each pair in an order of its own. Sources: as of `path/sampler.rs`, whose functions of the same
// names these are the twins of.

// Decisions of a vertex, each with a pair of its own.
const PAIRS_PER_VERTEX: u32 = 5u;
const PAIR_DIRECTION: u32 = 1u;
const PAIR_CHOICE: u32 = 2u;
const PAIR_LIGHT: u32 = 3u;
const PAIR_PASSAGE: u32 = 4u;
const PAIR_WALK: u32 = 5u;
// Vertices that draw from the sequence.
const SEQUENCE_VERTICES: u32 = 4u;

fn mix_bits(given: u32) -> u32 {
    var x = given;
    x ^= x >> 16u;
    x *= 0x85ebca6bu;
    x ^= x >> 13u;
    x *= 0xc2b2ae35u;
    return x ^ (x >> 16u);
}

fn pixel_seed(seed: u32, pixel: u32) -> u32 {
    return mix_bits(mix_bits(seed) ^ mix_bits(pixel * 0x9e3779b9u + 0x7f4a7c15u));
}

fn laine_karras(given: u32, seed: u32) -> u32 {
    var x = given;
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    return x ^ (x * 0x53a22864u);
}

fn owen(x: u32, seed: u32) -> u32 {
    return reverseBits(laine_karras(reverseBits(x), seed));
}

fn sobol_1(index: u32) -> u32 {
    var x = reverseBits(index);
    x ^= (x & 0x55555555u) << 1u;
    x ^= (x & 0x33333333u) << 2u;
    x ^= (x & 0x0f0f0f0fu) << 4u;
    x ^= (x & 0x00ff00ffu) << 8u;
    return x ^ (x << 16u);
}

fn unit_number(x: u32) -> f32 {
    return f32(x >> 8u) * (1.0 / 16777216.0);
}

// Two numbers in [0, 1) for a decision of a vertex; pair 0 of vertex 0 is the place within the pixel.
fn draw_pair(seed: u32, index: u32, vertex: u32, pair: u32) -> vec2f {
    let h = mix_bits(seed + (PAIRS_PER_VERTEX * vertex + pair) * 0x9e3779b9u + 0x3c6ef372u);
    if vertex >= SEQUENCE_VERTICES {
        let x = mix_bits(h ^ (index * 0x9e3779b9u));
        return vec2f(unit_number(mix_bits(x + 0x85157af5u)), unit_number(mix_bits(x + 0x0a2af5eau)));
    }
    let j = owen(index, h);
    let first = reverseBits(laine_karras(j, mix_bits(h + 0x85157af5u)));
    return vec2f(unit_number(first), unit_number(owen(sobol_1(j), mix_bits(h + 0x0a2af5eau))));
}
