//! `slew monte-carlo`: draws have the distributions of the spec, and depend on seed and number
//! alone.

use super::binary::{Folder, SPEC};
use slewkit::lie::{exp, log};
use slewkit::{Matrix3, Vector3};
use slewkit_files::batch::{Batch, Case, Shard};
use slewkit_files::spec::{Base, Format, Override};
use std::fs;

const DISPERSION: &str = r#"
[actuators]
torque_limit_n_m = [5, 6, 7]

[dispersion]
seed = 20261122
cases = 20000

[[dispersion.vary]]
key = "body.inertia_kg_m2"
kind = "normal"
covariance = [[4e-4, 1e-4, 0], [1e-4, 9e-4, 0], [0, 0, 0]]

[[dispersion.vary]]
key = "start.angular_velocity_deg_s"
kind = "ellipsoid"
semi_axes = [[0.1, 0.1, 0], [-0.2, 0.2, 0], [0, 0, 0.4]]

[[dispersion.vary]]
key = "end.attitude.rotation_vector_deg"
kind = "normal"
sigma = [0.5, 1, 2]

[[dispersion.vary]]
key = "actuators.torque_limit_n_m"
kind = "uniform"
half_width_relative = 0.1

[[dispersion.vary]]
key = "maneuver.duration_s"
kind = "normal"
sigma = 0.25
"#;

fn spec() -> String {
    SPEC.replace("angle_deg = 0 }\n", "angle_deg = 0 }\nangular_velocity_deg_s = [1, 0, 0]\n") + DISPERSION
}

fn batch(set: &[&str]) -> Batch {
    let set: Vec<Override> = set.iter().map(|text| Override::parse(text).unwrap()).collect();
    let base = Base::from_reader(spec().as_bytes(), "spec.toml", Format::Toml, &set).unwrap();
    Batch::of_dispersion(base).unwrap()
}

fn draws(batch: &Batch) -> Vec<Case> {
    batch.stream(Shard::ALL, 0).unwrap().map(Result::unwrap).collect()
}

/// Returns the mean and the covariance of the rows.
fn moments<const N: usize>(rows: &[[f64; N]]) -> ([f64; N], [[f64; N]; N]) {
    let count = rows.len() as f64;
    let mean: [f64; N] = std::array::from_fn(|i| rows.iter().map(|row| row[i]).sum::<f64>() / count);
    let product = |i: usize, j: usize| {
        rows.iter().map(|row| (row[i] - mean[i]) * (row[j] - mean[j])).sum::<f64>() / count
    };
    (mean, std::array::from_fn(|i| std::array::from_fn(|j| product(i, j))))
}

/// Requires agreement within five standard errors; the standard error of a covariance is at most
/// √(2 σᵢ² σⱼ²/n) for these distributions.
fn agree<const N: usize>(rows: &[[f64; N]], mean: [f64; N], covariance: [[f64; N]; N]) {
    let count = (rows.len() as f64).sqrt();
    let (found_mean, found) = moments(rows);
    for i in 0..N {
        let error = 5.0 * covariance[i][i].sqrt() / count + 1e-12;
        assert!((found_mean[i] - mean[i]).abs() < error, "mean {i}: {} for {}", found_mean[i], mean[i]);
        for j in 0..N {
            let error = 5.0 * (2.0 * covariance[i][i] * covariance[j][j]).sqrt() / count + 1e-12;
            let (found, wanted) = (found[i][j], covariance[i][j]);
            assert!((found - wanted).abs() < error, "covariance {i}, {j}: {found} for {wanted} ± {error}");
        }
    }
}

