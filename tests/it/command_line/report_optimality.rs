//! Hamiltonian and switching functions in reports: the maximum principle and the price of time,
//! drawn.

use super::binary::Folder;
use super::page::{curve, data, picture, points, problem};
use std::fs;

/// The maximum principle in pictures: away from the thresholds an input follows its switching
/// function, and the functions cross the thresholds where arcs of the continuous extremal meet.
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
    // A plan with a limit of the norm burns where the norm of the costate is above the price.
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
    // A turn of a cube about the diagonal of a face: the switching function of one input is zero,
    // and this input stays within its limits all the way.
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

/// The Hamiltonian is the derivative of the least cost by the duration. The cost of a free body
/// from rest to rest is proportional to `T⁻³`, because its equations do not depend on time.
#[test]
fn the_hamiltonian_is_that_of_the_theory() {
    let folder = Folder::new();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "plan.json", "--report", "a.html"]).ends(0);
    let wanted = -3.0 * folder.json("plan.json")["cost"].as_f64().unwrap() / 10.0;
    for value in curve(&data(&folder.read("a.html")), "hamiltonian") {
        assert!((value - wanted).abs() < 2e-3 * wanted.abs(), "{value} {wanted}");
    }
    // The costates in a field belong to places next to the nodes, where the Hamiltonian is constant
    // to second order.
    let pendulum = concat!(env!("CARGO_MANIFEST_DIR"), "/../../problems/pendulum_inversion.toml");
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

/// The Hamiltonian is the derivative of the least cost by the duration, in a turning frame, with
/// wheels, and with torques fixed in the reference frame. The derivative is taken by differences of
/// plans of one extremal, which the quick search finds too.
#[test]
fn the_hamiltonian_is_the_price_of_time() {
    let folder = Folder::new();
    let wheels = fs::read_to_string(problem("wheels_pyramid")).unwrap();
    let free = wheels
        .replace("torque_limit_n_m = 0.2", "torque_limit_n_m = 20")
        .replace("_n_m_s = 1.8", "_n_m_s = 90");
    fs::write(folder.path("wheels.toml"), free.split("[expect]").next().unwrap()).unwrap();
    for (spec, duration, bound) in [
        (problem("orbit_flip"), Some(std::f64::consts::FRAC_PI_2), 2e-2),
        ("wheels.toml".into(), Some(60.0), 2e-3),
        (problem("pendulum_horizontal_torques"), None, 0.0),
    ] {
        let plan = |factor: f64, steps: usize| {
            let steps = format!("maneuver.steps={steps}");
            let set = ["plan", &spec, "-q", "--set", &steps, "--set", "solver.scheme=lie_verlet"];
            let set = [&set[..], &["--set", "solver.search=quick"]].concat();
            let length = duration.map(|duration: f64| format!("maneuver.duration_s={}", factor * duration));
            let timed: Vec<&str> = length.iter().flat_map(|length| ["--set", length]).collect();
            let out = ["-o", "plan.json", "--report", "a.html", "--force"];
            folder.slew(&[&set[..], &timed, &out].concat()).ends(0);
            let values = curve(&data(&folder.read("a.html")), "hamiltonian");
            let (low, high) =
                values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
            (folder.json("plan.json")["cost"].as_f64().unwrap(), low, high)
        };
        let (coarse, fine) = (plan(1.0, 200), plan(1.0, 400));
        let order = ((coarse.2 - coarse.1) / (fine.2 - fine.1)).log2();
        assert!((order - 2.0).abs() < 0.2, "{spec}: {order} {coarse:?} {fine:?}");
        if let Some(duration) = duration {
            let slope = (plan(1.001, 400).0 - plan(0.999, 400).0) / (0.002 * duration);
            let middle = 0.5 * (fine.1 + fine.2);
            assert!((middle - slope).abs() < bound * slope.abs(), "{spec}: {middle} {slope}");
        }
    }
    // The Hamiltonian vanishes if the duration is sought. If a limit of the wheels is active, the
    // page states why it shows no Hamiltonian.
    folder.slew(&["plan", &problem("minimum_time_xte"), "-q", "--report", "time.html"]).ends(0);
    assert!(curve(&data(&folder.read("time.html")), "hamiltonian").iter().all(|value| value.abs() < 1e-3));
    folder.slew(&["plan", &problem("wheels_pyramid"), "-q", "--report", "wheels.html"]).ends(0);
    assert!(folder.read("wheels.html").contains("No Hamiltonian: a limit of the wheels is active"));
}
