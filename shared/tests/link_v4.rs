//! The bytes of version 4: what is wired to the converter, in the setup, and whether a board has one.

mod frames;

use frames::golden;
use motorlens_shared::link::{Capabilities, FromBoard, Refusal, Scaling, Setup, SetupFault, ToBoard};

#[test]
fn what_is_wired_keeps_its_bytes() {
    let wired = Setup { divider: 1100, amplifier: 1650, pwm_hz: 16_000, ..Setup::default() };
    golden(ToBoard::Configure(wired), "06ac0203e8070ce05de807c0a907a01ff4030ef40305807dcc08f20c5c6ee7df00");
    golden(FromBoard::Refused(Refusal::Setup(SetupFault::Divider)), "0aac020401083ce498ad00");
    golden(FromBoard::Refused(Refusal::Setup(SetupFault::NoConverter)), "0aac020401093f67f35f00");
    golden(
        FromBoard::Capabilities(Capabilities {
            effects: 22,
            segments: 16,
            log_samples: 1024,
            fit_samples: 2000,
            core_hz: 84_000_000,
            pwm_hz: 20_000,
            measures_supply: true,
            measures_current: false,
            scaling: Scaling { pwm_top: 4200, rate_hz: 1000 },
            converter: true,
        }),
        "12ac020116108008d00f80fa8628a09c01010ae820e8070165c2985600",
    );
}
