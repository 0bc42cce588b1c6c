//! `slew report` and `slew plot`: what is in the files, what is escaped, what is refused.

use super::binary::{Folder, SPEC};
use std::fs;

/// A maneuver whose names would break out of a page or a drawing that did not escape them.
pub const HOSTILE: &str = r#"
format = 1
name = "</script><script>window.smuggled = 1</script> \"quoted\" & 'single' <img src=x onerror=smuggled=1>"
[body]
inertia_kg_m2 = [1, 2, 2.5]
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[end]
attitude = { euler_zyx_deg = [80, -25, 40] }
[maneuver]
duration_s = 10
steps = 100
[[constraint]]
kind = "keep_out"
name = "</title><img src=x onerror=smuggled=1> \" ' &amp; cone"
boresight_body = [1, 0, 0]
direction_inertial = { vector = [0.6, 0.7, 0.3] }
half_angle_deg = 12
"#;

/// A page and its script data in parts.
fn data(page: &str) -> serde_json::Value {
    let rest = page.split("<script type=\"application/json\" id=\"data\">").nth(1).unwrap();
    serde_json::from_str(rest.split("</script>").next().unwrap()).unwrap()
}

#[test]
fn a_report_has_every_part_and_no_address() {
    let folder = Folder::new();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "plan.json", "--set", "maneuver.steps=1000"]).ends(0);
    folder.slew(&["report", "plan.json", "-o", "report.html"]).ends(0).tells("wrote       report.html");
    let page = folder.read("report.html");
    for id in ["proved", "summary", "directions", "limits", "attitude", "costates", "convergence", "body"] {
        assert!(page.contains(&format!("<section id=\"{id}\">")), "{id}");
    }
    for heading in ["Rivals", "Checks of the witnesses"] {
        assert!(page.contains(&format!("<h2>{heading}</h2>")), "{heading}");
    }
    assert!(page.contains("solved and verified") && page.contains("no conjugate point"));
    // The name of the language of drawings is the one address, and nothing is fetched from there.
    let elsewhere = page.replace("http://www.w3.org/2000/svg", "");
    for foreign in ["http://", "https://", "src=", "@import", "url(http"] {
        assert!(!elsewhere.contains(foreign), "{foreign}");
    }
    assert!(page.len() < 2_000_000, "{}", page.len());
    let data = data(&page);
    let keys: Vec<&str> =
        data["charts"].as_array().unwrap().iter().map(|chart| chart["key"].as_str().unwrap()).collect();
    for key in ["sky", "inputs", "rates", "euler", "quaternion", "error", "costates_attitude", "hamiltonian"]
    {
        assert!(keys.contains(&key), "no {key} in {keys:?}");
    }
    assert_eq!(data["body"]["time"].as_array().unwrap().len(), 1001);
    // Curves over the nodes share one list of times.
    assert!(data["grids"].as_array().unwrap().len() <= 12);
    assert!(!page.contains("Curves show at most"));
}

#[test]
fn what_the_page_says_is_what_the_plan_says() {
    let folder = Folder::new();
    let told =
        folder.slew(&["plan", "spec.toml", "-o", "plan.json", "--report", "report.html"]).ends(0).stderr;
    assert_eq!(folder.names(), ["plan.json", "report.html", "spec.toml"]);
    let page = folder.read("report.html");
    for line in told.lines().filter(|line| {
        line.starts_with("  ")
            && !line.starts_with("  try")
            && !line.contains(".json")
            && !line.contains(".html")
    }) {
        let text: String = line.chars().skip(13).collect();
        let text = text.trim().replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        assert!(page.contains(&format!("<dd>{text}</dd>")), "{text}");
    }
    // The numbers of the data are those of the plan to the digits that they have.
    let (data, plan) = (data(&page), folder.json("plan.json"));
    for row in [0, 37, 100] {
        for part in 0..4 {
            let shown = data["body"]["quaternion"][row][part].as_f64().unwrap();
            let recorded = plan["trajectory"]["quaternion_wxyz"][row][part].as_f64().unwrap();
            assert!((shown - recorded).abs() < 1e-6);
        }
    }
    // From the file it is the same page, but for the time that the file holds to all its digits.
    folder.slew(&["report", "plan.json", "-o", "again.html", "-q"]).ends(0).silent();
    assert_eq!(folder.read("again.html"), page);
    let stdout = folder.slew(&["report", "plan.json", "-o", "-"]).ends(0).silent();
    assert_eq!(stdout.stdout, page);
}

