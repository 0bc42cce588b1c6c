//! Reports in a real browser, if one is installed: `.ci/run` installs Chromium, and without any the
//! tests skip aloud.

use super::binary::Folder;
use super::report::HOSTILE;
use serde_json::Value;
use slewkit::{Matrix3, lie};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Names of the browser.
const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

const WATCH: &str = include_str!("../../browser/watch.js");
const CHECK: &str = include_str!("../../browser/check.js");
const PAINT: &str = include_str!("../../browser/paint.js");

/// The page around the page under test, which returns the result.
const FRAME: &str = r#"<!DOCTYPE html><meta charset="utf-8"><body style="margin:0"><script>
const frame = document.createElement("iframe");
Object.assign(frame, { srcdoc: PAGE, width: WIDTH, height: 900, style: "border:0" });
document.body.appendChild(frame);
const wait = setInterval(() => {
  const check = frame.contentDocument.getElementById("check");
  if (!check) return;
  document.body.appendChild(check.cloneNode(true));
  clearInterval(wait);
}, 100);
</script>"#;

fn browser() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let found = std::env::split_paths(&path).flat_map(|folder| BROWSERS.map(|name| folder.join(name)));
    let found = found.into_iter().find(|file| file.is_file());
    if found.is_none() {
        eprintln!("SKIPPED: no Chromium to open a report in (Debian, Ubuntu: `apt-get install chromium`)");
    }
    found
}

