//! The interface of a GLSL shader: what its global declarations bind, and which of it `main` and
//! the functions it calls use.

use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::ast::{BlockDecl, Declaration, Dim, Item, LayoutId, Qualifiers, Storage};
use super::declarations::{DeclarationReader, Named};
use super::handles;
use super::parser::Bodies;
use super::scopes::{Scopes, Use};
use super::texts::Texts;
use super::types::{Builtin, builtin};
use crate::interface::{EntryPoint, Input, Interface, Resource, ResourceKind, SpecConstant};
use crate::shape::{AddressSpace, ArrayLen, Type};
use crate::source::{ReadOptions, Source, Span, Stage};
use crate::syntax::reached;

/// Returns the interface of a shader; what has errors, which [`super::read`] reports, is missing.
pub(in crate::syntax) fn read(source: &Source, options: &ReadOptions) -> Interface {
    let texts = Texts::new();
    let mut reader = super::reader(source, options, &texts, Bodies::Keep);
    let mut items = reader.read_items();
    let mut unread = Vec::new();
    // One by one: a function that cannot be parsed must not hide the uses of the others. It counts
    // as one that uses every name in it.
    for (at, item) in items.iter_mut().enumerate() {
        if reader.parser.complete(std::slice::from_mut(item), source.stage).is_err() {
            unread.push(at);
        }
    }
    let mut found = Found { interface: Interface::default(), names: FxHashMap::default() };
    let mut size = DeclaredLocalSize::default();
    for item in &items {
        match item {
            Item::Block(block) => found.block(&mut reader, block),
            Item::Variables(declaration) => found.variables(&mut reader, declaration),
            Item::Defaults(qualifiers) if qualifiers.storage == Storage::In => {
                for id in &qualifiers.layout {
                    size.read(&mut reader, id);
                }
            }
            _ => {}
        }
    }
    let mut graph = UseGraph::default();
    for (at, item) in items.iter().enumerate() {
        match unread.contains(&at) {
            true => graph.unread(&reader, item),
            false => graph.item(item),
        }
    }
    // `sampler2D(t, s)` pairs a texture with a sampler (GL_KHR_vulkan_glsl).
    for (texture, sampler) in &graph.pairs {
        if let (Some(texture), Some(sampler)) = (found.names.get(texture), found.names.get(sampler))
        {
            found.interface.pair(*texture, *sampler);
        }
    }
    if let Some(span) = graph.main {
        let used = graph.reached();
        let mut uses: Vec<usize> =
            used.iter().filter_map(|name| found.names.get(name)).copied().collect();
        uses.sort_unstable();
        uses.dedup();
        let stage = source.stage.or(size.declared.then_some(Stage::Compute));
        let inputs = match stage {
            Some(Stage::Vertex) => vertex_inputs(&mut reader, &items),
            _ => Vec::new(),
        };
        found.interface.entry_points.push(EntryPoint {
            name: "main".into(),
            stage,
            workgroup_size: size.declared.then_some(size.size),
            inputs,
            uses,
            span,
        });
    }
    found.interface.includes = std::mem::take(&mut reader.parser.preprocessor().opened);
    found.interface
}

/// The workgroup size of `layout(local_size_x = N) in;`.
// GLSL 4.60 §4.4.1.4: a dimension that is not stated is 1; `local_size_x_id` leaves it to a
// specialisation constant.
struct DeclaredLocalSize {
    declared: bool,
    size: [Option<u32>; 3],
}

impl Default for DeclaredLocalSize {
    fn default() -> DeclaredLocalSize {
        DeclaredLocalSize { declared: false, size: [Some(1); 3] }
    }
}

impl DeclaredLocalSize {
    fn read<'a>(&mut self, reader: &mut DeclarationReader<'a>, id: &LayoutId<'a>) {
        let name = id.name.text.to_ascii_lowercase();
        let Some(rest) = name.strip_prefix("local_size_") else { return };
        let Some(at) = ["x", "y", "z"].iter().position(|axis| rest.starts_with(axis)) else {
            return;
        };
        self.declared = true;
        self.size[at] = match rest.ends_with("_id") {
            true => None,
            false => reader.layout_number(id).ok().and_then(|value| u32::try_from(value).ok()),
        };
    }
}