#[test]
fn draws_have_the_moments_of_their_distributions() {
    let batch = batch(&[]);
    let cases = draws(&batch);
    assert_eq!((cases.len(), cases[0].set.len()), (20_000, 5));
    let loaded: Vec<_> =
        cases.iter().take(4000).map(|case| batch.read(case).unwrap().maneuver().unwrap()).collect();

    let inertia: Vec<[f64; 3]> =
        loaded.iter().map(|one| one.problem.body.inertia.j().diagonal().into()).collect();
    agree(&inertia, [1.0, 2.0, 2.5], [[4e-4, 1e-4, 0.0], [1e-4, 9e-4, 0.0], [0.0; 3]]);
    assert!(loaded.iter().all(|one| one.problem.body.inertia.j()[(0, 1)] == 0.0));

    // Uniform in an ellipsoid of n dimensions: covariance A Aᵀ/(n + 2), and no point outside.
    let axes = Matrix3::new(0.1, -0.2, 0.0, 0.1, 0.2, 0.0, 0.0, 0.0, 0.4);
    let nominal = Vector3::new(1.0, 0.0, 0.0);
    let rate = |one: &slewkit_files::spec::Loaded| one.problem.start.angular_velocity.map(f64::to_degrees);
    let rates: Vec<[f64; 3]> = loaded.iter().map(|one| rate(one).into()).collect();
    let covariance = axes * axes.transpose() / 5.0;
    agree(&rates, nominal.into(), covariance.transpose().into());
    let inside = |one: &slewkit_files::spec::Loaded| {
        (axes.try_inverse().unwrap() * (rate(one) - nominal)).norm() < 1.0 + 1e-12
    };
    assert!(loaded.iter().all(inside));

    // A rotation vector on the body side of the attitude, which the spec has as Euler angles.
    let turn = |z: f64, y: f64, x: f64| {
        exp(&Vector3::new(0.0, 0.0, z.to_radians()))
            * exp(&Vector3::new(0.0, y.to_radians(), 0.0))
            * exp(&Vector3::new(x.to_radians(), 0.0, 0.0))
    };
    let end = turn(80.0, -25.0, 40.0);
    let offsets: Vec<[f64; 3]> = loaded
        .iter()
        .map(|one| log(&(end.transpose() * one.problem.end.attitude)).map(f64::to_degrees).into())
        .collect();
    agree(&offsets, [0.0; 3], [[0.25, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 4.0]]);

    // Uniform between bounds: variance of half the width squared over three.
    let limits: Vec<[f64; 3]> = loaded
        .iter()
        .map(|one| <[f64; 3]>::try_from(one.problem.actuation.torque.limits().size.clone().unwrap()).unwrap())
        .collect();
    let variance = |limit: f64| (0.1 * limit).powi(2) / 3.0;
    let diagonal = [[variance(5.0), 0.0, 0.0], [0.0, variance(6.0), 0.0], [0.0, 0.0, variance(7.0)]];
    agree(&limits, [5.0, 6.0, 7.0], diagonal);
    let inside = |row: &[f64; 3]| {
        row.iter().zip([5.0, 6.0, 7.0]).all(|(limit, nominal)| (limit / nominal - 1.0).abs() < 0.1)
    };
    assert!(limits.iter().all(inside));

    // Quantiles of the normal distribution, on all draws: 2.275 % below −2 σ, 15.866 % below −σ,
    // half below the mean.
    let durations: Vec<f64> = cases.iter().map(|case| case.set[4].value().parse().unwrap()).collect();
    for (quantile, part) in [(9.5, 0.022_750), (9.75, 0.158_655), (10.0, 0.5), (10.25, 0.841_345)] {
        let below = durations.iter().filter(|value| **value < quantile).count() as f64 / 20_000.0;
        let error = 5.0 * (part * (1.0 - part) / 20_000.0_f64).sqrt();
        assert!((below - part).abs() < error, "{below} for {part} ± {error}");
    }
}

#[test]
fn a_draw_depends_on_seed_number_and_place_alone() {
    let all = draws(&batch(&[]));
    assert_eq!(draws(&batch(&["dispersion.cases=3"])), all[..3]);
    assert_eq!(batch(&[]).case(17_000).unwrap(), all[16_999]);
    let shard = Shard::new(2, 3).unwrap();
    let own: Vec<Case> = batch(&[]).stream(shard, 5).unwrap().map(Result::unwrap).take(2).collect();
    assert_eq!(own, [all[16].clone(), all[19].clone()]);
    // Another quantity and its distribution change no number of this one.
    let other = batch(&[
        "dispersion.vary.0.key=maneuver.duration_s",
        "dispersion.vary.0.covariance=[1]",
        "dispersion.vary.4.key=body.inertia_kg_m2",
    ]);
    assert_eq!(other.case(9).unwrap().set[1..4], all[8].set[1..4]);
    assert_ne!(batch(&["dispersion.seed=1"]).case(1).unwrap(), all[0]);
}

#[test]
fn attitudes_keep_their_whole_turns() {
    let turned = SPEC.replace(
        "attitude = { euler_zyx_deg = [80, -25, 40] }",
        "rotation_from_start = { axis = [1, 0, 0], angle_deg = 480 }",
    );
    let spec = turned
        + "[dispersion]\nseed = 3\ncases = 50\n[[dispersion.vary]]\n\
            key = \"end.rotation_from_start.rotation_vector_rad\"\nkind = \"uniform\"\nhalf_width = 0.01\n";
    let batch =
        Batch::of_dispersion(Base::from_reader(spec.as_bytes(), "spec.toml", Format::Toml, &[]).unwrap())
            .unwrap();
    let wanted = Vector3::new(480_f64.to_radians(), 0.0, 0.0);
    for case in draws(&batch) {
        let loaded = batch.read(&case).unwrap().maneuver().unwrap();
        let slewkit::maneuver::Path::AsGiven(turn) = loaded.problem.path else { panic!("{case:?}") };
        let offset = log(&(exp(&wanted).transpose() * exp(&turn)));
        assert!(offset.amax() < 0.01 && (turn - wanted).norm() < 0.2, "{turn}");
    }
}

