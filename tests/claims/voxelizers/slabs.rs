//! Grids cut into slabs: nobody can see where.

use super::*;
use glam::DVec3;
use murrine::gpu::{AdapterChoice, Gpu};
use murrine::grid::Slab;
use murrine::headless::VoxelSlabs;

/// A grid of cubes about −1 … 1, longer along z.
fn tall() -> Grid {
    Grid::world_aligned(DVec3::new(-1.03, -0.98, -1.01), 2.1 / 70.0, UVec3::new(68, 65, 70))
}

fn ring() -> Vec<Triangle> {
    mesh(&Shape::Torus { radius: 0.7, tube: 0.23, segments: 24 })
}

/// Words of one layer of 32 slices of [`tall`].
const LAYER_BYTES: u64 = 68 * 65 * 4;

/// What each list of slabs keeps, as one array \[z\]\[y\]\[x\], marked by one voxelizer.
fn marked_in<const N: usize>(
    gpu: &Gpu,
    settings: &VoxelizerSettings,
    lists: &[Vec<Slab>; N],
    solid: bool,
) -> [Vec<u8>; N] {
    let lengths = lists.each_ref().map(Vec::len);
    let triangles = upload_to(gpu, &ring());
    let mut slabs = VoxelSlabs::of_triangles(gpu, triangles, settings, lists.concat(), solid).unwrap();
    lengths.map(|length| slabs.by_ref().take(length).flat_map(|slab| slab.unwrap().into_slices().flatten()).collect())
}

fn differing(a: &[u8], b: &[u8]) -> Vec<usize> {
    assert_eq!(a.len(), b.len());
    (0..a.len()).filter(|i| a[*i] != b[*i]).collect()
}

#[test]
fn slabs_hold_every_slice_once_and_no_more_words_than_allowed() {
    let grid = tall();
    let whole = grid.slabs(3 * LAYER_BYTES).unwrap();
    assert_eq!(whole, [Slab { grid, slices: 0..70, skipped: 0 }]);
    for layers in 1..3 {
        let slabs = grid.slabs(layers * LAYER_BYTES + 3).unwrap();
        assert!(slabs.len() > 1);
        let slices: Vec<u32> = slabs.iter().flat_map(|slab| slab.slices.clone()).collect();
        assert_eq!(slices, (0..70).collect::<Vec<_>>());
        for Slab { grid: part, slices, skipped } in slabs {
            assert!(u64::from(part.word_count()) * 4 <= layers * LAYER_BYTES);
            // A slice beyond either cut, none beyond the grid.
            assert_eq!(skipped, u32::from(slices.start > 0));
            assert_eq!(part.cells.z, skipped + slices.end - slices.start + u32::from(slices.end < 70));
            let (first, lower) = (DVec3::new(3.0, 4.0, f64::from(skipped)), DVec3::new(3.0, 4.0, slices.start.into()));
            assert!(part.world_point(first).distance(grid.world_point(lower)) < 1e-6);
            assert!(part.grid_point(grid.world_point(lower)).distance(first) < 1e-4);
        }
    }
    assert_eq!(grid.slabs(LAYER_BYTES - 1), None);
}

#[test]
fn every_method_marks_and_fills_in_slabs_what_it_does_at_once() {
    let grid = tall();
    let at_once = vec![Slab { grid, slices: 0..70, skipped: 0 }];
    let slabs = grid.slabs(LAYER_BYTES).unwrap();
    // Slabs that are a slice off are told.
    let mut moved = slabs.clone();
    moved.iter_mut().for_each(|slab| slab.grid.grid_from_world.w_axis.z += 1.0);
    let truth = exact_voxels(&grid, &ring(), Separability::TwentySix);
    let ties = grid.cell_bytes(&truth.ties);
    for method in voxelize::METHODS {
        let settings = settings_of(method.name);
        for solid in [false, true] {
            if solid && voxelize::scans_whole_columns(method) {
                let triangles = upload_to(gpu(), &ring());
                let refused = VoxelSlabs::of_triangles(gpu(), triangles, &settings, slabs.clone(), true).unwrap_err();
                assert!(refused.to_string().contains("choose another voxelizer"), "{refused}");
                continue;
            }
            let lists = [at_once.clone(), slabs.clone(), moved.clone()];
            let [whole, cut, moved] = marked_in(gpu(), &settings, &lists, solid);
            let count = whole.iter().filter(|v| **v == 1).count();
            assert!(count > 2_000, "{}, solid {solid}: {count}", method.name);
            let changed = differing(&whole, &cut);
            // A slab's depths are smaller numbers, rounded finer.
            assert!(changed.len() <= 1 + count / 10_000, "{}, solid {solid}: {}", method.name, changed.len());
            if method.promise == Promise::Exact && !solid {
                assert!(changed.iter().all(|i| ties[*i] == 1), "{}: {changed:?}", method.name);
            }
            assert!(differing(&whole, &moved).len() > count / 100, "{}, solid {solid}", method.name);
        }
    }
}

