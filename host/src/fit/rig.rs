//! The known part of a rig: what a motor file and the logs say of it.

use motorlens_shared::effects::Rig;

use crate::log::quantum::quantum as step_of;
use crate::log::{EncoderShaft, Record};
use crate::motor_file::MotorFile;

/// The rig that `records` were made on. Its reference speed is that of no motor yet.
pub fn rig(records: &[Record], motor: &MotorFile) -> Rig {
    let meta = |f: fn(&Record) -> Option<f64>| records.iter().find_map(f);
    let gear_ratio = motor.gear_ratio.or_else(|| meta(|r| r.meta.gear_ratio())).unwrap_or(1.0);
    let shaft = motor.encoder_shaft.or_else(|| records.iter().find_map(|r| r.meta.encoder_shaft()));
    let counts = motor.counts_per_rev.or_else(|| meta(|r| r.meta.counts_per_rev()));
    let peak = highest_voltage(records).max(1e-3);
    let nominal_v = motor.nameplate.voltage_v.unwrap_or(peak);
    let is_logged = records.iter().any(|record| record.supply_v.is_some());
    let supply_v = match mean_supply(records) {
        Some(mean) if is_logged => mean,
        // A bridge gives no more than its supply has, whatever was said of that.
        told => told.unwrap_or(nominal_v).max(peak),
    };
    let measured_count = records.iter().find_map(|r| step_of(r.angle_rad.as_ref()?));
    let count_rad = counts.map(|c| std::f64::consts::TAU / c).or(measured_count).unwrap_or(1e-3);
    Rig {
        step_s: 1e-3,
        gear_ratio,
        encoder_on_motor: shaft.unwrap_or(EncoderShaft::Motor) == EncoderShaft::Motor,
        nominal_v,
        supply_v,
        reference_speed: 1.0,
        count_rad,
    }
}

/// The highest voltage in `records`, V.
pub(crate) fn highest_voltage<'a>(records: impl IntoIterator<Item = &'a Record>) -> f64 {
    records.into_iter().flat_map(|record| &record.voltage_v).fold(0.0_f64, |peak, v| peak.max(v.abs()))
}

/// Voltage of the supply, V: the mean over all samples of those `records` that tell it; none where no record does.
fn mean_supply(records: &[Record]) -> Option<f64> {
    let told = records.iter().filter_map(|record| Some((record.mean_supply_v()?, record.len() as f64)));
    let (sum, n) = told.fold((0.0, 0.0), |(sum, n), (volts, samples)| (sum + volts * samples, n + samples));
    (n > 0.0).then(|| sum / n)
}

#[cfg(test)]
mod tests {
    use motorlens_shared::effects::Kind;
    use motorlens_shared::excitation::{Programme, Shape};
    use motorlens_virtual_motor::{Effect, Kind as Hidden, Motor, Run, VirtualMotor};

    use super::*;
    use crate::estimate::{Method, Options, fit};
    use crate::exam::case;
    use crate::motor_file::Nameplate;

    fn in_volts(voltage_v: Vec<f64>) -> Record {
        let time_s = (0..voltage_v.len()).map(|k| 0.01 * k as f64).collect();
        Record { time_s, voltage_v, ..Record::default() }
    }

    /// The same, made from a duty on a supply of 12 V.
    fn of_duty(mut record: Record) -> Record {
        record.meta.insert("voltage", "it is the duty times 12 V, whatever the supply did").unwrap();
        record
    }

    #[test]
    fn the_supply_behind_a_duty_is_known_however_low_the_duty_stays() {
        let of = |records: &[Record]| rig(records, &MotorFile::default());
        let low = of_duty(in_volts(vec![0.0, 6.0, -3.0]));
        let alone = of(std::slice::from_ref(&low));
        assert_eq!((alone.supply_v, alone.nominal_v), (12.0, 6.0));
        // A record in volts tells nothing of the supply, but that it is no lower.
        assert_eq!(of(&[low.clone(), in_volts(vec![7.0, 1.0])]).supply_v, 12.0);
        assert_eq!(of(&[low, in_volts(vec![13.0, 1.0])]).supply_v, 13.0);
        assert_eq!(of(&[in_volts(vec![5.0, -6.5])]).supply_v, 6.5);
    }

    #[test]
    fn a_supply_that_was_logged_is_its_mean_and_a_nameplate_stands_in_where_nothing_tells_it() {
        let logged = Record { supply_v: Some(vec![12.5, 11.5, 12.0]), ..in_volts(vec![12.4, 0.0, 3.0]) };
        let plate = Nameplate { voltage_v: Some(24.0), ..Nameplate::default() };
        let motor = MotorFile { nameplate: plate, ..MotorFile::default() };
        assert!((rig(&[logged], &motor).supply_v - 12.0).abs() < 1e-12);
        assert_eq!(rig(&[in_volts(vec![5.0, -6.5])], &motor).supply_v, 24.0);
        assert_eq!(rig(&[of_duty(in_volts(vec![5.0, -6.5]))], &motor).supply_v, 12.0);
    }

    /// With the highest voltage for the supply the gain of this motor comes out at nearly its double.
    #[test]
    fn a_driver_that_floats_at_low_duty_leaves_the_gain_of_its_motor() {
        let motor = Motor::small();
        let floats = [Effect::typical(Hidden::Coast)];
        let shapes = [
            Shape::PulseAndCoast { amplitude_v: 5.0 },
            Shape::PulseAndCoast { amplitude_v: 2.0 },
            Shape::Staircase { amplitude_v: 5.0, hold_s: 0.6, seed: 1 },
        ];
        let records = shapes.map(|shape| {
            let mut plant = VirtualMotor::new(&motor, &floats, 1);
            let programme = Programme::single("low-duty", shape, 8.0);
            of_duty(case::record(&mut plant, &programme, 200, &Run::at(200.0)))
        });
        let options =
            Options { method: Method::Conventional, effects: vec![Kind::Coast], ..Options::default() };
        let found = fit(&records, &[], &MotorFile::default(), &options, &mut |_, _| {}).unwrap();
        assert_eq!(found.model.rig.supply_v, 12.0);
        let gain = found.model.values().base.gain;
        assert!((gain / motor.gain() - 1.0).abs() < 0.05, "{gain} for {}", motor.gain());
    }
}
