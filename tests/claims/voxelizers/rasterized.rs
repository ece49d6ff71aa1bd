//! Methods that rasterize: what they miss, and what being conservative finds.

use super::{
    Triangle, count, faults, from_within, gpu, huge, in_perspective, needles, soup, sphere, torus_of, try_words,
    turned, upload, words,
};
use glam::{DVec3, UVec3, Vec3};
use murrine::grid::Grid;
use murrine::scene::description::{Conservative, Separability, VoxelizerSettings};
use murrine::voxelize::{self, exact_voxels};

/// The ways that need nothing of the adapter.
const OURS: [Conservative; 3] = [Conservative::Polygon, Conservative::Box, Conservative::Dilated];

/// The methods that take them.
fn conservative_methods() -> Vec<&'static str> {
    let takes = |m: &&voxelize::Method| OURS.iter().all(|way| m.conservative.contains(way));
    let methods: Vec<_> = voxelize::METHODS.iter().filter(takes).map(|m| m.name).collect();
    assert!(methods.len() >= 3, "{methods:?}");
    methods
}

fn settings(method: &str, conservative: Conservative, conservative_depth: bool) -> VoxelizerSettings {
    VoxelizerSettings { method: method.to_owned(), conservative, conservative_depth, ..Default::default() }
}

/// Voxels of `part` that `whole` lacks.
fn outside(part: &[u32], whole: &[u32]) -> u32 {
    part.iter().zip(whole).map(|(part, whole)| (part & !whole).count_ones()).sum()
}

/// Bodies in grids that they may cross, pass by or reach behind the eye of.
fn cases() -> Vec<(&'static str, Grid, Vec<Triangle>)> {
    let straight = Grid::world_aligned(DVec3::splat(-1.0), 2.0 / 32.0, UVec3::splat(32));
    vec![
        ("torus", turned(UVec3::new(40, 31, 45)), torus_of(30)),
        ("torus in perspective", in_perspective(UVec3::new(40, 30, 35)), torus_of(30)),
        ("soup", turned(UVec3::splat(33)), soup(200)),
        ("needles", turned(UVec3::splat(48)), needles()),
        ("needles, straight", straight, needles()),
        ("huge", turned(UVec3::splat(24)), huge()),
        ("around a light", from_within(UVec3::new(40, 30, 35)), soup(150)),
    ]
}

#[test]
fn conservative_in_depth_too_nothing_of_the_truth_is_missing() {
    for (what, grid, triangles) in cases() {
        let truth = exact_voxels(&grid, &triangles, Separability::TwentySix);
        let uploaded = upload(&triangles);
        for method in conservative_methods() {
            let missing = |way, depth| faults(&words(grid, &uploaded, &settings(method, way, depth)), &truth).missing;
            for way in OURS {
                assert_eq!(missing(way, true), 0, "{method}, {way:?}, {what}");
            }
            // Either half alone does not do it.
            let halves = [missing(Conservative::None, true), missing(Conservative::Polygon, false)];
            assert!(halves.iter().all(|m| *m > 0), "{method}, {what}: {halves:?}");
        }
    }
}

#[test]
fn every_way_marks_what_middle_lines_do_the_box_what_the_polygon_does_and_dilation_no_less() {
    let mut grown = 0;
    for (what, grid, triangles) in cases() {
        let uploaded = upload(&triangles);
        for method in conservative_methods() {
            for depth in [false, true] {
                let of = |way| words(grid, &uploaded, &settings(method, way, depth));
                let [none, polygon, boxed, dilated] =
                    [Conservative::None, Conservative::Polygon, Conservative::Box, Conservative::Dilated].map(of);
                assert!(polygon == boxed, "{method}, {what}, {depth}");
                // Depths that the rasterizer's clipper rounded may fall into the next slice.
                let by_clipper = method == "slice-amplified" && !depth;
                let lost = outside(&none, &polygon);
                assert!(lost <= if by_clipper { count(&none) / 100 } else { 0 }, "{method}, {what}, {depth}: {lost}");
                assert_eq!(outside(&polygon, &dilated), 0, "{method}, {what}, {depth}");
                assert!(count(&none) < count(&polygon), "{method}, {what}, {depth}");
                grown += count(&dilated) - count(&polygon);
            }
        }
    }
    assert!(grown > 1000, "half a diagonal is more than half a side by {grown} voxels");
}

