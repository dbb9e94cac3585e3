//! The encoder's counter, extended past its 16 bits.

/// Follows a wrapping 16-bit counter. Right as long as it moves less than 32768 counts between two looks.
#[derive(Debug, Clone, Copy, Default)]
pub struct Extended {
    last: u16,
    total: i32,
}

impl Extended {
    /// Looks at the counter and returns the counts since the start.
    pub fn look(&mut self, counter: u16) -> i32 {
        let moved = counter.wrapping_sub(self.last) as i16;
        self.last = counter;
        self.total = self.total.wrapping_add(moved.into());
        self.total
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_follows_through_every_wrap_in_both_directions() {
        let mut extended = Extended::default();
        let mut truth = 0_i32;
        for k in 0..4000 {
            truth += if k < 3000 { 30_000 } else { -32_000 };
            assert_eq!(extended.look(truth as u16), truth);
        }
    }
}
