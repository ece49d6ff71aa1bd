//! `hybrid`'s ways of telling small triangles from large ones: none changes a voxel.

use super::{Triangle, in_perspective, settings_of, soup, torus, turned, upload};
use crate::gpu;
use glam::{DVec3, UVec2, UVec3, Vec3};
use murrine::compose::DebugView;
use murrine::frame::Frame;
use murrine::gpu::{Recorder, Timing, buffer};
use murrine::grid::Grid;
use murrine::headless::{self, Still};
use murrine::march::Channel;
use murrine::scene::World;
use murrine::scene::description::{
    Background, Classify, Light, MaterialOverride, Model, Scene, Shape, SizeMeasure, Source, VoxelizerSettings,
};
use murrine::volume::Volume;
use murrine::voxelize::{self, CutoffFrom, Input, Voxelizer};

/// A grid and triangles in it, to be marked again and again.
struct Marking {
    volume: Volume,
    triangles: murrine::animate::Triangles,
}

impl Marking {
    fn new(grid: Grid, triangles: &[Triangle]) -> Self {
        let mut volume = Volume::new(gpu()).unwrap();
        volume.fit(gpu(), &[grid]).unwrap();
        Self { volume, triangles: upload(triangles) }
    }

    fn words(&self, voxelizer: &mut dyn Voxelizer, settings: &VoxelizerSettings) -> Vec<u32> {
        let mut rec = Recorder::new(gpu(), Timing::Off);
        self.volume.clear(&mut rec, 0);
        voxelizer.record(&mut rec, &self.input(settings)).unwrap();
        rec.finish().unwrap();
        let count = self.volume.grids[0].word_count() as usize;
        buffer::read(gpu(), &self.volume.occupancy, 0, count).unwrap()
    }

    /// Which triangles are large.
    fn classes(&self, voxelizer: &mut dyn Voxelizer, settings: &VoxelizerSettings) -> Vec<bool> {
        let mut rec = Recorder::new(gpu(), Timing::Off);
        let classes = voxelizer.classes(&mut rec, &self.input(settings)).unwrap().cloned().unwrap();
        rec.finish().unwrap();
        let count = self.triangles.triangle_count;
        let bits: Vec<u32> = buffer::read(gpu(), &classes, 0, count.div_ceil(32) as usize).unwrap();
        (0..count).map(|t| bits[t as usize / 32] >> (t % 32) & 1 == 1).collect()
    }

    fn input<'a>(&'a self, settings: &'a VoxelizerSettings) -> Input<'a> {
        Input { volume: &self.volume, grid: 0, triangles: &self.triangles, settings }
    }
}

fn new(method: &str) -> Box<dyn Voxelizer> {
    (voxelize::method(method).unwrap().new)(gpu()).unwrap()
}

/// Size of a triangle seen along z, worked out by the book.
fn size_of(measure: SizeMeasure, [a, b, c]: [DVec3; 3]) -> f64 {
    let sides = [b - a, c - b, a - c].map(|e| e.truncate().length());
    let perimeter: f64 = sides.iter().sum();
    let area = 0.5 * (b - a).truncate().perp_dot((c - a).truncate()).abs();
    // The inscribed circle's radius grows by half of a pixel's diagonal, and all else with it.
    let (inner, reach) = (2.0 * area / perimeter, 0.5_f64.sqrt());
    let (lo, hi) = (a.min(b).min(c), a.max(b).max(c));
    let box_area = (hi - lo + 2.0 * reach).truncate().element_product();
    let dilated = (area * (1.0 + reach / inner).powi(2)).min(box_area);
    let cells = hi.floor() - lo.floor() + 1.0;
    match measure {
        SizeMeasure::Area => area,
        SizeMeasure::DilatedArea => dilated,
        SizeMeasure::Extent2d => cells.x * cells.y,
        SizeMeasure::Extent3d => cells.element_product(),
        SizeMeasure::AreaRatio => area / dilated,
    }
}

#[test]
fn every_measure_of_size_parts_triangles_and_changes_no_voxel() {
    let measures = [
        (SizeMeasure::Area, 4.0_f32),
        (SizeMeasure::DilatedArea, 12.0),
        (SizeMeasure::Extent2d, 9.0),
        (SizeMeasure::Extent3d, 27.0),
        (SizeMeasure::AreaRatio, 0.3),
    ];
    let mut voxelizer = new("hybrid");
    let triangles = soup(500);
    for grid in [turned(UVec3::new(64, 50, 90)), in_perspective(UVec3::new(64, 50, 90))] {
        let marking = Marking::new(grid, &triangles);
        let want = marking.words(&mut *new("triangle-parallel"), &settings_of("triangle-parallel"));
        let mut all_classes = Vec::new();
        for (size_measure, cutoff) in measures {
            for classify in [Classify::OnTheFly, Classify::First] {
                let cutoff_cells2 = Some(cutoff);
                let settings = VoxelizerSettings { size_measure, classify, cutoff_cells2, ..settings_of("hybrid") };
                assert!(marking.words(&mut *voxelizer, &settings) == want, "{size_measure:?}, {classify:?}");
                let classes = marking.classes(&mut *voxelizer, &settings);
                let large = classes.iter().filter(|large| **large).count();
                assert!((50..450).contains(&large), "{size_measure:?}: {large} are large");
                all_classes.push(classes);
            }
            let [.., on_the_fly, first] = all_classes.as_slice() else { panic!("two each") };
            assert_eq!(on_the_fly, first);
            if grid.projection == murrine::grid::ORTHOGRAPHIC {
                for (triangle, large) in triangles.iter().zip(first) {
                    let size =
                        size_of(size_measure, triangle.map(|p| grid.grid_point(p.as_dvec3()))) / f64::from(cutoff);
                    let is_sure = (size - 1.0).abs() > 1e-3;
                    assert!(!is_sure || *large == (size > 1.0), "{size_measure:?}: {size} of the cut-off");
                }
            }
        }
        all_classes.dedup();
        assert_eq!(all_classes.len(), measures.len(), "each measure has its own opinion");
    }
}

