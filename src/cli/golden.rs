//! `murrine golden`.

use super::arguments::{Adapter, Golden, GoldenWork};
use super::{Failure, Outcome, Output, open_gpu, tell};
use crate::frame::Frame;
use crate::golden::{Goldens, Verdict};
use std::path::Path;

/// Where the pictures of goldens that fail go.
const FAILURES: &str = "target/golden";

pub(super) fn run(options: &Golden, adapter: &Adapter, out: &mut Output) -> Result<Outcome, Failure> {
    let goldens = Goldens::open(&options.folder)?;
    // Golden frames are lavapipe's; another adapter must be asked for.
    let software = Adapter { adapter: adapter.adapter.clone().or_else(|| Some("software".to_owned())) };
    match &options.work {
        GoldenWork::List => {
            for golden in &goldens.entries {
                let made = goldens.sidecar(golden).map_or_else(|| "missing".to_owned(), |s| s.driver);
                out.line(format_args!("{:<24} {:<40} {}", golden.name, made, golden.about))?;
            }
            Ok(Outcome::Good)
        }
        GoldenWork::Run { names } => {
            let chosen = goldens.named(names)?;
            let gpu = open_gpu(&software)?;
            let mut frame = Frame::new(&gpu)?;
            let mut outcome = Outcome::Good;
            for golden in chosen {
                let verdict = goldens.check(&gpu, &mut frame, golden, Path::new(FAILURES))?;
                if !matches!(verdict, Verdict::Same(_)) {
                    outcome = Outcome::Bad;
                }
                match verdict {
                    Verdict::Same(d) => {
                        out.line(format_args!("same       {} (most {}/255)", golden.name, d.largest))?
                    }
                    Verdict::Different(d, look) => out.line(format_args!(
                        "DIFFERENT  {}: {:.2}% of the pixels, most {}/255; {look}",
                        golden.name,
                        d.share * 100.0,
                        d.largest
                    ))?,
                    Verdict::Missing(remedy) => out.line(format_args!("MISSING    {}: {remedy}", golden.name))?,
                }
            }
            Ok(outcome)
        }
        GoldenWork::Update { names } => {
            let chosen = goldens.named(names)?;
            let gpu = open_gpu(&software)?;
            let mut frame = Frame::new(&gpu)?;
            for golden in chosen {
                goldens.bless(&gpu, &mut frame, golden)?;
                tell(format_args!("{}", goldens.picture_path(golden).display()));
            }
            Ok(Outcome::Good)
        }
    }
}
