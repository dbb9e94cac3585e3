//! An answer that cannot be read in passing. It hides, it does not protect: the key is in the file.

use rand::rngs::ChaCha8Rng;
use rand::{Rng, SeedableRng};

use super::Answer;

const HEADER: &str = "motorlens sealed answer; motorlens reveal opens it\n";

/// The answer as a text whose words cannot be seen: checksum and masked JSON in hexadecimal digits.
pub fn seal(answer: &Answer) -> String {
    let mut bytes = serde_json::to_vec(answer).expect("an answer holds numbers and strings only");
    let sum = checksum(&bytes);
    mask(&mut bytes, sum);
    let digits: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    format!("{HEADER}{sum:016x}{digits}\n")
}

/// The answer in a sealed text; `None` where it is none or was changed.
pub fn open(text: &str) -> Option<Answer> {
    let digits = text.strip_prefix(HEADER)?.trim_end();
    let (sum, rest) = digits.split_at_checked(16)?;
    let sum = u64::from_str_radix(sum, 16).ok()?;
    let mut bytes = Vec::with_capacity(rest.len() / 2);
    for pair in rest.as_bytes().chunks(2) {
        bytes.push(u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()?);
    }
    mask(&mut bytes, sum);
    if checksum(&bytes) != sum {
        return None;
    }
    serde_json::from_slice(&bytes).ok()
}

/// Exclusive or with a key stream: applied twice, nothing has changed.
fn mask(bytes: &mut [u8], key: u64) {
    let mut stream = vec![0; bytes.len()];
    ChaCha8Rng::seed_from_u64(key).fill_bytes(&mut stream);
    for (byte, key) in bytes.iter_mut().zip(stream) {
        *byte ^= key;
    }
}

/// Fowler, Noll and Vo's hash, 64 bits, variant 1a.
fn checksum(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}
