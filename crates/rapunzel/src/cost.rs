//! What a run has taken of the computer.

use rapunzel_sim::ContactTimes;
use std::time::Duration;

/// The steps that this process has taken.
#[derive(Default)]
pub(crate) struct Steps {
    pub(crate) taken: u64,
    pub(crate) times: ContactTimes,
}

impl Steps {
    /// What a step took, s, and for contacts the shares of its phases.
    pub(crate) fn report(&self, wall: f64, contacts: bool) -> String {
        let mut text = format!("{wall:.2} s, {:.4} s a step", wall / self.taken.max(1) as f64);
        if contacts {
            let ContactTimes { detection, laws, solver, rods } = self.times;
            let share = |phase: Duration| 100.0 * phase.as_secs_f64() / wall;
            text += &format!(
                ": solver {:.0} %, detection {:.0} %, laws {:.0} %, rods {:.0} %, other {:.0} %",
                share(solver),
                share(detection),
                share(laws),
                share(rods),
                100.0 - share(self.times.total())
            );
        }
        text
    }
}

/// The most memory that this process has had, bytes, where the system tells it as Linux does.
pub(crate) fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(1024.0 * line.trim().strip_suffix(" kB")?.parse::<f64>().ok()?)
}

/// Memory that this process may take, bytes: that of the machine, or less where a limit is set on
/// the process or its group; 16 GB where the system does not tell.
pub(crate) fn memory() -> f64 {
    let read = |path| std::fs::read_to_string(path).unwrap_or_default();
    let word = |text: &str, name: &str, at: usize| {
        let line = text.lines().find_map(|line| line.strip_prefix(name))?;
        line.split_whitespace().nth(at)?.parse::<f64>().ok()
    };
    let machine = word(&read("/proc/meminfo"), "MemTotal:", 0).map(|kilobytes| 1024.0 * kilobytes);
    let process = word(&read("/proc/self/limits"), "Max address space", 0);
    let group = read("/sys/fs/cgroup/memory.max").trim().parse().ok();
    let limits = [machine, process, group].into_iter().flatten();
    limits.reduce(f64::min).unwrap_or(16e9)
}
