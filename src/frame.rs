//! The recipe: scene → animate → voxelize → resolve → fill → light → march → compose.
//!
//! The window, the headless renderer, the tests and the benchmarks all run this same recipe. It never waits for the
//! device: what the device counts comes back a frame late ([`Volume::fit`]). A stage whose inputs did not change since
//! the last frame is left out; [`Stale`] says which.

use crate::animate::{Animate, Triangles};
use crate::compose::{self, Compose, DebugView};
use crate::csg::{self, Csg};
use crate::fill::FillInterior;
use crate::gpu::{Gpu, GpuError, Recorder, StageTimes, Timing};
use crate::light::LightColumns;
use crate::march::{self, Channel, March, Radiance};
use crate::plane_light::PlaneLight;
use crate::resolve::Resolve;
use crate::scene::description::Fill;
use crate::scene::{Scene, World};
use crate::stale::{self, Inputs, Stale};
use crate::surroundings::{SurroundingsBuffers, surroundings};
use crate::volume::Volume;
use crate::voxel_cameras::VoxelCameras;
use crate::voxelize::{self, Cutoff, Method, Sheets, Voxelizer};
use glam::UVec2;
use std::ops::Range;

/// What is to be shown.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// What the scene names, loaded.
    pub world: &'a World,
    /// Seconds.
    pub time_secs: f64,
    /// Resolution at which rays are marched.
    pub size: UVec2,
    /// Resolution of the picture.
    pub picture_size: UVec2,
    /// Which float channel to write beside the picture.
    pub channel: Channel,
    /// What to show instead of the picture.
    pub view: DebugView,
    /// How the stages are timed.
    pub timing: Timing,
}

/// The renderer: its stages, and the buffers that stand between them.
#[derive(Debug)]
pub struct Frame {
    animate: Animate,
    voxelizer: Option<(&'static Method, Box<dyn Voxelizer>)>,
    resolve: Resolve,
    fill: FillInterior,
    csg: Option<Csg>,
    light: LightColumns,
    plane_light: PlaneLight,
    march: March,
    compose: Compose,

    triangles: Option<Triangles>,
    surroundings: Option<SurroundingsBuffers>,
    volume: Volume,
    radiance: Radiance,
    picture: wgpu::Texture,
    /// The true words of the view's grid, to hold cubes and slices against.
    truth: Option<wgpu::Buffer>,
    truth_is_new: bool,
    last: Option<Inputs>,
    /// Rows of the picture that are still to be marched.
    rows_left: Range<u32>,
    warnings: Vec<String>,
}

impl Frame {
    /// Compiles every stage.
    ///
    /// # Errors
    /// `file:line:column` of the first shader that is wrong.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let march = March::new(gpu)?;
        let compose = Compose::new(gpu)?;
        Ok(Self {
            animate: Animate::new(gpu)?,
            voxelizer: None,
            resolve: Resolve::new(gpu)?,
            fill: FillInterior::new(gpu)?,
            csg: None,
            light: LightColumns::new(gpu)?,
            plane_light: PlaneLight::new(gpu)?,
            triangles: None,
            surroundings: None,
            volume: Volume::new(gpu)?,
            radiance: march.target(gpu, UVec2::ONE),
            picture: compose.target(gpu, UVec2::ONE),
            march,
            compose,
            truth: None,
            truth_is_new: false,
            last: None,
            rows_left: 0..0,
            warnings: Vec::new(),
        })
    }

    /// Renders one frame into [`Frame::picture`] and [`Frame::radiance`] and returns the stages' times, if asked for.
    ///
    /// # Errors
    /// When the device refuses a buffer, or is lost. The last good picture stays.
    pub fn render(&mut self, gpu: &Gpu, request: &Request<'_>) -> Result<StageTimes, GpuError> {
        self.render_part(gpu, request, u32::MAX)
    }

