//! The flat form of a shader: instructions over columns of lanes.
//!
//! Written by [`compile`](super::compile), optimised by [`optimize`](super::optimize), run by
//! [`machine`](super::machine). Every register holds one scalar of all lanes.

mod operation;

pub(super) use operation::{Cast, RealBinary, RealTernary, WideBinary, WordBinary, WordUnary};
pub use operation::{Cmp, RealUnary, Test};

/// Invocations that run at a time, one bit of a mask each.
pub(super) const LANES: usize = 64;

/// The register file of a scalar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Class {
    /// `f32` and `f16`, in the precision of the run.
    Real,
    /// Integers of up to 32 bits and bools, which are 0 or 1.
    Word,
    /// The bits of `f64`, `i64` and `u64`.
    Wide,
}

/// The instructions that may write a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WriteRegion {
    /// None: filled once.
    Constant,
    /// Stores, lane by lane.
    Variable,
    /// A single instruction.
    Temporary,
}

/// A register: class, region and number packed in a word until the program is linked, a plain index
/// into its class's file from then on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Reg(pub u32);

impl Reg {
    /// Maximum number of registers of one class and region.
    pub const LIMIT: u32 = 1 << 28;

    pub fn new(class: Class, region: WriteRegion, number: u32) -> Reg {
        // Bits 31 and 30: the class; 29 and 28: the region; the others: the number.
        Reg((class as u32) << 30 | (region as u32) << 28 | number)
    }

    pub fn class(self) -> Class {
        match self.0 >> 30 {
            0 => Class::Real,
            1 => Class::Word,
            _ => Class::Wide,
        }
    }

    pub fn region(self) -> WriteRegion {
        match self.0 >> 28 & 3 {
            0 => WriteRegion::Constant,
            1 => WriteRegion::Variable,
            _ => WriteRegion::Temporary,
        }
    }

    pub fn number(self) -> u32 {
        self.0 & (Reg::LIMIT - 1)
    }
}

/// An instruction: `head` registers read once, then `groups` times the operands of its [`Shape`],
/// all in the program's pool from `at` on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inst {
    pub op: Op,
    pub head: u8,
    /// Whether its results are the same for all invocations of a run, and in registers of their own.
    pub once: bool,
    /// Whether it multiplies, and the next instruction adds or subtracts in as many groups, and nothing
    /// else reads the products.
    pub fused: bool,
    pub groups: u32,
    pub at: u32,
}

/// The operands of one group, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shape {
    pub writes: usize,
    pub reads: usize,
    /// The number of plain numbers.
    pub plain: usize,
}

impl Shape {
    pub fn len(self) -> usize {
        self.writes + self.reads + self.plain
    }
}

impl Inst {
    /// Returns the number of pool words of one group.
    pub fn operands(&self) -> usize {
        usize::from(self.head) + self.groups as usize * self.op.shape().len()
    }
}

/// The format in memory of a scalar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Stored {
    F32,
    F16,
    /// 32-bit integers.
    B32,
    I16,
    U16,
    /// A byte of 0 or 1.
    Bool,
    /// 64-bit integers and doubles.
    B64,
}

impl Stored {
    pub const ALL: [Stored; 7] = [
        Stored::F32,
        Stored::F16,
        Stored::B32,
        Stored::I16,
        Stored::U16,
        Stored::Bool,
        Stored::B64,
    ];

    /// Returns the class of the registers that it is loaded to.
    pub fn class(self) -> Class {
        match self {
            Stored::F32 | Stored::F16 => Class::Real,
            Stored::B32 | Stored::I16 | Stored::U16 | Stored::Bool => Class::Word,
            Stored::B64 => Class::Wide,
        }
    }

