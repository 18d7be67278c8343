// Directional albedos of the material at hand: what its rough interfaces lose to single scattering, and what its dielectric
// reflects. Lookups in the words that `Albedos::words` of `albedos.rs` made; AXES and HEAD are printed from there. Twin of `albedos.rs`.

// What is tabulated over the directions: slots of a grid's head. A quantity that the material does not need must not be read.
const METAL_MISS: u32 = 0;
const DIELECTRIC_MISS: u32 = 1;
const GLASS_KEPT: u32 = 2;
const GLASS_KEPT_INSIDE: u32 = 3;

// Tables of one interface: where the words of its material begin, and where its own head does.
struct Grid {
    words: u32,
    head: u32,
}

// A place on the varying numbers of a grid: of every axis its number of entries, the cell and the place within it.
struct Place {
    counts: array<u32, AXES>,
    index: array<u32, AXES>,
    fraction: array<f32, AXES>,
    // Entries that surround the place: two along each varying number.
    corners: u32,
}

// A direction on the angular axes of a grid.
struct Slant {
    azimuth: u32,
    azimuth_fraction: f32,
    cosine: u32,
    cosine_fraction: f32,
}

// An entry about a place, and its weight.
struct Corner {
    row: u32,
    weight: f32,
}

// Tables of the base and of the coat of a material whose words begin there.
fn grid_base(words: u32) -> Grid {
    return Grid(words, words);
}

fn grid_coat(words: u32) -> Grid {
    return Grid(words, words + HEAD);
}

// Number `slot` of the head: counts, azimuths, cosines, begin of the means, begins of the quantities.
fn grid_head(grid: Grid, slot: u32) -> u32 {
    return u32(albedo_tables[grid.head + slot]);
}

// Where these numbers (each in [0, 1]) lie.
fn grid_place(grid: Grid, numbers: array<f32, AXES>) -> Place {
    var given = numbers;
    var place: Place;
    place.corners = 1u;
    for (var k = 0u; k < AXES; k++) {
        let count = grid_head(grid, k);
        place.counts[k] = count;
        if count > 1u {
            let at = cell(given[k], count);
            place.index[k] = u32(at.x);
            place.fraction[k] = at.y;
            place.corners *= 2u;
        }
    }
    return place;
}

// Where a direction lies: `w` in the frame of the stretch, either side.
fn grid_slant(grid: Grid, w: vec3f) -> Slant {
    let c = cell(sqrt(abs(w.z)), grid_head(grid, AXES + 1));
    let azimuths = grid_head(grid, AXES);
    var a = vec2f(0.0);
    if azimuths > 1u {
        let x = abs(w.x);
        let y = abs(w.y);
        a = cell(y / max(x + y, 1e-20), azimuths);
    }
    return Slant(u32(a.x), a.y, u32(c.x), c.y);
}

// A quantity at a place for a direction. It must be held.
fn grid_at(grid: Grid, quantity: u32, place: Place, slant: Slant) -> f32 {
    let azimuths = grid_head(grid, AXES);
    let cosines = grid_head(grid, AXES + 1);
    let begin = grid.words + grid_head(grid, AXES + 3 + quantity);
    var sum = 0.0;
    for (var k = 0u; k < place.corners; k++) {
        let corner = place_corner(place, k);
        let i = begin + (corner.row * azimuths + slant.azimuth) * cosines + slant.cosine;
        var value = table_pair(i, slant.cosine_fraction);
        if azimuths > 1u {
            value = mix(value, table_pair(i + cosines, slant.cosine_fraction), slant.azimuth_fraction);
        }
        sum += corner.weight * value;
    }
    return sum;
}

// Cosine-weighted mean of a quantity over all directions: exactly that of what `grid_at` returns.
fn grid_mean(grid: Grid, quantity: u32, place: Place) -> f32 {
    let size = grid_head(grid, AXES) * grid_head(grid, AXES + 1);
    // The first quantity begins where the values do.
    let rows_before = (grid_head(grid, AXES + 3 + quantity) - grid_head(grid, AXES + 3)) / size;
    let begin = grid.words + grid_head(grid, AXES + 2) + rows_before;
    var sum = 0.0;
    for (var k = 0u; k < place.corners; k++) {
        let corner = place_corner(place, k);
        sum += corner.weight * albedo_tables[begin + corner.row];
    }
    return sum;
}

// Corner `k` of the cell: multilinear interpolation over the numbers that vary.
fn place_corner(place: Place, k: u32) -> Corner {
    // Arrays in a value cannot be indexed by a variable.
    var p = place;
    var corner = Corner(0u, 1.0);
    var bits = k;
    for (var axis = 0u; axis < AXES; axis++) {
        if p.counts[axis] > 1u {
            let upper = bits & 1u;
            bits = bits >> 1u;
            corner.row = corner.row * p.counts[axis] + p.index[axis] + upper;
            corner.weight *= select(1.0 - p.fraction[axis], p.fraction[axis], upper == 1u);
        }
    }
    return corner;
}