/// The number of an entry of `layout(…)`.
fn number<'a>(
    reader: &mut DeclarationReader<'a>,
    qualifiers: &Qualifiers<'a>,
    key: &str,
) -> Option<u32> {
    u32::try_from(reader.layout_number(qualifiers.find(key)?).ok()?).ok()
}

/// What the declarations bind.
struct Found<'a> {
    interface: Interface,
    /// The resources by the names that stand for them: of instances, or of members.
    names: FxHashMap<&'a str, usize>,
}

impl<'a> Found<'a> {
    fn block(&mut self, reader: &mut DeclarationReader<'a>, block: &BlockDecl<'a>) {
        let qualifiers = &block.qualifiers;
        let space = super::blocks::address_space(qualifiers);
        match space {
            AddressSpace::Uniform | AddressSpace::Storage | AddressSpace::PushConstant => {}
            AddressSpace::BufferReference
            | AddressSpace::ShaderRecord
            | AddressSpace::TaskPayload
            | AddressSpace::Default
            | AddressSpace::Structure => return,
        }
        let mut access = handles::access(qualifiers);
        // `readonly` on each member is as good as on the block (GLSL 4.60 §4.10).
        if block.members.iter().all(|member| member.qualifiers.readonly) {
            access = crate::interface::Access::Read;
        }
        let name = block.instance.unwrap_or(block.name);
        let resource = Resource {
            name: name.text.into(),
            group: number(reader, qualifiers, "set"),
            binding: number(reader, qualifiers, "binding"),
            location: None,
            kind: ResourceKind::Buffer(space, access),
            count: dimensions(reader, &block.dims),
            span: block.name.span,
        };
        let at = self.interface.resources.len();
        self.interface.resources.push(resource);
        match &block.instance {
            Some(instance) => drop(self.names.insert(instance.text, at)),
            None => {
                let members = block.members.iter().flat_map(|member| &member.names);
                self.names.extend(members.map(|member| (member.name.text, at)));
            }
        }
    }

    fn variables(&mut self, reader: &mut DeclarationReader<'a>, declaration: &Declaration<'a>) {
        let Declaration { qualifiers, ty, names, broken, .. } = declaration;
        if *broken {
            return;
        }
        if qualifiers.constant && qualifiers.find("constant_id").is_some() {
            let id = number(reader, qualifiers, "constant_id");
            let scalar = match ty.base_name().and_then(builtin) {
                Some(Builtin::Data(Type::Scalar(scalar))) => Some(scalar),
                _ => None,
            };
            self.interface.constants.extend(names.iter().map(|declarator| SpecConstant {
                name: declarator.name.text.into(),
                id,
                scalar,
                // GLSL demands an initialiser.
                has_default: true,
                span: declarator.name.span,
            }));
        }
        if qualifiers.storage != Storage::Uniform || qualifiers.subroutine {
            return;
        }
        let [group, binding, location] =
            ["set", "binding", "location"].map(|key| number(reader, qualifiers, key));
        let kinds = handles_of(reader, ty.base_name(), declaration);
        for declarator in names {
            let mut count = dimensions(reader, &declarator.dims);
            count.extend(dimensions(reader, &ty.dims));
            // A structure of handles is a resource for each handle, `s.a`, `s.b`; the name in the
            // text is `s`.
            for (path, kind) in &kinds {
                let at = self.interface.resources.len();
                self.interface.resources.push(Resource {
                    name: format!("{}{path}", declarator.name.text).into(),
                    group,
                    binding,
                    location,
                    kind: kind.clone(),
                    count: count.clone(),
                    span: declarator.name.span,
                });
                self.names.insert(declarator.name.text, at);
            }
        }
    }
}

/// The handles in a type, with their paths from a variable of it.
fn handles_of<'a>(
    reader: &DeclarationReader<'a>,
    name: Option<&'a str>,
    declaration: &Declaration<'a>,
) -> Vec<(String, ResourceKind)> {
    let Some(name) = name else { return Vec::new() };
    match (builtin(name), reader.types.get(name)) {
        (Some(Builtin::Opaque), _) => {
            vec![(String::new(), handles::kind(name, &declaration.qualifiers))]
        }
        // The types of handles in a structure are not kept with it.
        (None, Some(Named::Struct(structure))) => {
            structure.opaque.iter().map(|m| (format!(".{m}"), ResourceKind::Other)).collect()
        }
        _ => Vec::new(),
    }
}

