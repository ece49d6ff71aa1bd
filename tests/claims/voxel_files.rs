//! Voxels on disk: each format is read again by a library that is not ours (`.nrrd` by a parser of its own, after the
//! format's definition), and holds what the list held. A saved `.npz` is a model again.

mod hostile;
mod saved;

use crate::gpu;
use flate2::read::GzDecoder;
use glam::{DVec3, UVec3, Vec3};
use murrine::grid::Grid;
use murrine::headless;
use murrine::image::ImageError;
use murrine::scene::description::{MaterialOverride, Model, Scene, Shape, Source};
use murrine::scene::{World, material::Material};
use murrine::voxel_file::{VoxelBody, VoxelFormat, write};
use std::io::Read as _;
use std::path::PathBuf;
use std::sync::OnceLock;

const CELLS: UVec3 = UVec3::new(30, 24, 20);

fn model(name: &str, shape: Shape, of: MaterialOverride) -> Model {
    Model { name: name.to_owned(), source: Source::Shape(shape), materials: vec![of], ..Model::default() }
}

/// A ball of amber glass beside a red box.
fn scene() -> Scene {
    let amber = MaterialOverride { ior: Some(1.33), sigma: Some(Vec3::new(0.25, 1.0, 2.0)), ..Default::default() };
    let red = MaterialOverride {
        opaque: Some(true),
        base_color: Some(Vec3::new(0.8, 0.1, 0.05)),
        priority: Some(3),
        roughness: Some(0.5),
        ..Default::default()
    };
    let boxed = Shape::Box { min: Vec3::new(0.9, -0.6, -0.4), max: Vec3::new(1.7, 0.55, 0.5) };
    let ball = Shape::Icosphere { radius: 0.8, subdivisions: 4 };
    Scene { models: vec![model("ball", ball, amber), model("box", boxed, red)], ..Scene::default() }
}

fn body(solid: bool) -> &'static VoxelBody {
    static BODIES: [OnceLock<VoxelBody>; 2] = [const { OnceLock::new() }; 2];
    BODIES[usize::from(solid)].get_or_init(|| {
        let scene = scene();
        let world = World::load(&scene, None).unwrap();
        let grid = Grid::world_aligned(DVec3::new(-1.1, -1.2, -1.05), 0.1, CELLS);
        headless::voxel_body(gpu(), &scene, &world, 0.0, grid, solid).unwrap().0
    })
}

/// Writes the body and gives the file's bytes.
fn file(ending: &str, solid: bool) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("a.{ending}"));
    let format = VoxelFormat::of(&path, CELLS, solid).unwrap();
    write(&path, format, body(solid)).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    write(&path, format, body(solid)).unwrap();
    assert_eq!(bytes, std::fs::read(&path).unwrap(), "the same bytes every time");
    bytes
}

/// 1 + the part of each cell of the surface, [z][y][x].
fn surface_labels() -> Vec<u16> {
    let mut labels = vec![0; CELLS.element_product() as usize];
    for voxel in &body(false).voxels {
        labels[place(voxel.cell())] = u16::try_from(voxel.part + 1).unwrap();
    }
    labels
}

fn place(cell: UVec3) -> usize {
    ((cell.z * CELLS.y + cell.y) * CELLS.x + cell.x) as usize
}

#[test]
fn the_list_and_the_marked_cells_agree_and_each_cell_inside_has_its_part() {
    let (surface, solid) = (body(false), body(true));
    let marked = surface.marked.iter().filter(|m| **m == 1).count();
    assert_eq!(marked, surface.voxels.len());
    assert!(surface.voxels.iter().all(|v| surface.marked[place(v.cell())] == 1));
    assert_eq!(surface.voxels, solid.voxels);
    let inside = solid.interior.as_ref().unwrap();
    assert!(inside.iter().zip(&solid.marked).all(|(label, marked)| (*label != 0) == (*marked == 1)));
    for (label, at, half) in [(1, DVec3::ZERO, DVec3::splat(0.8)), (2, DVec3::new(1.3, 0.0, 0.05), DVec3::splat(0.4))] {
        let cells = inside.iter().filter(|l| **l == label).count();
        assert!(cells > 500, "{cells} of part {label} about {at} ± {half}");
        let cell = ((at - surface.origin) / surface.cell).as_uvec3();
        assert_eq!(inside[place(cell)], label);
    }
    assert!(surface.interior.is_none());
}

