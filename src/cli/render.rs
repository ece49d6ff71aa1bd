//! `murrine render`.

use super::arguments::{Adapter, Render};
use super::{Failure, Outcome, open_gpu, tell, tell_warnings};
use crate::compose::DebugView;
use crate::frame::Frame;
use crate::headless::{self, Still};
use crate::image::{self, Format};
use crate::march::Channel;
use std::time::Instant;

pub(super) fn run(options: &Render, adapter: &Adapter) -> Result<Outcome, Failure> {
    let format = Format::of(&options.output)?;
    if options.antialias && (format != Format::Png || options.channel != Channel::Beauty) {
        let what = "--antialias is for pictures; leave it out, or write the channel `beauty` to a .png file";
        return Err(Failure::Other(what.to_owned()));
    }
    let (scene, world, warnings) = headless::open(&options.scene, &options.scene_flags.assignments())?;
    tell_warnings(&warnings);
    let gpu = open_gpu(adapter)?;
    let started = Instant::now();
    let mut frame = Frame::new(&gpu)?;
    let mut still = Still {
        scene: &scene,
        world: &world,
        time_secs: options.time,
        size: options.size,
        antialias: options.antialias,
        channel: options.channel,
        view: DebugView::None,
    };
    headless::render(&gpu, &mut frame, &still)?;
    for warning in frame.warnings() {
        tell(format_args!("warning: {}: {warning}", options.scene.display()));
    }
    if let Some(cutoff) = frame.cutoff().filter(|_| options.verbose) {
        tell(format_args!("{}: {cutoff}", scene.voxelizer.method));
    }
    match format {
        Format::Png => {
            if options.channel != Channel::Beauty {
                let max = headless::floats(&gpu, &frame, options.channel)?.largest();
                still.view = DebugView::Channel { max: if max > 0.0 { max } else { 1.0 } };
                headless::render(&gpu, &mut frame, &still)?;
            }
            image::write_png(&options.output, &headless::picture(&gpu, &frame)?)?;
        }
        Format::Exr => image::write_exr(&options.output, &headless::floats(&gpu, &frame, options.channel)?)?,
        Format::Npy => image::write_npy(&options.output, &headless::floats(&gpu, &frame, options.channel)?)?,
    }
    let (size, secs) = (options.size, started.elapsed().as_secs_f64());
    tell(format_args!("{}: {}x{}, {secs:.1} s on {}", options.output.display(), size.x, size.y, gpu.info.name));
    Ok(Outcome::Good)
}
