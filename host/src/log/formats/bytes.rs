//! Numbers out of a slice of bytes, with the place where it ends too early.

use super::Fault;

/// A place in a slice of bytes.
#[derive(Debug, Clone)]
pub struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
    big_endian: bool,
}

macro_rules! numbers {
    ($($name:ident: $type:ty),*) => {$(
        #[doc = concat!("The next bytes as `", stringify!($type), "`.")]
        #[allow(dead_code)] // not every build has every reader
        pub fn $name(&mut self) -> Result<$type, Fault> {
            let bytes = self.take(size_of::<$type>())?.try_into().expect("as many as asked for");
            Ok(if self.big_endian { <$type>::from_be_bytes(bytes) } else { <$type>::from_le_bytes(bytes) })
        }
    )*};
}

#[allow(dead_code)] // not every build has every reader
impl<'a> Bytes<'a> {
    /// Starts at the beginning, with little-endian numbers.
    pub fn new(all: &'a [u8]) -> Self {
        Bytes { all, at: 0, big_endian: false }
    }

    /// The same with big-endian numbers where `big` says so.
    #[must_use]
    pub fn big_endian(mut self, big: bool) -> Self {
        self.big_endian = big;
        self
    }

    /// Whether numbers are big-endian.
    pub fn is_big_endian(&self) -> bool {
        self.big_endian
    }

    /// Offset of the next byte.
    pub fn at(&self) -> usize {
        self.at
    }

    /// Bytes that are left.
    pub fn left(&self) -> usize {
        self.all.len() - self.at
    }

    /// The next `count` bytes.
    ///
    /// # Errors
    /// A broken file where there are fewer.
    pub fn take(&mut self, count: usize) -> Result<&'a [u8], Fault> {
        let rest = &self.all[self.at..];
        let taken = rest.get(..count).ok_or_else(|| {
            Fault::broken(self.at as u64, &format!("where {count} bytes should follow and {} do", rest.len()))
        })?;
        self.at += count;
        Ok(taken)
    }

    /// Leaves bytes out so that the next stands at a multiple of `to` from the beginning of the slice.
    pub fn align(&mut self, to: usize) {
        self.at = self.at.next_multiple_of(to).min(self.all.len());
    }

    /// A little-endian number of 1 to 8 bytes.
    ///
    /// # Errors
    /// A broken file where there are fewer.
    pub fn unsigned(&mut self, bytes: usize) -> Result<u64, Fault> {
        Ok(self.take(bytes)?.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte)))
    }

    /// A text behind its length of 4 bytes; what is no UTF-8 in it is replaced.
    ///
    /// # Errors
    /// A broken file where there are fewer bytes than it says.
    pub fn text(&mut self) -> Result<String, Fault> {
        let length = self.u32()? as usize;
        Ok(String::from_utf8_lossy(self.take(length)?).into_owned())
    }

    numbers! {u8: u8, i8: i8, u16: u16, i16: i16, u32: u32, i32: i32, u64: u64, i64: i64, f32: f32, f64: f64}
}

/// The little-endian number of two bytes that stands at `at`; none beyond the end.
#[allow(dead_code)] // not every build has every reader
pub fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

/// The same of four bytes.
#[allow(dead_code)] // not every build has every reader
pub fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_at_a_place_is_none_beyond_the_end() {
        let bytes = [1, 2, 0, 0, 3];
        assert_eq!(
            (u16_at(&bytes, 3), u16_at(&bytes, 4), u16_at(&bytes, usize::MAX)),
            (Some(0x300), None, None)
        );
        assert_eq!((u32_at(&bytes, 1), u32_at(&bytes, 2)), (Some(0x0300_0002), None));
    }

    #[test]
    fn numbers_come_in_either_order_and_the_end_is_named() {
        let bytes = [1, 2, 0, 0, 0, 3];
        assert_eq!(Bytes::new(&bytes).u16().unwrap(), 0x0201);
        assert_eq!(Bytes::new(&bytes).big_endian(true).u16().unwrap(), 0x0102);
        assert_eq!(Bytes::new(&bytes).unsigned(3).unwrap(), 0x0201);
        let mut end = Bytes::new(&bytes);
        end.take(4).unwrap();
        let fault = end.u32().unwrap_err();
        assert!(fault.why.contains("byte 4") && fault.why.contains("2 do"), "{}", fault.why);
    }
}
