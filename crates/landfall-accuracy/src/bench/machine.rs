//! The machine of a measurement and its load.

use serde::{Deserialize, Serialize};

/// A machine and its load.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Machine {
    /// The processor's name, where the system reports it.
    pub processor: Option<String>,
    /// The number of hardware threads.
    pub threads: u32,
    /// The operating system and architecture.
    pub system: String,
    /// The load average of the last minute before and after, where the system reports it.
    pub load: Option<[f64; 2]>,
    /// Whether this program was compiled with optimisation.
    pub optimised: bool,
}

impl Machine {
    /// Returns this machine with its current load.
    pub fn here() -> Machine {
        let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let named = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
        Machine {
            processor: named.map(|(_, name)| name.trim().to_string()),
            threads: std::thread::available_parallelism().map_or(1, |n| n.get() as u32),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            load: load().map(|now| [now, now]),
            optimised: !cfg!(debug_assertions),
        }
    }

    /// Sets the load after the measurement to the current one.
    pub fn after(self) -> Machine {
        let load = self.load.and_then(|[before, _]| Some([before, load()?]));
        Machine { load, ..self }
    }
}

/// Returns the load average of the last minute.
fn load() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/loadavg").ok()?;
    text.split_whitespace().next()?.parse().ok()
}
