//! How fast bytes are set by name, as ratios in one run:
//! `cargo bench --features full --bench buffer`.
//!
//! The block is the light array of 128 point lights, whose 769 names an engine formats and looks
//! up.

use std::collections::HashMap;
use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

use landfall_layout::{Buffer, Options, Source, layout};
use measure::{Contest, Ratios, contest};

mod measure;

const LIGHTS: &str = include_str!("lights.frag");

/// What `landfall emit` makes of `lights.frag`; a test holds it to that.
mod gpu {
    include!("lights.rs");
}

const SIZE: usize = 6160;
const ROUNDS: usize = 1001;

fn main() {
    let block = layout(&Source::new("lights.frag", LIGHTS), &Options::default()).blocks.remove(0);
    let mut buffer = Buffer::new(&block).expect("the block has a fixed size");
    let fourth = buffer.handle::<[f32; 3]>("data[3].color").expect("a vec3");
    let handle = buffer.handle::<[f32; 3]>("data[].color").expect("a vec3");
    let values: Vec<[f32; 3]> = (0..128).map(|i| [i as f32, 1.0, 0.5]).collect();
    let paths: Vec<String> = (0..128).map(|i| format!("data[{i}].color")).collect();
    // 128 lights in an order that is not theirs, so that no side learns it.
    let order: Vec<usize> = (0..128).map(|i| i * 37 % 128).collect();
    let names = names();
    let map: HashMap<String, (usize, usize)> =
        names.iter().map(|(name, offset, size)| (name.clone(), (*offset, *size))).collect();
    let mut plain = vec![0u8; SIZE];
    let mirrors = vec![[1f32; 12]; 128];

    println!("{} names, {} rounds; ns for one call", names.len(), ROUNDS);
    println!("{:<58} {:>8} {:>8} {:>7} (8 of 10 pairs)", "", "ours", "theirs", "ratio");

    let mut constant = |plain: &mut Vec<u8>| {
        for value in &values {
            put(&mut black_box(&mut *plain)[160..172], black_box(value));
        }
    };
    let mut by_handle = |buffer: &mut Buffer| {
        for value in &values {
            black_box(&mut *buffer).set_at(&fourth, [], *black_box(value)).expect("in range");
        }
    };
    let (b, p) = (&mut buffer, &mut plain);
    slower("data[3].color by handle : store at 160", 128, b, p, &mut by_handle, &mut constant);

    let mut indexed = |plain: &mut Vec<u8>| {
        for (&i, value) in order.iter().zip(&values) {
            let at = 48 * i + 16;
            put(&mut black_box(&mut *plain)[at..at + 12], black_box(value));
        }
    };
    let mut by_handle = |buffer: &mut Buffer| {
        for (&i, value) in order.iter().zip(&values) {
            black_box(&mut *buffer).set_at(&handle, [i], *black_box(value)).expect("in range");
        }
    };
    slower("data[i].color by handle : store at 48 i + 16", 128, b, p, &mut by_handle, &mut indexed);
    slower("data[i].color by handle : store at 160", 128, b, p, &mut by_handle, &mut constant);

    let mut by_handle = |buffer: &mut Buffer| {
        for (&i, value) in order.iter().zip(&values) {
            black_box(&mut *buffer).set_at(&handle, [i], *black_box(value)).expect("in range");
        }
        buffer.clear_dirty();
    };
    slower("all data[i].color, then clear : same", 128, b, p, &mut by_handle, &mut indexed);

    let mut formatted = |buffer: &mut Buffer| {
        for &i in &order {
            let path = black_box(paths[i].as_str());
            black_box(&mut *buffer).set(path, values[i]).expect("in range");
        }
    };
    let mut literal = |buffer: &mut Buffer| {
        for value in &values {
            let path = black_box("data[3].color");
            black_box(&mut *buffer).set(path, *black_box(value)).expect("in range");
        }
    };
    let mut on_stack = |buffer: &mut Buffer| {
        for &i in &order {
            let mut path = Stack { bytes: [0; 32], len: 0 };
            write!(path, "data[{}].color", black_box(i)).expect("it fits");
            black_box(&mut *buffer).set(path.text(), values[i]).expect("in range");
        }
    };
    let mut scan = |plain: &mut Vec<u8>| {
        for &i in &order {
            let name = format!("data[{}].color", black_box(i));
            let found = black_box(&names).iter().find(|row| row.0 == name).expect("a name");
            let at = black_box(&mut *plain);
            put(&mut at[found.1..found.1 + found.2], &values[i]);
        }
    };
    let mut hash = |plain: &mut Vec<u8>| {
        for &i in &order {
            let name = format!("data[{}].color", black_box(i));
            let (offset, size) = black_box(&map)[&name];
            let at = black_box(&mut *plain);
            put(&mut at[offset..offset + size], &values[i]);
        }
    };
    let (b, p) = (&mut buffer, &mut plain);
    faster("format and scan a Vec : path at hand", 128, b, p, &mut formatted, &mut scan);
    faster("format and scan a Vec : path literal", 128, b, p, &mut literal, &mut scan);
    faster(
        "format and scan a Vec : path formatted on the stack",
        128,
        b,
        p,
        &mut on_stack,
        &mut scan,
    );
    faster("format and HashMap : path at hand", 128, b, p, &mut formatted, &mut hash);
    faster("format and HashMap : path literal", 128, b, p, &mut literal, &mut hash);
    faster("format and HashMap : path formatted on the stack", 128, b, p, &mut on_stack, &mut hash);

    let mut slice = |buffer: &mut Buffer| {
        let mirrors = black_box(&mirrors[..]);
        black_box(&mut *buffer).write_slice("data", mirrors).expect("in range");
    };
    let mut memcpy = |plain: &mut Vec<u8>| {
        let from: &[u8] = bytemuck::cast_slice(black_box(&mirrors[..]));
        let at = black_box(&mut *plain);
        at[..6144].copy_from_slice(from);
    };
    slower("128 mirrors at once : memcpy", 1, &mut buffer, &mut plain, &mut slice, &mut memcpy);

    let lights: Vec<gpu::PointLight> = bytemuck::cast_slice(&mirrors).to_vec();
    let mut block: Box<gpu::PointLightBlock> = Box::default();
    let mut copied = |_: &mut Buffer| {
        black_box(&mut *block).data.copy_from_slice(black_box(&lights[..]));
    };
    slower(
        "128 lights copied to a mirror : memcpy",
        1,
        &mut buffer,
        &mut plain,
        &mut copied,
        &mut memcpy,
    );
    let mut assigned = |_: &mut Buffer| {
        let block = black_box(&mut *block);
        for (to, from) in block.data.iter_mut().zip(black_box(&lights[..])) {
            *to = *from;
        }
    };
    slower(
        "128 lights one by one to a mirror : memcpy",
        1,
        &mut buffer,
        &mut plain,
        &mut assigned,
        &mut memcpy,
    );
    let mut built = |_: &mut Buffer| {
        let block = black_box(&mut *block);
        for (to, l) in block.data.iter_mut().zip(black_box(&lights[..])) {
            *to = gpu::PointLight::new(gpu::PointLightInit {
                pos: l.pos,
                color: l.color,
                intensity: l.intensity,
                constant: l.constant,
                linear: l.linear,
                quadratic: l.quadratic,
            });
        }
    };
    slower(
        "128 lights built with new : memcpy",
        1,
        &mut buffer,
        &mut plain,
        &mut built,
        &mut memcpy,
    );
    // Limits of the row above: members without padding, and the fewest stores of plain integers.
    let mut stored = |_: &mut Buffer| {
        let block = black_box(&mut *block);
        for (to, l) in block.data.iter_mut().zip(black_box(&lights[..])) {
            to.pos = l.pos;
            to.color = l.color;
            to.intensity = l.intensity;
            to.constant = l.constant;
            to.linear = l.linear;
            to.quadratic = l.quadratic;
        }
    };
    slower(
        "128 lights stored by member, padding left : memcpy",
        1,
        &mut buffer,
        &mut plain,
        &mut stored,
        &mut memcpy,
    );
    let mut words = |_: &mut Buffer| {
        let block = black_box(&mut *block);
        for (to, l) in block.data.iter_mut().zip(black_box(&lights[..])) {
            *to = in_words(l);
        }
    };
    slower(
        "128 lights stored in words of 8 bytes : memcpy",
        1,
        &mut buffer,
        &mut plain,
        &mut words,
        &mut memcpy,
    );

    buffer.clear_dirty();
    buffer.set("data[3].pos", [1f32; 3]).expect("a vec3");
    println!("\none moved light: {:?}", buffer.dirty(64).collect::<Vec<_>>());
    let start = Instant::now();
    for _ in 0..10_000 {
        black_box(black_box(&buffer).upload(64));
    }
    println!("finding it: {:.0} ns", start.elapsed().as_nanos() as f64 / 10_000.0);
}

