//! How the values of an input are distributed over its range.
//!
//! Stated beside the range in a [`Domain`](super::domain::Domain); drawn from by
//! `sampler`.

use std::sync::Arc;

use super::random::Random;

/// The distribution of a scalar over its range.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Distribution {
    /// Each value equally likely.
    #[default]
    Uniform,
    /// Each power of two equally likely; the range excludes 0.
    Log,
    /// A normal distribution, of which values outside of the range are left out.
    Normal {
        mean: f64,
        /// The standard deviation.
        deviation: f64,
    },
    /// The bins of a histogram by their counts, uniform within each.
    Histogram(Arc<Histogram>),
}

/// A histogram: neighbouring bins with the number of values in each.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// The edges of the bins, ascending; one more than bins.
    edges: Vec<f64>,
    /// The sums of the counts of the bins up to each.
    sums: Vec<f64>,
}

/// The most values drawn from a normal distribution until one is in the range.
const TRIES: usize = 1 << 12;

impl Distribution {
    /// Draws a number between the bounds of a range.
    pub(crate) fn draw(&self, (low, high): (f64, f64), random: &mut Random) -> f64 {
        let x = match self {
            _ if low == high => low,
            Distribution::Uniform => random.between(low, high),
            Distribution::Log if low > 0.0 => random.scale(low, high),
            Distribution::Log => -random.scale(-high, -low),
            Distribution::Normal { mean, deviation } => {
                let mut all = (0..TRIES).map(|_| mean + deviation * random.normal());
                let inside = all.find(|x| (low..=high).contains(x));
                // A range far out in a tail is hit too seldom to draw from.
                inside.unwrap_or_else(|| random.between(low, high))
            }
            Distribution::Histogram(histogram) => histogram.draw(random),
        };
        x.clamp(low, high)
    }

    /// Whether it takes values of a range: `Err` with the reason if it does not.
    pub(super) fn fits(&self, low: f64, high: f64) -> Result<(), String> {
        match self {
            Distribution::Log if low <= 0.0 && high >= 0.0 => {
                Err("a range with 0 in it has no logarithmic distribution".to_string())
            }
            Distribution::Normal { mean, deviation }
                if low > mean + 3.0 * deviation || high < mean - 3.0 * deviation =>
            {
                Err("the range is more than 3 standard deviations from the mean".to_string())
            }
            Distribution::Uniform
            | Distribution::Log
            | Distribution::Normal { .. }
            | Distribution::Histogram(_) => Ok(()),
        }
    }

    /// The name in reports.
    pub(super) fn text(&self) -> String {
        match self {
            Distribution::Uniform => "uniform".to_string(),
            Distribution::Log => "log".to_string(),
            Distribution::Normal { mean, deviation } => {
                format!("normal (mean {mean}, deviation {deviation})")
            }
            Distribution::Histogram(_) => "histogram".to_string(),
        }
    }
}

impl Histogram {
    /// A histogram of counts between ascending edges; `None` if these do not fit.
    pub(super) fn new(edges: Vec<f64>, counts: &[f64]) -> Option<Histogram> {
        let ascending = edges.windows(2).all(|pair| pair[0] < pair[1]);
        let finite = edges.iter().all(|x| x.is_finite());
        let counted = counts.iter().all(|n| n.is_finite() && *n >= 0.0);
        let sums = counts.iter().scan(0.0, |sum, count| {
            *sum += count;
            Some(*sum)
        });
        let sums: Vec<f64> = sums.collect();
        let any = sums.last().is_some_and(|sum| *sum > 0.0 && sum.is_finite());
        let fits = edges.len() == counts.len() + 1 && ascending && finite && counted && any;
        fits.then_some(Histogram { edges, sums })
    }

    pub(super) fn bounds(&self) -> (f64, f64) {
        (self.edges[0], self.edges[self.edges.len() - 1])
    }

    fn draw(&self, random: &mut Random) -> f64 {
        let at = random.unit() * self.sums[self.sums.len() - 1];
        let bin = self.sums.partition_point(|sum| *sum <= at).min(self.sums.len() - 1);
        random.between(self.edges[bin], self.edges[bin + 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(distribution: &Distribution, low: f64, high: f64) -> Vec<f64> {
        let mut random = Random::new(5, 0);
        (0..100_000).map(|_| distribution.draw((low, high), &mut random)).collect()
    }

    fn share(all: &[f64], is: impl Fn(f64) -> bool) -> f64 {
        all.iter().filter(|x| is(**x)).count() as f64 / all.len() as f64
    }

    #[test]
    fn each_distribution_has_the_shares_of_its_definition() {
        // Of 100,000 values a share is within 0.005 of its expectation but for one in 1,000 seeds.
        let near = |share: f64, wanted: f64| assert!((share - wanted).abs() < 0.005, "{share}");
        near(share(&drawn(&Distribution::Uniform, 3.0, 7.0), |x| x < 4.0), 0.25);
        near(share(&drawn(&Distribution::Log, 1e-3, 1e3), |x| x < 0.1), 1.0 / 3.0);
        near(share(&drawn(&Distribution::Log, -16.0, -1.0), |x| x < -4.0), 0.5);
        // The normal distribution function at 1 is 0.8413, of which 0.5 are below 0.
        let normal = Distribution::Normal { mean: 2.0, deviation: 0.5 };
        near(share(&drawn(&normal, 0.0, 4.0), |x| x < 2.5), 0.8413);
        near(share(&drawn(&normal, 2.0, 4.0), |x| x < 2.5), 2.0 * (0.8413 - 0.5));
        let bins = Histogram::new(vec![0.0, 1.0, 4.0], &[1.0, 3.0]).expect("it fits");
        let bins = Distribution::Histogram(Arc::new(bins));
        near(share(&drawn(&bins, 0.0, 4.0), |x| x < 1.0), 0.25);
        near(share(&drawn(&bins, 0.0, 4.0), |x| x > 3.0), 0.25);
        assert_eq!(drawn(&Distribution::Uniform, 0.1, 0.1), [0.1; 100_000]);
    }

    #[test]
    fn a_histogram_has_ascending_edges_and_counts() {
        assert!(Histogram::new(vec![0.0, 0.0, 1.0], &[1.0, 1.0]).is_none());
        assert!(Histogram::new(vec![0.0, 1.0], &[1.0, 1.0]).is_none());
        assert!(Histogram::new(vec![0.0, 1.0], &[0.0]).is_none());
        assert!(Histogram::new(vec![0.0, 1.0], &[-1.0]).is_none());
        assert!(Histogram::new(Vec::new(), &[]).is_none());
    }
}
