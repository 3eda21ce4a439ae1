//! Every reader there is. One that is missing fails the test: it is never skipped.

use std::cell::RefCell;

use landfall_exec::backend::Reader;
use landfall_exec::backend::gl::Gl;
use landfall_exec::backend::wgpu::Gpu;
use landfall_exec::interp::Cpu;

thread_local! {
    // Never closed: drivers use thread-local storage of their own when they are.
    static OPEN: &'static RefCell<Vec<Box<dyn Reader>>> =
        Box::leak(Box::new(RefCell::new(readers())));
}

/// Gives all readers, opened once a thread, to somebody.
pub fn with_readers<T>(ask: impl FnOnce(&mut [Box<dyn Reader>]) -> T) -> T {
    OPEN.with(|readers| ask(&mut readers.borrow_mut()))
}

fn readers() -> Vec<Box<dyn Reader>> {
    let gl = Gl::open().expect("an OpenGL driver: apt-get install libegl1 libgl1-mesa-dri");
    let gpu = Gpu::open(&landfall_exec::backend::wgpu::Choice::default())
        .expect("a Vulkan driver: apt-get install libvulkan1 mesa-vulkan-drivers");
    vec![Box::new(Cpu::new(Default::default())), Box::new(gl), Box::new(gpu)]
}
