//! Tables in text, read in one of several ways (the first byte says which), and JSON.
#![no_main]

use libfuzzer_sys::fuzz_target;
use motorlens::log::Format;
use motorlens_fuzz::{WAYS, answer, begin, must_answer};

fuzz_target!(init: begin(), |input: &[u8]| {
    let Some((way, content)) = input.split_first() else { return };
    must_answer(|| match usize::from(*way) {
        way if way < WAYS.len() => answer(content, Format::Csv, WAYS[way]),
        way if way % 2 == 0 => answer(content, Format::WpilibSysid, ""),
        _ => answer(content, Format::BamJson, ""),
    });
});
