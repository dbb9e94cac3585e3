//! Tables in text, read in one of several ways (the first byte says which), and JSON.
#![no_main]

use libfuzzer_sys::fuzz_target;
use motorlens_fuzz::{begin, must_answer, way};

fuzz_target!(init: begin(), |input: &[u8]| {
    let Some((first, content)) = input.split_first() else { return };
    must_answer(|| way(*first, content));
});
