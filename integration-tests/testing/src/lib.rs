//! What the tests of all crates share: [`Random`] numbers by seed, an allocator that counts, and a judge of motions.

mod counting;
mod phases;
mod random;

pub use counting::{Counting, allocations_in, most_bytes_in};
pub use phases::{Phase, Wanted};
pub use random::Random;
