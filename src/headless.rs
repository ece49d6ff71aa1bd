//! Renders one frame, or voxelizes one grid, without a window and reads it back.

mod slabs;
mod voxels;

pub use slabs::{MarkedSlab, VoxelSlabs, largest_cube};
pub use voxels::voxel_body;

use crate::compose::DebugView;
use crate::frame::{Frame, Request};
use crate::gpu::{Gpu, GpuError, Timing, buffer};
use crate::image::{Floats, Picture};
use crate::march::Channel;
use crate::scene::{Scene, SceneError, Warning, World, file, framing};
use crate::voxelize;
use glam::UVec2;
use std::path::Path;

/// The most times a frame is rendered until the volume has room for every record: each time it grows to what the last
/// one counted, and only neighbouring stages add to it.
const MAX_TRIES: u32 = 6;

/// Of `rgba32float`, the largest that is read back.
const FLOAT_TEXEL_BYTES: u64 = 16;

/// Names of the voxelizers there are.
#[must_use]
pub fn methods() -> Vec<&'static str> {
    voxelize::METHODS.iter().map(|m| m.name).collect()
}

/// Reads a scene or a model, applies the `--set` assignments, loads what it names and fits it.
///
/// # Errors
/// The first thing that is wrong, with its place and remedy.
pub fn open(path: &Path, sets: &[String]) -> Result<(Scene, World, Vec<Warning>), SceneError> {
    let (mut scene, mut warnings) = file::read(path, sets, &methods())?;
    let world = World::load(&scene, None)?;
    framing::frame(&mut scene, &world);
    warnings.extend(world.warnings.iter().cloned());
    Ok((scene, world, warnings))
}

/// What is to be rendered.
#[derive(Debug, Clone, Copy)]
pub struct Still<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// What it names.
    pub world: &'a World,
    /// Seconds.
    pub time_secs: f64,
    /// Pixels.
    pub size: UVec2,
    /// Four rays a pixel instead of one, of which the picture shows the mean; the floats are then of twice the size.
    pub antialias: bool,
    /// The float channel beside the picture.
    pub channel: Channel,
    /// What to show instead of the picture.
    pub view: DebugView,
}

/// Renders until the volume has room for every record. The picture and its floats are then [`picture`] and [`floats`].
///
/// # Errors
/// When the device refuses a buffer or is lost.
pub fn render(gpu: &Gpu, frame: &mut Frame, still: &Still<'_>) -> Result<(), GpuError> {
    let rays = still.size * if still.antialias { 2 } else { 1 };
    check_size(gpu, rays)?;
    let request = Request {
        scene: still.scene,
        world: still.world,
        time_secs: still.time_secs,
        size: rays,
        picture_size: still.size,
        channel: still.channel,
        view: still.view,
        timing: Timing::Off,
    };
    for _ in 0..MAX_TRIES {
        frame.render(gpu, &request)?;
        if frame.settle(gpu)? {
            return Ok(());
        }
    }
    Err(GpuError::Lost(format!("the volume was still too small after {MAX_TRIES} frames; choose a smaller grid")))
}

/// Refuses a picture that the device can't hold, or not hand back in one piece.
fn check_size(gpu: &Gpu, size: UVec2) -> Result<(), GpuError> {
    let limits = gpu.device.limits();
    let remedy = "choose a smaller picture";
    let (widest, most) = (u64::from(limits.max_texture_dimension_2d), limits.max_buffer_size);
    let longest = u64::from(size.max_element());
    if longest > widest {
        let what = "pixels along an axis".to_owned();
        return Err(GpuError::TooMany { what, needed: longest, allowed: widest, remedy });
    }
    let needed = u64::from(size.x) * u64::from(size.y) * FLOAT_TEXEL_BYTES;
    if needed > most {
        return Err(GpuError::Limit { what: format!("a picture of {size}"), needed, allowed: most, remedy });
    }
    Ok(())
}

/// Reads the picture back.
///
/// # Errors
/// When the device is lost.
pub fn picture(gpu: &Gpu, frame: &Frame) -> Result<Picture, GpuError> {
    let texture = frame.picture();
    let rgba8: Vec<[u8; 4]> = buffer::read_texture(gpu, texture)?;
    let rgb8 = rgba8.into_iter().map(|[r, g, b, _]| [r, g, b]).collect();
    Ok(Picture { width: texture.width(), height: texture.height(), rgb8 })
}

/// Reads the channel's floats back; the beauty channel is the linear radiance.
///
/// # Errors
/// When the device is lost.
pub fn floats(gpu: &Gpu, frame: &Frame, channel: Channel) -> Result<Floats, GpuError> {
    let radiance = frame.radiance();
    let texture = if channel == Channel::Beauty { &radiance.radiance } else { &radiance.channel };
    let components = Channel::ALL.iter().find(|(c, ..)| *c == channel).map_or(3, |(.., components)| *components);
    let texels: Vec<[f32; 4]> = buffer::read_texture(gpu, texture)?;
    let values = texels.iter().flat_map(|texel| texel[..components].iter().copied()).collect();
    Ok(Floats { width: texture.width(), height: texture.height(), components, values })
}
