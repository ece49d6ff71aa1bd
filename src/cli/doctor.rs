//! `murrine doctor`: what this machine's adapter and driver are, and what will and won't work.

use super::arguments::Adapter;
use super::{Failure, Outcome, Output};
use crate::compose::DebugView;
use crate::frame::Frame;
use crate::gpu::clock::StageClock;
use crate::gpu::{Gpu, GpuError};
use crate::headless::{self, Still};
use crate::march::Channel;
use crate::scene::{World, file};
use crate::volume::Volume;
use glam::UVec2;
use std::path::Path;
use std::time::Instant;

/// The smallest scene that uses every stage.
const PROBE: &str =
    "[grid]\ncells = 32\n[light_grid]\ncells = 32\n[[model]]\nshape = \"icosphere\"\nsubdivisions = 2\n";

pub(super) fn run(adapter: &Adapter, out: &mut Output) -> Result<Outcome, Failure> {
    out.line(format_args!("murrine {}", env!("CARGO_PKG_VERSION")))?;
    let mut checks = Checks { out, outcome: Outcome::Good };
    for info in adapters() {
        let kind = format!("{:?}", info.device_type);
        checks.out.line(format_args!("adapter    {} ({kind}, {:?})", info.name, info.backend))?;
        checks.out.line(format_args!("           driver {} {}", info.driver, info.driver_info))?;
    }
    match Gpu::open(&adapter.choice()) {
        Ok(gpu) => examine(&gpu, &mut checks)?,
        Err(error) => checks.fail("adapter", &error.to_string())?,
    }
    display(&mut checks)?;
    Ok(checks.outcome)
}

/// Every adapter of the machine.
fn adapters() -> Vec<wgpu::AdapterInfo> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::PRIMARY;
    let instance = wgpu::Instance::new(descriptor);
    let found = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    found.iter().map(wgpu::Adapter::get_info).collect()
}

struct Checks<'o> {
    out: &'o mut Output,
    outcome: Outcome,
}

impl Checks<'_> {
    fn pass(&mut self, what: &str, about: &str) -> Result<(), Failure> {
        self.out.line(format_args!("ok         {what}: {about}"))
    }

    /// Something works less well; the program does without.
    fn note(&mut self, what: &str, about: &str) -> Result<(), Failure> {
        self.out.line(format_args!("note       {what}: {about}"))
    }

    fn fail(&mut self, what: &str, about: &str) -> Result<(), Failure> {
        self.outcome = Outcome::Bad;
        self.out.line(format_args!("FAILS      {what}: {about}"))
    }
}

fn examine(gpu: &Gpu, checks: &mut Checks<'_>) -> Result<(), Failure> {
    checks.pass("adapter", &format!("using {}", gpu.info.name))?;
    if gpu.is_software() {
        checks.note("speed", "a software adapter: pictures are right, but slow; golden frames are made here")?;
    } else {
        checks.note("golden frames", "are made on lavapipe only; use --adapter software for them")?;
    }
    let limits = gpu.device.limits();
    let mib = limits.max_storage_buffer_binding_size >> 20;
    let about = format!("{mib} MiB a binding, pictures up to {} pixels wide", limits.max_texture_dimension_2d);
    if mib >= 128 {
        checks.pass("limits", &about)?;
    } else {
        checks.fail("limits", &format!("{about}; grids of 512 cells need 128 MiB"))?;
    }
    let (marked, rendered) = (headless::largest_cube(gpu), Volume::largest_cube(gpu));
    let about = format!(
        "marked alone {marked}x{marked}x{marked} cells, with records {rendered}x{rendered}x{rendered}, where memory allows"
    );
    checks.note("largest grids", &about)?;
    if !StageClock::is_supported(gpu) {
        checks.note("timestamps", "the adapter has none; stages are timed by waiting for them")?;
    } else if gpu.clock.is_true(gpu)? {
        checks.pass("timestamps", "agree with the wall clock")?;
    } else {
        checks.note("timestamps", "disagree with the wall clock; stages are timed by waiting for them")?;
    }
    match probe(gpu) {
        Ok(ms) => checks.pass("rendering", &format!("a 64x64 picture in {ms:.0} ms, compiling included")),
        Err(error) => checks.fail("rendering", &error.to_string()),
    }
}

fn probe(gpu: &Gpu) -> Result<f64, GpuError> {
    let started = Instant::now();
    let scene = file::parse(PROBE, Path::new("probe.toml"), &headless::methods());
    let opened = scene.and_then(|(scene, _)| World::load(&scene, None).map(|world| (scene, world)));
    let (scene, world) = opened.map_err(|e| GpuError::Lost(e.to_string()))?;
    let mut frame = Frame::new(gpu)?;
    let still = Still {
        scene: &scene,
        world: &world,
        time_secs: 0.0,
        size: UVec2::splat(64),
        antialias: false,
        channel: Channel::Beauty,
        view: DebugView::None,
    };
    headless::render(gpu, &mut frame, &still)?;
    headless::picture(gpu, &frame)?;
    Ok(started.elapsed().as_secs_f64() * 1e3)
}

fn display(checks: &mut Checks<'_>) -> Result<(), Failure> {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    if cfg!(not(all(unix, not(target_os = "macos")))) {
        return checks.pass("window", "the system has its own display");
    }
    let display = ["WAYLAND_DISPLAY", "DISPLAY"].into_iter().find(|name| set(name));
    match display {
        Some(name) => checks.pass("window", &format!("{name} is set"))?,
        None => checks.note("window", "neither WAYLAND_DISPLAY nor DISPLAY is set: use `murrine render`")?,
    }
    if !set("XDG_RUNTIME_DIR") {
        checks.note("XDG_RUNTIME_DIR", "is not set; Wayland and some drivers want it")?;
    }
    Ok(())
}
