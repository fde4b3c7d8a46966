//! The interface finds what the libraries find, starts no thread, and allocates nothing in a look.
#![allow(unsafe_code, reason = "calls the functions as C does")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "all pointers are to values of the tests"
)]

use enfilade::{Camera, Method, SectorId, View, Viewer, VisibleKeys};
use enfilade_c::*;
use enfilade_import::{Import, ReadOptions, read_bytes};
use rayon::ThreadPoolBuilder;
use std::ffi::CStr;
use std::ptr::{null, null_mut};

const PALACE: &[u8] = include_bytes!("../../enfilade_scenes/src/palace.glb");

/// Returns the result of a call that must succeed: `call` is given where it goes, and the error.
fn made<T>(call: impl FnOnce(*mut T, *mut EnfiladeError) -> EnfiladeStatus) -> T {
    let mut result = std::mem::MaybeUninit::<T>::zeroed();
    let mut error = std::mem::MaybeUninit::<EnfiladeError>::zeroed();
    let status = call(result.as_mut_ptr(), error.as_mut_ptr());
    let error = unsafe { error.assume_init() };
    let message = unsafe { CStr::from_ptr(error.message.as_ptr()) };
    assert_eq!(status, EnfiladeStatus::Ok, "{message:?}");
    unsafe { result.assume_init() }
}

fn palace() -> *mut EnfiladeScene {
    made(|scene, error| unsafe {
        enfilade_scene_read_memory(
            ENFILADE_VERSION,
            PALACE.as_ptr(),
            PALACE.len(),
            null(),
            scene,
            error,
        )
    })
}

/// Reads the palace without the interface, which has made the global pool of rayon one thread of its callers.
fn read_in_rust() -> Import {
    let pool = ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
    let read = || read_bytes(PALACE, None, &ReadOptions::default());
    pool.install(read).expect("the palace")
}

fn viewer() -> *mut EnfiladeViewer {
    made(|viewer, error| unsafe { enfilade_viewer_create(ENFILADE_VERSION, null(), viewer, error) })
}

fn cameras(scene: *const EnfiladeScene) -> Vec<EnfiladeCamera> {
    let count: usize =
        made(|count, error| unsafe { enfilade_scene_cameras(scene, null_mut(), 0, count, error) });
    let mut cameras: Vec<EnfiladeCamera> = (0..count).map(|_| unsafe { std::mem::zeroed() }).collect();
    let again: usize = made(|again, error| unsafe {
        enfilade_scene_cameras(scene, cameras.as_mut_ptr(), count, again, error)
    });
    assert_eq!(again, count);
    cameras
}

fn view(camera: &EnfiladeCamera, size: [u32; 2]) -> EnfiladeView {
    made(|view, error| unsafe { enfilade_view_from_camera(camera, size[0], size[1], view, error) })
}

fn keys(viewer: *mut EnfiladeViewer) -> Vec<u64> {
    let keys: EnfiladeKeys = made(|keys, error| unsafe { enfilade_viewer_keys(viewer, keys, error) });
    unsafe { std::slice::from_raw_parts(keys.visible, keys.visible_count) }.to_vec()
}