#[test]
fn cases_are_planned_as_drawn_and_bad_draws_are_counted() {
    let folder = Folder::new();
    // A thin body: some of the inertias that are drawn break the triangle inequality.
    let spec = SPEC.replace("[1, 2, 2.5]", "[1, 2, 2.9]")
        + "[dispersion]\nseed = 5\ncases = 24\n[[dispersion.vary]]\nkey = \"body.inertia_kg_m2\"\n\
            kind = \"normal\"\nsigma = [0.1, 0.1, 0.1]\n";
    fs::write(folder.path("thin.toml"), spec).unwrap();
    let command = ["monte-carlo", "thin.toml", "-o", "all.jsonl", "--threads", "2"];
    let run = folder.slew(&command).ends(9).tells("Monte Carlo of 24 cases").tells("E0042");
    let run = run.tells("spec invalid: case").tells("again       slew monte-carlo thin.toml --case ");
    let text = folder.read("all.jsonl");
    let lines: Vec<serde_json::Value> =
        text.lines().skip(1).map(|line| serde_json::from_str(line).unwrap()).collect();
    let (bad, good): (Vec<_>, Vec<_>) = lines.iter().partition(|line| line["status"] == "spec_invalid");
    assert!(bad.len() > 1 && good.len() > 10, "{} and {}: {}", bad.len(), good.len(), run.stderr);
    assert!(
        bad.iter()
            .all(|line| line["error"]["code"] == "E0042" && line["set"]["body.inertia_kg_m2"].is_array())
    );
    // The same case three ways: of the run, by its number, by its values.
    let line = good[1];
    let case = line["case"].to_string();
    folder.slew(&["monte-carlo", "thin.toml", "--case", &case, "-q", "-o", "plan.json"]).ends(0).silent();
    assert_eq!(folder.json("plan.json")["cost"], line["cost"]);
    let set = format!("body.inertia_kg_m2={}", line["set"]["body.inertia_kg_m2"]);
    let plan = folder.slew(&["plan", "thin.toml", "-q", "--format", "json", "--set", &set]).ends(0).json();
    assert_eq!((&plan["cost"], &plan["terminal"]), (&line["cost"], &line["terminal"]));
    // Any division of the work gives the same bytes.
    for shard in ["1/2", "2/2"] {
        let part = format!("part{}.jsonl", &shard[..1]);
        folder.slew(&["monte-carlo", "thin.toml", "-q", "-o", &part, "--shard", shard]).ends(9);
    }
    folder.slew(&["merge", "part1.jsonl", "part2.jsonl", "-o", "merged.jsonl"]).ends(0);
    assert_eq!(folder.read("merged.jsonl"), text);
}