#[test]
fn an_npz_holds_every_array_and_the_table_of_materials() {
    let bytes = file("npz", true);
    let mut npz = ndarray_npy::NpzReader::new(std::io::Cursor::new(bytes)).unwrap();
    let body = body(true);
    let occupancy: ndarray::Array3<u8> = npz.by_name("occupancy").unwrap();
    assert_eq!(occupancy.shape(), [20, 24, 30]);
    let interior: ndarray::Array3<u16> = npz.by_name("interior").unwrap();
    assert!(interior.iter().eq(body.interior.as_ref().unwrap()));
    let index: ndarray::Array2<u16> = npz.by_name("index").unwrap();
    let [position, normal, color] =
        ["position", "normal", "color"].map(|name| npz.by_name::<ndarray::OwnedRepr<f32>, ndarray::Ix2>(name).unwrap());
    let part: ndarray::Array1<u16> = npz.by_name("part").unwrap();
    let triangle: ndarray::Array1<i32> = npz.by_name("triangle").unwrap();
    assert_eq!((index.shape(), part.len()), (&[body.voxels.len(), 3][..], body.voxels.len()));
    assert_eq!(occupancy.iter().filter(|o| **o == 1).count(), body.voxels.len());
    for (i, voxel) in body.voxels.iter().enumerate() {
        let row = |of: &ndarray::Array2<f32>| Vec3::new(of[(i, 0)], of[(i, 1)], of[(i, 2)]);
        assert_eq!((row(&position), row(&normal), row(&color)), (voxel.position, voxel.normal, voxel.color));
        let cell = UVec3::new(index[(i, 0)].into(), index[(i, 1)].into(), index[(i, 2)].into());
        assert_eq!(cell, voxel.cell());
        assert_eq!(occupancy[(cell.z as usize, cell.y as usize, cell.x as usize)], 1);
        assert_eq!((u32::from(part[i]), triangle[i].cast_unsigned()), (voxel.part, voxel.triangle));
    }
    let origin: ndarray::Array1<f64> = npz.by_name("origin").unwrap();
    let cell: ndarray::Array0<f64> = npz.by_name("cell").unwrap();
    assert!((origin[1] + 1.2).abs() < 1e-6 && (cell[()] - 0.1).abs() < 1e-6);
    let ior: ndarray::Array1<f32> = npz.by_name("ior").unwrap();
    let sigma: ndarray::Array2<f32> = npz.by_name("sigma").unwrap();
    let base_color: ndarray::Array2<f32> = npz.by_name("base_color").unwrap();
    let opaque: ndarray::Array1<u8> = npz.by_name("opaque").unwrap();
    assert_eq!((ior[0], sigma[(0, 2)], opaque[0], opaque[1], base_color[(1, 0)]), (1.33, 2.0, 0, 1, 0.8));
    let without = file("npz", false);
    let mut without = ndarray_npy::NpzReader::new(std::io::Cursor::new(without)).unwrap();
    assert!(without.by_name::<ndarray::OwnedRepr<u16>, ndarray::Ix3>("interior").is_err());
}

#[test]
fn an_npy_holds_the_marked_cells() {
    let bytes = file("npy", true);
    let array = npyz::NpyFile::new(&bytes[..]).unwrap();
    assert_eq!(array.shape(), [20, 24, 30]);
    assert_eq!(array.into_vec::<u8>().unwrap(), body(true).marked);
}

