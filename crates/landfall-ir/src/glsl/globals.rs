//! Lowers declarations outside functions: types, constants, blocks, uniforms, variables.

use std::rc::Rc;

use naga::{Handle, MemoryDecorations, ResourceBinding};

use super::ast::*;
use super::block_types::BlockType;
use super::constant::{Const, converted, evaluate};
use super::io::StageVariable;
use super::types::{Field, Kind, Structure, Ty, holds_values};
use super::value_types::builtin;
use super::{Lowerer, Lowering, refuse};
use landfall_layout::diagnostic::Diagnostic;
use landfall_layout::source::{Span, Stage};

/// The most values in a structure, which bounds the memory for hostile texts.
const MAX_LEAVES: u64 = 1 << 20;

#[derive(Clone, Debug)]
pub enum Global<'a> {
    /// A variable.
    Variable { handle: Handle<naga::GlobalVariable>, ty: Ty, writable: bool },
    /// A `shared` variable that atomic functions change.
    Shared { handle: Handle<naga::GlobalVariable>, block_type: Rc<BlockType> },
    /// A block with an instance name: its memory.
    Block(usize),
    /// A member of a block without one, or a loose uniform.
    Member { memory: Option<usize>, ty: Ty },
    Constant {
        ty: Ty,
        declaration: Rc<Declaration<'a>>,
        index: usize,
        /// The value it is lowered to, if known.
        value: Option<Const>,
        /// The value in constant expressions, if known.
        known: Option<Const>,
    },
    /// Unsupported: using it is this error.
    Refused(Box<Diagnostic>),
}

/// The memory of a block.
#[derive(Clone, Debug)]
pub struct Memory {
    /// The variables: one, or one per element of an array of blocks.
    pub variables: Vec<Handle<naga::GlobalVariable>>,
    pub dims: Vec<u32>,
    pub block_type: Rc<BlockType>,
    pub structure: Rc<Structure>,
    pub writable: bool,
    /// For a block of words: whether they are stored as vectors of four.
    pub fours: bool,
}