fn dimensions<'a>(reader: &mut DeclarationReader<'a>, dims: &[Dim<'a>]) -> Vec<ArrayLen> {
    dims.iter()
        .map(|dim| match dim.tokens.is_empty() {
            true => ArrayLen::Runtime,
            false => {
                let size = reader.constant_integer(&dim.tokens, dim.span).ok();
                size.and_then(|n| u32::try_from(n).ok()).map_or(ArrayLen::Runtime, ArrayLen::Fixed)
            }
        })
        .collect()
}

fn vertex_inputs<'a>(reader: &mut DeclarationReader<'a>, items: &[Item<'a>]) -> Vec<Input> {
    let mut inputs = Vec::new();
    for item in items {
        let Item::Variables(declaration) = item else { continue };
        let Declaration { qualifiers, ty, names, .. } = &**declaration;
        if qualifiers.storage != Storage::In {
            continue;
        }
        // Inputs of a vertex shader have no structures and no blocks (GLSL 4.60 §4.3.4).
        let Some(Builtin::Data(base)) = ty.base_name().and_then(builtin) else { continue };
        let location = number(reader, qualifiers, "location");
        for declarator in names {
            if declarator.name.text.starts_with("gl_") {
                continue;
            }
            let mut dims = dimensions(reader, &declarator.dims);
            dims.extend(dimensions(reader, &ty.dims));
            let ty = dims
                .into_iter()
                .rev()
                .fold(base.clone(), |element, len| Type::Array { element: Arc::new(element), len });
            let span = declarator.name.span;
            inputs.push(Input { name: declarator.name.text.into(), location, ty, span });
        }
    }
    inputs
}

/// The names that functions and global initialisers use.
// By names, without overloads: a function counts as used if one of its name is. So more may be
// reported as used than is, never less.
#[derive(Default)]
struct UseGraph<'a> {
    /// Of functions, all of one name together.
    functions: FxHashMap<&'a str, FxHashSet<&'a str>>,
    /// Of global initialisers, which run before `main`.
    globals: FxHashSet<&'a str>,
    /// Textures with the samplers they are combined with.
    pairs: Vec<(&'a str, &'a str)>,
    main: Option<Span>,
}

impl<'a> UseGraph<'a> {
    fn item(&mut self, item: &Item<'a>) {
        let mut used = FxHashSet::default();
        let pairs = &mut self.pairs;
        let mut scopes = Scopes::new(|one: Use<'_, 'a>| match one {
            Use::Name(name) | Use::Call(name) => drop(used.insert(name)),
            Use::Construct([texture, sampler]) => {
                pairs.extend(texture.root().zip(sampler.root()));
            }
            Use::Construct(..) => {}
        });
        match item {
            Item::Variables(declaration) => {
                scopes.declaration(declaration);
                self.globals.extend(used);
            }
            Item::Function(function) => {
                scopes.function(function);
                if function.name.text == "main" && function.body.is_some() {
                    self.main = Some(function.name.span);
                }
                self.functions.entry(function.name.text).or_default().extend(used);
            }
            _ => {}
        }
    }

    /// A declaration that cannot be parsed uses every name in it.
    fn unread(&mut self, reader: &DeclarationReader<'a>, item: &Item<'a>) {
        if let Item::Function(function) = item {
            let tokens = &reader.parser.tokens()[function.tokens.clone()];
            let names = tokens.iter().map(|token| token.text);
            self.functions.entry(function.name.text).or_default().extend(names);
            if function.name.text == "main" {
                self.main = Some(function.name.span);
            }
        }
    }

    /// The names that are used from `main`.
    fn reached(&self) -> FxHashSet<&'a str> {
        let first = self.globals.iter().copied().chain(["main"]);
        reached(first, |name| self.functions.get(name).into_iter().flatten().copied())
    }
}