/// A light made of six words, padding included.
fn in_words(l: &gpu::PointLight) -> gpu::PointLight {
    let both = |a: f32, b: f32| u64::from(a.to_bits()) | u64::from(b.to_bits()) << 32;
    bytemuck::cast([
        both(l.pos[0], l.pos[1]),
        both(l.pos[2], 0.0),
        both(l.color[0], l.color[1]),
        both(l.color[2], l.intensity),
        both(l.constant, l.linear),
        both(l.quadratic, 0.0),
    ])
}

/// The table of the engine: every element's name, offset and size.
fn names() -> Vec<(String, usize, usize)> {
    let members = [
        ("pos", 0, 12),
        ("color", 16, 12),
        ("intensity", 28, 4),
        ("constant", 32, 4),
        ("linear", 36, 4),
        ("quadratic", 40, 4),
    ];
    let mut names: Vec<_> = (0..128)
        .flat_map(|i| {
            members.map(|(name, at, size)| (format!("data[{i}].{name}"), 48 * i + at, size))
        })
        .collect();
    names.push(("actually_used_count".to_string(), 6144, 4));
    names
}

#[inline]
fn put(at: &mut [u8], value: &[f32; 3]) {
    at.copy_from_slice(bytemuck::bytes_of(value));
}

/// A path formatted without allocation.
struct Stack {
    bytes: [u8; 32],
    len: usize,
}

