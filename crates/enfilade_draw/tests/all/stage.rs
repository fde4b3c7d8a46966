//! Small textured scenes, and ray casts into them.

use enfilade::{
    Attributes, GeometryBuilder, Indices, Material, MaterialId, Mesh, Method, Part, Ray, Scene, SceneBuilder,
    SectorId, Texture, TextureId, Transform, Vertices, View, Viewer, Wrap,
};
use enfilade_draw::{Picture, Settings, Stage};
use glam::{DMat3, DVec3};
use std::sync::Arc;

pub(crate) const SIZE: [u32; 2] = [120, 80];

/// Creates a texture with 12 different texels, unfiltered.
pub(crate) fn mosaic(size: [u32; 2]) -> Texture {
    let texel = |i: u32| {
        [
            (40 * i % 256) as u8,
            (93 * i + 20) as u8,
            (i * i % 200) as u8,
            255,
        ]
    };
    let mut texture = Texture::new("mosaic", size, (0..size[0] * size[1]).map(texel).collect())
        .expect("one texel per pixel");
    texture.magnify = enfilade::Filter::Nearest;
    texture.minify = enfilade::Minify {
        texels: enfilade::Filter::Nearest,
        levels: None,
    };
    texture
}

/// Creates a sheet of two triangles from (0, 0, 0) to (2, 1, 0), with non-rectangular texture coordinates.
pub(crate) fn sheet(material: MaterialId) -> Mesh {
    Mesh::new(&[Part {
        positions: Vertices::Packed(&[[0.0; 3], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]]),
        corners: Indices::U32(&[0, 1, 2, 0, 2, 3]),
        sides: None,
        material,
        attributes: Attributes {
            texture: Vertices::Packed(&[[-0.4, 1.2], [2.3, 0.9], [2.1, -0.7], [-0.2, -1.1]]),
            ..Attributes::default()
        },
    }])
    .expect("a sheet")
}

/// Creates several sheets, rotated, scaled and mirrored, and a mirror that reflects them.
pub(crate) fn gallery(textures: Vec<Texture>, materials: &[Material]) -> Scene {
    let mut geometry = GeometryBuilder::new(materials.to_vec());
    geometry.textures(textures.into_iter().map(Arc::new).collect::<Vec<_>>());
    let kinds: Vec<_> = (0..materials.len() as u32)
        .map(|material| geometry.mesh(sheet(MaterialId(material))))
        .collect();
    let places = [
        Transform::translation([-1.5, -0.5, -2.0]) * Transform::rotation([0.0, 1.0, 0.0], 0.6),
        Transform::translation([0.2, -0.4, -3.0]) * Transform::rotation([1.0, 0.3, 0.1], -1.1),
        Transform::translation([1.0, 0.3, -1.7])
            * Transform::from_columns([[-0.8, 0.0, 0.1], [0.0, 0.7, 0.0], [0.3, 0.0, 1.0], [0.0; 3]]),
        Transform::translation([-1.0, -0.9, 0.6]) * Transform::rotation([1.0, 0.0, 0.0], -1.5),
    ];
    for (number, place) in places.into_iter().enumerate().filter(|_| !kinds.is_empty()) {
        geometry.item(&format!("sheet {number}"), kinds[number % kinds.len()], place);
    }
    let glass = enfilade::ConvexPolygon::rectangle([-2.0, -1.0, -3.6], [4.0, 0.0, 0.4], [0.0, 2.0, 0.0])
        .expect("a mirror");
    let mirror = geometry.opening("mirror", glass);
    let mut scene = SceneBuilder::new();
    let hall = scene.add("hall", geometry.build().expect("a hall"), Method::ZBuffer);
    scene.mirror(hall, mirror);
    scene.build().expect("a gallery")
}

pub(crate) fn view() -> View {
    View::new([0.1, 0.2, 2.0], [0.0, -0.1, -2.0], SIZE).expect("a valid view")
}

/// As [`view`], in parallel.
pub(crate) fn parallel_view() -> View {
    View::parallel([0.1, 0.2, 2.0], [0.0, -0.1, -2.0], [0.1, 1.0, 0.0], 3.0, SIZE).expect("a valid view")
}

pub(crate) fn drawn(scene: &Scene, view: &View, settings: &Settings) -> Picture {
    Stage::new(scene).draw(&mut Viewer::new(), scene, view, settings)
}

