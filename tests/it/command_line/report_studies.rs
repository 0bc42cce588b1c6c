//! Pages and pictures of comparisons and simulations.

use super::binary::Folder;
use super::page::{curve, data, picture, points, problem, row};
use std::fs;

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
    // The methods found the same motion, although they share only the problem.
    for curve in picture(&data, "difference")["curves"].as_array().unwrap() {
        assert!(points(&data, curve).iter().all(|point| point.1 < 1e-3));
    }
    let cost = document["methods"][0]["cost"].as_f64().unwrap();
    for method in ["shooting", "scp", "scp + polish"] {
        let shown: f64 = row(&page, method)[1].parse().unwrap();
        assert!((shown / cost - 1.0).abs() < 1e-9, "{method} {shown} {cost}");
    }
    // The page has the numbers of the document, and states where the motions are.
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
        // The drawn inputs have the effort of the table.
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

    // Cut short it is no simulation. A curve that diverges is cut, and its name states so.
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
