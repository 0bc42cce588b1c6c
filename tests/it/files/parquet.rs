//! Parquet, read back by the reader of the crate that wrote it; `tests/exchange` has pyarrow read
//! it.

use super::{BASE, good};
use slewkit::plan::{Silent, plan};
use slewkit_files::batch::{Batch, CaseResult, Journal, Options, Shard, merge_to_parquet, run};
use slewkit_files::exchange::Tables;
use slewkit_files::export::{PlanFile, Target};
use slewkit_files::formats::Format;
use slewkit_files::parquet::file::reader::{FileReader, SerializedFileReader};
use slewkit_files::parquet::record::Field;
use slewkit_files::spec::{self, Base};
use std::path::Path;

/// Returns the columns of a file with their heads, and its rows.
fn rows(path: &Path) -> (Vec<String>, Vec<Vec<Field>>) {
    let reader = SerializedFileReader::new(std::fs::File::open(path).unwrap()).unwrap();
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let heads = schema.columns().iter().map(|column| column.name().to_string()).collect();
    let rows = reader.get_row_iter(None).unwrap().map(|row| {
        let row = row.unwrap();
        row.get_column_iter().map(|(_, field)| field.clone()).collect()
    });
    (heads, rows.collect())
}

/// Returns the content of the table of a plan in CSV.
fn csv(text: &str) -> (Vec<String>, Vec<Vec<Field>>) {
    let cells = |line: &str| line.split(',').map(String::from).collect::<Vec<_>>();
    let field = |cell: &String| cell.parse().map_or(Field::Null, Field::Double);
    let mut lines = text.lines().map(cells);
    (lines.next().unwrap(), lines.map(|line| line.iter().map(field).collect()).collect())
}

#[test]
fn a_plan_has_the_columns_of_csv_to_the_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    for scheme in ["lie_verlet", "lie_euler"] {
        let set = format!("solver.scheme=\"{scheme}\"");
        let loaded = good(BASE, &["maneuver.steps=20", &set]);
        let found = plan(&loaded.problem, &loaded.settings, None, &mut Silent).unwrap();
        let file = PlanFile::new(&loaded.problem, &loaded.settings, &found);
        let tables = Tables { margins: true, ..Tables::default() };
        let written = |ending: &str| {
            let path = folder.path().join(format!("{scheme}.{ending}"));
            let format = Format::of_ending(ending).unwrap();
            let target = Target::new(&path, false).unwrap();
            target
                .write(|output| format.write(&file, &loaded.problem, &loaded.identity, tables, output))
                .unwrap();
            path
        };
        let text = std::fs::read_to_string(written("csv")).unwrap();
        // Fields of doubles are equal if their numbers are equal. No field is NaN, and readers
        // distinguish zeros of either sign.
        assert_eq!(rows(&written("parquet")), csv(&text));
    }
}

#[test]
fn results_of_a_batch_are_a_row_a_case() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("cases.csv");
    let cases = "name,maneuver.duration_s,solver.scheme,body.inertia_kg_m2\n\
        short,30,lie_verlet,\"[2, 3, 4]\"\nlong,90.5,lie_euler,\"[2, 3, 4]\"\nwrong,60,lie_euler,\"[1, 1, 9]\"\n";
    std::fs::write(&table, cases).unwrap();
    let base = || Base::from_reader(BASE.as_bytes(), "base", spec::Format::Toml, &[]).unwrap();
    let batch = Batch::of_table(base(), &table).unwrap();
    let (mut shards, mut all) = (Vec::new(), Vec::<CaseResult>::new());
    for shard in ["1/2", "2/2"] {
        let (path, shard) = (folder.path().join(shard.replace('/', "of")), Shard::parse(shard).unwrap());
        let (mut journal, _) =
            Journal::open(&path, &batch.header(shard, false), false, &mut |_: &CaseResult| {}).unwrap();
        run(
            &batch,
            shard,
            0,
            &Options::default(),
            &|| false,
            &mut |result, line| {
                all.push(result.clone());
                journal.line(line)
            },
            &mut || {},
        )
        .unwrap();
        journal.close().unwrap();
        shards.push(path);
    }
    all.sort_by_key(|result| result.case);
    let target = Target::new(folder.path().join("all.parquet"), false).unwrap();
    assert_eq!(merge_to_parquet(&shards, &target).unwrap(), 3);
    let (heads, rows) = rows(target.path());
    assert_eq!(rows.len(), 3);
    let column = |name: &str| {
        let at = heads.iter().position(|head| head == name).unwrap_or_else(|| panic!("{name} of {heads:?}"));
        rows.iter().map(|row| row[at].clone()).collect::<Vec<_>>()
    };
    let text = |text: &str| Field::Str(text.into());
    assert_eq!(column("case"), [1, 2, 3].map(Field::Long));
    assert_eq!(column("name"), ["short", "long", "wrong"].map(text));
    assert_eq!(column("maneuver.duration_s"), [30.0, 90.5, 60.0].map(Field::Double));
    assert_eq!(column("solver.scheme"), ["lie_verlet", "lie_euler", "lie_euler"].map(text));
    assert_eq!(column("body.inertia_kg_m2")[2], text("[1,1,9]"));
    assert_eq!(column("status"), ["solved", "solved", "spec_invalid"].map(text));
    let costs = all.iter().map(|result| result.cost.map_or(Field::Null, Field::Double));
    assert_eq!(column("cost"), costs.collect::<Vec<_>>());
    assert_eq!(column("verified_passed"), [Field::Bool(true), Field::Bool(true), Field::Null]);
    let code = all[2].error.as_ref().map(|error| text(&error.code)).unwrap();
    assert_eq!(column("error_code"), [Field::Null, Field::Null, code]);
    // A missing key of a shard is reported as by `merge`, and no file is written.
    let lacking = Target::new(folder.path().join("part.parquet"), false).unwrap();
    let refused = merge_to_parquet(&shards[..1], &lacking).unwrap_err().to_string();
    assert!(refused.contains("missing: shard 2/2") && !lacking.path().exists(), "{refused}");
}
