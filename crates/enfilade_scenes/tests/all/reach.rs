//! Light reach and sight lines through portals, compared with an exhaustive search over all chains of portals.

use enfilade::laws::{chains, goes_straight};
use enfilade::{Light, Limits, Location, PortalId, Ray, RayEnd, Scene, SectorId, Transform};
use enfilade_scenes::{BuiltIn, built_in};
use glam::Vec3;

const SCENES: [&str; 6] = ["two-rooms", "mirror", "free-doorway", "slits", "pillar", "glass"];
const MAX_CROSSED: usize = 3;

fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_crossings = MAX_CROSSED as u16;
    limits
}

/// Returns a grid of points in a sector's bounds.
fn points(scene: &Scene, sector: SectorId, per_side: u32) -> Vec<[f32; 3]> {
    let bounds = scene.bounds(sector);
    let along = |axis: usize, i: u32| {
        let part = (i as f32 + 0.37) / per_side as f32;
        bounds.min[axis] + (bounds.max[axis] - bounds.min[axis]) * part
    };
    let count = per_side * per_side * per_side;
    let point = |n| {
        let [x, y, z] = [n % per_side, n / per_side % per_side, n / per_side / per_side];
        [along(0, x), along(1, y), along(2, z)]
    };
    (0..count).map(point).collect()
}

#[test]
fn a_beam_holds_what_a_straight_line_through_the_same_openings_leads_to() {
    let (mut held, mut beyond) = (0, 0);
    for name in SCENES {
        let BuiltIn { scene, cameras } = built_in(name).expect("a built-in scene");
        for camera in &cameras {
            let sector = scene
                .locate(camera.eye, camera.toward)
                .expect("a camera inside a sector");
            let from = Location {
                sector,
                position: camera.eye,
            };
            let beams = scene.reach(from, 1e6, &limits());
            let chain_of = |mut number: usize| {
                let mut chain = Vec::new();
                while let Some(portal) = beams[number].portal {
                    chain.insert(0, portal);
                    number = beams[number].parent.expect("a portal has a parent") as usize;
                }
                chain
            };
            for (chain, to) in chains(&scene, sector, MAX_CROSSED) {
                let beam = (0..beams.len()).find(|&number| chain_of(number) == chain);
                for point in points(&scene, to, 5) {
                    let Some(expected) = goes_straight(&scene, from, &chain, point.map(f64::from)) else {
                        continue;
                    };
                    let holds = beam.is_some_and(|number| beams[number].holds(point.map(f64::from)));
                    assert_eq!(
                        holds, expected,
                        "@{name} from `{}` by {chain:?} to {point:?}",
                        camera.name
                    );
                    held += usize::from(expected);
                    beyond += usize::from(expected && !chain.is_empty());
                }
            }
        }
    }
    assert!(held > 1000 && beyond > 100, "{held}, {beyond} through portals");
}

#[test]
fn one_place_sees_another_where_no_face_is_on_the_straight_line_between() {
    let (mut seen, mut through) = (0, 0);
    for name in SCENES {
        let BuiltIn { scene, cameras } = built_in(name).expect("a built-in scene");
        let camera = &cameras[0];
        let sector = scene
            .locate(camera.eye, camera.toward)
            .expect("a camera inside a sector");
        let from = Location {
            sector,
            position: camera.eye,
        };
        for to in scene.sectors() {
            for point in points(&scene, to, 4) {
                let chains = chains(&scene, sector, MAX_CROSSED)
                    .into_iter()
                    .filter(|(_, end)| *end == to);
                let answers: Vec<_> = chains
                    .map(|(chain, _)| {
                        goes_straight(&scene, from, &chain, point.map(f64::from))
                            .map(|straight| straight && is_free(&scene, camera.eye, sector, &chain, point))
                    })
                    .collect();
                let expected = answers.contains(&Some(true));
                if !expected && answers.contains(&None) {
                    continue;
                }
                let place = Location {
                    sector: to,
                    position: point,
                };
                let line = scene.sees(from, place).filter(|line| line.crossed.len() <= 3);
                assert_eq!(line.is_some(), expected, "@{name}: {place:?}");
                seen += usize::from(expected);
                through += usize::from(line.is_some_and(|line| !line.crossed.is_empty()));
            }
        }
    }
    assert!(seen > 100 && through > 10, "{seen}, {through} through portals");
}