#[test]
fn a_slicemap_misses_steep_walls_unless_it_is_conservative_in_depth() {
    // One column wide and 30 slices tall: it leans over three columns.
    let grid = Grid::world_aligned(DVec3::ZERO, 1.0, UVec3::splat(32));
    let [a, b, c, d] = [[10.2, 10.3, 1.2], [13.1, 10.3, 30.7], [13.1, 20.8, 30.7], [10.2, 20.8, 1.2]].map(Vec3::from);
    let wall = [[a, b, c], [a, c, d]];
    let truth = exact_voxels(&grid, &wall, Separability::TwentySix);
    let found = |way, depth| {
        let words = words(grid, &upload(&wall), &settings("slicemap", way, depth));
        (count(&words), faults(&words, &truth))
    };
    // Three columns' middle lines meet it; eleven rows of middles.
    let (marked, none) = found(Conservative::None, false);
    assert_eq!((marked, none.spurious), (3 * 11, 0));
    for way in OURS {
        let (marked, shallow) = found(way, false);
        assert!(marked < 80 && shallow.missing > 250, "{way:?}: {marked} of {}", count(&truth.words));
        assert_eq!(found(way, true).1.missing, 0, "{way:?}");
    }
}

#[test]
fn a_pass_a_slice_and_a_bit_a_column_mark_the_same() {
    for (what, grid, triangles) in cases() {
        let uploaded = upload(&triangles);
        for way in [Conservative::None, Conservative::Polygon, Conservative::Dilated] {
            for depth in [false, true] {
                let of = |method| words(grid, &uploaded, &settings(method, way, depth));
                let slices = of("slices");
                assert!(slices == of("slicemap"), "{what}, {way:?}, {depth}");
                // Cut by the rasterizer's clipper, or at a depth that both slices own.
                let amplified = of("slice-amplified");
                let other: u32 = slices.iter().zip(&amplified).map(|(a, b)| (a ^ b).count_ones()).sum();
                assert!(other * 100 <= count(&slices) + 200, "{what}, {way:?}, {depth}: {other} of {}", count(&slices));
            }
        }
    }
}

#[test]
fn footprints_that_start_on_borders_of_cells_reach_the_cells_they_touch() {
    // A triangle on the borders of columns: closed cells on both sides are touched.
    let grid = Grid::world_aligned(DVec3::ZERO, 1.0, UVec3::splat(32));
    let triangle = [[8.0, 8.0, 5.5], [16.0, 8.0, 5.5], [8.0, 16.0, 5.5]].map(Vec3::from);
    let touched: u32 = (0..10).map(|row| if row == 0 { 10 } else { 11 - row }).sum();
    for method in conservative_methods() {
        for way in [Conservative::Polygon, Conservative::Box] {
            let words = words(grid, &upload(&[triangle]), &settings(method, way, false));
            assert_eq!(count(&words), touched, "{method}, {way:?}");
        }
    }
}

#[test]
fn the_adapters_own_way_marks_what_the_polygon_does_or_is_refused() {
    let grid = turned(UVec3::splat(48));
    let uploaded = upload(&torus_of(60));
    let has = gpu().device.features().contains(wgpu::Features::CONSERVATIVE_RASTERIZATION);
    for method in conservative_methods() {
        let hardware = try_words(grid, &uploaded, &settings(method, Conservative::Hardware, true));
        match hardware {
            Ok(words_of) => {
                assert!(has && words_of == words(grid, &uploaded, &settings(method, Conservative::Polygon, true)));
            }
            Err(refused) => {
                let told = refused.to_string();
                assert!(
                    !has && told.contains("has no conservative rasterization") && told.contains("polygon"),
                    "{told}"
                );
            }
        }
    }
}

#[test]
fn a_solid_slicemap_refuses_to_be_conservative() {
    let grid = turned(UVec3::splat(32));
    let uploaded = upload(&sphere());
    let refused = |way, depth| try_words(grid, &uploaded, &settings("slicemap-solid", way, depth));
    for way in OURS {
        let told = refused(way, false).unwrap_err().to_string();
        assert!(told.contains("slicemap-solid") && told.contains("conservative = \"none\""), "{told}");
    }
    assert!(refused(Conservative::None, true).is_err());
    assert!(refused(Conservative::None, false).is_ok());
}

#[test]
fn what_rasterizes_marks_its_own_region_alone_the_same_every_time_and_nothing_that_is_no_number() {
    let corner = Vec3::splat(0.1);
    let odd = upload(&[f32::NAN, f32::INFINITY].map(|x| [corner, corner + Vec3::X, Vec3::new(x, 0.4, 0.4)]));
    let uploaded = upload(&torus_of(60));
    let mut grid = turned(UVec3::new(40, 37, 45));
    for method in ["slices", "slicemap", "slicemap-solid"] {
        let settings = VoxelizerSettings { method: method.into(), ..Default::default() };
        grid.word_base = 0;
        let alone = words(grid, &uploaded, &settings);
        assert!(count(&alone) > 200, "{method}");
        assert!((0..3).all(|_| words(grid, &uploaded, &settings) == alone), "{method}");
        assert_eq!(count(&words(grid, &odd, &settings)), 0, "{method}");
        grid.word_base = 100;
        let region = words(grid, &uploaded, &settings);
        assert!(region[..100].iter().all(|w| *w == 0) && region[100..] == alone, "{method}");
    }
}
