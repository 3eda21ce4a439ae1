//! Scales: the place of a number on an axis, and the numbers written along it.

/// An axis of numbers from `low` to `high`.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// The quantity and its unit.
    pub label: String,
    pub low: f64,
    pub high: f64,
    /// The spacing of numbers.
    pub scale: Scale,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences are equal lengths.
    Linear,
    /// Equal ratios are equal lengths; all numbers are positive.
    Log,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// The place, from 0 to 1.
    pub at: f64,
    /// The text; empty for a line alone.
    pub text: String,
}

impl Axis {
    pub fn linear(label: impl Into<String>, low: f64, high: f64) -> Axis {
        let (low, high) = ordered(low, high);
        let high = if high > low { high } else { low + 1.0 };
        Axis { label: label.into(), low, high, scale: Scale::Linear }
    }

    /// A logarithmic axis.
    ///
    /// Bounds that are not positive and finite are clamped; bounds closer than a third of a decade
    /// are widened.
    pub fn log(label: impl Into<String>, low: f64, high: f64) -> Axis {
        let usable = |x: f64| if x > 0.0 && x.is_finite() { x.clamp(1e-300, 1e300) } else { 1.0 };
        let (mut low, mut high) = ordered(usable(low), usable(high));
        if high < 2.0 * low {
            let middle = (low * high).sqrt();
            (low, high) = (middle / 2f64.sqrt(), middle * 2f64.sqrt());
        }
        Axis { label: label.into(), low, high, scale: Scale::Log }
    }

    /// A logarithmic axis with a margin around numbers; around 1 if there are none.
    pub fn around(label: impl Into<String>, numbers: impl Iterator<Item = f64>) -> Axis {
        let mut range: Option<(f64, f64)> = None;
        for x in numbers.filter(|x| *x > 0.0 && x.is_finite()) {
            let (low, high) = range.unwrap_or((x, x));
            range = Some((low.min(x), high.max(x)));
        }
        let (low, high) = range.unwrap_or((1.0, 1.0));
        let tight = Axis::log(label, low, high);
        let room = (tight.high / tight.low).powf(0.12);
        Axis { low: tight.low / room, high: tight.high * room, ..tight }
    }

    /// Returns the place of a number, from 0 to 1; clamped to the ends.
    pub fn at(&self, number: f64) -> f64 {
        let at = match self.scale {
            Scale::Linear => (number - self.low) / (self.high - self.low),
            Scale::Log => (number / self.low).ln() / (self.high / self.low).ln(),
        };
        // The logarithm of zero or less.
        if at.is_nan() { 0.0 } else { at.clamp(0.0, 1.0) }
    }

    /// Returns the number at a place from 0 to 1.
    pub fn number(&self, at: f64) -> f64 {
        match self.scale {
            Scale::Linear => self.low + at * (self.high - self.low),
            Scale::Log => self.low * (self.high / self.low).powf(at),
        }
    }

    /// Returns about `most` round numbers at most, and the lines between decades.
    pub fn ticks(&self, most: usize) -> Vec<Tick> {
        match self.scale {
            Scale::Linear => self.linear_ticks(most.max(2)),
            Scale::Log => self.log_ticks(most.max(2)),
        }
    }

    fn linear_ticks(&self, most: usize) -> Vec<Tick> {
        let rough = (self.high - self.low) / most as f64;
        let decade = 10f64.powf(rough.log10().floor());
        let step =
            // The next round step that gives no more ticks than wanted.
            [1.0, 2.0, 5.0, 10.0].map(|by| by * decade).into_iter().find(|step| *step >= rough);
        let step = step.unwrap_or(10.0 * decade);
        let (first, last) = ((self.low / step).ceil(), (self.high / step).floor());
        (0..=(last - first).max(0.0) as usize)
            .map(|i| (first + i as f64) * step)
            .map(|number| Tick { at: self.at(number), text: number_text(number, step) })
            .collect()
    }

    fn log_ticks(&self, most: usize) -> Vec<Tick> {
        let first = self.low.log10().floor() as i32;
        let last = self.high.log10().ceil() as i32;
        let decades = (self.high / self.low).log10();
        let every = (decades / most as f64).ceil().max(1.0) as i32;
        let written = |digit: i32| match digit {
            1 => true,
            2 | 5 => decades * 3.0 <= most as f64,
            _ => false,
        };
        let lines: &[i32] = if every == 1 { &[1, 2, 3, 4, 5, 6, 7, 8, 9] } else { &[1] };
        let mut ticks = Vec::new();
        for exponent in first..=last {
            for &digit in lines {
                let number = f64::from(digit) * 10f64.powi(exponent);
                // Rounding may put an end slightly outside.
                let inside = self.low * (1.0 - 1e-9)..=self.high * (1.0 + 1e-9);
                if !inside.contains(&number) {
                    continue;
                }
                let text = match exponent.rem_euclid(every) == 0 && written(digit) {
                    true => power(digit, exponent),
                    false => String::new(),
                };
                ticks.push(Tick { at: self.at(number), text });
            }
        }
        ticks
    }
}

fn ordered(a: f64, b: f64) -> (f64, f64) {
    if a <= b { (a, b) } else { (b, a) }
}

/// Formats a number with the digits that its step needs.
fn number_text(number: f64, step: f64) -> String {
    if number == 0.0 {
        return "0".to_string();
    }
    if !(1e-4..1e6).contains(&number.abs()) {
        return format!("{number:.2e}");
    }
    let digits = (-step.log10().floor()).max(0.0) as usize;
    format!("{number:.digits$}")
}

/// Formats `digit` times a power of ten.
fn power(digit: i32, exponent: i32) -> String {
    match exponent {
        0..=3 => format!("{}", i64::from(digit) * 10i64.pow(exponent as u32)),
        -4..=-1 => {
            let zeros = "0".repeat((-exponent - 1) as usize);
            format!("0.{zeros}{digit}")
        }
        _ => {
            let raised: String = exponent
                .to_string()
                .chars()
                .map(|c| match c {
                    '-' => '⁻',
                    '1' => '¹',
                    '2' => '²',
                    '3' => '³',
                    c => char::from_u32('⁰' as u32 + c as u32 - '0' as u32)
                        .expect("the raised digits follow each other"),
                })
                .collect();
            if digit == 1 { format!("10{raised}") } else { format!("{digit}·10{raised}") }
        }
    }
}
