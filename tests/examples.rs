//! Tests that the Rust examples run without an error, as `cargo run --example NAME` runs them.

#[path = "../examples/certify_motion.rs"]
mod certify_motion;
#[path = "../examples/changing_world.rs"]
mod changing_world;
#[path = "../examples/check_batch.rs"]
mod check_batch;
#[path = "../examples/check_state.rs"]
mod check_state;
#[path = "../examples/check_trajectory.rs"]
mod check_trajectory;
#[path = "../examples/leave_shelf.rs"]
mod leave_shelf;

#[test]
fn all_run() {
    for (name, run) in [
        ("certify_motion", certify_motion::main as fn() -> _),
        ("changing_world", changing_world::main),
        ("check_batch", check_batch::main),
        ("check_state", check_state::main),
        ("check_trajectory", check_trajectory::main),
        ("leave_shelf", leave_shelf::main),
    ] {
        println!("{name}");
        run().unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}
