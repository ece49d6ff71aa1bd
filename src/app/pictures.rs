//! Keeps one frame in flight: asks for a picture when something changed, at a resolution that holds the frame time, and
//! for a sharp one when things have come to rest. That one is marched in [`Parts`]: an input in between ends it.

use super::parts::Parts;
use super::resolution::Resolution;
use super::session::Session;
use crate::compose::DebugView;
use crate::frame::{Frame, Request};
use crate::gpu::{Gpu, GpuError, StageTimes, Timing, buffer};
use crate::march::Channel;
use crate::scene::Scene;
use glam::UVec2;
use std::sync::mpsc::{Sender, channel};
use std::time::{Duration, Instant};

/// After this long without a change the picture is made sharp.
const REST: Duration = Duration::from_millis(150);

/// All that decides what a picture shows, except its resolution.
#[derive(Debug, Clone, PartialEq)]
struct Content {
    scene: Scene,
    world_number: u64,
    time_secs: f64,
    full: UVec2,
    channel: Channel,
    view: DebugView,
    beside: Option<String>,
    is_held: bool,
}

impl Content {
    fn of(session: &Session, full: UVec2) -> Self {
        let (channel, view) = session.view.request(session.scene.effect.max_events);
        let (scene, world_number) = (session.scene.clone(), session.world_number);
        let (beside, is_held) = (session.laboratory.beside.clone(), session.held().is_some());
        Self { scene, world_number, time_secs: session.time_secs(), full, channel, view, beside, is_held }
    }

    /// True when this is what is to be shown, the time aside.
    fn is_of(&self, session: &Session, full: UVec2) -> bool {
        self.world_number == session.world_number
            && (self.full, (self.channel, self.view)) == (full, session.view.request(session.scene.effect.max_events))
            && self.scene == session.scene
            && self.beside == session.laboratory.beside
            && self.is_held == session.held().is_some()
    }
}

/// What was measured of the last frame.
#[derive(Debug, Clone, Default)]
pub struct Measured {
    /// From the start of recording to the device's end, milliseconds.
    pub frame_ms: f64,
    /// Of that, recording on the host.
    pub record_ms: f64,
    /// Time of each stage, where measured; by the device's timestamps a frame or more late.
    pub stages: StageTimes,
    /// Internal resolution.
    pub size: UVec2,
    /// Full resolution.
    pub full: UVec2,
    /// Frames rendered.
    pub count: u64,
}

#[derive(Debug)]
struct Flight {
    started: Instant,
    record_ms: f64,
    size: UVec2,
    full: UVec2,
    // The first frame of a world, and one that is timed stage by stage, says nothing about those that follow.
    typical: bool,
}

/// The renderer with its one frame in flight.
#[derive(Debug)]
pub struct Pictures {
    frame: Frame,
    /// That of the method at the right of the wipe.
    beside: Option<Frame>,
    resolution: Resolution,
    parts: Parts,
    waiter: Sender<()>,
    flight: Option<Flight>,
    shown: Option<(Content, UVec2)>,
    /// The picture of stages that were replaced, until there is one of the new.
    standing: Option<wgpu::Texture>,
    changed_at: Instant,
    again: bool,
    /// What could not be rendered: not tried again until something but the time changes.
    failed: Option<Content>,
    measured: Measured,
}

/// What to do next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    /// A frame is under way; the waiter tells its end.
    InFlight,
    /// The picture will be made sharper then, if nothing changes.
    SharpenAt(Instant),
    /// The picture is as it should be.
    AtRest,
}

/// How the next picture is to be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Wish {
    /// At full resolution at once.
    pub sharp: bool,
    /// Every stage, submitted and timed one by one.
    pub measure: bool,
    /// Stage times by the device's timestamps are wanted.
    pub timestamps: bool,
}

impl Pictures {
    /// Compiles the frame's stages. `done` is called from another thread whenever the device has finished a frame.
    ///
    /// # Errors
    /// When a shader is wrong or the system refuses a thread.
    pub fn new(gpu: &Gpu, done: impl Fn(Result<(), String>) + Send + 'static) -> Result<Self, GpuError> {
        let frame = Frame::new(gpu)?;
        let (waiter, orders) = channel::<()>();
        let device = gpu.device.clone();
        std::thread::Builder::new()
            .name("frame waiter".to_owned())
            .spawn(move || {
                while orders.recv().is_ok() {
                    let waited = device.poll(wgpu::PollType::wait_indefinitely());
                    done(waited.map(drop).map_err(|e| e.to_string()));
                }
            })
            .map_err(|e| GpuError::Lost(format!("no thread to wait for it: {e}")))?;
        Ok(Self {
            frame,
            beside: None,
            resolution: Resolution::default(),
            parts: Parts::whole(),
            waiter,
            flight: None,
            shown: None,
            standing: None,
            changed_at: Instant::now(),
            again: false,
            failed: None,
            measured: Measured::default(),
        })
    }

