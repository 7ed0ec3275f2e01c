//! What the tests of all crates share: [`Random`] numbers by seed, how many [`cases`] a test plays, an allocator that counts, and a judge
//! of motions.

mod cases;
mod counting;
mod phases;
mod random;

pub use cases::cases;
pub use counting::{Counting, allocations_in, most_bytes_in};
pub use phases::{Phase, Wanted};
pub use random::Random;
