//! Four samples per pixel, and the number of shaded samples.

use crate::stage::{SIZE, drawn, gallery, mosaic, poster, view};
use enfilade::laws::OwnerPicture;
use enfilade::{Material, Method, View, Viewer};
use enfilade_draw::{Samples, Settings, Show, Stage};
use enfilade_scenes::built_in;

fn four() -> Settings {
    let mut settings = Settings::default();
    settings.samples = Samples::Four;
    settings
}

#[test]
fn an_edge_shows_as_much_of_a_face_as_its_four_samples_do() {
    let white = Material {
        unlit: true,
        double_sided: true,
        ..Material::opaque([1.0; 3])
    };
    let scene = gallery(Vec::new(), &[white]);
    let seen_at = |sample| {
        let view = view().at_sample(sample).expect("a position in the pixel");
        let mut picture = OwnerPicture::new(SIZE);
        Viewer::new().draw(&scene, &view, &mut picture);
        picture
    };
    let owners = View::FOUR_SAMPLES.map(seen_at);
    let image = drawn(&scene, &view(), &four()).image;
    let mut edges = 0;
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            let covered = owners.iter().filter(|of| of.owner([x, y]).is_some()).count();
            let white = image.get_pixel(x, y).0 == [255; 3];
            assert_eq!(white, covered == 4, "({x}, {y}): {covered} of 4");
            edges += usize::from((1..4).contains(&covered));
        }
    }
    assert!(edges > 200, "{edges} pixels with an edge");
}

#[test]
fn a_face_inside_is_shaded_once_for_each_pixel_however_many_samples_it_has() {
    let scene = gallery(vec![mosaic([4, 3])], &[poster()]);
    let [one, many] = [Settings::default(), four()].map(|settings| drawn(&scene, &view(), &settings));
    // Only pixels with an edge are shaded more than once.
    assert!(many.shaded > one.shaded, "{} and {}", many.shaded, one.shaded);
    assert!(
        4 * many.shaded < 5 * one.shaded,
        "{} and {}",
        many.shaded,
        one.shaded
    );
}

#[test]
fn four_samples_of_a_world_without_edges_are_as_one() {
    let scene = gallery(vec![mosaic([4, 3])], &[]);
    let [one, many] = [Settings::default(), four()].map(|settings| drawn(&scene, &view(), &settings));
    let off = |(a, b): (&u8, &u8)| a.abs_diff(*b);
    assert!(one.image.iter().zip(many.image.iter()).map(off).max() <= Some(1));
}

#[test]
fn what_shows_how_a_method_works_has_one_sample() {
    let scene = gallery(Vec::new(), &[Material::opaque([1.0; 3])]);
    for show in Show::ALL {
        if show == Show::Image {
            continue;
        }
        let mut settings = four();
        settings.show = show;
        let many = drawn(&scene, &view(), &settings).image;
        settings.samples = Samples::One;
        assert!(many == drawn(&scene, &view(), &settings).image, "{show:?}");
    }
}

#[test]
fn methods_that_know_the_owners_shade_each_sample_that_is_seen_once() {
    // The palace has visible alpha-tested and alpha-blended faces, which do not count as opaque samples.
    for name in ["enfilade", "mirrors", "two-rooms", "glass"] {
        let built = built_in(name).expect("a built-in scene");
        for method in [
            Method::SBuffer,
            Method::BspFront,
            Method::HierarchicalS,
            Method::ZBuffer,
        ] {
            let scene = built
                .scene
                .with_method(method, u64::MAX)
                .expect("within the memory limit");
            let stage = Stage::new(&scene);
            let view = built.cameras[0].view(SIZE).expect("a valid view");
            let mut owners = OwnerPicture::new(SIZE);
            Viewer::new().draw(&scene, &view, &mut owners);
            let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y]));
            let seen = pixels.filter(|&at| owners.owner(at).is_some()).count() as u64;
            let picture = stage.draw(&mut Viewer::new(), &scene, &view, &Settings::default());
            assert_eq!(picture.shaded, seen, "{method} on @{name}");
            assert!(seen > 0);
        }
    }
}
