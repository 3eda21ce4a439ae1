//! Loads and stores: buffers by their bytes, variables by an index, images by the texel.
//!
//! An index past the end is clamped to the last element; bytes outside a buffer read as zero and
//! are not written (WGSL §2.2 leaves the choice).

use crate::backend::texel_index;

use super::super::code::{Access, AtomicChange, Class, Dynamic, ElementCount, LANES, Stored};
use super::super::lanes::{Lanes, lane_numbers};
use super::super::real::Real;
use super::integer::binary;
use super::kernel::{fill, map1, split};
use super::{Image, Machine, apart, column, column_mut};

/// Returns the number of elements that an index is limited to.
pub(crate) fn elements(bound: ElementCount, bytes: usize) -> u32 {
    match bound {
        ElementCount::Known(len) => len,
        ElementCount::Runtime { offset, stride } => {
            let room = bytes.saturating_sub(offset as usize);
            let stride = (stride as usize).max(1);
            u32::try_from(room / stride).unwrap_or(u32::MAX)
        }
    }
}

/// The colours of an image in all lanes where it was sampled last.
pub(super) struct SampledColours<L> {
    u: L,
    v: L,
    colors: [L; 4],
}

/// Returns whether all bits of two columns are equal.
fn same<L: Lanes<Item: Real>>(a: &L, b: &L) -> bool {
    a.each().zip(b.each()).fold(true, |same, (a, b)| same & a.same(b))
}

