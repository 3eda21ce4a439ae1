//! Counts the work of lighting, by a type parameter, so that timed code does not count.

/// The events of lighting.
pub trait Tally {
    /// Whether anything is counted.
    const COUNTS: bool = true;

    /// A light is visited.
    fn trip(&mut self) {}
    /// The terms of a light are evaluated.
    fn evaluation(&mut self) {}
    /// An attenuation is divided by.
    fn attenuation(&mut self) {}
    /// A power is evaluated.
    fn power(&mut self) {}
}

impl Tally for () {
    const COUNTS: bool = false;
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// The lights visited, over all fragments.
    pub trips: u64,
    /// The lights whose terms were evaluated.
    pub evaluations: u64,
    pub attenuations: u64,
    pub powers: u64,
}

impl Tally for Work {
    fn trip(&mut self) {
        self.trips += 1;
    }

    fn evaluation(&mut self) {
        self.evaluations += 1;
    }

    fn attenuation(&mut self) {
        self.attenuations += 1;
    }

    fn power(&mut self) {
        self.powers += 1;
    }
}
