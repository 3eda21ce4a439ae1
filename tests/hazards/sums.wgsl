// WGSL has no `precise`: an implementation may reassociate the compensation away.

fn contribution(i: i32, bright: f32, dim: f32) -> f32 {
    return select(dim, bright, i == 0);
}

fn compensated(bright: f32, dim: f32) -> f32 {
    var sum = 0.0;
    var lost = 0.0;
    for (var i = 0; i < 1024; i++) {
        let next = contribution(i, bright, dim) - lost;
        let total = sum + next;
        lost = (total - sum) - next;
        sum = total;
    }
    return sum;
}
