//! Records made ready once for a whole search, and the objective of candidates on them.

use super::dispatch::{DOUBLES, LANES, Level, Work};
use motorlens_shared::linear::{Filter, Hold, Kind, Laned, Prepare, Sample, State, absolute_error};
use motorlens_shared::motor::Combinations;
use thiserror::Error;

/// One record with a constant step. The motor rests at its start; an angle counts from its first sample,
/// because where the shaft stood then is a nuisance of each record.
#[derive(Debug, Clone)]
pub struct LinearRecord {
    /// Time between samples, s.
    pub dt: f64,
    /// At the driver's output, V.
    pub voltage: Vec<f64>,
    /// At the output shaft, rad or rad/s.
    pub measured: Vec<f64>,
    /// Which of the two.
    pub kind: Kind,
    /// What the voltage does between samples.
    pub hold: Hold,
}

/// Why records cannot be searched on.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RecordError {
    /// Nothing to fit.
    #[error("no record to fit: give at least one with two samples or more")]
    Empty,
    /// The columns do not match.
    #[error(
        "record {record} has {voltages} voltages and {measured} measurements; both must be as many, 2 or more"
    )]
    Lengths {
        /// Counted from 1.
        record: usize,
        /// Number of voltages.
        voltages: usize,
        /// Number of measurements.
        measured: usize,
    },
    /// A number that is none.
    #[error(
        "record {record}, sample {sample}: a voltage, measurement or step is not a finite number; remove the row"
    )]
    NotFinite {
        /// Counted from 1.
        record: usize,
        /// Counted from 1.
        sample: usize,
    },
    /// The step is not positive.
    #[error("record {record}: the step is {step} s; time must go forward")]
    Step {
        /// Counted from 1.
        record: usize,
        /// s.
        step: f64,
    },
}

/// How a record was sampled; records that share this share the discretised candidates.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sampling {
    step: f64,
    hold: Hold,
    kind: Kind,
}

impl Sampling {
    fn filter(&self, motor: &Combinations) -> Filter<f64> {
        Filter::new(motor, self.step, self.hold, self.kind)
    }
}

/// One record in the kernel's layout, in both precisions.
#[derive(Debug, Clone)]
struct Prepared {
    /// Position in [`Records::samplings`].
    sampling: usize,
    double: Vec<Sample<f64>>,
    single: Vec<Sample<f32>>,
}

/// All records of a search.
#[derive(Debug, Clone)]
pub struct Records {
    records: Vec<Prepared>,
    samplings: Vec<Sampling>,
    level: Level,
}

/// Candidates as difference equations, once per kind of sampling.
#[derive(Debug, Clone, Default)]
pub struct Candidates {
    filters: Vec<Vec<Filter<f64>>>,
}

impl Records {
    /// Checks and prepares.
    ///
    /// # Errors
    /// See [`RecordError`].
    pub fn new(records: &[LinearRecord], level: Level) -> Result<Self, RecordError> {
        if records.is_empty() {
            return Err(RecordError::Empty);
        }
        let mut samplings = Vec::new();
        let records = records.iter().enumerate().map(|(k, r)| prepared(k + 1, r, &mut samplings));
        Ok(Self { records: records.collect::<Result<_, _>>()?, samplings, level })
    }