impl<'j, R: Real> Machine<'_, 'j, R> {
    /// Returns the offset that the indices of a lane add up to.
    pub(super) fn computed_offset(
        &self,
        access: &Access,
        head: &[u32],
        lane: usize,
        class: usize,
    ) -> usize {
        let bytes = self.buffers.get(access.buffer as usize).map_or(0, |b| b.bytes.len());
        let step = |(reg, dynamic): (&u32, &Dynamic)| {
            let index = column(&self.words, *reg)[lane];
            let last = elements(dynamic.bound, bytes).saturating_sub(1);
            index.min(last) as usize * dynamic.strides[class] as usize
        };
        head.iter().zip(&access.dynamics).map(step).sum()
    }

    /// Returns a lane that stands for all, if the active lanes agree in their indices.
    #[inline(always)]
    fn agreed(&self, head: &[u32]) -> Option<usize> {
        // Any lane if none is active.
        let first = (self.active.trailing_zeros() as usize).min(LANES - 1);
        let agree = head.iter().all(|&reg| {
            let column = column(&self.words, reg);
            let one = column[first];
            // Over all lanes at once, which is vectorised; where that fails, over those that are
            // active.
            column.iter().all(|&index| index == one)
                || (0..LANES).all(|lane| self.active >> lane & 1 == 0 || column[lane] == one)
        });
        agree.then_some(first)
    }

    #[inline(always)]
    pub(super) fn load(&mut self, access: u32, head: &[u32], operands: &[u32]) {
        let access = &self.program.accesses[access as usize];
        let buffer = access.buffer as usize;
        // One address for all lanes.
        if let Some(first) = self.agreed(head) {
            let way = self.computed_offset(access, head, first, 0);
            for group in operands.chunks_exact(3) {
                let stored = Stored::ALL[group[2] as usize];
                let at = group[1] as usize + way;
                let bits = match stored {
                    // The usual one without a call.
                    Stored::F32 => {
                        let bytes = self.buffers[buffer].bytes.get(at..at + 4);
                        let bytes = bytes.and_then(<[u8]>::first_chunk).copied();
                        u64::from(u32::from_le_bytes(bytes.unwrap_or_default()))
                    }
                    _ => self.fetch(buffer, at, stored),
                };
                match stored {
                    Stored::F32 | Stored::F16 => {
                        let value = R::narrow(f32::from_bits(bits as u32));
                        fill(column_mut(&mut self.reals, group[0]), value);
                    }
                    Stored::B32 | Stored::I16 | Stored::U16 | Stored::Bool => {
                        fill(column_mut(&mut self.words, group[0]), bits as u32);
                    }
                    Stored::B64 => fill(column_mut(&mut self.wides, group[0]), bits),
                }
                if self.watch.is_some() && self.active != 0 {
                    self.mark(buffer, at, stored);
                }
            }
            return;
        }
        // The same for all operands of the instruction.
        let mut ways = [0; LANES];
        for lane in lane_numbers(self.active) {
            ways[lane] = self.computed_offset(access, head, lane, 0);
        }
        for group in operands.chunks_exact(3) {
            let stored = Stored::ALL[group[2] as usize];
            for lane in lane_numbers(self.active) {
                let at = group[1] as usize + ways[lane];
                let bits = self.fetch(buffer, at, stored);
                self.put(group[0], stored, lane, bits);
                if self.watch.is_some() {
                    self.mark(buffer, at, stored);
                }
            }
        }
    }

    /// Returns the bits at a byte in the format of a register; zero past the end.
    fn fetch(&self, buffer: usize, at: usize, stored: Stored) -> u64 {
        let bytes = self.buffers[buffer].bytes.get(at..).unwrap_or_default();
        let bits = match stored.width() {
            1 => bytes.first().map(|byte| u64::from(*byte)),
            2 => bytes.first_chunk().map(|from| u64::from(u16::from_le_bytes(*from))),
            4 => bytes.first_chunk().map(|from| u64::from(u32::from_le_bytes(*from))),
            _ => bytes.first_chunk().map(|from| u64::from_le_bytes(*from)),
        };
        let bits = bits.unwrap_or(0);
        match stored {
            Stored::F32 | Stored::B32 | Stored::U16 | Stored::B64 => bits,
            Stored::F16 => u64::from(half::f16::from_bits(bits as u16).to_f32().to_bits()),
            Stored::I16 => u64::from(i32::from(bits as u16 as i16) as u32),
            Stored::Bool => u64::from(bits != 0),
        }
    }

    fn put(&mut self, reg: u32, stored: Stored, lane: usize, bits: u64) {
        match stored {
            Stored::F32 | Stored::F16 => {
                let value = R::narrow(f32::from_bits(bits as u32));
                column_mut(&mut self.reals, reg).put(lane, value);
            }
            Stored::B32 | Stored::I16 | Stored::U16 | Stored::Bool => {
                column_mut(&mut self.words, reg)[lane] = bits as u32;
            }
            Stored::B64 => column_mut(&mut self.wides, reg)[lane] = bits,
        }
    }

    /// Records that bytes were read.
    fn mark(&mut self, buffer: usize, at: usize, stored: Stored) {
        let read = &mut self.buffers[buffer].read;
        for byte in at..at + stored.width() {
            if let Some(word) = read.get_mut(byte / 64) {
                *word |= 1 << (byte % 64);
            }
        }
    }

    pub(super) fn save(&mut self, access: u32, head: &[u32], operands: &[u32]) {
        let access = &self.program.accesses[access as usize];
        // In the order of the lanes: of two that store to the same bytes the later wins. That is a
        // data race, whose outcome no shader may rely on.
        for lane in lane_numbers(self.active) {
            let way = self.computed_offset(access, head, lane, 0);
            for group in operands.chunks_exact(3) {
                let stored = Stored::ALL[group[2] as usize];
                let bits = match stored {
                    Stored::F32 => {
                        u64::from(column(&self.reals, group[0]).lane(lane).single().to_bits())
                    }
                    Stored::F16 => {
                        let single = column(&self.reals, group[0]).lane(lane).single();
                        u64::from(half::f16::from_f32(single).to_bits())
                    }
                    Stored::B32 | Stored::I16 | Stored::U16 | Stored::Bool => {
                        u64::from(column(&self.words, group[0])[lane])
                    }
                    Stored::B64 => column(&self.wides, group[0])[lane],
                };
                let at = group[1] as usize + way;
                self.write(access.buffer as usize, at, stored, bits);
            }
        }
    }

    fn write(&mut self, buffer: usize, at: usize, stored: Stored, bits: u64) {
        let bytes = self.buffers[buffer].bytes.to_mut();
        if let Some(to) = bytes.get_mut(at..at + stored.width()) {
            to.copy_from_slice(&bits.to_le_bytes()[..stored.width()]);
        }
    }

    pub(super) fn gather(&mut self, class: Class, access: u32, head: &[u32], operands: &[u32]) {
        let access = &self.program.accesses[access as usize];
        let agreed = self.agreed(head);
        macro_rules! from {
            ($file:ident) => {
                for group in operands.chunks_exact(2) {
                    let from = |m: &Self, lane: usize| {
                        group[1] + m.computed_offset(access, head, lane, class as usize) as u32
                    };
                    // All active lanes have the same indices: the column is copied as a whole.
                    if let Some(first) = agreed {
                        let from = from(self, first);
                        let (to, others) = apart(&mut self.$file, group[0]);
                        *to = *others.column(from);
                        continue;
                    }
                    for lane in lane_numbers(self.active) {
                        let value = column(&self.$file, from(self, lane)).lane(lane);
                        column_mut(&mut self.$file, group[0]).put(lane, value);
                    }
                }
            };
        }
        match class {
            Class::Real => from!(reals),
            Class::Word => from!(words),
            Class::Wide => from!(wides),
        }
    }

    pub(super) fn scatter(&mut self, class: Class, access: u32, head: &[u32], operands: &[u32]) {
        let access = &self.program.accesses[access as usize];
        // Each lane writes its own number of the register that its indices select.
        for lane in lane_numbers(self.active) {
            let way = self.computed_offset(access, head, lane, class as usize);
            macro_rules! into {
                ($file:ident) => {
                    for group in operands.chunks_exact(2) {
                        let value = column(&self.$file, group[0]).lane(lane);
                        let reg = group[1] as usize + way;
                        column_mut(&mut self.$file, reg as u32).put(lane, value);
                    }
                };
            }
            match class {
                Class::Real => into!(reals),
                Class::Word => into!(words),
                Class::Wide => into!(wides),
            }
        }
    }

    /// Runs an atomic, one lane after the other.
    pub(super) fn atomic(&mut self, access: u32, head: &[u32], operands: &[u32]) {
        let access = &self.program.accesses[access as usize];
        let [old, exchanged, value, compare, offset, _] = *operands else {
            unreachable!("an atomic has six operands");
        };
        let buffer = access.buffer as usize;
        // Atomics happen in some order: here in that of the lanes.
        for lane in lane_numbers(self.active) {
            let at = offset as usize + self.computed_offset(access, head, lane, 0);
            let before = self.fetch(buffer, at, Stored::B32) as u32;
            if self.watch.is_some() {
                self.mark(buffer, at, Stored::B32);
            }
            let value = column(&self.words, value)[lane];
            let same = column(&self.words, compare)[lane] == before;
            let after = match access.change {
                Some(AtomicChange::Int(f)) => binary(f, before, value),
                Some(AtomicChange::CompareExchange) if !same => before,
                Some(AtomicChange::Exchange | AtomicChange::CompareExchange) | None => value,
            };
            self.write(buffer, at, Stored::B32, u64::from(after));
            self.put(old, Stored::B32, lane, u64::from(before));
            self.put(exchanged, Stored::B32, lane, u64::from(same));
        }
    }

    pub(super) fn array_length(&mut self, access: u32, operands: &[u32]) {
        let access = &self.program.accesses[access as usize];
        let bytes = self.buffers[access.buffer as usize].bytes.len();
        let len = elements(access.dynamics[0].bound, bytes);
        *column_mut(&mut self.words, operands[0]) = [len; LANES];
    }

    /// Returns the image that an operand chooses in all lanes; `None` if they differ.
    #[inline(always)]
    fn image(&self, reg: u32) -> Option<Image<'j>> {
        let numbers = column(&self.words, reg);
        // All bits without a branch, which is vectorised.
        let one = numbers.iter().fold(0, |bits, number| bits | (number ^ numbers[0])) == 0;
        self.images.get(numbers[0] as usize).copied().filter(|_| one)
    }

    /// Writes the texels at some places, zeros outside; a lane without an image is left alone.
    #[inline(never)]
    fn colors(&mut self, to: &[u32], texel: impl Fn(&Self, usize) -> Option<[f32; 4]>) {
        let mut texels = [[0.0; 4]; LANES];
        let mut found = u64::MAX;
        for (lane, to) in texels.iter_mut().enumerate() {
            match texel(self, lane) {
                Some(texel) => *to = texel,
                None => found &= !(1 << lane),
            }
        }
        for (i, reg) in to.iter().enumerate() {
            let column = column_mut(&mut self.reals, *reg);
            for (lane, texel) in texels.iter().enumerate() {
                if found >> lane & 1 == 1 {
                    column.put(lane, R::narrow(texel[i]));
                }
            }
        }
    }

    #[inline(always)]
    pub(super) fn sample(&mut self, operands: &[u32]) {
        let wrap = |x: R, size: u32| texel_index(x.double(), size);
        let (to, from) = operands.split_at(4);
        let at = |image: Image, u: u32, v: u32| v as usize * image.width as usize + u as usize;
        let of = |image: Image<'j>, at: usize| image.texels.get(at).copied().unwrap_or_default();
        let Some(image) = self.image(from[0]) else {
            return self.colors(to, |m, lane| {
                let image = *m.images.get(column(&m.words, from[0])[lane] as usize)?;
                let [u, v] = [1, 2].map(|i| column(&m.reals, from[i]).lane(lane));
                Some(of(image, at(image, wrap(u, image.width), wrap(v, image.height))))
            });
        };
        // A function may sample one texture at one place whenever it is called.
        let number = column(&self.words, from[0])[0] as usize;
        let (u, v) = (column(&self.reals, from[1]), column(&self.reals, from[2]));
        let known = match &mut self.samples[number] {
            Some(known) if same(&known.u, u) & same(&known.v, v) => known,
            others => {
                let known = others.get_or_insert_with(|| {
                    Box::new(SampledColours { u: *u, v: *v, colors: [*u; 4] })
                });
                (known.u, known.v) = (*u, *v);
                let (mut x, mut y) = ([0; LANES], [0; LANES]);
                map1(&mut x, u, |u| wrap(u, image.width));
                map1(&mut y, v, |v| wrap(v, image.height));
                let mut texels = [[0.0; 4]; LANES];
                for lane in 0..LANES {
                    texels[lane] = of(image, at(image, x[lane], y[lane]));
                }
                split::<R>(&mut known.colors, &texels);
                known
            }
        };
        for (channel, reg) in to.iter().enumerate() {
            *column_mut(&mut self.reals, *reg) = known.colors[channel];
        }
    }

    #[inline(always)]
    pub(super) fn texel(&mut self, operands: &[u32]) {
        let (to, from) = operands.split_at(4);
        let (x, y) = (column(&self.words, from[1]), column(&self.words, from[2]));
        // Zeros outside: one of the results that WGSL §17.7.4 permits.
        let of = |image: Image<'j>, x: u32, y: u32| {
            let inside = x < image.width && y < image.height;
            let at = y as usize * image.width as usize + x as usize;
            image.texels.get(at).filter(|_| inside).copied().unwrap_or_default()
        };
        let Some(image) = self.image(from[0]) else {
            return self.colors(to, |m, lane| {
                let [number, x, y] = [0, 1, 2].map(|i| column(&m.words, from[i])[lane]);
                Some(of(*m.images.get(number as usize)?, x, y))
            });
        };
        let mut texels = [[0.0; 4]; LANES];
        for lane in 0..LANES {
            texels[lane] = of(image, x[lane], y[lane]);
        }
        for (channel, reg) in to.iter().enumerate() {
            column_mut(&mut self.reals, *reg).set(|lane| R::narrow(texels[lane][channel]));
        }
    }

    pub(super) fn image_size(&mut self, operands: &[u32]) {
        for lane in 0..LANES {
            let number = column(&self.words, operands[2])[lane] as usize;
            let size = self.images.get(number).map_or([0; 2], |i| [i.width, i.height]);
            for (reg, size) in operands[..2].iter().zip(size) {
                self.put(*reg, Stored::B32, lane, u64::from(size));
            }
        }
    }
}
