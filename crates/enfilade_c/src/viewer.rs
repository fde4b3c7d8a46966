//! Viewers: look, and read what is visible.

use crate::handle::{self, Handle};
use crate::ids::{EnfiladeItemId, EnfiladePortalId, EnfiladeSectorId};
use crate::lent::Caller;
use crate::scene::{EnfiladeScene, SceneState, check_flags};
use crate::status::{EnfiladeError, EnfiladeStatus, Failure, border, refuse};
use crate::threads;
use crate::version::check_version;
use crate::view::EnfiladeView;
use enfilade::{Contract, Limits, Method, Tightness, View, Viewer, ViewerOptions, VisibleKeys};
use enfilade_draw::{Exposure, Samples, Settings, Show, Stage};

/// What one camera sees. Keep one for each camera: it keeps its buffers and what it saw, which makes the next look cheaper and
/// never changes it. Use it by one thread at a time.
pub struct EnfiladeViewer {
    _opaque: (),
}

impl Handle for EnfiladeViewer {
    type Object = ViewerState;
    const NAME: &'static str = "viewer";
}

pub(crate) struct ViewerState {
    viewer: Viewer,
    uses_threads: bool,
    keys: VisibleKeys,
    /// Whether the keys are those of the last look.
    keys_are_known: bool,
    has_looked: bool,
}

/// Flags of EnfiladeViewerOptions.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnfiladeViewerFlags {
    /// Looks use the threads of enfilade_set_threads.
    UsesThreads = 1,
    /// Do not test first what was visible before. Changes the speed only.
    NoCoherence = 2,
    /// Nothing hides anything: cull by the frustum and by portals alone.
    NoOcclusion = 4,
}

/// How closely ENFILADE_METHOD_MASKED tests what it found once more, when all occluders are known.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnfiladeTightness {
    /// By boxes.
    Boxes = 0,
    /// By faces: fewer hidden items, slower.
    Faces = 1,
    /// By faces at exact depths: fewest hidden items, slowest.
    Resolved = 2,
}

/// How a viewer looks. All zero is a good default.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeViewerOptions {
    /// EnfiladeViewerFlags, or 0.
    pub flags: u32,
    /// The layers to look at, one bit each; 0 for all.
    pub layers: u32,
    /// An EnfiladeTightness.
    pub tightness: u32,
    /// Most portals in a row that are followed, up to 65535; 0 for 64.
    pub max_crossings: u32,
    /// Most passages of a look; 0 for 65536.
    pub max_passages: u32,
    /// Most occluders per passage, for methods that select occluders; 0 for a number that suits the method.
    pub max_occluders: u32,
    /// How far the renderer may move vertices, 0 to 0.5 pixels; expensive, and proven. Mostly 0.
    pub margin_px: f32,
    /// How far tested boxes grow, 0 to 8 pixels; cheap. 1 for multisampling, and for GPUs that snap vertices.
    pub growth_px: f32,
}

/// Guarantee of a look.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnfiladeContract {
    /// Visible items may be missing.
    Approximate = 0,
    /// No item is missing that is visible at a sample of the view; hidden ones may be there.
    Conservative = 1,
    /// As conservative, for any sample positions and resolutions.
    Strict = 2,
    /// Exactly the items that are visible at a sample of the view.
    Exact = 3,
}

/// What a look found, in numbers.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeLook {
    /// Number of visible items; one that is visible through two passages counts twice.
    pub item_count: usize,
    /// Number of passages.
    pub passage_count: usize,
    /// An EnfiladeContract: that of all passages.
    pub contract: u32,
    /// 1, or 0 if items may be missing because a limit of EnfiladeViewerOptions ended the look, or the scene has no sector.
    pub is_complete: u32,
}

/// A visible item.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeVisibleItem {
    /// Its key.
    pub key: u64,
    /// Its id; 0 for a block of terrain that is read from its file on demand, and for an item that was removed since the look.
    pub item: EnfiladeItemId,
    /// The passage that it is visible through: an index among those of enfilade_viewer_passages.
    pub passage: u32,
    /// Longer side of its rectangle on the screen, in pixels.
    pub size_px: u32,
    /// 1 if visible parts are alpha-blended, else 0.
    pub blends: u32,
    /// Always 0.
    pub reserved: u32,
}