#[test]
fn looks_find_what_they_find_in_rust() {
    let import = read_in_rust();
    let mut scene = import
        .scene(Method::Masked, Method::DEFAULT_LIMIT)
        .expect("a scene");
    // The interface numbers the items of a file.
    let items: Vec<_> = scene
        .sectors()
        .flat_map(|sector| {
            let geometry = scene.geometry(sector).expect("no custom sector");
            let indices = (0..geometry.items().len() as u32).map(enfilade::ItemIndex);
            indices
                .map(|index| (sector, geometry.id_of(index)))
                .collect::<Vec<_>>()
        })
        .collect();
    let mut edit = scene.edit();
    for (&(sector, item), key) in items.iter().zip(0..) {
        edit.set_key(sector, item, key).expect("an item");
    }
    edit.finish().expect("an edit");
    let (own, own_viewer) = (palace(), viewer());
    let (mut rust_viewer, mut rust_keys) = (Viewer::new(), VisibleKeys::default());
    let mut looked = 0;
    for (camera, own_camera) in import.cameras.iter().zip(cameras(own)) {
        for size in [[320, 200], [641, 359]] {
            let expected = camera.view(size).expect("a view");
            rust_keys.update(rust_viewer.look(&scene, &expected));
            let view = view(&own_camera, size);
            let look: EnfiladeLook =
                made(|look, error| unsafe { enfilade_viewer_look(own_viewer, own, &view, look, error) });
            assert_eq!(look.item_count, rust_viewer.visible().items().len());
            assert_eq!(look.passage_count, rust_viewer.visible().passages().len());
            assert_eq!(keys(own_viewer), rust_keys.all());
            let mut bits = vec![0_u64; items.len().div_ceil(64)];
            let status =
                unsafe { enfilade_viewer_bits(own_viewer, bits.as_mut_ptr(), bits.len(), null_mut()) };
            assert_eq!(status, EnfiladeStatus::Ok);
            let set =
                (0..64 * bits.len() as u64).filter(|key| bits[*key as usize / 64] >> (key % 64) & 1 == 1);
            assert_eq!(set.collect::<Vec<_>>(), rust_keys.all());
            looked += look.item_count;
        }
    }
    assert!(looked > 100, "only {looked} items were visible");
    assert_eq!(enfilade_scene_free(own), EnfiladeStatus::Ok);
    assert_eq!(enfilade_viewer_free(own_viewer), EnfiladeStatus::Ok);
}

#[test]
fn a_parallel_camera_looks_as_in_rust() {
    let own = palace();
    let import = read_in_rust();
    let scene = import
        .scene(Method::Masked, Method::DEFAULT_LIMIT)
        .expect("a scene");
    let bounds = scene.bounds(SectorId(0));
    let middle = [0, 1, 2].map(|axis| f64::from(bounds.min[axis] + bounds.max[axis]) * 0.5);
    let [x, y, z] = middle;
    let eye = [x, y + 0.1, z];
    let expected = View::parallel(eye, [x, y - 1.0, z], [0.0, 0.0, -1.0], 20.0, [300, 200]).expect("a view");
    let mut camera: EnfiladeCamera = unsafe { std::mem::zeroed() };
    (camera.eye, camera.target, camera.up) = (eye, [x, y - 1.0, z], [0.0, 0.0, -1.0]);
    camera.parallel_height = 20.0;
    let view = view(&camera, [300, 200]);
    let viewer = viewer();
    let look: EnfiladeLook =
        made(|look, error| unsafe { enfilade_viewer_look(viewer, own, &view, look, error) });
    let mut rust = Viewer::new();
    let set = rust.look(&scene, &expected);
    assert!(look.item_count > 0);
    assert_eq!(look.item_count, set.items().len());
    enfilade_scene_free(own);
    enfilade_viewer_free(viewer);
}