    /// Number of records.
    #[must_use]
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Never true: a set of no records is refused.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// Samples of all records.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.records.iter().map(|r| r.double.len()).sum()
    }

    /// The vector unit in use.
    #[must_use]
    pub fn level(&self) -> Level {
        self.level
    }

    /// Discretises `motors` for every kind of sampling among the records, reusing the memory of `candidates`.
    pub fn discretise(&self, motors: &[Combinations], candidates: &mut Candidates) {
        candidates.filters.resize_with(self.samplings.len(), Vec::new);
        for (sampling, filters) in self.samplings.iter().zip(&mut candidates.filters) {
            filters.clear();
            filters.extend(motors.iter().map(|m| sampling.filter(m)));
        }
    }

    /// IAE of the candidates `block * LANES ..` (at most [`LANES`]) on one record, in single precision.
    #[must_use]
    pub fn lane_iae(&self, record: usize, candidates: &Candidates, block: usize) -> [f64; LANES] {
        let Prepared { sampling, single, .. } = &self.records[record];
        let filters = &candidates.filters[*sampling][block * LANES..];
        let work = Sums { filters: &filters[..filters.len().min(LANES)], samples: single };
        let step = self.samplings[*sampling].step;
        self.level.run(work).map(|sum| sum * step)
    }

    /// IAE of many candidates, summed over the records in their order, in single precision.
    pub fn iae_of(&self, candidates: &Candidates, iae: &mut [f64]) {
        for (block, iae) in iae.chunks_mut(LANES).enumerate() {
            iae.fill(0.0);
            for record in 0..self.records.len() {
                let sums = self.lane_iae(record, candidates, block);
                for (total, sum) in iae.iter_mut().zip(sums) {
                    *total += sum;
                }
            }
        }
    }

    /// IAE of one candidate, summed over the records, in double precision: the figure that is reported.
    #[must_use]
    pub fn exact_iae(&self, motor: &Combinations) -> f64 {
        let iae = |r: &Prepared| {
            let sampling = &self.samplings[r.sampling];
            let mut sum = [0.0];
            absolute_error(&sampling.filter(motor), &r.double, &mut sum);
            sum[0] * sampling.step
        };
        self.records.iter().map(iae).sum()
    }

    /// IAE of a few candidates, summed over the records, in double precision and side by side.
    #[must_use]
    pub fn exact_iae_of(&self, motors: &[Combinations; DOUBLES]) -> [f64; DOUBLES] {
        let mut total = [0.0; DOUBLES];
        for r in &self.records {
            let sampling = &self.samplings[r.sampling];
            let filters = motors.each_ref().map(|m| sampling.filter(m));
            let sums = self.level.run_double(DoubleSums { filters: &filters, samples: &r.double });
            for (total, sum) in total.iter_mut().zip(sums) {
                *total += sum * sampling.step;
            }
        }
        total
    }

    /// Each record's samples with the filters of `motors` for it.
    pub(super) fn with_filters<const N: usize>(
        &self,
        motors: &[Combinations; N],
    ) -> impl Iterator<Item = (&[Sample<f64>], [Filter<f64>; N])> {
        self.records.iter().map(move |r| {
            let sampling = &self.samplings[r.sampling];
            (r.double.as_slice(), motors.each_ref().map(|m| sampling.filter(m)))
        })
    }

    /// Gives every error (prediction minus measurement) to `visit`: record, sample, error.
    pub fn errors(&self, motor: &Combinations, mut visit: impl FnMut(usize, usize, f64)) {
        for (number, r) in self.records.iter().enumerate() {
            let filter = self.samplings[r.sampling].filter(motor);
            let mut state = State::default();
            for (k, sample) in r.double.iter().enumerate() {
                visit(number, k, filter.error(&mut state, *sample));
            }
        }
    }
}

fn prepared(record: usize, r: &LinearRecord, samplings: &mut Vec<Sampling>) -> Result<Prepared, RecordError> {
    let (voltages, measured) = (r.voltage.len(), r.measured.len());
    if voltages != measured || voltages < 2 {
        return Err(RecordError::Lengths { record, voltages, measured });
    }
    if !r.dt.is_finite() {
        return Err(RecordError::NotFinite { record, sample: 1 });
    }
    if r.dt <= 0.0 {
        return Err(RecordError::Step { record, step: r.dt });
    }
    let mut prepare = Prepare::new(r.dt, r.hold, r.kind);
    let mut double = Vec::with_capacity(voltages);
    for (k, (&v, &y)) in r.voltage.iter().zip(&r.measured).enumerate() {
        if !(v.is_finite() && y.is_finite()) {
            return Err(RecordError::NotFinite { record, sample: k + 1 });
        }
        double.push(prepare.push(v, y));
    }
    let single = double.iter().map(|s| s.map(|x| x as f32)).collect();
    let sampling = Sampling { step: r.dt, hold: r.hold, kind: r.kind };
    let known = samplings.iter().position(|s| *s == sampling);
    let sampling = known.unwrap_or_else(|| {
        samplings.push(sampling);
        samplings.len() - 1
    });
    Ok(Prepared { sampling, double, single })
}

/// The inner loop at the level's own width.
struct Sums<'a> {
    filters: &'a [Filter<f64>],
    samples: &'a [Sample<f32>],
}