#[test]
fn text_of_a_spec_is_escaped_in_pages_and_drawings() {
    let folder = Folder::new();
    fs::write(folder.path("hostile.toml"), HOSTILE).unwrap();
    folder.slew(&["plan", "hostile.toml", "-q", "-o", "plan.json", "--report", "report.html"]).ends(0);
    let page = folder.read("report.html");
    assert_eq!(page.matches("<script").count(), 2, "data and script");
    assert_eq!(page.matches("</script>").count(), 2);
    assert!(!page.contains("<img") && page.matches("</title>").count() == 1);
    assert!(page.contains("&lt;/script&gt;") && page.contains("&quot;quoted&quot; &amp; &#39;single&#39;"));
    let name = data(&page)["charts"].as_array().unwrap()[0]["cones"][0]["name"].clone();
    assert_eq!(name, "</title><img src=x onerror=smuggled=1> \" ' &amp; cone");
    folder.slew(&["plot", "plan.json", "-q", "-o", "figures"]).ends(0).silent();
    for file in fs::read_dir(folder.path("figures")).unwrap() {
        let svg = fs::read_to_string(file.unwrap().path()).unwrap();
        assert!(!svg.contains("<img") && !svg.contains("<script") && !svg.contains("%\" font"), "{svg}");
        // Absolute sizes alone: percent of the page is what one renderer makes of the others.
        assert!(!svg.split("font-size=\"").skip(1).any(|rest| rest.split('"').next().unwrap().contains('%')));
    }
}

#[test]
fn long_trajectories_are_thinned_and_it_is_said() {
    let folder = Folder::new();
    folder.slew(&["plan", "spec.toml", "-q", "--report", "a.html", "--set", "maneuver.steps=20000"]).ends(0);
    let page = folder.read("a.html");
    assert!(page.contains("Curves show at most 2000 of 20001 points"));
    assert!(page.len() < 2_000_000, "{}", page.len());
}

#[test]
fn a_plan_without_a_trajectory_has_a_report_and_no_picture() {
    let folder = Folder::new();
    let set = "actuators.torque_norm_limit_n_m=0.001";
    folder.slew(&["plan", "spec.toml", "-q", "-o", "plan.json", "--set", set, "--report", "a.html"]).ends(4);
    let page = folder.read("a.html");
    assert!(page.contains("No plan exists, and that is proved") && !page.contains("<figure"));
    folder.slew(&["plot", "plan.json", "-o", "figures"]).ends(8).tells("error[E0108]").tells("slew report");
    assert_eq!(folder.names(), ["a.html", "plan.json", "spec.toml"]);
}

#[test]
fn plot_draws_one_file_a_picture_or_a_panel() {
    let folder = Folder::new();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "plan.json"]).ends(0);
    folder.slew(&["plot", "plan.json", "-o", "figures"]).ends(0).tells("wrote       figures/sky.svg");
    assert!(folder.read("figures/rates.svg").contains("Angular velocity"));
    folder
        .slew(&["plot", "plan.json", "-q", "-o", "panel.svg", "--charts", "euler,error,rates"])
        .ends(0)
        .silent();
    let panel = folder.read("panel.svg");
    for letter in ["(a)", "(b)", "(c)"] {
        assert!(panel.contains(letter));
    }
    assert!(!panel.contains("(d)") && panel.contains("Euler angles zyx"));
    folder.slew(&["plot", "plan.json", "-q", "-o", "e.svg", "--charts", "euler", "--euler", "xyx"]).ends(0);
    assert!(folder.read("e.svg").contains("Euler angles xyx"));
}

