//! Merging of shards into one file, which equals byte for byte the file of a run without shards.

use super::error::shown;
use super::{BatchError, CaseResult, CommaTable, Header, Results, Shard};
use crate::export::{ExportError, Target};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Largest number of cases that an error message lists.
const NAMED: usize = 8;

/// Merges the result files of all shards of one batch into `target` and returns the number of
/// results. If an error occurs, `target` is not written.
///
/// # Errors
/// Returns an error if the files belong to different batches, if a shard is missing or given twice,
/// if a shard lacks cases, or if a file cannot be read or written.
pub fn merge(shards: &[PathBuf], target: &Target) -> Result<u64, BatchError> {
    let mut files = in_order(shards)?;
    let header = whole(&files[0]);
    written(target, |output, wrong| {
        serde_json::to_writer(&mut *output, &header)?;
        output.write_all(b"\n")?;
        every_result(&mut files, header.cases, wrong, &mut |_, line| Ok(output.write_all(line)?))
    })?;
    Ok(header.cases)
}

/// Merges the results of all shards into a comma-separated table for spreadsheets, with one row for
/// each case.
///
/// # Errors
/// Returns the errors of [`merge`].
pub fn merge_to_csv(shards: &[PathBuf], target: &Target) -> Result<u64, BatchError> {
    let mut files = in_order(shards)?;
    let header = whole(&files[0]);
    written(target, |output, wrong| {
        let mut table = CommaTable::begin(&header, output)?;
        every_result(&mut files, header.cases, wrong, &mut |result, _| table.add(result))
    })?;
    Ok(header.cases)
}

/// Merges the results of all shards into a Parquet table for analysis, with one row for each case.
///
/// # Errors
/// Returns the errors of [`merge`]; always fails in a build without the feature `parquet`.
#[cfg(feature = "parquet")]
pub fn merge_to_parquet(shards: &[PathBuf], target: &Target) -> Result<u64, BatchError> {
    let mut files = in_order(shards)?;
    let header = whole(&files[0]);
    let mut columns = super::tabulated::Columns::new(&header);
    let mut wrong = None;
    let met = every_result(&mut files, header.cases, &mut wrong, &mut |result, _| {
        columns.meet(result);
        Ok(())
    });
    if let Some(wrong) = wrong {
        return Err(wrong);
    }
    met?;
    let mut files = in_order(shards)?;
    written(target, |output, wrong| {
        let mut table = columns.begin(&header, output)?;
        every_result(&mut files, header.cases, wrong, &mut |result, _| table.add(result))?;
        table.close()
    })?;
    Ok(header.cases)
}

/// Returns an error, because this build cannot write Parquet.
///
/// # Errors
/// Always fails: this build lacks the feature `parquet`.
#[cfg(not(feature = "parquet"))]
pub fn merge_to_parquet(_: &[PathBuf], _: &Target) -> Result<u64, BatchError> {
    let lacking = crate::exchange::Lacking::Parquet;
    Err(BatchError::argument(lacking.code(), lacking.to_string(), lacking.remedy()))
}

/// Returns the header of the undivided batch, derived from the header of one shard.
fn whole(file: &Results) -> Header {
    Header { shard: None, ..file.header().clone() }
}

/// Writes the merged file. If both the results and the output have an error, the error of the
/// results is returned, because it is the cause of the incomplete output.
fn written(
    target: &Target,
    write: impl FnOnce(&mut dyn Write, &mut Option<BatchError>) -> Result<(), ExportError>,
) -> Result<(), BatchError> {
    let mut wrong = None;
    let written = target.write(|output| write(output, &mut wrong));
    match wrong {
        Some(wrong) => Err(wrong),
        None => Ok(written?),
    }
}

/// A function that receives each result together with its line.
type Take<'t> = dyn FnMut(&CaseResult, &[u8]) -> Result<(), ExportError> + 't;