/// A passage: a chain of portals from the eye into a sector. Draw the items of each passage with its matrix, scissor and plane.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladePassage {
    /// The view-projection matrix, from the space of the sector to clip space: 16 doubles, column after column.
    pub clip_from_sector: [f64; 16],
    /// Only points with ax + by + cz + d >= 0 are visible: the plane of the last opening, in the space of the sector. All zero if
    /// there is none.
    pub clip_plane: [f64; 4],
    /// The sector at its end.
    pub sector: EnfiladeSectorId,
    /// The last portal; 0 for the sector of the eye.
    pub portal: EnfiladePortalId,
    /// Scissor rectangle in pixels of the render target, y down: left, top, width, height.
    pub scissor: [u32; 4],
    /// Index of the passage one portal nearer to the eye; UINT32_MAX for none.
    pub parent: u32,
    /// Number of portals.
    pub crossings: u32,
}

/// The keys of visible items, each once, ascending, and how they changed. The arrays belong to the viewer, and are valid until its
/// next look, draw or end.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeKeys {
    /// Keys that are visible.
    pub visible: *const u64,
    /// Their number.
    pub visible_count: usize,
    /// Keys that became visible since the last enfilade_viewer_keys.
    pub entered: *const u64,
    /// Their number.
    pub entered_count: usize,
    /// Keys that are no longer visible since the last enfilade_viewer_keys.
    pub left: *const u64,
    /// Their number.
    pub left_count: usize,
}

/// What enfilade_viewer_draw shows.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnfiladeShow {
    /// The picture.
    Image = 0,
    /// Each item in a colour of its own.
    Items = 1,
    /// Each sector in a colour of its own.
    Sectors = 2,
    /// The order in which the method reached items.
    Order = 3,
    /// How often samples were painted.
    Overdraw = 4,
    /// The occlusion buffer.
    Cover = 5,
}

/// How enfilade_viewer_draw draws. All zero is a good default.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeDrawOptions {
    /// An EnfiladeShow.
    pub show: u32,
    /// Samples per pixel: 1 (or 0), or 4.
    pub samples: u32,
    /// 1 if lights cast shadows, else 0.
    pub shadows: u32,
    /// Rays per pixel for ambient occlusion, up to 1024; 0 for none.
    pub ambient_rays: u32,
    /// Exposure: displayed value of a unit of light; 0 for 1.
    pub exposure: f32,
}

impl EnfiladeViewerOptions {
    const NONE: EnfiladeViewerOptions = EnfiladeViewerOptions {
        flags: 0,
        layers: 0,
        tightness: 0,
        max_crossings: 0,
        max_passages: 0,
        max_occluders: 0,
        margin_px: 0.0,
        growth_px: 0.0,
    };

    fn options(&self) -> Result<ViewerOptions, Failure> {
        check_flags(self.flags, 7)?;
        let has = |flag: EnfiladeViewerFlags| self.flags & flag as u32 != 0;
        let tightness = match self.tightness {
            0 => Tightness::Boxes,
            1 => Tightness::Faces,
            2 => Tightness::Resolved,
            other => {
                let message =
                    format_args!("tightness is {other}; it must be an EnfiladeTightness").to_string();
                return Err(refuse("c/tightness", message));
            }
        };
        if self.max_crossings > u32::from(u16::MAX) {
            return Err(refuse("c/max-crossings", "max_crossings must be at most 65535"));
        }
        if !((0.0..=0.5).contains(&self.margin_px) && (0.0..=8.0).contains(&self.growth_px)) {
            return Err(refuse(
                "c/pixels",
                "margin_px must be 0 to 0.5, and growth_px 0 to 8",
            ));
        }
        let mut limits = Limits::default();
        if self.max_crossings != 0 {
            limits.max_crossings = self.max_crossings as u16;
        }
        if self.max_passages != 0 {
            limits.max_passages = self.max_passages;
        }
        Ok(ViewerOptions {
            limits,
            coherence: !has(EnfiladeViewerFlags::NoCoherence),
            parallel: has(EnfiladeViewerFlags::UsesThreads),
            occlusion: !has(EnfiladeViewerFlags::NoOcclusion),
            occluders: (self.max_occluders != 0).then_some(self.max_occluders),
            tightness,
            margin_px: self.margin_px,
            growth_px: self.growth_px,
            layers: if self.layers == 0 { u32::MAX } else { self.layers },
            ..ViewerOptions::default()
        })
    }
}

