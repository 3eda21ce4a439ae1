//! The C types of members, and the structures they need, each kept once.
//!
//! Reads the [layout](landfall_layout::layout); [`structs`](super::structs) prints these structures.

use rustc_hash::{FxHashMap, FxHashSet};

use super::comments;
use super::names::{Names, identifier_part};
use super::plain::{CType, glm_type, plain_type};
use crate::refusal::Refusal;
use crate::user_types::UserTypes;
use landfall_layout::ShaderLayout;
use landfall_layout::layout::measure::element_size;
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::{ArrayLen, Rules, Type};
use landfall_layout::source::Span;

/// A member of a C structure.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Field {
    pub name: String,
    /// The member's name in the shader; empty for padding.
    pub member: String,
    pub ty: CType,
    pub offset: u64,
    /// The type in the shader's spelling.
    pub shader_type: String,
    pub comment: Vec<String>,
}

impl Field {
    /// The assertion that a type of the program has the size of the shader's, and an alignment with
    /// which it stands at the offset, and in what repeats after `stride` bytes; in a packed structure
    /// any alignment does.
    pub fn assert_type(&self, stride: u64, is_packed: bool) -> String {
        let CType { base, brackets, size, .. } = &self.ty;
        let size = size / brackets.iter().product::<u64>().max(1);
        let place = format!("`{base}` has {size} bytes in the shader");
        if is_packed {
            return format!("static_assert(sizeof({base}) == {size}, \"{place}\");\n");
        }
        // The alignment divides both the offset and the stride: as many zeros as their common ones
        // at the end.
        let most = 1u64 << (self.offset | stride).trailing_zeros();
        format!(
            "static_assert(sizeof({base}) == {size} && alignof({base}) <= {most},\n    \
             \"{place}, aligned to {most} at most at byte {}\");\n",
            self.offset
        )
    }
}

/// The C structure of a block.
#[derive(Clone, Debug)]
pub(super) struct Mirror {
    /// The structure before the runtime-sized tail; `None` when the tail is the only member.
    pub structure: Option<String>,
    /// The tail's field and its stride in bytes.
    pub tail: Option<(Field, u64)>,
}

#[derive(Clone, Debug)]
pub(super) struct CStruct {
    pub name: String,
    pub fields: Vec<Field>,
    pub size: u64,
    pub align: u64,
    /// The alignment that `#pragma pack` must lower it to.
    pub pack: Option<u64>,
    /// The runtime-sized array after it.
    pub tail: Option<Field>,
    /// Whether it is a padded element that other headers define too.
    pub shared: bool,
    /// Its name in the shader; empty for padded elements.
    pub shader_name: String,
    pub comment: Vec<String>,
}

/// The structures of a header, each after those it contains.
#[derive(Debug, Default)]
pub(super) struct Types {
    pub structs: Vec<CStruct>,
    /// The index of each, by its C name.
    places: FxHashMap<String, usize>,
    /// The C name of each, by shader name and signature.
    known: FxHashMap<(String, String), String>,
    /// The types of the program.
    pub user: UserTypes,
    /// Whether vectors and matrices are those of glm.
    glm: bool,
    /// Whether a type is one of C++.
    pub is_cpp: bool,
}

impl Types {
    pub fn new(user: UserTypes, glm: bool) -> Types {
        Types { user, glm, is_cpp: glm, ..Types::default() }
    }

    /// Removes the structures from index `mark` on.
    pub fn roll_back(&mut self, mark: usize, names: &mut Names) {
        for dropped in self.structs.drain(mark..) {
            names.global.release(&dropped.name);
            self.places.remove(&dropped.name);
        }
        self.known.retain(|_, name| self.places.contains_key(name));
    }

    /// Returns the structure with this C name.
    pub fn get(&self, name: &str) -> Option<&CStruct> {
        self.places.get(name).map(|&place| &self.structs[place])
    }

    /// Adds the structures of a block.
    pub fn block(
        &mut self,
        block: &BlockLayout,
        shader: &ShaderLayout,
        names: &mut Names,
    ) -> Result<Mirror, Refusal> {
        let size = crate::runtime_tail::buffer_size(block).unwrap_or(0);
        let (fixed, last) = block.split_tail();
        // A runtime-sized tail is no part of the structure in C++, and a flexible array member in
        // C.
        let types = |member| self.member_type(&block.name, member, block.rules, shader, names);
        let tail_type = last.map(types).transpose()?;
        let end = last.and_then(|member| member.offset).unwrap_or(size);
        let fields = self.fields(&block.name, fixed, end, block.rules, shader, names)?;
        // Padding may have the name that the tail asks for.
        let taken = fields.iter().map(|field| field.name.clone()).collect();
        let tail = last
            .zip(tail_type)
            .map(|(member, ty)| (field(member, ty, shader, names, &taken), member.strides[0]));
        let comment = comments::lines(&block.comment, shader);
        let structure = if fields.is_empty() {
            None
        } else {
            let tail = tail.as_ref().map(|(field, _)| field.clone());
            Some(self.structure(&block.name, fields, end, tail, comment, names))
        };
        Ok(Mirror { structure, tail })
    }

