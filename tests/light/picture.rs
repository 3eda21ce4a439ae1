//! Pictures: their codes, their files, and how far two are apart.
//!
//! Codes are held against the rules by hand, files against bytes written by hand and other
//! writers, FLIP against the published program (`nv-flip`).

use exr::prelude::{Image, SpecificChannels, WritableImage, f16};
use landfall_light::picture::code::{code, codes};
use landfall_light::picture::compare::{Compare, Psnr};
use landfall_light::picture::difference::{NON_FINITE, amplification, difference, flip_picture};
use landfall_light::picture::file;
use landfall_light::picture::file::PictureFormat;
use landfall_light::picture::flip::{PIXELS_PER_DEGREE, flip};
use landfall_light::picture::{Codes, Picture, PictureError, Transfer, color_map, compare, pfm};
use snapbox::str;

use crate::support::command::golden;

const ODD: [f32; 8] =
    [0.0, -0.0, 1e-45, -1.5, 1e30, f32::INFINITY, f32::NEG_INFINITY, 0.333_333_34];

fn odd() -> Picture {
    let mut picture = Picture::filled(5, 3, [0.25, 0.5, 0.75, 1.0]);
    for (i, value) in ODD.iter().enumerate() {
        picture.pixels[i][i % 4] = *value;
    }
    picture.pixels[14] = [f32::from_bits(0x7fc0_1234), -f32::NAN, 2.0, 0.5];
    picture
}

