//! What the window shows of a frame: the picture, or one of the debug views.

use crate::compose::DebugView;
use crate::march::Channel;

/// The views, in the order of the menu.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// The picture.
    #[default]
    Picture,
    /// The view grid's voxels as cubes.
    Cubes,
    /// The same, by the way that their triangle was marked.
    Classes,
    /// One slice of the view grid.
    Slice,
    /// Normals of the first surface.
    Normals,
    /// Length inside glass.
    Thickness,
    /// Refractions and inner reflections.
    Events,
    /// Rays that met a leak.
    Questionable,
    /// One slice of light 0's grid.
    LightVolume,
    /// Absorption alone.
    Transmittance,
}

/// A view and its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Which.
    pub mode: Mode,
    /// Slice: 0 = x, 1 = y, 2 = z of the grid.
    pub slice_axis: u32,
    /// Slice: 0 to 1 along the axis.
    pub slice_position: f32,
    /// Light volume: 0 to 1 along the light.
    pub light_position: f32,
    /// Thickness shown brightest, world units.
    pub thickness_max: f32,
}

impl Default for View {
    fn default() -> Self {
        Self { mode: Mode::Picture, slice_axis: 2, slice_position: 0.5, light_position: 0.5, thickness_max: 2.0 }
    }
}

impl View {
    /// What to ask the frame for; `max_events` is the scene's.
    #[must_use]
    pub fn request(&self, max_events: u32) -> (Channel, DebugView) {
        #[expect(clippy::cast_precision_loss, reason = "at most 32")]
        let events = max_events.max(1) as f32;
        match self.mode {
            Mode::Picture => (Channel::Beauty, DebugView::None),
            Mode::Cubes => (Channel::Beauty, DebugView::Cubes),
            Mode::Classes => (Channel::Beauty, DebugView::Classes),
            Mode::Slice => (Channel::Beauty, DebugView::Slice { axis: self.slice_axis, position: self.slice_position }),
            Mode::Normals => (Channel::Normal, DebugView::Channel { max: 1.0 }),
            Mode::Thickness => (Channel::Thickness, DebugView::Channel { max: self.thickness_max }),
            Mode::Events => (Channel::Events, DebugView::Channel { max: events }),
            Mode::Questionable => (Channel::Questionable, DebugView::Channel { max: 1.0 }),
            Mode::LightVolume => (Channel::Beauty, DebugView::LightVolume { position: self.light_position }),
            Mode::Transmittance => (Channel::Transmittance, DebugView::Channel { max: 1.0 }),
        }
    }
}
