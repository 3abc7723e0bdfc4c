//! Common Data Representation, little endian: how ROS 2 lays messages out [OMG CDR, XCDR1].

/// The four bytes before every message: plain CDR, little endian.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// A message being laid out; every number is aligned to its own size.
pub struct Cdr {
    bytes: Vec<u8>,
}

impl Cdr {
    pub fn new() -> Self {
        Self { bytes: ENCAPSULATION.to_vec() }
    }

    pub fn finish(self) -> Vec<u8> {
        self.bytes
    }

    fn put<const N: usize>(&mut self, number: [u8; N]) -> &mut Self {
        let body = self.bytes.len() - ENCAPSULATION.len();
        self.bytes.resize(self.bytes.len() + (N - body % N) % N, 0);
        self.bytes.extend_from_slice(&number);
        self
    }

    pub fn u8(&mut self, value: u8) -> &mut Self {
        self.put([value])
    }

    pub fn i32(&mut self, value: i32) -> &mut Self {
        self.put(value.to_le_bytes())
    }

    pub fn u32(&mut self, value: u32) -> &mut Self {
        self.put(value.to_le_bytes())
    }

    pub fn f32(&mut self, value: f64) -> &mut Self {
        self.put((value as f32).to_le_bytes())
    }

    pub fn f64(&mut self, value: f64) -> &mut Self {
        self.put(value.to_le_bytes())
    }

    pub fn f64s(&mut self, values: impl IntoIterator<Item = f64>) -> &mut Self {
        for value in values {
            self.f64(value);
        }
        self
    }

    /// How many elements of a sequence follow.
    pub fn length(&mut self, count: usize) -> &mut Self {
        self.u32(u32::try_from(count).unwrap_or(u32::MAX))
    }

    pub fn string(&mut self, text: &str) -> &mut Self {
        self.length(text.len() + 1);
        self.bytes.extend_from_slice(text.as_bytes());
        self.u8(0)
    }

    pub fn bytes(&mut self, values: impl ExactSizeIterator<Item = u8>) -> &mut Self {
        self.length(values.len());
        self.bytes.extend(values);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_aligned_to_their_size_counted_after_the_encapsulation() {
        let mut cdr = Cdr::new();
        cdr.u8(7).f64(1.0).u8(8).u32(9);
        let body = cdr.finish().split_off(4);
        assert_eq!((body[0], body[16], body[20]), (7, 8, 9));
        assert_eq!(body[8..16], 1.0f64.to_le_bytes());
        assert_eq!(body.len(), 24);
    }

    #[test]
    fn a_string_has_its_length_with_the_final_nul() {
        let mut cdr = Cdr::new();
        cdr.string("ab");
        assert_eq!(cdr.finish()[4..], [3, 0, 0, 0, b'a', b'b', 0]);
    }
}
