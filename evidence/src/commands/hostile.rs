//! Feeds hostile inputs to all readers: specs in TOML and JSON, overrides, plan files, surfaces,
//! tables of cases, attitude files.
//!
//! `cargo run --release -p evidence -- hostile [COUNT [SEED]]` reads COUNT inputs (100,000 by
//! default). Every input is a valid one with up to three changes of bytes, numbers, words or lines,
//! which may come from another input. These results count as wrong: a panic; a refusal without a
//! place, a reason or a remedy; and, on Linux, more than a second of CPU time.
//!
//! The command ends with 1 if a result was wrong.

use evidence::Random;
use evidence::hostile::{Answer, Corpus, READERS};
use evidence::process::own_cpu_seconds;
use evidence::words::Words;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The largest accepted CPU time for an input \[s\].
const LONGEST: f64 = 1.0;

pub fn run(words: &mut Words) -> Result<(), Box<dyn std::error::Error>> {
    let (count, seed) = (words.number("number of inputs", 100_000)?, words.number::<u64>("seed", 1)?);
    words.end()?;
    let corpus = Corpus::new()?;
    // Panics are printed below, together with their input.
    std::panic::set_hook(Box::new(|_| {}));
    let mut counts = [[0_u64; 2]; READERS.len()];
    let (mut panics, mut hangs, mut silent) = (0, 0, 0);
    for index in 0..count {
        let turn = (index % READERS.len() as u64) as usize;
        let reader = READERS[turn];
        // An input depends only on the seed and its index.
        let bytes = corpus.input(reader, &mut Random::new(seed << 40 | index));
        let complain = |what: &str| {
            println!("input {index}, {reader:?}: {what}\n{}\n", String::from_utf8_lossy(&bytes));
        };
        let before = own_cpu_seconds();
        let outcome = catch_unwind(AssertUnwindSafe(|| corpus.read(reader, &bytes)));
        let took = own_cpu_seconds() - before;
        if took > LONGEST {
            hangs += 1;
            complain(&format!("{took:.1} s"));
        }
        match outcome {
            Ok(Ok(answer)) => counts[turn][usize::from(answer == Answer::Refused)] += 1,
            Ok(Err(lacking)) => {
                silent += 1;
                complain(&format!("refused without place, reason or remedy: {lacking}"));
            }
            Err(_) => {
                panics += 1;
                complain("panic");
            }
        }
    }
    for (reader, [read, refused]) in READERS.iter().zip(counts) {
        println!("{:<10} {read:>8} read, {refused:>8} refused", format!("{reader:?}"));
    }
    println!(
        "{count} inputs: {panics} panics, {hangs} above a second, {silent} without place, reason or remedy"
    );
    if panics + hangs + silent > 0 { Err("see above".into()) } else { Ok(()) }
}