    /// The fields of `members` and the padding between them, up to `end`.
    fn fields(
        &mut self,
        owner: &str,
        members: &[MemberLayout],
        end: u64,
        rules: Rules,
        shader: &ShaderLayout,
        names: &mut Names,
    ) -> Result<Vec<Field>, Refusal> {
        let mut sorted: Vec<&MemberLayout> = members.iter().collect();
        sorted.sort_by_key(|member| member.offset);
        let mut fields: Vec<Field> = Vec::with_capacity(sorted.len());
        let mut taken = FxHashSet::default();
        let mut at = 0;
        for member in sorted {
            let ty = self.member_type(owner, member, rules, shader, names)?;
            let field = field(member, ty, shader, names, &taken);
            // Scalar layout and SPIR-V let a member begin in the padding of the one before; in C no
            // field can.
            if field.offset < at {
                return Err(overlap(
                    &fields,
                    at,
                    field.offset,
                    &format!("`{}`", member.name),
                    member.span,
                ));
            }
            pad(&mut fields, &mut taken, at, field.offset);
            at = field.offset + field.ty.size;
            taken.insert(field.name.clone());
            fields.push(field);
        }
        if at > end {
            let span = members.last().map_or(Span::default(), |member| member.span);
            return Err(overlap(&fields, at, end, "the next member", span));
        }
        if !fields.is_empty() || end > 0 {
            pad(&mut fields, &mut taken, at, end);
        }
        Ok(fields)
    }

    /// The C type of a member, without a runtime-sized outer dimension.
    fn member_type(
        &mut self,
        owner: &str,
        member: &MemberLayout,
        rules: Rules,
        shader: &ShaderLayout,
        names: &mut Names,
    ) -> Result<CType, Refusal> {
        let mut ty = match member.ty.innermost() {
            Type::Struct(s) => {
                let size = element_size(member, rules);
                let shader_name =
                    if s.name.is_empty() { member.name.to_string() } else { s.name.to_string() };
                let fields =
                    self.fields(&shader_name, &member.members, size, rules, shader, names)?;
                let name = self.structure(&shader_name, fields, size, None, Vec::new(), names);
                self.use_of(name)
            }
            plain => self.plain(owner, plain, member),
        };
        // From the innermost dimension outwards: an element shorter than its stride is wrapped with
        // padding.
        for (len, stride) in member.dims.iter().zip(&member.strides).rev() {
            if ty.size > *stride {
                let why = format!(
                    "an element of `{}` takes {} bytes in C, its stride is {stride}",
                    member.name, ty.size
                );
                return Err(Refusal { span: member.span, why });
            }
            if ty.size < *stride {
                ty = self.element(ty, *stride, names);
            }
            if let ArrayLen::Fixed(n) = len {
                ty.brackets.insert(0, u64::from(*n));
                ty.size = stride * u64::from(*n);
            }
        }
        Ok(ty)
    }

    /// The type of a scalar, vector or matrix: one of the program, of glm, or of C.
    fn plain(&mut self, owner: &str, ty: &Type, member: &MemberLayout) -> CType {
        let plain = plain_type(ty, member);
        let user = self.user.of(owner, member).map(|name| name.to_string());
        let glm = || self.glm.then(|| glm_type(ty, member)).flatten();
        let Some(base) = user.or_else(glm) else { return plain };
        // A name of C++, `glm::vec3` or `Vec<3>`, makes the header one for C++ alone.
        self.is_cpp |= base.contains([':', '<']);
        CType { base, brackets: Vec::new(), is_user: true, ..plain }
    }

    /// A structure of one `value` and padding up to `stride`.
    fn element(&mut self, ty: CType, stride: u64, names: &mut Names) -> CType {
        // Padded plain types have the same name and contents in every header.
        let shared = !ty.is_user && self.get(&ty.base).is_none_or(|base| base.shared);
        let mut name = identifier_part(&ty.base.trim_end_matches("_t").replace("::", "_"));
        if shared && !name.starts_with("landfall_") {
            name.insert_str(0, "landfall_");
        }
        for count in &ty.brackets {
            name.push_str(&format!("_{count}"));
        }
        name.push_str(&format!("_stride{stride}"));
        let size = ty.size;
        let mut fields = vec![Field {
            name: "value".to_string(),
            member: String::new(),
            offset: 0,
            shader_type: String::new(),
            comment: Vec::new(),
            ty,
        }];
        pad(&mut fields, &mut FxHashSet::default(), size, stride);
        // By contents: the same element in another block is the same structure.
        let key = (name.clone(), signature(&fields, stride, None));
        let known = self.known.get(&key).cloned();
        let kept = known.unwrap_or_else(|| {
            let claimed = if shared { name } else { names.global.claim(name) };
            let made = CStruct::new(claimed, fields, stride);
            self.keep(key, CStruct { shared, ..made })
        });
        self.use_of(kept)
    }

