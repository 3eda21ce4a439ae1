//! The parts of a [`Program`] under construction: constants, registers, instructions.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::rc::Rc;

use naga::valid::ModuleInfo;
use naga::{Handle, TypeInner};
use rustc_hash::FxHashMap;

use super::super::body::{Body, Compiled};
use super::super::code::{Access, Class, Inst, LANES, Op, Origin, Reg, Values, WriteRegion};
use super::super::counts::instruction_cost;
use super::super::flatten::{Types, class};
use super::super::interface::interface;
use super::super::optimize;
use super::super::program::{BufferInfo, Floats, FunctionCode, ImageInfo, Program};
use super::nowhere;
pub use landfall_ir::module::Locals;
use landfall_layout::source::Language;

pub(super) struct Builder<'a> {
    pub ir: &'a naga::Module,
    pub info: &'a ModuleInfo,
    pub types: Types<'a>,
    pub overrides: &'a [Option<f64>],
    pub locals: Locals,
    pub floats: Floats,
    /// With [`Floats::Mediump`]: the spans of the expressions that are rounded.
    pub reduced: &'a BTreeSet<(u32, u32)>,
    /// Whether the current expression is rounded to `f16`.
    pub rounds: bool,
    pub buffers: Vec<BufferInfo>,
    pub images: Vec<ImageInfo>,
    pub accesses: Vec<Access>,
    pub values: Vec<Values>,
    /// By class and bits: equal constants share a register.
    known: FxHashMap<(u32, u64), Reg>,
    /// Constants in a row for an index, by the registers they are copies of.
    tables: FxHashMap<Vec<Reg>, Vec<Reg>>,
    constants: [Vec<u64>; 3],
    variables: [u32; 3],
    /// Temporaries of all functions so far.
    temporaries: [u32; 3],
    /// The operands of each function so far.
    lengths: Vec<usize>,
    /// The operands that may still be inlined.
    room: usize,
    /// The current function.
    pub body: Body,
    /// The functions before it.
    code: Vec<Inst>,
    origins: Vec<Origin>,
    pool: Vec<u32>,
}

/// Maximum number of registers of a program: half a million take 128 MB of `f32` per thread.
const MAX_REGISTERS: u32 = 1 << 19;
/// Maximum number of operands of a program.
const MAX_OPERANDS: usize = 1 << 24;
/// Maximum number of operands of a function that is inlined, and of all that are in a program.
const LONGEST_INLINED: usize = 2_000;
// Without the second bound, functions that each call the next one twice would double the code with
// each link of the chain.
const MAX_INLINED: usize = 1 << 17;

