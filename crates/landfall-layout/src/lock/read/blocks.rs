//! Reads the layout of one shader: its blocks, their members and leaves.
//!
//! Values come from [`place`](crate::lock::place) and types from
//! [`spelling`](crate::lock::spelling); [`check`](crate::lock::check) checks consistency.

use std::sync::Arc;

use crate::error::Error;
use crate::layout;
use crate::layout::{BlockLayout, MAX_LEAVES, MemberLayout};
use crate::lock::check::MemberContext;
use crate::lock::place::{JsonText, Object, WRITE_AGAIN};
use crate::lock::{Lock, SPACES, Verified, check, spelling};
use crate::shape::{
    AddressSpace, ArrayLen, DEFAULT_BLOCK, MatrixLayout, Member, Rules, Struct, Type,
};
use crate::source::{Files, Language, Span, Stage, Target};
use crate::text::json::{Node, Value};

const BLOCK_KEYS: &[&str] = &[
    "name",
    "variants",
    "instance",
    "address_space",
    "rules",
    "rules_declared",
    "group",
    "binding",
    "count",
    "size",
    "data_size",
    "align",
    "members",
    "span",
    "opaque",
    "leaves",
    "offsets",
];

pub(super) type MacroSet = Vec<(String, String)>;

/// The sets of macros of a lock, the first being none.
pub(super) struct Sets(pub Vec<MacroSet>);

impl Sets {
    /// Those of a shader without variants.
    pub(super) fn none() -> Sets {
        Sets(vec![MacroSet::new()])
    }
}

/// The JSON format that is read.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    Lock,
    Layout,
}

pub(super) struct BlockReader<'t> {
    pub place: JsonText<'t>,
    pub shape: Shape,
    pub files: Files,
}