/// Returns `true` if no face is on a straight line that passes through a given chain of portals.
fn is_free(scene: &Scene, from: [f32; 3], sector: SectorId, chain: &[PortalId], to: [f32; 3]) -> bool {
    let back = chain.iter().rev().fold(Transform::IDENTITY, |sum, id| {
        let portal = &scene.portals()[id.0 as usize];
        portal.there_from_here.inverse().expect("an invertible transform") * sum
    });
    let target = Vec3::from(back.point(to));
    let ray = Ray {
        origin: from,
        direction: (target - Vec3::from(from)).into(),
    };
    let cast = scene.cast(sector, &ray);
    assert!(cast.distance < 0.999 || cast.end == RayEnd::Nothing || cast.crossed.starts_with(chain));
    cast.distance >= 0.9999
}

#[test]
fn a_lamp_reaches_no_farther_than_its_range() {
    let BuiltIn { scene, cameras } = built_in("two-rooms").expect("a built-in scene");
    let sector = scene
        .locate(cameras[0].eye, cameras[0].toward)
        .expect("a camera inside a sector");
    let portal = scene
        .portals()
        .iter()
        .find(|portal| portal.from == sector)
        .expect("a door");
    let outline = &scene.sector(sector).openings()[usize::from(portal.opening.0)].outline;
    let [middle, normal] = [outline.bounds().center(), outline.normal()];
    let place = Location {
        sector,
        position: std::array::from_fn(|axis| middle[axis] + 1.5 * normal[axis]),
    };
    assert_eq!(scene.reach(place, 1.4, &limits()).len(), 1);
    assert_eq!(scene.reach(place, 1.6, &limits()).len(), 2);
}

#[test]
fn light_fades_to_nothing_at_its_range_and_stays_finite_at_the_lamp() {
    let lamp = Light::point(SectorId(0), [0.0; 3], [1.0; 3], 10.0);
    assert!((lamp.falloff(1.0) - (1.0 - 1e-4)).abs() < 1e-12);
    assert_eq!([lamp.falloff(10.0), lamp.falloff(11.0)], [0.0; 2]);
    assert!(lamp.falloff(0.0).is_finite());
    assert!(lamp.falloff(2.0) > lamp.falloff(3.0));
}

#[test]
fn what_is_behind_a_door_is_near_by_the_way_through_it_and_not_when_it_is_closed() {
    let BuiltIn { mut scene, .. } = built_in("two-rooms").expect("a built-in scene");
    let ids: Vec<PortalId> = (0..scene.portals().len() as u32).map(PortalId).collect();
    let [here, there] = [scene.portals()[0].from, scene.portals()[0].to];
    // Beside the door, close to its wall: the path to the box beyond bends at the post.
    let place = Location {
        sector: here,
        position: [-0.6, 1.0, -2.0],
    };
    let named = |scene: &Scene, sector: SectorId, name: &str| {
        let geometry = scene.geometry(sector).expect("a sector with geometry");
        let mut items = (0..geometry.items().len() as u32).map(enfilade::ItemIndex);
        let item = items
            .find(|&item| geometry.name(item) == name)
            .expect("an existing item");
        (item, geometry.item(item).bounds)
    };
    let (left_box, bounds) = named(&scene, there, "left box");
    let all = scene.near(place, 20.0).items;
    assert!(all.windows(2).all(|pair| pair[0].distance <= pair[1].distance));
    let found = all
        .iter()
        .find(|near| near.sector == there && near.item == left_box.into())
        .expect("a path within range");
    assert_eq!(found.crossed.len(), 1);
    let nearest: Vec3 = Vec3::from(place.position)
        .max(bounds.min.into())
        .min(bounds.max.into());
    let straight = f64::from(nearest.distance(place.position.into()));
    // Around the post at z = −0.5, level with the eye: two straight lines, because the wall has no thickness.
    let post = Vec3::new(0.0, 1.0, -0.5);
    let corner = Vec3::new(bounds.min[0], 1.0, bounds.max[2]).min(bounds.max.into());
    let round = f64::from(post.distance(place.position.into()) + post.distance(corner));
    assert!(
        found.distance > straight + 0.1,
        "{} through the wall is {straight}",
        found.distance
    );
    assert!(
        (found.distance - round).abs() < 0.02,
        "{} is not {round}",
        found.distance
    );
    let within = |radius: f64| {
        let near = scene.near(place, radius as f32).items;
        near.iter()
            .any(|near| near.sector == there && near.item == left_box.into())
    };
    assert!(within(found.distance + 1e-3) && !within(found.distance - 1e-3));
    ids.iter().for_each(|&id| scene.set_open(id, false));
    let near = scene.near(place, 20.0).items;
    assert!(
        !near.is_empty()
            && near
                .iter()
                .all(|near| near.sector == here && near.crossed.is_empty())
    );
}
