//! `slew convert` and `simulate` from the command line alone.

use super::binary::Folder;
use serde_json::Value;

#[test]
fn simulate_follows_a_spinning_body_for_a_turn() {
    let folder = Folder::new();
    // 36 deg/s about a principal axis: one turn in ten seconds.
    let spin = ["--set", "start.angular_velocity_deg_s=[0, 0, 36]"];
    let simulate = |more: &[&str]| {
        let mut args = vec!["simulate", "spec.toml"];
        args.extend(spin);
        args.extend(more);
        folder.slew(&args)
    };
    let json = simulate(&["--format", "json", "--integrator", "verner98"]).ends(0).tells("energy").json();
    let q: [f64; 4] = serde_json::from_value(json["trajectory"]["quaternion_wxyz"][100].clone()).unwrap();
    assert!((q[0] + 1.0).abs() < 1e-13 && q[3].abs() < 1e-12, "a full turn changes the sign: {q:?}");
    let half: [f64; 4] = serde_json::from_value(json["trajectory"]["quaternion_wxyz"][50].clone()).unwrap();
    assert!((half[3] - 1.0).abs() < 1e-13, "{half:?}");

    let table = simulate(&["-q", "--format", "csv", "--steps", "1000", "--stride", "250"]).ends(0).silent();
    let times: Vec<&str> = table.stdout.lines().skip(1).map(|line| line.split(',').next().unwrap()).collect();
    assert_eq!(times, ["0.0", "2.5", "5.0", "7.5", "10.0"]);
    let columns = table.stdout.lines().map(|line| line.split(',').count()).collect::<Vec<_>>();
    assert_eq!(columns, [13; 6]);

    let pushed = simulate(&["-q", "--format", "jsonl", "--inputs", "0,0,0.1"]).ends(0);
    let last: Value = serde_json::from_str(pushed.stdout.lines().last().unwrap()).unwrap();
    let momentum = last["angular_momentum_n_m_s"][2].as_f64().unwrap();
    assert!((momentum - (2.5 * 36_f64.to_radians() + 1.0)).abs() < 1e-12, "{momentum}");
    simulate(&["--inputs", "0,0"]).ends(2).tells("--inputs");
    simulate(&["--inputs", "0,0,nan"]).ends(2).tells("finite");
    simulate(&["--steps", "0"]).ends(2);
    simulate(&["--steps", "1000000000", "--format", "json"]).ends(2).tells("--stride");
    simulate(&["--steps", "2", "-o", "none.csv"]).ends(5).tells("increase `--steps`");
    assert_eq!(folder.names(), ["spec.toml"]);
}

#[test]
fn convert_gives_every_notation_and_each_reads_back() {
    let folder = Folder::new();
    let attitudes = [
        "euler_zyx_deg = [10, 20, 150]",
        "quaternion_xyzw = [0.5, -0.5, 0.5, 0.5]",
        "{ axis = [1, 2, 3], angle_deg = -170 }",
        "attitude = { euler_xyz_deg = [0, 90, 30] }",
        "axis = [0, 0, 1], angle_deg = 180",
        "matrix = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]",
        "rotation_vector_rad = [1e-9, 0, 0]",
        "euler_zxz_deg = [30, 180, 40]",
    ];
    let wxyz = |text: &str| {
        let run = folder.slew(&["convert", text, "--format", "json", "-q"]).ends(0);
        serde_json::from_value::<[f64; 4]>(run.json()["quaternion_wxyz"].clone()).unwrap()
    };
    for text in attitudes {
        let run = folder.slew(&["convert", text]).ends(0).silent();
        let wanted = wxyz(text);
        let mut lines: Vec<&str> = run.stdout.lines().collect();
        // Rodrigues parameters of half a turn are infinite.
        let infinite = !lines.iter().any(|line| line.starts_with("rodrigues"));
        assert_eq!(lines.len(), if infinite { 22 } else { 23 }, "{}", run.stdout);
        assert!(
            !infinite || lines.iter().any(|line| line.starts_with("angle_deg = 180.0")),
            "{}",
            run.stdout
        );
        let part = |name: &str, lines: &mut Vec<&str>| {
            let at = lines.iter().position(|line| line.starts_with(name)).unwrap();
            lines.remove(at).to_string()
        };
        let (axis, angle) = (part("axis", &mut lines), part("angle_deg", &mut lines));
        let pair = format!("{axis}, {angle}");
        lines.push(&pair);
        let pointing = ["ra_deg", "dec_deg", "roll_deg"].map(|name| part(name, &mut lines)).join(", ");
        lines.push(&pointing);
        for line in lines {
            let found = wxyz(line);
            let dot: f64 = wanted.iter().zip(found).map(|(a, b)| a * b).sum();
            let apart =
                wanted.iter().zip(found).map(|(a, b)| (a * dot.signum() - b).abs()).fold(0.0, f64::max);
            // Sixteen digits of an angle near 180 deg are 3e-16 of a turn; two conversions.
            assert!(apart < 4e-15, "{text} as {line}: {wanted:?}, {found:?}");
        }
    }
}

#[test]
fn convert_explains_what_is_wrong_with_an_attitude() {
    let folder = Folder::new();
    folder.slew(&["convert", "quaternion = [1, 0, 0, 0]"]).ends(3).tells("attitude:1:").tells("E0052");
    folder.slew(&["convert", "euler_zyx_deg = [10, 20]"]).ends(3).tells("E0026");
    folder.slew_with_stdin(&["convert", "-"], "axis = [0, 0, 1], angle_deg = 90\n").ends(0);
}
