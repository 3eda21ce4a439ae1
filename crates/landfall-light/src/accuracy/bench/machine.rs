//! Where it was measured: a number without that is no measurement.

use serde::{Deserialize, Serialize};

/// The machine and how busy it was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// What its processor calls itself, where the system says.
    pub processor: Option<String>,
    /// Threads it runs at once.
    pub threads: u32,
    /// Operating system and architecture.
    pub system: String,
    /// The load average of the last minute, before and after, where the system says.
    pub load: Option<[f64; 2]>,
    /// Whether the program that measured was compiled with optimisation.
    pub optimised: bool,
}

impl Machine {
    /// This one, its load as it is now.
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

    /// The same, with the load as it is now for the end.
    pub fn after(self) -> Machine {
        let load = self.load.and_then(|[before, _]| Some([before, load()?]));
        Machine { load, ..self }
    }
}

/// Programs that ran or waited to, on average over the last minute.
fn load() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/loadavg").ok()?;
    text.split_whitespace().next()?.parse().ok()
}
