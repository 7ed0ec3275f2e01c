//! The command `cr7`. The library holds it, so that what both use is compiled once.

fn main() -> std::process::ExitCode {
    robot_cr7::command_line()
}
