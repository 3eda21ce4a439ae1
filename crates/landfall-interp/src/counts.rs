//! The cost of a run in operations, the same on every machine.
//!
//! A scalar operation of one active invocation counts one; copies, branches and bit casts count
//! nothing.

use super::code::{Cast, Inst, Op, RealBinary, RealTernary, RealUnary};

/// The kinds of operations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cost {
    Free,
    Arithmetic,
    Transcendental,
    Load,
    Store,
    Texture,
}

const KINDS: usize = 6;

/// The cost of an instruction per active lane, and its size.
#[derive(Clone, Copy, Debug)]
pub(super) struct InstructionCost {
    pub kind: Cost,
    pub weight: u32,
    /// The number of its words in the pool.
    pub operands: u32,
}

/// The operations counted while a machine runs.
#[derive(Clone, Debug)]
pub(super) struct Tally {
    pub kinds: [u64; KINDS],
    /// By function: the number of lanes that entered it.
    pub calls: Vec<u64>,
}

impl Tally {
    pub fn new(functions: usize) -> Tally {
        Tally { kinds: [0; KINDS], calls: vec![0; functions] }
    }

    pub fn add(&mut self, other: &Tally) {
        self.kinds.iter_mut().zip(other.kinds).for_each(|(sum, n)| *sum += n);
        self.calls.iter_mut().zip(&other.calls).for_each(|(sum, n)| *sum += n);
    }

    pub fn counts(&self, names: impl Iterator<Item = String>) -> Counts {
        let [_, arithmetic, transcendental, loads, stores, textures] = self.kinds;
        let calls = names.zip(self.calls.iter().copied()).filter(|(_, n)| *n > 0).collect();
        Counts { arithmetic, transcendental, loads, stores, textures, calls }
    }
}

/// The operations of a run, summed over the active invocations.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Additions, products, divisions, roots, comparisons, bit operations, conversions, one per
    /// component. A dot product of three components counts five, a `normalize` nine.
    pub arithmetic: u64,
    /// `pow`, `exp`, `log`, `sin` and similar functions.
    pub transcendental: u64,
    /// Scalars read from buffers.
    pub loads: u64,
    /// Scalars written to buffers.
    pub stores: u64,
    /// Texture lookups.
    pub textures: u64,
    /// The number of invocations that called each function, by name; entry points included.
    pub calls: Vec<(String, u64)>,
}

impl Counts {
    /// Returns the number of all operations.
    pub fn operations(&self) -> u64 {
        self.arithmetic + self.transcendental + self.loads + self.stores + self.textures
    }

    /// Returns how many invocations called a function.
    pub fn calls_of(&self, name: &str) -> u64 {
        self.calls.iter().filter(|(called, _)| called == name).map(|(_, n)| n).sum()
    }
}

/// Returns the cost of an instruction.
pub(super) fn instruction_cost(inst: &Inst) -> InstructionCost {
    use Cost::{Arithmetic, Free, Load, Store, Texture, Transcendental};
    let (kind, each) = match inst.op {
        Op::RealUnary(f) | Op::D1(f) => match f {
            RealUnary::Sin
            | RealUnary::Cos
            | RealUnary::Tan
            | RealUnary::Sinh
            | RealUnary::Cosh
            | RealUnary::Tanh
            | RealUnary::Asin
            | RealUnary::Acos
            | RealUnary::Atan
            | RealUnary::Asinh
            | RealUnary::Acosh
            | RealUnary::Atanh
            | RealUnary::Exp
            | RealUnary::Exp2
            | RealUnary::Log
            | RealUnary::Log2 => (Transcendental, 1),
            // A root and a quotient, a floor and a difference, a least and a greatest.
            RealUnary::InverseSqrt | RealUnary::Fract | RealUnary::Saturate => (Arithmetic, 2),
            _ => (Arithmetic, 1),
        },
        Op::RealBinary(RealBinary::Pow | RealBinary::Atan2) => (Transcendental, 1),
        // What their formulas count: GLSL 4.60 §8.3.
        Op::RealTernary(RealTernary::Mix) | Op::D3(RealTernary::Mix) => (Arithmetic, 4),
        Op::RealTernary(RealTernary::SmoothStep) | Op::D3(RealTernary::SmoothStep) => {
            (Arithmetic, 9)
        }
        Op::RealTernary(_) | Op::D3(_) => (Arithmetic, 2),
        // Products and the sums of them; then a root, and for each component a difference or a
        // quotient.
        Op::Dot(n) | Op::DDot(n) => (Arithmetic, 2 * u32::from(n) - 1),
        Op::Length(n) => (Arithmetic, 2 * u32::from(n)),
        Op::Distance(n) | Op::Normalize(n) => (Arithmetic, 3 * u32::from(n)),
        Op::Cross => (Arithmetic, 9),
        Op::RealBinary(_)
        | Op::FCmp(_)
        | Op::FTest(_)
        | Op::Ldexp
        | Op::WordUnary(_)
        | Op::WordBinary(_) => (Arithmetic, 1),
        Op::CmpSint(_) | Op::CmpUint(_) | Op::ExtractSint | Op::ExtractUint | Op::Insert => {
            (Arithmetic, 1)
        }
        Op::DNeg | Op::DNot | Op::WideBinary(_) | Op::DCmp(_) | Op::DCmpSint(_) => (Arithmetic, 1),
        Op::DCmpUint(_) | Op::DTest(_) | Op::DAbsSint | Op::DSignSint => (Arithmetic, 1),
        Op::Cast(Cast::RealBits | Cast::BitsReal) => (Free, 0),
        Op::Cast(_) | Op::Select(_) => (Arithmetic, 1),
        Op::DerivativeFine(_) | Op::DerivativeCoarse(_) => (Arithmetic, 1),
        Op::Load(_) => (Load, 1),
        Op::StoreMemory(_) => (Store, 1),
        Op::Atomic(_) => (Store, 2),
        Op::Sample | Op::Sampled | Op::Texel => (Texture, 1),
        Op::Move(_)
        | Op::Undefined(_)
        | Op::Store(_)
        | Op::Gather(..)
        | Op::Scatter(..)
        | Op::ArrayLength(_)
        | Op::ImageSize
        | Op::Nop
        | Op::If(_)
        | Op::Else(_)
        | Op::EndIf(_)
        | Op::Loop
        | Op::Continuing(_)
        | Op::BreakIf
        | Op::LoopBack(_)
        | Op::LoopEnd(_)
        | Op::Switch
        | Op::Case(_)
        | Op::CaseSkip(_)
        | Op::CaseEnd
        | Op::SwitchEnd(_)
        | Op::Break
        | Op::Continue
        | Op::Return
        | Op::Kill
        | Op::Barrier
        | Op::Call(_)
        | Op::Inlined(_)
        | Op::End => (Free, 0),
    };
    InstructionCost { kind, weight: each * inst.groups, operands: inst.operands() as u32 }
}
