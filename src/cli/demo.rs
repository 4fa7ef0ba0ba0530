use super::failure::Failure;
pub fn run(_: log::LevelFilter) -> Result<std::process::ExitCode, Failure> { Ok(std::process::ExitCode::SUCCESS) }
