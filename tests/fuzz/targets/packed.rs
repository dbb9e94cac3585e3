//! Spreadsheets and archives of arrays: the input is one of the files inside.
#![no_main]

use libfuzzer_sys::fuzz_target;
use motorlens::log::Format;
use motorlens_fuzz::packing::packed;
use motorlens_fuzz::{answer, begin, must_answer};

fuzz_target!(init: begin(), |input: &[u8]| {
    must_answer(|| answer(&packed(input), Format::Csv, ""));
});
