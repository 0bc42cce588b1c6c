//! `slew timeline`: reports, conversions, plans and refusals.

use super::binary::Folder;
use slewkit_files::exchange::read_attitudes;
use slewkit_files::pointing::{Roll, Target, read_pointing};
use std::fs;

/// Two observations of ten minutes, and five minutes between them.
const PTR: &str = r#"<prm><body><segment><data><timeline frame="SC">
<block ref="OBS"><startTime>2032-12-26T10:15:31</startTime><endTime>2032-12-26T10:25:31</endTime>
<attitude ref="inertial"><boresight ref="SC_Zaxis"/>
<phaseAngle ref="align"><SCAxis frame="SC"><x>1</x><y>0</y><z>0</z></SCAxis>
<inertialAxis frame="EME2000"><x>0</x><y>0</y><z>1</z></inertialAxis></phaseAngle>
<target frame="EME2000"><lon units="deg">235.671</lon><lat units="deg">-34.7104</lat></target></attitude></block>
<block ref="SLEW"/>
<block ref="OBS"><startTime>2032-12-26T10:30:31</startTime><endTime>2032-12-26T10:40:31</endTime>
<attitude ref="inertial"><boresight ref="SC_Zaxis"/>
<phaseAngle ref="align"><SCAxis frame="SC"><x>1</x><y>0</y><z>0</z></SCAxis>
<inertialAxis frame="EME2000"><x>0</x><y>0</y><z>1</z></inertialAxis></phaseAngle>
<target frame="EME2000"><lon units="deg">83.633</lon><lat units="deg">22.014</lat></target></attitude>
<metadata><comment>Crab</comment></metadata></block>
</timeline></data></segment></body></prm>
"#;

const CRAFT: &str = r#"format = 1
epoch = "2032-12-26T10:10:31 UTC"
[names]
object = "IMAGER"
reference_frame = "EME2000"
body_frame = "SC"
[body]
inertia_kg_m2 = [[120, 4, -3], [4, 100, 2], [-3, 2, 80]]
[actuators]
torque_axes_body = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
torque_limit_n_m = 0.2
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[end]
attitude = { axis = [0, 0, 1], angle_deg = 30 }
[maneuver]
minimize = "time"
steps = 60
"#;

fn folder() -> Folder {
    let folder = Folder::new();
    fs::write(folder.path("requests.ptx"), PTR).unwrap();
    fs::write(folder.path("craft.toml"), CRAFT).unwrap();
    folder
}

#[test]
fn a_timeline_is_read_and_converted() {
    let folder = folder();
    let told = folder.slew(&["timeline", "requests.ptx"]).ends(0);
    let told = told.tells("2 observations, 1200 s observed").tells("Crab");
    told.tells("300.00 s");
    folder.slew(&["timeline", "requests.ptx", "-o", "requests.xml"]).ends(0).tells("wrote");
    folder.slew(&["timeline", "requests.xml", "-o", "again.ptx"]).ends(0);
    let json = |file: &str| {
        folder.slew(&["timeline", file, "-q", "--format", "json"]).ends(0).json()["observations"].clone()
    };
    let first = json("requests.ptx");
    assert_eq!(first[1]["name"], "Crab");
    assert_eq!(first[0]["begins"], "2032-12-26T10:15:31.000 UTC");
    assert_eq!(first[1]["slew"]["available_s"], 300.0);
    for file in ["requests.xml", "again.ptx"] {
        assert_eq!(json(file), first, "{file}");
    }
}

#[test]
fn slews_of_a_timeline_are_planned_within_their_time() {
    let folder = folder();
    let planned = ["timeline", "requests.ptx", "--spec", "craft.toml"];
    let with = |more: &[&str]| folder.slew(&[&planned[..], more].concat());
    let told = with(&["-o", "resolved.ptx", "--plan", "attitude.aem", "--report", "day.html"]).ends(0);
    told.tells("planned and verified").tells("wrote");
    let resolved = folder.read("resolved.ptx");
    assert_eq!(resolved.matches("<block ref=\"SLEW\"/>").count(), 1);
    assert!(folder.read("day.html").contains("Crab"));

    // The AEM holds the attitude of each observation all through it.
    let attitudes = read_attitudes(folder.read("attitude.aem").as_bytes(), "attitude.aem").unwrap();
    let file = read_pointing(resolved.as_bytes(), "resolved.ptx").unwrap();
    for observation in &file.observations {
        let Target::Inertial(target) = observation.target else { panic!() };
        let wanted = observation.attitude(&target).unwrap();
        for share in [0.0, 0.5, 1.0] {
            let moment = observation.begin.after(share * observation.lasting());
            let found = attitudes.at(moment.since(&attitudes.epoch.unwrap())).unwrap();
            let off = slewkit::lie::rotation_from_quaternion(&found) - wanted;
            assert!(off.norm() < 1e-5, "{share}: {off}");
        }
    }

    // A slew of least effort lasts as long as the timeline allows, and is not late.
    let effort = with(&["--set", "maneuver.minimize=effort", "--set", "maneuver.duration_s=60"]);
    effort.ends(0).tells("   300.00 s   300.00 s");

    // A weak craft takes too long for the second slew.
    let late = with(&["--set", "actuators.torque_limit_n_m=0.01"]).ends(5);
    late.tells("not planned as requested").tells("the slew to Crab takes").tells("and has 300 s");

    // A free roll is found, and given.
    let free = folder.read("requests.ptx");
    let mut file = read_pointing(free.as_bytes(), "requests.ptx").unwrap();
    file.observations[1].roll = Roll::Free;
    let mut prm = Vec::new();
    file.write_prm(&file.observations[0].begin, "TEST", &mut prm).unwrap();
    fs::write(folder.path("free.xml"), prm).unwrap();
    folder.slew(&["timeline", "free.xml", "-o", "free.ptx"]).ends(2).tells("E0145");
    folder.slew(&["timeline", "free.xml", "--spec", "craft.toml", "-o", "free.ptx"]).ends(0);
    let found = read_pointing(folder.read("free.ptx").as_bytes(), "free.ptx").unwrap();
    assert!(matches!(found.observations[1].roll, Roll::Referred { .. }));
}

#[test]
fn a_timeline_that_cannot_be_planned_is_refused() {
    let folder = folder();
    fs::write(folder.path("other.ptx"), PTR.replace("SC_Zaxis", "SC_HGA")).unwrap();
    folder.slew(&["timeline", "other.ptx"]).ends(8).tells("other.ptx:3:").tells("E0154");
    folder.slew(&["timeline", "none.ptx"]).ends(8).tells("E0090");
    folder.slew(&["timeline", "requests.ptx", "-o", "out.json"]).ends(2).tells("E0105");
    folder.slew(&["timeline", "requests.ptx", "-o", "requests.ptx", "--force"]).ends(8).tells("E0100");
    folder.slew(&["timeline", "requests.ptx", "--plan", "plan.json"]).ends(2).tells("--spec");
    let planned = ["timeline", "requests.ptx", "--spec", "craft.toml", "--set"];
    let with = |set: &str| folder.slew(&[&planned[..], &[set]].concat());
    with("epoch=2032-12-26T10:20:00 UTC").ends(8).tells("E0155").tells("from the start of the maneuver");
    with("names.reference_frame=LVLH").ends(8).tells("E0152");
    with("names.body_frame=CAMERA").ends(8).tells("E0152");
    assert_eq!(folder.names(), ["craft.toml", "other.ptx", "requests.ptx", "spec.toml"]);
}