impl Work for Sums<'_> {
    type Output = [f64; LANES];

    #[inline(always)]
    fn run<T: Laned<Element: bytemuck::Pod>>(self) -> [f64; LANES] {
        let mut sums = [0.0; LANES];
        absolute_error(&Filter::<T>::gather(self.filters), bytemuck::cast_slice(self.samples), &mut sums);
        sums
    }
}

/// The same in double precision.
struct DoubleSums<'a> {
    filters: &'a [Filter<f64>],
    samples: &'a [Sample<f64>],
}

impl Work for DoubleSums<'_> {
    type Output = [f64; DOUBLES];

    #[inline(always)]
    fn run<T: Laned<Element: bytemuck::Pod>>(self) -> [f64; DOUBLES] {
        let mut sums = [0.0; DOUBLES];
        let filter = Filter::<T>::gather(self.filters);
        absolute_error(&filter, bytemuck::cast_slice(self.samples), &mut sums);
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::{Candidates, LinearRecord, RecordError, Records};
    use crate::search::dispatch::Level;
    use crate::search::trial::{MOTOR, three_sines};
    use motorlens_shared::linear::Kind;
    use motorlens_shared::motor::{Combinations, PaperMotor};

    /// 37 motors around the true one: no multiple of the lanes.
    fn motors() -> Vec<Combinations> {
        (0..37)
            .map(|k| {
                let k = f64::from(k);
                let motor = PaperMotor {
                    resistance: MOTOR.resistance * (0.3 + 0.1 * k),
                    inductance: MOTOR.inductance * (8.0 - 0.2 * k),
                    ..MOTOR
                };
                motor.combinations()
            })
            .collect()
    }

    #[test]
    fn every_level_agrees_with_double_precision_within_its_stated_error() {
        for kind in [Kind::Angle, Kind::Speed] {
            for rate in [100, 1000] {
                for level in Level::available() {
                    let records = Records::new(&three_sines(rate, kind), level).expect("good records");
                    let motors = motors();
                    let mut candidates = Candidates::default();
                    records.discretise(&motors, &mut candidates);
                    let mut iae = vec![0.0; motors.len()];
                    records.iae_of(&candidates, &mut iae);
                    for (motor, iae) in motors.iter().zip(iae) {
                        let exact = records.exact_iae(motor);
                        let error = (iae - exact).abs() / exact;
                        assert!(error < 1e-4, "{level:?}, {kind:?}, {rate} Hz: {iae} {exact}");
                    }
                }
            }
        }
    }

    #[test]
    fn records_of_different_sampling_are_summed() {
        let mut mixed = three_sines(100, Kind::Angle);
        mixed.truncate(1);
        mixed.extend(three_sines(250, Kind::Speed).into_iter().take(1));
        let both = Records::new(&mixed, Level::best()).expect("good records");
        let alone = |r: &LinearRecord| {
            let alone = Records::new(std::slice::from_ref(r), Level::best()).expect("good");
            alone.exact_iae(&motors()[3])
        };
        let sum: f64 = mixed.iter().map(alone).sum();
        assert!((both.exact_iae(&motors()[3]) / sum - 1.0).abs() < 1e-12);
        let mut candidates = Candidates::default();
        both.discretise(&motors()[3..4], &mut candidates);
        let mut iae = [0.0];
        both.iae_of(&candidates, &mut iae);
        assert!((iae[0] / sum - 1.0).abs() < 1e-4);
    }

    #[test]
    fn bad_records_are_refused_with_their_place() {
        let good = three_sines(100, Kind::Angle);
        let refused = |change: fn(&mut LinearRecord)| {
            let mut records = good.clone();
            change(&mut records[1]);
            Records::new(&records, Level::best()).expect_err("refused")
        };
        let error = refused(|r| r.voltage[7] = f64::NAN);
        assert_eq!(error, RecordError::NotFinite { record: 2, sample: 8 });
        let error = refused(|r| r.measured.truncate(5));
        assert_eq!(error, RecordError::Lengths { record: 2, voltages: 1200, measured: 5 });
        assert_eq!(refused(|r| r.dt = 0.0), RecordError::Step { record: 2, step: 0.0 });
        assert_eq!(Records::new(&[], Level::best()).expect_err("refused"), RecordError::Empty);
    }
}
