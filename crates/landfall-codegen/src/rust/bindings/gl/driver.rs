use core::ffi::{c_char, c_void};

/// A block as the constants have it.
pub struct Block {
    pub name: &'static str,
    /// What names of its members begin with: its own name, if it has an instance.
    pub prefix: &'static str,
    pub is_storage: bool,
    /// Whether the driver may leave out members.
    pub is_packed: bool,
    /// The end of the last member, and the bytes of a buffer.
    pub sizes: (i64, i64),
    pub members: &'static [Member],
}

/// A scalar, vector or matrix, or an array of these.
pub struct Member {
    /// `lights[].color`
    pub path: &'static str,
    /// OpenGL's number of the type, 0 where it has none, and its name.
    pub ty: (u32, &'static str),
    pub offset: i64,
    /// Elements, 0 if runtime-sized, and stride of each array, outermost first.
    pub arrays: &'static [(i64, i64)],
    /// Stride of a matrix, and whether it is row-major.
    pub matrix: Option<(i64, bool)>,
}

/// Returns an entry point of OpenGL.
///
/// # Safety
/// `F` is the type of the function with that name.
unsafe fn function<F: Copy>(
    load: &mut dyn FnMut(&str) -> *const c_void,
    name: &str,
) -> Result<F, String> {
    let at = load(name);
    if at.is_null() {
        return Err(format!("the driver has no {name}"));
    }
    // SAFETY: a pointer to a function of that type.
    Ok(unsafe { core::mem::transmute_copy(&at) })
}

/// A member as the driver reports it.
struct Reported {
    name: String,
    /// Type, elements, offset, array stride, matrix stride, whether it is row-major; elements and
    /// stride of the outermost array, where the driver reports one element of it.
    numbers: [i32; 8],
}

/// A block as the driver reports it.
struct ReportedBlock {
    name: String,
    size: i32,
    members: Vec<Reported>,
}

type Parameters = unsafe extern "system" fn(u32, u32, *mut i32);
type BlockParameters = unsafe extern "system" fn(u32, u32, u32, *mut i32);
type BlockName = unsafe extern "system" fn(u32, u32, i32, *mut i32, *mut c_char);
type UniformParameters = unsafe extern "system" fn(u32, i32, *const u32, u32, *mut i32);
type UniformName =
    unsafe extern "system" fn(u32, u32, i32, *mut i32, *mut i32, *mut u32, *mut c_char);
type ResourceParameters =
    unsafe extern "system" fn(u32, u32, u32, i32, *const u32, i32, *mut i32, *mut i32);
type ResourceName =
    unsafe extern "system" fn(u32, u32, u32, i32, *mut i32, *mut c_char);

/// Bytes of the longest name that is read.
const NAME: usize = 1 << 14;

/// Reads a name that a function writes.
fn name_of(read: impl FnOnce(&mut i32, *mut c_char)) -> String {
    let (mut length, mut bytes) = (0, vec![0u8; NAME]);
    read(&mut length, bytes.as_mut_ptr().cast());
    bytes.truncate(usize::try_from(length).unwrap_or(0));
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The uniform blocks that the driver reports.
///
/// # Safety
/// `load` returns the functions of the context that is current.
unsafe fn uniform_blocks(
    program: u32,
    load: &mut dyn FnMut(&str) -> *const c_void,
) -> Result<Vec<ReportedBlock>, String> {
    // SAFETY: the types are those of OpenGL 3.1, and every array is as long as is said.
    unsafe {
        let of_program: Parameters = function(load, "glGetProgramiv")?;
        let of_block: BlockParameters = function(load, "glGetActiveUniformBlockiv")?;
        let block_name: BlockName = function(load, "glGetActiveUniformBlockName")?;
        let of_uniforms: UniformParameters = function(load, "glGetActiveUniformsiv")?;
        let uniform_name: UniformName = function(load, "glGetActiveUniform")?;
        let length = NAME as i32;
        let mut count = 0;
        of_program(program, 0x8A36, &mut count);
        let mut blocks = Vec::new();
        for block in 0..u32::try_from(count).unwrap_or(0) {
            let name = name_of(|n, text| block_name(program, block, length, n, text));
            let (mut size, mut active) = (0, 0);
            of_block(program, block, 0x8A40, &mut size);
            of_block(program, block, 0x8A42, &mut active);
            let mut indices = vec![0u32; usize::try_from(active).unwrap_or(0)];
            of_block(program, block, 0x8A43, indices.as_mut_ptr().cast());
            let mut members = Vec::new();
            for index in indices {
                let mut numbers = [0; 8];
                let asked = [0x8A37, 0x8A38, 0x8A3B, 0x8A3C, 0x8A3D, 0x8A3E];
                for (number, asked) in numbers.iter_mut().zip(asked) {
                    of_uniforms(program, 1, &index, asked, number);
                }
                let name = name_of(|n, text| {
                    let (mut elements, mut ty) = (0, 0);
                    uniform_name(
                        program,
                        index,
                        length,
                        n,
                        &mut elements,
                        &mut ty,
                        text,
                    );
                });
                members.push(Reported { name, numbers });
            }
            blocks.push(ReportedBlock {
                name,
                size,
                members,
            });
        }
        Ok(blocks)
    }
}

/// The storage blocks that the driver reports.
///
/// # Safety
/// `load` returns the functions of the context that is current.
unsafe fn storage_blocks(
    program: u32,
    load: &mut dyn FnMut(&str) -> *const c_void,
) -> Result<Vec<ReportedBlock>, String> {
    const BLOCKS: u32 = 0x92E6;
    const VARIABLES: u32 = 0x92E5;
    // SAFETY: the types are those of OpenGL 4.3, and every array is as long as is said.
    unsafe {
        let of_interface: BlockParameters = function(load, "glGetProgramInterfaceiv")?;
        let of_resource: ResourceParameters = function(load, "glGetProgramResourceiv")?;
        let resource_name: ResourceName = function(load, "glGetProgramResourceName")?;
        let name = |interface, index| {
            let length = NAME as i32;
            name_of(|n, text| resource_name(program, interface, index, length, n, text))
        };
        let read = |interface, index, asked: &[u32], numbers: &mut [i32]| {
            let (n, most) = (asked.len() as i32, numbers.len() as i32);
            let (asked, numbers) = (asked.as_ptr(), numbers.as_mut_ptr());
            let mut written = 0;
            of_resource(
                program,
                interface,
                index,
                n,
                asked,
                most,
                &mut written,
                numbers,
            );
        };
        let mut count = 0;
        of_interface(program, BLOCKS, 0x92F5, &mut count);
        let mut blocks = Vec::new();
        for block in 0..u32::try_from(count).unwrap_or(0) {
            let mut numbers = [0; 2];
            read(BLOCKS, block, &[0x9303, 0x9304], &mut numbers);
            let mut indices = vec![0; usize::try_from(numbers[1]).unwrap_or(0)];
            read(BLOCKS, block, &[0x9305], &mut indices);
            let members = indices.into_iter().map(|index| {
                let (index, mut numbers) = (index as u32, [0; 8]);
                let asked = [
                    0x92FA, 0x92FB, 0x92FC, 0x92FE, 0x92FF, 0x9300, 0x930C, 0x930D,
                ];
                read(VARIABLES, index, &asked, &mut numbers);
                Reported {
                    name: name(VARIABLES, index),
                    numbers,
                }
            });
            let members = members.collect();
            blocks.push(ReportedBlock {
                name: name(BLOCKS, block),
                size: numbers[0],
                members,
            });
        }
        Ok(blocks)
    }
}

/// Holds what the driver reports of a program to the constants.
///
/// # Safety
/// `load` returns the functions of the context that is current.
pub unsafe fn check(
    program: u32,
    load: &mut dyn FnMut(&str) -> *const c_void,
    blocks: &[Block],
) -> Result<(), String> {
    // SAFETY: the type is that of OpenGL 2.0.
    let linked = unsafe {
        let of_program: Parameters = function(load, "glGetProgramiv")?;
        let mut linked = 0;
        of_program(program, 0x8B82, &mut linked);
        linked
    };
    if linked == 0 {
        return Err(format!("{program} is not a program that is linked"));
    }
    let (mut uniform, mut storage) = (Vec::new(), Vec::new());
    // SAFETY: as promised for `load`.
    unsafe {
        if blocks.iter().any(|block| !block.is_storage) {
            uniform = uniform_blocks(program, load)?;
        }
        if blocks.iter().any(|block| block.is_storage) {
            storage = storage_blocks(program, load)?;
        }
    }
    let mut found = Vec::new();
    for block in blocks {
        let reported = if block.is_storage { &storage } else { &uniform };
        // Of an array of blocks, each element is reported.
        let is_it =
            |one: &&ReportedBlock| one.name.split('[').next() == Some(block.name);
        match reported.iter().find(is_it) {
            Some(reported) => compare(block, reported, &mut found),
            None => {
                found.push(format!("{}: the program has no such block", block.name))
            }
        }
    }
    match found.len() {
        0 => Ok(()),
        count => Err(format!(
            "the constants and the program differ in {count} place{}:\n  {}",
            if count == 1 { "" } else { "s" },
            found.join("\n  ")
        )),
    }
}

/// A member's path without the block's name, each index replaced by `[]`; and the indices.
fn path_of(name: &str, prefix: &str) -> (String, Vec<i64>) {
    let inside = match name.strip_prefix(prefix) {
        Some(rest) if !prefix.is_empty() => {
            rest.split_once('.').map_or(name, |(_, inside)| inside)
        }
        _ => name,
    };
    let (mut path, mut indices) = (String::new(), Vec::new());
    for (at, part) in inside.split('[').enumerate() {
        match part.split_once(']') {
            Some((index, rest)) if at > 0 => {
                indices.push(index.parse().unwrap_or(0));
                path.push_str("[]");
                path.push_str(rest);
            }
            _ => path.push_str(part),
        }
    }
    (path, indices)
}

/// Adds a line for each member that the two place or type otherwise.
fn compare(block: &Block, reported: &ReportedBlock, found: &mut Vec<String>) {
    let name = block.name;
    let mut seen: Vec<Vec<(Vec<i64>, &Reported)>> = Vec::new();
    seen.resize_with(block.members.len(), Vec::new);
    let mut unknown = Vec::new();
    for one in &reported.members {
        let (path, mut indices) = path_of(&one.name, block.prefix);
        let at = block.members.iter().position(|member| {
            let shorter = member.path.strip_suffix("[]") == Some(&*path);
            if shorter {
                indices.push(0);
            }
            shorter || member.path == path
        });
        match at {
            Some(at) => seen[at].push((indices, one)),
            None => unknown.push((one.numbers[2], path)),
        }
    }
    unknown.sort();
    unknown.dedup_by(|a, b| a.1 == b.1);
    for (offset, path) in unknown {
        found.push(format!(
            "{name}.{path}: byte {offset} in the program, not in the constants"
        ));
    }
    for (member, seen) in block.members.iter().zip(seen) {
        if seen.is_empty() && !block.is_packed {
            let (path, offset) = (member.path, member.offset);
            found.push(format!(
                "{name}.{path}: byte {offset} in the constants, not in the program"
            ));
        }
        found.extend(
            seen.iter()
                .find_map(|(indices, one)| place(block, member, indices, one)),
        );
        found.extend(shape(block, member, &seen));
    }
    let size = i64::from(reported.size);
    // Some drivers round the size up, whatever the rules.
    let most = (block.sizes.1 + 15) / 16 * 16;
    if !block.is_packed && !(block.sizes.0..=most).contains(&size) {
        found.push(format!(
            "{name}: {} bytes in the constants, {size} in the program",
            block.sizes.1
        ));
    }
}

/// Where an element lies otherwise, or what else its bytes are read as.
fn place(
    block: &Block,
    member: &Member,
    indices: &[i64],
    one: &Reported,
) -> Option<String> {
    let [ty, _, offset, _, stride, row_major, ..] = one.numbers.map(i64::from);
    let (path, _) = path_of(&one.name, block.prefix);
    let mut parts = path.split("[]");
    let mut path = format!("{}.{}", block.name, parts.next().unwrap_or(""));
    for (index, part) in indices.iter().zip(parts.chain([""])) {
        path.push_str(&format!("[{index}]{part}"));
    }
    let arrays = indices.iter().zip(member.arrays);
    let expected = arrays.fold(member.offset, |at, (index, (_, stride))| {
        at + index * stride
    });
    if offset != expected {
        let text = format!(
            "{path}: byte {expected} in the constants, {offset} in the program"
        );
        return Some(text);
    }
    let (number, name) = member.ty;
    if number != 0 && ty != i64::from(number) {
        return Some(format!(
            "{path}: a {name} at byte {offset} in the constants, a type {ty:#x} in the program"
        ));
    }
    let (expected, by_rows) = member.matrix?;
    let order = |by_rows: bool| if by_rows { "row-major" } else { "column-major" };
    if stride != expected || (row_major != 0) != by_rows {
        return Some(format!(
            "{path}: {}, {expected} bytes apart in the constants, {}, {stride} in the program",
            order(by_rows),
            order(row_major != 0)
        ));
    }
    None
}

/// How the arrays around a member differ.
fn shape(
    block: &Block,
    member: &Member,
    seen: &[(Vec<i64>, &Reported)],
) -> Option<String> {
    let (_, first) = seen.first()?;
    let [_, elements, _, stride, _, _, outer, outer_stride] =
        first.numbers.map(i64::from);
    let last = member.arrays.len().checked_sub(1)?;
    for (at, (length, expected)) in member.arrays.iter().enumerate() {
        let reached = seen
            .iter()
            .filter_map(|(indices, _)| indices.get(at))
            .max()?;
        let (reported, distance) = match (at == last && member.path.ends_with("[]"), at)
        {
            (true, _) => (elements, stride),
            // Of the outermost array of a storage block, one element is reported.
            (false, 0) if block.is_storage && outer_stride != 0 => {
                (outer, outer_stride)
            }
            (false, _) => (reached + 1, *expected),
        };
        let path = format!("{}.{}", block.name, member.path);
        if distance != *expected {
            return Some(format!(
                "{path}: elements {expected} bytes apart in the constants, {distance} in the program"
            ));
        }
        if reported != *length && !block.is_packed {
            return Some(format!(
                "{path}: {length} elements in the constants, {reported} in the program"
            ));
        }
    }
    None
}
