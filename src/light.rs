//! Stage 5: walks each column of each light's grid and writes how much light is left after each record.
//!
//! Source: [`papers::CHANG_LAI_2011`](crate::papers::CHANG_LAI_2011), §3.1, Eq. 1: Σᵢ α(x, y, i)·E(x, y, i), i from the
//! light to the point's slice s.
//!
//! | paper   | here                                   | meaning                                                        |
//! |---------|----------------------------------------|----------------------------------------------------------------|
//! | (x, y)  | `column.cell`                          | a column of the grid that looks along the light                |
//! | i, s    | `slice`, `at`                          | slices along the light; where the point lies                   |
//! | E       | `media_ruling(light.media)`            | whether, and in which part, the light is                       |
//! | α       | `materials[part].sigma`, × length      | absorption, here of a world length and not of a voxel, RGB     |
//! | Σ       | `light.depth`                          | optical depth so far                                           |
//!
//! Differs: coloured; the light that is left is exp(−Σ) (Beer–Lambert), the paper's 1 − Σ is `shadow = "linear"`; chords
//! end where the column's centre line crosses the planes of the records, not at voxels, and parts may lie within one
//! another; stored after every record, so that it can be looked up at any depth, on glass and in it too
//! (`lib/light_volume.inc.wgsl`). Beside absorption, what the surfaces reflect away is kept as a separate factor: by
//! Fresnel's formulas for a light that goes straight on.
//! Promises: through a mesh whose crossings are all found, the sum over a column is exact up to the packing's steps.
//! Columns whose crossings don't pair up (open shells, holes) are walked again, each part counted at most once and
//! closed at the column's last record; they are marked, and neighbours stand in for them.
//! Costs: one thread a column, one step an occupied voxel; 8 bytes a record.

use crate::animate::Triangles;
use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Recorder, buffer};
use crate::grid::Grid;
use crate::scene::description::{EffectSettings, Shadow};
use crate::scene::material::PartMaterial;
use crate::volume::{Record, Volume};

crate::gpu_struct! {
    /// What the walk needs to know of the effect.
    pub struct LightSettings {
        /// 1 linear, 2 Beer–Lambert.
        pub shadow: u32,
        /// Padding.
        pub _pad: [u32; 3],
    }
}

/// The pass.
#[derive(Debug)]
pub struct LightColumns {
    pass: ComputePass,
    linear: wgpu::Buffer,
    beer_lambert: wgpu::Buffer,
}

impl LightColumns {
    /// Compiles the pass.
    ///
    /// # Errors
    /// When a shader is wrong.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let layouts = [Grid::LAYOUT, Record::LAYOUT, PartMaterial::LAYOUT, LightSettings::LAYOUT];
        let settings = |shadow| buffer::uniform(gpu, "light_settings", &LightSettings { shadow, _pad: [0; 3] });
        Ok(Self {
            pass: ComputePass::new(gpu, "light.wgsl", "main", &layouts)?,
            linear: settings(1),
            beer_lambert: settings(2),
        })
    }

    /// Records the walk of one light's grid into `volume.light_records`. Nothing to do where light is not shadowed.
    pub fn record(
        &self,
        rec: &mut Recorder<'_>,
        volume: &Volume,
        grid: usize,
        triangles: &Triangles,
        effect: &EffectSettings,
    ) {
        let settings = match effect.shadow {
            Shadow::None => return,
            Shadow::Linear => &self.linear,
            Shadow::BeerLambert => &self.beer_lambert,
        };
        let group = self.pass.bind(
            rec.gpu,
            &[
                ("grids", volume.grid_data.as_entire_binding()),
                ("grid_index", volume.grid_index[grid].as_entire_binding()),
                ("light_settings", settings.as_entire_binding()),
                ("occupancy", volume.occupancy.as_entire_binding()),
                ("ranks", volume.ranks.as_entire_binding()),
                ("records", volume.records.as_entire_binding()),
                ("materials", triangles.materials.as_entire_binding()),
                ("light_records", volume.light_records.as_entire_binding()),
            ],
        );
        let cells = volume.grids[grid].cells;
        self.pass.dispatch(&mut rec.encoder, &group, [cells.x, cells.y, 1]);
    }
}