impl Stack {
    fn text(&self) -> &str {
        std::str::from_utf8(&self.bytes[..self.len]).expect("only text was written")
    }
}

impl Write for Stack {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        let to = self.bytes.get_mut(self.len..self.len + text.len()).ok_or(std::fmt::Error)?;
        to.copy_from_slice(text.as_bytes());
        self.len += text.len();
        Ok(())
    }
}

type Ours<'a> = &'a mut dyn FnMut(&mut Buffer);
type Theirs<'a> = &'a mut dyn FnMut(&mut Vec<u8>);

/// Ours over theirs: how many times slower ours is.
fn slower(
    name: &str,
    calls: usize,
    b: &mut Buffer,
    p: &mut Vec<u8>,
    ours: Ours<'_>,
    theirs: Theirs<'_>,
) {
    let Contest { first, second, ratios } = contest(ROUNDS, || theirs(p), || ours(b));
    row(name, calls, [second, first], &ratios);
}

/// Theirs over ours: how many times faster ours is.
fn faster(
    name: &str,
    calls: usize,
    b: &mut Buffer,
    p: &mut Vec<u8>,
    ours: Ours<'_>,
    theirs: Theirs<'_>,
) {
    let Contest { first, second, ratios } = contest(ROUNDS, || ours(b), || theirs(p));
    row(name, calls, [first, second], &ratios);
}

fn row(name: &str, calls: usize, seconds: [f64; 2], ratios: &Ratios) {
    let [ours, theirs] = seconds.map(|seconds| 1e9 * seconds / calls as f64);
    println!("{name:<58} {ours:>8.2} {theirs:>8.2} {ratios}");
}
