//! Counts how many plan files with one damaged figure `slew verify`, `slew report` or `slew export`
//! report as verified.
//!
//! `cargo run --release -p evidence -- damaged [CASES [SEED]]`, 100 cases of each kind by default.
//! The second column counts the same files if they are marked as written by another program, so
//! that their checksum is not checked. Only the witnesses can then detect the damage. They cannot
//! check figures that do not follow from the motion: costates, gains, and claims of the search.
//!
//! The command ends with 1 if a damaged file is reported as verified, or if an undamaged one is
//! not.

use evidence::Random;
use evidence::damaged::{Called, DAMAGES, Files, called};
use evidence::words::Words;

pub fn run(words: &mut Words) -> Result<(), Box<dyn std::error::Error>> {
    let (count, seed) = (words.number("number of cases", 100_usize)?, words.number::<u64>("seed", 1)?);
    words.end()?;
    let files = Files::new()?;
    let all = Called { verify: true, report: true, export: true };
    let refused = files.all().iter().filter(|file| called(file) != all).count();
    println!("{} right files: {refused} not called verified", files.all().len());
    println!("{:<12} {:>8} {:>20}", "damaged", "verified", "by witnesses alone");
    let (mut wrong, mut open) = (0, 0);
    for (kind, damage) in DAMAGES.into_iter().enumerate() {
        let (mut verified, mut unsealed) = (0, 0);
        for index in 0..count {
            let mut random = Random::of_case(seed, kind * count + index);
            let (mut file, what) = files.damaged(damage, &mut random);
            let found = called(&file);
            if found.verified() {
                verified += 1;
                println!("{damage:?}, case {index}, {what}: {found:?}");
            }
            file["generator"] = "another program".into();
            unsealed += usize::from(called(&file).verified());
        }
        println!("{:<12} {verified:>8} {unsealed:>20}", format!("{damage:?}"));
        (wrong, open) = (wrong + verified, open + unsealed);
    }
    let all = count * DAMAGES.len();
    println!("{all} damaged files: {wrong} called verified; {open} by the witnesses alone");
    if wrong + refused > 0 { Err("see above".into()) } else { Ok(()) }
}
