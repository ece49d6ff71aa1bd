//! `murrine list`: every list that the program has, from the lists themselves.

use super::arguments::{List, choose};
use super::{Failure, Outcome, Output};
use crate::march::Channel;
use crate::scene::description::{
    Align, Blending, Classify, ColumnLoop, Conservative, Fill, Hit, Projection, Refraction, Shadow, SizeMeasure,
};
use crate::scene::file;
use crate::scene::words::Words;
use crate::voxelize::{METHODS, Promise};

/// A list's name and its lines: a word and what it says.
type Lines = (&'static str, Vec<(&'static str, String)>);

pub(super) fn run(options: &List, out: &mut Output) -> Result<Outcome, Failure> {
    if options.markdown {
        return gallery(out);
    }
    let lists = lists();
    let names: Vec<&str> = lists.iter().map(|(name, _)| *name).collect();
    if let Some(what) = options.what.as_deref().filter(|what| !names.contains(what)) {
        return Err(Failure::Other(format!("there is no list `{what}`; {}", choose(what, &names))));
    }
    let wanted = |name: &str| options.what.as_deref().is_none_or(|what| what == name);
    for (name, lines) in lists.into_iter().filter(|(name, _)| wanted(name)) {
        out.line(format_args!("{name}"))?;
        for (word, about) in lines {
            out.line(format_args!("  {word:<18} {about}"))?;
        }
    }
    Ok(Outcome::Good)
}

/// The table of `docs/gallery.md`.
fn gallery(out: &mut Output) -> Result<Outcome, Failure> {
    out.line(format_args!("| name | source | idea | promise | interior | conservative |"))?;
    out.line(format_args!("|---|---|---|---|---|---|"))?;
    for method in METHODS {
        let promise = match method.promise {
            Promise::Exact => "exact",
            Promise::Approximate => "approximate",
        };
        let interior = if method.interior { "its own" } else { "the fill's" };
        let ways: Vec<&str> = method.conservative.iter().map(|way| way.word()).collect();
        let ways = if ways.is_empty() { "–".to_owned() } else { ways.join(", ") };
        let (name, source, idea) = (method.name, method.paper.short, method.summary);
        out.line(format_args!("| `{name}` | {source} | {idea} | {promise} | {interior} | {ways} |"))?;
    }
    Ok(Outcome::Good)
}

fn lists() -> Vec<Lines> {
    let voxelizers = METHODS.iter().map(|method| {
        let promise = match method.promise {
            Promise::Exact => "exact",
            Promise::Approximate => "approximate",
        };
        (method.name, format!("{} ({}; {promise})", method.summary, method.paper.short))
    });
    let channels = Channel::ALL.iter().map(|(_, name, components)| {
        (*name, if *components == 1 { "a float a pixel".to_owned() } else { format!("{components} floats a pixel") })
    });
    let plain = |words: &[&'static str]| words.iter().map(|word| (*word, String::new())).collect();
    vec![
        ("voxelizers", voxelizers.collect()),
        words::<Refraction>("refraction"),
        words::<Hit>("hit"),
        words::<Shadow>("shadow"),
        words::<Conservative>("conservative"),
        words::<ColumnLoop>("column loop"),
        words::<Blending>("three-axis blending"),
        words::<SizeMeasure>("size measure"),
        words::<Classify>("classify"),
        words::<Fill>("fill"),
        words::<Align>("align"),
        words::<Projection>("projection"),
        ("channels", channels.collect()),
        ("shapes", plain(file::SHAPES)),
        ("deformers", plain(file::DEFORMERS)),
        ("lights", plain(file::LIGHTS)),
        ("backgrounds", plain(file::BACKGROUNDS)),
    ]
}

fn words<T: Words>(name: &'static str) -> Lines {
    (name, T::WORDS.iter().map(|(_, word, about)| (*word, (*about).to_owned())).collect())
}