#[test]
fn wrong_inputs_and_outputs_are_told() {
    let folder = Folder::new();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "plan.json"]).ends(0);
    folder
        .slew(&["report", "spec.toml", "-o", "a.html"])
        .ends(8)
        .tells("not a plan file")
        .tells("slew plan SPEC -o FILE");
    folder.slew(&["plot", "spec.toml", "-o", "a.svg"]).ends(8).tells("not a plan file");
    folder.slew(&["report", "absent.json", "-o", "a.html"]).ends(8).tells("cannot read absent.json");
    folder.slew(&["report", "plan.json", "-o", "a.txt"]).ends(2).tells("must end in .html");
    folder.slew(&["plan", "spec.toml", "--report", "a.json"]).ends(2).tells("must end in .html");
    folder.slew(&["plot", "plan.json", "-o", "a.jpg"]).ends(2).tells("written as .svg, .png or .pdf");
    folder
        .slew(&["plot", "plan.json", "-o", "a.svg", "--charts", "forces"])
        .ends(2)
        .tells("no picture \"forces\"");
    folder.slew(&["plot", "plan.json", "-o", "a.svg", "--charts", "faces"]).ends(2).tells("possible values");
    folder.slew(&["report", "plan.json", "-o", "a.html", "--euler", "xxz"]).ends(2);
    assert_eq!(folder.names(), ["plan.json", "spec.toml"]);
    fs::write(folder.path("a.html"), "mine").unwrap();
    folder.slew(&["report", "plan.json", "-o", "a.html"]).ends(8).tells("error[E0098]").tells("--force");
    folder.slew(&["plan", "spec.toml", "-q", "--report", "a.html"]).ends(8);
    assert_eq!(folder.read("a.html"), "mine");
    folder.slew(&["report", "plan.json", "-o", "a.html", "--force", "-q"]).ends(0).silent();
    assert!(folder.read("a.html").starts_with("<!DOCTYPE html>"));
    fs::create_dir(folder.path("figures")).unwrap();
    fs::write(folder.path("figures/rates.svg"), "mine").unwrap();
    folder.slew(&["plot", "plan.json", "-o", "figures"]).ends(8).tells("error[E0098]");
    // Nothing is written before all names are checked.
    assert_eq!(fs::read_dir(folder.path("figures")).unwrap().count(), 1);
    // A spec is not overwritten by its own report.
    fs::write(folder.path("spec.html"), SPEC).unwrap();
    let run = folder.slew(&["plan", "spec.html", "-q", "--report", "spec.html", "--force"]).ends(8);
    run.tells("error[E0100]");
}

#[test]
#[cfg(not(feature = "paper"))]
fn png_and_pdf_are_refused_where_nothing_makes_them() {
    let folder = Folder::new();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "plan.json"]).ends(0);
    for name in ["a.png", "a.PDF"] {
        folder
            .slew(&["plot", "plan.json", "-o", name])
            .ends(2)
            .tells("--features paper")
            .tells("rsvg-convert");
    }
    assert_eq!(folder.names(), ["plan.json", "spec.toml"]);
}

/// `cargo test --features paper --test it -- png_and_pdf`.
#[test]
#[cfg(feature = "paper")]
fn png_and_pdf_show_the_picture_with_its_letters() {
    let folder = Folder::new();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "plan.json"]).ends(0);
    for name in ["a.png", "a.pdf"] {
        folder.slew(&["plot", "plan.json", "-q", "-o", name, "--charts", "rates,euler"]).ends(0).silent();
    }
    let png = fs::read(folder.path("a.png")).unwrap();
    let number = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
    assert_eq!((&png[1..4], number(16), number(20)), (&b"PNG"[..], 3200, 960));
    // Curves without letters would be half of it.
    assert!(png.len() > 60_000, "{}", png.len());
    let pdf = fs::read(folder.path("a.pdf")).unwrap();
    let text = String::from_utf8_lossy(&pdf);
    assert!(text.starts_with("%PDF-") && text.contains("/Font"), "text stays text");
    // 1600 and 480 px at 96 an inch are 1200 and 360 points: letters of 13 px are 9.75 points high.
    assert!(text.contains("/MediaBox [0 0 1200 360]"), "absolute size");
}

/// The ordinates of the one curve of a picture.
fn curve(data: &serde_json::Value, key: &str) -> Vec<f64> {
    let chart = data["charts"].as_array().unwrap().iter().find(|chart| chart["key"] == key).unwrap();
    chart["curves"][0]["y"].as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
}

/// The picture `key` of a page.
fn picture<'a>(data: &'a serde_json::Value, key: &str) -> &'a serde_json::Value {
    let all = data["charts"].as_array().unwrap();
    all.iter().find(|chart| chart["key"] == key).unwrap_or_else(|| panic!("no {key}"))
}

/// Times and values of a curve.
fn points(data: &serde_json::Value, curve: &serde_json::Value) -> Vec<(f64, f64)> {
    let grid = &data["grids"][curve["grid"].as_u64().unwrap() as usize];
    let numbers = |list: &serde_json::Value| -> Vec<f64> {
        list.as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
    };
    numbers(grid).into_iter().zip(numbers(&curve["y"])).collect()
}