#[test]
fn looks_and_moves_allocate_nothing_once_buffers_have_grown() {
    let options = EnfiladeReadOptions {
        flags: EnfiladeReadFlags::Flat as u32,
        method: 0,
        limit_bytes: 0,
    };
    let scene: *mut EnfiladeScene = made(|scene, error| unsafe {
        enfilade_scene_read_memory(
            ENFILADE_VERSION,
            PALACE.as_ptr(),
            PALACE.len(),
            &options,
            scene,
            error,
        )
    });
    let viewer = viewer();
    let views: Vec<EnfiladeView> = cameras(scene)
        .iter()
        .map(|camera| view(camera, [320, 200]))
        .collect();
    let mut ids = [0_u64; 40];
    let mut count = 0;
    let listed = unsafe { enfilade_scene_items(scene, 0, ids.as_mut_ptr(), 40, &mut count, null_mut()) };
    assert_eq!(listed, EnfiladeStatus::BufferTooSmall);
    let transform = |&id: &u64| {
        let info: EnfiladeItemInfo =
            made(|info, error| unsafe { enfilade_scene_item(scene, id, info, error) });
        info.sector_from_item
    };
    let transforms: Vec<[f32; 16]> = ids.iter().map(transform).collect();
    let mut bits = vec![0_u64; count.div_ceil(64)];
    let mut error: EnfiladeError = unsafe { std::mem::zeroed() };
    let mut frame = |view: &EnfiladeView| unsafe {
        let from = transforms.as_ptr().cast();
        let moved = enfilade_scene_move_items(scene, ids.as_ptr(), 40, from, 0, null_mut(), &mut error);
        let looked = enfilade_viewer_look(viewer, scene, view, null_mut(), &mut error);
        let read = enfilade_viewer_bits(viewer, bits.as_mut_ptr(), bits.len(), &mut error);
        let mut keys: EnfiladeKeys = std::mem::zeroed();
        let listed = enfilade_viewer_keys(viewer, &mut keys, &mut error);
        assert_eq!([moved, looked, read, listed], [EnfiladeStatus::Ok; 4]);
        assert!(keys.visible_count > 0);
    };
    views.iter().cycle().take(3 * views.len()).for_each(&mut frame);
    let allocations: Vec<u64> = views
        .iter()
        .map(|view| allocation_counter::measure(|| frame(view)).count_total)
        .collect();
    assert!(allocations.iter().all(|&count| count == 0), "{allocations:?}");
    enfilade_scene_free(scene);
    enfilade_viewer_free(viewer);
}

#[test]
fn looks_through_portals_allocate_no_more_than_in_rust() {
    let import = read_in_rust();
    let rust_scene = import
        .scene(Method::Masked, Method::DEFAULT_LIMIT)
        .expect("a scene");
    let (scene, viewer) = (palace(), viewer());
    let mut rust_viewer = Viewer::new();
    rust_viewer.options.parallel = false;
    for turn in 0..3 {
        for (camera, own) in import.cameras.iter().zip(cameras(scene)) {
            let (rust_view, view) = (camera.view([320, 200]).expect("a view"), view(&own, [320, 200]));
            let in_rust = allocation_counter::measure(|| {
                rust_viewer.look(&rust_scene, &rust_view);
            });
            let here = allocation_counter::measure(|| {
                unsafe { enfilade_viewer_look(viewer, scene, &view, null_mut(), null_mut()) };
            });
            assert!(
                turn < 2 || here.count_total <= in_rust.count_total,
                "{} allocations, {} in Rust",
                here.count_total,
                in_rust.count_total
            );
        }
    }
    enfilade_scene_free(scene);
    enfilade_viewer_free(viewer);
}

