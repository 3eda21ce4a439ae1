//! Every backend there is. One that is missing fails the test: it is never skipped.

use std::cell::RefCell;

use landfall_exec::backend::Backend;
use landfall_exec::backend::gl::Gl;
use landfall_exec::backend::wgpu::Gpu;
use landfall_interp::Cpu;

thread_local! {
    // Never closed: drivers use thread-local storage of their own when they are.
    static OPEN: &'static RefCell<Vec<Box<dyn Backend>>> =
        Box::leak(Box::new(RefCell::new(backends())));
}

/// Gives all backends, opened once a thread, to somebody.
pub fn with_readers<T>(ask: impl FnOnce(&mut [Box<dyn Backend>]) -> T) -> T {
    OPEN.with(|backends| ask(&mut backends.borrow_mut()))
}

fn backends() -> Vec<Box<dyn Backend>> {
    let gl = Gl::open().expect("an OpenGL driver: apt-get install libegl1 libgl1-mesa-dri");
    let gpu = Gpu::open(&landfall_exec::backend::wgpu::AdapterChoice::default())
        .expect("a Vulkan driver: apt-get install libvulkan1 mesa-vulkan-drivers");
    vec![Box::new(Cpu::new(Default::default())), Box::new(gl), Box::new(gpu)]
}