fn problem(name: &str) -> String {
    format!("{}/problems/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

/// The maximum principle, drawn: wherever its function is clear of the thresholds an input does what the function asks, and
/// the functions cross them where the arcs of the continuous extremal meet.
#[test]
fn switching_functions_ask_for_the_inputs_that_the_plan_has() {
    let folder = Folder::new();
    for (name, kinds) in [
        ("minimum_time_xte", &["bang"][..]),
        ("minimum_fuel_120", &["bang", "coast"]),
        ("minimum_fuel_thrusters", &["bang", "coast"]),
    ] {
        let (file, page) = (format!("{name}.json"), format!("{name}.html"));
        folder.slew(&["plan", &problem(name), "-q", "-o", &file, "--report", &page]).ends(0);
        let (data, plan) = (data(&folder.read(&page)), folder.json(&file));
        let chart = picture(&data, "switching");
        let levels: Vec<f64> = chart["levels"]
            .as_array()
            .unwrap()
            .iter()
            .map(|level| level["value"].as_f64().unwrap())
            .collect();
        let arcs = plan["switching"]["arcs"].as_array().unwrap();
        let spans = chart["spans"].as_array().unwrap();
        assert_eq!(spans.len(), arcs.len());
        let mut found: Vec<&str> = spans.iter().map(|span| span["label"].as_str().unwrap()).collect();
        found.sort_unstable();
        found.dedup();
        assert_eq!(found, kinds, "{name}");
        let inputs = plan["trajectory"]["input"].as_array().unwrap();
        let mut crossings = 0;
        for (index, curve) in chart["curves"].as_array().unwrap().iter().enumerate() {
            let points = points(&data, curve);
            let largest = inputs.iter().map(|row| row[index].as_f64().unwrap().abs()).fold(0.0, f64::max);
            for (step, row) in inputs.iter().enumerate() {
                let (a, b) = (points[step].1, points[step + 1].1);
                let clear = |level: &f64| (a - level) * (b - level) > 0.0 && (a - level).abs() > 0.02;
                crossings += levels.iter().filter(|level| (a - **level) * (b - **level) < 0.0).count();
                if !levels.iter().all(clear) {
                    continue;
                }
                let wanted = match levels[..] {
                    [0.0] => -largest * a.signum(),
                    [off] => {
                        if a < off {
                            largest
                        } else {
                            0.0
                        }
                    }
                    _ => {
                        if a.abs() > 1.0 {
                            -largest * a.signum()
                        } else {
                            0.0
                        }
                    }
                };
                let value = row[index].as_f64().unwrap();
                assert!((value - wanted).abs() <= 1e-9 * largest, "{name} {index} {step}: {a} {value}");
            }
        }
        let switches = plan["switching"]["switches"].as_u64().unwrap() as usize;
        assert!(crossings.abs_diff(switches) <= 2 && crossings > 0, "{name}: {crossings} for {switches}");
        assert!(folder.read(&page).contains("<h2>Arcs</h2>"));
    }
    // Under a limit of the norm: it burns where the norm of the costate is above the price.
    folder
        .slew(&["plan", &problem("minimum_fuel_norm"), "-q", "-o", "norm.json", "--report", "norm.html"])
        .ends(0);
    let data = self::data(&folder.read("norm.html"));
    let chart = picture(&data, "switching");
    let labels: Vec<&str> =
        chart["spans"].as_array().unwrap().iter().map(|span| span["label"].as_str().unwrap()).collect();
    assert_eq!(labels, ["bang", "coast", "bang"]);
    let sizes = points(&data, &chart["curves"][0]);
    for (step, row) in
        folder.json("norm.json")["trajectory"]["torque_n_m"].as_array().unwrap().iter().enumerate()
    {
        let norm =
            row.as_array().unwrap().iter().map(|part| part.as_f64().unwrap().powi(2)).sum::<f64>().sqrt();
        let (low, high) = (sizes[step].1.min(sizes[step + 1].1), sizes[step].1.max(sizes[step + 1].1));
        assert!(low < 1.005 || (norm - 1.0).abs() < 1e-9, "{step}: {low} {norm}");
        assert!(high > 0.995 || norm < 1e-9, "{step}: {high} {norm}");
    }
    // A turn of a cube about the diagonal of a face: one input has no function to ask it, and stays within its
    // limits all the way.
    fs::write(folder.path("cube.toml"), CUBE).unwrap();
    folder.slew(&["plan", "cube.toml", "-q", "--report", "cube.html"]).ends(0);
    let data = self::data(&folder.read("cube.html"));
    let chart = picture(&data, "switching");
    let labels: Vec<&str> =
        chart["spans"].as_array().unwrap().iter().map(|span| span["label"].as_str().unwrap()).collect();
    assert_eq!(labels, ["singular"]);
    let size = |index: usize| {
        let points = points(&data, &chart["curves"][index]);
        points.iter().map(|point| point.1.abs()).fold(0.0, f64::max)
    };
    assert!(size(2) < 0.01 * size(0) && size(1) > 0.1, "{} {} {}", size(0), size(1), size(2));
}

const CUBE: &str = r#"
format = 1
[body]
inertia_kg_m2 = [1, 1, 1]
[actuators]
torque_limit_n_m = 1
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[end]
attitude = { axis = [1, 1, 0], angle_deg = 60 }
[maneuver]
minimize = "time"
steps = 100
"#;

#[test]
fn charts_and_tables_use_the_names_of_the_spec() {
    let folder = Folder::new();
    folder.slew(&["plan", &problem("wheels_pyramid"), "-q", "-o", "plan.json", "--report", "a.html"]).ends(0);
    let page = folder.read("a.html");
    let data = data(&page);
    for key in ["inputs", "wheel_momentum"] {
        let curves = picture(&data, key)["curves"].as_array().unwrap();
        let names: Vec<&str> = curves.iter().map(|curve| curve["name"].as_str().unwrap()).collect();
        assert_eq!(names, ["+x", "+y", "-x", "-y"], "{key}");
    }
    assert!(page.contains("<td>+x</td>") || page.contains("<td>-x</td>"), "margins name the wheel");
    // Names of thrusters, and of frames and object.
    let text = fs::read_to_string(problem("minimum_fuel_thrusters")).unwrap();
    let named = text.replacen("[[actuators.thruster]]", "[[actuators.thruster]]\nname = \"A <1>\"", 1);
    let names = "epoch = \"2026-11-21T07:00:00 UTC\"\n[names]\nobject = \"PROBE\"\nreference_frame = \"J2000\"\n\n[body]";
    fs::write(folder.path("named.toml"), named.replacen("[body]", names, 1)).unwrap();
    folder.slew(&["plan", "named.toml", "-q", "-o", "named.json"]).ends(0);
    folder.slew(&["report", "named.json", "-q", "-o", "named.html"]).ends(0);
    let page = folder.read("named.html");
    let data = self::data(&page);
    let curves = picture(&data, "switching")["curves"].as_array().unwrap();
    assert_eq!((&curves[0]["name"], &curves[7]["name"]), (&"A <1>".into(), &"thruster 8".into()));
    assert!(page.contains("reference frame J2000") && page.contains("<dd>PROBE</dd>"));
    assert!(page.contains("2026-11-21T07:00:00") && page.contains("from body axes to J2000"));
}

/// The Hamiltonian is the derivative of the least cost by the duration. From rest to rest a free body's cost goes as
/// `T⁻³`, because its equations know no time of their own.
#[test]
fn the_hamiltonian_is_that_of_the_theory() {
    let folder = Folder::new();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "plan.json", "--report", "a.html"]).ends(0);
    let wanted = -3.0 * folder.json("plan.json")["cost"].as_f64().unwrap() / 10.0;
    for value in curve(&data(&folder.read("a.html")), "hamiltonian") {
        assert!((value - wanted).abs() < 2e-3 * wanted.abs(), "{value} {wanted}");
    }
    // In a field the costates stand beside the nodes: put there, the value is constant to second order.
    let pendulum = concat!(env!("CARGO_MANIFEST_DIR"), "/problems/pendulum_inversion.toml");
    let spread = |steps: usize| {
        let (set, page) = (format!("maneuver.steps={steps}"), format!("{steps}.html"));
        folder.slew(&["plan", pendulum, "-q", "--report", &page, "--set", &set]).ends(0);
        let values = curve(&data(&folder.read(&page)), "hamiltonian");
        let (low, high) =
            values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
        high - low
    };
    let order = (spread(100) / spread(200)).log2();
    assert!((order - 2.0).abs() < 0.2, "{order}");
}

