//! Plays a programme sample by sample.

use super::plan::Plan;
use super::sequence::Lfsr;
use super::{Fault, MAX_SEGMENTS, Programme, ProgrammeError};
use heapless::Vec;

/// The state of playing one programme at one sample rate: an iterator of volts.
///
/// [`Player::new`] does everything slow (the crest of a multisine is scanned, up to about a million
/// operations), so it belongs outside the interrupt; [`Iterator::next`] costs at most 14 sines of about
/// twenty operations. The log and the device agree because both take the same `f32`.
///
/// Against `f64`: sines within `amplitude * (2.5e-7 + 2 pi * 2^-33 * samples)`, chirps within
/// `amplitude * 2 pi * 3e-7 * cycles so far`.
#[derive(Debug, Clone)]
pub struct Player {
    plans: Vec<(u32, Plan), MAX_SEGMENTS>,
    rate_hz: u32,
    segment: usize,
    sample: u32,
    register: Lfsr,
    chip: bool,
}

impl Player {
    /// Prepares `programme` for `rate_hz` samples per second (1 to 50000).
    ///
    /// # Errors
    /// Whatever [`Programme::validate`] finds (with no voltage limit), and what is too fast for the rate.
    pub fn new(programme: &Programme, rate_hz: u32) -> Result<Self, ProgrammeError> {
        Self::with_progress(programme, rate_hz, &mut || ())
    }

    /// [`Self::new`], which calls `alive` again and again, at least every thousand points of a crest (14 sines each): a
    /// board feeds its watchdog there.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_progress(
        programme: &Programme,
        rate_hz: u32,
        alive: &mut dyn FnMut(),
    ) -> Result<Self, ProgrammeError> {
        if !(1..=50_000).contains(&rate_hz) {
            return Err(ProgrammeError::whole(Fault::Rate));
        }
        programme.validate(f32::MAX)?;
        let mut plans = Vec::new();
        for (index, segment) in programme.segments.iter().enumerate() {
            let samples = libm::round(f64::from(segment.seconds) * f64::from(rate_hz)).max(0.0) as u32;
            if samples == 0 {
                let fault = Fault::TooFastForRate { rate_hz };
                return Err(ProgrammeError::at(index, fault));
            }
            let plan = Plan::new(segment, samples, rate_hz, alive)
                .map_err(|fault| ProgrammeError::at(index, fault))?;
            plans.extend([(samples, plan)]);
        }
        Ok(Self { plans, rate_hz, segment: 0, sample: 0, register: Lfsr::new(0), chip: false })
    }

    /// Samples in the whole programme.
    pub fn samples(&self) -> u32 {
        self.plans.iter().map(|(samples, _)| samples).sum()
    }

    /// The sample rate that it was prepared for, in hertz.
    pub fn rate_hz(&self) -> u32 {
        self.rate_hz
    }

    /// The segment that the next sample belongs to, from 0; the number of segments when it has ended.
    pub fn segment(&self) -> usize {
        self.segment
    }

    /// Back to the first sample.
    pub fn rewind(&mut self) {
        self.segment = 0;
        self.sample = 0;
    }
}

impl Iterator for Player {
    type Item = f32;

    /// The voltage of the next sample, in volts; `None` when the programme has ended.
    #[inline]
    fn next(&mut self) -> Option<f32> {
        let (samples, plan) = self.plans.get(self.segment)?;
        if let Plan::Prbs { chip, seed, .. } = *plan {
            if self.sample == 0 {
                self.register = Lfsr::new(seed);
            }
            if self.sample.is_multiple_of(chip) {
                self.chip = self.register.next_chip();
            }
        }
        let volts = plan.volts(self.sample, self.chip);
        self.sample += 1;
        if self.sample == *samples {
            self.sample = 0;
            self.segment += 1;
        }
        Some(volts)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let total: u32 = self.plans.iter().skip(self.segment).map(|(samples, _)| samples).sum();
        let left = (total - self.sample) as usize;
        (left, Some(left))
    }
}

impl ExactSizeIterator for Player {}
