//! Finite numbers from bytes.

/// Turns bytes into numbers. Behind their end there are zeros, so that every input means something.
///
/// The first byte says whether numbers are such as a person may mean (sizes from 1e-3 to 1e2) or any finite ones.
#[derive(Debug, Clone)]
pub struct Numbers<'a> {
    bytes: &'a [u8],
    hostile: bool,
}

/// Numbers at the ends of what a double holds, and some that programs stumble over.
const HOSTILE: [f64; 14] = [
    0.0,
    -0.0,
    1.0,
    1e-300,
    -1e-300,
    5e-324,
    f64::MIN_POSITIVE,
    f64::EPSILON,
    1e15,
    -1e16,
    1e150,
    -1e300,
    f64::MAX,
    f64::MIN,
];

impl<'a> Numbers<'a> {
    /// The numbers of an input.
    pub fn new(bytes: &'a [u8]) -> Self {
        let (first, bytes) = bytes.split_first().unwrap_or((&0, bytes));
        Self { bytes, hostile: first % 4 == 0 }
    }

    /// True if numbers may be any finite ones.
    pub fn hostile(&self) -> bool {
        self.hostile
    }

    /// True once all bytes are used.
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.bytes.split_first() else { return 0 };
        self.bytes = rest;
        *first
    }

    /// A whole number below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        usize::from(self.byte()) % n.max(1)
    }

    /// From 0 to 1.
    pub fn unit(&mut self) -> f64 {
        f64::from(u16::from_le_bytes([self.byte(), self.byte()])) / f64::from(u16::MAX)
    }

    /// A number of any sign.
    pub fn value(&mut self) -> f64 {
        let kind = self.byte();
        if self.hostile && kind & 1 == 0 {
            return self.any();
        }
        match (kind >> 1) % 8 {
            0 => 0.0,
            1 => f64::from(self.byte() % 7) - 3.0,
            2 => (f64::from(self.byte()) - 128.0) / 10.0,
            _ => self.size() * if kind > 127 { -1.0 } else { 1.0 },
        }
    }

    /// A number above 0.
    pub fn positive(&mut self) -> f64 {
        if self.hostile && self.byte() & 1 == 0 {
            return self.any().abs();
        }
        self.size()
    }

    /// From 1e-3 to 1e2, by its logarithm.
    fn size(&mut self) -> f64 {
        10f64.powf(self.unit().mul_add(5.0, -3.0))
    }

    /// Any finite number.
    fn any(&mut self) -> f64 {
        let kind = self.byte();
        if kind < 128 {
            return HOSTILE[usize::from(kind) % HOSTILE.len()];
        }
        let value = f64::from_bits(u64::from_le_bytes(std::array::from_fn(|_| self.byte())));
        // Without its highest bit the exponent is a finite one.
        if value.is_finite() { value } else { f64::from_bits(value.to_bits() & !(1 << 62)) }
    }

    /// Several numbers of any sign.
    pub fn values<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| self.value())
    }
}