/// The cells of the row of a table that begins with `first`.
fn row<'a>(page: &'a str, first: &str) -> Vec<&'a str> {
    let start = format!("<tr><td>{first}</td>");
    let rest = page.split(&start).nth(1).unwrap_or_else(|| panic!("no row {first}"));
    let row = rest.split("</tr>").next().unwrap();
    row.split("<td>").skip(1).map(|cell| cell.trim_end_matches("</td>")).collect()
}

#[test]
fn methods_and_objectives_have_a_page_with_their_motions_side_by_side() {
    let folder = Folder::new();
    let args = ["compare", "spec.toml", "-q", "--format", "json", "--report", "methods.html"];
    let compared = folder.slew(&args).ends(0);
    let document = compared.json();
    let page = folder.read("methods.html");
    let data = data(&page);
    for key in ["inputs_1", "inputs_2", "inputs_3", "turning", "difference"] {
        assert!(!picture(&data, key)["curves"].as_array().unwrap().is_empty());
    }
    // They came to the same motion, by roads that share nothing but the problem.
    for curve in picture(&data, "difference")["curves"].as_array().unwrap() {
        assert!(points(&data, curve).iter().all(|point| point.1 < 1e-3));
    }
    let cost = document["methods"][0]["cost"].as_f64().unwrap();
    for method in ["shooting", "scp", "scp + polish"] {
        let shown: f64 = row(&page, method)[1].parse().unwrap();
        assert!((shown / cost - 1.0).abs() < 1e-9, "{method} {shown} {cost}");
    }
    // From its document the page has the numbers, and says where the motions are.
    fs::write(folder.path("methods.json"), compared.stdout).unwrap();
    folder.slew(&["report", "methods.json", "-q", "-o", "again.html"]).ends(0).silent();
    let again = folder.read("again.html");
    assert_eq!(row(&again, "shooting"), row(&page, "shooting"));
    assert!(again.contains("slew compare SPEC --report FILE.html"));
    folder.slew(&["plot", "methods.json", "-o", "a.svg"]).ends(8).tells("nothing to draw");
    folder.slew(&["compare", "spec.toml", "--report", "methods.html"]).ends(8).tells("error[E0098]");
    folder.slew(&["compare", "spec.toml", "--report", "a.json"]).ends(2).tells("must end in .html");

    let time = problem("minimum_time_xte");
    folder.slew(&["compare", &time, "-q", "--report", "objectives.html"]).ends(0).silent();
    let page = folder.read("objectives.html");
    let data = self::data(&page);
    let numbers = |name: &str| -> Vec<f64> {
        row(&page, name)[1..4].iter().map(|cell| cell.parse().unwrap()).collect()
    };
    let (time, fuel, effort) = (numbers("time"), numbers("fuel"), numbers("effort"));
    assert!(time[0] < fuel[0] && fuel[2] < effort[2] && effort[1] < fuel[1], "{time:?} {fuel:?} {effort:?}");
    for (index, plan) in [&time, &fuel, &effort].into_iter().enumerate() {
        let motion = points(&data, &picture(&data, "turning")["curves"][index]);
        assert!((motion.last().unwrap().0 / plan[0] - 1.0).abs() < 1e-6);
        // The effort of the inputs that are drawn is that of the table.
        let chart = picture(&data, &format!("inputs_{}", index + 1));
        let sum: f64 = chart["curves"]
            .as_array()
            .unwrap()
            .iter()
            .map(|curve| {
                let points = points(&data, curve);
                points
                    .windows(2)
                    .map(|ends| 0.25 * (ends[1].0 - ends[0].0) * (ends[0].1.powi(2) + ends[1].1.powi(2)))
                    .sum::<f64>()
            })
            .sum();
        assert!((sum / plan[1] - 1.0).abs() < 1e-3, "{index}: {sum} {plan:?}");
    }
}

