//! The bytes of version 1 of the link, as deployed boards send and expect them.
//!
//! A failure here means that a change broke the wire format. Do not edit the bytes: put the old form back, raise
//! `link::NEWEST`, and put what is new into `link_v2.rs`. A new field goes to the end of a message and must mean "as before"
//! at zero (`link::decode`); a new variant goes to the end and is sent only to an end that has agreed on the version.

mod frames;

use frames::{golden, unended};
use motorlens_shared::excitation::{Segment, Shape};
use motorlens_shared::link::{
    Capabilities, Cause, DriveMode, FromBoard, Hello, LogBlock, MAX_ENCODED, Packet, Refusal, Reset,
    RunState, Sample, Scaling, Setup, SetupFault, Status, ToBoard, decode, encode,
};
use motorlens_shared::quickfit::{Estimate, Progress, QuickFit, Request};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Debug;

/// [`golden`] for a message that has got fields since, which are zero in this one: the old bytes mean it, and its bytes begin
/// with the old ones and go on with zeros, so that an old end reads what it knows.
fn grown<M: Serialize + DeserializeOwned + PartialEq + Debug>(message: M, hex: &str) {
    let packet = Packet { id: 300, message };
    let old = unended(hex);
    assert_eq!(decode::<Packet<M>>(&old), Ok(packet));
    let packet = decode::<Packet<M>>(&old).unwrap();
    let mut out = [0; MAX_ENCODED];
    let frame = encode(&packet, &mut out).unwrap();
    // Without stuffing and checksum.
    let plain = |frame: &[u8]| {
        let mut out = [0; MAX_ENCODED];
        let length = cobs::decode(frame, &mut out).unwrap();
        out[..length - 4].to_vec()
    };
    let (old, new) = (plain(&old), plain(&frame[..frame.len() - 1]));
    assert!(new.len() > old.len(), "{packet:?}");
    assert_eq!(new[..old.len()], old);
    assert!(new[old.len()..].iter().all(|byte| *byte == 0), "{new:?}");
}

#[test]
fn hello_is_frozen() {
    golden(ToBoard::Hello { oldest: 1, newest: 1 }, "03ac02070101ea9bf44b00");
    let hello = Hello { oldest: 1, newest: 1, firmware: [0, 1, 0], unique: *b"motorlens-01" };
    golden(FromBoard::Hello(hello), "03ac020301010201116d6f746f726c656e732d30317cc43c8400");
}

#[test]
fn commands_keep_their_bytes() {
    golden(ToBoard::Capabilities, "08ac02011f06a67900");
    golden(ToBoard::EffectName { index: 7 }, "09ac0202076ec264fc00");
    grown(
        ToBoard::Configure(Setup { drive: DriveMode::LockedAntiPhase, ..Setup::default() }),
        "12ac0203e80702e05de807c0a907a01ff40308f4030530b283fb00",
    );
    let shape = Shape::Multisine { amplitude_v: 8.0, low_hz: 0.1, high_hz: 12.0, tones: 14, seed: 5 };
    let segment = Segment { shape, seconds: 10.0 };
    golden(
        ToBoard::SetSegment { index: 2, name: "training".try_into().unwrap(), segment },
        "0fac02040208747261696e696e670201010641cdcccc3d010540410e050107204189f78a8600",
    );
    golden(ToBoard::Start { run: 70_000, segments: 3 }, "0cac0205f0a2040365d18f2400");
    golden(ToBoard::Stop, "08ac0206f4626cad00");
    golden(ToBoard::ReadLog { first: 59_000, count: 64 }, "0cac0207f8cc0340c9f96e4500");
    golden(
        ToBoard::QuickFit(Request { coulomb: true, rad_per_count: 0.0025, ..Request::default() }),
        "10ac0208102801010ad7233b669aabe400",
    );
    golden(ToBoard::ReadResult, "08ac0209d05e7ff300");
    golden(ToBoard::Bootloader, "08ac020a24ad2fe000");
    golden(ToBoard::KeepAlive, "08ac020b272e441200");
    golden(ToBoard::Status, "08ac020ccc4a8ec600");
}

#[test]
fn answers_keep_their_bytes() {
    let scaling = Scaling { pwm_top: 4200, rate_hz: 1000 };
    grown(
        FromBoard::Capabilities(Capabilities {
            effects: 22,
            segments: 16,
            log_samples: 1024,
            fit_samples: 2000,
            core_hz: 84_000_000,
            pwm_hz: 20_000,
            measures_supply: true,
            measures_current: false,
            scaling,
            converter: false,
        }),
        "12ac020116108008d00f80fa8628a09c010109e820e807c5ef20f200",
    );
    golden(FromBoard::EffectName("coulomb".try_into().unwrap()), "10ac020207636f756c6f6d629130e53a00");
    golden(FromBoard::Done, "08ac0203e8769d9800");
    golden(FromBoard::Refused(Refusal::Setup(SetupFault::LinkTimeout)), "0aac02040104ec2bdbe000");
    let sample = Sample { duty: -2100, count: -70_000, supply_mv: 12_000, current_ma: -900, late_us: -3 };
    let samples = [sample, Sample::MISSED].into_iter().collect();
    golden(
        FromBoard::Log(LogBlock { run: 9, first: 59_992, samples }),
        "13ac020509d8d40302e720dfc508e05d870e0501010108ffff039eacf82e00",
    );
    golden(FromBoard::NotHeld { first: 3, count: 300 }, "0bac020603ac02883481f400");
    let status = Status {
        state: RunState::Stopped(Cause::Stall),
        run: 9,
        oldest: 4000,
        next: 5024,
        missed: 0,
        kept: 1004,
        damaged: 12,
        reset: Reset::Watchdog,
        worst_cycles: 2900,
    };
    golden(FromBoard::Status(status), "0bac0207020309a01fa0270bec070c01d41688180db500");
    golden(
        FromBoard::Progress(Progress { generation: 4, generations: 40, iae: 0.5 }),
        "06ac020804280101063f6b81b94f00",
    );
    let estimate = |value| Estimate { value, standard_error: 0.25 };
    let fit = QuickFit {
        gain: estimate(0.9),
        tau_m: estimate(0.045),
        tau_e: estimate(0.0015),
        coulomb: Some(estimate(0.7)),
        iae: 0.5,
        iae_search: 0.75,
        rmse: 0.001,
        samples: 2000,
        evaluations: 640,
        micros: 250_000,
        micros_search: 200_000,
    };
    golden(
        FromBoard::Fit(Some(fit)),
        "09ac0209016666663f0107803eec51383d0107803ea69bc43a0108803e013333333f0103803e0101023f0115403f6f12833ad00f800590a10fc09a0ce166113300",
    );
    golden(FromBoard::Fit(None), "04ac020905a4cd5d8100");
}
