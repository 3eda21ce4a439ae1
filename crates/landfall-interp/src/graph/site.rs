//! The operations of a [`Graph`] that can break.

use super::super::program::Program;
use super::super::undefined::UndefinedKind as K;
use super::fault::faults_of;
use super::guard::{ALWAYS, Guard};
use super::node::{NodeId, NodeOp};
use super::{Fault, Graph, Site};
use landfall_layout::source::Language;

impl Graph {
    /// Lists the operations that can break, one for each fault and place in the text.
    pub(super) fn find_sites(&mut self, program: &Program) {
        let mut sites: Vec<Site> = Vec::new();
        let reaches = self.reaches();
        let reach = |ids: &[NodeId]| -> Vec<usize> {
            ids.iter().flat_map(|&id| &reaches[id as usize]).copied().collect()
        };
        for (id, node) in self.nodes.iter().enumerate() {
            for &fault in faults_of(node.act) {
                let operands = self.operands(node);
                if fault == Fault::Cancellation && operands.iter().all(|&id| self.is_exact(id)) {
                    continue;
                }
                // WGSL defines what GLSL does not.
                let negative = Fault::Undefined(K::RemainderOfNegative);
                if fault == negative && program.language == Language::Wgsl {
                    continue;
                }
                let place = program.place(program.origins[node.pc as usize]);
                let mut inputs = reach(match fault {
                    Fault::Undefined(kind) => kind.deciding(operands),
                    _ => operands,
                });
                let mut guard = node.guard;
                // Whether the operation is reached depends on the conditions around it.
                while guard != ALWAYS {
                    let Guard { parent, cond, .. } = self.guards[guard as usize];
                    inputs.extend(&reaches[cond as usize]);
                    guard = parent;
                }
                inputs.sort_unstable();
                inputs.dedup();
                sites.push(Site { fault, place, inputs, node: id as NodeId });
            }
        }
        self.sites = sites;
        self.find_correlated(&reaches);
    }

    /// Returns the inputs that each value is computed from.
    fn reaches(&self) -> Vec<Vec<usize>> {
        let mut all: Vec<Vec<usize>> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let mut mine = Vec::new();
            if let NodeOp::Input(n) = node.act {
                mine.push(n as usize);
            }
            for &id in self.operands(node) {
                mine.extend(&all[id as usize]);
            }
            mine.sort_unstable();
            mine.dedup();
            all.push(mine);
        }
        all
    }
}
