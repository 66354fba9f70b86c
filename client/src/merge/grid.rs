//! Which voxel a place in the world falls into.

use glam::DVec3;

/// Smallest edge of a voxel, m: the world then reaches a kilometre.
pub(super) const SMALLEST_VOXEL_M: f64 = 0.001;
/// Largest edge of a voxel, m.
pub(super) const LARGEST_VOXEL_M: f64 = 10.0;

/// Bits of a key for each axis.
const AXIS_BITS: u32 = 21;
/// Cells in each direction from the world's origin: 52 km for voxels of 5 cm.
const HALF: i64 = 1 << (AXIS_BITS - 1);

/// A voxel's number in the world; three of 21 bits in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct CellKey(u64);

impl CellKey {
    /// The cell at the world's origin.
    pub(super) const ORIGIN: Self =
        Self((HALF | HALF << AXIS_BITS | HALF << (2 * AXIS_BITS)).cast_unsigned());

    /// The key of a cell; `None` beyond the grid.
    #[inline]
    pub(super) fn of(cell: [i64; 3]) -> Option<Self> {
        // A cell far below zero wraps to a number far above the grid.
        let [x, y, z] = cell.map(|c| c.wrapping_add(HALF) as u64);
        let inside = (x | y | z) >> AXIS_BITS == 0;
        inside.then_some(Self(x | y << AXIS_BITS | z << (2 * AXIS_BITS)))
    }

    /// The cell.
    pub(super) fn cell(self) -> [i64; 3] {
        let mask = (1 << AXIS_BITS) - 1;
        [0, 1, 2].map(|axis| ((self.0 >> (axis * AXIS_BITS)) & mask).cast_signed() - HALF)
    }

    /// A hash whose upper 29 bits are shared by the eight cells of a block of two by two by two, and whose lower
    /// three tell them apart: so they lie side by side in a table, and a surface takes fewer cache lines.
    #[inline]
    pub(super) fn hash(self) -> u32 {
        let axis = |axis: u32| 1_u64 << (axis * AXIS_BITS);
        let lowest = axis(0) | axis(1) | axis(2);
        let within = [0, 1, 2].map(|axis| (self.0 >> (axis * AXIS_BITS) & 1) << axis);
        // Neighbouring blocks differ in few bits; an odd constant without structure spreads them (2^64 / φ),
        // and both halves of the product are folded.
        let product =
            u128::from((self.0 & !lowest) ^ 0x243f_6a88_85a3_08d3) * 0x9e37_79b9_7f4a_7c15;
        let folded = product as u64 ^ (product >> 64) as u64;
        let block = (folded >> 32) as u32 ^ folded as u32;
        block & !7 | (within[0] | within[1] | within[2]) as u32
    }
}

/// A regular grid of cubes over the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    edge_m: f64,
}

impl Grid {
    /// Cubes with this edge, m.
    pub(super) const fn new(edge_m: f64) -> Self {
        Self { edge_m }
    }

    /// Edge, m.
    pub(super) const fn edge_m(self) -> f64 {
        self.edge_m
    }

    /// The cell of a place in the world, m, and how far into it the place lies, in edges, 0 to 1.
    ///
    /// What is not finite lands in no cell that has a key.
    pub(super) fn locate(self, place_m: DVec3) -> ([i64; 3], DVec3) {
        let scaled = place_m / self.edge_m;
        let floor = scaled.floor();
        // The cast saturates; both ends are far beyond the grid.
        let cell = floor.to_array().map(|c| if c.is_nan() { i64::MAX / 2 } else { c as i64 });
        (cell, scaled - floor)
    }

    /// A place in a cell, so many edges from its lower corner, in the world, m.
    pub(super) fn place_m(self, cell: [i64; 3], inside: DVec3) -> DVec3 {
        (DVec3::from_array(cell.map(|c| c as f64)) + inside) * self.edge_m
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_key_gives_its_cell_back(cell in prop::array::uniform3(-HALF..HALF)) {
            prop_assert_eq!(CellKey::of(cell).unwrap().cell(), cell);
        }

        #[test]
        fn a_place_lies_in_its_cell(
            place in prop::array::uniform3(-50_000.0..50_000.0_f64),
            edge_m in 0.05..1.0_f64,
        ) {
            let (grid, place) = (Grid::new(edge_m), DVec3::from_array(place));
            let (cell, inside) = grid.locate(place);
            prop_assert!(inside.cmpge(DVec3::ZERO).all() && inside.cmple(DVec3::ONE).all());
            prop_assert!(grid.place_m(cell, inside).abs_diff_eq(place, 1e-9));
        }

        #[test]
        fn beyond_the_grid_there_is_no_key(axis in 0..3_usize, beyond in any::<i64>()) {
            prop_assume!(!(-HALF..HALF).contains(&beyond));
            let mut cell = [0; 3];
            cell[axis] = beyond;
            prop_assert_eq!(CellKey::of(cell), None);
        }
    }

    #[test]
    fn what_is_no_place_has_no_key() {
        for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e300] {
            let (cell, _) = Grid::new(0.05).locate(DVec3::new(0.0, bad, 0.0));
            assert_eq!(CellKey::of(cell), None, "{bad}");
        }
    }

    #[test]
    fn blocks_spread_over_the_hash_and_their_cells_lie_side_by_side() {
        // Given a wall of 200 by 200 voxels, in 100 by 100 blocks
        let hash = |i: i64, j: i64| CellKey::of([i, 6, j]).unwrap().hash();
        let mut blocks: Vec<u32> =
            (0..10_000).map(|n| hash(n % 100 * 2, n / 100 * 2) >> 16).collect();
        blocks.sort_unstable();
        blocks.dedup();
        // Then about as many of 65,536 buckets are used as by chance: 65536 (1 − e^(−10000/65536)).
        assert!((8_900..9_650).contains(&blocks.len()), "{}", blocks.len());
        assert_eq!(hash(4, 8) >> 3, hash(5, 9) >> 3);
        assert_ne!(hash(4, 8), hash(5, 9));
    }
}