/// Creates a viewer that has seen nothing. Free it with enfilade_viewer_free.
///
/// @param version ENFILADE_VERSION.
/// @param options Null for the defaults.
/// @param viewer Receives the viewer.
///
/// Errors: ENFILADE_STATUS_BAD_ARGUMENT.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_viewer_create(
    version: u32,
    options: *const EnfiladeViewerOptions,
    viewer: *mut *mut EnfiladeViewer,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let viewer = caller.out(viewer, "viewer")?;
        check_version(version)?;
        let options = caller
            .maybe(options)
            .unwrap_or(EnfiladeViewerOptions::NONE)
            .options()?;
        viewer.set(handle::create(ViewerState {
            viewer: Viewer::with_options(options),
            uses_threads: options.parallel,
            keys: VisibleKeys::default(),
            keys_are_known: false,
            has_looked: false,
        })?);
        Ok(())
    })
}

/// Frees a viewer. Null is ignored.
///
/// Errors: ENFILADE_STATUS_BAD_HANDLE if it was freed before.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub extern "C" fn enfilade_viewer_free(viewer: *mut EnfiladeViewer) -> EnfiladeStatus {
    border(|| handle::free(viewer))
}

/// Replaces the options of a viewer; it keeps what it saw.
///
/// @param options Null for the defaults.
///
/// Errors: ENFILADE_STATUS_BAD_ARGUMENT.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_viewer_set_options(
    viewer: *mut EnfiladeViewer,
    options: *const EnfiladeViewerOptions,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let viewer = handle::find(viewer)?;
        let mut viewer = viewer.write()?;
        let options = caller
            .maybe(options)
            .unwrap_or(EnfiladeViewerOptions::NONE)
            .options()?;
        viewer.viewer.options = options;
        viewer.uses_threads = options.parallel;
        Ok(())
    })
}

/// Determines what is visible. Read it with enfilade_viewer_bits, enfilade_viewer_keys, enfilade_viewer_items and
/// enfilade_viewer_passages.
///
/// Starts no thread, and allocates nothing once the buffers of the viewer have grown, but for plans through several sectors. A look
/// that is refused changes nothing: what was visible before can still be read.
///
/// The method of each sector decides how long it takes (enfilade_scene_set_method); ENFILADE_METHOD_MASKED is mostly the fastest.
///
/// @param look Null, or receives the result in numbers.
///
/// Errors: ENFILADE_STATUS_BAD_VIEW; ENFILADE_STATUS_NO_SUCH_ID for the sector of the view; ENFILADE_STATUS_TOO_LARGE if buffers
/// for the screen would take more than 1 GB.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_viewer_look(
    viewer: *mut EnfiladeViewer,
    scene: *const EnfiladeScene,
    view: *const EnfiladeView,
    look: *mut EnfiladeLook,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let view = caller.one(view, "view");
        let look = caller.maybe_out(look);
        let viewer = handle::find(viewer)?;
        let mut viewer = viewer.write()?;
        let scene = handle::find(scene)?;
        let scene = scene.read()?;
        let view = view?.within(&scene)?;
        check_screen(&scene, &view)?;
        let ViewerState {
            viewer: own,
            uses_threads,
            keys_are_known,
            has_looked,
            ..
        } = &mut *viewer;
        *keys_are_known = false;
        *has_looked = true;
        let set = if *uses_threads {
            threads::on_all(|| own.look(&scene.scene, &view))
        } else {
            own.look(&scene.scene, &view)
        };
        if let Some(look) = look {
            let contracts = set.passages().iter().map(|passage| passage.contract);
            let combined = contracts.reduce(|all, one| all.combined_with(one));
            look.set(EnfiladeLook {
                item_count: set.items().len(),
                passage_count: set.passages().len(),
                contract: match combined {
                    Some(Contract::Exact) => EnfiladeContract::Exact,
                    Some(Contract::Strict) => EnfiladeContract::Strict,
                    Some(Contract::Conservative) => EnfiladeContract::Conservative,
                    _ => EnfiladeContract::Approximate,
                } as u32,
                is_complete: u32::from(set.complete()),
            });
        }
        Ok(())
    })
}

