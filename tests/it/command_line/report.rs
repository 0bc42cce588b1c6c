//! `slew report` and `slew plot`: contents of the files, escaped text, refusals.

use super::binary::{Folder, SPEC};
use super::page::{data, picture, problem};
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
    // The only address is the namespace of SVG, from which nothing is fetched.
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
    // The numbers of the data equal the numbers of the plan to the digits that they have.
    let (data, plan) = (data(&page), folder.json("plan.json"));
    for row in [0, 37, 100] {
        for part in 0..4 {
            let shown = data["body"]["quaternion"][row][part].as_f64().unwrap();
            let recorded = plan["trajectory"]["quaternion_wxyz"][row][part].as_f64().unwrap();
            assert!((shown - recorded).abs() < 1e-6);
        }
    }
    // The report of the plan file is an equal page, except for the time, which the file holds to
    // all its digits.
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
        // Font sizes are absolute: one renderer takes a percentage relative to the page.
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
    assert!(page.contains("No plan exists, and this is proved") && !page.contains("<figure"));
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
        .tells("slew plan spec.toml -o plan.json");
    folder.slew(&["plot", "spec.toml", "-o", "a.svg"]).ends(8).tells("not a plan file");
    folder.slew(&["report", "absent.json", "-o", "a.html"]).ends(8).tells("cannot read absent.json");
    folder.slew(&["report", "plan.json", "-o", "a.txt"]).ends(2).tells("must end in .html");
    folder.slew(&["plan", "spec.toml", "--report", "a.json"]).ends(2).tells("must end in .html");
    folder.slew(&["plot", "plan.json", "-o", "a.jpg"]).ends(2).tells("pictures are .svg, .png or .pdf");
    folder
        .slew(&["plot", "plan.json", "-o", "a.svg", "--charts", "forces"])
        .ends(2)
        .tells("this file has no picture \"forces\"");
    folder
        .slew(&["plot", "plan.json", "-o", "a.svg", "--charts", "momentum"])
        .ends(2)
        .tells("no picture is called \"momentum\"; its pictures are sky, inputs,")
        .tells("see `slew plot --help`");
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
    let names = "epoch = \"2026-11-21T07:00:00 UTC\"\n[names]\nobject = \"PROBE\"\n\
        reference_frame = \"J2000\"\n\n[body]";
    fs::write(folder.path("named.toml"), named.replacen("[body]", names, 1)).unwrap();
    folder.slew(&["plan", "named.toml", "-q", "-o", "named.json"]).ends(0);
    folder.slew(&["report", "named.json", "-q", "-o", "named.html"]).ends(0);
    let page = folder.read("named.html");
    let data = super::page::data(&page);
    let curves = picture(&data, "switching")["curves"].as_array().unwrap();
    assert_eq!((&curves[0]["name"], &curves[7]["name"]), (&"A <1>".into(), &"thruster 8".into()));
    assert!(page.contains("reference frame J2000") && page.contains("<dd>PROBE</dd>"));
    assert!(page.contains("2026-11-21T07:00:00") && page.contains("from body axes to J2000"));
}

#[test]
fn a_plan_of_no_time_is_shown_as_what_it_is() {
    let folder = Folder::new();
    let spec = "format = 1\n[body]\ninertia_kg_m2 = [1, 2, 3]\n[actuators]\ntorque_limit_n_m = 1\n[start]\n\
        attitude = { axis = [0, 0, 1], angle_deg = 30 }\n[end]\nattitude = { axis = [0, 0, 1], angle_deg = \
        30 }\n[maneuver]\nminimize = \"time\"\n";
    fs::write(folder.path("none.toml"), spec).unwrap();
    folder
        .slew(&["plan", "none.toml", "-o", "none.json", "--report", "none.html"])
        .ends(0)
        .tells("the global minimum: the body is already in its end attitude");
    assert!(folder.read("none.html").contains("solved and verified"));
    folder.slew(&["report", "none.json", "-o", "again.html"]).ends(0);
    folder.slew(&["plot", "none.json", "-o", "figures"]).ends(0);
    let compared = folder.slew(&["compare", "none.toml"]);
    assert!(!compared.stderr.contains("panicked"), "{}", compared.stderr);
}

const THRUSTERS: &str = r#"
format = 1
name = "Pulses at both ends"
body.inertia_kg_m2 = [20, 30, 40]
start.attitude = { axis = [0, 0, 1], angle_deg = 0 }
end.attitude = { axis = [0, 0, 1], angle_deg = 20 }
maneuver = { minimize = "fuel", duration_s = 300 }
[[constraint]]
kind = "keep_out"
name = "Sun"
boresight_body = [0, 0, 1]
boresight_name = "telescope"
direction_inertial = { vector = [1, 0, 1] }
half_angle_deg = 20
[actuators]
thruster = [
    { name = "A", position_m = [0.5, 0, 0], force_direction_body = [0, 1, 0], force_limit_n = 2 },
    { name = "B", position_m = [0.5, 0, 0], force_direction_body = [0, -1, 0], force_limit_n = 2 },
    { name = "C", position_m = [0, 0.5, 0], force_direction_body = [0, 0, 1], force_limit_n = 2 },
    { name = "D", position_m = [0, 0.5, 0], force_direction_body = [0, 0, -1], force_limit_n = 2 },
    { name = "E", position_m = [0, 0, 0.5], force_direction_body = [1, 0, 0], force_limit_n = 2 },
    { name = "F", position_m = [0, 0, 0.5], force_direction_body = [-1, 0, 0], force_limit_n = 2 },
]
"#;

/// The page begins with the figures of the plan; firings of seconds in minutes can be seen;
/// boresights have the names that the spec gives them; thrusters by force are forces in tables.
#[test]
fn a_page_begins_with_its_figures_and_shows_short_firings() {
    let folder = Folder::new();
    fs::write(folder.path("spec.toml"), THRUSTERS).unwrap();
    folder.slew(&["plan", "spec.toml", "-o", "plan.json"]).ends(0).tells("Sun (telescope): ");
    assert_eq!(folder.json("plan.json")["spec"]["constraint"][0]["boresight_name"], "telescope");
    folder.slew(&["report", "plan.json", "-q", "-o", "plan.html"]).ends(0);
    let page = folder.read("plan.html");
    let tiles = page.split("<dl class=\"tiles\">").nth(1).unwrap().split("</dl>").next().unwrap();
    for told in [
        "<dt>duration</dt><dd><b>300 s</b>",
        "<b>20.0°</b>",
        "peak thrust",
        "100 % of 2 N, ",
        "least clearance",
        "Sun for telescope at ",
    ] {
        assert!(tiles.contains(told), "{told}: {tiles}");
    }
    assert!(page.find("class=\"tiles\"").unwrap() < page.find("id=\"summary\"").unwrap());
    assert!(page.contains("\"name\":\"telescope\""));
    folder.slew(&["plot", "plan.json", "-q", "-o", "figures", "--charts", "firings"]).ends(0);
    let firings = folder.read("figures/firings.svg");
    assert!(firings.contains("s off</text>"), "no coast is left out: {firings}");
    folder.slew(&["export", "plan.json", "-q", "-o", "plan.csv"]).ends(0);
    let table = folder.read("plan.csv");
    let heads: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let at = heads.iter().position(|head| *head == "input_A_n").unwrap_or_else(|| panic!("{heads:?}"));
    let most = table.lines().skip(1).filter_map(|line| line.split(',').nth(at)?.parse::<f64>().ok());
    assert!((most.fold(0.0, f64::max) - 2.0).abs() < 1e-6);
}
