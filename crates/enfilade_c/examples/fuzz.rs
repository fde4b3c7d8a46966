//! Calls every function with null, wrong and random arguments, and checks that it returns a code and stays sound.
//!
//! Run with `cargo run --release -p enfilade_c --example fuzz -- SECONDS SEED [THREADS]`. With one thread, a seed repeats a run.
//! Pointers that are not null point to as much as their count says: the library cannot detect others.
#![allow(unsafe_code, reason = "calls the functions as C does")]
#![allow(clippy::print_stdout, reason = "a driver prints what it counted")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "all pointers are null, or into arrays of the driver"
)]

use enfilade_c::*;
use fastrand::Rng;
use std::collections::HashSet;
use std::ffi::{CStr, c_char, c_void};
use std::ptr::{null, null_mut, without_provenance_mut};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Number of functions that are called.
pub(crate) const FUNCTIONS: usize = FUNCTION_COUNT;

/// What a run did.
#[derive(Clone, Debug, Default)]
pub(crate) struct Count {
    /// Calls of each function, by number.
    pub(crate) calls: Vec<u64>,
    /// Those of them that succeeded.
    pub(crate) succeeded: Vec<u64>,
    /// Calls that returned each status.
    pub(crate) statuses: Vec<u64>,
}

// The test of the driver has no use for it.
#[cfg(not(test))]
fn main() {
    let mut arguments = std::env::args()
        .skip(1)
        .map(|argument| argument.parse::<u64>().expect("a number"));
    let [seconds, seed] = [arguments.next().unwrap_or(10), arguments.next().unwrap_or(1)];
    let threads = arguments.next().unwrap_or(1);
    let handles = Mutex::new(Handles::default());
    let run = |number: u64| {
        fuzz(
            seed + number,
            Duration::from_secs(seconds),
            u64::MAX,
            &handles,
            threads > 1,
        )
    };
    let counts = std::thread::scope(|scope| {
        let started: Vec<_> = (0..threads)
            .map(|number| scope.spawn(move || run(number)))
            .collect();
        started
            .into_iter()
            .map(|thread| thread.join().expect("no panic"))
            .collect::<Vec<_>>()
    });
    for (number, count) in counts.iter().enumerate() {
        let calls: u64 = count.calls.iter().sum();
        let least = count.calls.iter().min().copied().unwrap_or(0);
        println!(
            "thread {number}: {calls} calls, at least {least} of each of {} functions",
            count.calls.len()
        );
        println!("  by status: {:?}", count.statuses);
        println!("  succeeded, by function: {:?}", count.succeeded);
    }
}

/// Handles that were created, and some that were freed.
#[derive(Default)]
pub(crate) struct Handles {
    all: [Vec<usize>; 6],
    /// Ids of all kinds.
    ids: Vec<u64>,
}

const MESH: usize = 0;
const SCENE: usize = 1;
const VIEWER: usize = 2;
const OCCLUDER: usize = 3;
const OCCLUSION: usize = 4;
const ROOMS: usize = 5;

/// Most objects of a kind at a time.
const MOST: usize = 6;

struct Fuzz<'a> {
    rng: Rng,
    handles: &'a Mutex<Handles>,
    error: EnfiladeError,
    /// Bytes for inputs, aligned to 8; random, but valid as what the functions read.
    words: Vec<u64>,
    results: Vec<u64>,
    is_shared: bool,
    removed: HashSet<u64>,
}

/// Calls functions until the time is over, or `most` were called.
pub(crate) fn fuzz(seed: u64, time: Duration, most: u64, handles: &Mutex<Handles>, is_shared: bool) -> Count {
    let start = Instant::now();
    let mut fuzz = Fuzz {
        rng: Rng::with_seed(seed),
        handles,
        error: unsafe { std::mem::zeroed() },
        words: vec![0; 1 << 13],
        results: vec![0; 1 << 16],
        is_shared,
        removed: HashSet::new(),
    };
    let mut count = Count {
        calls: vec![0; FUNCTIONS],
        succeeded: vec![0; FUNCTIONS],
        statuses: vec![0; 15],
    };
    while count.calls.iter().sum::<u64>() < most && start.elapsed() < time {
        // Now and then a world that is sound, so that the calls after it reach something.
        if fuzz.rng.u32(0..400) == 0 {
            fuzz.build();
        }
        let function = fuzz.rng.usize(0..FUNCTIONS);
        let status = fuzz.call(function) as usize;
        assert!(
            status < 13,
            "function {function} returned {status}: {:?}",
            fuzz.message()
        );
        count.calls[function] += 1;
        count.succeeded[function] += u64::from(status == 0);
        count.statuses[status] += 1;
        if function != 0 {
            fuzz.check(function, status);
        }
    }
    count
}