impl<'a> Builder<'a> {
    pub fn new(
        ir: &'a naga::Module,
        info: &'a ModuleInfo,
        pending: &'a dyn Fn(Handle<naga::Override>) -> Option<u32>,
        overrides: &'a [Option<f64>],
        floats: Floats,
        reduced: &'a BTreeSet<(u32, u32)>,
    ) -> Builder<'a> {
        Builder {
            ir,
            info,
            types: Types {
                arena: &ir.types,
                pending,
                counted: RefCell::default(),
                before: RefCell::default(),
            },
            overrides,
            locals: Locals::Zeros,
            floats,
            reduced,
            rounds: false,
            buffers: Vec::new(),
            images: Vec::new(),
            accesses: Vec::new(),
            values: Vec::new(),
            known: FxHashMap::default(),
            tables: FxHashMap::default(),
            constants: Default::default(),
            variables: [0; 3],
            temporaries: [0; 3],
            lengths: Vec::new(),
            room: MAX_INLINED,
            body: Body::default(),
            code: Vec::new(),
            origins: Vec::new(),
            pool: Vec::new(),
        }
    }

    /// Returns the register of a constant; of a real, `bits` are those of its `f32`.
    pub fn constant(&mut self, class: Class, bits: u64) -> Reg {
        let list = &mut self.constants[class as usize];
        *self.known.entry((class as u32, bits)).or_insert_with(|| {
            list.push(bits);
            Reg::new(class, WriteRegion::Constant, list.len() as u32 - 1)
        })
    }

    pub fn word(&mut self, value: u32) -> Reg {
        self.constant(Class::Word, u64::from(value))
    }

    pub fn real(&mut self, value: f32) -> Reg {
        self.constant(Class::Real, u64::from(value.to_bits()))
    }

    /// Returns the value of a constant register.
    pub fn known(&self, reg: Reg) -> Option<u64> {
        (reg.region() == WriteRegion::Constant)
            .then(|| self.constants[reg.class() as usize][reg.number() as usize])
    }

    /// Returns registers of constants in a row, for an index.
    pub fn table(&mut self, regs: &[Reg]) -> Vec<Reg> {
        if let Some(found) = self.tables.get(regs) {
            return found.clone();
        }
        let table: Vec<Reg> = regs
            .iter()
            .map(|&reg| {
                let bits = self.known(reg).expect("only constants are asked for");
                let list = &mut self.constants[reg.class() as usize];
                list.push(bits);
                Reg::new(reg.class(), WriteRegion::Constant, list.len() as u32 - 1)
            })
            .collect();
        self.tables.insert(regs.to_vec(), table.clone());
        table
    }

    pub fn temporary(&mut self, class: Class) -> Reg {
        let next = &mut self.body.temporaries[class as usize];
        *next += 1;
        // `finish` refuses the function; until then numbers are given again, as a larger one does
        // not fit a `Reg`.
        if *next >= Reg::LIMIT {
            self.body.overflow = true;
            *next = 1;
        }
        Reg::new(class, WriteRegion::Temporary, *next - 1)
    }

    pub fn temporaries(&mut self, class: Class, count: usize) -> Vec<Reg> {
        (0..count).map(|_| self.temporary(class)).collect()
    }

    /// Allocates registers for a variable, those of each class in a row.
    pub fn variable(&mut self, inner: &TypeInner) -> Result<Rc<[Reg]>, String> {
        let leaves = self.types.leaves(inner)?;
        let classes: Result<Vec<Class>, String> = leaves.iter().map(|l| class(l.scalar)).collect();
        self.variables_of(&classes?)
    }

    pub fn variables_of(&mut self, classes: &[Class]) -> Result<Rc<[Reg]>, String> {
        let sum: u32 = self.variables.iter().sum();
        if sum + classes.len() as u32 > MAX_REGISTERS {
            return Err(format!("variables of more than {MAX_REGISTERS} scalars"));
        }
        Ok(classes
            .iter()
            .map(|&class| {
                let next = &mut self.variables[class as usize];
                *next += 1;
                Reg::new(class, WriteRegion::Variable, *next - 1)
            })
            .collect())
    }

    pub fn access(&mut self, access: Access) -> u32 {
        self.accesses.push(access);
        self.accesses.len() as u32 - 1
    }

    /// Appends an instruction and returns its index.
    pub fn push(&mut self, op: Op, head: &[Reg], operands: &[u32]) -> u32 {
        let len = op.shape().len();
        let groups = operands.len().checked_div(len).unwrap_or(0);
        debug_assert_eq!(groups * len, operands.len());
        let body = &mut self.body;
        // As above: `finish` refuses the function.
        if body.pool.len() + operands.len() > MAX_OPERANDS {
            body.overflow = true;
            return 0;
        }
        let at = body.pool.len() as u32;
        body.pool.extend(head.iter().map(|reg| reg.0));
        body.pool.extend_from_slice(operands);
        body.code.push(Inst {
            op,
            head: head.len() as u8,
            once: false,
            fused: false,
            groups: groups as u32,
            at,
        });
        body.origins.push(body.origin.unwrap_or(nowhere(0)));
        body.code.len() as u32 - 1
    }

    /// Returns the index of the next instruction.
    pub fn next_index(&self) -> u32 {
        self.body.code.len() as u32
    }

    /// Sets the target of a jump to the next instruction.
    pub fn patch_jump(&mut self, jump: u32) {
        let here = self.next_index();
        if let Some(target) = self.body.code.get_mut(jump as usize).and_then(|i| i.op.target()) {
            *target = here;
        }
    }

    /// Whether a function is short enough to be inlined once more.
    pub fn has_room_for(&self, function: usize) -> bool {
        self.lengths[function] <= LONGEST_INLINED.min(self.room)
    }

    /// Takes the room of a function that has it.
    pub fn take_room_for(&mut self, function: usize) {
        self.room -= self.lengths[function];
    }

    pub fn begin(&mut self, function: u32) {
        self.body = Body { origin: Some(nowhere(function)), ..Body::default() };
    }

    /// Optimises the current function and appends it to the others.
    pub fn finish(
        &mut self,
        name: String,
        entry: Option<&naga::EntryPoint>,
        compiled: Result<Compiled, String>,
    ) -> FunctionCode {
        let mut body = std::mem::take(&mut self.body);
        // A failed function has a length too, as they are found by number; and it is that before
        // the optimisation, as an inlined copy is compiled from naga's IR again.
        self.lengths.push(body.pool.len());
        let compiled = compiled.and_then(|compiled| {
            optimize::optimize(&mut body, &self.accesses, &self.buffers, &compiled);
            let sum: u32 = (0..3).map(|i| self.temporaries[i] + body.temporaries[i]).sum();
            if body.overflow || sum > MAX_REGISTERS {
                return Err(format!("values of more than {MAX_REGISTERS} scalars"));
            }
            Ok(compiled)
        });
        let mut function = FunctionCode {
            name,
            state: Err(String::new()),
            arguments: Vec::new(),
            result: Vec::new(),
            result_type: None,
            interface: None,
        };
        match compiled {
            Err(why) => function.state = Err(why),
            Ok(compiled) => {
                let start = self.append(body);
                let interface = entry
                    .map(|entry| interface(self.ir, &self.types, entry, &compiled))
                    .transpose();
                function.state = interface.map(|interface| {
                    function.interface = interface;
                    start
                });
                function.arguments = compiled.arguments;
                function.result = compiled.result.to_vec();
                function.result_type = compiled.result_type;
            }
        }
        function
    }

    fn append(&mut self, body: Body) -> u32 {
        let start = self.code.len() as u32;
        let pool = self.pool.len() as u32;
        // Every function has temporaries of its own: a caller's must survive its calls.
        let before = self.temporaries;
        for mut inst in body.code {
            let operands = inst.operands();
            let from = inst.at as usize;
            inst.at += pool;
            if let Some(target) = inst.op.target() {
                *target += start;
            }
            // Only what is left is copied: where the optimiser removed groups, the body's pool has
            // gaps.
            self.pool.extend_from_slice(&body.pool[from..from + operands]);
            inst.at = (self.pool.len() - operands) as u32;
            let at = inst.at as usize;
            optimize::registers(&inst, |place, _| {
                let reg = Reg(self.pool[at + place]);
                if reg.region() == WriteRegion::Temporary {
                    self.pool[at + place] += before[reg.class() as usize];
                }
            });
            self.code.push(inst);
        }
        self.origins.extend(body.origins);
        for (sum, n) in self.temporaries.iter_mut().zip(body.temporaries) {
            *sum += n;
        }
        start
    }

    /// Assigns every register its place in the file of its class.
    pub fn link(
        mut self,
        mut functions: Vec<FunctionCode>,
        mut start: Result<FunctionCode, String>,
    ) -> Program {
        // A file holds the constants, then the variables, then the temporaries of all functions.
        let constants = [0, 1, 2].map(|class| self.constants[class].len() as u32);
        let variables = self.variables;
        let place = |reg: Reg| {
            let class = reg.class() as usize;
            match reg.region() {
                WriteRegion::Constant => reg.number(),
                WriteRegion::Variable => constants[class] + reg.number(),
                WriteRegion::Temporary => constants[class] + variables[class] + reg.number(),
            }
        };
        for inst in &self.code {
            let at = inst.at as usize;
            optimize::registers(inst, |operand, _| {
                let word = &mut self.pool[at + operand];
                *word = place(Reg(*word));
            });
        }
        // The registers that the API fills and reads keep their class.
        let packed = |reg: &mut Reg| {
            *reg = Reg::new(reg.class(), WriteRegion::Variable, place(*reg));
        };
        for function in functions.iter_mut().chain(start.as_mut().ok()) {
            function.arguments.iter_mut().flat_map(|a| a.regs.iter_mut()).for_each(packed);
            function.result.iter_mut().for_each(packed);
            if let Some(interface) = &mut function.interface {
                interface.regs_mut().for_each(packed);
            }
        }
        let registers =
            [0, 1, 2].map(|class| constants[class] + variables[class] + self.temporaries[class]);
        debug_assert_eq!(LANES, 64);
        let starts = functions.iter().map(|f| *f.state.as_ref().unwrap_or(&0)).collect();
        Program {
            costs: self.code.iter().map(instruction_cost).collect(),
            starts,
            code: self.code,
            origins: self.origins,
            pool: self.pool,
            accesses: self.accesses,
            values: self.values,
            constants: self.constants,
            registers,
            buffers: self.buffers,
            images: self.images,
            functions,
            start,
            files: Default::default(),
            bases: Vec::new(),
            language: Language::Wgsl,
        }
    }
}
