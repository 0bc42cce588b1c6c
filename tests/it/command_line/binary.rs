//! The real binary in a temporary folder.

use serde_json::Value;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A maneuver.
pub const SPEC: &str = r#"
format = 1
name = "test slew"
[body]
inertia_kg_m2 = [1, 2, 2.5]
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[end]
attitude = { euler_zyx_deg = [80, -25, 40] }
[maneuver]
duration_s = 10
steps = 100
"#;

/// A folder with a spec in it, and the binary run from there.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        fs::write(folder.path("spec.toml"), SPEC).unwrap();
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_slew"));
        command.args(args).current_dir(self.0.path()).stdin(Stdio::null());
        command
    }

    pub fn slew(&self, args: &[&str]) -> Run {
        Run::of(self.command(args).output().unwrap(), args)
    }

    pub fn slew_with_stdin(&self, args: &[&str], stdin: &str) -> Run {
        let mut command = self.command(args);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        child.stdin.take().unwrap().write_all(stdin.as_bytes()).unwrap();
        Run::of(child.wait_with_output().unwrap(), args)
    }
}

/// The result of a command.
pub struct Run {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Run {
    pub fn of(output: Output, args: &[&str]) -> Self {
        let code = output.status.code().unwrap_or_else(|| panic!("{args:?} was killed"));
        let text = |bytes| String::from_utf8(bytes).unwrap();
        let run = Self { code, stdout: text(output.stdout), stderr: text(output.stderr) };
        assert!(!run.stderr.contains("panicked"), "{args:?}: {}", run.stderr);
        run
    }

    /// Checks the exit code.
    #[track_caller]
    pub fn ends(self, code: i32) -> Self {
        assert_eq!(self.code, code, "stdout: {}\nstderr: {}", self.stdout, self.stderr);
        self
    }

    #[track_caller]
    pub fn tells(self, wanted: &str) -> Self {
        let said = self.stderr.contains(wanted) || self.typed().contains(wanted);
        assert!(said, "no {wanted:?} in: {}", self.stderr);
        self
    }

    /// Returns the command as a shell accepts it: joined if it continues on the next line, and with
    /// its comment at the end.
    fn typed(&self) -> String {
        let mut text = String::new();
        for line in self.stderr.lines() {
            let bare = line.trim_start();
            if text.ends_with(" \\") {
                text.truncate(text.len() - 1);
                text.push_str(bare);
            } else if bare.starts_with("# ") {
                text.push_str("   ");
                text.push_str(bare);
            } else {
                text.push('\n');
                text.push_str(line);
            }
        }
        text + "\n"
    }

    #[track_caller]
    pub fn silent(self) -> Self {
        assert_eq!(self.stderr, "");
        self
    }

    pub fn json(&self) -> Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error}: {}", self.stdout))
    }
}

/// Returns whether a process has taken Ctrl-C over.
#[cfg(target_os = "linux")]
pub fn catches_interrupt(process: u32) -> bool {
    catches(process, "-INT")
}

/// Returns whether a process has taken a signal over.
#[cfg(target_os = "linux")]
pub fn catches(process: u32, signal: &str) -> bool {
    is_listed(&process.to_string(), "SigCgt:", signal)
}

/// Returns whether this process ignores a signal, as under `nohup`: its children then do so as
/// well.
#[cfg(target_os = "linux")]
pub fn is_ignored(signal: &str) -> bool {
    is_listed("self", "SigIgn:", signal)
}

/// Returns whether a signal is in a list that the kernel keeps of a process.
#[cfg(target_os = "linux")]
fn is_listed(process: &str, list: &str, signal: &str) -> bool {
    let number = match signal {
        "-HUP" => 1,
        "-INT" => 2,
        "-TERM" => 15,
        other => panic!("{other}"),
    };
    let status = fs::read_to_string(Path::new("/proc").join(process).join("status"));
    let mask = status.ok().and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix(list))?.trim().to_string();
        u64::from_str_radix(&line, 16).ok()
    });
    mask.is_some_and(|mask| mask & (1 << (number - 1)) != 0)
}