impl BlockReader<'_> {
    pub fn lock(&self, object: Object<'_>) -> Result<Lock, Error> {
        let place = &self.place;
        object.known(
            place,
            match self.shape {
                Shape::Lock => &[
                    "schema_version",
                    "language",
                    "assumed_target",
                    "variants",
                    "blocks",
                    "verified",
                ],
                Shape::Layout => &[
                    "path",
                    "language",
                    "stage",
                    "variants",
                    "includes",
                    "overrides",
                    "constants",
                    "structures",
                    "assumed_target",
                    "blocks",
                ],
            },
        )?;
        let language = self.word(object, "language", &Language::ALL, Language::name)?;
        let stage = match object.get("stage") {
            Some(node) => Stage::from_name(place.text(node, "stage")?),
            None => None,
        };
        let assumed_target = match object.get("assumed_target") {
            Some(_) => {
                let all = [Target::OpenGl, Target::Vulkan];
                Some(self.word(object, "assumed_target", &all, layout::targets::key)?)
            }
            None => None,
        };
        let shader = object.get("path").map(|node| place.text(node, "path")).transpose()?;
        let shader = shader.map(String::from);
        let blocks = self.required(object, "blocks")?;
        // A shader with variants is one entry in the output of `layout` for each group of variants
        // that share all blocks, and one lock with the variants of each block.
        // Of `layout`, the key says which variants have all of these blocks.
        let (sets, shader) = match self.shape {
            Shape::Lock => (self.sets(object)?, shader),
            Shape::Layout => (Sets::none(), self.title(object, shader)?),
        };
        let read = |node| Ok((self.block(node, language)?, self.having(node, &sets)?));
        let blocks = place.list(blocks, "blocks")?.iter().map(read).collect::<Result<_, _>>()?;
        let (blocks, variants) = self.divided(sets, blocks)?;
        let verified = match object.get("verified") {
            Some(node) => {
                let list = place.list(node, "verified")?;
                list.iter().map(|one| self.verified(one)).collect::<Result<_, _>>()?
            }
            None => Vec::new(),
        };
        let files = self.files.clone();
        Ok(Lock { shader, language, stage, blocks, variants, verified, assumed_target, files })
    }

    fn required<'n>(&self, object: Object<'n>, key: &str) -> Result<&'n Node, Error> {
        object.get(key).ok_or_else(|| {
            self.place.error(object.at, &format!("lacks `{key}`")).with_help(WRITE_AGAIN)
        })
    }

    /// A string that is one of `names`.
    fn word<T: Copy>(
        &self,
        object: Object<'_>,
        key: &str,
        all: &[T],
        name: impl Fn(T) -> &'static str,
    ) -> Result<T, Error> {
        let node = self.required(object, key)?;
        let text = self.place.text(node, key)?;
        all.iter().copied().find(|one| name(*one) == text).ok_or_else(|| {
            let names: Vec<&str> = all.iter().map(|one| name(*one)).collect();
            let message = format!("has `{text}` where `{key}` must be one of {}", names.join(", "));
            self.place.error(node.start, &message).with_help(WRITE_AGAIN)
        })
    }

    fn optional(&self, object: Object<'_>, key: &str) -> Result<Option<u64>, Error> {
        object.get(key).map(|node| self.place.number(node, key)).transpose()
    }

    /// A set or binding.
    fn slot(&self, object: Object<'_>, key: &str) -> Result<Option<u32>, Error> {
        // `optional` limits numbers to at most 2^32.
        Ok(self.optional(object, key)?.map(|n| u32::try_from(n).unwrap_or(u32::MAX)))
    }

    fn numbers(&self, object: Object<'_>, key: &str) -> Result<Vec<u64>, Error> {
        let Some(node) = object.get(key) else { return Ok(Vec::new()) };
        self.place.list(node, key)?.iter().map(|item| self.place.number(item, key)).collect()
    }

    /// The dimensions of an array of blocks; empty for a single block.
    fn count(&self, object: Object<'_>) -> Result<Vec<ArrayLen>, Error> {
        Ok(match (object.get("count"), self.shape) {
            // `layout` always writes the count; a lock leaves it out for a block that is no array.
            (Some(node), shape) => match self.place.number(node, "count")? {
                1 if shape == Shape::Layout => Vec::new(),
                n => vec![ArrayLen::Fixed(u32::try_from(n).unwrap_or(u32::MAX))],
            },
            // Null is a count that the shader does not specify; no key means one buffer.
            (None, _) if object.entries.iter().any(|(key, _, _)| key == "count") => {
                vec![ArrayLen::Runtime]
            }
            (None, _) => Vec::new(),
        })
    }

    fn block(&self, node: &Node, language: Language) -> Result<BlockLayout, Error> {
        let place = &self.place;
        let object = place.object(node, "a block")?;
        object.known(place, BLOCK_KEYS)?;
        let name_node = self.required(object, "name")?;
        let space = self.word(object, "address_space", &SPACES, AddressSpace::name)?;
        let loose = space == AddressSpace::Default;
        let declared = object.get("rules_declared");
        let declared = declared.map(|node| place.truth(node, "rules_declared")).transpose()?;
        let members = place.list(self.required(object, "members")?, "members")?;
        let leaf_nodes = match object.get("leaves") {
            Some(node) => Some(place.list(node, "leaves")?),
            None => None,
        };
        let leaf_paths = leaf_nodes.map(|nodes| self.leaf_paths(nodes)).transpose()?;
        let within = MemberContext { language, loose, leaves: leaf_paths.as_deref() };
        let members = self.members(members, &within, "")?;
        let count = self.count(object)?;
        let opaque = match object.get("opaque") {
            Some(node) => place.list(node, "opaque")?,
            None => &[],
        };
        let opaque: Vec<&str> =
            opaque.iter().map(|node| place.text(node, "opaque")).collect::<Result<_, _>>()?;
        // As of shaders, and before an entry is made for each.
        if members.iter().fold(0u64, |sum, m| sum.saturating_add(m.ty.leaves())) > MAX_LEAVES {
            let message =
                format!("has a block with more than {MAX_LEAVES} scalars, vectors and matrices");
            return Err(place.error(object.at, &message).with_help(WRITE_AGAIN));
        }
        let name = place.text(name_node, "name")?;
        let rules_declared = declared.unwrap_or(!loose);
        let mut block = BlockLayout {
            name: Arc::from(name),
            instance: object
                .get("instance")
                .map(|n| place.text(n, "instance"))
                .transpose()?
                .map(Arc::from),
            space,
            // Stands in: loose uniforms have no numbers that depend on rules.
            rules: if loose {
                Rules::Std140
            } else {
                self.word(object, "rules", &Rules::ALL, Rules::name)?
            },
            rules_declared,
            // A lock does not record it.
            gathered: loose || (!rules_declared && name == DEFAULT_BLOCK),
            group: self.slot(object, "group")?,
            binding: self.slot(object, "binding")?,
            count,
            size: self.optional(object, "size")?,
            data_size: self.optional(object, "data_size")?,
            align: self.optional(object, "align")?,
            members,
            leaves: Vec::new(),
            // `layout` lists those within structures, too, by paths.
            opaque: opaque.into_iter().filter(|path| !path.contains('.')).map(Arc::from).collect(),
            span: span(name_node),
            comment: Vec::new(),
        };
        // Members were checked one by one; here they are against the block.
        check::block(place, &block)?;
        block.leaves = layout::leaves_of(&block.members, block.rules);
        if let Some(nodes) = leaf_nodes {
            self.leaves(nodes, &block, language)?;
        }
        Ok(block)
    }

    fn leaf_paths<'n>(&self, nodes: &'n [Node]) -> Result<Vec<&'n str>, Error> {
        let path = |node: &'n Node| {
            let object = self.place.object(node, "a leaf")?;
            self.place.text(self.required(object, "path")?, "path")
        };
        nodes.iter().map(path).collect()
    }

    fn members(
        &self,
        nodes: &[Node],
        within: &MemberContext<'_>,
        parent: &str,
    ) -> Result<Vec<MemberLayout>, Error> {
        nodes.iter().map(|node| self.member(node, within, parent)).collect()
    }

    fn member(
        &self,
        node: &Node,
        within: &MemberContext<'_>,
        parent: &str,
    ) -> Result<MemberLayout, Error> {
        let place = &self.place;
        let object = place.object(node, "a member")?;
        object.known(
            place,
            &[
                "name",
                "type",
                "offset",
                "size",
                "align",
                "strides",
                "matrix_stride",
                "row_major",
                "structure",
                "members",
                "array_stride",
                "dims",
                "span",
            ],
        )?;
        let name_node = self.required(object, "name")?;
        let name: Arc<str> = Arc::from(place.text(name_node, "name")?);
        let type_node = self.required(object, "type")?;
        let spelled = place.text(type_node, "type")?;
        let unknown = |at: &Node| {
            let message = format!("gives `{name}` the unknown type `{spelled}`");
            place.error(at.start, &message).with_help(WRITE_AGAIN)
        };
        // Dimensions first: the path needs their number, and a structure its own name.
        let spelling =
            spelling::take_apart(spelled, within.language).ok_or_else(|| unknown(type_node))?;
        let path = match parent {
            "" => format!("{name}{}", "[]".repeat(spelling.dims.len())),
            _ => format!("{parent}.{name}{}", "[]".repeat(spelling.dims.len())),
        };
        let row_major = object.get("row_major").map(|n| place.truth(n, "row_major")).transpose()?;
        let offset = self.optional(object, "offset")?;
        let size = self.optional(object, "size")?;
        let members = match object.get("members") {
            Some(node) => Some(self.members(place.list(node, "members")?, within, &path)?),
            None => None,
        };
        // Members make a structure, as their names are all that tells it from an unknown type. Then
        // scalars, vectors and matrices by spelling.
        let base = match (members.as_deref(), spelling::leaf_type(&spelling.base, within.language))
        {
            (Some(members), _) => structure(&spelling.base, members, span(name_node)),
            (None, Some(plain)) => plain,
            // The output of `layout` marks a structure of samplers only by its lack of leaves.
            (None, None) if within.leaves.is_some_and(|all| !all.contains(&path.as_str())) => {
                structure(&spelling.base, &[], span(name_node))
            }
            // A buffer reference has the name of its block, and is an address of 8 bytes; of arrays
            // and loose uniforms the size does not tell.
            (None, None) if !spelling.dims.is_empty() || within.loose || size == Some(8) => {
                Type::Address(Arc::from(spelling.base.as_str()))
            }
            (None, None) => return Err(unknown(type_node)),
        };
        let member = MemberLayout {
            name,
            ty: spelling::array_of(base, &spelling.dims),
            offset,
            size,
            align: self.optional(object, "align")?,
            dims: spelling.dims,
            strides: self.numbers(object, "strides")?,
            matrix_stride: self.optional(object, "matrix_stride")?,
            row_major: row_major.unwrap_or(false),
            members: members.unwrap_or_default(),
            span: span(name_node),
            comment: Vec::new(),
        };
        check::member(place, &member, within)?;
        Ok(member)
    }

    /// Checks the leaves listed in an output of `layout` against those of its members.
    fn leaves(&self, nodes: &[Node], block: &BlockLayout, language: Language) -> Result<(), Error> {
        let place = &self.place;
        for (i, node) in nodes.iter().enumerate() {
            let object = place.object(node, "a leaf")?;
            object.known(
                place,
                &[
                    "path",
                    "type",
                    "kind",
                    "width",
                    "columns",
                    "rows",
                    "offset",
                    "dims",
                    "strides",
                    "size",
                    "matrix_stride",
                    "row_major",
                    "naga_offset",
                    "naga_dims",
                    "naga_strides",
                ],
            )?;
            let path_node = self.required(object, "path")?;
            let path = place.text(path_node, "path")?;
            let refuse =
                |message: String| Err(place.contradiction(span(path_node).start, &message));
            // Leaves are in member order, so search only on a mismatch.
            let Some(leaf) = block.leaves.get(i).filter(|leaf| leaf.path == path) else {
                return refuse(match block.leaves.iter().any(|leaf| leaf.path == path) {
                    true if listed(&nodes[..i], path) => {
                        format!("the leaf `{path}` is listed twice")
                    }
                    true => format!("the leaf `{path}` is not in the order of the members"),
                    false => format!("no member of `{}` is the leaf `{path}`", block.name),
                });
            };
            // A leaf is a summary of its members; where they disagree, neither can be trusted.
            let numbers = [
                ("offset", self.optional(object, "offset")?, leaf.offset),
                ("size", self.optional(object, "size")?, leaf.size),
                ("matrix_stride", self.optional(object, "matrix_stride")?, leaf.matrix_stride),
            ];
            for (key, listed_value, made) in numbers {
                if listed_value != made {
                    let shown = |n: Option<u64>| n.map_or("null".to_string(), |n| n.to_string());
                    return refuse(format!(
                        "the leaf `{path}` has `{key}` {}, but its member puts it at {}",
                        shown(listed_value),
                        shown(made)
                    ));
                }
            }
            let ty = place.text(self.required(object, "type")?, "type")?;
            let made = leaf.ty.spelled(language).to_string();
            if ty != made {
                return refuse(format!("the leaf `{path}` is a `{ty}`, its member a `{made}`"));
            }
            let strides = self.numbers(object, "strides")?;
            if strides != leaf.strides {
                return refuse(format!(
                    "the leaf `{path}` has the strides {strides:?}, its members {:?}",
                    leaf.strides
                ));
            }
        }
        // In order and without another one among them, so that only the last can be missing.
        match block.leaves.get(nodes.len()) {
            None => Ok(()),
            Some(leaf) => Err(place.contradiction(
                block.span.start,
                &format!("the leaf `{}` of `{}` is not listed", leaf.path, block.name),
            )),
        }
    }

    fn verified(&self, node: &Node) -> Result<Verified, Error> {
        let object = self.place.object(node, "an entry of `verified`")?;
        object.known(&self.place, &["backend", "adapter", "driver", "version"])?;
        let text = |key: &str| {
            let node = self.required(object, key)?;
            self.place.text(node, key).map(String::from)
        };
        Ok(Verified {
            backend: text("backend")?,
            adapter: text("adapter")?,
            driver: text("driver")?,
            version: text("version")?,
        })
    }
}

/// Whether one of the leaves has this path.
fn listed(nodes: &[Node], path: &str) -> bool {
    let says = |node: &Node| match &node.value {
        Value::Object(entries) => entries.iter().any(|(key, _, node)| {
            key == "path" && matches!(&node.value, Value::Text(text) if text == path)
        }),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::Text(_) | Value::List(_) => false,
    };
    nodes.iter().any(says)
}

fn span(node: &Node) -> Span {
    let at = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    Span { file: 0, start: at(node.start), end: at(node.end) }
}

/// A structure type with the members of a layout.
fn structure(name: &str, members: &[MemberLayout], span: Span) -> Type {
    // GLSL's nameless `struct { … }` is spelled `struct`.
    let name = if name == "struct" { "" } else { name };
    let declared = |member: &MemberLayout| Member {
        matrix_layout: member.row_major.then_some(MatrixLayout::Row),
        ..Member::unqualified(member.name.clone(), member.ty.clone(), member.span)
    };
    let members = members.iter().map(declared).collect();
    Type::Struct(Arc::new(Struct::new(Arc::from(name), members, Vec::new(), span)))
}
