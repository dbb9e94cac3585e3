//! The bytes of version 3: the PWM's frequency in the setup, and protected frames.

use motorlens_shared::link::{
    Decoder, FromBoard, MAX_ENCODED, MAX_PROTECTED, Packet, Refusal, Setup, SetupFault, ToBoard, decode,
    encode, encode_protected,
};

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len() / 2).map(|k| u8::from_str_radix(&hex[2 * k..2 * k + 2], 16).unwrap()).collect()
}

#[test]
fn the_setup_of_version_3_keeps_its_bytes() {
    let packet =
        Packet { id: 300, message: ToBoard::Configure(Setup { pwm_hz: 16_000, ..Setup::default() }) };
    // It has got fields since, which are zero here: as in `link_v1.rs`.
    let frame = bytes(CONFIGURE);
    assert_eq!(decode(&frame[..frame.len() - 1]), Ok(packet.clone()));
    let mut out = [0; MAX_ENCODED];
    let today = encode(&packet, &mut out).unwrap();
    let plain = |frame: &[u8]| {
        let mut out = [0; MAX_ENCODED];
        let length = cobs::decode(&frame[..frame.len() - 1], &mut out).unwrap();
        out[..length - 4].to_vec()
    };
    let (old, new) = (plain(&frame), plain(today));
    assert_eq!((&new[..old.len()], &new[old.len()..]), (&*old, &[0, 0][..]));
    let packet = Packet { id: 300, message: FromBoard::Refused(Refusal::Setup(SetupFault::Pwm)) };
    let frame = bytes(REFUSED);
    assert_eq!(encode(&packet, &mut [0; MAX_ENCODED]), Ok(&*frame));
    assert_eq!(decode(&frame[..frame.len() - 1]), Ok(packet));
}

#[test]
fn a_protected_frame_keeps_its_bytes_and_is_read_beside_plain_ones() {
    let packet = Packet { id: 300, message: ToBoard::Stop };
    let frame = bytes(PROTECTED_STOP);
    let mut out = [0; MAX_PROTECTED];
    assert_eq!(encode_protected(&packet, &mut out), Ok(&*frame));
    let mut plain = [0; MAX_ENCODED];
    let plain = encode(&packet, &mut plain).unwrap();
    let mut decoder = Decoder::new();
    for (frame, protected) in [(&*frame, true), (plain, false), (&*frame, true)] {
        let read: Vec<_> = frame.iter().filter_map(|byte| decoder.push(*byte)).collect();
        assert_eq!(read, [Ok(packet.clone())]);
        assert_eq!(decoder.protected(), protected);
    }
}

#[test]
fn a_protected_frame_is_read_with_one_in_eight_of_its_bytes_damaged_or_missing() {
    let packet = Packet { id: 300, message: ToBoard::Configure(Setup::default()) };
    let mut out = [0; MAX_PROTECTED];
    let frame = encode_protected(&packet, &mut out).unwrap();
    for first in 0..8 {
        let mut decoder = Decoder::new();
        let read = frame.iter().enumerate().filter_map(|(place, byte)| match place % 16 {
            k if k == first && *byte != 0 => decoder.push(byte ^ 0x40),
            k if k == first + 8 && *byte != 0 => None,
            _ => decoder.push(*byte),
        });
        assert_eq!(read.collect::<Vec<_>>(), [Ok(packet.clone())], "from byte {first} on");
    }
}

const CONFIGURE: &str = "06ac0203e8070ce05de807c0a907a01ff4030af40305807d9d7aa0c900";
const REFUSED: &str = "0aac0204010718d88bf300";
const PROTECTED_STOP: &str = "3a5c6082a0c6f03055699cb7d2e43656609cacd8ff30557d99aad7e23c5f7887b7ddfc300000";