#[test]
fn a_dispersion_that_is_none_is_refused_at_its_place() {
    let folder = Folder::new();
    let entry =
        |lines: &str| format!("{SPEC}[dispersion]\nseed = 1\ncases = 5\n[[dispersion.vary]]\n{lines}\n");
    for (spec, code, why) in [
        (format!("{SPEC}[dispersion]\ncases = 5\n"), "E0021", "needs `seed`"),
        (
            entry("key = \"body.inertia\"\nkind = \"normal\"\nsigma = 1"),
            "E0020",
            "did you mean `body.inertia_kg_m2`?",
        ),
        (
            entry("key = \"maneuver.duration_s\"\nkind = \"gaussian\"\nsigma = 1"),
            "E0020",
            "\"gaussian\" is not one of",
        ),
        (
            entry("key = \"maneuver.duration_s\"\nkind = \"normal\"\nhalf_width = 1"),
            "E0020",
            "does not belong to kind",
        ),
        (entry("key = \"maneuver.duration_s\"\nkind = \"normal\""), "E0021", "needs `sigma`"),
        (
            entry("key = \"maneuver.duration_s\"\nkind = \"normal\"\nsigma = 1\nsigma_relative = 0.1"),
            "E0028",
            "both",
        ),
        (entry("key = \"maneuver.duration_s\"\nkind = \"normal\"\nsigma = -1"), "E0032", "sigma"),
        (entry("key = \"maneuver.duration_s\"\nkind = \"normal\"\nsigma = [1, 2]"), "E0026", "has 1"),
        (entry("key = \"maneuver.steps\"\nkind = \"normal\"\nsigma = 1"), "E0160", "is a count"),
        (entry("key = \"maneuver.path\"\nkind = \"normal\"\nsigma = 1"), "E0160", "has no value for it"),
        (entry("key = \"name\"\nkind = \"normal\"\nsigma = 1"), "E0160", "holds no numbers"),
        (
            entry("key = \"end.attitude\"\nkind = \"normal\"\nsigma = 1"),
            "E0160",
            "end.attitude.rotation_vector_deg",
        ),
        (
            entry("key = \"start.angular_velocity_deg_s\"\nkind = \"normal\"\nsigma = 1"),
            "E0160",
            "has no value for it",
        ),
        (
            entry("key = \"body.inertia_kg_m2\"\nkind = \"normal\"\nsigma = [1, 2, 3, 4]"),
            "E0026",
            "3 (the diagonal) or 6",
        ),
        (
            entry(
                "key = \"body.inertia_kg_m2\"\nkind = \"normal\"\ncovariance = [[1, 2, 0], [2, 1, 0], [0, 0, 1]]",
            ),
            "E0160",
            "the negative eigenvalue -1",
        ),
        (
            entry(
                "key = \"body.inertia_kg_m2\"\nkind = \"normal\"\ncovariance = [[1, 2, 0], [0, 1, 0], [0, 0, 1]]",
            ),
            "E0160",
            "not symmetric",
        ),
        (
            entry("key = \"end.attitude.rotation_vector_deg\"\nkind = \"normal\"\nsigma_relative = 0.1"),
            "E0160",
            "no magnitude",
        ),
        (
            entry(
                "key = \"body.inertia_kg_m2\"\nkind = \"normal\"\nsigma = 1\n[[dispersion.vary]]\n\
                    key = \"body.inertia_kg_m2\"\nkind = \"normal\"\nsigma = 1",
            ),
            "E0011",
            "already varies",
        ),
    ] {
        fs::write(folder.path("bad.toml"), &spec).unwrap();
        for command in ["check", "monte-carlo"] {
            let run = folder.slew(&[command, "bad.toml"]).ends(3);
            assert!(
                run.stderr.contains(&format!("error[{code}]")) && run.stderr.contains(why),
                "{spec}{}",
                run.stderr
            );
        }
    }
    folder.slew(&["monte-carlo", "spec.toml"]).ends(2).tells("error[E0160]").tells("[[dispersion.vary]]");
    // Planned by itself, the spec means its nominal values.
    fs::write(folder.path("mc.toml"), entry("key = \"maneuver.duration_s\"\nkind = \"normal\"\nsigma = 1"))
        .unwrap();
    let plan = |name| folder.slew(&["plan", name, "-q", "--format", "json"]).ends(0).json();
    assert_eq!(plan("mc.toml")["cost"], plan("spec.toml")["cost"]);
}

/// The script for a cluster, with the variables that Slurm sets.
#[cfg(unix)]
#[test]
fn the_array_script_gives_shards_that_merge() {
    let folder = Folder::new();
    let dispersion = "[dispersion]\nseed = 1\ncases = 7\n[[dispersion.vary]]\nkey = \"maneuver.duration_s\"\n\
        kind = \"uniform\"\nhalf_width = 2\n";
    fs::write(folder.path("mc.toml"), format!("{SPEC}{dispersion}")).unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/slurm_array.sh");
    for task in ["1", "2", "3"] {
        let mut shell = std::process::Command::new("bash");
        shell.args([script, "mc.toml", "results", "3"]).current_dir(folder.path("."));
        shell.env("SLEW", env!("CARGO_BIN_EXE_slew"));
        shell.env("SLURM_ARRAY_TASK_ID", task);
        let output = shell.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let shards = ["results/shard-1.jsonl", "results/shard-2.jsonl", "results/shard-3.jsonl"];
    folder
        .slew(&[&["merge"], &shards[..], &["-o", "all.jsonl"]].concat())
        .ends(0)
        .tells("7 cases of 3 shards");
    folder.slew(&["monte-carlo", "mc.toml", "-q", "-o", "whole.jsonl"]).ends(0);
    assert_eq!(folder.read("all.jsonl"), folder.read("whole.jsonl"));
}

#[test]
fn check_tells_what_is_drawn() {
    let folder = Folder::new();
    fs::write(folder.path("spec.toml"), spec()).unwrap();
    let told = "dispersion  body.inertia_kg_m2, start.angular_velocity_deg_s, ";
    folder.slew(&["check", "spec.toml"]).ends(0).tells(told).tells("20000 cases, for `slew monte-carlo`");
}