impl Fuzz<'_> {
    fn message(&self) -> String {
        let text = unsafe { CStr::from_ptr(self.error.message.as_ptr()) };
        text.to_string_lossy().into_owned()
    }

    /// Checks what the last call reported.
    fn check(&mut self, function: usize, status: usize) {
        if self.error.reserved == u32::MAX {
            // It was given no error to fill in.
            return;
        }
        assert_eq!(self.error.status as usize, status, "function {function}");
        assert!(self.error.message.contains(&0) && self.error.code.contains(&0));
        let is_empty = self.error.message[0] == 0;
        assert_eq!(is_empty, status == 0, "function {function}: {:?}", self.message());
    }

    fn one_in(&mut self, chance: u32) -> bool {
        self.rng.u32(0..chance) == 0
    }

    /// Returns null sometimes.
    fn error(&mut self) -> *mut EnfiladeError {
        self.error.status = EnfiladeStatus::Ok;
        self.error.reserved = u32::MAX;
        if self.one_in(20) {
            null_mut()
        } else {
            &raw mut self.error
        }
    }

    fn version(&mut self) -> u32 {
        if self.one_in(30) {
            self.rng.u32(..)
        } else {
            ENFILADE_VERSION
        }
    }

    /// Returns a handle: mostly one of its kind, else null, a freed one, one of another kind, or any number.
    fn handle<T>(&mut self, kind: usize) -> *mut T {
        let handles = self.handles.lock().expect("no panic");
        let kind = if self.rng.u32(0..25) == 0 {
            self.rng.usize(0..6)
        } else {
            kind
        };
        let known = &handles.all[kind];
        let number = match self.rng.u32(0..30) {
            0 => 0,
            1 => self.rng.usize(..),
            2 => 16 * self.rng.usize(0..200),
            _ if known.is_empty() => 0,
            _ => known[self.rng.usize(0..known.len())],
        };
        without_provenance_mut(number)
    }

    fn keep<T>(&mut self, kind: usize, handle: *mut T) {
        if handle.is_null() {
            return;
        }
        let mut handles = self.handles.lock().expect("no panic");
        handles.all[kind].push(handle.addr());
        let oldest = if handles.all[kind].len() > MOST {
            Some(handles.all[kind].remove(0))
        } else {
            None
        };
        drop(handles);
        if let Some(oldest) = oldest {
            self.free(kind, oldest);
        }
    }

    fn free(&mut self, kind: usize, number: usize) -> EnfiladeStatus {
        match kind {
            MESH => enfilade_mesh_free(without_provenance_mut(number)),
            SCENE => enfilade_scene_free(without_provenance_mut(number)),
            VIEWER => enfilade_viewer_free(without_provenance_mut(number)),
            OCCLUDER => enfilade_occluder_free(without_provenance_mut(number)),
            OCCLUSION => enfilade_occlusion_free(without_provenance_mut(number)),
            _ => enfilade_rooms_free(without_provenance_mut(number)),
        }
    }

    fn free_some(&mut self, kind: usize) -> EnfiladeStatus {
        let handle = self.handle::<c_void>(kind).addr();
        // Mostly others: objects should live for a while.
        if self.one_in(10) {
            let mut handles = self.handles.lock().expect("no panic");
            handles.all[kind].retain(|&number| number != handle);
            drop(handles);
            return self.free(kind, handle);
        }
        self.free(kind, handle | 1)
    }

    fn note_ids(&mut self, ids: &[u64]) {
        let mut handles = self.handles.lock().expect("no panic");
        for &id in ids.iter().filter(|&&id| id != 0) {
            if handles.ids.len() < 300 {
                handles.ids.push(id);
            } else {
                let place = self.rng.usize(0..300);
                handles.ids[place] = id;
            }
        }
    }

    /// Returns an id: of anything, also of what was removed.
    fn id(&mut self) -> u64 {
        let handles = self.handles.lock().expect("no panic");
        match self.rng.u32(0..30) {
            0 => 0,
            1 => self.rng.u64(..),
            2 if !handles.ids.is_empty() => {
                handles.ids[self.rng.usize(0..handles.ids.len())] ^ (1 << self.rng.u32(0..64))
            }
            _ if handles.ids.is_empty() => 0,
            _ => handles.ids[self.rng.usize(0..handles.ids.len())],
        }
    }

    /// Returns a sector of a scene, mostly.
    fn sector(&mut self, scene: *const EnfiladeScene) -> u64 {
        let mut ids = [0; 8];
        let mut count = 0;
        unsafe { enfilade_scene_sectors(scene, ids.as_mut_ptr(), 8, &mut count, null_mut()) };
        if count == 0 || self.one_in(8) {
            self.id()
        } else {
            ids[self.rng.usize(0..count.min(8))]
        }
    }

    fn item(&mut self, scene: *const EnfiladeScene) -> u64 {
        let mut ids = [0; 64];
        let mut count = 0;
        unsafe { enfilade_scene_items(scene, 0, ids.as_mut_ptr(), 64, &mut count, null_mut()) };
        if count == 0 || self.one_in(8) {
            self.id()
        } else {
            ids[self.rng.usize(0..count.min(64))]
        }
    }

    fn portal(&mut self, scene: *const EnfiladeScene) -> u64 {
        let mut portals: [EnfiladePortal; 8] = unsafe { std::mem::zeroed() };
        let mut count = 0;
        unsafe { enfilade_scene_portals(scene, 0, portals.as_mut_ptr(), 8, &mut count, null_mut()) };
        if count == 0 || self.one_in(8) {
            self.id()
        } else {
            portals[self.rng.usize(0..count.min(8))].portal
        }
    }

    /// Returns a room and a door, mostly of the rooms.
    fn room_and_door(&mut self, rooms: *const EnfiladeRooms) -> [u64; 2] {
        let mut doors: [EnfiladeDoor; 8] = unsafe { std::mem::zeroed() };
        let mut count = 0;
        unsafe { enfilade_rooms_doors(rooms, 0, doors.as_mut_ptr(), 8, &mut count, null_mut()) };
        if count == 0 || self.one_in(8) {
            return [self.id(), self.id()];
        }
        let door = doors[self.rng.usize(0..count.min(8))];
        [door.rooms[self.rng.usize(0..2)], door.door]
    }

    fn float(&mut self) -> f32 {
        match self.rng.u32(0..40) {
            0 => f32::NAN,
            1 => f32::INFINITY,
            2 => f32::NEG_INFINITY,
            3 => f32::from_bits(self.rng.u32(..)),
            4 => 0.0,
            5 => f32::MAX,
            6 => f32::MIN_POSITIVE,
            7 => 1e17 * (self.rng.f32() - 0.5),
            8..20 => self.rng.i32(-5..6) as f32,
            _ => 12.0 * (self.rng.f32() - 0.5),
        }
    }

    fn sound(&mut self) -> f32 {
        if self.one_in(3) {
            self.rng.i32(-5..6) as f32
        } else {
            12.0 * (self.rng.f32() - 0.5)
        }
    }

    fn number(&mut self, is_sound: bool) -> f32 {
        if is_sound { self.sound() } else { self.float() }
    }

    /// Fills the inputs with floats, and returns them.
    fn floats(&mut self) -> *const f32 {
        let is_sound = !self.one_in(4);
        for word in 0..512 {
            let [low, high] = [(); 2].map(|()| u64::from(self.number(is_sound).to_bits()));
            self.words[word] = low | high << 32;
        }
        let at = self.words.as_ptr().cast::<u8>();
        match self.rng.u32(0..30) {
            0 => null(),
            // Not aligned.
            1..4 => at.wrapping_add(self.rng.usize(1..8)).cast(),
            _ => at.cast(),
        }
    }

    fn doubles(&mut self) -> *const f64 {
        for word in 0..64 {
            self.words[word] = f64::from(self.float()).to_bits();
        }
        let at = self.words.as_ptr();
        match self.rng.u32(0..30) {
            0 => null(),
            1 => at.cast::<u8>().wrapping_add(3).cast(),
            _ => at.cast(),
        }
    }

    fn matrix(&mut self) -> [f32; 16] {
        let mut matrix = [0.0; 16];
        let is_sound = !self.one_in(10);
        for (number, value) in matrix.iter_mut().enumerate() {
            *value = match number {
                0 | 5 | 10 => {
                    if self.rng.bool() {
                        1.0
                    } else {
                        self.number(is_sound)
                    }
                }
                12..15 => self.number(is_sound),
                15 => 1.0,
                3 | 7 | 11 => 0.0,
                _ if self.rng.u32(0..6) == 0 => self.number(is_sound),
                _ => 0.0,
            };
        }
        if self.one_in(30) {
            matrix[self.rng.usize(0..16)] = self.float();
        }
        matrix
    }

    /// Fills the inputs with up to `count` matrices.
    fn matrices(&mut self, count: usize) -> *const f32 {
        let mut floats = Vec::new();
        for _ in 0..count {
            floats.extend(self.matrix());
        }
        for (word, pair) in self.words.iter_mut().zip(floats.chunks(2)) {
            *word = u64::from(pair[0].to_bits()) | u64::from(pair[1].to_bits()) << 32;
        }
        if self.one_in(30) {
            null()
        } else {
            self.words.as_ptr().cast()
        }
    }

    /// Returns a count of elements that are there, or one that cannot be.
    fn count(&mut self, there: usize) -> usize {
        match self.rng.u32(0..20) {
            0 => 0,
            1 => usize::MAX >> self.rng.u32(0..20),
            _ => self.rng.usize(0..=there),
        }
    }

    /// Returns a stride of elements of a size, of which there may be `most` bytes.
    fn stride(&mut self, size: usize) -> usize {
        match self.rng.u32(0..12) {
            0 => self.rng.usize(1..size),
            1 => size + self.rng.usize(0..16),
            2 => size,
            _ => 0,
        }
    }

    /// Returns an array for results, its capacity and where their number goes.
    fn results<T>(&mut self) -> (*mut T, usize, *mut usize) {
        let room = 8 * (self.results.len() - 1) / size_of::<T>();
        let capacity = match self.rng.u32(0..8) {
            0 => 0,
            1 => 1,
            2 => usize::MAX,
            _ => self.rng.usize(0..=room),
        };
        let last = self.results.len() - 1;
        let count: *mut usize = if self.one_in(20) {
            null_mut()
        } else {
            (&raw mut self.results[last]).cast()
        };
        let to = self.results.as_mut_ptr();
        let to = match self.rng.u32(0..8) {
            0 => null_mut(),
            _ => to.cast::<T>(),
        };
        (to, capacity, count)
    }

    fn out<T>(&mut self) -> *mut T {
        let to = self.results.as_mut_ptr().cast::<u8>();
        match self.rng.u32(0..24) {
            0 => null_mut(),
            1 => to.wrapping_add(1).cast(),
            _ => to.cast(),
        }
    }

    fn text(&mut self) -> *const c_char {
        const TEXTS: [&CStr; 5] = [
            c"room",
            c"door",
            c"",
            c"\xFF\xFE",
            c"K\xC3\xBCche mit einem sehr langen Namen, der nirgends hineinpasst, wo er stehen soll",
        ];
        if self.one_in(5) {
            null()
        } else {
            TEXTS[self.rng.usize(0..5)].as_ptr()
        }
    }

    fn flags(&mut self) -> u32 {
        if self.one_in(15) {
            self.rng.u32(..)
        } else {
            self.rng.u32(0..8) & self.rng.u32(0..8)
        }
    }

    fn view(&mut self, scene: *const EnfiladeScene) -> EnfiladeView {
        let mut view: EnfiladeView = unsafe { std::mem::zeroed() };
        let size = match self.rng.u32(0..60) {
            0 => [self.rng.u32(..), self.rng.u32(..)],
            1 => [16_384, 1],
            2 => [0, 7],
            _ => [self.rng.u32(1..200), self.rng.u32(1..120)],
        };
        if self.one_in(4) {
            for value in view.eye_from_sector.iter_mut().chain(&mut view.clip_from_eye) {
                *value = f64::from(self.float());
            }
            view.clip_depth = self.rng.u32(0..4);
            [view.width, view.height] = size;
            [view.left, view.top] = [self.rng.u32(..), self.rng.u32(..)];
        } else {
            let camera = self.camera();
            unsafe { enfilade_view_from_camera(&camera, size[0], size[1], &mut view, null_mut()) };
            if self.one_in(20) {
                view.clip_from_eye[self.rng.usize(0..16)] = f64::from(self.float());
            }
        }
        view.sector = if self.one_in(4) { self.sector(scene) } else { 0 };
        view
    }

    fn camera(&mut self) -> EnfiladeCamera {
        let mut camera: EnfiladeCamera = unsafe { std::mem::zeroed() };
        let is_sound = !self.one_in(6);
        for value in camera.eye.iter_mut().chain(&mut camera.target) {
            *value = f64::from(self.number(is_sound));
        }
        if self.one_in(4) {
            camera.up = [0, 1, 2].map(|_| f64::from(self.float()));
            camera.fov_y = self.float();
            camera.near_distance = self.float();
            camera.parallel_height = self.float();
        }
        camera.name = [-1; 64];
        camera
    }

    /// Returns a part whose arrays are in the inputs.
    fn part(&mut self) -> EnfiladeMeshPart {
        let positions = self.floats();
        let at = self.words.len() / 2;
        let size = [2, 4][self.rng.usize(0..2)];
        let highest = if self.one_in(8) { u32::MAX } else { 8 };
        for word in 0..64 {
            let index = |fuzz: &mut Self| u64::from(fuzz.rng.u32(0..highest));
            self.words[at + word] = if size == 2 {
                (0..4).fold(0, |all, _| all << 16 | index(self) & 0xFFFF)
            } else {
                index(self) << 32 | index(self)
            };
        }
        let indices = self.words[at..].as_ptr().cast::<c_void>();
        EnfiladeMeshPart {
            positions,
            position_count: if self.one_in(10) { self.count(20) } else { 12 },
            position_stride: self.stride(12),
            indices: match self.rng.u32(0..30) {
                0 => null(),
                1 => indices.cast::<u8>().wrapping_add(1).cast(),
                _ => indices,
            },
            index_count: if self.one_in(10) {
                self.count(100)
            } else {
                3 * self.rng.usize(0..20)
            },
            index_size: if self.one_in(30) { self.rng.u32(..) } else { size },
            material: if self.one_in(10) {
                self.rng.u32(..)
            } else {
                self.rng.u32(0..2)
            },
        }
    }

    fn item_options(&mut self) -> EnfiladeItemOptions {
        let mut options = EnfiladeItemOptions {
            flags: 0,
            layers: 0,
            max_distance: 0.0,
            min_size_px: 0.0,
        };
        if self.one_in(4) {
            options = EnfiladeItemOptions {
                flags: self.flags(),
                layers: self.rng.u32(..),
                max_distance: self.float(),
                min_size_px: self.float(),
            };
        }
        options
    }

    fn location(&mut self, scene: *const EnfiladeScene) -> EnfiladeLocation {
        let is_sound = !self.one_in(6);
        EnfiladeLocation {
            sector: self.sector(scene),
            position: [0, 1, 2].map(|_| self.number(is_sound)),
            reserved: 0,
        }
    }

    fn maybe<T>(&mut self, value: &T) -> *const T {
        if self.one_in(25) { null() } else { value }
    }

    /// Fills the inputs with an outline that is sound, or with anything.
    fn outline(&mut self) -> (*const f32, usize) {
        let at = self.floats();
        if self.one_in(4) {
            return (at, self.count(30));
        }
        let [x, z] = [self.sound(), self.sound()];
        let corners = [x, -1.0, z, x + 1.5, -1.0, z, x + 1.5, 1.5, z, x, 1.5, z];
        for (word, pair) in self.words.iter_mut().zip(corners.chunks(2)) {
            *word = u64::from(pair[0].to_bits()) | u64::from(pair[1].to_bits()) << 32;
        }
        (self.words.as_ptr().cast(), 4)
    }

    /// Builds a scene that is sound: two sectors with items, a door and a mirror, or a building of two rooms.
    fn build(&mut self) {
        let corner =
            |number: usize| [0, 1, 2].map(|axis| if number >> axis & 1 == 1 { 0.5_f32 } else { -0.5 });
        let corners: Vec<[f32; 3]> = (0..8).map(corner).collect();
        let indices: [u16; 36] = [
            0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5,
            7, 4, 7, 6,
        ];
        let part = EnfiladeMeshPart {
            positions: corners.as_ptr().cast(),
            position_count: 8,
            position_stride: 0,
            indices: indices.as_ptr().cast(),
            index_count: 36,
            index_size: 2,
            material: 0,
        };
        let (mut mesh, mut scene) = (null_mut(), null_mut());
        unsafe { enfilade_mesh_create(ENFILADE_VERSION, &part, 1, &mut mesh, null_mut()) };
        unsafe { enfilade_scene_create(ENFILADE_VERSION, &mut scene, null_mut()) };
        let materials: [EnfiladeMaterial; 3] = [0, 1, 2].map(|alpha| EnfiladeMaterial {
            color: [0.5; 4],
            alpha,
            double_sided: alpha,
            detail: 0,
        });
        let mut sectors = [0_u64; 2];
        for sector in &mut sectors {
            let method = if self.rng.bool() { 0 } else { self.rng.u32(0..14) };
            unsafe {
                enfilade_scene_add_sector(
                    scene,
                    c"room".as_ptr(),
                    method,
                    materials.as_ptr(),
                    3,
                    sector,
                    null_mut(),
                )
            };
        }
        let is_building = self.one_in(10);
        let boxes: Vec<[f32; 6]> = if is_building {
            HOUSE.to_vec()
        } else {
            let place = |_| {
                let [x, y, z] = [(); 3].map(|()| self.sound());
                let size = 0.1 + self.rng.f32();
                [x, y, z, x + size, y + 1.0, z + size]
            };
            (0..30).map(place).collect()
        };
        for (number, walls) in boxes.chunks(15).enumerate() {
            let items = walls.iter().zip(0..).map(|(&[x, y, z, to_x, to_y, to_z], key)| {
                let mut matrix = [0.0; 16];
                [matrix[0], matrix[5], matrix[10], matrix[15]] = [to_x - x, to_y - y, to_z - z, 1.0];
                [matrix[12], matrix[13], matrix[14]] = [0.5 * (x + to_x), 0.5 * (y + to_y), 0.5 * (z + to_z)];
                EnfiladeItem {
                    mesh,
                    key,
                    sector_from_item: matrix,
                    options: EnfiladeItemOptions {
                        flags: 0,
                        layers: 0,
                        max_distance: 0.0,
                        min_size_px: 0.0,
                    },
                    name: if key == 4 { c"door".as_ptr() } else { null() },
                }
            });
            let items: Vec<EnfiladeItem> = items.collect();
            let mut ids = vec![0; items.len()];
            unsafe {
                enfilade_scene_add_items(
                    scene,
                    sectors[number],
                    items.as_ptr(),
                    items.len(),
                    ids.as_mut_ptr(),
                    null_mut(),
                )
            };
            self.note_ids(&ids);
        }
        let [mut door, mut mirror] = [[0_u64; 2], [0; 2]];
        let opening = [-1.0_f32, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0];
        let aside = [4.0_f32, -1.0, 1.0, 4.0, -1.0, -1.0, 4.0, 1.0, -1.0, 4.0, 1.0, 1.0];
        let [a, b] = sectors;
        unsafe {
            enfilade_scene_add_door(scene, a, b, opening.as_ptr(), 0, 4, door.as_mut_ptr(), null_mut())
        };
        unsafe {
            enfilade_scene_add_portal(
                scene,
                a,
                aside.as_ptr(),
                0,
                4,
                a,
                null(),
                mirror.as_mut_ptr(),
                null_mut(),
            )
        };
        if is_building {
            let options = EnfiladeRoomOptions {
                metres_per_unit: 1.0,
                voxel: 0.1,
                max_voxels: 100_000,
                up: 2,
                ignores_sectors: 1,
            };
            let mut rooms = null_mut();
            unsafe { enfilade_rooms_find(ENFILADE_VERSION, scene, &options, &mut rooms, null_mut()) };
            self.keep(ROOMS, rooms);
        }
        self.keep(MESH, mesh);
        self.keep(SCENE, scene);
        self.note_ids(&sectors);
        self.note_ids(&door);
        self.note_ids(&mirror);
    }

    /// Calls a function with arguments of which some are wrong.
    fn call(&mut self, function: usize) -> EnfiladeStatus {
        let error = self.error();
        let version = self.version();
        let scene: *mut EnfiladeScene = self.handle(SCENE);
        let viewer: *mut EnfiladeViewer = self.handle(VIEWER);
        let occlusion: *mut EnfiladeOcclusion = self.handle(OCCLUSION);
        let rooms: *mut EnfiladeRooms = self.handle(ROOMS);
        unsafe {
            match function {
                0 => {
                    enfilade_version();
                    self.free_some(MESH)
                }
                1 => {
                    // Threads of its own would make the driver itself slow.
                    let count = if self.one_in(50) { self.rng.u32(1..4) } else { 1 };
                    let count = if self.one_in(4) {
                        257 + self.rng.u32(0..9)
                    } else {
                        count
                    };
                    enfilade_set_threads(count, error)
                }
                2 => {
                    let mut mesh = null_mut();
                    let part = self.part();
                    let parts = [part; 2];
                    let count = if self.one_in(20) {
                        usize::MAX / 3
                    } else {
                        self.rng.usize(0..3)
                    };
                    let to = if self.one_in(20) {
                        null_mut()
                    } else {
                        &raw mut mesh
                    };
                    let status = enfilade_mesh_create(version, self.maybe(&parts[0]), count, to, error);
                    self.keep(MESH, mesh);
                    status
                }
                3 => {
                    let mut mesh = null_mut();
                    let [low, high] = [self.floats(), self.floats()];
                    let high = if high.is_null() {
                        high
                    } else {
                        high.wrapping_byte_add(16)
                    };
                    let status = enfilade_mesh_create_box(version, low, high, &mut mesh, error);
                    self.keep(MESH, mesh);
                    status
                }
                4 => {
                    let mut scene = null_mut();
                    let to = if self.one_in(20) {
                        null_mut()
                    } else {
                        &raw mut scene
                    };
                    let status = enfilade_scene_create(version, to, error);
                    self.keep(SCENE, scene);
                    status
                }
                5 => {
                    let mut scene = null_mut();
                    let options = self.read_options();
                    let path = if self.rng.bool() {
                        self.text()
                    } else {
                        c"/".as_ptr()
                    };
                    enfilade_scene_read_file(version, path, self.maybe(&options), &mut scene, error)
                }
                6 => {
                    let mut scene = null_mut();
                    let options = self.read_options();
                    let mut bytes = GLTF.as_bytes().to_vec();
                    for _ in 0..self.rng.usize(0..3) {
                        let place = self.rng.usize(0..bytes.len());
                        bytes[place] = self.rng.u8(..);
                    }
                    let count = if self.one_in(20) {
                        self.rng.usize(0..=bytes.len())
                    } else {
                        bytes.len()
                    };
                    let options = self.maybe(&options);
                    let status = enfilade_scene_read_memory(
                        version,
                        bytes.as_ptr(),
                        count,
                        options,
                        &mut scene,
                        error,
                    );
                    self.keep(SCENE, scene);
                    status
                }
                7 => self.free_some(SCENE),
                8 => {
                    let materials: [EnfiladeMaterial; 3] = [0, 1, 2].map(|_| EnfiladeMaterial {
                        color: [0, 1, 2, 3].map(|_| if self.rng.bool() { 0.5 } else { self.float() }),
                        alpha: self.rng.u32(0..4),
                        double_sided: self.rng.u32(..),
                        detail: self.rng.u32(0..2),
                    });
                    let (name, method) = (self.text(), self.rng.u32(0..15));
                    let count = if self.one_in(20) {
                        usize::MAX
                    } else {
                        self.rng.usize(0..4)
                    };
                    let mut sector = 0;
                    let materials = self.maybe(&materials[0]);
                    let status =
                        enfilade_scene_add_sector(scene, name, method, materials, count, &mut sector, error);
                    self.note_ids(&[sector]);
                    status
                }
                9 => {
                    let sector = if self.one_in(4) {
                        self.sector(scene)
                    } else {
                        self.id()
                    };
                    enfilade_scene_remove_sector(scene, sector, error)
                }
                10 => {
                    let sector = self.sector(scene);
                    enfilade_scene_set_method(scene, sector, self.rng.u32(0..15), error)
                }
                11 => {
                    let (to, capacity, count) = self.results();
                    enfilade_scene_sectors(scene, to, capacity.min(100), count, error)
                }
                12 => {
                    let sector = self.sector(scene);
                    enfilade_scene_sector(scene, sector, self.out(), error)
                }
                13 => {
                    let (to, capacity, count) = self.results();
                    enfilade_scene_cameras(scene, to, capacity, count, error)
                }
                14 => {
                    let (to, capacity, count) = self.results();
                    enfilade_scene_warnings(scene, to, capacity, count, error)
                }
                15 | 16 => {
                    let sector = self.sector(scene);
                    let items: Vec<EnfiladeItem> = (0..self.rng.usize(1..20))
                        .map(|_| EnfiladeItem {
                            mesh: self.handle(MESH),
                            key: if self.one_in(20) {
                                self.rng.u64(..)
                            } else {
                                self.rng.u64(0..200)
                            },
                            sector_from_item: self.matrix(),
                            options: self.item_options(),
                            name: self.text(),
                        })
                        .collect();
                    let count = if self.one_in(30) {
                        usize::MAX / 2
                    } else {
                        items.len()
                    };
                    let mut ids = vec![7; items.len()];
                    let to = if self.one_in(30) {
                        null_mut()
                    } else {
                        ids.as_mut_ptr()
                    };
                    let from = self.maybe(&items[0]);
                    let from = if from.is_null() { from } else { items.as_ptr() };
                    let status = enfilade_scene_add_items(scene, sector, from, count, to, error);
                    ids.retain(|&id| id != 7);
                    self.note_ids(&ids);
                    status
                }
                17 => {
                    let ids: Vec<u64> = (0..self.rng.usize(1..4)).map(|_| self.item(scene)).collect();
                    let status = enfilade_scene_remove_items(scene, ids.as_ptr(), ids.len(), error);
                    if !self.is_shared && status == EnfiladeStatus::Ok {
                        self.removed.extend(&ids);
                    }
                    status
                }
                18 | 19 => {
                    let ids: Vec<u64> = (0..20).map(|_| self.item(scene)).collect();
                    let transforms = self.matrices(24);
                    let count = self.count(20);
                    let stride = self.stride(64);
                    let refused = if self.rng.bool() {
                        null_mut()
                    } else {
                        self.results.as_mut_ptr()
                    };
                    enfilade_scene_move_items(scene, ids.as_ptr(), count, transforms, stride, refused, error)
                }
                20 => {
                    let ids: Vec<u64> = (0..5).map(|_| self.item(scene)).collect();
                    let options: Vec<_> = (0..5).map(|_| self.item_options()).collect();
                    enfilade_scene_set_options(scene, ids.as_ptr(), self.count(5), options.as_ptr(), error)
                }
                21 => {
                    let ids: Vec<u64> = (0..5).map(|_| self.item(scene)).collect();
                    enfilade_scene_set_keys(scene, ids.as_ptr(), self.count(5), ids.as_ptr(), error)
                }
                22 => {
                    let item = self.item(scene);
                    enfilade_scene_set_mesh(scene, item, self.handle(MESH), error)
                }
                23 => {
                    let (item, sector) = (self.item(scene), self.sector(scene));
                    let transform = self.matrices(1);
                    enfilade_scene_transfer_item(scene, item, sector, transform, error)
                }
                24 => {
                    let sector = if self.rng.bool() { 0 } else { self.sector(scene) };
                    let (to, capacity, count) = self.results();
                    enfilade_scene_items(scene, sector, to, capacity, count, error)
                }
                25 => {
                    let item = if self.one_in(3) {
                        self.id()
                    } else {
                        self.item(scene)
                    };
                    let status = enfilade_scene_item(scene, item, self.out(), error);
                    let was_removed = self.removed.contains(&item);
                    assert!(
                        !was_removed || status != EnfiladeStatus::Ok,
                        "item {item} was removed"
                    );
                    status
                }
                26 => {
                    let [a, b] = [self.sector(scene), self.sector(scene)];
                    if self.portals_of(scene) > 6 {
                        return enfilade_scene_remove_portal(scene, self.portal(scene), error);
                    }
                    let (corners, count) = self.outline();
                    let stride = self.stride(12);
                    let mut portals = [0_u64; 2];
                    let to = if self.one_in(20) {
                        null_mut()
                    } else {
                        portals.as_mut_ptr()
                    };
                    let status = enfilade_scene_add_door(scene, a, b, corners, stride, count, to, error);
                    self.note_ids(&portals);
                    status
                }
                27 => {
                    let [from, to] = [self.sector(scene), self.sector(scene)];
                    if self.portals_of(scene) > 6 {
                        return enfilade_scene_remove_portal(scene, self.portal(scene), error);
                    }
                    let transform = self.matrix();
                    let transform = if self.one_in(3) {
                        null()
                    } else {
                        transform.as_ptr()
                    };
                    let (corners, count) = self.outline();
                    let stride = self.stride(12);
                    let mut portal = 0;
                    let out = if self.one_in(20) {
                        null_mut()
                    } else {
                        &raw mut portal
                    };
                    let status = enfilade_scene_add_portal(
                        scene, from, corners, stride, count, to, transform, out, error,
                    );
                    self.note_ids(&[portal]);
                    status
                }
                28 => enfilade_scene_remove_portal(scene, self.portal(scene), error),
                29 => {
                    let portal = self.portal(scene);
                    enfilade_scene_set_open(scene, portal, self.rng.u32(0..3), error)
                }
                30 => {
                    let sector = if self.rng.bool() { 0 } else { self.sector(scene) };
                    let (to, capacity, count) = self.results();
                    enfilade_scene_portals(scene, sector, to, capacity, count, error)
                }
                31 => {
                    let camera = self.camera();
                    let camera = self.maybe(&camera);
                    enfilade_view_from_camera(
                        camera,
                        self.rng.u32(0..17_000),
                        self.rng.u32(0..99),
                        self.out(),
                        error,
                    )
                }
                32 => {
                    let mut viewer = null_mut();
                    let options = self.viewer_options();
                    let to = if self.one_in(20) {
                        null_mut()
                    } else {
                        &raw mut viewer
                    };
                    let status = enfilade_viewer_create(version, &options, to, error);
                    self.keep(VIEWER, viewer);
                    status
                }
                33 => self.free_some(VIEWER),
                34 => {
                    let options = self.viewer_options();
                    enfilade_viewer_set_options(viewer, &options, error)
                }
                35..=38 => {
                    let view = self.view(scene);
                    let view = self.maybe(&view);
                    enfilade_viewer_look(viewer, scene, view, self.out(), error)
                }
                39 => {
                    let words = match self.rng.u32(0..20) {
                        0 => null_mut(),
                        1 => self.results.as_mut_ptr().cast::<u8>().wrapping_add(4).cast(),
                        _ => self.results.as_mut_ptr(),
                    };
                    enfilade_viewer_bits(viewer, words, self.count(8), error)
                }
                40 => {
                    let mut keys: EnfiladeKeys = std::mem::zeroed();
                    let status = enfilade_viewer_keys(viewer, &mut keys, error);
                    if status == EnfiladeStatus::Ok && !self.is_shared {
                        let visible = std::slice::from_raw_parts(keys.visible, keys.visible_count);
                        assert!(visible.is_sorted());
                        assert!(keys.entered_count <= keys.visible_count);
                    }
                    status
                }
                41 => {
                    let (to, capacity, count) = self.results();
                    enfilade_viewer_items(viewer, scene, to, capacity, count, error)
                }
                42 => {
                    let (to, capacity, count) = self.results();
                    enfilade_viewer_passages(viewer, scene, to, capacity, count, error)
                }
                43 => {
                    let view = self.view(scene);
                    let options = EnfiladeDrawOptions {
                        show: self.rng.u32(0..7),
                        samples: [0, 1, 4, 5][self.rng.usize(0..4)],
                        shadows: self.rng.u32(0..2),
                        ambient_rays: if self.one_in(8) { self.rng.u32(..) } else { 0 },
                        exposure: self.float(),
                    };
                    let options = EnfiladeDrawOptions {
                        ambient_rays: options.ambient_rays | u32::from(options.ambient_rays > 4) << 11,
                        ..options
                    };
                    let options = self.maybe(&options);
                    let row = if self.one_in(4) {
                        self.rng.usize(0..1000)
                    } else {
                        0
                    };
                    let bytes = self.count(8 * self.results.len());
                    enfilade_viewer_draw(
                        viewer,
                        scene,
                        &view,
                        options,
                        self.results.as_mut_ptr().cast(),
                        row,
                        bytes,
                        error,
                    )
                }
                44 => {
                    let point = self.doubles();
                    let target = if self.rng.bool() { null() } else { point };
                    enfilade_scene_locate(scene, point, target, self.out(), error)
                }
                45 => {
                    let from = self.location(scene);
                    let (from, direction) = (self.maybe(&from), self.floats());
                    enfilade_scene_cast_ray(scene, from, direction, self.out(), error)
                }
                46 => {
                    let [from, to] = [self.location(scene), self.location(scene)];
                    enfilade_scene_sees(scene, &from, self.maybe(&to), self.out(), error)
                }
                47 => {
                    let from = self.location(scene);
                    let from = self.maybe(&from);
                    let radius = self.float();
                    let (to, capacity, count) = self.results();
                    enfilade_scene_near(scene, from, radius, to, capacity, count, error)
                }
                48 => {
                    let mut location = self.location(scene);
                    let before = location;
                    let to = if self.one_in(20) {
                        null_mut()
                    } else {
                        &raw mut location
                    };
                    let status = enfilade_scene_walk(scene, to, self.floats(), self.out(), error);
                    assert!(status == EnfiladeStatus::Ok || location.sector == before.sector);
                    status
                }
                49 => {
                    let mut location = self.location(scene);
                    let mut capsule = EnfiladeCapsule {
                        radius: self.float(),
                        height: self.float(),
                        up: [0, 1, 2].map(|_| self.float()),
                        climb: if self.rng.bool() { 0.0 } else { self.float() },
                    };
                    if self.rng.bool() {
                        capsule = EnfiladeCapsule {
                            radius: 0.3,
                            height: 1.8,
                            up: [0.0, 1.0, 0.0],
                            climb: 0.2,
                        };
                    }
                    let step = self.floats();
                    let body = if self.one_in(20) {
                        null_mut()
                    } else {
                        &raw mut capsule
                    };
                    enfilade_scene_slide(scene, body, &mut location, step, self.out(), null_mut(), error)
                }
                50 => {
                    let mut occluder = null_mut();
                    let part = self.part();
                    let part = self.maybe(&part);
                    let status =
                        enfilade_occluder_create(version, part, self.rng.u32(0..2), &mut occluder, error);
                    self.keep(OCCLUDER, occluder);
                    status
                }
                51 => self.free_some(OCCLUDER),
                52 => {
                    let mut occlusion = null_mut();
                    let to = if self.one_in(20) {
                        null_mut()
                    } else {
                        &raw mut occlusion
                    };
                    let status = enfilade_occlusion_create(version, to, error);
                    self.keep(OCCLUSION, occlusion);
                    status
                }
                53 => self.free_some(OCCLUSION),
                54 => {
                    let view = self.view(null());
                    enfilade_occlusion_begin(occlusion, self.maybe(&view), error)
                }
                55 => {
                    let occluder: *mut EnfiladeOccluder = self.handle(OCCLUDER);
                    let (transforms, count) = (self.matrices(24), self.count(20));
                    enfilade_occlusion_draw(occlusion, occluder, transforms, self.stride(64), count, error)
                }
                56 => {
                    let (boxes, count) = (self.floats(), self.count(90));
                    let stride = self.stride(24);
                    let visible = match self.rng.u32(0..20) {
                        0 => null_mut(),
                        1 => self.results.as_mut_ptr().cast::<u8>().wrapping_add(4).cast(),
                        _ => self.results.as_mut_ptr(),
                    };
                    enfilade_occlusion_test_boxes(occlusion, boxes, stride, count, visible, error)
                }
                57 => {
                    let (to, capacity, count) = self.results();
                    enfilade_occlusion_depths(occlusion, to, capacity, count, error)
                }
                58 => {
                    let mut rooms = null_mut();
                    // Slow where it succeeds.
                    let scene = if self.one_in(10) { scene } else { null_mut() };
                    let options = EnfiladeRoomOptions {
                        metres_per_unit: if self.one_in(4) {
                            f64::from(self.float())
                        } else {
                            1.0
                        },
                        voxel: if self.one_in(4) {
                            f64::from(self.float())
                        } else {
                            0.5
                        },
                        max_voxels: self.rng.u64(1..3000),
                        up: self.rng.u32(0..5),
                        ignores_sectors: self.rng.u32(0..2),
                    };
                    let status = enfilade_rooms_find(version, scene, &options, &mut rooms, error);
                    self.keep(ROOMS, rooms);
                    status
                }
                59 => {
                    let mut read = null_mut();
                    let mut json = vec![0_u8; 1 << 16];
                    let mut count = 0;
                    enfilade_rooms_write(rooms, json.as_mut_ptr(), json.len(), &mut count, null_mut());
                    json.truncate(count);
                    if !json.is_empty() && self.rng.bool() {
                        let place = self.rng.usize(0..json.len());
                        json[place] = self.rng.u8(..);
                    }
                    let status = enfilade_rooms_read(version, json.as_ptr(), json.len(), &mut read, error);
                    self.keep(ROOMS, read);
                    status
                }
                60 => {
                    let (to, capacity, count) = self.results();
                    enfilade_rooms_write(rooms, to, capacity, count, error)
                }
                61 => self.free_some(ROOMS),
                62 => {
                    let (to, capacity, count) = self.results::<EnfiladeRoom>();
                    let status = enfilade_rooms_list(rooms, to, capacity, count, error);
                    if status == EnfiladeStatus::Ok && !to.is_null() && !count.is_null() {
                        let ids: Vec<u64> = (0..*count)
                            .map(|number| to.add(number).read_unaligned().room)
                            .collect();
                        self.note_ids(&ids);
                    }
                    status
                }
                63 => {
                    let room = if self.rng.bool() {
                        0
                    } else {
                        self.room_and_door(rooms)[0]
                    };
                    let (to, capacity, count) = self.results::<EnfiladeDoor>();
                    let status = enfilade_rooms_doors(rooms, room, to, capacity, count, error);
                    if status == EnfiladeStatus::Ok && !to.is_null() && !count.is_null() {
                        let ids: Vec<u64> = (0..*count)
                            .map(|number| to.add(number).read_unaligned().door)
                            .collect();
                        self.note_ids(&ids);
                    }
                    status
                }
                64 => {
                    let point = self.doubles();
                    enfilade_rooms_at(rooms, point, self.out(), error)
                }
                65 => {
                    let [_, door] = self.room_and_door(rooms);
                    enfilade_rooms_set_open(rooms, door, self.rng.u32(0..2), error)
                }
                66 => {
                    let (from, length) = (self.doubles(), self.out::<f64>());
                    // The length and the doors go to the same array.
                    let length = if length.is_null() { length } else { null_mut() };
                    let (to, capacity, count) = self.results();
                    let target = if from.is_null() {
                        from
                    } else {
                        from.wrapping_add(3)
                    };
                    enfilade_rooms_path(rooms, from, target, length, to, capacity, count, error)
                }
                67 => {
                    let from = self.doubles();
                    let source = if from.is_null() {
                        from
                    } else {
                        from.wrapping_add(3)
                    };
                    enfilade_rooms_heard(rooms, from, source, self.out(), error)
                }
                _ => {
                    let [room, _] = self.room_and_door(rooms);
                    let (to, capacity, count) = self.results();
                    enfilade_rooms_relevant(rooms, room, to, capacity, count, error)
                }
            }
        }
    }

    fn portals_of(&self, scene: *const EnfiladeScene) -> usize {
        let mut count = 0;
        unsafe { enfilade_scene_portals(scene, 0, null_mut(), 0, &mut count, null_mut()) };
        count
    }

    fn read_options(&mut self) -> EnfiladeReadOptions {
        EnfiladeReadOptions {
            flags: self.flags(),
            method: if self.rng.bool() { 0 } else { self.rng.u32(0..15) },
            limit_bytes: if self.one_in(4) {
                self.rng.u64(0..10_000)
            } else {
                0
            },
        }
    }

    fn viewer_options(&mut self) -> EnfiladeViewerOptions {
        let is_default = self.rng.bool();
        EnfiladeViewerOptions {
            flags: if is_default { 0 } else { self.flags() },
            layers: if is_default { 0 } else { self.rng.u32(..) },
            tightness: self.rng.u32(0..3) + u32::from(self.one_in(30)),
            max_crossings: if self.one_in(30) {
                self.rng.u32(..)
            } else {
                self.rng.u32(0..9)
            },
            max_passages: self.rng.u32(1..50),
            max_occluders: self.rng.u32(0..40),
            margin_px: if is_default { 0.0 } else { self.float() },
            growth_px: if self.rng.bool() { 0.0 } else { self.float() },
        }
    }
}

