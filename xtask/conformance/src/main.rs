//! Prints the reports of all scenes.
#![allow(clippy::print_stdout, reason = "a command prints what it finds")]

fn main() {
    for named in conformance::scenes() {
        for line in conformance::report(named) {
            println!("{line}");
        }
    }
}
