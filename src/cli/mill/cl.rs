//! The path as an APT CL file, where `--cl` asks for one.

use super::MillArgs;
use crate::cldata::{Cutter, Job, WriteOptions, Writer, steps};
use crate::cli::Failure;
use crate::toolpath::Toolpath;
use std::path::PathBuf;

/// Refuses names that cannot be written, before anything is computed.
pub(super) fn check_name(a: &MillArgs) -> Result<(), Failure> {
    let Some(cl) = &a.cl else {
        return Ok(());
    };
    let refuse = |problem: &str| Err(Failure::Failed(format!("{}: {problem}", cl.display())));
    if cl.is_dir() {
        return refuse("is a folder, not a file to write");
    }
    if *cl == a.output {
        return refuse("is the program's file too: give --cl another name");
    }
    Ok(())
}

/// The bytes of the CL file and its name, if one is wanted: the steps that the post wrote from.
pub(super) fn text(
    a: &MillArgs,
    path: &Toolpath,
    job: &Job,
) -> Result<Option<(PathBuf, Vec<u8>)>, Failure> {
    let Some(file) = &a.cl else {
        return Ok(None);
    };
    let fail = |e| Failure::Failed(format!("{}: {e}", file.display()));
    let name = (a.part.file_stem()).map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    let options = WriteOptions {
        part: name,
        cutter: Some(Cutter::ball(a.tool.tool.radius)),
    };
    let mut writer = Writer::new(Vec::new(), &options).map_err(fail)?;
    for (_, step) in steps(path, job) {
        writer.write(&step).map_err(fail)?;
    }
    Ok(Some((file.clone(), writer.finish().map_err(fail)?)))
}