    /// As [`Frame::render`], but marches no more than `most_rows` rows of the picture (at least [`march::ROWS`]). The
    /// same request again marches the next ones, another one starts anew; the picture changes once [`Frame::is_whole`].
    ///
    /// # Errors
    /// As [`Frame::render`].
    pub fn render_part(&mut self, gpu: &Gpu, request: &Request<'_>, most_rows: u32) -> Result<StageTimes, GpuError> {
        let mut rec = Recorder::new(gpu, request.timing);
        rec.stage("scene")?;
        let scene = request.scene;
        let world = &request.world.at(scene, request.time_secs, self.last.as_ref().map(|last| &last.world));
        let (inputs, cameras) = inputs_of(request, world);
        let mut stale = inputs.stale_since(self.last.as_ref());
        stale.compose |= std::mem::take(&mut self.truth_is_new);
        self.last = None; // until this frame is recorded whole
        self.make_ready(gpu, &Request { world, ..*request }, &inputs, &mut stale)?;
        stale.grids_anew(&self.volume.fit(gpu, &cameras.grids)?);
        self.csg = Csg::for_world(self.csg.take(), gpu, world, &self.volume)?;
        self.warnings = cameras.warnings;
        self.warnings.extend(world.warnings_now(scene));

        let (Some(triangles), Some(surroundings), Some((method, voxelizer))) =
            (&self.triangles, &self.surroundings, &mut self.voxelizer)
        else {
            return Ok(StageTimes::new());
        };
        let volume = &self.volume;

        if stale.animate {
            rec.stage("animate")?;
            self.animate.record(&mut rec, triangles, world, scene, &inputs.pose);
        }
        let stale_grids = || (0..volume.grids.len()).filter(|g| stale.grids[*g]);
        if stale.any_grid() {
            rec.stage("voxelize")?;
            for grid in stale_grids() {
                volume.clear(&mut rec, grid);
                let input = voxelize::Input { volume, grid, triangles, settings: &scene.voxelizer };
                voxelizer.record(&mut rec, &input)?;
            }
            rec.stage("resolve")?;
            for grid in stale_grids() {
                csg::record_resolve(self.csg.as_ref(), &mut rec, &self.resolve, volume, grid, triangles);
            }
            rec.stage("fill")?;
            let fills = scene.voxelizer.fill == Fill::Eager && (!method.interior || self.csg.is_some());
            for grid in stale_grids().filter(|_| fills) {
                self.fill.record(&mut rec, volume, grid, triangles, scene.effect.fill_questionable);
                self.csg.iter().for_each(|csg| csg.record_interior(&mut rec, volume, grid, triangles));
            }
        }
        if stale.light {
            rec.stage("light")?;
            for grid in cameras.light_grids.iter().cloned().flatten() {
                self.light.record(&mut rec, volume, grid as usize, triangles, &scene.effect);
            }
            self.plane_light.record(&mut rec, volume, triangles, (&inputs.surroundings, surroundings))?;
        }
        if stale.march {
            self.rows_left = 0..self.radiance.size.y;
        }
        let rows = march::take_rows(&mut self.rows_left, most_rows);
        if !rows.is_empty() {
            rec.stage("march")?;
            let (effect, channel, plane_light) = (&scene.effect, request.channel, self.plane_light.view());
            let background = inputs.surroundings.background_kind;
            let eye = inputs.surroundings.eye;
            let input = march::Input { volume, triangles, surroundings, eye, background, plane_light, effect, channel };
            self.march.record(&mut rec, &input, &self.radiance, rows.clone())?;
        }
        if self.rows_left.is_empty() && (stale.compose || !rows.is_empty()) {
            rec.stage("compose")?;
            let picture_size = request.picture_size.max(UVec2::ONE);
            if UVec2::new(self.picture.width(), self.picture.height()) != picture_size {
                self.picture = self.compose.target(gpu, picture_size);
            }
            let (radiance, materials, view) = (&self.radiance, &triangles.materials, request.view);
            let (channel, effect) = (request.channel, &scene.effect);
            let input = voxelize::Input { volume, grid: 0, triangles, settings: &scene.voxelizer };
            let classes = if view == DebugView::Classes { voxelizer.classes(&mut rec, &input)? } else { None };
            let (filled, truth) = (scene.voxelizer.fill == Fill::Eager, self.truth.as_ref());
            let input = compose::Input {
                radiance,
                channel,
                volume,
                materials,
                surroundings,
                effect,
                view,
                classes,
                filled,
                truth,
            };
            self.compose.record(&mut rec, &input, &self.picture);
        }
        self.volume.count(&mut rec);
        let times = rec.finish()?;
        // Only times that a frame does not wait for: a benchmark is not to search.
        if stale.any_grid() && request.timing == Timing::Timestamps {
            times.iter().filter(|(stage, _)| *stage == "voxelize").for_each(|(_, ms)| voxelizer.took(*ms));
        }
        self.last = Some(inputs);
        Ok(times)
    }