/// Opens the page `name` of `folder` in a window of this size in pixels, uses it, and returns the
/// results.
fn used(browser: &Path, folder: &Folder, name: &str, width: u32) -> Value {
    let page = folder.read(name);
    let (head, tail) = ("<style>", "</body>");
    assert_eq!((page.matches(head).count(), page.matches(tail).count()), (1, 1));
    let page = page
        .replace(head, &format!("<script>{WATCH}</script><style>"))
        .replace(tail, &format!("<script>{CHECK}</script></body>"));
    // The page is shown in a frame, because a window of Chromium has a least width. It is written
    // into the frame, because Chromium treats files as strangers to each other.
    let text = serde_json::to_string(&page).unwrap().replace('<', "\\u003c");
    fs::write(folder.path("checked.html"), FRAME.replace("WIDTH", &width.to_string()).replace("PAGE", &text))
        .unwrap();
    let home = tempfile::tempdir().unwrap();
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"])
        .arg(format!("--user-data-dir={}", home.path().display()))
        .args(["--virtual-time-budget=20000", "--window-size=1600,900", "--dump-dom"])
        .arg(format!("file://{}", folder.path("checked.html").display()))
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let dom = String::from_utf8_lossy(&output.stdout);
    let found = dom.split("<pre id=\"check\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    let found = found.unwrap_or_else(|| panic!("no result: {}", String::from_utf8_lossy(&output.stderr)));
    let plain = found.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    serde_json::from_str(&plain).unwrap_or_else(|error| panic!("{error}: {plain}"))
}

/// Returns the times at which the page `name` of `folder` shows a first picture, and all of them
/// \[ms\], by the clock of the machine.
fn painted(browser: &Path, folder: &Folder, name: &str) -> Option<(f64, f64)> {
    let page = folder.read(name).replace("</body>", &format!("<script>{PAINT}</script></body>"));
    fs::write(folder.path("painted.html"), page).unwrap();
    let home = tempfile::tempdir().unwrap();
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"])
        .arg(format!("--user-data-dir={}", home.path().display()))
        // A picture of the window makes frames; the console goes to stderr.
        .args(["--enable-logging=stderr", "--timeout=10000", "--window-size=1280,900"])
        .arg(format!("--screenshot={}", folder.path("painted.png").display()))
        .arg(format!("file://{}", folder.path("painted.html").display()))
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    let found = told.split("PAINT ").nth(1)?.split('}').next()?;
    let found: Value = serde_json::from_str(&format!("{found}}}")).unwrap();
    Some((found["first"].as_f64()?, found["drawn"].as_f64()?))
}

/// `cargo test --test it -- first_paint --nocapture` prints the figures.
#[test]
fn a_report_of_a_thousand_steps_has_its_first_paint_within_a_second() {
    const RUNS: usize = 7;
    let Some(browser) = browser() else { return };
    let folder = Folder::new();
    let steps = ["--set", "maneuver.steps=1000"];
    folder.slew(&[&["plan", "spec.toml", "-q", "--report", "a.html"][..], &steps[..]].concat()).ends(0);
    // Other work of the machine only adds time, so the least of several counts is used.
    let runs: Vec<(f64, f64)> = (0..RUNS).filter_map(|_| painted(&browser, &folder, "a.html")).collect();
    let least = |of: fn(&(f64, f64)) -> f64| runs.iter().map(of).fold(f64::INFINITY, f64::min);
    let (first, drawn) = (least(|run| run.0), least(|run| run.1));
    let size = folder.read("a.html").len() as f64 / 1e6;
    println!(
        "a report of 1000 steps: {size:.2} MB, first paint {first:.0} ms, all drawn {drawn:.0} ms, least of {RUNS}"
    );
    assert!(first < 1000.0, "{runs:?}");
    // The measurement detects a delay of the page.
    let busy = "<script>for (const end = Date.now() + 1100; Date.now() < end; );</script><style>";
    fs::write(folder.path("busy.html"), folder.read("a.html").replacen("<style>", busy, 1)).unwrap();
    assert!(painted(&browser, &folder, "busy.html").is_none_or(|(first, _)| first > 1000.0));
}

fn figures(found: &Value) -> Vec<(String, i64)> {
    let figures = found["figures"].as_object().unwrap().iter();
    figures.map(|(key, curves)| (key.clone(), curves.as_i64().unwrap())).collect()
}

/// Checks that the angles of every sequence of the page compose to its quaternion.
fn angles_are_the_attitude(found: &Value) {
    let number = |value: &Value| value.as_str().unwrap().replace('−', "-").parse::<f64>().unwrap();
    let numbers = |value: &Value| value.as_array().unwrap().iter().map(number).collect::<Vec<f64>>();
    let q = numbers(&found["quaternion"]);
    let wanted = lie::rotation_from_quaternion(&[q[0], q[1], q[2], q[3]]);
    let sequences = found["euler"].as_object().unwrap();
    assert_eq!(sequences.len(), 12);
    for (sequence, angles) in sequences {
        let axes =
            sequence.bytes().map(|axis| Matrix3::identity().column(usize::from(axis - b'x')).into_owned());
        let turns = axes.zip(numbers(angles)).map(|(axis, angle)| lie::exp(&(angle.to_radians() * axis)));
        let product = turns.fold(Matrix3::identity(), |product, turn| product * turn);
        assert!((product - wanted).amax() < 2e-4, "{sequence} {angles}");
    }
}

#[test]
fn a_report_works_in_a_browser_at_any_width() {
    let Some(browser) = browser() else { return };
    let folder = Folder::new();
    fs::write(folder.path("hostile.toml"), HOSTILE).unwrap();
    folder.slew(&["plan", "hostile.toml", "-q", "-o", "plan.json", "--report", "report.html"]).ends(0);
    for width in [400, 1280] {
        let found = used(&browser, &folder, "report.html", width);
        assert_eq!(found["wrong"], serde_json::json!([]), "at {width} px");
        let figures = figures(&found);
        let keys: Vec<&str> = figures.iter().map(|(key, _)| key.as_str()).collect();
        for key in [
            "sky",
            "inputs",
            "rates",
            "clearance",
            "euler",
            "quaternion",
            "error",
            "hamiltonian",
            "convergence",
        ] {
            assert!(keys.contains(&key), "no {key} in {keys:?}");
        }
        assert!(figures.iter().all(|(_, curves)| *curves > 0), "{figures:?}");
        assert_eq!(found["images"], 3, "the slider moves the body");
        assert_eq!(found["clock"], "10 s");
        for what in ["turns", "shared", "zooms", "unzooms", "smuggled"] {
            assert_eq!(found[what], true, "{what} at {width} px");
        }
        angles_are_the_attitude(&found);
        let values = found["values"].as_array().unwrap();
        assert!(
            values.iter().all(|value| value.as_str().is_some_and(|text| text.contains(char::is_numeric)))
        );
        // Nothing stands out to the right.
        assert!(found["width"][0].as_f64() <= found["width"][1].as_f64(), "{}", found["width"]);
        assert!(found["title"].as_str().unwrap().contains("</script>"), "{}", found["title"]);
        assert!(found["verdict"].as_str().unwrap().contains("solved and verified"));
    }
}

#[test]
fn a_long_plan_and_one_that_failed_work_as_well() {
    let Some(browser) = browser() else { return };
    let folder = Folder::new();
    let steps = ["--set", "maneuver.steps=5000"];
    folder.slew(&[&["plan", "spec.toml", "-q", "--report", "long.html"][..], &steps[..]].concat()).ends(0);
    let found = used(&browser, &folder, "long.html", 800);
    assert_eq!(found["wrong"], serde_json::json!([]));
    assert_eq!(found["images"], 3);
    // Logarithmic axes to the right, and charts without a body.
    let spec = concat!(env!("CARGO_MANIFEST_DIR"), "/../../problems/dumbbells.toml");
    let study = ["--step", "0.1,0.05", "--horizon", "2", "--report", "compared.html"];
    folder.slew(&[&["compare", spec, "-q"][..], &study].concat()).ends(0);
    let found = used(&browser, &folder, "compared.html", 400);
    assert_eq!(found["wrong"], serde_json::json!([]));
    let figures = figures(&found);
    assert!(figures.len() == 9 && figures.iter().all(|(_, curves)| *curves == 4), "{figures:?}");
    let impossible = ["--set", "actuators.torque_norm_limit_n_m=0.001"];
    folder
        .slew(&[&["plan", "spec.toml", "-q", "--report", "none.html"][..], &impossible[..]].concat())
        .ends(4);
    let found = used(&browser, &folder, "none.html", 800);
    assert_eq!(
        (&found["wrong"], found["verdict"].as_str().unwrap()),
        (&serde_json::json!([]), "✗ infeasible")
    );
}