/// Passes each result with its line to `take`, in the order of the cases. An error in the results
/// is stored in `wrong`, to distinguish it from an error of the output. After any error, the output
/// file is not written.
fn every_result(
    files: &mut [Results],
    cases: u64,
    wrong: &mut Option<BatchError>,
    take: &mut Take<'_>,
) -> Result<(), ExportError> {
    let of = files.len() as u64;
    for case in 1..=cases {
        let file = &mut files[((case - 1) % of) as usize];
        let found = match file.next_result() {
            Ok(Some((result, line))) if result.case == case => Ok((result, line)),
            Ok(Some((result, _))) => Err(astray(file.path(), result.case, case)),
            Ok(None) => Err(unfinished(file, case)),
            Err(error) => Err(error),
        };
        match found {
            Ok((result, line)) => take(&result, &line)?,
            Err(error) => {
                *wrong = Some(error);
                return Err(ExportError::Io(std::io::Error::other("the shards do not fit")));
            }
        }
    }
    Ok(())
}

/// Opens the files at `paths` and sorts them by shard; each shard must occur exactly once.
fn in_order(paths: &[PathBuf]) -> Result<Vec<Results>, BatchError> {
    let wrong = |reason: String, remedy: &str| Err(BatchError::file("E0117", reason, remedy));
    let mut files = paths.iter().map(|path| Results::open(path)).collect::<Result<Vec<_>, _>>()?;
    let Some(first) = files.first() else {
        return wrong("no shard is given".into(), "name the files of all shards");
    };
    let shard = |file: &Results| file.header().shard.unwrap_or(Shard::ALL);
    let (batch, of) = (whole(first), shard(first).of());
    for file in &files {
        let (path, here) = (shown(file.path()), shown(files[0].path()));
        if whole(file) != batch {
            return wrong(
                format!("{path} and {here} hold results of different batches"),
                "give the shards of one batch",
            );
        }
        if shard(file).of() != of {
            let (one, other) = (shard(file), shard(&files[0]));
            return wrong(
                format!("{path} is shard {one} and {here} is shard {other}"),
                "give shards of the same total number",
            );
        }
    }
    files.sort_by_key(|file| shard(file).index());
    if let Some(pair) = files.windows(2).find(|pair| shard(&pair[0]) == shard(&pair[1])) {
        let (one, other) = (shown(pair[0].path()), shown(pair[1].path()));
        return wrong(
            format!("{one} and {other} are both shard {}", shard(&pair[0])),
            "give each shard once",
        );
    }
    let missing: Vec<String> = (1..=of)
        .filter(|index| !files.iter().any(|file| shard(file).index() == *index))
        .map(|index| format!("{index}/{of}"))
        .collect();
    if !missing.is_empty() {
        let more =
            if missing.len() > NAMED { format!(", … {} in all", missing.len()) } else { String::new() };
        let named = missing[..missing.len().min(NAMED)].join(", ");
        let cases = if of > batch.cases { " (they have no cases, but their files are needed)" } else { "" };
        return wrong(
            format!("missing: shard {named}{more}{cases}"),
            "run them with --shard, then merge all shards",
        );
    }
    Ok(files)
}

fn astray(path: &Path, found: u64, wanted: u64) -> BatchError {
    let reason = format!("{}: case {found} was found instead of case {wanted}", shown(path));
    BatchError::file("E0114", reason, "the file was edited, or its disk fails: run the shard again")
}

/// Creates the error for a shard whose file ends before the result of `case`.
fn unfinished(file: &Results, case: u64) -> BatchError {
    let header = file.header();
    let shard = header.shard.unwrap_or(Shard::ALL);
    let done = (case - shard.index()) / shard.of();
    let lacking: Vec<u64> = (done..shard.count(header.cases)).map(|place| shard.case(place)).collect();
    let named: Vec<String> = lacking.iter().take(NAMED).map(u64::to_string).collect();
    let more = if lacking.len() > NAMED { format!(", … {} in all", lacking.len()) } else { String::new() };
    let reason = format!("{} lacks case {}{more}", shown(file.path()), named.join(", "));
    BatchError::file("E0117", reason, "run its command again: it continues the run")
}
