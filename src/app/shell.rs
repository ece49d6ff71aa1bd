//! The event loop. It sleeps until something happens: an input, a finished frame, a file, a moment that was asked for.

use super::actions::{self, ActionId};
use super::laboratory::{self, Held, Key};
use super::loader::{Answer, Job, Loader, Reason};
use super::notices::{Severity, Topic};
use super::painter::{PaintInput, Painted};
use super::panels::{self, Chrome, Command, Leaving, Stage};
use super::pictures::{Next, Pictures, Wish};
use super::session::{self, Session};
use super::timeline::KEY_STEP_SECS;
use super::watch::{Change, Watcher};
use super::window::Opened;
use super::{AppError, Options, screenshot};
use crate::frame::Frame;
use crate::gpu::shader::ShaderLibrary;
use crate::gpu::{GpuError, buffer};
use crate::image::Picture;
use crate::scene::description::Background;
use glam::UVec2;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{Fullscreen, Window, WindowId};

/// Size of the window at first, points: the picture beside the panels is about 3:2. At most
const SIZE: winit::dpi::LogicalSize<f64> = winit::dpi::LogicalSize::new(1440.0, 800.0);
/// this share of the screen.
const SCREEN_SHARE: f64 = 0.92;
/// Before a surface that was not ready is tried again.
const RETRY: Duration = Duration::from_millis(15);
/// egui asks for a painting "never" by a longer delay than this.
const LONGEST_DELAY: Duration = Duration::from_secs(3600);
/// How often a lost device is opened again before the program gives up.
const MOST_REOPENINGS: u32 = 3;
/// Factor of text size by key.
const TEXT_STEP: f32 = 1.1;

/// What other threads tell the loop.
#[derive(Debug)]
pub(super) enum Event {
    /// A scene was read.
    Loaded(Box<Answer>),
    /// The device finished a frame, or was lost.
    FrameDone(Result<(), String>),
    /// A file changed.
    Changed(Change),
    /// The device complains.
    Complaint(String),
    /// Shaders were compiled, or not: of which compilation, from where.
    Compiled(u64, ShaderLibrary, Box<Result<Frame, GpuError>>),
    /// The truth of a frame is known, or could not be worked out.
    Held(Box<Result<Held, GpuError>>),
    /// A screenshot was written, or not.
    Shot(Result<PathBuf, String>),
}

/// How other threads reach the loop.
#[derive(Debug, Clone)]
pub(super) struct Proxy(EventLoopProxy<Event>);

impl Proxy {
    pub(super) fn send(&self, event: Event) {
        // A loop that has ended needs no news.
        let _ = self.0.send_event(event);
    }
}

/// Runs the event loop until the window is closed.
///
/// # Errors
/// When there is no display or no usable adapter.
pub fn run(options: Options) -> Result<(), AppError> {
    let event_loop = EventLoop::with_user_event().build().map_err(|e| AppError::NoDisplay(e.to_string()))?;
    let proxy = Proxy(event_loop.create_proxy());
    let loaded = proxy.clone();
    let loader = Loader::start(move |answer| loaded.send(Event::Loaded(Box::new(answer))))
        .map_err(|e| AppError::System(format!("a thread: {e}")))?;
    let mut shell = Shell {
        started: Instant::now(),
        session: Session::default(),
        chrome: Chrome::default(),
        loader,
        watcher: None,
        wanted: options.scene.clone(),
        job_number: 0,
        opened: None,
        redraw_at: None,
        redraw_waits: false,
        compilation: 0,
        place: UVec2::ZERO,
        last_tick: None,
        wish: Wish::default(),
        shot: false,
        held_keys: Vec::new(),
        painted: 0,
        reopenings: 0,
        title: String::new(),
        closing: false,
        failed: None,
        options,
        proxy,
    };
    shell.start_watching();
    shell.request(Reason::Open, shell.wanted.clone());
    event_loop.run_app(&mut shell).map_err(|e| AppError::NoDisplay(e.to_string()))?;
    shell.failed.map_or(Ok(()), Err)
}

