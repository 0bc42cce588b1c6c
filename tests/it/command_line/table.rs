//! `slew table`: a coarse table, read back, against `slew plan` and a closed form.

use super::binary::Folder;
use slewkit::{Vector3, lie};
use slewkit_files::table::read_npz;
use std::fs::{self, File};

/// A free body from rest to rest, with the least effort in ten seconds; the discrete motion meets the
/// end, as in a table.
const LEGS: &str = r#"
format = 1
[body]
inertia_kg_m2 = [1, 2, 2.5]
[start]
attitude = { axis = [1, 0, 0], angle_deg = 0 }
[end]
attitude = { rotation_vector_rad = [0, 0, 0.1] }
[maneuver]
duration_s = 10
steps = 100
[solver]
target = "discrete"
"#;

#[test]
fn a_table_has_the_costs_of_plans() {
    let folder = Folder::new();
    fs::write(folder.path("legs.toml"), LEGS).unwrap();
    let args = ["table", "legs.toml", "-o", "slew.npz", "--divisions", "2", "--checks", "10"];
    folder.slew(&args).ends(0).tells("minimum efforts from rest to rest in 10.00 s").tells("10 random turns");
    let table = read_npz(File::open(folder.path("slew.npz")).unwrap()).unwrap();
    let planned = |vector: &Vector3| -> f64 {
        let end = format!("end.attitude.rotation_vector_rad=[{}, {}, {}]", vector.x, vector.y, vector.z);
        let run = folder.slew(&["plan", "legs.toml", "--format", "json", "--set", &end]).ends(0);
        run.json()["cost"].as_f64().unwrap()
    };
    // A node, on a principal axis: 6 J²θ²/T³ is the least effort of a turn about it.
    let angle = table.nodes().angles[table.nodes().angles.len() / 2];
    let node = Vector3::new(0.0, angle, 0.0);
    let value = table.value(&lie::exp(&node));
    assert!((value / planned(&node) - 1.0).abs() < 1e-6, "{value} {}", planned(&node));
    let closed = 6.0 * 2.0_f64.powi(2) * angle.powi(2) / 10.0_f64.powi(3);
    assert!((value / closed - 1.0).abs() < 1e-3, "{value} {closed}");
    // Between nodes a coarse table is as far off as its own checks.
    let between = Vector3::new(0.5, -0.7, 0.4);
    let value = table.value(&lie::exp(&between));
    let error = value / planned(&between) - 1.0;
    let errors = &table.nodes().errors;
    let most = errors.highest.max(-errors.lowest);
    assert!(error.abs() <= most && most < 0.1, "{error} {errors:?}");
    assert!(table.bound(&lie::exp(&between)) <= planned(&between));
    assert_eq!(errors.count, 10);
}

#[test]
fn a_wrong_grid_is_refused_before_any_plan() {
    let folder = Folder::new();
    for (option, told) in [
        ("--divisions=0", "the divisions must be from 1 to 64"),
        ("--settling=-1", "the settling time must not be negative"),
    ] {
        folder.slew(&["table", "spec.toml", "-o", "slew.npz", option]).ends(2).tells(told);
        assert!(!folder.path("slew.npz").exists());
    }
    folder.slew(&["table", "spec.toml"]).ends(2).tells("a table needs a file: -o slew.npz");
}