#[test]
fn integrators_have_a_page_and_pictures_evaluations_first() {
    let folder = Folder::new();
    let spec = problem("dumbbells");
    let study = ["--step", "0.1,0.05,0.025", "--horizon", "3"];
    let args = [&["compare", &spec, "-q", "--format", "json", "--report", "a.html"][..], &study].concat();
    let compared = folder.slew(&args).ends(0);
    let document = compared.json();
    let page = folder.read("a.html");
    let data = data(&page);
    let chart = picture(&data, "evaluations_precision");
    assert!(chart["x"]["log"].as_bool().unwrap() && picture(&data, "energy_over_time")["x"]["log"] == false);
    let runs = document["runs"].as_array().unwrap();
    let first: Vec<(f64, f64)> = runs
        .iter()
        .filter(|run| run["method"] == "lie_verlet")
        .map(|run| (run["force_evaluations"].as_f64().unwrap(), run["energy_error_mean"].as_f64().unwrap()))
        .collect();
    for (shown, run) in points(&data, &chart["curves"][0]).iter().zip(&first) {
        assert!((shown.0 / run.0 - 1.0).abs() < 1e-6 && (shown.1 / run.1 - 1.0).abs() < 1e-6);
    }
    // The script looks values up by bisection.
    for curve in picture(&data, "energy_over_step")["curves"].as_array().unwrap() {
        assert!(points(&data, curve).windows(2).all(|pair| pair[0].0 < pair[1].0));
    }
    let head = page.split("<h2>Work at equal error</h2>").nth(1).unwrap();
    assert!(head.find("evaluations").unwrap() < head.find("CPU time").unwrap());
    fs::write(folder.path("a.json"), compared.stdout).unwrap();
    folder.slew(&["report", "a.json", "-q", "-o", "again.html"]).ends(0).silent();
    assert!(folder.read("again.html").contains("<h2>Runs</h2>"));
    folder.slew(&["plot", "a.json", "-q", "-o", "figures"]).ends(0).silent();
    assert_eq!(fs::read_dir(folder.path("figures")).unwrap().count(), 6);
    fs::write(folder.path("cut.json"), "{\"compares\": \"integrators\", \"name\": 1}").unwrap();
    folder.slew(&["report", "cut.json", "-o", "cut.html"]).ends(8).tells("error[E0102]");
}