    /// Compiles the stages anew, on whatever thread; those of the window go on meanwhile.
    ///
    /// # Errors
    /// `file:line:column` of the first shader that is wrong.
    pub fn compile(gpu: &Gpu) -> Result<Frame, GpuError> {
        // Those too that are compiled when first asked for: once the old stages are gone it would be too late.
        gpu.shaders.check_all()?;
        Frame::new(gpu)
    }

    /// Goes on with other stages. The picture stays until they have made one.
    pub fn replace(&mut self, frame: Frame) {
        self.standing = self.picture().cloned();
        self.frame = frame;
        self.beside = None;
        self.shown = None;
        self.failed = None;
    }

    /// The picture as it stands; the first one may still be empty.
    #[must_use]
    pub fn picture(&self) -> Option<&wgpu::Texture> {
        if self.shown.is_some() { Some(self.frame.picture()) } else { self.standing.as_ref() }
    }

    /// The picture at the right of the wipe, if there is one.
    #[must_use]
    pub fn picture_beside(&self) -> Option<&wgpu::Texture> {
        let (shown, _) = self.shown.as_ref()?;
        shown.beside.as_ref().and(self.beside.as_ref()).map(Frame::picture)
    }

    /// The frame, for its counts.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// What was measured of the last frame.
    #[must_use]
    pub fn measured(&self) -> &Measured {
        &self.measured
    }

    /// True while the device works on a frame.
    #[must_use]
    pub fn is_in_flight(&self) -> bool {
        self.flight.is_some()
    }

    /// True when the picture is half marched: [`Pictures::advance`] goes on with it, or drops it if something changed.
    #[must_use]
    pub fn is_between_parts(&self) -> bool {
        !self.is_in_flight() && !self.frame.is_whole()
    }

    /// True when the picture stands at full resolution and nothing is under way.
    #[must_use]
    pub fn is_sharp(&self) -> bool {
        !self.is_in_flight()
            && self.frame.is_whole()
            && !self.again
            && self.shown.as_ref().is_some_and(|(c, size)| *size == c.full)
    }

    /// Starts a frame if the picture is not what it should be. `full` is the size of the picture's place, pixels.
    ///
    /// # Errors
    /// When the device refuses a buffer, or is lost. The last good picture stays.
    pub fn advance(&mut self, gpu: &Gpu, session: &Session, full: UVec2, wish: Wish) -> Result<Next, GpuError> {
        if self.is_in_flight() {
            return Ok(Next::InFlight);
        }
        if full.min_element() == 0 {
            return Ok(Next::AtRest);
        }
        if self.failed.as_ref().is_some_and(|failed| failed.is_of(session, full)) {
            return Ok(Next::AtRest);
        }
        let (channel, view) = session.view.request(session.scene.effect.max_events);
        let time_secs = session.time_secs();
        let shown = self.shown.as_ref();
        let same = shown.is_some_and(|(c, _)| c.is_of(session, full) && c.time_secs.to_bits() == time_secs.to_bits());
        if !same {
            self.changed_at = Instant::now();
        }
        let goes_on = same && !self.frame.is_whole() && !self.again && !wish.measure;
        let stands = same && !goes_on && !self.again && !wish.measure;
        let size = match shown {
            Some((_, size)) if stands && *size == full => return Ok(Next::AtRest),
            _ if wish.sharp => full,
            Some(_) if stands => {
                let due = self.changed_at + REST;
                if Instant::now() < due {
                    return Ok(Next::SharpenAt(due));
                }
                full
            }
            Some((_, size)) if same => *size,
            _ => self.resolution.moving_size(full),
        };
        if !goes_on {
            let in_parts = (stands || wish.sharp) && !wish.measure;
            self.parts = if in_parts { Parts::of(full, self.resolution.march_ms(full)) } else { Parts::whole() };
        }
        let known_world = shown.is_some_and(|(c, _)| {
            c.world_number == session.world_number && c.scene.voxelizer.method == session.scene.voxelizer.method
        });
        let content = (!same).then(|| Content::of(session, full));
        let typical = !same && known_world && !self.again && !wish.measure;
        self.render(gpu, session, &Order { time_secs, full, channel, view, size, wish, typical })?;
        match (content, &mut self.shown) {
            (Some(content), _) => self.shown = Some((content, size)),
            (None, Some((_, shown_size))) => *shown_size = size,
            (None, None) => {}
        }
        Ok(Next::InFlight)
    }

