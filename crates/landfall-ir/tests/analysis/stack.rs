//! Deep recursion, on this thread or on one with a large stack.

use std::thread;

use landfall_ir::stack::{StackError, on_a_large_stack, spawn_alike};

/// Uses a kilobyte of stack for each level.
fn deep(levels: usize) -> usize {
    let frame = std::hint::black_box([levels; 128]);
    if levels == 0 { 0 } else { 1 + deep(levels - 1) + frame[127] - levels }
}

/// Whether this thread has a large stack, so that work stays on it.
fn is_large() -> bool {
    on_a_large_stack(|| thread::current().id()).unwrap() == thread::current().id()
}

#[test]
fn a_large_stack_is_entered_once_and_inherited() {
    let levels = 60_000;
    let here = thread::current().id();
    let (outer, inner, child) = on_a_large_stack(|| {
        assert_eq!(deep(levels), levels);
        let inner = on_a_large_stack(|| thread::current().id()).unwrap();
        let child = thread::scope(|scope| {
            spawn_alike(scope, || (deep(levels), is_large())).unwrap().join().unwrap()
        });
        (thread::current().id(), inner, child)
    })
    .unwrap();
    assert!(outer != here && inner == outer);
    assert_eq!(child, (levels, true));
    let usual = thread::scope(|scope| spawn_alike(scope, is_large).unwrap().join().unwrap());
    assert!(!usual);
}

#[test]
fn a_panic_is_an_error_on_either_kind_of_thread() {
    let panics = || on_a_large_stack(|| -> () { panic!("expected by this test") });
    assert!(matches!(panics(), Err(StackError::Panic(_))));
    assert!(matches!(on_a_large_stack(panics), Ok(Err(StackError::Panic(_)))));
}