/// The software device, allowed bindings of so many bytes.
fn confined(bytes: u64) -> Gpu {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = Gpu::pick(&instance, &AdapterChoice::Software).unwrap();
    let required_limits =
        wgpu::Limits { max_storage_buffer_binding_size: bytes, max_buffer_size: 64 << 20, ..Default::default() };
    let descriptor = wgpu::DeviceDescriptor { required_limits, ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    Gpu::new(adapter, device, queue)
}

#[test]
fn what_a_binding_cannot_hold_is_done_in_slabs_or_told_before_anything_is_allocated() {
    let bytes = 1 << 20;
    let gpu = confined(bytes);
    let mut volume = Volume::new(&gpu).unwrap();
    let before = volume.memory();
    let cube = |cells| Grid::world_aligned(DVec3::splat(-1.0), 2.0 / f64::from(cells), UVec3::splat(cells));
    let refused = volume.fit(&gpu, &[cube(384), cube(64)]).unwrap_err().to_string();
    for part in ["384x384x384, 64x64x64", "needs 71", "allows 1048576", "lower grid.cells or light_grid.cells"] {
        assert!(refused.contains(part), "no `{part}` in: {refused}");
    }
    assert_eq!((volume.memory(), volume.grids.len()), (before, 0));
    let largest = Volume::largest_cube(&gpu);
    assert!(volume.fit(&gpu, &[cube(largest)]).is_ok() && volume.fit(&gpu, &[cube(largest + 16)]).is_err());

    let settings = settings_of("triangle-parallel");
    let slabs = cube(240).slabs(bytes).unwrap();
    assert!(slabs.len() > 1, "{}", slabs.len());
    let [cut] = marked_in(&gpu, &settings, &[slabs], true);
    let [whole] = marked_in(super::gpu(), &settings, &[cube(240).slabs(u64::MAX).unwrap()], true);
    assert!(differing(&whole, &cut).len() < 10);
    assert_eq!(cube(600).slabs(bytes), None);
    let most = murrine::headless::largest_cube(&gpu);
    assert!((500..600).contains(&most), "{most}");
}

/// Takes minutes: `cargo test --test claims a_dragon_of_1024 -- --ignored`. The claims above are its likeness.
#[test]
#[ignore = "takes minutes and a scanned model"]
fn a_dragon_of_1024_cells_equals_the_truth_in_every_voxel() {
    let Some(triangles) = scanned("dragon_100000.glb") else { return };
    let grid = Grid::world_aligned(DVec3::splat(-0.8501), 1.7002 / 1024.0, UVec3::splat(1024));
    let slabs = grid.slabs(32 << 20).unwrap();
    let uploaded = upload(&triangles);
    let mut slabs = VoxelSlabs::of_triangles(gpu(), uploaded, &settings_of("hybrid"), slabs, false).unwrap();
    let (mut marked, mut ties) = (0, 0);
    for slab in slabs.by_ref().map(Result::unwrap) {
        let truth = exact_voxels(&slab.slab.grid, &triangles, Separability::TwentySix);
        assert_eq!(faults(&slab.words, &truth), Faults { missing: 0, spurious: 0 }, "{:?}", slab.slab.slices);
        (marked, ties) = (marked + count(&truth.words), ties + count(&truth.ties));
    }
    assert!(marked > 1_000_000 && ties < marked / 50, "{marked} voxels, {ties} ties");
}
