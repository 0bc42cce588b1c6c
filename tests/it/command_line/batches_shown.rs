//! Files of results as pictures and pages.

use super::binary::Folder;
use std::fs;

#[test]
fn a_sweep_over_one_key_has_its_curve_and_shades_what_failed() {
    let folder = Folder::new();
    let sweep = ["sweep", "spec.toml", "-q", "--set", "actuators.torque_limit_n_m=0.1", "--over"];
    folder.slew(&[&sweep[..], &["maneuver.duration_s=6:20:8", "-o", "sweep.jsonl"]].concat()).ends(9);
    folder.slew(&["plot", "sweep.jsonl", "-o", "figures"]).ends(0).tells("figures/cost.svg");
    let svg = folder.read("figures/cost.svg");
    assert!(svg.contains("Cost over maneuver.duration_s") && svg.contains("not solved"));
    // The picture has one mark for each solved case, and one more in the legend.
    let solved = folder.read("sweep.jsonl").matches("\"status\":\"solved\"").count();
    assert_eq!(svg.matches("<circle").count(), solved + 1);
    folder
        .slew(&["plot", "sweep.jsonl", "-o", "one.svg", "--charts", "map"])
        .ends(2)
        .tells("its pictures are cost");
    folder.slew(&["report", "sweep.jsonl", "-o", "sweep.html"]).ends(0);
    let page = folder.read("sweep.html");
    assert!(page.contains("Cases that failed") && page.contains("infeasible") && page.contains("fig-cost"));
    folder.slew(&["report", "-", "-o", "x.html"]).ends(8);
}

#[test]
fn a_sweep_over_two_keys_has_a_map_with_a_cell_a_case() {
    let folder = Folder::new();
    let over = ["--over", "maneuver.duration_s=8:20:4", "--over", "actuators.torque_limit_n_m=0.01,1,2"];
    folder.slew(&[&["sweep", "spec.toml", "-q", "-o", "sweep.jsonl"], &over[..]].concat()).ends(9);
    folder.slew(&["plot", "sweep.jsonl", "-o", "map.svg", "--charts", "map"]).ends(0);
    let svg = folder.read("map.svg");
    assert!(svg.contains("actuators.torque_limit_n_m") && svg.contains("× not solved"));
    let (cells, none) = (svg.matches("<polygon").count(), svg.matches("fill=\"#f3f3f3\"").count());
    // A frame and 64 stripes of the legend are polygons as well.
    assert_eq!((cells, none), (12 + 1 + 64, 4), "the smallest limit is infeasible everywhere");
    folder.slew(&["report", "sweep.jsonl", "-o", "sweep.html"]).ends(0);
    let page = folder.read("sweep.html");
    assert_eq!(page.matches("<figure id=\"fig-map\"").count(), 1);
}

#[test]
fn random_draws_have_their_distribution_and_hostile_names_are_text() {
    let folder = Folder::new();
    let rows: String =
        (0..40).map(|row| format!("</script><b>{row},{}\n", 10.0 + 0.1 * f64::from(row))).collect();
    fs::write(folder.path("cases.csv"), format!("name,maneuver.duration_s\n{rows}")).unwrap();
    folder.slew(&["batch", "spec.toml", "-q", "--cases", "cases.csv", "-o", "all.jsonl"]).ends(0);
    folder.slew(&["report", "all.jsonl", "-o", "all.html"]).ends(0);
    let page = folder.read("all.html");
    assert!(page.contains("fig-distribution") && page.contains("Costliest cases"));
    assert!(!page.contains("</script><b>") && page.contains("&lt;/script&gt;&lt;b&gt;0"));
    // A file that is still being written is shown up to its last complete line.
    let text = folder.read("all.jsonl");
    fs::write(folder.path("part.jsonl"), &text[..text.len() / 2]).unwrap();
    folder.slew(&["report", "part.jsonl", "-o", "part.html"]).ends(0);
    let there = text[..text.len() / 2].matches('\n').count() - 1;
    let told = format!("{there} of 40 cases done, {there} of them solved and verified");
    assert!(folder.read("part.html").contains(&told), "{told}");
    let shard = ["--cases", "cases.csv", "--shard", "2/3", "-o", "shard.jsonl"];
    folder.slew(&[&["batch", "spec.toml", "-q"], &shard[..]].concat()).ends(0);
    folder.slew(&["report", "shard.jsonl", "-o", "shard.html"]).ends(0);
    assert!(folder.read("shard.html").contains("shard 2/3 of 40 cases: all 13 cases solved and verified"));
    fs::write(folder.path("bad.jsonl"), text.replacen("\"case\":3", "\"case\":-3", 1)).unwrap();
    folder.slew(&["report", "bad.jsonl", "-o", "bad.html"]).ends(8).tells("error[E0114]").tells("line 4");
}

#[test]
fn of_plans_whose_inputs_switch_a_batch_says_what_is_known() {
    let folder = Folder::new();
    let spec = concat!(env!("CARGO_MANIFEST_DIR"), "/../../problems/minimum_time_xte.toml");
    let over = ["sweep", spec, "--over", "maneuver.steps=40,60", "-o", "all.jsonl"];
    // The page of a sweep uses the same words as the page of a plan.
    folder.slew(&over).ends(0).tells("proof       2 local minima to first order");
    folder
        .slew(&["plan", spec, "-o", "one.json"])
        .ends(0)
        .tells("proof       a local minimum to first order; others");
    assert_eq!(folder.json("one.json")["proof"], "first_order");
    folder.slew(&["report", "one.json", "-q", "-o", "one.html"]).ends(0);
    assert!(folder.read("one.html").contains("The plan is a local minimum to first order"));
    let text = folder.read("all.jsonl");
    assert_eq!(text.matches("\"gap\":").count(), 2, "{text}");
    // A smooth plan has no gap.
    folder
        .slew(&["sweep", "spec.toml", "-q", "--over", "maneuver.duration_s=20,30", "-o", "smooth.jsonl"])
        .ends(0);
    let smooth = folder.read("smooth.jsonl");
    assert!(!smooth.contains("gap") && smooth.matches("\"proof\":\"minimum\"").count() == 2, "{smooth}");
}
