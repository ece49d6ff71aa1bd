//! Environment pictures: read exactly, and refused when they are no such thing.

use image::{DynamicImage, ImageFormat, Rgb32FImage};
use murrine::scene::description::{Background, Scene};
use murrine::scene::{World, environment};
use std::io::Cursor;

fn encoded(width: u32, height: u32, format: ImageFormat) -> Vec<u8> {
    let texel = |x: u32, y: u32| image::Rgb([1.0, 0.25 * x as f32, 0.5 * y as f32]);
    let picture = DynamicImage::ImageRgb32F(Rgb32FImage::from_fn(width, height, texel));
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

#[test]
fn environments_keep_their_radiance_and_their_rows() {
    for (format, tolerance) in [(ImageFormat::OpenExr, 0.0), (ImageFormat::Hdr, 0.02)] {
        let map = environment::parse(&encoded(16, 8, format)).unwrap();
        assert_eq!((map.width, map.height, map.rgb.len()), (16, 8, 128));
        for (i, rgb) in map.rgb.iter().enumerate() {
            let expected = [1.0, 0.25 * (i % 16) as f32, 0.5 * (i / 16) as f32];
            let error = rgb.iter().zip(expected).map(|(a, b)| (a - b).abs() / 4.0).fold(0.0, f32::max);
            assert!(error <= tolerance, "{format:?} texel {i}: {rgb:?}, not {expected:?}");
        }
    }
}

#[test]
fn a_wide_environment_is_averaged_down() {
    let map = environment::parse(&encoded(8192, 2, ImageFormat::OpenExr)).unwrap();
    assert_eq!((map.width, map.height), (4096, 1));
    assert_eq!(map.rgb[10], [1.0, 0.25 * 20.5, 0.25]);
}

#[test]
fn what_is_no_environment_is_refused_with_a_remedy() {
    let mut huge = encoded(4, 4, ImageFormat::Hdr);
    let at = huge.windows(8).position(|w| w == b"-Y 4 +X ").unwrap();
    huge.splice(at..at + 9, *b"-Y 900000000 +X 900000000");
    let mut cut = encoded(64, 32, ImageFormat::OpenExr);
    cut.truncate(cut.len() / 2);
    for (bytes, told) in
        [(huge, "texels"), (cut, "can't be decoded"), (b"hello".to_vec(), "convert it"), (vec![], "convert it")]
    {
        let what = environment::parse(&bytes).unwrap_err();
        assert!(what.contains(told), "{what}");
    }
    let background = Background::Environment { file: "nowhere.hdr".into(), rotate_deg: 0.0, intensity: 1.0 };
    let error = World::load(&Scene { background, ..Scene::default() }, None).unwrap_err();
    assert!(error.place.contains("nowhere.hdr") && error.what.contains("can't be read"), "{error}");
}
