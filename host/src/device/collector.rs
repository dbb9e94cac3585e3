//! Puts a run's log together from blocks that come late, twice, or not at all.

use motorlens_shared::link::{LogBlock, Sample};
use std::ops::Range;
use std::time::Duration;

/// Missing samples are asked for again after this time.
const AGAIN: Duration = Duration::from_millis(40);
/// Ranges asked for at once: no more than the board lets wait.
const RANGES: usize = 6;
/// Samples asked for in one request.
const AT_ONCE: u32 = 64;

/// Samples that a line may be out for: half a minute at the fastest rate.
const FAR: usize = 60_000;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Place {
    Missing,
    Here(Sample),
    /// The board no longer has it.
    Gone,
}

/// A run's log while it is put together.
#[derive(Debug)]
pub struct Collector {
    run: u32,
    places: Vec<Place>,
    complete: usize,
    asked: Option<Duration>,
}

impl Collector {
    /// An empty log of a run.
    pub fn new(run: u32) -> Self {
        Self { run, places: Vec::new(), complete: 0, asked: None }
    }

    /// Takes a block. Blocks of other runs are dropped.
    pub fn block(&mut self, block: &LogBlock) {
        // A number far ahead of all others is no sample of this run, whatever the frame's checksum says.
        if block.run != self.run || block.first as usize > self.places.len() + FAR {
            return;
        }
        self.expect(block.first + block.samples.len() as u32);
        for (place, sample) in self.places[block.first as usize..].iter_mut().zip(&block.samples) {
            *place = Place::Here(*sample);
        }
        self.advance();
    }

    /// The board says that it no longer has these; what lies beyond the run's end is simply not yet there.
    pub fn not_held(&mut self, first: u32, count: u32) {
        let end = (first.saturating_add(count) as usize).min(self.places.len());
        for place in self.places.get_mut(first as usize..end).unwrap_or_default() {
            if *place == Place::Missing {
                *place = Place::Gone;
            }
        }
        self.advance();
    }

    /// The run has so many samples by now.
    pub fn expect(&mut self, samples: u32) {
        if samples as usize > self.places.len() + FAR {
            return;
        }
        if samples as usize > self.places.len() {
            self.places.resize(samples as usize, Place::Missing);
        }
    }

    fn advance(&mut self) {
        while self.places.get(self.complete).is_some_and(|place| *place != Place::Missing) {
            self.complete += 1;
        }
    }

    /// Whether nothing known of is missing any more.
    pub fn is_complete(&self) -> bool {
        self.complete == self.places.len()
    }

    /// Samples known of.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether no sample is known of.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Samples from number `from` on that have come without a gap, with their numbers.
    pub fn samples_from(&self, from: usize) -> Vec<(u32, Sample)> {
        let numbered = (0..).zip(&self.places).skip(from);
        let here = numbered.map_while(|(index, place)| match place {
            Place::Here(sample) => Some((index, *sample)),
            Place::Gone => Some((index, Sample::MISSED)),
            Place::Missing => None,
        });
        here.collect()
    }

    /// What to ask for now: first sample and count of each range.
    pub fn requests(&mut self, now: Duration) -> Vec<(u32, u16)> {
        if self.is_complete() || self.asked.is_some_and(|asked| now.saturating_sub(asked) < AGAIN) {
            return Vec::new();
        }
        self.asked = Some(now);
        let mut ranges = Vec::new();
        let mut at = self.complete;
        while ranges.len() < RANGES && at < self.places.len() {
            let count = self.places[at..]
                .iter()
                .take(AT_ONCE as usize)
                .take_while(|place| **place == Place::Missing)
                .count();
            if count > 0 {
                ranges.push((at as u32, count as u16));
            }
            at += count.max(1);
        }
        ranges
    }

    /// The samples, each with its number, without those that are gone or were not taken; and the ranges of those.
    pub fn finish(&self) -> (Vec<(u32, Sample)>, Vec<Range<u32>>) {
        let mut samples = Vec::new();
        let mut holes: Vec<Range<u32>> = Vec::new();
        for (index, place) in (0..).zip(&self.places) {
            match place {
                Place::Here(sample) if !sample.missed() => samples.push((index, *sample)),
                _ => match holes.last_mut() {
                    Some(hole) if hole.end == index => hole.end += 1,
                    _ => holes.push(index..index + 1),
                },
            }
        }
        (samples, holes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(first: u32, count: u32) -> LogBlock {
        let sample = |index| Sample { duty: 1, count: index as i32, supply_mv: 1, current_ma: 0, late_us: 0 };
        LogBlock { run: 7, first, samples: (first..first + count).map(sample).collect() }
    }

    #[test]
    fn gaps_are_asked_for_until_they_are_filled_or_known_to_be_gone() {
        let mut collector = Collector::new(7);
        collector.block(&block(0, 8));
        collector.block(&block(16, 8));
        collector.block(&block(40, 4));
        collector.block(&LogBlock { run: 6, ..block(8, 8) });
        let now = Duration::from_secs(1);
        assert_eq!(collector.requests(now), [(8, 8), (24, 16)]);
        assert_eq!(
            collector.samples_from(3).iter().map(|(index, _)| *index).collect::<Vec<_>>(),
            [3, 4, 5, 6, 7]
        );
        assert_eq!(collector.requests(now + AGAIN / 2), []);
        collector.block(&block(8, 8));
        collector.block(&block(24, 8));
        assert_eq!(collector.requests(now + AGAIN), [(32, 8)]);
        collector.not_held(32, 6);
        collector.block(&block(38, 2));
        assert!(collector.is_complete());
        let (samples, holes) = collector.finish();
        assert_eq!((samples.len(), holes.len(), &holes[0]), (38, 1, &(32..38)));
        assert!(samples.iter().all(|(index, sample)| *index as i32 == sample.count));
    }

    #[test]
    fn samples_that_were_not_taken_are_holes_too() {
        let mut collector = Collector::new(7);
        let mut with_missed = block(0, 4);
        with_missed.samples[2] = Sample::MISSED;
        collector.block(&with_missed);
        assert_eq!(collector.finish().1.as_slice(), std::slice::from_ref(&(2..3)));
    }
}
