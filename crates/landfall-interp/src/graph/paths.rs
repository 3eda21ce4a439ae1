//! The registers along one path, and the paths that leave a construct.

use std::rc::Rc;

use super::super::code::Class;
use super::node::{GuardId, NodeId};

/// The values of all registers, by class; copied where paths part.
#[derive(Clone, Debug)]
pub(super) struct State {
    files: [Rc<Vec<NodeId>>; 3],
}

impl State {
    pub fn new(files: [Vec<NodeId>; 3]) -> State {
        State { files: files.map(Rc::new) }
    }

    pub fn get(&self, class: Class, reg: u32) -> NodeId {
        self.files[class as usize][reg as usize]
    }

    pub fn set(&mut self, class: Class, reg: u32, to: NodeId) {
        if self.get(class, reg) != to {
            Rc::make_mut(&mut self.files[class as usize])[reg as usize] = to;
        }
    }

    /// Returns the registers in which two states differ.
    pub fn differences(&self, other: &State) -> Vec<(Class, u32)> {
        let mut all = Vec::new();
        for class in [Class::Real, Class::Word, Class::Wide] {
            let (a, b) = (&self.files[class as usize], &other.files[class as usize]);
            if Rc::ptr_eq(a, b) {
                continue;
            }
            let differ = a.iter().zip(b.iter()).enumerate().filter(|(_, (a, b))| a != b);
            all.extend(differ.map(|(reg, _)| (class, reg as u32)));
        }
        all
    }
}

/// A path that is still followed: its branches, and its registers.
#[derive(Clone, Debug)]
pub(super) struct Path {
    pub guard: GuardId,
    pub state: State,
}

/// The paths that left a construct early.
#[derive(Debug, Default)]
pub(super) struct Exits {
    pub returns: Vec<Path>,
    pub breaks: Vec<Path>,
    pub continues: Vec<Path>,
}