fn bits(picture: &Picture) -> Vec<[u32; 4]> {
    picture.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

#[test]
fn linear_codes_round_to_nearest_and_halves_up() {
    let half = 0.5 / 255.0;
    let below = f32::from_bits((half as f32).to_bits() - 1);
    // 0.5 / 255 itself is no f32: the nearest one is above it.
    assert!(f64::from(half as f32) * 255.0 >= 0.5);
    assert_eq!(code(half as f32, Transfer::Linear), 1);
    assert_eq!(code(below, Transfer::Linear), 0);
    // 127.5 / 255 is one half and exact.
    assert_eq!(code(0.5, Transfer::Linear), 128);
    assert_eq!(code(1.0, Transfer::Linear), 255);
    assert_eq!(code(7.0, Transfer::Linear), 255);
    assert_eq!(code(-3.0, Transfer::Linear), 0);
}

#[test]
fn srgb_codes_follow_the_curve_of_iec_61966() {
    // 1.055 * 0.5^(1/2.4) - 0.055 = 0.735 357, times 255 = 187.516.
    assert_eq!(code(0.5, Transfer::Srgb), 188);
    // On the straight piece: 12.92 * 0.001 * 255 = 3.29.
    assert_eq!(code(0.001, Transfer::Srgb), 3);
    for transfer in [Transfer::Srgb, Transfer::Linear] {
        for stored in 0..=255u8 {
            let linear = transfer.decode(f64::from(stored) / 255.0) as f32;
            assert_eq!(code(linear, transfer), stored, "{transfer:?}");
        }
    }
}

#[test]
fn values_that_are_no_numbers_get_a_code_by_rule_and_are_counted() {
    let pixel = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
    for transfer in [Transfer::Srgb, Transfer::Linear] {
        let codes = codes(&Picture::filled(2, 1, pixel), transfer);
        assert_eq!(codes.pixels, vec![[0, 255, 0, 0]; 2]);
        assert_eq!(codes.non_finite, 8);
    }
}

#[test]
fn floats_come_back_from_exr_bit_for_bit() {
    let bytes = file::write(&odd(), PictureFormat::Exr, Transfer::Srgb).unwrap();
    let read = file::read(&bytes, PictureFormat::Exr, Transfer::Srgb).unwrap();
    assert_eq!(bits(&read), bits(&odd()));
    assert_eq!((read.width, read.height), (5, 3));
}

#[test]
fn half_floats_without_alpha_are_read_from_exr() {
    let channels =
        SpecificChannels::rgb(|_| (f16::from_f32(0.5), f16::from_f32(2.0), f16::from_f32(-1.0)));
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_channels((3, 2), channels).write().to_buffered(&mut bytes).unwrap();
    let read = file::read(&bytes.into_inner(), PictureFormat::Exr, Transfer::Srgb).unwrap();
    assert_eq!(read, Picture::filled(3, 2, [0.5, 2.0, -1.0, 1.0]));
}

#[test]
fn a_float_map_has_its_header_and_its_bottom_row_first() {
    let picture =
        Picture { width: 1, height: 2, pixels: vec![[1.0, 2.0, 3.0, 0.5], [4.0, 5.0, 6.0, 1.0]] };
    let mut wanted = b"PF\n1 2\n-1.0\n".to_vec();
    for float in [4f32, 5.0, 6.0, 1.0, 2.0, 3.0] {
        wanted.extend(float.to_le_bytes());
    }
    assert_eq!(pfm::write(&picture).unwrap(), wanted);
    let mut opaque = odd();
    opaque.pixels.iter_mut().for_each(|pixel| pixel[3] = 1.0);
    assert_eq!(bits(&pfm::read(&pfm::write(&odd()).unwrap()).unwrap()), bits(&opaque));
}

#[test]
fn grey_and_big_endian_float_maps_are_read() {
    let mut bytes = b"Pf 2 1\t1.0\n".to_vec();
    bytes.extend([0.25f32, 8.0].iter().flat_map(|float| float.to_be_bytes()));
    let pixels = vec![[0.25, 0.25, 0.25, 1.0], [8.0, 8.0, 8.0, 1.0]];
    assert_eq!(pfm::read(&bytes).unwrap(), Picture { width: 2, height: 1, pixels });
}

#[test]
fn png_keeps_codes_and_what_they_mean() {
    for (transfer, chunk) in [(Transfer::Srgb, "sRGB"), (Transfer::Linear, "gAMA")] {
        // The last pixel alone may have an alpha; colours are noise.
        for (alpha, channels) in [(255, 3), (7, 4)] {
            let mut random = fastrand::Rng::with_seed(5);
            let mut code = |_| [random.u8(..), random.u8(..), random.u8(..), 255];
            let mut pixels: Vec<[u8; 4]> = (0..300 * 200).map(&mut code).collect();
            pixels[300 * 200 - 1][3] = alpha;
            let (width, height, stored) = (300, 200, Some(transfer));
            let codes = Codes { width, height, pixels, transfer: stored, non_finite: 0 };
            let picture = codes.picture(Transfer::Srgb);
            let bytes = landfall_light::picture::png::write(&picture, transfer).unwrap();
            assert!(bytes.windows(4).any(|four| four == chunk.as_bytes()), "{chunk}");
            assert_eq!(landfall_light::picture::png::read(&bytes).unwrap(), codes);
            // What does not compress is stored: a byte a row and a few dozen of headers more.
            let raw = channels * 300 * 200;
            assert!((raw..raw + 200 + 400).contains(&bytes.len()), "{} {raw}", bytes.len());
        }
    }
}

#[test]
fn png_of_several_strips_is_compressed_and_keeps_an_alpha_wherever_it_is() {
    let (width, height) = (301, 200);
    for alpha_at in [None, Some(0), Some(301 * 100), Some(301 * 200 - 1)] {
        let shade = |at: u32| [(at % width / 2) as u8, (at / width) as u8, 7, 255];
        let mut pixels: Vec<[u8; 4]> = (0..width * height).map(shade).collect();
        if let Some(at) = alpha_at {
            pixels[at][3] = 254;
        }
        let transfer = Some(Transfer::Srgb);
        let codes = Codes { width, height, pixels, transfer, non_finite: 0 };
        let picture = codes.picture(Transfer::Srgb);
        let bytes = landfall_light::picture::png::write(&picture, Transfer::Srgb).unwrap();
        assert_eq!(landfall_light::picture::png::read(&bytes).unwrap(), codes);
        assert!(bytes.len() < 301 * 200, "{}", bytes.len());
    }
}

#[test]
fn grey_and_indexed_png_are_read_and_deeper_ones_refused() {
    let encode = |color, depth, palette: Option<&[u8]>, data: &[u8], gamma: Option<u32>| {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if let Some(palette) = palette {
            encoder.set_palette(palette.to_vec());
        }
        if let Some(gamma) = gamma {
            encoder.set_source_gamma(png::ScaledFloat::from_scaled(gamma));
        }
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(data).unwrap();
        writer.finish().unwrap();
        bytes
    };
    use png::{BitDepth, ColorType};
    let read = landfall_light::picture::png::read;
    let grey = encode(ColorType::Grayscale, BitDepth::Eight, None, &[9, 200], Some(45_455));
    let grey = read(&grey).unwrap();
    assert_eq!(grey.pixels, [[9, 9, 9, 255], [200, 200, 200, 255]]);
    assert_eq!(grey.transfer, Some(Transfer::Srgb));
    let palette = [1, 2, 3, 4, 5, 6];
    let indexed =
        encode(ColorType::Indexed, BitDepth::One, Some(&palette), &[0b0100_0000], Some(100_000));
    let indexed = read(&indexed).unwrap();
    assert_eq!(indexed.pixels, [[1, 2, 3, 255], [4, 5, 6, 255]]);
    assert_eq!(indexed.transfer, Some(Transfer::Linear));
    let plain = encode(ColorType::Rgb, BitDepth::Eight, None, &[1, 2, 3, 4, 5, 6], None);
    assert_eq!(read(&plain).unwrap(), Codes { transfer: None, ..indexed });
    let deep = encode(ColorType::Grayscale, BitDepth::Sixteen, None, &[1, 2, 3, 4], None);
    let said = read(&deep).unwrap_err().to_string();
    golden().eq(
        &said,
        str!["is a PNG with 16 bits a channel, which is not supported; save it with 8, or as EXR"],
    );
    let odd = encode(ColorType::Grayscale, BitDepth::Eight, None, &[1, 2], Some(50_000));
    let said = read(&odd).unwrap_err().to_string();
    golden().eq(&said, str!["is a PNG with gamma 0.5, which is not supported; save it as sRGB, or linear with gamma 1"]);
}

#[test]
fn broken_files_are_refused_in_every_format() {
    for format in [PictureFormat::Png, PictureFormat::Exr, PictureFormat::Pfm] {
        let whole = file::write(&odd(), format, Transfer::Srgb).unwrap();
        assert!(file::read(&whole, format, Transfer::Srgb).is_ok());
        for len in 0..whole.len() {
            // A PNG without its last chunk is whole enough for its pixels.
            let read = file::read(&whole[..len], format, Transfer::Srgb);
            assert!(
                read.is_err() || format == PictureFormat::Png && len + 12 >= whole.len(),
                "{len}"
            );
        }
        let mut random = fastrand::Rng::with_seed(9);
        for _ in 0..3000 {
            let mut bytes = whole.clone();
            for _ in 0..random.usize(1..6) {
                let at = random.usize(..bytes.len());
                bytes[at] = random.u8(..);
            }
            // Either is right; neither may panic or take memory without end.
            let _ = file::read(&bytes, format, Transfer::Srgb);
        }
        let junk: Vec<u8> = (0..100_000).map(|_| random.u8(..)).collect();
        assert!(file::read(&junk, format, Transfer::Srgb).is_err());
    }
}

#[test]
fn a_size_that_no_memory_holds_is_refused_before_memory_is_asked_for() {
    let said = pfm::read(b"PF\n4000000000 4000000000\n-1.0\n").unwrap_err();
    assert_eq!(said, PictureError::TooLarge { width: 4_000_000_000, height: 4_000_000_000 });
    golden().eq(
        pfm::read(b"PF\n0 7\n-1.0\n").unwrap_err().to_string(),
        str!["a picture of 0 x 7 pixels is empty"],
    );
    let mut header = Vec::new();
    png::Encoder::new(&mut header, 2_000_000_000, 2_000_000_000).write_header().ok();
    let said = file::read(&header, PictureFormat::Png, Transfer::Srgb).unwrap_err().to_string();
    golden().eq(&said, str!["a picture of 2000000000 x 2000000000 has 4000000000000000000 pixels; at most 67108864 are read"]);
}

#[test]
fn a_format_is_told_by_the_end_of_its_name() {
    assert_eq!(PictureFormat::from_path("a.b/six.PNG"), Ok(PictureFormat::Png));
    assert_eq!(PictureFormat::from_path("six.exr"), Ok(PictureFormat::Exr));
    golden().eq(
        PictureFormat::from_path("png").unwrap_err().to_string(),
        str!["has no known extension; use `.png`, `.exr` or `.pfm`"],
    );
}

#[test]
fn steps_are_counted_as_by_hand() {
    let a = Picture::filled(10, 10, [0.4, 0.4, 0.4, 1.0]);
    let mut b = a.clone();
    b.pixels[3][0] = 0.4 + 1.0 / 255.0;
    b.pixels[14][1] = 0.4 - 2.0 / 255.0;
    b.pixels[25][2] = 0.4 + 100.0 / 255.0;
    b.pixels[25][3] = 0.5;
    // Over full scale in floats, not in codes: both are 255.
    let c = Picture::filled(10, 10, [2.0, 0.5, 0.5, 1.0]);
    let mut d = c.clone();
    d.pixels[7][0] = 3.0;
    let options = Compare { transfer: Transfer::Linear, leave_out: None };
    let found = compare(&a, &b, &options).unwrap();
    assert_eq!((found.pixels, found.codes.channels, found.left_out), (100, 300, 0));
    assert_eq!(found.codes.counts, [297, 1, 1, 1]);
    assert_eq!(found.codes.max, 100);
    assert_eq!(found.codes.flips, 0.01);
    assert!((found.linear.max - 100.0).abs() < 1e-4, "{}", found.linear.max);
    assert_eq!(found.linear.at, Some([5, 2]));
    // Of 300 channels, rank 300 is the first that covers 99.9 %.
    assert_eq!(found.linear.p999, found.linear.max);
    assert!((found.linear.mean - 103.0 / 300.0).abs() < 1e-4);
    assert_eq!(found.linear.alpha_max, 127.5);
    let wanted = 10.0 * (255.0 * 255.0 * 300.0 / (1.0 + 4.0 + 10_000.0f64)).log10();
    assert_eq!(found.psnr, Psnr::Db(wanted));
    let found = compare(&c, &d, &options).unwrap();
    assert_eq!((found.linear.max, found.codes.max, found.psnr), (255.0, 0, Psnr::Identical));
    assert_eq!((found.flip.mean, found.flip.max), (0.0, 0.0));
}

#[test]
fn the_percentile_leaves_one_in_a_thousand_above() {
    let a = Picture::filled(100, 100, [0.0, 0.0, 0.0, 1.0]);
    let mut b = a.clone();
    // 31 of 30,000 channels: one more than a thousandth.
    for (i, pixel) in b.pixels.iter_mut().take(31).enumerate() {
        pixel[0] = (i + 1) as f32 / 255.0;
    }
    let found = compare(&a, &b, &Compare::default()).unwrap();
    assert!((found.linear.p999 - 1.0).abs() < 1e-5, "{}", found.linear.p999);
    b.pixels[0][0] = 0.0;
    assert_eq!(compare(&a, &b, &Compare::default()).unwrap().linear.p999, 0.0);
}

#[test]
fn no_number_is_never_the_same_as_a_number() {
    let a = Picture::filled(4, 4, [0.0, 0.5, 1.0, 1.0]);
    let mut b = a.clone();
    // By its rule of codes a NaN would be 0, as the other picture is.
    b.pixels[5][0] = f32::NAN;
    b.pixels[6][2] = f32::INFINITY;
    b.pixels[7][3] = f32::NAN;
    let found = compare(&a, &b, &Compare::default()).unwrap();
    let counts = found.non_finite;
    assert_eq!((counts.a, counts.b, counts.either, counts.pixels), (0, 2, 2, 3));
    assert_eq!(found.codes.channels, 46);
    let text = landfall::report::compare::human(&found);
    golden().eq(
        &text,
        str![[r#"
pixels       16 compared
linear       max 0 steps, 99.9 % within 0, mean 0
8-bit        max 0 steps (srgb); of 46 channels, 0 differ by 1, 0 by 2, 0 by 3
             or more
flips        0 % of the 8-bit values
psnr         infinite: all 8-bit values are equal
FLIP         mean 0, max 0
non-finite   3 pixels: 0 channels of the first picture, 2 of the second

"#]],
    );
    let drawn = difference(&a, &b, 1.0).unwrap();
    assert_eq!(drawn.pixels[5], NON_FINITE);
    assert_eq!(drawn.pixels[0], [0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn undefined_fragments_are_left_out_and_counted_and_do_not_glow() {
    let a = Picture::filled(20, 20, [0.2, 0.2, 0.2, 1.0]);
    let mut b = a.clone();
    let mut leave_out = vec![false; 400];
    b.pixels[210] = [f32::NAN; 4];
    b.pixels[211] = [1.0; 4];
    leave_out[210] = true;
    leave_out[211] = true;
    let options = Compare { transfer: Transfer::Srgb, leave_out: Some(&leave_out) };
    let found = compare(&a, &b, &options).unwrap();
    assert_eq!((found.pixels, found.left_out), (398, 2));
    assert_eq!((found.linear.max, found.non_finite.pixels), (0.0, 0));
    assert_eq!((found.flip.max, found.psnr), (0.0, Psnr::Identical));
    let text = landfall::report::compare::human(&found);
    golden().eq(
        &text,
        str![[r#"
pixels       398 compared, 2 left out as undefined
linear       max 0 steps, 99.9 % within 0, mean 0
8-bit        max 0 steps (srgb); of 1,194 channels, 0 differ by 1, 0 by 2, 0
             by 3 or more
flips        0 % of the 8-bit values
psnr         infinite: all 8-bit values are equal
FLIP         mean 0, max 0
non-finite   none

"#]],
    );
    let all = compare(&a, &b, &Compare { leave_out: Some(&[true; 400]), ..options }).unwrap();
    assert_eq!((all.psnr, all.flip.mean), (Psnr::Nothing, 0.0));
    let few = Compare { leave_out: Some(&[true]), ..options };
    assert_eq!(compare(&a, &b, &few), Err(PictureError::WrongMask { pixels: 400, marks: 1 }),);
}

#[test]
fn pictures_of_two_sizes_are_not_compared() {
    let (a, b) = (Picture::filled(4, 2, [0.0; 4]), Picture::filled(2, 4, [0.0; 4]));
    let said = compare(&a, &b, &Compare::default()).unwrap_err().to_string();
    golden().eq(
        &said,
        str!["one picture is 4 x 2 pixels and the other 2 x 4; render both at one size"],
    );
    let short = Picture { pixels: vec![[0.0; 4]; 7], ..a };
    assert_eq!(short.checked(), Err(PictureError::WrongCount { wanted: 8, given: 7 }));
    assert!(pfm::write(&short).is_err());
}

/// Pairs of pictures as people compare them, and noise.
fn pairs() -> Vec<(&'static str, Codes, Codes)> {
    let mut random = fastrand::Rng::with_seed(67);
    let make = |width: u32, height: u32, color: &mut dyn FnMut(f64, f64) -> [f64; 3]| {
        let pixels = (0..width * height)
            .map(|i| {
                let [r, g, b] = color(f64::from(i % width), f64::from(i / width))
                    .map(|part| (part.clamp(0.0, 1.0) * 255.0).round() as u8);
                [r, g, b, 255]
            })
            .collect();
        Codes { width, height, pixels, transfer: Some(Transfer::Srgb), non_finite: 0 }
    };
    let scene = |x: f64, y: f64| {
        let disc = if (x - 40.0).hypot(y - 30.0) < 17.0 { 0.9 } else { 0.2 };
        let checks = if (x as u32 / 8 + y as u32 / 8).is_multiple_of(2) { 0.6 } else { 0.35 };
        [disc, checks, (x * 0.1).sin() * 0.5 + 0.5]
    };
    let clean = make(97, 61, &mut |x, y| scene(x, y));
    let mut jitter = |by: f64| {
        make(97, 61, &mut |x, y| scene(x, y).map(|part| part + by * (random.f64() - 0.5)))
    };
    let (weak, strong) = (jitter(0.01), jitter(0.4));
    let moved = make(97, 61, &mut |x, y| scene(x + 1.0, y));
    let blurred = make(97, 61, &mut |x, y| {
        [0, 1, 2].map(|i| (scene(x - 1.0, y)[i] + scene(x, y)[i] + scene(x + 1.0, y)[i]) / 3.0)
    });
    let spot =
        make(97, 61, &mut |x, y| if x == 50.0 && y == 20.0 { [1.0; 3] } else { scene(x, y) });
    let mut noise = |width| make(width, 40, &mut |_, _| [random.f64(), random.f64(), random.f64()]);
    let (noise_a, noise_b, narrow_a, narrow_b) = (noise(50), noise(50), noise(3), noise(3));
    let green = make(30, 30, &mut |_, _| [0.0, 1.0, 0.0]);
    let blue = make(30, 30, &mut |_, _| [0.0, 0.0, 1.0]);
    vec![
        ("weak noise", clean.clone(), weak),
        ("strong noise", clean.clone(), strong),
        ("moved by a pixel", clean.clone(), moved),
        ("blurred", clean.clone(), blurred),
        ("one pixel", clean, spot),
        ("two noises", noise_a, noise_b),
        ("narrower than the filters", narrow_a, narrow_b),
        ("green and blue", green, blue),
    ]
}

#[test]
fn flip_is_that_of_the_published_program() {
    let theirs = |codes: &Codes| {
        let rgb: Vec<u8> = codes.pixels.iter().flat_map(|p| p[..3].iter().copied()).collect();
        nv_flip::FlipImageRgb8::with_data(codes.width, codes.height, &rgb)
    };
    for (name, a, b) in pairs() {
        for per_degree in [PIXELS_PER_DEGREE, 25.0] {
            let wanted = nv_flip::flip(theirs(&a), theirs(&b), per_degree as f32).to_vec();
            let map = flip(&a, &b, per_degree).unwrap();
            assert_eq!(map.errors.len(), wanted.len());
            let mean = |values: &[f32]| {
                values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64
            };
            let worst = map
                .errors
                .iter()
                .zip(&wanted)
                .map(|(ours, theirs)| (ours - theirs).abs())
                .fold(0.0, f32::max);
            let apart = (mean(&map.errors) - mean(&wanted)).abs();
            println!("{name} at {per_degree}: mean {:.6}, worst {worst:e}", mean(&wanted));
            // Theirs is in f32 throughout.
            assert!(worst < 5e-4 && apart < 1e-5, "{name} at {per_degree}: {worst:e} {apart:e}");
        }
        assert!(flip(&a, &a, PIXELS_PER_DEGREE).unwrap().errors.iter().all(|error| *error == 0.0));
    }
}

#[test]
fn one_step_in_a_hundredth_of_the_channels_is_hardly_visible() {
    let mut random = fastrand::Rng::with_seed(3);
    let a = Picture::filled(200, 200, [0.4, 0.4, 0.4, 1.0]);
    let mut b = a.clone();
    for channel in b.pixels.iter_mut().flat_map(|pixel| &mut pixel[..3]) {
        if random.f32() < 0.01 {
            *channel += 1.0 / 255.0;
        }
    }
    let options = Compare { transfer: Transfer::Linear, leave_out: None };
    let found = compare(&a, &b, &options).unwrap();
    assert_eq!(found.codes.max, 1);
    // 20 log10(255) + 20 = 68.13 dB for a hundredth of the channels.
    let Psnr::Db(db) = found.psnr else { panic!("{:?}", found.psnr) };
    assert!((db - 68.13).abs() < 0.5, "{db}");
    assert!((5e-4..5e-3).contains(&found.flip.mean), "{}", found.flip.mean);
}

#[test]
fn a_map_is_lighter_where_more_is_visible() {
    let light = |part: f64| {
        let [r, g, b] =
            color_map::color(part).map(|code| Transfer::Srgb.decode(f64::from(code) / 255.0));
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    for i in 0..100 {
        let (less, more) = (f64::from(i) / 100.0, f64::from(i + 1) / 100.0);
        assert!(light(less) < light(more), "{less}");
    }
    assert_eq!(color_map::color(f64::NAN), color_map::color(0.0));
    let map =
        landfall_light::picture::flip::FlipMap { width: 2, height: 1, errors: vec![0.0, 1.0] };
    let drawn = codes(&flip_picture(&map), Transfer::Srgb);
    assert_eq!(drawn.pixels, [[0, 0, 4, 255], [252, 253, 191, 255]]);
}

#[test]
fn a_difference_is_amplified_below_full_scale() {
    assert_eq!(amplification(0.0), 1.0);
    assert_eq!(amplification(0.9e-3), 100_000.0);
    assert_eq!(amplification(1.0), 100.0);
    assert_eq!(amplification(300.0), 1.0);
    let (a, b) = (Picture::filled(1, 1, [0.5; 4]), Picture::filled(1, 1, [0.25; 4]));
    assert_eq!(difference(&a, &b, 2.0).unwrap().pixels, [[0.5, 0.5, 0.5, 1.0]]);
}
