//! Counting what lighting does: by a type, so that what is timed does not count.

/// What is told of each step of the work.
pub trait Tally {
    /// A light was looped over.
    fn trip(&mut self) {}
    /// Its terms were evaluated.
    fn evaluation(&mut self) {}
    /// Its attenuation was divided by.
    fn attenuation(&mut self) {}
    /// A power was raised.
    fn power(&mut self) {}
}

/// Counts nothing.
impl Tally for () {}

/// How much was done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Fragments lit.
    pub fragments: u64,
    /// Lights looped over, summed over the fragments.
    pub trips: u64,
    /// Lights whose terms were evaluated.
    pub evaluations: u64,
    /// Attenuations computed.
    pub attenuations: u64,
    /// Powers raised.
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

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Work) {
        self.fragments += other.fragments;
        self.trips += other.trips;
        self.evaluations += other.evaluations;
        self.attenuations += other.attenuations;
        self.powers += other.powers;
    }
}