#[test]
fn a_vti_holds_a_value_a_cell_of_each_array() {
    use vtkio::model::{Attribute, DataSet, Piece, Vtk};
    let vtk = Vtk::parse_xml(&file("vti", true)[..]).unwrap();
    let DataSet::ImageData { origin, spacing, pieces, extent, .. } = vtk.data else { panic!("no image data") };
    assert!((origin[0] + 1.1).abs() < 1e-6 && (spacing[2] - 0.1).abs() < 1e-6);
    assert_eq!(extent.into_ranges(), [0..=30, 0..=24, 0..=20]);
    let Piece::Inline(piece) = pieces.into_iter().next().unwrap() else { panic!("no piece") };
    let array = |name: &str| {
        let of_name = |a: &&Attribute| matches!(a, Attribute::DataArray(a) if a.name == name);
        let Some(Attribute::DataArray(found)) = piece.data.cell.iter().find(of_name) else { panic!("no {name}") };
        found.data.clone()
    };
    assert_eq!(array("part").into_vec::<u16>().unwrap(), surface_labels());
    assert_eq!(array("interior").into_vec::<u16>().unwrap(), *body(true).interior.as_ref().unwrap());
    let occupancy = array("occupancy").into_vec::<u8>().unwrap();
    let normals = array("normal").into_vec::<f32>().unwrap();
    let colors = array("color").into_vec::<u8>().unwrap();
    assert_eq!((normals.len(), colors.len()), (3 * occupancy.len(), 3 * occupancy.len()));
    assert_eq!(occupancy, body(false).marked);
    for voxel in &body(true).voxels {
        let at = 3 * place(voxel.cell());
        assert_eq!(normals[at..at + 3], voxel.normal.to_array());
        assert_eq!(colors[at..at + 3], shown(voxel.part));
    }
    let text = String::from_utf8_lossy(&file("vti", true)).into_owned();
    assert!(text.contains(r#"Name="ior" NumberOfComponents="1" NumberOfTuples="2" format="ascii">1.33 1.5<"#));
}

/// The colour that viewers see of a part: red paint; or white light behind a quarter of the grid's 3 units of amber.
fn shown(part: u32) -> [u8; 3] {
    let linear = if part == 1 { Vec3::new(0.8, 0.1, 0.05) } else { (-Vec3::new(0.25, 1.0, 2.0) * 0.75).exp() };
    let curve = |x: f32| if x <= 0.003_130_8 { x * 12.92 } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within 0 … 255")]
    linear.to_array().map(|x| (curve(x) * 255.0 + 0.5) as u8)
}

#[test]
fn an_nrrd_holds_a_label_a_cell_and_the_materials_as_keys() {
    for solid in [false, true] {
        let bytes = file("nrrd", solid);
        // The definition: lines up to an empty one, `key: value` or `key:=value`; then the data.
        let end = bytes.windows(2).position(|w| w == b"\n\n").unwrap();
        let header = std::str::from_utf8(&bytes[..end]).unwrap();
        assert!(header.starts_with("NRRD0004\n"));
        let field = |key: &str| {
            let line = header.lines().find_map(|l| l.strip_prefix(key)).unwrap_or_else(|| panic!("no {key}"));
            line.trim_start_matches(":=").trim_start_matches(": ").to_owned()
        };
        let fields = ["type", "dimension", "sizes", "endian", "encoding", "space origin"].map(field);
        assert_eq!(fields[..5], ["uint16", "3", "30 24 20", "little", "gzip"]);
        let origin: Vec<f64> =
            fields[5].trim_matches(['(', ')']).split(',').map(|number| number.parse().unwrap()).collect();
        assert!((origin[0] + 1.05).abs() < 1e-6, "the middle of the first cell");
        assert_eq!((field("part 1 name"), field("part 1 ior")), ("ball/icosphere".to_owned(), "1.33".to_owned()));
        assert_eq!((field("part 2 opaque"), field("part 1 sigma")), ("true".to_owned(), "0.25 1 2".to_owned()));
        let mut data = Vec::new();
        GzDecoder::new(&bytes[end + 2..]).read_to_end(&mut data).unwrap();
        let labels: Vec<u16> = data.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
        let expected = if solid { body(true).interior.clone().unwrap() } else { surface_labels() };
        assert_eq!(labels, expected);
    }
}

#[test]
fn a_vox_holds_each_voxel_with_its_colour_and_glass_with_its_index() {
    for solid in [false, true] {
        let vox = dot_vox::load_bytes(&file("vox", solid)).unwrap();
        assert_eq!(vox.models.len(), 1);
        let model = &vox.models[0];
        assert_eq!((model.size.x, model.size.y, model.size.z), (30, 20, 24), "z is up");
        let expected = if solid { body(true).interior.clone().unwrap() } else { surface_labels() };
        assert_eq!(model.voxels.len(), expected.iter().filter(|l| **l != 0).count());
        for voxel in &model.voxels {
            let label = expected[place(UVec3::new(voxel.x.into(), voxel.z.into(), 19 - u32::from(voxel.y)))];
            assert_ne!(label, 0);
            let color = vox.palette[usize::from(voxel.i)];
            assert_eq!([color.r, color.g, color.b], shown(u32::from(label) - 1));
            let material = vox.materials.iter().find(|m| m.id == u32::from(voxel.i) + 1);
            let ior = material.and_then(|m| m.properties.get("_ior")).map(|ior| ior.parse::<f32>().unwrap());
            assert_eq!(ior.is_some(), label == 1, "only the ball is glass");
            assert!(ior.is_none_or(|ior| (ior - 0.33).abs() < 1e-6));
        }
    }
}

#[test]
fn a_palette_of_too_many_colours_keeps_the_255_nearest() {
    let mut body = body(false).clone();
    for (i, voxel) in (0_u16..).zip(&mut body.voxels) {
        voxel.part = 1;
        voxel.color = Vec3::new(f32::from(i % 97) / 97.0, f32::from(i % 31) / 31.0, 0.5);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vox");
    write(&path, VoxelFormat::Vox, &body).unwrap();
    let vox = dot_vox::load_bytes(&std::fs::read(&path).unwrap()).unwrap();
    let mut worst = 0;
    for (read, written) in vox.models[0].voxels.iter().zip(&body.voxels) {
        let color = vox.palette[usize::from(read.i)];
        let srgb = |x: f32| if x <= 0.003_130_8 { x * 12.92 } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        #[expect(clippy::cast_possible_truncation, reason = "within 0 … 255")]
        let red = (srgb(written.color.x) * 255.0).round() as i32;
        worst = worst.max((i32::from(color.r) - red).abs());
    }
    assert!((1..=32).contains(&worst), "the worst is {worst} of 255 away: fewer colours, but near ones");
}

#[test]
fn a_ply_holds_a_point_a_voxel_with_its_normal_and_colour() {
    use ply_rs_bw::ply::{DefaultElement, Property};
    let ply = ply_rs_bw::parser::Parser::<DefaultElement>::new().read_ply(&mut &file("ply", false)[..]).unwrap();
    let (points, body) = (&ply.payload["vertex"], body(false));
    assert_eq!(points.len(), body.voxels.len());
    let float = |element: &DefaultElement, name: &str| match element.get(name) {
        Some(Property::Float(x)) => *x,
        other => panic!("{name}: {other:?}"),
    };
    for (point, voxel) in points.iter().zip(&body.voxels) {
        let vector = |names: [&str; 3]| Vec3::from_array(names.map(|name| float(point, name)));
        assert_eq!(vector(["x", "y", "z"]), voxel.position);
        assert_eq!(vector(["nx", "ny", "nz"]), voxel.normal);
        let rgb = ["red", "green", "blue"].map(|name| match point.get(name) {
            Some(Property::UChar(c)) => *c,
            other => panic!("{name}: {other:?}"),
        });
        assert_eq!(rgb, shown(voxel.part));
        assert!(matches!(point.get("part"), Some(Property::UShort(p)) if u32::from(*p) == voxel.part));
    }
    let materials = &ply.payload["material"];
    assert_eq!((materials.len(), float(&materials[0], "ior")), (2, 1.33));
    assert_eq!(float(&materials[0], "sigma_blue"), 2.0);
}

#[test]
fn what_a_format_cannot_hold_is_refused_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| -> PathBuf { folder.path().join(name) };
    let told = |name: &str, cells: UVec3, solid: bool| match VoxelFormat::of(&path(name), cells, solid) {
        Err(ImageError::Unfit(_, what)) => what,
        other => panic!("{name}: {other:?}"),
    };
    assert!(told("a.vox", UVec3::new(16, 300, 16), false).contains("holds 256 cells along an axis"));
    assert!(told("a.ply", CELLS, true).contains("no interior"));
    assert!(told("a.stl", CELLS, false).contains("write one of .npy, .npz, .vti, .nrrd, .vox, .ply"));
    assert!(VoxelFormat::of(&path("a.vox"), UVec3::splat(256), true).is_ok());
    assert!(matches!(VoxelFormat::of(&path("no/a.npz"), CELLS, false), Err(ImageError::Place(..))));
}

/// The material of a part as the file has it.
fn material(part: usize) -> &'static Material {
    &body(true).parts[part].1
}
