//! The command line of Ambidex.

fn main() {}