    /// The type of a kept structure.
    fn use_of(&self, name: String) -> CType {
        let found = self.get(&name).expect("it was just kept");
        CType {
            size: found.size,
            align: found.align,
            brackets: Vec::new(),
            base: name,
            is_user: false,
        }
    }

    /// Returns the C name of the structure with these contents, adding it if it is new.
    fn structure(
        &mut self,
        shader_name: &str,
        fields: Vec<Field>,
        size: u64,
        tail: Option<Field>,
        comment: Vec<String>,
        names: &mut Names,
    ) -> String {
        let key = (shader_name.to_string(), signature(&fields, size, tail.as_ref()));
        if let Some(known) = self.known.get(&key) {
            return known.clone();
        }
        let made = CStruct::new(names.of_type(shader_name), fields, size);
        let shader_name = shader_name.to_string();
        self.keep(key, CStruct { shader_name, comment, tail, ..made })
    }

    fn keep(&mut self, key: (String, String), mut made: CStruct) -> String {
        let all = made.fields.iter().chain(&made.tail);
        // What the compiler would align it to; less has to be asked for by `#pragma pack`.
        let natural = all.map(|f| f.ty.align).max().unwrap_or(1);
        made.align = fitting_alignment(&made, natural);
        made.pack = (made.align < natural).then_some(made.align);
        let name = made.name.clone();
        self.known.insert(key, name.clone());
        self.places.insert(name.clone(), self.structs.len());
        self.structs.push(made);
        name
    }
}

impl CStruct {
    /// A key of its contents, comments ignored.
    pub fn signature(&self) -> String {
        signature(&self.fields, self.size, self.tail.as_ref())
    }

    fn new(name: String, fields: Vec<Field>, size: u64) -> CStruct {
        CStruct {
            name,
            fields,
            size,
            align: 1,
            pack: None,
            tail: None,
            shared: false,
            shader_name: String::new(),
            comment: Vec::new(),
        }
    }
}

/// A key of a structure's contents, comments ignored.
fn signature(fields: &[Field], size: u64, tail: Option<&Field>) -> String {
    let mut text = format!("{size}");
    for (mark, field) in fields.iter().map(|f| (';', f)).chain(tail.map(|f| ('~', f))) {
        let CType { base, brackets, .. } = &field.ty;
        text.push_str(&format!("{mark}{} {base}{brackets:?}@{}", field.name, field.offset));
    }
    text
}

fn field(
    member: &MemberLayout,
    ty: CType,
    shader: &ShaderLayout,
    names: &Names,
    taken: &FxHashSet<String>,
) -> Field {
    Field {
        name: names.field(&member.name, taken),
        member: member.name.to_string(),
        ty,
        offset: member.offset.expect("a placed block's members are placed"),
        shader_type: member.ty.spelled(shader.language).to_string(),
        comment: comments::lines(&member.comment, shader),
    }
}

fn pad(fields: &mut Vec<Field>, taken: &mut FxHashSet<String>, from: u64, to: u64) {
    if to <= from {
        return;
    }
    let mut name = format!("_pad_{from}");
    while taken.contains(&name) {
        name.push('_');
    }
    taken.insert(name.clone());
    fields.push(Field {
        name,
        member: String::new(),
        ty: CType {
            base: "uint8_t".to_string(),
            brackets: vec![to - from],
            size: to - from,
            align: 1,
            is_user: false,
        },
        offset: from,
        shader_type: String::new(),
        comment: Vec::new(),
    });
}

fn overlap(fields: &[Field], end: u64, next: u64, name: &str, span: Span) -> Refusal {
    let before = fields.last().map_or("", |field| field.member.as_str());
    let why = format!(
        "`{before}` ends at byte {end} in C, but {name} begins at byte {next}, inside its padding"
    );
    Refusal { span, why }
}

/// The largest alignment, at most `natural`, under which C places every field at its offset.
fn fitting_alignment(made: &CStruct, natural: u64) -> u64 {
    let mut align = natural;
    while align > 1 {
        let mut all = made.fields.iter().chain(&made.tail);
        // In a packed structure no field is aligned to more than the pack.
        let fits = all.all(|f| f.offset.is_multiple_of(f.ty.align.min(align)));
        if fits && made.size.is_multiple_of(align) {
            break;
        }
        align /= 2;
    }
    align
}
