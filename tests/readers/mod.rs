//! Every reader there is. One that is missing fails the test: it is never skipped.

use landfall::run::eval::Cpu;
use landfall::run::gl::Gl;
use landfall::run::gpu::Gpu;
use landfall::run::reader::Reader;

pub fn readers() -> Vec<Box<dyn Reader>> {
    let gl = Gl::open().expect("an OpenGL driver: apt-get install libegl1 libgl1-mesa-dri");
    let gpu = Gpu::open(&landfall::run::gpu::Choice::default())
        .expect("a Vulkan driver: apt-get install libvulkan1 mesa-vulkan-drivers");
    vec![Box::new(Cpu::new(Default::default())), Box::new(gl), Box::new(gpu)]
}
