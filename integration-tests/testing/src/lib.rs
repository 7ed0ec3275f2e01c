//! What the tests of all crates share: [`Random`] numbers by seed, and an allocator that counts.

mod counting;
mod random;

pub use counting::{Counting, allocations_in};
pub use random::Random;