#[test]
fn an_automatic_cut_off_settles_and_changes_no_voxel_on_the_way() {
    let marking = Marking::new(turned(UVec3::splat(64)), &torus());
    let settings = settings_of("hybrid");
    let want = marking.words(&mut *new("triangle-parallel"), &settings_of("triangle-parallel"));
    let mut voxelizer = new("hybrid");
    let from = |voxelizer: &dyn Voxelizer| voxelizer.cutoff().unwrap().from;
    assert!(marking.words(&mut *voxelizer, &settings) == want);
    assert_eq!(from(&*voxelizer), CutoffFrom::Device, "nothing is known of the triangles yet");
    assert!(marking.words(&mut *voxelizer, &settings) == want);
    assert_eq!(from(&*voxelizer), CutoffFrom::Sizes, "their sizes have come back");
    // Without times it stays; with times it searches and settles where they are least.
    let modelled = voxelizer.cutoff().unwrap().cells2;
    assert!((0..5).all(|_| marking.words(&mut *voxelizer, &settings) == want));
    assert_eq!(voxelizer.cutoff().unwrap().cells2, modelled);
    let mut seen = Vec::new();
    for _ in 0..400 {
        let octave = f64::from(voxelizer.cutoff().unwrap().cells2.log2());
        voxelizer.took(1.0 + (octave - 3.0).abs());
        assert!(marking.words(&mut *voxelizer, &settings) == want);
        seen.push(octave);
        if from(&*voxelizer) == CutoffFrom::Times {
            break;
        }
    }
    assert_eq!((from(&*voxelizer), *seen.last().unwrap()), (CutoffFrom::Times, 3.0), "{seen:?}");
    // Settled: other times move nothing. Given by the scene: no search. Other triangles: anew.
    voxelizer.took(1e6);
    assert!(marking.words(&mut *voxelizer, &settings) == want);
    assert_eq!(voxelizer.cutoff().unwrap().cells2, 8.0);
    let given = VoxelizerSettings { cutoff_cells2: Some(5.0), ..settings.clone() };
    assert!(marking.words(&mut *voxelizer, &given) == want);
    assert_eq!((from(&*voxelizer), voxelizer.cutoff().unwrap().cells2), (CutoffFrom::Scene, 5.0));
    let other = Marking::new(turned(UVec3::splat(64)), &soup(300));
    other.words(&mut *voxelizer, &settings);
    assert_eq!(from(&*voxelizer), CutoffFrom::Device);
}

#[test]
fn the_view_of_classes_colours_voxels_by_the_way_their_triangle_was_marked() {
    let model = |name: &str, x: f32, shape: Shape| Model {
        name: name.to_owned(),
        source: Source::Shape(shape),
        translate: Vec3::new(x, 0.0, 0.0),
        materials: vec![MaterialOverride::default()],
        ..Model::default()
    };
    let slab = Shape::Box { min: Vec3::new(-0.7, -0.7, -0.3), max: Vec3::new(0.7, 0.7, 0.3) };
    let ball = Shape::Icosphere { radius: 0.7, subdivisions: 5 };
    let scene = |method: &str| Scene {
        models: vec![model("slab", -0.9, slab), model("ball", 0.9, ball)],
        lights: Vec::<Light>::new(),
        background: Background::Color { color: Vec3::ZERO },
        voxelizer: VoxelizerSettings { cutoff_cells2: Some(100.0), ..settings_of(method) },
        ..Scene::default()
    };
    let picture = |method: &str, view| {
        let scene = scene(method);
        let world = World::load(&scene, None).unwrap();
        let mut frame = Frame::new(gpu()).unwrap();
        let size = UVec2::new(120, 60);
        let channel = Channel::Beauty;
        let still = Still { scene: &scene, world: &world, time_secs: 0.0, size, antialias: false, channel, view };
        headless::render(gpu(), &mut frame, &still).unwrap();
        headless::picture(gpu(), &frame).unwrap()
    };
    let shown = picture("hybrid", DebugView::Classes);
    let at = |x: usize| shown.rgb8[30 * 120 + x].map(f32::from);
    let ([slab_r, _, slab_b], [ball_r, _, ball_b]) = (at(34), at(86));
    assert!(slab_b > 2.0 * slab_r, "the slab's twelve triangles are large: {:?}", at(34));
    assert!(ball_r > 2.0 * ball_b, "the ball's 20,480 are small: {:?}", at(86));
    // Of a method that makes no difference, the normals' colours.
    let cubes = picture("triangle-parallel", DebugView::Cubes);
    assert_eq!(picture("triangle-parallel", DebugView::Classes), cubes);
    assert!(shown != cubes);
}