/// Checks the memory that the methods of the scene need for a view.
fn check_screen(scene: &SceneState, view: &View) -> Result<(), Failure> {
    for method in &scene.methods {
        method.check_screen(view, None, Method::DEFAULT_LIMIT)?;
    }
    Ok(())
}

/// Writes the last look as bits: bit key % 64 of word key / 64 is 1 if an item with this key is visible, else 0.
/// Before the first look all bits are 1: nothing is known to be hidden.
///
/// @param words The bits, which are cleared first.
/// @param word_count Number of words: one for each 64 keys.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL if a visible key has no bit, with the key as index; the bits of the others are right.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_viewer_bits(
    viewer: *const EnfiladeViewer,
    words: *mut u64,
    word_count: usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let words = caller.slice_mut(words, word_count, "words")?;
        words.fill(0);
        let viewer = handle::find(viewer)?;
        let viewer = viewer.read()?;
        if !viewer.has_looked {
            words.fill(u64::MAX);
            return Ok(());
        }
        let set = viewer.viewer.visible();
        set.mark(words);
        let end = 64 * words.len() as u64;
        let mut keys = set.items().iter().map(|item| item.key);
        match keys.find(|&key| key >= end) {
            None => Ok(()),
            Some(key) => {
                let message = format_args!("key {key} is visible, and there are only {end} bits").to_string();
                let failure = Failure::new(EnfiladeStatus::BufferTooSmall, "c/buffer-too-small", message);
                Err(failure.at(key as usize))
            }
        }
    })
}

/// Returns the keys of the last look, and those that entered and left since the last call of this function: what to show and to
/// hide. A second call after the same look returns the same.
///
/// @param keys Receives the arrays, which belong to the viewer.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_viewer_keys(
    viewer: *mut EnfiladeViewer,
    keys: *mut EnfiladeKeys,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let out = caller.out(keys, "keys")?;
        let viewer = handle::find(viewer)?;
        let mut viewer = viewer.write()?;
        let ViewerState {
            viewer,
            keys,
            keys_are_known,
            ..
        } = &mut *viewer;
        if !*keys_are_known {
            keys.update(viewer.visible());
            *keys_are_known = true;
        }
        let [all, entered, left] = [keys.all(), keys.entered(), keys.left()];
        out.set(EnfiladeKeys {
            visible: all.as_ptr(),
            visible_count: all.len(),
            entered: entered.as_ptr(),
            entered_count: entered.len(),
            left: left.as_ptr(),
            left_count: left.len(),
        });
        Ok(())
    })
}

/// Lists the visible items of the last look, passage after passage.
///
/// @param scene The scene that was looked at.
/// @param items Receives up to @p capacity items; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_viewer_items(
    viewer: *const EnfiladeViewer,
    scene: *const EnfiladeScene,
    items: *mut EnfiladeVisibleItem,
    capacity: usize,
    count: *mut usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let buffer = caller.buffer(items, capacity, count, "items")?;
        let viewer = handle::find(viewer)?;
        let viewer = viewer.read()?;
        let scene = handle::find(scene)?;
        let scene = scene.read()?;
        let set = viewer.viewer.visible();
        buffer.fill(set.items().iter().map(|item| EnfiladeVisibleItem {
            key: item.key,
            item: scene.items.id_of(set.passage(item.passage).sector, item.item),
            passage: item.passage.0,
            size_px: u32::from(item.size_px),
            blends: u32::from(item.blends),
            reserved: 0,
        }))
    })
}

/// Lists the passages of the last look. The first is that of the sector of the eye; without portals it is the only one.
///
/// @param scene The scene that was looked at.
/// @param passages Receives up to @p capacity passages; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_viewer_passages(
    viewer: *const EnfiladeViewer,
    scene: *const EnfiladeScene,
    passages: *mut EnfiladePassage,
    capacity: usize,
    count: *mut usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let buffer = caller.buffer(passages, capacity, count, "passages")?;
        let viewer = handle::find(viewer)?;
        let viewer = viewer.read()?;
        let scene = handle::find(scene)?;
        let scene = scene.read()?;
        buffer.fill(viewer.viewer.visible().passages().iter().map(|passage| {
            let matrix = passage.clip_from_sector();
            EnfiladePassage {
                clip_from_sector: std::array::from_fn(|number| matrix[number / 4][number % 4]),
                clip_plane: passage.entry_plane().unwrap_or_default(),
                sector: scene.sectors.id(passage.sector.0),
                portal: passage.portal.map_or(0, |portal| scene.portals.id(portal.0)),
                scissor: passage.scissor(),
                parent: passage.parent.map_or(u32::MAX, |parent| parent.0),
                crossings: u32::from(passage.crossings),
            }
        }))
    })
}

