//! Textures on faces, texel by texel.

use crate::stage::{SIZE, drawn, gallery, meet, mosaic, parallel_view, poster, texel, view};
use enfilade::{Alpha, Contract, Material, Method, View, Wrap};
use enfilade_draw::Settings;

#[test]
fn every_texel_is_where_a_ray_meets_it_also_beyond_the_sides_and_in_a_mirror() {
    every_texel_is_where_a_ray_meets_it(&view());
}

#[test]
fn every_texel_of_a_parallel_view_is_where_a_ray_meets_it() {
    every_texel_is_where_a_ray_meets_it(&parallel_view());
}

fn every_texel_is_where_a_ray_meets_it(view: &View) {
    for wrap in [
        [Wrap::Repeat, Wrap::Mirror],
        [Wrap::Mirror, Wrap::Clamp],
        [Wrap::Clamp, Wrap::Repeat],
    ] {
        let mut texture = mosaic([4, 3]);
        texture.wrap = wrap;
        let scene = gallery(vec![texture.clone()], &[poster()]);
        for method in Method::ALL
            .into_iter()
            .filter(|method| method.requires().is_none())
        {
            if method.contract() == Contract::Approximate {
                continue;
            }
            let scene = scene
                .with_method(method, u64::MAX)
                .expect("within the memory limit");
            let image = drawn(&scene, view, &Settings::default()).image;
            let mut compared = 0;
            for y in 0..SIZE[1] {
                for x in 0..SIZE[0] {
                    let at = [f64::from(x) + 0.5, f64::from(y) + 0.5];
                    let Some(met) = meet(&scene, view, at) else {
                        continue;
                    };
                    // At the edges of faces either colour is accepted.
                    let beside = [[-0.05, 0.0], [0.05, 0.0], [0.0, -0.05], [0.0, 0.05]];
                    let same = beside.iter().all(|[dx, dy]| {
                        meet(&scene, view, [at[0] + dx, at[1] + dy])
                            .is_some_and(|other| other.face == met.face)
                    });
                    let Some(expected) = texel(&texture, met.place).filter(|_| same) else {
                        continue;
                    };
                    let shown = image.get_pixel(x, y).0;
                    let off = (0..3).map(|i| shown[i].abs_diff(expected[i])).max();
                    assert!(off <= Some(1), "{method} at ({x}, {y}): {shown:?}, {expected:?}");
                    compared += 1;
                }
            }
            assert!(compared > 2000, "{method}: only {compared} samples");
        }
    }
}

#[test]
fn a_cut_out_is_seen_through_where_its_texture_says_and_nowhere_else() {
    let mut texture = mosaic([4, 3]);
    let holes = |(i, [r, g, b, _]): (usize, &[u8; 4])| [*r, *g, *b, if i % 2 == 0 { 100 } else { 160 }];
    let texels = texture.texels().iter().enumerate().map(holes).collect();
    let mut holed = enfilade::Texture::new("holed", [4, 3], texels).expect("one texel per pixel");
    (holed.magnify, holed.minify) = (texture.magnify, texture.minify);
    texture = holed;
    let cut_out = |cutoff| Material {
        alpha: Alpha::Mask,
        cutoff,
        ..poster()
    };
    let painted = |material: Material| {
        let scene = gallery(vec![texture.clone()], &[material]);
        let lonely = gallery(vec![texture.clone()], &[]);
        let [image, sky] = [&scene, &lonely].map(|scene| drawn(scene, &view(), &Settings::default()).image);
        image.pixels().zip(sky.pixels()).filter(|(a, b)| a != b).count()
    };
    let [all, half, none] = [0.2, 0.5, 0.9].map(|cutoff| painted(cut_out(cutoff)));
    assert_eq!(none, 0);
    assert!(
        all > 2000 && half > all / 3 && half < 3 * all / 4,
        "{half} of {all}"
    );
    assert_eq!(
        painted(poster()),
        all,
        "opaque: what its texture says of coverage has no say"
    );
}

#[test]
fn what_lies_far_off_is_even_and_does_not_flicker() {
    let checks = |levels| {
        let texel = |i: u32| {
            if (i + i / 64).is_multiple_of(2) {
                [255; 4]
            } else {
                [0, 0, 0, 255]
            }
        };
        let mut texture =
            enfilade::Texture::new("checks", [64, 64], (0..4096).map(texel).collect()).expect("texels");
        texture.minify.levels = levels;
        let scene = gallery(vec![texture], &[poster()]);
        let mut image = Vec::new();
        for step in 0..2 {
            let [x, y, z] = view().eye();
            let view = enfilade::View::new([x + 0.013 * f64::from(step), y, z], view().toward(), SIZE);
            let view = view.expect("a valid view");
            image.push(drawn(&scene, &view, &Settings::default()).image);
        }
        let change = |(a, b): (&u8, &u8)| u64::from(a.abs_diff(*b));
        image[0].iter().zip(image[1].iter()).map(change).sum::<u64>()
    };
    let [even, flickering] = [Some(enfilade::Filter::Linear), None].map(checks);
    assert!(4 * even < flickering, "{even} against {flickering}");
}
