//! The link between host and board: the first byte says which of them hears the rest, and how that came about.
#![no_main]

use libfuzzer_sys::fuzz_target;
use motorlens_fuzz::{begin, link, must_answer};

fuzz_target!(init: begin(), |input: &[u8]| {
    must_answer(|| link::hear(input));
});
