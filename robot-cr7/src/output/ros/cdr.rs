//! The encoding of ROS 2 messages: CDR, little endian (OMG DDSI-RTPS 10.2).

/// A message that can be encoded.
pub trait Message {
    /// Adds its fields.
    fn write(&self, cdr: &mut Cdr);

    /// Its bytes.
    fn to_cdr(&self) -> Vec<u8> {
        let mut cdr = Cdr::default();
        self.write(&mut cdr);
        // Plain CDR, little endian, no options.
        let mut bytes = vec![0, 1, 0, 0];
        bytes.extend(cdr.bytes);
        bytes
    }
}

/// The fields so far. Numbers are aligned to their size, counted from the end of the header.
#[derive(Debug, Default)]
pub struct Cdr {
    bytes: Vec<u8>,
}

impl Cdr {
    fn align(&mut self, size: usize) {
        self.bytes.resize(self.bytes.len().next_multiple_of(size), 0);
    }

    /// An int32.
    pub fn i32(&mut self, value: i32) {
        self.align(4);
        self.bytes.extend(value.to_le_bytes());
    }

    /// A uint32.
    pub fn u32(&mut self, value: u32) {
        self.align(4);
        self.bytes.extend(value.to_le_bytes());
    }

    /// The length of a sequence.
    pub fn count(&mut self, count: usize) {
        self.u32(u32::try_from(count).unwrap_or(u32::MAX));
    }

    /// A float64.
    pub fn f64(&mut self, value: f64) {
        self.align(8);
        self.bytes.extend(value.to_le_bytes());
    }

    /// A sequence of float64.
    pub fn numbers(&mut self, values: &[f64]) {
        self.count(values.len());
        values.iter().for_each(|value| self.f64(*value));
    }

    /// A string, with the 0 at its end.
    pub fn string(&mut self, text: &str) {
        self.count(text.len() + 1);
        self.bytes.extend(text.as_bytes());
        self.bytes.push(0);
    }

    /// A sequence of strings.
    pub fn strings(&mut self, texts: &[String]) {
        self.count(texts.len());
        texts.iter().for_each(|text| self.string(text));
    }
}