/// Of a process of its own: other tests have threads. Linux counts them in a folder.
#[cfg(target_os = "linux")]
#[test]
fn no_thread_is_started() {
    const CHILD: &str = "ENFILADE_C_COUNTS_THREADS";
    if std::env::var_os(CHILD).is_none() {
        let program = std::env::current_exe().expect("a program");
        let output = std::process::Command::new(program)
            .args(["--exact", "no_thread_is_started", "--test-threads", "1"])
            .env(CHILD, "1")
            .output()
            .expect("it runs");
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stdout)
        );
        return;
    }
    let threads = || std::fs::read_dir("/proc/self/task").expect("a folder").count();
    let before = threads();
    let (scene, viewer) = (palace(), viewer());
    let view = view(&cameras(scene)[0], [64, 40]);
    let mut rgba = vec![0_u8; 64 * 40 * 4];
    for method in [0, 3] {
        let mut sectors = [0_u64; 64];
        let mut count = 0;
        unsafe { enfilade_scene_sectors(scene, sectors.as_mut_ptr(), 64, &mut count, null_mut()) };
        unsafe { enfilade_scene_set_method(scene, sectors[0], method, null_mut()) };
        let (to, bytes) = (rgba.as_mut_ptr(), rgba.len());
        let drawn = unsafe { enfilade_viewer_draw(viewer, scene, &view, null(), to, 0, bytes, null_mut()) };
        assert_eq!(drawn, EnfiladeStatus::Ok);
    }
    // Nor by calls from other threads; those that draw, read and find rooms use rayon by themselves.
    let [scene_number, viewer_number] = [scene.addr(), viewer.addr()];
    std::thread::spawn(move || {
        let scene = std::ptr::without_provenance_mut(scene_number);
        let viewer = std::ptr::without_provenance_mut(viewer_number);
        let looked = unsafe { enfilade_viewer_look(viewer, scene, &view, null_mut(), null_mut()) };
        let (to, bytes) = (rgba.as_mut_ptr(), rgba.len());
        let drawn = unsafe { enfilade_viewer_draw(viewer, scene, &view, null(), to, 0, bytes, null_mut()) };
        assert_eq!([looked, drawn], [EnfiladeStatus::Ok; 2]);
        assert_eq!(enfilade_scene_free(palace()), EnfiladeStatus::Ok);
    })
    .join()
    .expect("no panic");
    let options = EnfiladeRoomOptions {
        metres_per_unit: 1.0,
        voxel: 0.5,
        max_voxels: 100_000,
        up: 2,
        ignores_sectors: 0,
    };
    let rooms: *mut EnfiladeRooms =
        made(|rooms, error| unsafe { enfilade_rooms_find(ENFILADE_VERSION, scene, &options, rooms, error) });
    assert_eq!(threads(), before, "the library started a thread");
    unsafe { enfilade_set_threads(2, null_mut()) };
    assert!(threads() > before, "it was asked for threads");
    enfilade_rooms_free(rooms);
    enfilade_scene_free(scene);
    enfilade_viewer_free(viewer);
}

#[test]
fn a_camera_of_a_file_has_its_name_and_sector() {
    let scene = palace();
    let import = read_in_rust();
    for (camera, own) in import.cameras.iter().zip(cameras(scene)) {
        let Camera { name, eye, .. } = camera;
        let own_name = unsafe { CStr::from_ptr(own.name.as_ptr()) };
        assert_eq!(
            (own_name.to_string_lossy().as_ref(), own.eye),
            (name.as_str(), *eye)
        );
    }
    enfilade_scene_free(scene);
}

#[test]
fn before_the_first_look_nothing_is_known_to_be_hidden() {
    let viewer = viewer();
    let mut words = [0; 3];
    let status = unsafe { enfilade_viewer_bits(viewer, words.as_mut_ptr(), words.len(), null_mut()) };
    assert_eq!((status, words), (EnfiladeStatus::Ok, [u64::MAX; 3]));
    let scene = palace();
    let mut view = view(&cameras(scene)[0], [64, 36]);
    view.reserved = 9;
    let look =
        |view: &EnfiladeView| unsafe { enfilade_viewer_look(viewer, scene, view, null_mut(), null_mut()) };
    assert_eq!(
        look(&view),
        EnfiladeStatus::BadArgument,
        "a later version may use the field"
    );
    view.reserved = 0;
    assert_eq!(look(&view), EnfiladeStatus::Ok);
    let columns = view.clip_from_eye;
    for (place, value) in view.clip_from_eye.iter_mut().enumerate() {
        *value = columns[4 * (place % 4) + place / 4];
    }
    assert_eq!(look(&view), EnfiladeStatus::BadView, "it is transposed");
    assert_eq!(enfilade_viewer_free(viewer), EnfiladeStatus::Ok);
    assert_eq!(enfilade_scene_free(scene), EnfiladeStatus::Ok);
}
