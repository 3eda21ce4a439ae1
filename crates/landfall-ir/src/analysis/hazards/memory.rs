//! Variables and parts of values: the nodes that pointers refer to.

use naga::{Handle, TypeInner};

use super::graph::{GraphOp, Id, Leaf, Origin};
use super::walk::Walk;
use super::{Access, IndexBound};
use landfall_layout::source::Span;

/// A value, or the path to a variable.
#[derive(Clone, Debug)]
pub enum Value {
    Is(Id),
    /// A variable that the shader declares.
    At(usize, Vec<Projection>),
}

/// A step into a variable.
#[derive(Clone, Copy, Debug)]
pub enum Projection {
    Part(u32),
    Element(Id),
}

impl Walk<'_> {
    pub fn load(&mut self, value: &Value, span: Option<Span>) -> Id {
        match value {
            Value::Is(id) => *id,
            Value::At(cell, steps) => {
                let mut id = self.cells[*cell];
                for step in steps {
                    id = match *step {
                        Projection::Part(index) => self.part(id, index),
                        Projection::Element(index) => self.element(id, index, span),
                    };
                }
                id
            }
        }
    }

    pub fn store(&mut self, pointer: &Value, value: Id) {
        // What is stored in a block is not followed.
        let Value::At(cell, steps) = pointer else { return };
        let before = self.cells[*cell];
        self.cells[*cell] = self.replaced(before, steps, value);
    }

    fn replaced(&mut self, whole: Id, steps: &[Projection], value: Id) -> Id {
        let Some((first, rest)) = steps.split_first() else { return value };
        // An element at an index that is not known may be any: the whole becomes unknown, but
        // still depends on what was stored.
        match *first {
            Projection::Part(index) => {
                let part = self.part(whole, index);
                let part = self.replaced(part, rest, value);
                self.graph.add(GraphOp::Insert(index), &[whole, part])
            }
            Projection::Element(_) => self.graph.opaque(&[whole, value]),
        }
    }

    /// Returns a member or component of a value.
    pub fn part(&mut self, mut id: Id, index: u32) -> Id {
        // Through insertions of other parts, down to the one of this part or to what was there
        // before.
        loop {
            let args = self.graph.args(id);
            match (self.graph.op(id), args) {
                // A number stands for a vector of equal components; parts of nothing are nothing.
                (GraphOp::Number(_) | GraphOp::Undefined(_), _) => return id,
                (GraphOp::Insert(own), &[_, value]) if own == index => return value,
                (GraphOp::Insert(_), &[whole, _]) => id = whole,
                // Only where argument `n` is component `n`.
                (GraphOp::Compose, args) if self.whole_parts.contains(&id) => {
                    match args.get(index as usize) {
                        Some(&part) => return part,
                        None => return self.graph.add(GraphOp::Part(index), &[id]),
                    }
                }
                (GraphOp::Leaf(_), _) => return self.part_of_leaf(id, index),
                _ => return self.graph.add(GraphOp::Part(index), &[id]),
            }
        }
    }

    fn part_of_leaf(&mut self, id: Id, index: u32) -> Id {
        let Some(leaf) = self.graph.as_leaf(id).cloned() else { return id };
        match &self.ir.types[leaf.ty].inner {
            TypeInner::Struct { members, .. } => {
                let Some(member) = members.get(index as usize) else { return id };
                let name = member.name.clone().unwrap_or_default();
                let origin = match &member.binding {
                    Some(binding) => self.origin(binding),
                    None => leaf.origin,
                };
                let ty = member.ty;
                // The key tells leaves apart, the path is printed: indices are in the first alone.
                let key = format!("{}.{name}", leaf.key);
                let dot = if leaf.path.is_empty() { "" } else { "." };
                let path = format!("{}{dot}{name}", leaf.path);
                let light = leaf.light.clone().map(|(light, way)| {
                    let dot = if way.is_empty() { "" } else { "." };
                    (light, format!("{way}{dot}{name}"))
                });
                self.leaf(Leaf { key, path, name, ty, origin, light, ..leaf })
            }
            TypeInner::Array { .. } => {
                let index = self.graph.number(f64::from(index));
                self.element(id, index, None)
            }
            _ => self.graph.add(GraphOp::Part(index), &[id]),
        }
    }

    /// Returns an element of a value; `span` is the access.
    pub fn element(&mut self, id: Id, index: Id, span: Option<Span>) -> Id {
        // A constant index into a vector or a structure is a component, not an element.
        if let Some(number) = self.graph.value(index) {
            let is_array = self.graph.as_leaf(id).is_some_and(|leaf| {
                matches!(self.ir.types[leaf.ty].inner, TypeInner::Array { .. })
            });
            if !is_array {
                return self.part(id, number as u32);
            }
        }
        let Some(leaf) = self.graph.as_leaf(id).cloned() else {
            return self.graph.add(GraphOp::Element, &[id, index]);
        };
        let TypeInner::Array { base, .. } = self.ir.types[leaf.ty].inner else {
            return self.graph.add(GraphOp::Element, &[id, index]);
        };
        let key = match self.graph.value(index) {
            Some(number) => format!("{}[{number}]", leaf.key),
            // By the node of the index: `lights[i]` twice in an iteration is one leaf, `lights[j]`
            // another.
            None => format!("{}[#{index}]", leaf.key),
        };
        let path = format!("{}[]", leaf.path);
        let light = leaf.light.clone().map(|(light, way)| (light, format!("{way}[]")));
        let made = self.leaf(Leaf { key, path, ty: base, light, ..leaf });
        self.note_access(made, index, span);
        made
    }

    /// Adds a leaf with its light and role.
    pub fn leaf(&mut self, mut leaf: Leaf) -> Id {
        if leaf.light.is_none() {
            leaf.light = self.light_of(&leaf);
        }
        // The light's member that the path from the light leads to has the role.
        leaf.role = leaf.light.as_ref().and_then(|(light, way)| {
            let parts = &self.lights[*light].roles.parts;
            parts.iter().find(|part| part.path == *way).map(|part| part.role)
        });
        self.graph.leaf(leaf)
    }

    fn light_of(&self, leaf: &Leaf) -> Option<(usize, String)> {
        let block = leaf.block.map(|block| &self.module.blocks[block].layout);
        if let Some(block) = block {
            // In the block where the binding was found; uniforms outside of blocks belong to one
            // without a name of its own.
            let here = |light: &&crate::analysis::roles::LightBinding<'_>| {
                let same = light.block.name == block.name
                    || light.block.space == landfall_layout::shape::AddressSpace::Default;
                same && light.path == leaf.path
            };
            if let Some(found) = self.lights.iter().position(|light| here(&light)) {
                return Some((found, String::new()));
            }
        }
        // A parameter or variable of the light's structure is a light, too: functions take `Light
        // light`.
        let name = self.ir.types[leaf.ty].name.as_deref()?;
        let named = |light: &crate::analysis::roles::LightBinding<'_>| {
            *light.roles.name == *name && light.form == crate::analysis::roles::Form::Structure
        };
        Some((self.lights.iter().position(named)?, String::new()))
    }

    /// Records the index of an access to an array of lights.
    fn note_access(&mut self, element: Id, index: Id, span: Option<Span>) {
        let (Some(span), Some(leaf)) = (span, self.graph.as_leaf(element)) else { return };
        let Some((light, way)) = leaf.light.clone() else { return };
        // An access to a light itself, not to a member of one that was accessed already.
        let is_light = way.is_empty() || way.ends_with("[]");
        if !is_light || self.lights[light].dims.is_empty() {
            return;
        }
        let bound = self.bound(light, index);
        self.accesses.push((index, Access { light, bound, span }));
    }

    fn bound(&self, light: usize, index: Id) -> IndexBound {
        if let Some(number) = self.graph.value(index) {
            return IndexBound::Fixed(number.max(0.0) as u64);
        }
        let index = self.through(index);
        // The conditions that hold here and have the index on their smaller side: `i < count`, `i
        // < 16`. The loop's own condition is among them, as is a guard inside of it.
        let (mut constant, mut count, mut clamped, mut length) = (None, false, false, false);
        for &(a, b) in &self.relations {
            if self.through(a) != index {
                continue;
            }
            let limit = self.through(b);
            if let Some(number) = self.graph.value(limit) {
                let number = number.max(0.0) as u64;
                constant = Some(constant.map_or(number, |known: u64| known.min(number)));
            } else if self.is_count(light, limit) {
                count = true;
            } else if self.graph.contains(limit, &mut |id| self.is_count(light, id)) {
                // `min(count, 16)` has an upper bound; `count - 1` or `int(count)` has none.
                count = true;
                clamped |= self.facts(limit).high.is_finite();
            } else if self.graph.as_leaf(limit).is_some_and(|leaf| leaf.key.ends_with(".length()"))
            {
                length = true;
            }
        }
        match (count, constant) {
            (true, Some(_)) => IndexBound::ClampedCount,
            (true, None) if clamped => IndexBound::ClampedCount,
            (true, None) => IndexBound::Count,
            (false, Some(number)) => IndexBound::Constant(number),
            (false, None) if length => IndexBound::Length,
            (false, None) => IndexBound::Unknown,
        }
    }

    /// Returns the value without its conversions.
    fn through(&self, mut id: Id) -> Id {
        while let (GraphOp::Convert, &[of]) = (self.graph.op(id), self.graph.args(id)) {
            id = of;
        }
        id
    }

    fn is_count(&self, light: usize, id: Id) -> bool {
        let Some(count) = &self.lights[light].count else { return false };
        let leaf = self.graph.as_leaf(id);
        leaf.is_some_and(|leaf| leaf.path == *count.member.name && leaf.block.is_some())
    }

    /// Returns the origin of an input: whether it is interpolated.
    pub fn origin(&self, binding: &naga::Binding) -> Origin {
        match binding {
            naga::Binding::Location { interpolation, .. }
                if self.in_fragment && *interpolation != Some(naga::Interpolation::Flat) =>
            {
                Origin::Interpolated
            }
            _ => Origin::Other,
        }
    }

    /// Adds a leaf of a type.
    pub fn outside(&mut self, name: &str, ty: Handle<naga::Type>, origin: Origin) -> Id {
        let fresh = self.graph.next();
        let key = format!("{name}#{fresh}");
        let (path, name) = (name.to_string(), name.to_string());
        self.leaf(Leaf { key, path, name, ty, origin, block: None, light: None, role: None })
    }
}