    /// Returns the size in bytes.
    pub fn width(self) -> usize {
        match self {
            Stored::Bool => 1,
            Stored::F16 | Stored::I16 | Stored::U16 => 2,
            Stored::F32 | Stored::B32 => 4,
            Stored::B64 => 8,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum AtomicChange {
    Int(WordBinary),
    Exchange,
    CompareExchange,
}

/// The direction of a derivative within a quad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum DerivativeAxis {
    X,
    Y,
    // `fwidth`: the sum of the absolute values of both.
    Width,
}

/// The operation of an instruction. The index of a memory access, a table or an instruction is part
/// of the operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Op {
    Nop,
    RealUnary(RealUnary),
    RealBinary(RealBinary),
    RealTernary(RealTernary),
    FCmp(Cmp),
    FTest(Test),
    Ldexp,
    /// Sum of products of 1 to 4 components.
    Dot(u8),
    Length(u8),
    Distance(u8),
    Normalize(u8),
    Cross,
    WordUnary(WordUnary),
    WordBinary(WordBinary),
    CmpSint(Cmp),
    CmpUint(Cmp),
    ExtractSint,
    ExtractUint,
    Insert,
    D1(RealUnary),
    DNeg,
    DNot,
    WideBinary(WideBinary),
    D3(RealTernary),
    DCmp(Cmp),
    DCmpSint(Cmp),
    DCmpUint(Cmp),
    DTest(Test),
    DAbsSint,
    DSignSint,
    DDot(u8),
    Cast(Cast),
    /// Operands: condition, accept, reject.
    Select(Class),
    Move(Class),
    /// Copies the zeros that a variable holds before its first store.
    Undefined(Class),
    /// Copies the active lanes.
    Store(Class),
    /// Reads a buffer: `[to | byte offset, stored]`.
    Load(u32),
    /// Writes a buffer: `[from | byte offset, stored]`.
    StoreMemory(u32),
    /// Reads a variable at an index: `[to | its first register]`.
    Gather(Class, u32),
    /// Writes a variable at an index.
    Scatter(Class, u32),
    /// `[old, exchanged | value, compare | offset, stored]`
    Atomic(u32),
    /// The number of elements of a buffer's runtime-sized array.
    ArrayLength(u32),
    /// `[r, g, b, a | image, x, y]`
    Sample,
    /// A sample that an earlier one has taken already: it only counts.
    Sampled,
    Texel,
    /// `[width, height | image]`
    ImageSize,
    /// Fine derivatives; `DerivativeCoarse` is the coarse one.
    DerivativeFine(DerivativeAxis),
    DerivativeCoarse(DerivativeAxis),
    /// Reads the condition; the number is the instruction of its else or end.
    If(u32),
    Else(u32),
    EndIf(u32),
    Loop,
    /// Begins the continuing block, which the lanes that continued join; jumps if none is left.
    Continuing(u32),
    BreakIf,
    /// Jumps back if a lane is left.
    LoopBack(u32),
    /// Joins the lanes that left the loop; jumps if there is none.
    LoopEnd(u32),
    Switch,
    /// Reads the selector; the number is that of its table of values. The next instruction holds
    /// the jump target.
    Case(u32),
    /// Jumps if no lane takes the case.
    CaseSkip(u32),
    /// Lets the lanes wait for the end of the switch.
    CaseEnd,
    /// Joins the lanes that left the switch; jumps if there is none.
    SwitchEnd(u32),
    Break,
    Continue,
    Return,
    Kill,
    Barrier,
    Call(u32),
    /// Begins the code of a callee that stands in place of its call.
    Inlined(u32),
    End,
}

impl Op {
    pub fn shape(self) -> Shape {
        let (writes, reads, plain) = match self {
            Op::RealUnary(_)
            | Op::FTest(_)
            | Op::WordUnary(_)
            | Op::D1(_)
            | Op::DNeg
            | Op::DNot => (1, 1, 0),
            Op::DTest(_) | Op::DAbsSint | Op::DSignSint | Op::Cast(_) => (1, 1, 0),
            Op::Move(_) | Op::Undefined(_) | Op::Store(_) => (1, 1, 0),
            Op::DerivativeFine(_) | Op::DerivativeCoarse(_) => (1, 1, 0),
            Op::RealBinary(_) | Op::FCmp(_) | Op::Ldexp | Op::WordBinary(_) => (1, 2, 0),
            Op::CmpSint(_) | Op::CmpUint(_) | Op::WideBinary(_) => (1, 2, 0),
            Op::DCmp(_) | Op::DCmpSint(_) | Op::DCmpUint(_) => (1, 2, 0),
            Op::RealTernary(_) | Op::D3(_) | Op::ExtractSint | Op::ExtractUint | Op::Select(_) => {
                (1, 3, 0)
            }
            Op::Insert => (1, 4, 0),
            Op::Dot(n) | Op::Distance(n) | Op::DDot(n) => (1, 2 * usize::from(n), 0),
            Op::Length(n) => (1, usize::from(n), 0),
            Op::Normalize(n) => (usize::from(n), usize::from(n), 0),
            Op::Cross => (3, 6, 0),
            Op::Load(_) => (1, 0, 2),
            Op::StoreMemory(_) => (0, 1, 2),
            Op::Gather(..) => (1, 1, 0),
            Op::Scatter(..) => (0, 2, 0),
            Op::Atomic(_) => (2, 2, 2),
            Op::ArrayLength(_) => (1, 0, 0),
            Op::Sample | Op::Texel => (4, 3, 0),
            Op::ImageSize => (2, 1, 0),
            Op::Nop
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
            | Op::Sampled
            | Op::End => (0, 0, 0),
        };
        Shape { writes, reads, plain }
    }

