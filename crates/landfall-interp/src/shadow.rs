//! Both precisions side by side: one of the [`Real`]s of the machine.

use super::code::{Cmp, LANES};
use super::lanes::Lanes;
use super::real::{ColumnWork, Real};

/// Both precisions: the result on a device, and the reference. Branches, comparisons and integers
/// follow the `f32`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shadow {
    pub single: f32,
    pub double: f64,
}

macro_rules! both {
    ($($name:ident($($b:ident),*);)*) => {$(
        #[inline(always)]
        fn $name(self $(, $b: Shadow)*) -> Shadow {
            Shadow {
                single: Real::$name(self.single $(, $b.single)*),
                double: Real::$name(self.double $(, $b.double)*),
            }
        }
    )*};
}

/// Each part in a column of its own: loops over one type of number are vectorised.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadowLanes {
    single: [f32; LANES],
    double: [f64; LANES],
}

impl Lanes for ShadowLanes {
    type Item = Shadow;
    #[inline(always)]
    fn filled(value: Shadow) -> ShadowLanes {
        ShadowLanes { single: [value.single; LANES], double: [value.double; LANES] }
    }
    #[inline(always)]
    fn lane(&self, lane: usize) -> Shadow {
        Shadow { single: self.single[lane], double: self.double[lane] }
    }
    #[inline(always)]
    fn put(&mut self, lane: usize, value: Shadow) {
        self.single[lane] = value.single;
        self.double[lane] = value.double;
    }
    #[inline(always)]
    fn set(&mut self, value: impl Fn(usize) -> Shadow) {
        // Each loop needs but one part of the value; compilers drop the other.
        self.single.set(|lane| value(lane).single);
        self.double.set(|lane| value(lane).double);
    }
    #[inline(always)]
    fn blend(&mut self, from: &ShadowLanes, lanes: u64) {
        self.single.blend(&from.single, lanes);
        self.double.blend(&from.double, lanes);
    }
}

impl Real for Shadow {
    const MANY: bool = true;
    type Lanes = ShadowLanes;
    #[inline(always)]
    fn narrow(x: f32) -> Shadow {
        Shadow { single: x, double: f64::from(x) }
    }
    #[inline(always)]
    fn wide(x: f64) -> Shadow {
        Shadow { single: x as f32, double: x }
    }
    #[inline(always)]
    fn single(self) -> f32 {
        self.single
    }
    #[inline(always)]
    fn double(self) -> f64 {
        self.double
    }
    #[inline(always)]
    fn followed(self) -> f64 {
        f64::from(self.single)
    }
    #[inline(always)]
    fn lift1(self, f: impl Fn(f64) -> f64) -> Shadow {
        Shadow { single: self.single.lift1(&f), double: f(self.double) }
    }
    #[inline(always)]
    fn lift2(self, b: Shadow, f: impl Fn(f64, f64) -> f64) -> Shadow {
        Shadow { single: self.single.lift2(b.single, &f), double: f(self.double, b.double) }
    }
    both! {
        add(b); sub(b); mul(b); div(b); rem(b); neg(); abs(); sqrt(); fma(b, c);
        floor(); ceil(); trunc(); round(); min(b); max(b); half();
    }
    fn on_parts<const N: usize>(
        to: &mut ShadowLanes,
        from: [&ShadowLanes; N],
        work: &impl ColumnWork<N>,
    ) {
        work.run::<f32>(&mut to.single, from.map(|lanes| &lanes.single));
        work.run::<f64>(&mut to.double, from.map(|lanes| &lanes.double));
    }
    #[inline(always)]
    fn whole(self) -> f64 {
        f64::from(self.single)
    }
    #[inline(always)]
    fn sint(x: i64) -> Shadow {
        Shadow { single: x as f32, double: x as f64 }
    }
    #[inline(always)]
    fn uint(x: u64) -> Shadow {
        Shadow { single: x as f32, double: x as f64 }
    }
    type By = f32;
    #[inline(always)]
    fn by(self) -> f32 {
        self.single
    }
    #[inline(always)]
    fn is_infinite(self) -> bool {
        self.single.is_infinite()
    }
    #[inline(always)]
    fn unsure(self, cmp: Cmp, b: Shadow) -> bool {
        let [x, y] = [self.single, b.single].map(f64::from);
        // Without branches, so that loops over lanes are vectorised.
        let finite = x.is_finite() & y.is_finite();
        finite & (cmp.holds(x, y) != cmp.holds(self.double, b.double))
    }
    #[inline(always)]
    fn same(self, b: Shadow) -> bool {
        self.single.same(b.single) && self.double.same(b.double)
    }
}