    fn render(&mut self, gpu: &Gpu, session: &Session, order: &Order) -> Result<(), GpuError> {
        let timing = match order.wish {
            Wish { measure: true, .. } => Timing::Submit,
            // Those of a part would say little.
            Wish { timestamps: true, .. } if self.parts.rows() == u32::MAX => Timing::Timestamps,
            _ => Timing::Off,
        };
        if order.wish.measure {
            self.frame.forget();
        }
        let started = Instant::now();
        let request = Request {
            scene: &session.scene,
            world: &session.world,
            time_secs: order.time_secs,
            size: order.size,
            picture_size: order.size,
            channel: order.channel,
            view: order.view,
            timing,
        };
        let truth = session.held().filter(|_| order.view != DebugView::None);
        let truth = truth.map(|held| buffer::storage_with(gpu, "truth", &held.truth)).transpose()?;
        self.frame.hold_against(truth.clone());
        let stages = self.frame.render_part(gpu, &request, self.parts.rows())?;
        self.render_beside(gpu, session, request, truth)?;
        self.again = false;
        self.failed = None;
        if !stages.is_empty() {
            self.measured.stages = stages;
        }
        let record_ms = started.elapsed().as_secs_f64() * 1e3;
        let Order { size, full, typical, .. } = *order;
        self.flight = Some(Flight { started, record_ms, size, full, typical });
        // The thread lives as long as this does.
        let _ = self.waiter.send(());
        Ok(())
    }

    /// Renders what is at the right of the wipe.
    fn render_beside(
        &mut self,
        gpu: &Gpu,
        session: &Session,
        request: Request<'_>,
        truth: Option<wgpu::Buffer>,
    ) -> Result<(), GpuError> {
        let Some(voxelizer) = session.laboratory.settings_beside(&session.scene.voxelizer) else {
            self.beside = None;
            return Ok(());
        };
        let scene = Scene { voxelizer, ..session.scene.clone() };
        let mut frame = match self.beside.take() {
            Some(frame) => frame,
            None => Frame::new(gpu)?,
        };
        frame.hold_against(truth);
        frame.render_part(gpu, &Request { scene: &scene, timing: Timing::Off, ..request }, self.parts.rows())?;
        self.beside = Some(frame);
        Ok(())
    }

    /// The device has finished the frame in flight.
    pub fn finished(&mut self, gpu: &Gpu) {
        let Some(flight) = self.flight.take() else { return };
        let part_ms = flight.started.elapsed().as_secs_f64() * 1e3;
        self.parts.measured(part_ms);
        let has_room = self.frame.had_room(gpu) & self.beside.as_mut().is_none_or(|frame| frame.had_room(gpu));
        self.again = !has_room;
        if !self.frame.is_whole() {
            tracing::debug!(part_ms, record_ms = flight.record_ms, rows = self.parts.rows(), "part");
            return;
        }
        let frame_ms = self.parts.spent_ms();
        self.standing = None;
        let count = self.measured.count + 1;
        let stages = std::mem::take(&mut self.measured.stages);
        let Flight { record_ms, size, full, typical, .. } = flight;
        tracing::debug!(frame_ms, record_ms, %size, "frame");
        self.measured = Measured { frame_ms, record_ms, stages, size, full, count };
        if typical && has_room {
            self.resolution.measured(full, size, frame_ms);
        }
    }

    /// The frame failed: it is not tried again until something but the time changes.
    pub fn give_up(&mut self, session: &Session, full: UVec2) {
        self.failed = Some(Content::of(session, full));
        self.again = false;
    }
}

#[derive(Debug, Clone, Copy)]
struct Order {
    time_secs: f64,
    full: UVec2,
    channel: Channel,
    view: DebugView,
    size: UVec2,
    wish: Wish,
    typical: bool,
}