/// Number of branches of [`Fuzz::call`].
const FUNCTION_COUNT: usize = 69;

/// The walls of two rooms of 4 by 4 units with a doorway, in which a leaf is: lower and upper corners.
const HOUSE: [[f32; 6]; 10] = [
    [0.0, 0.0, -0.2, 8.2, 3.0, 0.0],
    [0.0, 0.0, 4.0, 8.2, 3.0, 4.2],
    [-0.2, 0.0, 0.0, 0.0, 3.0, 4.0],
    [8.2, 0.0, 0.0, 8.4, 3.0, 4.0],
    [4.05, 0.0, 1.5, 4.1, 2.0, 2.5],
    [4.0, 0.0, 0.0, 4.2, 3.0, 1.5],
    [4.0, 0.0, 2.5, 4.2, 3.0, 4.0],
    [4.0, 2.0, 1.5, 4.2, 3.0, 2.5],
    [-0.2, -0.2, -0.2, 8.4, 0.0, 4.2],
    [-0.2, 3.0, -0.2, 8.4, 3.2, 4.2],
];

/// Two triangles in a room.
const GLTF: &str = r#"{
    "asset": { "version": "2.0" },
    "scenes": [{ "nodes": [0, 2] }],
    "nodes": [{ "name": "Hall-room", "children": [1] }, { "name": "Leaf", "mesh": 0, "translation": [0, 0, -2] },
        { "name": "Eye", "camera": 0 }],
    "cameras": [{ "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.1 } }],
    "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
    "accessors": [{ "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3 }],
    "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
    "buffers": [{ "byteLength": 36, "uri":
        "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }]
}"#;