/// In a turning frame, with wheels, with torques fixed in the reference frame: the Hamiltonian is the derivative of the least
/// cost by the duration, taken by differences of plans.
#[test]
fn the_hamiltonian_is_the_price_of_time() {
    let folder = Folder::new();
    let wheels = fs::read_to_string(problem("wheels_pyramid")).unwrap();
    let free = wheels
        .replace("torque_limit_n_m = 0.2", "torque_limit_n_m = 20")
        .replace("_n_m_s = 1.8", "_n_m_s = 90");
    fs::write(folder.path("wheels.toml"), free.split("[expect]").next().unwrap()).unwrap();
    for (spec, duration, bound) in [
        (problem("orbit_flip"), std::f64::consts::FRAC_PI_2, 2e-2),
        ("wheels.toml".into(), 60.0, 2e-3),
        (problem("pendulum_horizontal_torques"), f64::NAN, 0.0),
    ] {
        let plan = |factor: f64, steps: usize| {
            let (steps, length) =
                (format!("maneuver.steps={steps}"), format!("maneuver.duration_s={}", factor * duration));
            let set = ["plan", &spec, "-q", "--set", &steps, "--set", "solver.scheme=lie_verlet"];
            let timed = ["--set", &length];
            let timed = if duration.is_nan() { &[][..] } else { &timed[..] };
            let out = ["-o", "plan.json", "--report", "a.html", "--force"];
            folder.slew(&[&set[..], timed, &out].concat()).ends(0);
            let values = curve(&data(&folder.read("a.html")), "hamiltonian");
            let (low, high) =
                values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
            (folder.json("plan.json")["cost"].as_f64().unwrap(), low, high)
        };
        let (coarse, fine) = (plan(1.0, 200), plan(1.0, 400));
        let order = ((coarse.2 - coarse.1) / (fine.2 - fine.1)).log2();
        assert!((order - 2.0).abs() < 0.2, "{spec}: {order} {coarse:?} {fine:?}");
        if !duration.is_nan() {
            let slope = (plan(1.001, 400).0 - plan(0.999, 400).0) / (0.002 * duration);
            let middle = 0.5 * (fine.1 + fine.2);
            assert!((middle - slope).abs() < bound * slope.abs(), "{spec}: {middle} {slope}");
        }
    }
    // Where the duration is sought it vanishes, and where a limit of the wheels acts the page says why there is none.
    folder.slew(&["plan", &problem("minimum_time_xte"), "-q", "--report", "time.html"]).ends(0);
    assert!(curve(&data(&folder.read("time.html")), "hamiltonian").iter().all(|value| value.abs() < 1e-3));
    folder.slew(&["plan", &problem("wheels_pyramid"), "-q", "--report", "wheels.html"]).ends(0);
    assert!(folder.read("wheels.html").contains("No Hamiltonian: a limit of the wheels acts"));
}

