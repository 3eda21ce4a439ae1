//! Every reader there is. One that is missing fails the test: it is never skipped.

use landfall::run::gl::Gl;
use landfall::run::reader::Reader;

pub fn readers() -> Vec<Box<dyn Reader>> {
    let gl = Gl::open().expect("an OpenGL driver: apt-get install libegl1 libgl1-mesa-dri");
    vec![Box::new(gl)]
}
