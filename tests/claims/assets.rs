//! Our own models: remade byte for byte, closed where they claim to be.

#[path = "../../assets/make/models/mod.rs"]
mod models;

use std::collections::BTreeMap;
use std::path::Path;

/// A point by the bits of its coordinates.
type Point = [u32; 3];

fn committed(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets").join(name);
    std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}; run `make assets`", path.display()))
}

/// Every primitive's material and triangles, read by a reader that the renderer's own has no part in. Vertices at one
/// place are one vertex.
fn primitives(bytes: &[u8]) -> Vec<(String, Vec<[Point; 3]>)> {
    let file = gltf::Gltf::from_slice(bytes).unwrap();
    let blob = file.blob.as_deref().unwrap();
    let mut found = Vec::new();
    for primitive in file.meshes().flat_map(|mesh| mesh.primitives().collect::<Vec<_>>()) {
        let reader = primitive.reader(|_| Some(blob));
        let positions: Vec<Point> = reader.read_positions().unwrap().map(|p| p.map(f32::to_bits)).collect();
        let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        let triangles = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|i| positions[i as usize])).collect();
        found.push((primitive.material().name().unwrap().to_owned(), triangles));
    }
    found
}

/// Edges that don't have exactly one triangle on each side.
fn open_edges(triangles: &[[Point; 3]]) -> usize {
    let mut uses: BTreeMap<(Point, Point), [u32; 2]> = BTreeMap::new();
    for t in triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            uses.entry((a.min(b), a.max(b))).or_default()[usize::from(a > b)] += 1;
        }
    }
    uses.values().filter(|sides| **sides != [1, 1]).count()
}

fn signed_volume(triangles: &[[Point; 3]]) -> f32 {
    let corner = |p: Point| glam::Vec3::from(p.map(f32::from_bits));
    triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))) / 6.0).sum()
}

#[test]
fn remaking_the_models_gives_the_committed_bytes() {
    for (name, make) in models::ALL {
        assert!(make() == committed(name), "assets/{name} differs from what its code makes; run `make assets`");
    }
}

#[test]
fn own_models_are_closed_and_wound_outwards_but_for_the_leaky_shell() {
    for (name, _) in models::ALL.iter().filter(|(name, _)| name.ends_with(".glb")) {
        for (material, triangles) in primitives(&committed(name)) {
            let open = open_edges(&triangles);
            if *name == "shell.glb" {
                assert!(open > 100, "the shell must leak; {open} open edges");
                continue;
            }
            assert_eq!(open, 0, "assets/{name}, {material}");
            assert!(signed_volume(&triangles) > 0.0, "assets/{name}, {material} is inside out");
            let torn = &triangles[1..];
            assert_eq!(open_edges(torn), 3, "a hole of one triangle goes unnoticed in assets/{name}, {material}");
        }
    }
}

#[test]
fn own_models_are_small() {
    for (name, _) in models::ALL {
        let size = committed(name).len();
        assert!(size < 1_500_000, "assets/{name} has {size} bytes");
    }
}