    /// Makes what the stages write into, where the old does not fit any more.
    fn make_ready(
        &mut self,
        gpu: &Gpu,
        request: &Request<'_>,
        inputs: &Inputs,
        stale: &mut Stale,
    ) -> Result<(), GpuError> {
        let Request { scene, world, .. } = *request;
        let has_room = |triangles| stale.world || !stale.animate || self.animate.write_remade(gpu, triangles, world);
        stale.world |= !self.triangles.as_ref().is_some_and(has_room);
        if stale.world {
            stale.materials = true;
            self.triangles = Some(self.animate.upload(gpu, world)?);
            self.surroundings = Some(SurroundingsBuffers::new(gpu, world)?);
        }
        if let Some(surroundings) = self.surroundings.as_ref().filter(|_| stale.march) {
            surroundings.write(gpu, &inputs.surroundings);
        }
        if let Some(triangles) = self.triangles.as_ref().filter(|_| stale.materials) {
            self.animate.write_materials(gpu, triangles, &inputs.materials);
        }
        if self.voxelizer.as_ref().map(|(method, _)| method.name) != Some(scene.voxelizer.method.as_str()) {
            let method = voxelize::method(&scene.voxelizer.method)?;
            self.voxelizer = Some((method, (method.new)(gpu)?));
        }
        if self.radiance.size != request.size.max(UVec2::ONE) {
            self.radiance = self.march.target(gpu, request.size.max(UVec2::ONE));
            stale.march = true;
        }
        stale.compose |= stale.march;
        Ok(())
    }

    /// From the next frame on, cubes and slices of the view's grid are held against these words (as
    /// [`Grid::word_of`](crate::grid::Grid::word_of) lays them out), or against none.
    pub fn hold_against(&mut self, truth: Option<wgpu::Buffer>) {
        self.truth_is_new |= truth != self.truth;
        self.truth = truth;
    }

    /// The triangles as the last frame animated them.
    #[must_use]
    pub fn triangles(&self) -> Option<&Triangles> {
        self.triangles.as_ref()
    }

    /// Forgets the last frame, so that the next one runs every stage: for timing them.
    pub fn forget(&mut self) {
        self.last = None;
    }

    /// False while rows of the last request's picture are still to be marched; the picture is then an earlier one.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.rows_left.is_empty()
    }

    /// True once the last frame had room for every record; else render again ([`Volume::fit`] grows).
    ///
    /// # Errors
    /// When the device is lost.
    pub fn settle(&mut self, gpu: &Gpu) -> Result<bool, GpuError> {
        self.volume.settle(gpu)
    }

    /// As [`Frame::settle`], from the counts that have come back so far, without waiting.
    pub fn had_room(&mut self, gpu: &Gpu) -> bool {
        self.volume.take_counts(gpu);
        self.volume.fits()
    }

    /// The picture, `rgba8unorm` holding sRGB-encoded values.
    #[must_use]
    pub fn picture(&self) -> &wgpu::Texture {
        &self.picture
    }

    /// Linear radiance and the float channel.
    #[must_use]
    pub fn radiance(&self) -> &Radiance {
        &self.radiance
    }

    /// The volume, for its counts and its memory.
    #[must_use]
    pub fn volume(&self) -> &Volume {
        &self.volume
    }

    /// The cut-off in use, of a method that has one.
    #[must_use]
    pub fn cutoff(&self) -> Option<Cutoff> {
        self.voxelizer.as_ref().and_then(|(_, voxelizer)| voxelizer.cutoff())
    }

    /// The sheet buffers of the view's grid, of a method that has them.
    #[must_use]
    pub fn sheets(&self) -> Option<&Sheets> {
        self.voxelizer.as_ref().and_then(|(_, voxelizer)| voxelizer.sheets())
    }

    /// What the last frame could not do as the scene asked, in words.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

/// All that the frame's stages depend on, and the grids.
fn inputs_of(request: &Request<'_>, world: &World) -> (Inputs, VoxelCameras) {
    let scene = request.scene;
    let pose = world.pose(scene, request.time_secs);
    let materials = world.materials(scene);
    let cameras = VoxelCameras::fit(scene, world, &materials, &pose);
    let aspect = request.picture_size.x.max(1) as f32 / request.picture_size.y.max(1) as f32;
    let view = (aspect, request.size.y);
    let inputs = Inputs {
        surroundings: surroundings(scene, world, &materials, view, &cameras.light_grids, cameras.scene_grid),
        world: world.clone(),
        pose,
        deformers: stale::deformers(scene),
        materials,
        grids: cameras.grids.clone(),
        voxelizer: scene.voxelizer.clone(),
        effect: scene.effect,
        size: request.size,
        picture_size: request.picture_size,
        channel: request.channel,
        view: request.view,
    };
    (inputs, cameras)
}
