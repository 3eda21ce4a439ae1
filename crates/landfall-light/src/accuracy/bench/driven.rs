//! A function over the calls of a bench by a driver, as a workload.
//!
//! Takes a [`Variant`]; a run is the jobs of [`Driven`] with their upload and read-back, of which
//! the kernel of the same words has as much.

use super::called::Variant;
use super::clock::{Stopwatch, Took};
use super::errors::{Errors, Results};
use super::rounds::{Part, Workload};
use super::shader::Shared;
use landfall_exec::backend::Failure;
use landfall_exec::harness::call::driven::{Driven, DrivenCalled};

/// A variant by a driver.
pub struct OnDriver<'a> {
    variant: &'a Variant<'a>,
    reader: Shared,
    whole: Driven<'a>,
    trivial: Option<Driven<'a>>,
}

impl<'a> OnDriver<'a> {
    /// A variant by a reader.
    ///
    /// # Errors
    /// Why it cannot be run there, such as WGSL by OpenGL.
    pub fn new(variant: &'a Variant<'a>, reader: Shared) -> Result<OnDriver<'a>, Failure> {
        let device = reader.borrow().device().clone();
        let whole = variant.pure().on(&device)?;
        let trivial = variant.trivial().and_then(|kernel| kernel.on(&device).ok());
        Ok(OnDriver { variant, reader, whole, trivial })
    }

    /// How far what it gives is from the truth.
    ///
    /// # Errors
    /// What the reader says.
    pub fn judged(&self) -> Result<Errors, String> {
        let called = self.call(&self.whole)?.0;
        let kinds = self.variant.kinds();
        let each = self.variant.truth().iter().enumerate().map(|(lane, truth)| {
            let word = |&(nth, at): &(usize, usize)| called.results[nth][at][lane];
            let float = |place| f64::from(f32::from_bits(word(place) as u32));
            let results = Results {
                floats: kinds.floats.iter().map(float).collect(),
                wholes: kinds.wholes.iter().map(word).collect(),
                missing: called.discarded.get(lane) == Some(&true),
            };
            (results, truth.clone())
        });
        Ok(Errors::of_calls(each))
    }

    fn call(&self, driven: &Driven<'_>) -> Result<(DrivenCalled, Option<Took>), String> {
        let (columns, lanes, limit) = self.variant.given();
        let mut reader = self.reader.borrow_mut();
        let mut watched = Stopwatch::new(reader.as_mut());
        let called = driven.call(&mut watched, columns, lanes, limit);
        Ok((called.map_err(|failure| failure.brief())?, watched.took()))
    }
}

impl Workload for OnDriver<'_> {
    fn has(&self, part: Part) -> bool {
        match part {
            Part::Whole => true,
            Part::Unlit => false,
            Part::Trivial => self.trivial.is_some(),
        }
    }

    fn run(&mut self, part: Part) -> Result<Option<Took>, String> {
        let driven = match (part, &self.trivial) {
            (Part::Whole, _) => &self.whole,
            (Part::Trivial, Some(trivial)) => trivial,
            (Part::Trivial, None) | (Part::Unlit, _) => {
                return Err("it has no such part".to_string());
            }
        };
        Ok(self.call(driven)?.1)
    }
}