    /// Returns the instruction it may jump to.
    pub fn target(&mut self) -> Option<&mut u32> {
        match self {
            Op::If(to)
            | Op::Else(to)
            | Op::EndIf(to)
            | Op::Continuing(to)
            | Op::LoopBack(to)
            | Op::LoopEnd(to)
            | Op::CaseSkip(to)
            | Op::SwitchEnd(to) => Some(to),
            _ => None,
        }
    }

    /// Returns whether it has no effect besides its result.
    pub fn is_pure(self) -> bool {
        let shape = self.shape();
        // A store leaves the other lanes as they are, and an atomic changes a buffer.
        shape.writes > 0 && !matches!(self, Op::Store(_) | Op::Atomic(_))
    }

    /// Returns whether all results are reals that were computed, not copied.
    pub fn computes_reals(self) -> bool {
        matches!(
            self,
            Op::RealUnary(_)
                | Op::RealBinary(_)
                | Op::RealTernary(_)
                | Op::Dot(_)
                | Op::Length(_)
                | Op::Distance(_)
                | Op::Normalize(_)
                | Op::Cross
                | Op::Ldexp
                | Op::Cast(Cast::RoundHalf)
                | Op::DerivativeFine(_)
                | Op::DerivativeCoarse(_)
        )
    }

    /// Returns whether all results are reals that are not copied.
    pub fn writes_reals(self) -> bool {
        let converts = match self {
            Op::Cast(cast) => cast.classes().1 == Class::Real,
            _ => matches!(self, Op::Sample | Op::Texel),
        };
        converts || self.computes_reals()
    }

    /// Returns whether all operands of an operation that computes reals are reals too.
    pub fn takes_reals(self) -> bool {
        // Its second operand is a word.
        self != Op::Ldexp
    }
}

/// An index computed at run time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dynamic {
    /// Stride in registers of each class; in bytes for a buffer.
    pub strides: [u32; 3],
    pub bound: ElementCount,
}

/// The number of elements.
#[derive(Clone, Copy, Debug)]
pub(super) enum ElementCount {
    Known(u32),
    /// As many as fit in the buffer: elements from `offset` on, `stride` bytes each.
    Runtime {
        offset: u32,
        stride: u32,
    },
}

/// An access by computed indices, which are the head registers of its instruction.
#[derive(Clone, Debug)]
pub(super) struct Access {
    /// The buffer; unused for variables.
    pub buffer: u32,
    pub dynamics: Vec<Dynamic>,
    /// The operation of an atomic.
    pub change: Option<AtomicChange>,
}

/// The values of one case of a switch.
#[derive(Clone, Debug)]
pub(super) struct Values {
    /// Lanes with one of these values take the case; for the default, lanes with none of them.
    pub bits: Vec<u32>,
    pub default: bool,
}

/// The origin of an instruction: the function, and the byte range of the text in naga's numbering.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin {
    pub function: u32,
    pub start: u32,
    pub end: u32,
}
