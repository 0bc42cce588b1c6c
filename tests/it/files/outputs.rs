//! Output files are written completely or not at all, and replace another file only on request.

use slewkit_files::export::{FileError, Target};
use std::fs;
use std::path::Path;

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into()).collect();
    names.sort();
    names
}

#[test]
fn a_file_is_there_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.json");
    let target = Target::new(&path, false).unwrap();
    let failed = target.write(|output| {
        output.write_all(b"half")?;
        Err(std::io::Error::other("disk full").into())
    });
    assert_eq!(failed.unwrap_err().code(), "E0097");
    assert_eq!(names(folder.path()), [""; 0], "nothing may be left behind");

    target.write(|output| Ok(output.write_all(b"whole")?)).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"whole");
    assert_eq!(names(folder.path()), ["plan.json"]);

    let forced = Target::new(&path, true).unwrap();
    assert!(forced.write(|_| Err(std::io::Error::other("disk full").into())).is_err());
    assert_eq!(fs::read(&path).unwrap(), b"whole", "the old file survives a failed write");
    forced.write(|output| Ok(output.write_all(b"newer")?)).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"newer");
    assert_eq!(names(folder.path()), ["plan.json"]);
}

#[test]
fn an_existing_file_is_never_replaced_without_force() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.json");
    let early = Target::new(&path, false).unwrap();
    fs::write(&path, "mine").unwrap();
    assert!(matches!(Target::new(&path, false), Err(FileError::Exists { .. })));
    // Also when it appears between the check and the end of the solve.
    let error = early.write(|output| Ok(output.write_all(b"other")?)).unwrap_err();
    assert_eq!(error.code(), "E0098");
    assert_eq!(fs::read(&path).unwrap(), b"mine");
    assert_eq!(names(folder.path()), ["plan.json"]);
}

#[test]
fn names_that_cannot_be_files_are_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let code = |name: &str| match Target::new(folder.path().join(name), true) {
        Ok(_) => "accepted",
        Err(error) => error.code(),
    };
    assert_eq!(code("missing/plan.json"), "E0095");
    for name in ["a\nb", "\u{1b}[31mred", "CON", "con.json", "Lpt1.txt", "folder/", "."] {
        assert_eq!(code(name), "E0099", "{name:?}");
    }
    assert_eq!(code(&"n".repeat(256)), "E0099");
    for name in ["CONE.json", "com0.json", "lpt10", "plan", ".hidden", "größe.json"] {
        assert_eq!(code(name), "accepted", "{name:?}");
    }
    fs::create_dir(folder.path().join("taken")).unwrap();
    assert_eq!(code("taken"), "E0099");
    let shown = Target::new(folder.path().join("\u{1b}[31m"), true).unwrap_err().to_string();
    assert!(shown.contains("\\u{1b}") && !shown.contains('\u{1b}'), "{shown}");
}

#[test]
fn an_output_that_is_an_input_is_refused_even_with_force() {
    let folder = tempfile::tempdir().unwrap();
    let spec = folder.path().join("spec.toml");
    fs::write(&spec, "spec").unwrap();
    let target = Target::new(folder.path().join("./spec.toml"), true).unwrap();
    assert_eq!(target.distinct_from(&spec).unwrap_err().code(), "E0100");
    Target::new(folder.path().join("plan.json"), true).unwrap().distinct_from(&spec).unwrap();
}

#[cfg(unix)]
#[test]
fn devices_and_rights_are_respected() {
    use std::os::unix::fs::PermissionsExt;
    // Streams too, whatever they lead to: with force, the file behind one would be another
    // program's.
    for name in ["/dev/null", "/dev/stderr", "/dev/fd/2", "/proc/self/fd/2"] {
        for force in [false, true] {
            assert_eq!(Target::new(name, force).unwrap_err().code(), "E0099", "{name}");
        }
    }
    // No user can create a file here.
    #[cfg(target_os = "linux")]
    assert_eq!(Target::new("/sys/plan.json", false).unwrap_err().code(), "E0096");
    let folder = tempfile::tempdir().unwrap();
    let mode = |name: &str| fs::metadata(folder.path().join(name)).unwrap().permissions().mode();
    fs::write(folder.path().join("ordinary"), "").unwrap();
    let path = folder.path().join("ours");
    Target::new(&path, false).unwrap().write(|output| Ok(output.write_all(b"x")?)).unwrap();
    assert_eq!(mode("ours"), mode("ordinary"), "readable as any new file");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
    Target::new(&path, true).unwrap().write(|output| Ok(output.write_all(b"x")?)).unwrap();
    assert_eq!(mode("ours") & 0o777, 0o640, "a replaced file keeps its rights");
    std::os::unix::fs::symlink(folder.path().join("nowhere"), folder.path().join("dangling")).unwrap();
    // The name exists and cannot be written to, with or without `--force`.
    for force in [false, true] {
        assert_eq!(Target::new(folder.path().join("dangling"), force).unwrap_err().code(), "E0099");
    }
}