/// Draws a view in software: to show what is culled, and to test. It is a look, too: what is visible can be read afterwards.
///
/// @param options Null for the defaults.
/// @param rgba Receives the picture: rows from top to bottom, 4 bytes per pixel (red, green, blue, 255), sRGB.
/// @param row_bytes Bytes from one row to the next, at least 4 x width; 0 for that.
/// @param byte_count Bytes that @p rgba has room for, at least row_bytes x height.
///
/// Errors: as enfilade_viewer_look; ENFILADE_STATUS_BUFFER_TOO_SMALL.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_viewer_draw(
    viewer: *mut EnfiladeViewer,
    scene: *const EnfiladeScene,
    view: *const EnfiladeView,
    options: *const EnfiladeDrawOptions,
    rgba: *mut u8,
    row_bytes: usize,
    byte_count: usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let rgba = caller.slice_mut(rgba, byte_count, "rgba")?;
        let viewer = handle::find(viewer)?;
        let mut viewer = viewer.write()?;
        let scene = handle::find(scene)?;
        let scene = scene.read()?;
        let view = caller.one(view, "view")?.within(&scene)?;
        check_screen(&scene, &view)?;
        let settings = settings(caller.maybe(options))?;
        let [width, height] = view.size().map(|side| side as usize);
        let row_bytes = if row_bytes == 0 { 4 * width } else { row_bytes };
        if row_bytes < 4 * width {
            return Err(refuse(
                "c/short-stride",
                format_args!("row_bytes is {row_bytes}; a row has {}", 4 * width),
            ));
        }
        let needed = row_bytes.checked_mul(height);
        if needed.is_none_or(|needed| needed > rgba.len()) {
            return Err(Failure::new(
                EnfiladeStatus::BufferTooSmall,
                "c/buffer-too-small",
                format_args!("{height} rows of {row_bytes} bytes do not fit in {byte_count}"),
            ));
        }
        let ViewerState {
            viewer,
            keys_are_known,
            ..
        } = &mut *viewer;
        let scene: &SceneState = &scene;
        *keys_are_known = false;
        let picture = threads::on_all(|| {
            let stage = scene.stage.get_or_init(|| Stage::new(&scene.scene));
            stage.draw(viewer, &scene.scene, &view, &settings)
        });
        let rows = picture.image.as_raw().chunks_exact(3 * width);
        for (to, from) in rgba.chunks_mut(row_bytes).zip(rows) {
            for (to, from) in to.as_chunks_mut::<4>().0.iter_mut().zip(from.as_chunks::<3>().0) {
                let [r, g, b] = *from;
                *to = [r, g, b, u8::MAX];
            }
        }
        Ok(())
    })
}

fn settings(options: Option<EnfiladeDrawOptions>) -> Result<Settings, Failure> {
    const SHOWS: [Show; 6] = [
        Show::Image,
        Show::Items,
        Show::Sectors,
        Show::Order,
        Show::Overdraw,
        Show::Cover,
    ];
    let mut settings = Settings::default();
    let Some(options) = options else {
        return Ok(settings);
    };
    let Some(&show) = SHOWS.get(options.show as usize) else {
        return Err(refuse("c/show", "show must be an EnfiladeShow"));
    };
    settings.show = show;
    settings.samples = match options.samples {
        0 | 1 => Samples::One,
        4 => Samples::Four,
        _ => return Err(refuse("c/samples", "samples must be 1 or 4")),
    };
    settings.shadows = options.shadows != 0;
    if options.ambient_rays > 1024 {
        return Err(refuse("c/ambient-rays", "ambient_rays must be at most 1024"));
    }
    settings.ambient_occlusion = options.ambient_rays;
    crate::status::check_finite("exposure", &[options.exposure])?;
    if options.exposure != 0.0 {
        settings.exposure = Exposure::Fixed(options.exposure);
    }
    Ok(settings)
}