struct Shell {
    options: Options,
    proxy: Proxy,
    started: Instant,
    session: Session,
    chrome: Chrome,
    loader: Loader,
    watcher: Option<Watcher>,
    /// The file that was asked for last, whether or not it could be opened.
    wanted: Option<PathBuf>,
    job_number: u64,
    opened: Option<Opened>,
    redraw_at: Option<Instant>,
    /// A painting was asked for while the device worked.
    redraw_waits: bool,
    /// Counts compilations of shaders: the result of an older one, or for a device that is gone, is not used.
    compilation: u64,
    /// Size of the picture's place at the last painting, pixels.
    place: UVec2,
    /// When time was last advanced, while it runs.
    last_tick: Option<Instant>,
    wish: Wish,
    /// A screenshot is to be taken as soon as the picture is sharp.
    shot: bool,
    held_keys: Vec<egui::Key>,
    painted: u64,
    reopenings: u32,
    title: String,
    closing: bool,
    failed: Option<AppError>,
}

impl ApplicationHandler<Event> for Shell {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.opened.is_some() {
            return;
        }
        let mut size = SIZE;
        if let Some(monitor) = event_loop.primary_monitor().or_else(|| event_loop.available_monitors().next()) {
            let screen = monitor.size().to_logical::<f64>(monitor.scale_factor());
            let share = (SCREEN_SHARE * screen.width / size.width).min(SCREEN_SHARE * screen.height / size.height);
            if share > 0.0 && share < 1.0 {
                size = winit::dpi::LogicalSize::new(size.width * share, size.height * share);
            }
        }
        let attributes = Window::default_attributes().with_title("murrine").with_inner_size(size);
        let window = event_loop.create_window(attributes).map_err(|e| AppError::NoDisplay(e.to_string()));
        match window.and_then(|w| self.open(Arc::new(w))) {
            Ok(()) => tracing::info!(ms = self.started.elapsed().as_millis(), "the window is open"),
            Err(error) => self.fail(event_loop, error),
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if matches!(cause, StartCause::ResumeTimeReached { .. }) {
            self.redraw_at = None;
            self.redraw();
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, event: Event) {
        match event {
            Event::Loaded(answer) => self.receive(*answer),
            Event::FrameDone(result) => return self.frame_done(event_loop, result),
            Event::Changed(Change::Scene) => self.files_changed(),
            Event::Changed(Change::Shader) => self.shaders_changed(),
            Event::Complaint(text) => {
                // A lost device complains of everything; it is told of once.
                let is_lost = self.opened.as_ref().is_some_and(|o| o.gpu.check().is_err());
                if !is_lost {
                    tracing::error!("{text}");
                    self.session.notices.set(Topic::Device, Severity::Error, [text]);
                }
            }
            Event::Compiled(number, shaders, result) if number == self.compilation => self.compiled(shaders, *result),
            Event::Compiled(..) => {}
            Event::Held(result) => {
                let laboratory = &mut self.session.laboratory;
                match *result {
                    Ok(held) => laboratory.held = Some(held),
                    Err(error) => {
                        laboratory.holds = false;
                        self.session.notices.tell(Topic::Frame, Severity::Error, error.to_string());
                    }
                }
                self.session.laboratory.asked = None;
            }
            Event::Shot(Ok(path)) => {
                let text = format!("screenshot: {}", path.display());
                self.session.notices.tell(Topic::Files, Severity::Done, text);
            }
            Event::Shot(Err(text)) => self.session.notices.tell(Topic::Files, Severity::Error, text),
        }
        self.redraw();
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(opened) = &mut self.opened else { return };
        if !matches!(event, WindowEvent::RedrawRequested) && opened.egui.on_window_event(&opened.window, &event).repaint
        {
            self.redraw();
        }
        match event {
            WindowEvent::CloseRequested => self.leave(Leaving::Close),
            WindowEvent::RedrawRequested => self.draw(event_loop),
            WindowEvent::DroppedFile(path) => {
                self.chrome.dropping = false;
                self.open_file(&path);
            }
            WindowEvent::HoveredFile(_) => self.chrome.dropping = true,
            WindowEvent::HoveredFileCancelled => self.chrome.dropping = false,
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        if self.closing {
            event_loop.exit();
        }
        event_loop.set_control_flow(self.redraw_at.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}

impl Shell {
    fn open(&mut self, window: Arc<Window>) -> Result<(), AppError> {
        let opened = Opened::new(window, &self.options.adapter, self.options.shaders.as_deref(), &self.proxy)?;
        match &opened.shader_fault {
            Some(fault) => self.session.notices.tell(Topic::Shaders, Severity::Warning, fault.clone()),
            None => self.session.notices.clear(Topic::Shaders),
        }
        self.opened = Some(opened);
        self.compilation += 1;
        self.redraw();
        Ok(())
    }

    /// Ends the program; unsaved edits are written to a file of their own.
    fn fail(&mut self, event_loop: &ActiveEventLoop, error: AppError) {
        self.failed = Some(match self.session.rescue() {
            Some(path) => AppError::Rescued { error: Box::new(error), path },
            None => error,
        });
        event_loop.exit();
    }

    /// Asks for a painting; one that comes while the device works is put off until the frame is done, since it would
    /// only wait for it.
    fn redraw(&mut self) {
        match &self.opened {
            Some(opened) if opened.pictures.is_in_flight() => self.redraw_waits = true,
            Some(opened) => opened.window.request_redraw(),
            None => {}
        }
    }

    fn redraw_after(&mut self, delay: Duration) {
        if let Some(at) = Instant::now().checked_add(delay) {
            self.redraw_at = Some(self.redraw_at.map_or(at, |known| known.min(at)));
        }
    }

    fn draw(&mut self, event_loop: &ActiveEventLoop) {
        let Some(opened) = &mut self.opened else { return };
        let size = opened.size();
        if opened.pictures.is_in_flight() {
            self.redraw_waits = true;
            return;
        }
        self.redraw_waits = false;
        if let Err(error) = opened.gpu.check() {
            return self.frame_failed(event_loop, &error);
        }
        if size.min_element() == 0 || opened.window.is_minimized() == Some(true) {
            return;
        }
        opened.painter.resize(size);
        self.tick();
        match self.paint(event_loop) {
            Ok(place) => self.place = place,
            Err(error) => return self.fail(event_loop, error),
        }
        if let Err(error) = self.advance(self.place) {
            self.frame_failed(event_loop, &error);
        }
        self.name_window();
        self.painted += 1;
        if self.options.quit_after.is_some_and(|most| self.painted >= most) {
            event_loop.exit();
        }
    }

    /// Moves time on by what has passed since the last painting.
    fn tick(&mut self) {
        let now = Instant::now();
        let elapsed = self.last_tick.map_or(0.0, |last| now.duration_since(last).as_secs_f64());
        if !self.shot {
            self.session.timeline.advance(elapsed);
        }
        self.last_tick = self.session.timeline.is_running().then_some(now);
    }

    /// Runs and paints the interface; returns the picture's size in pixels.
    fn paint(&mut self, event_loop: &ActiveEventLoop) -> Result<UVec2, AppError> {
        let Some(opened) = &mut self.opened else { return Ok(UVec2::ZERO) };
        let ctx = opened.egui.egui_ctx().clone();
        let mut input = opened.egui.take_egui_input(&opened.window);
        let mut commands: Vec<Command> = take_keys(&ctx, &mut input, &mut self.held_keys);
        let picture = opened.pictures.picture().cloned();
        let beside = opened.pictures.picture_beside().cloned();
        let mut stage = Stage {
            session: &mut self.session,
            chrome: &mut self.chrome,
            measured: opened.pictures.measured(),
            frame: Some(opened.pictures.frame()),
            adapter: &opened.adapter,
            commands: Vec::new(),
        };
        let mut shown = (egui::Rect::NOTHING, false);
        let started = Instant::now();
        let output = ctx.run_ui(input, |ui| {
            stage.commands.clear();
            shown = panels::show(ui, &mut stage);
        });
        commands.append(&mut stage.commands);
        opened.egui.handle_platform_output_with_event_loop(&opened.window, event_loop, output.platform_output);
        let (place, times_on_view) = shown;
        let wipe = stage.session.laboratory.wipe;
        let place = (place * output.pixels_per_point).round();
        let delay = output.viewport_output.get(&egui::ViewportId::ROOT).map_or(Duration::MAX, |v| v.repaint_delay);
        let pixels_per_point = output.pixels_per_point;
        let input = PaintInput {
            shapes: output.shapes,
            textures: output.textures_delta,
            pixels_per_point,
            picture: picture.as_ref(),
            beside: beside.as_ref().map(|texture| (texture, wipe)),
            place,
        };
        let ui_ms = started.elapsed().as_secs_f64() * 1e3;
        let painted = opened.painter.paint(&opened.gpu, &opened.window, &ctx, input);
        tracing::debug!(ui_ms, paint_ms = started.elapsed().as_secs_f64() * 1e3 - ui_ms, ?delay, "painted");
        if painted == Painted::Lost {
            opened.replace_surface()?;
        }
        self.wish.timestamps = times_on_view;
        let holding = ctx.input(|i| i.pointer.any_down()) || ctx.text_edit_focused();
        self.session.observe_edits(holding);
        let again = matches!(painted, Painted::Again | Painted::Lost);
        let delay = if again { RETRY } else { delay.max(RETRY) };
        if delay < LONGEST_DELAY {
            self.redraw_after(delay);
        }
        for command in commands {
            self.carry_out(command, &ctx);
            self.redraw_after(Duration::ZERO);
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative, whole and small")]
        let size = UVec2::new(place.width().max(0.0) as u32, place.height().max(0.0) as u32);
        Ok(if place.is_finite() { size } else { UVec2::ZERO })
    }

    /// Starts the next frame, if one is needed, and plans the next painting.
    fn advance(&mut self, place: UVec2) -> Result<(), GpuError> {
        let Some(opened) = self.opened.as_mut().filter(|_| self.session.is_open) else { return Ok(()) };
        let wish = Wish { sharp: self.shot, ..self.wish };
        let next = opened.pictures.advance(&opened.gpu, &self.session, place, wish)?;
        self.wish.measure = false;
        match next {
            Next::SharpenAt(at) => self.redraw_after(at.saturating_duration_since(Instant::now())),
            Next::AtRest if self.shot => self.take_shot(),
            Next::AtRest if self.wants_truth() => self.ask_for_truth()?,
            Next::AtRest if self.session.timeline.is_running() => self.redraw_after(RETRY),
            Next::InFlight | Next::AtRest => {}
        }
        Ok(())
    }

    /// True when the voxels at rest are to be held against a truth that is not known, and nobody works on one.
    fn wants_truth(&self) -> bool {
        let laboratory = &self.session.laboratory;
        laboratory.holds
            && laboratory.asked.is_none()
            && self.session.held().is_none()
            && !self.session.timeline.is_running()
    }

    /// Has the truth of the frame at rest worked out on a thread of its own.
    fn ask_for_truth(&mut self) -> Result<(), GpuError> {
        let Some(opened) = &self.opened else { return Ok(()) };
        let frame = opened.pictures.frame();
        let (Some(triangles), Some(grid)) = (frame.triangles(), frame.volume().grids.first()) else { return Ok(()) };
        let session = &mut self.session;
        let own = session.scene.voxelizer.clone();
        let beside = session.laboratory.settings_beside(&own);
        let key = Key::of(session, session.time_secs());
        session.laboratory.asked = Some(key.clone());
        let job = laboratory::Job {
            key,
            gpu: opened.gpu.with_shaders(opened.gpu.shaders.clone()),
            triangles: triangles.standing(&opened.gpu)?,
            grid: *grid,
            settings: std::iter::once(own).chain(beside).collect(),
        };
        let proxy = self.proxy.clone();
        std::thread::spawn(move || proxy.send(Event::Held(Box::new(job.run()))));
        Ok(())
    }

    fn frame_done(&mut self, event_loop: &ActiveEventLoop, result: Result<(), String>) {
        let Some(opened) = &mut self.opened else { return };
        match result.map_err(GpuError::Lost) {
            Ok(()) => {
                opened.pictures.finished(&opened.gpu);
                if opened.pictures.is_between_parts() && !self.redraw_waits {
                    // Nobody wants anything: on with the sharp picture.
                    if let Err(error) = self.advance(self.place) {
                        self.frame_failed(event_loop, &error);
                    }
                    return;
                }
                let warnings = opened.pictures.frame().warnings().to_vec();
                if opened.pictures.measured().count == 1 {
                    tracing::info!(ms = self.started.elapsed().as_millis(), "the first picture is there");
                }
                self.session.notices.set(Topic::FrameWarnings, Severity::Warning, warnings);
                self.session.notices.clear(Topic::Frame);
            }
            Err(error) => self.frame_failed(event_loop, &error),
        }
        self.redraw();
    }

    /// Tells, and keeps the last good picture; a lost device is opened again.
    fn frame_failed(&mut self, event_loop: &ActiveEventLoop, error: &GpuError) {
        tracing::debug!("{error}");
        self.session.notices.tell(Topic::Frame, Severity::Error, error.to_string());
        let Some(opened) = &mut self.opened else { return };
        if matches!(error, GpuError::Lost(_)) {
            self.reopenings += 1;
            let window = Arc::clone(&opened.window);
            self.opened = None;
            if self.reopenings > MOST_REOPENINGS {
                return self.fail(event_loop, AppError::Gpu(GpuError::Lost("it was lost again and again".to_owned())));
            }
            match self.open(window) {
                Ok(()) => {
                    let text = format!("{error}; it was opened anew, and nothing of the scene is lost");
                    self.session.notices.clear(Topic::Frame);
                    self.session.notices.tell(Topic::Device, Severity::Warning, text);
                }
                Err(error) => self.fail(event_loop, error),
            }
        } else {
            opened.pictures.give_up(&self.session, self.place);
            self.shot = false;
            self.redraw_after(Duration::ZERO);
        }
    }

    fn take_shot(&mut self) {
        self.shot = false;
        let Some(opened) = &self.opened else { return };
        let picture = opened.pictures.frame().picture();
        let (width, height) = (picture.width(), picture.height());
        match buffer::read_texture::<[u8; 4]>(&opened.gpu, picture) {
            Ok(rgba8) => {
                let rgb8 = rgba8.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect();
                let picture = Picture { width, height, rgb8 };
                let (proxy, name) = (self.proxy.clone(), self.session.name());
                std::thread::spawn(move || {
                    proxy.send(Event::Shot(screenshot::write(&picture, &name, &screenshot::folders())));
                });
            }
            Err(error) => self.session.notices.tell(Topic::Files, Severity::Error, error.to_string()),
        }
    }

    fn carry_out(&mut self, command: Command, ctx: &egui::Context) {
        match command {
            Command::Act(action) => self.act(action, ctx),
            Command::Open(path) => self.open_file(&path),
            Command::SaveAs(path) => self.save(&path),
            Command::Measure => self.wish.measure = true,
            Command::SaveAndLeave => {
                self.save(&self.session.save_path());
                let saved = !self.session.is_edited();
                if let Some(leaving) = self.chrome.leaving.take().filter(|_| saved) {
                    self.go(leaving);
                }
            }
            Command::Leave => {
                if let Some(leaving) = self.chrome.leaving.take() {
                    self.go(leaving);
                }
            }
            Command::Stay => self.chrome.leaving = None,
        }
    }

    fn act(&mut self, action: ActionId, ctx: &egui::Context) {
        let session = &mut self.session;
        match action {
            ActionId::PlayPause => session.timeline.playing = !session.timeline.playing,
            ActionId::StepBack => session.timeline.step(-KEY_STEP_SECS),
            ActionId::StepForward => session.timeline.step(KEY_STEP_SECS),
            ActionId::Rewind => session.timeline.time_secs = 0.0,
            ActionId::FrameAll => {
                let full = self.opened.as_ref().map_or(UVec2::ONE, |o| o.pictures.measured().full);
                let aspect = full.x.max(1) as f32 / full.y.max(1) as f32;
                session.frame_all(aspect);
            }
            ActionId::ResetCamera => session.reset_camera(),
            ActionId::Show(mode) => session.view.mode = mode,
            ActionId::NextScene => self.open_neighbour(1),
            ActionId::PreviousScene => self.open_neighbour(-1),
            ActionId::Reload => self.request(Reason::Reload, self.session.path.clone()),
            ActionId::Save => self.save(&self.session.save_path()),
            ActionId::Undo => session.undo(),
            ActionId::Redo => session.redo(),
            ActionId::ResetScene => {
                session.reset_scene();
                if let environment @ Background::Environment { .. } = session.scene.background.clone() {
                    self.request_with(Reason::Background, self.session.path.clone(), Some(environment));
                }
            }
            ActionId::Screenshot => self.shot = true,
            ActionId::Panels => self.chrome.panels = !self.chrome.panels,
            ActionId::FullScreen => self.set_full_screen(!self.is_full_screen()),
            ActionId::LargerText => ctx.set_zoom_factor((ctx.zoom_factor() * TEXT_STEP).min(3.0)),
            ActionId::SmallerText => ctx.set_zoom_factor((ctx.zoom_factor() / TEXT_STEP).max(0.5)),
            ActionId::Help => self.chrome.help = !self.chrome.help,
            ActionId::Leave if self.chrome.leaving.is_some() => self.chrome.leaving = None,
            ActionId::Leave if self.chrome.help => self.chrome.help = false,
            ActionId::Leave => self.set_full_screen(false),
        }
    }

    fn is_full_screen(&self) -> bool {
        self.opened.as_ref().is_some_and(|o| o.window.fullscreen().is_some())
    }

    fn set_full_screen(&self, on: bool) {
        if let Some(opened) = &self.opened {
            opened.window.set_fullscreen(on.then_some(Fullscreen::Borderless(None)));
        }
    }

    fn name_window(&mut self) {
        let edited = if self.session.is_edited() { " •" } else { "" };
        let title = if self.session.is_open {
            format!("{}{edited} – murrine", self.session.name())
        } else {
            "murrine".to_owned()
        };
        if let Some(opened) = self.opened.as_ref().filter(|_| title != self.title) {
            opened.window.set_title(&title);
            self.title = title;
        }
    }

    fn open_file(&mut self, path: &Path) {
        if session::can_open(path) {
            self.leave(Leaving::Open(path.to_owned()));
        } else if session::is_environment(path) {
            let background = self.session.surrounded_by(path);
            self.request_with(Reason::Background, self.session.path.clone(), Some(background));
        } else {
            let text = format!(
                "{}: neither a scene (.toml) nor a model (.glb, .gltf, .npz) nor an environment (.hdr, .exr)",
                path.display()
            );
            self.session.notices.tell(Topic::Scene, Severity::Error, text);
        }
    }

    /// Leaves the scene; asks first where edits would be lost.
    fn leave(&mut self, leaving: Leaving) {
        if self.session.is_open && self.session.is_edited() {
            self.chrome.leaving = Some(leaving);
            self.redraw();
        } else {
            self.go(leaving);
        }
    }

    fn go(&mut self, leaving: Leaving) {
        match leaving {
            Leaving::Close => self.closing = true,
            Leaving::Open(path) => {
                self.wanted = Some(path);
                self.request(Reason::Open, self.wanted.clone());
            }
        }
    }

    fn open_neighbour(&mut self, by: i32) {
        let from = self.wanted.as_deref().or(self.session.path.as_deref());
        if let Some(path) = from.and_then(|p| session::neighbour(p, by)) {
            self.open_file(&path);
        }
    }

    fn save(&mut self, path: &Path) {
        if self.session.is_open {
            self.session.save(path);
            self.wanted = self.session.path.clone();
            self.watch_files();
        }
    }

    fn request(&mut self, reason: Reason, path: Option<PathBuf>) {
        self.request_with(reason, path, None);
    }

    /// Hands a job to the loader. Assignments of the command line hold for the scene it named.
    fn request_with(&mut self, reason: Reason, path: Option<PathBuf>, background: Option<Background>) {
        self.job_number += 1;
        let name = path.as_deref().and_then(Path::file_name).map(|n| n.to_string_lossy().into_owned());
        self.chrome.loading = Some(name.unwrap_or_else(|| "the built-in scene".to_owned()));
        let sets = if path == self.options.scene { self.options.sets.clone() } else { Vec::new() };
        let previous = self.session.world.clone();
        self.loader.request(Job { number: self.job_number, reason, path, sets, background, previous });
        self.redraw();
    }

    fn receive(&mut self, answer: Answer) {
        if answer.number != self.job_number {
            return;
        }
        self.chrome.loading = None;
        let fault = answer.result.as_ref().err().map(ToString::to_string);
        self.session.receive(answer);
        if let Some(fault) = fault.filter(|_| !self.session.is_open) {
            // Nothing was ever shown: the built-in scene, with the fault beside it.
            if let Ok(loaded) = super::loader::load(None, &[], None, &self.session.world) {
                let answer = Answer { number: 0, reason: Reason::Open, path: None, result: Ok(loaded) };
                self.session.receive(answer);
                self.session.notices.tell(Topic::Scene, Severity::Error, fault);
            }
        }
        self.watch_files();
    }

    fn start_watching(&mut self) {
        let changed = self.proxy.clone();
        match Watcher::start(move |change| changed.send(Event::Changed(change))) {
            Ok(watcher) => self.watcher = Some(watcher),
            Err(text) => self.session.notices.tell(Topic::Watch, Severity::Warning, text),
        }
        if let (Some(watcher), Some(folder)) = (&mut self.watcher, &self.options.shaders)
            && let Err(text) = watcher.watch_shaders(folder)
        {
            self.session.notices.tell(Topic::Watch, Severity::Warning, text);
        }
    }

    fn watch_files(&mut self) {
        let Some(watcher) = &mut self.watcher else { return };
        let files = self.session.files().into_iter().chain(self.wanted.clone());
        match watcher.watch_files(files) {
            Ok(()) => self.session.notices.clear(Topic::Watch),
            Err(text) => self.session.notices.tell(Topic::Watch, Severity::Warning, text),
        }
    }

    fn files_changed(&mut self) {
        if self.wanted == self.session.path {
            self.request(Reason::Changed, self.wanted.clone());
        } else {
            // The file that could not be opened may be mended.
            self.request(Reason::Open, self.wanted.clone());
        }
    }

    fn shaders_changed(&mut self) {
        let (Some(opened), Some(folder)) = (&self.opened, &self.options.shaders) else { return };
        self.compilation += 1;
        let shaders = ShaderLibrary::Folder(folder.clone());
        let (gpu, number, proxy) = (opened.gpu.with_shaders(shaders.clone()), self.compilation, self.proxy.clone());
        std::thread::spawn(move || {
            let started = Instant::now();
            let result = Pictures::compile(&gpu);
            tracing::debug!(ms = started.elapsed().as_millis(), "compiled");
            proxy.send(Event::Compiled(number, shaders, Box::new(result)));
        });
    }

    /// Goes on with new shaders; where they are wrong, the old ones and their picture stay.
    fn compiled(&mut self, shaders: ShaderLibrary, result: Result<Frame, GpuError>) {
        let Some(opened) = &mut self.opened else { return };
        match result {
            Ok(frame) => {
                opened.gpu.shaders = shaders;
                opened.pictures.replace(frame);
                self.session.notices.clear(Topic::Shaders);
            }
            Err(error) => self.session.notices.tell(Topic::Shaders, Severity::Error, error.to_string()),
        }
    }
}

/// Takes the key presses that mean actions out of the input, unless a text is being typed.
fn take_keys(ctx: &egui::Context, input: &mut egui::RawInput, held: &mut Vec<egui::Key>) -> Vec<Command> {
    let typing = ctx.text_edit_focused();
    let mut commands = Vec::new();
    input.events.retain(|event| {
        let egui::Event::Key { key, pressed, modifiers, .. } = event else { return true };
        let repeated = held.contains(key);
        held.retain(|k| k != key);
        if *pressed {
            held.push(*key);
        }
        match actions::of_key(*key, *modifiers).filter(|_| *pressed && !typing) {
            Some(action) => {
                if !repeated || actions::repeats(action) {
                    commands.push(Command::Act(action));
                }
                false
            }
            None => true,
        }
    });
    if input.events.iter().any(|e| matches!(e, egui::Event::WindowFocused(false))) {
        held.clear();
    }
    commands
}
