//! Keeps the computer from going to sleep while a job runs, by the system's own helper program where there is one.

use std::process::{Child, Command, Stdio};

/// Held while the job runs; dropping it lets the computer sleep again.
pub struct Awake(Child);

impl Awake {
    /// Asks the system not to sleep.
    ///
    /// # Errors
    /// What to tell the operator: no helper was found, or it would not.
    pub fn hold() -> Result<Awake, String> {
        let pid = std::process::id().to_string();
        // Both end by themselves when this process does, whatever becomes of it: no inhibitor outlives a crash.
        let mut command = if cfg!(target_os = "macos") {
            let mut c = Command::new("caffeinate");
            c.args(["-i", "-w", &pid]);
            c
        } else {
            let mut c = Command::new("systemd-inhibit");
            c.args([
                "--what=idle:sleep",
                "--who=morsemill",
                "--why=a job is running on the machine",
                "--mode=block",
            ])
            .args(["tail", "--follow", "/dev/null", "--pid", &pid]);
            c
        };
        let advice = "switch automatic sleep off yourself for a long job";
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|_| {
                format!(
                    "this computer may go to sleep (no helper to keep it awake was found): {advice}"
                )
            })?;
        // It refuses within moments where there is no session to ask.
        std::thread::sleep(std::time::Duration::from_millis(150));
        match child.try_wait() {
            Ok(None) => Ok(Awake(child)),
            _ => Err(format!(
                "this computer may go to sleep (the system would not promise otherwise): {advice}"
            )),
        }
    }
}

impl Drop for Awake {
    fn drop(&mut self) {
        // It may have ended already; then there is nothing to end.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