/// An unlit, two-sided material with the first texture.
pub(crate) fn poster() -> Material {
    Material {
        texture: Some(TextureId(0)),
        unlit: true,
        double_sided: true,
        ..Material::opaque([1.0; 3])
    }
}

/// The surface that the ray through a pixel's centre meets, with interpolated vertex attributes.
pub(crate) struct RayHit {
    pub(crate) place: [f64; 2],
    pub(crate) face: (SectorId, u32, u32),
}

/// Returns origin and direction of the ray through a screen position.
pub(crate) fn ray(view: &View, [x, y]: [f64; 2]) -> [DVec3; 2] {
    let [eye, toward, up] = [view.eye(), view.toward(), view.up()].map(DVec3::from);
    let forward = (toward - eye).normalize();
    let right = forward.cross(up).normalize();
    let step = if view.is_parallel() {
        2.0 / (view.clip_from_eye()[1][1] * f64::from(view.size()[1]))
    } else {
        2.0 * (0.5 * f64::from(view.fov_y())).tan() / f64::from(view.size()[1])
    };
    let [dx, dy] = View::GENERIC_OFFSET;
    let [right_of, below] = [
        x + dx - 0.5 * f64::from(view.size()[0]),
        y + dy - 0.5 * f64::from(view.size()[1]),
    ];
    let aside = right * (right_of * step) - right.cross(forward) * (below * step);
    if view.is_parallel() {
        [eye + aside, forward]
    } else {
        [eye, forward + aside]
    }
}

pub(crate) fn meet(scene: &Scene, view: &View, at: [f64; 2]) -> Option<RayHit> {
    let [origin, direction] = ray(view, at);
    let sector = scene.sector_of(view)?;
    let ray = Ray {
        origin: origin.as_vec3().into(),
        direction: direction.as_vec3().into(),
    };
    let cast = scene.cast(sector, &ray);
    let enfilade::RayEnd::Face(hit) = cast.end else {
        return None;
    };
    let moved = |p: DVec3| {
        let columns = cast
            .there_from_here
            .columns()
            .map(|c| DVec3::from(c.map(f64::from)));
        columns[0] * p.x + columns[1] * p.y + columns[2] * p.z + columns[3]
    };
    let point = moved(origin + direction * cast.distance);
    let geometry = scene.geometry(cast.sector)?;
    let mesh = geometry.mesh_of(hit.item.index);
    let corners = mesh.face(hit.face);
    let item = geometry.item(hit.item.index).transform();
    let place = |i: usize| {
        let [x, y, z] = mesh.positions()[corners[i] as usize].map(f64::from);
        let columns = item.columns().map(|c| DVec3::from(c.map(f64::from)));
        columns[0] * x + columns[1] * y + columns[2] * z + columns[3]
    };
    let [a, b, c] = [place(0), place(1), place(2)];
    let normal = (b - a).cross(c - a);
    let weights = DMat3::from_cols(b - a, c - a, normal).inverse() * (point - a);
    let carried = [0, 1, 2].map(|i| mesh.texture()[corners[i] as usize].map(f64::from));
    let [second, third] = [weights.x, weights.y];
    Some(RayHit {
        place: [0, 1].map(|axis| {
            carried[0][axis] * (1.0 - second - third) + carried[1][axis] * second + carried[2][axis] * third
        }),
        face: (cast.sector, hit.item.index.0, hit.face),
    })
}

/// Returns the texel at texture coordinates, or `None` within 0.01 texels of another texel.
pub(crate) fn texel(texture: &Texture, [u, v]: [f64; 2]) -> Option<[u8; 4]> {
    let [width, height] = texture.size();
    let mut found = [0; 2];
    for (axis, (place, side)) in [(u, width), (v, height)].into_iter().enumerate() {
        let at = place * f64::from(side);
        if (at - at.round()).abs() < 0.01 {
            return None;
        }
        let side = i64::from(side);
        let at = at.floor() as i64;
        found[axis] = match texture.wrap[axis] {
            Wrap::Repeat => at.rem_euclid(side),
            Wrap::Clamp => at.clamp(0, side - 1),
            Wrap::Mirror if at.div_euclid(side) % 2 == 0 => at.rem_euclid(side),
            Wrap::Mirror => side - 1 - at.rem_euclid(side),
        };
    }
    Some(texture.texels()[(found[1] * i64::from(width) + found[0]) as usize])
}
