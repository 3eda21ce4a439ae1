//! Asks the oracles about many blocks: one glslang process for a whole batch,
//! and for the driver as many programs as its limits need. Batches are spread
//! over two threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::blocks::{Block, Space, Standing, print};
use super::driver::{Api, Driver, Limits, Stage};
use super::glslang;
use super::leaf::OracleBlock;

/// Blocks that share one shader text and its default-layout statements.
#[derive(Clone, Debug)]
pub struct Batch {
    /// For messages: the seed, or the place in a list.
    pub name: String,
    pub standing: Vec<Standing>,
    pub blocks: Vec<Block>,
}

impl Batch {
    /// The text that glslang reads; all blocks in one compute shader.
    pub fn text(&self) -> String {
        print(&self.standing, &self.blocks.iter().collect::<Vec<_>>())
    }

    /// The same block alone, for a message.
    pub fn text_of(&self, block: &str) -> String {
        let alone: Vec<&Block> = self.blocks.iter().filter(|b| b.name == block).collect();
        print(&self.standing, &alone)
    }
}

/// What glslang says of every block of the batch. Its refusal is the
/// generator's fault: every block made is legal.
pub fn ask_glslang(batch: &Batch) -> Vec<OracleBlock> {
    let options = glslang::Options { target_env: Some("vulkan1.2"), ..Default::default() };
    let text = batch.text();
    glslang::blocks(&text, "comp", &options)
        .unwrap_or_else(|e| panic!("glslang refuses batch {}:\n{e}\n{text}", batch.name))
}

/// What the driver says of the blocks of the batch that `wanted` picks, and
/// which blocks it refuses, with its log.
pub fn ask_driver(
    driver: &Driver,
    batch: &Batch,
    wanted: impl Fn(&Block) -> bool,
) -> (Vec<OracleBlock>, Vec<(String, String)>) {
    let blocks: Vec<&Block> = batch.blocks.iter().filter(|b| wanted(b)).collect();
    let (mut answers, mut refused) = (Vec::new(), Vec::new());
    for program in pack(&blocks, driver.limits) {
        match ask(driver, batch, &program) {
            Ok(found) => answers.extend(found),
            // One by one, to find the block at fault.
            Err(_) => {
                for block in program {
                    match ask(driver, batch, &[block]) {
                        Ok(found) => answers.extend(found),
                        Err(log) => refused.push((block.name.clone(), log)),
                    }
                }
            }
        }
    }
    (answers, refused)
}

fn ask(driver: &Driver, batch: &Batch, blocks: &[&Block]) -> Result<Vec<OracleBlock>, String> {
    driver.blocks(&[(Stage::Compute, &print(&batch.standing, blocks))])
}

/// Programs filled up to the driver's limits; the elements of an array of
/// blocks count one by one.
fn pack<'b>(blocks: &[&'b Block], limits: Limits) -> Vec<Vec<&'b Block>> {
    let mut programs = vec![Vec::new()];
    let (mut uniform, mut storage) = (0, 0);
    for &block in blocks {
        let count = block.count.unwrap_or(1) as usize;
        let (uniforms, storages) = match block.space {
            Space::Uniform | Space::PushConstant => (count, 0),
            Space::Buffer => (0, count),
        };
        if uniform + uniforms > limits.uniform_blocks || (storage > 0 && storages > 0) {
            programs.push(Vec::new());
            (uniform, storage) = (0, 0);
        }
        uniform += uniforms;
        storage += storages;
        programs.last_mut().expect("never empty").push(block);
    }
    programs
}

/// Calls `judge` with every number below `batches`, two at a time, each
/// thread with a driver of its own, and collects what it returns.
pub fn spread<B: Sync, T: Send>(
    batches: &[B],
    judge: impl Fn(&Driver, &B) -> Vec<T> + Sync,
) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let found = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        let work = || {
            let driver = Driver::open(Api::Gl);
            loop {
                let at = next.fetch_add(1, Ordering::Relaxed);
                let Some(batch) = batches.get(at) else { return };
                let some = judge(&driver, batch);
                found.lock().expect("no other thread panicked").extend(some);
            }
        };
        let second = scope.spawn(work);
        work();
        if let Err(panic) = second.join() {
            std::panic::resume_unwind(panic);
        }
    });
    found.into_inner().expect("no thread panicked")
}