#[test]
fn a_simulation_has_a_report_and_pictures() {
    let folder = Folder::new();
    folder.slew(&["simulate", &problem("dzhanibekov"), "-q", "-o", "run.json"]).ends(0);
    folder.slew(&["report", "run.json", "-q", "-o", "run.html"]).ends(0).silent();
    let page = folder.read("run.html");
    for id in ["proved", "summary", "limits", "attitude", "kept", "body"] {
        assert!(page.contains(&format!("<section id=\"{id}\">")), "{id}");
    }
    let (data, run) = (data(&page), folder.json("run.json"));
    let energies = run["trajectory"]["energy_j"].as_array().unwrap();
    let last = |values: &[serde_json::Value]| values[values.len() - 1].as_f64().unwrap();
    let drift = curve(&data, "energy");
    let wanted = last(energies) - energies[0].as_f64().unwrap();
    assert!((drift[drift.len() - 1] - wanted).abs() <= 1e-6 * wanted.abs());
    let two = problem("dumbbells");
    let set = ["--set", "simulation.duration_s=2"];
    folder.slew(&[&["simulate", &two, "-q", "-o", "two.json"][..], &set[..]].concat()).ends(0);
    folder.slew(&["report", "two.json", "-q", "-o", "two.html"]).ends(0).silent();
    assert!(folder.read("two.html").contains("<b>Position</b>"));
    folder.slew(&["plot", "run.json", "-q", "-o", "figures"]).ends(0).silent();
    let mut drawn: Vec<String> = fs::read_dir(folder.path("figures"))
        .unwrap()
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .collect();
    drawn.sort();
    let wanted = ["angular_momentum", "energy", "euler", "orthogonality", "quaternion", "rates", "sky"];
    assert_eq!(drawn, wanted.map(|key| format!("{key}.svg")));
    folder.slew(&["plot", "two.json", "-q", "-o", "two.svg", "--charts", "position,energy"]).ends(0);
    assert!(folder.read("two.svg").contains("(b)"));

    // Cut short it is no simulation.
    // One that diverges is cut and says so.
    let run =
        ["simulate", &problem("dzhanibekov"), "-q", "--integrator", "explicit_midpoint", "-o", "away.json"];
    let set = ["--set", "simulation.step_s=1.5", "--set", "simulation.duration_s=150"];
    folder.slew(&[&run[..], &set].concat()).ends(9);
    folder.slew(&["plot", "away.json", "-q", "-o", "away.svg", "--charts", "rates,energy"]).ends(0).silent();
    let drawn = folder.read("away.svg");
    assert_eq!(drawn.matches(">reaches ").count(), 4, "three rates and the energy");
    assert!(!drawn.contains("·10<tspan dy=\"-5\" font-size=\"9.75\">1"), "no axis of 10^16");
    let text = folder.read("run.json");
    fs::write(folder.path("cut.json"), &text[..text.len() / 2]).unwrap();
    folder.slew(&["report", "cut.json", "-o", "a.html"]).ends(8).tells("error[E0102]");
    assert!(!folder.names().contains(&"a.html".to_string()));
}

#[test]
fn a_plan_of_no_time_is_shown_as_what_it_is() {
    let folder = Folder::new();
    let spec = "format = 1\n[body]\ninertia_kg_m2 = [1, 2, 3]\n[actuators]\ntorque_limit_n_m = 1\n[start]\nattitude = { axis = [0, 0, 1], angle_deg = 30 }\n[end]\nattitude = { axis = [0, 0, 1], angle_deg = 30 }\n[maneuver]\nminimize = \"time\"\n";
    fs::write(folder.path("none.toml"), spec).unwrap();
    folder
        .slew(&["plan", "none.toml", "-o", "none.json", "--report", "none.html"])
        .ends(0)
        .tells("0 s: the body is");
    assert!(folder.read("none.html").contains("solved and verified"));
    folder.slew(&["report", "none.json", "-o", "again.html"]).ends(0);
    folder.slew(&["plot", "none.json", "-o", "figures"]).ends(0);
    let compared = folder.slew(&["compare", "none.toml"]);
    assert!(!compared.stderr.contains("panicked"), "{}", compared.stderr);
}
