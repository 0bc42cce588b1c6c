//! Reading files to text: sizes, kinds of files, encodings, notations.

use super::BASE;
use slewkit_files::spec::{self, Format, MAX_BYTES};
use std::fs;
use std::path::Path;

/// Returns the single error code of reading `path`.
fn refused(path: &Path) -> (&'static str, String) {
    let errors = spec::read(path, &[]).expect_err("accepted");
    assert_eq!(errors.0.len(), 1, "{errors}");
    (errors.0[0].code, errors.0[0].reason.clone())
}

#[test]
fn missing_file_is_a_matter_of_files() {
    let errors = spec::read(Path::new("no/such/file.toml"), &[]).expect_err("accepted");
    assert!(errors.is_io());
    assert_eq!(errors.0[0].code, "E0015");
    assert_eq!(errors.0[0].file, "no/such/file.toml");
}

#[test]
fn directory_and_device_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(refused(folder.path()), ("E0014", "is a directory, not a file".into()));
    if cfg!(target_os = "linux") {
        assert_eq!(refused(Path::new("/dev/zero")), ("E0014", "is a device or a socket, not a file".into()));
    }
}

#[test]
fn large_file_is_refused_before_it_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.toml");
    fs::write(&path, " ".repeat(8 << 20)).unwrap();
    assert_eq!(refused(&path), ("E0004", "the spec is 8 MiB, the limit is 1 MiB".into()));
}

#[test]
fn endless_stream_is_read_to_the_limit() {
    let errors = spec::from_reader(std::io::repeat(b' '), "-", Format::Toml, &[]).expect_err("accepted");
    assert_eq!(errors.0[0].code, "E0004");
}

#[cfg(unix)]
#[test]
fn pipe_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pipe.toml");
    let made = std::process::Command::new("mkfifo").arg(&path).status();
    if !made.is_ok_and(|status| status.success()) {
        return;
    }
    let writer = std::thread::spawn({
        let path = path.clone();
        move || fs::write(path, BASE)
    });
    spec::read(&path, &[]).unwrap();
    writer.join().unwrap().unwrap();
}

#[test]
fn spec_of_exactly_the_limit_is_read() {
    let mut text = BASE.to_string();
    text.push('#');
    text.push_str(&"x".repeat(MAX_BYTES - text.len()));
    spec::from_str(&text, "x", Format::Toml, &[]).unwrap();
    text.push('x');
    assert_eq!(spec::from_str(&text, "x", Format::Toml, &[]).expect_err("accepted").0[0].code, "E0004");
}

#[test]
fn byte_order_mark_and_windows_lines_are_accepted() {
    let text = format!("\u{feff}{}", BASE.replace('\n', "\r\n"));
    spec::from_str(&text, "x", Format::Toml, &[]).unwrap();
    let wrong = text.replace("steps = 200", "steps = 1");
    let errors = spec::from_str(&wrong, "x", Format::Toml, &[]).expect_err("accepted");
    assert_eq!((errors.0[0].line, errors.0[0].column), (14, 9));
    assert!(!errors.to_string().contains('\r'));
}

#[test]
fn name_ending_in_json_is_read_as_json() {
    for (name, format) in
        [("a.json", Format::Json), ("a.JSON", Format::Json), ("a.toml", Format::Toml), ("-", Format::Toml)]
    {
        assert_eq!(Format::of(Path::new(name)), format, "{name}");
    }
}

#[test]
fn nesting_beyond_reason_needs_no_stack() {
    // Dotted keys inside inline tables: six thousand levels in twenty kilobytes.
    let dotted = format!("{} = {{ ", vec!["a"; 78].join(".")).repeat(78);
    let closed = format!("{dotted}b = 1{}", " }".repeat(78));
    let brackets = "[".repeat(MAX_BYTES);
    let texts = [closed, brackets.clone(), format!("a = {brackets}").split_off(8), "[a".repeat(100_000)];
    let small = std::thread::Builder::new().stack_size(512 << 10);
    let reading = move || {
        for text in &texts {
            for format in [Format::Toml, Format::Json] {
                spec::from_str(text, "x", format, &[]).expect_err("accepted");
            }
        }
    };
    small.spawn(reading).unwrap().join().unwrap();
}
