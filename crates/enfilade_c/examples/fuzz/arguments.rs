//! Random arguments, of which some are wrong.

use super::*;

impl Fuzz<'_> {
    pub(super) fn version(&mut self) -> u32 {
        if self.one_in(30) {
            self.rng.u32(..)
        } else {
            ENFILADE_VERSION
        }
    }

    /// Returns a handle: mostly one of its kind, else null, a freed one, one of another kind, or any number.
    pub(super) fn handle<T>(&mut self, kind: usize) -> *mut T {
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

    pub(super) fn keep<T>(&mut self, kind: usize, handle: *mut T) {
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

    pub(super) fn free(&mut self, kind: usize, number: usize) -> EnfiladeStatus {
        match kind {
            MESH => enfilade_mesh_free(without_provenance_mut(number)),
            SCENE => enfilade_scene_free(without_provenance_mut(number)),
            VIEWER => enfilade_viewer_free(without_provenance_mut(number)),
            OCCLUDER => enfilade_occluder_free(without_provenance_mut(number)),
            OCCLUSION => enfilade_occlusion_free(without_provenance_mut(number)),
            _ => enfilade_rooms_free(without_provenance_mut(number)),
        }
    }

    pub(super) fn free_some(&mut self, kind: usize) -> EnfiladeStatus {
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

    pub(super) fn note_ids(&mut self, ids: &[u64]) {
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
    pub(super) fn id(&mut self) -> u64 {
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
    pub(super) fn sector(&mut self, scene: *const EnfiladeScene) -> u64 {
        let mut ids = [0; 8];
        let mut count = 0;
        unsafe { enfilade_scene_sectors(scene, ids.as_mut_ptr(), 8, &mut count, null_mut()) };
        if count == 0 || self.one_in(8) {
            self.id()
        } else {
            ids[self.rng.usize(0..count.min(8))]
        }
    }

    pub(super) fn item(&mut self, scene: *const EnfiladeScene) -> u64 {
        let mut ids = [0; 64];
        let mut count = 0;
        unsafe { enfilade_scene_items(scene, 0, ids.as_mut_ptr(), 64, &mut count, null_mut()) };
        if count == 0 || self.one_in(8) {
            self.id()
        } else {
            ids[self.rng.usize(0..count.min(64))]
        }
    }

    pub(super) fn portal(&mut self, scene: *const EnfiladeScene) -> u64 {
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
    pub(super) fn room_and_door(&mut self, rooms: *const EnfiladeRooms) -> [u64; 2] {
        let mut doors: [EnfiladeDoor; 8] = unsafe { std::mem::zeroed() };
        let mut count = 0;
        unsafe { enfilade_rooms_doors(rooms, 0, doors.as_mut_ptr(), 8, &mut count, null_mut()) };
        if count == 0 || self.one_in(8) {
            return [self.id(), self.id()];
        }
        let door = doors[self.rng.usize(0..count.min(8))];
        [door.rooms[self.rng.usize(0..2)], door.door]
    }

    pub(super) fn float(&mut self) -> f32 {
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

    pub(super) fn sound(&mut self) -> f32 {
        if self.one_in(3) {
            self.rng.i32(-5..6) as f32
        } else {
            12.0 * (self.rng.f32() - 0.5)
        }
    }

    pub(super) fn number(&mut self, is_sound: bool) -> f32 {
        if is_sound { self.sound() } else { self.float() }
    }

    /// Fills the inputs with floats, and returns them.
    pub(super) fn floats(&mut self) -> *const f32 {
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

    pub(super) fn doubles(&mut self) -> *const f64 {
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

    pub(super) fn matrix(&mut self) -> [f32; 16] {
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
    pub(super) fn matrices(&mut self, count: usize) -> *const f32 {
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
    pub(super) fn count(&mut self, there: usize) -> usize {
        match self.rng.u32(0..20) {
            0 => 0,
            1 => usize::MAX >> self.rng.u32(0..20),
            _ => self.rng.usize(0..=there),
        }
    }

    /// Returns a stride of elements of a size, of which there may be `most` bytes.
    pub(super) fn stride(&mut self, size: usize) -> usize {
        match self.rng.u32(0..12) {
            0 => self.rng.usize(1..size),
            1 => size + self.rng.usize(0..16),
            2 => size,
            _ => 0,
        }
    }

    /// Returns an array for results, its capacity and where their number goes.
    pub(super) fn results<T>(&mut self) -> (*mut T, usize, *mut usize) {
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

    pub(super) fn out<T>(&mut self) -> *mut T {
        let to = self.results.as_mut_ptr().cast::<u8>();
        match self.rng.u32(0..24) {
            0 => null_mut(),
            1 => to.wrapping_add(1).cast(),
            _ => to.cast(),
        }
    }

    pub(super) fn text(&mut self) -> *const c_char {
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

    pub(super) fn flags(&mut self) -> u32 {
        if self.one_in(15) {
            self.rng.u32(..)
        } else {
            self.rng.u32(0..8) & self.rng.u32(0..8)
        }
    }

    pub(super) fn view(&mut self, scene: *const EnfiladeScene) -> EnfiladeView {
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

    pub(super) fn camera(&mut self) -> EnfiladeCamera {
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
    pub(super) fn part(&mut self) -> EnfiladeMeshPart {
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

    pub(super) fn item_options(&mut self) -> EnfiladeItemOptions {
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

    pub(super) fn location(&mut self, scene: *const EnfiladeScene) -> EnfiladeLocation {
        let is_sound = !self.one_in(6);
        EnfiladeLocation {
            sector: self.sector(scene),
            position: [0, 1, 2].map(|_| self.number(is_sound)),
            reserved: 0,
        }
    }

    pub(super) fn maybe<T>(&mut self, value: &T) -> *const T {
        if self.one_in(25) { null() } else { value }
    }

    /// Fills the inputs with an outline that is sound, or with anything.
    pub(super) fn outline(&mut self) -> (*const f32, usize) {
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

    pub(super) fn portals_of(&self, scene: *const EnfiladeScene) -> usize {
        let mut count = 0;
        unsafe { enfilade_scene_portals(scene, 0, null_mut(), 0, &mut count, null_mut()) };
        count
    }

    pub(super) fn read_options(&mut self) -> EnfiladeReadOptions {
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

    pub(super) fn viewer_options(&mut self) -> EnfiladeViewerOptions {
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