impl<'a> Lowerer<'a> {
    /// Lowers all items but the bodies of functions.
    pub fn items(&mut self, items: &[Item<'a>]) -> Result<(), Vec<Diagnostic>> {
        self.reserve_bindings(items);
        // In order of dependence: bindings that are stated, so that automatic ones avoid them;
        // types and constants; then everything. Structures and constants first: the block of loose
        // uniforms is made of all of them.
        for item in items {
            self.types_of(item);
        }
        for item in items {
            match item {
                Item::Variables(declaration) => {
                    self.variables(declaration);
                    Ok(())
                }
                Item::Block(block) | Item::Interface(block) => {
                    if let Err(why) = self.block(block) {
                        self.refuse_block(block, why);
                    }
                    Ok(())
                }
                Item::Function(function) => self.declare_function(function),
                Item::Defaults(qualifiers) => {
                    self.defaults(qualifiers);
                    Ok(())
                }
                Item::Requalified(..) | Item::Precision(_) | Item::Other(_) => Ok(()),
            }
            .map_err(|d| vec![*d])?;
        }
        Ok(())
    }

    // A block that naga cannot hold is an error only where it is used.
    fn refuse_block(&mut self, block: &BlockDecl<'a>, why: Box<Diagnostic>) {
        let members = block.members.iter().flat_map(|m| &m.names).map(|n| n.name.text);
        let names: Vec<&str> = match &block.instance {
            Some(instance) => vec![instance.text],
            None => members.collect(),
        };
        for name in names {
            self.declare_global(name, Global::Refused(why.clone()));
        }
    }

    pub fn declare_global(&mut self, name: &'a str, global: Global<'a>) {
        self.globals.push(global);
        self.global_names.insert(name, self.globals.len() - 1);
    }

    fn reserve_bindings(&mut self, items: &[Item<'a>]) {
        for item in items {
            let qualifiers = match item {
                Item::Variables(declaration) => &declaration.qualifiers,
                Item::Block(block) | Item::Interface(block) => &block.qualifiers,
                Item::Function(_)
                | Item::Defaults(_)
                | Item::Requalified(..)
                | Item::Precision(_)
                | Item::Other(_) => continue,
            };
            if let Some(binding) = self.layout_number(qualifiers, "binding") {
                let group = self.layout_number(qualifiers, "set").unwrap_or(0);
                self.bindings.reserve(group, binding);
            }
        }
    }

    fn defaults(&mut self, qualifiers: &Qualifiers<'a>) {
        for (axis, name) in ["local_size_x", "local_size_y", "local_size_z"].iter().enumerate() {
            if let Some(size) = self.layout_number(qualifiers, name) {
                self.workgroup_size[axis] = size.max(1);
            }
        }
        self.early_fragment_tests |= qualifiers.find("early_fragment_tests").is_some();
    }

    /// Returns a number in `layout(…)`.
    pub fn layout_number(&self, qualifiers: &Qualifiers<'a>, name: &str) -> Option<u32> {
        // `layout(binding = N + 1)`: constant expressions are allowed (GLSL 4.60 §4.4).
        let value = qualifiers.find(name)?.value.as_ref()?;
        u32::try_from(self.constant(value)?.integer()?).ok()
    }

    pub fn constant(&self, e: &Expr<'a>) -> Option<Const> {
        evaluate(e, &|name| self.constant_named(name))
    }

    pub fn constant_named(&self, name: &str) -> Option<Const> {
        match self.global_names.get(name).map(|&i| &self.globals[i]) {
            Some(Global::Constant { known, .. }) => known.clone(),
            Some(_) => None,
            // Built-in constants, such as `gl_MaxClipDistances`.
            None => self.language_constant(name),
        }
    }

    /// Returns the sizes of dimensions; `None` for `[]`.
    pub fn dims(
        &self,
        dims: &[Dim<'a>],
        constant: &dyn Fn(&Expr<'a>) -> Option<Const>,
    ) -> Lowering<Vec<Option<u32>>> {
        dims.iter()
            .map(|dim| {
                let Some(size) = &dim.size else { return Ok(None) };
                let value = constant(size).and_then(|c| u32::try_from(c.integer()?).ok());
                // Sizes are positive (GLSL 4.60 §4.1.9).
                match value.filter(|&size| size > 0) {
                    Some(size) => Ok(Some(size)),
                    None => Err(refuse(size.span, "the size of an array must be a constant")),
                }
            })
            .collect()
    }

    /// `T[3] a[2]` is an array of 2 arrays of 3 (GLSL 4.60 §4.1.9).
    pub fn arrayed(base: Ty, own: &[Option<u32>], name: &[Option<u32>]) -> Ty {
        // The dimensions of the name are outermost, then those of the type, each from left to
        // right.
        let dims = name.iter().chain(own);
        dims.rev().fold(base, |ty, len| Ty::Array(Rc::new(ty), *len))
    }

    /// Returns the type of a structure's or built-in type's name.
    pub fn named_type(&self, name: &str, span: Span) -> Lowering<Ty> {
        if let Some(ty) = self.structures.get(name) {
            return Ok(ty.clone());
        }
        if let Some(why) = self.broken.get(name) {
            return Err(why.clone());
        }
        builtin(name).ok_or_else(|| refuse(span, format!("unsupported type `{name}`")))
    }

    pub fn global_structure(&self, name: &str) -> Option<&Ty> {
        self.structures.get(name)
    }

    pub fn global_type(&mut self, spec: &TypeSpec<'a>, dims: &[Dim<'a>]) -> Lowering<Ty> {
        let base = match &spec.base {
            TypeBase::Name(name) => self.named_type(name, spec.span)?,
            TypeBase::Struct(declaration) => {
                // The declaration is met twice: once for its types, once for its variables.
                // `struct S { … } a, b;` declares it once.
                let at = (declaration.name.span.file, declaration.name.span.start);
                match self.structures_at.get(&at) {
                    Some(known) => Ty::Struct(known.clone()),
                    None => self.structure(declaration)?,
                }
            }
        };
        let own = self.dims(&spec.dims, &|e| self.constant(e))?;
        let name = self.dims(dims, &|e| self.constant(e))?;
        Ok(Self::arrayed(base, &own, &name))
    }

    /// Declares a structure, with its name in the global scope.
    fn structure(&mut self, declaration: &StructDecl<'a>) -> Lowering<Ty> {
        let ty = self.make_structure(declaration)?;
        if !declaration.name.text.is_empty() {
            self.structures.insert(declaration.name.text, ty.clone());
        }
        Ok(ty)
    }

    pub fn make_structure(&mut self, declaration: &StructDecl<'a>) -> Lowering<Ty> {
        let mut members = Vec::new();
        for member in &declaration.members {
            for declarator in &member.names {
                let ty = self.global_type(&member.ty, &declarator.dims)?;
                let name = declarator.name.text.to_string();
                members.push(Field { name, ty });
            }
        }
        let structure = self.new_structure(declaration.name.text, members);
        if structure.leaves > MAX_LEAVES {
            let message = format!("`{}` contains more than {MAX_LEAVES} values", structure.name);
            return Err(refuse(declaration.name.span, message));
        }
        let at = (declaration.name.span.file, declaration.name.span.start);
        self.structures_at.insert(at, structure.clone());
        Ok(Ty::Struct(structure))
    }

    pub fn new_structure(&mut self, name: &str, members: Vec<Field>) -> Rc<Structure> {
        let id = self.next_structure;
        self.next_structure += 1;
        Rc::new(Structure::new(id, name, members))
    }

    /// Returns the structure that the layout refers to.
    pub fn structure_of(&self, s: &landfall_layout::shape::Struct) -> Option<Rc<Structure>> {
        // The layout knows structures by where their names are in the text; names alone may be
        // declared twice.
        self.structures_at.get(&(s.span.file, s.span.start)).cloned()
    }

    /// An error in a type is reported where the type is used.
    fn types_of(&mut self, item: &Item<'a>) {
        match item {
            Item::Variables(declaration) => {
                if let TypeBase::Struct(structure) = &declaration.ty.base {
                    self.declare_structure(structure);
                }
                if declaration.qualifiers.storage == Storage::Const {
                    self.all_variables(declaration);
                }
            }
            Item::Block(block) | Item::Interface(block) => {
                for member in &block.members {
                    if let TypeBase::Struct(structure) = &member.ty.base {
                        self.declare_structure(structure);
                    }
                }
            }
            Item::Function(_)
            | Item::Defaults(_)
            | Item::Requalified(..)
            | Item::Precision(_)
            | Item::Other(_) => {}
        }
    }

    fn declare_structure(&mut self, declaration: &StructDecl<'a>) {
        if let Err(why) = self.structure(declaration) {
            self.broken.insert(declaration.name.text, why);
        }
    }

    fn variables(&mut self, declaration: &Rc<Declaration<'a>>) {
        if declaration.qualifiers.storage != Storage::Const {
            self.all_variables(declaration);
        }
    }

    fn all_variables(&mut self, declaration: &Rc<Declaration<'a>>) {
        for (index, declarator) in declaration.names.iter().enumerate() {
            let name = declarator.name;
            if name.text.starts_with("gl_") {
                // A redeclaration of a built-in variable, with a size or a qualifier.
                self.redeclared(declarator);
                continue;
            }
            if let Err(why) = self.variable(declaration, index) {
                self.declare_global(name.text, Global::Refused(why));
            }
        }
    }

    // By storage qualifier (GLSL 4.60 §4.3).
    fn variable(&mut self, declaration: &Rc<Declaration<'a>>, index: usize) -> Lowering<()> {
        let declarator = &declaration.names[index];
        let name = declarator.name;
        let mut ty = self.global_type(&declaration.ty, &declarator.dims)?;
        if let Some(init) = &declarator.init {
            let scope: &Lowerer<'a> = self;
            ty = super::construct::sized_by(ty, init, &|e| scope.constant(e));
        }
        let qualifiers = &declaration.qualifiers;
        match qualifiers.storage {
            Storage::Const => {
                let Some(init) = &declarator.init else {
                    return Err(refuse(
                        name.span,
                        format!("constant `{}` has no initialiser", name.text),
                    ));
                };
                // A specialisation constant that is set has its value everywhere; any other
                // constant is known in constant expressions, and lowered as a literal only if no
                // float arithmetic is in it.
                let (value, known) = match self.override_of(qualifiers, name.text, &ty) {
                    Some(value) => (Some(value.clone()), Some(value)),
                    None => {
                        let known = self.constant(init).and_then(|value| Self::typed(value, &ty));
                        (
                            known.clone().and_then(|value| Self::exact_constant(value, init, &ty)),
                            known,
                        )
                    }
                };
                let declaration = declaration.clone();
                let global = Global::Constant { ty, declaration, index, value, known };
                self.declare_global(name.text, global);
                Ok(())
            }
            Storage::Uniform => self.loose_uniform(qualifiers, name, ty),
            Storage::In | Storage::Out => {
                let output = qualifiers.storage == Storage::Out;
                // Compute shaders have built-in inputs alone (GLSL 4.60 §4.3.4).
                if matches!(self.stage, Some(Stage::Compute)) {
                    return Err(refuse(
                        name.span,
                        "a compute shader cannot have inputs or outputs",
                    ));
                }
                let handle = self.private(name.text, &ty, name.span)?;
                let location = self.layout_number(qualifiers, "location");
                let blend = self.layout_number(qualifiers, "index");
                self.io.push(
                    StageVariable::new(name.text, handle, ty.clone(), qualifiers, output)
                        .at(location, blend, name.span),
                );
                self.declare_global(name.text, Global::Variable { handle, ty, writable: output });
                Ok(())
            }
            Storage::Shared => self.shared(name, ty),
            Storage::Plain => {
                let handle = self.private(name.text, &ty, name.span)?;
                self.declare_global(name.text, Global::Variable { handle, ty, writable: true });
                // naga's initialisers are constant expressions; GLSL's need not be (GLSL 4.60
                // §4.3), so the entry point runs them.
                if declarator.init.is_some() {
                    let global = self.globals.len() - 1;
                    self.initialisers.push((global, declaration.clone(), index));
                }
                Ok(())
            }
            Storage::InOut | Storage::Buffer | Storage::Varying | Storage::Foreign => {
                let message =
                    format!("naga does not support the storage qualifier of `{}`", name.text);
                Err(refuse(name.span, message))
            }
        }
    }

    pub fn private(
        &mut self,
        name: &str,
        ty: &Ty,
        span: Span,
    ) -> Lowering<Handle<naga::GlobalVariable>> {
        let ty = self.value_type(ty, span)?;
        Ok(self.variable_in(naga::AddressSpace::Private, name, ty, None, span))
    }

    pub fn variable_in(
        &mut self,
        space: naga::AddressSpace,
        name: &str,
        ty: Handle<naga::Type>,
        at: Option<(u32, u32)>,
        span: Span,
    ) -> Handle<naga::GlobalVariable> {
        let variable = naga::GlobalVariable {
            name: Some(name.to_string()),
            space,
            binding: at.map(|(group, binding)| ResourceBinding { group, binding }),
            ty,
            init: None,
            memory_decorations: MemoryDecorations::empty(),
        };
        self.ir.global_variables.append(variable, self.bases.to_naga(span))
    }

    fn shared(&mut self, name: Name<'a>, ty: Ty) -> Lowering<()> {
        let space = naga::AddressSpace::WorkGroup;
        // An atomic type is part of the memory's type, so it is decided by what atomic functions
        // name.
        let touched = self.atomics.contains(name.text)
            || matches!(&ty, Ty::Struct(s) if s.members.iter().any(|f| self.atomics.contains(&*f.name)));
        if touched {
            let block_type = self.host_of_shared(&ty).ok_or_else(|| {
                refuse(
                    name.span,
                    format!("atomic functions cannot change `{}` as a whole", name.text),
                )
            })?;
            let naga = block_type.naga.expect("shared variables have naga types");
            let handle = self.variable_in(space, name.text, naga, None, name.span);
            self.declare_global(name.text, Global::Shared { handle, block_type });
            return Ok(());
        }
        let value_type = self.value_type(&ty, name.span)?;
        let handle = self.variable_in(space, name.text, value_type, None, name.span);
        self.declare_global(name.text, Global::Variable { handle, ty, writable: true });
        Ok(())
    }

    pub fn typed(value: Const, ty: &Ty) -> Option<Const> {
        match ty {
            Ty::Scalar(kind) => converted(&value, *kind),
            Ty::Vector(..) | Ty::Array(..) => Some(value),
            Ty::Void | Ty::Matrix(..) | Ty::Struct(_) | Ty::Opaque(_) => None,
        }
    }

    /// Returns a constant's value, unless it has to be computed in floats.
    pub fn exact_constant(value: Const, init: &Expr<'a>, ty: &Ty) -> Option<Const> {
        // Float arithmetic of the shader rounds to `f32` at each step, constant expressions here
        // do not.
        match ty {
            Ty::Scalar(Kind::Float) if !matches!(init.kind, ExprKind::Number(_)) => None,
            Ty::Scalar(Kind::Double | Kind::Half | Kind::Short | Kind::Ushort) => None,
            Ty::Vector(kind, _) if !matches!(kind, Kind::Int | Kind::Uint) => None,
            _ => Some(value),
        }
    }

    /// Returns the value of a specialisation constant from `-O`.
    fn override_of(&self, qualifiers: &Qualifiers<'a>, name: &str, ty: &Ty) -> Option<Const> {
        // By name or by number, as `-O` takes either; the last one given counts.
        let id = self.layout_number(qualifiers, "constant_id")?.to_string();
        let given = self.overrides.iter().rev().find(|(key, _)| *key == name || *key == id)?;
        let text = given.1.trim();
        let value = match text {
            "true" => Const::Bool(true),
            "false" => Const::Bool(false),
            _ => match text.parse::<i64>() {
                Ok(whole) => Const::Int(whole as i32),
                Err(_) => Const::Float(text.parse().ok()?),
            },
        };
        converted(&value, ty.kind()?)
    }

    /// Declares a loose uniform: handles become globals, other types members of the default block.
    fn loose_uniform(
        &mut self,
        qualifiers: &Qualifiers<'a>,
        name: Name<'a>,
        ty: Ty,
    ) -> Lowering<()> {
        if qualifiers.subroutine {
            return Err(refuse(name.span, "subroutines are not supported"));
        }
        // A structure may have both: its handles become globals, its values members.
        self.declare_handles(name.text, &ty, qualifiers, name.span)?;
        let memory = if holds_values(&ty) { Some(self.default_block(name)?) } else { None };
        let ty = match memory {
            // An array without a size has the one its layout found.
            Some(memory) => {
                let member = self.memories[memory].structure.member(name.text);
                member.map_or(ty, |member| member.ty.clone())
            }
            None => ty,
        };
        self.declare_global(name.text, Global::Member { memory, ty });
        Ok(())
    }
}
