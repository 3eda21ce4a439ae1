//! Options of every command that limit its time and memory.

use std::time::Duration;

/// Limit of memory in MiB without `--max-memory`.
const MEMORY: u64 = 8192;

/// The limits of a command.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Time and memory")]
pub struct BudgetArgs {
    /// End with exit code 2 after this time, in seconds [default: 3600; for `stress` at least twice
    /// its --time]
    #[arg(long, global = true, value_name = "SECONDS", value_parser = seconds)]
    pub max_time: Option<Duration>,
    /// End with exit code 2 if this process and those it starts need more memory, in MiB (Linux; measured
    /// every 60 ms)
    #[arg(long, global = true, value_name = "MIB", default_value_t = MEMORY,
          value_parser = clap::value_parser!(u64).range(1..))]
    pub max_memory: u64,
}

/// The longest time limit, about thirty years: clocks can add it without overflow.
const LONGEST: Duration = Duration::from_secs(1_000_000_000);

/// Parses a time limit in seconds.
pub fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "a limit is a number of seconds".to_string())?;
    match Duration::try_from_secs_f64(seconds) {
        Ok(limit) if !limit.is_zero() && limit <= LONGEST => Ok(limit),
        Ok(_) | Err(_) => Err(format!("a limit is above 0 and up to {} s", LONGEST.as_secs())),
    }
}
