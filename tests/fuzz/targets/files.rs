//! Files that are no text, told by their content.
#![no_main]

use libfuzzer_sys::fuzz_target;
use motorlens::log::Format;
use motorlens_fuzz::{answer, begin, must_answer};

fuzz_target!(init: begin(), |input: &[u8]| {
    must_answer(|| answer(input, Format::Csv, ""));
});
