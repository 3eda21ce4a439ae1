//! A function over the calls of a bench on a driver, as a workload.
//!
//! Takes a [`Variant`]; a run is the jobs of a [`Kernel`], including upload and read-back, which
//! the empty kernel with the same parameters measures alone.

use super::called::{CallErrors, Variant};
use super::clock::{BackendStopwatch, Elapsed};
use super::errors::Results;
use super::rounds::{Part, Workload};
use super::shader::SharedBackend;
use landfall_exec::backend::Failure;
use landfall_exec::harness::call::kernel::{Kernel, KernelResult};

pub struct DriverVariant<'a> {
    variant: &'a Variant<'a>,
    backend: SharedBackend,
    whole: Kernel<'a>,
    trivial: Option<Kernel<'a>>,
}

impl<'a> DriverVariant<'a> {
    /// A variant on a backend.
    ///
    /// # Errors
    /// Code the backend cannot run, such as WGSL on OpenGL.
    pub fn new(
        variant: &'a Variant<'a>,
        backend: SharedBackend,
    ) -> Result<DriverVariant<'a>, Failure> {
        let device = backend.borrow().device().clone();
        let whole = variant.pure().on(&device)?;
        // A trivial kernel that a device refuses is left out: the whole time is then not reduced.
        let trivial = variant.trivial().and_then(|kernel| kernel.on(&device).ok());
        Ok(DriverVariant { variant, backend, whole, trivial })
    }

    /// Returns the errors of its results against the truth.
    ///
    /// # Errors
    /// A failure of the backend.
    pub fn measure_errors(&self) -> Result<CallErrors, String> {
        let kinds = self.variant.kinds();
        self.variant.judged(|columns, lanes| {
            let called = self.call(&self.whole, columns, lanes)?.0;
            Ok(move |lane| {
                let word = |&(nth, at): &(usize, usize)| called.results[nth][at][lane];
                let float = |place| f64::from(f32::from_bits(word(place) as u32));
                Results {
                    floats: kinds.floats.iter().map(float).collect(),
                    wholes: kinds.wholes.iter().map(word).collect(),
                    missing: called.discarded.get(lane) == Some(&true),
                }
            })
        })
    }

    fn call(
        &self,
        driven: &Kernel<'_>,
        columns: &[Vec<u64>],
        lanes: usize,
    ) -> Result<(KernelResult, Option<Elapsed>), String> {
        let limit = self.variant.call_inputs().2;
        let mut backend = self.backend.borrow_mut();
        let mut watched = BackendStopwatch::new(backend.as_mut());
        let called = driven.call(&mut watched, columns, lanes, limit);
        Ok((called.map_err(|failure| failure.summary())?, watched.elapsed()))
    }
}

impl Workload for DriverVariant<'_> {
    fn has(&self, part: Part) -> bool {
        match part {
            Part::Whole => true,
            Part::Unlit => false,
            Part::Trivial => self.trivial.is_some(),
        }
    }

    fn run(&mut self, part: Part) -> Result<Option<Elapsed>, String> {
        let driven = match (part, &self.trivial) {
            (Part::Whole, _) => &self.whole,
            (Part::Trivial, Some(trivial)) => trivial,
            (Part::Trivial, None) | (Part::Unlit, _) => {
                return Err("internal error: the samples of this run were not prepared".to_string());
            }
        };
        let (columns, lanes, _) = self.variant.call_inputs();
        Ok(self.call(driven, columns, lanes)?.1)
    }
}
