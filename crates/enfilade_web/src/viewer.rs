//! The viewer: one camera, and what it saw last.

use crate::scene::Scene;
use crate::{check_length, error};
use enfilade::{ClipDepth, Limits, Tightness, View, ViewerOptions, VisibleKeys};
use wasm_bindgen::prelude::*;

/// The camera of a page. Keep one for each camera: what it saw makes the next look cheaper.
#[wasm_bindgen]
pub struct Viewer {
    /// One for each sample of a pixel.
    viewers: Vec<enfilade::Viewer>,
    keys: VisibleKeys,
    /// One bit per key; little endian, so also in 32-bit words.
    bits: Vec<u64>,
    /// The lists of `keys`, one after the other, as 32-bit numbers.
    lists: Vec<u32>,
    /// Keys that count as visible, besides those of the last sample.
    others: Vec<u64>,
    is_complete: bool,
    is_mirrored: bool,
}

/// Passages of a look: between mirrors that face each other, more would take seconds.
const MAX_PASSAGES: u32 = 1024;

#[wasm_bindgen]
impl Viewer {
    /// Creates a viewer that has seen nothing. `tightness`: how closely found objects are tested at the end, 0 by boxes, 1 by
    /// faces, 2 by faces at exact depths. `growth_px`: how far tested boxes grow. `samples` of a pixel: 1,
    /// or 4 for those of 4x multisampling, each looked at.
    #[wasm_bindgen(constructor)]
    pub fn new(tightness: u32, growth_px: f32, samples: u32) -> Viewer {
        let mut limits = Limits::default();
        limits.max_passages = MAX_PASSAGES;
        let options = ViewerOptions {
            tightness: match tightness {
                0 => Tightness::Boxes,
                1 => Tightness::Faces,
                _ => Tightness::Resolved,
            },
            growth_px,
            limits,
            ..ViewerOptions::default()
        };
        let viewers = (0..if samples > 1 { View::FOUR_SAMPLES.len() } else { 1 })
            .map(|_| enfilade::Viewer::with_options(options))
            .collect();
        Viewer {
            viewers,
            keys: VisibleKeys::default(),
            bits: Vec::new(),
            lists: Vec::new(),
            others: Vec::new(),
            is_complete: false,
            is_mirrored: false,
        }
    }

    /// Determines what is visible. The matrices have 16 numbers each: their columns. `depth` is the depth range of clip
    /// space: 0 for -1 to 1 (WebGL), 1 for 0 to 1 (WebGPU), 2 for 1 to 0 (reversed).
    ///
    /// # Errors
    /// Returns `web/length`, or the code of a [`ViewError`](enfilade::ViewError).
    #[allow(
        clippy::too_many_arguments,
        reason = "numbers cross the border of the module more cheaply than objects"
    )]
    pub fn look(
        &mut self,
        scene: &Scene,
        eye_from_world: &[f64],
        clip_from_eye: &[f64],
        depth: u32,
        width: u32,
        height: u32,
        layers: u32,
    ) -> Result<(), JsValue> {
        let view = view(eye_from_world, clip_from_eye, depth, [width, height])?;
        self.see(
            scene.scene(),
            scene.always_visible().iter().copied(),
            // It has no portals.
            0,
            &view,
            layers,
        )
    }

    /// Address of the bits of visible keys.
    #[wasm_bindgen(getter, js_name = bitsAddress)]
    pub fn bits_address(&self) -> usize {
        self.bits.as_ptr() as usize
    }

    /// Number of 32-bit words of these bits.
    #[wasm_bindgen(getter, js_name = bitsLength)]
    pub fn bits_length(&self) -> usize {
        2 * self.bits.len()
    }

    /// Address of the lists of visible, entered and left keys, one after the other.
    #[wasm_bindgen(getter, js_name = listsAddress)]
    pub fn lists_address(&self) -> usize {
        self.lists.as_ptr() as usize
    }

    /// Number of visible keys.
    #[wasm_bindgen(getter, js_name = visibleCount)]
    pub fn visible_count(&self) -> usize {
        self.keys.all().len()
    }

    /// Whether every visible portal was followed. If not, all keys count as visible.
    #[wasm_bindgen(getter, js_name = isComplete)]
    pub fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// Whether counter-clockwise faces appear clockwise on the screen.
    #[wasm_bindgen(getter, js_name = isMirrored)]
    pub fn is_mirrored(&self) -> bool {
        self.is_mirrored
    }

    /// Number of keys that became visible.
    #[wasm_bindgen(getter, js_name = enteredCount)]
    pub fn entered_count(&self) -> usize {
        self.keys.entered().len()
    }

    /// Number of keys that are no longer visible.
    #[wasm_bindgen(getter, js_name = leftCount)]
    pub fn left_count(&self) -> usize {
        self.keys.left().len()
    }
}

/// Returns the view of matrices as JavaScript has them. `depth` as in [`Viewer::look`].
pub(crate) fn view(
    eye_from_world: &[f64],
    clip_from_eye: &[f64],
    depth: u32,
    size: [u32; 2],
) -> Result<View, JsValue> {
    let depth = match depth {
        0 => ClipDepth::MinusOneToOne,
        1 => ClipDepth::ZeroToOne,
        _ => ClipDepth::OneToZero,
    };
    let [eye_from_world, clip_from_eye] = [
        columns("the view matrix", eye_from_world)?,
        columns("the projection matrix", clip_from_eye)?,
    ];
    View::from_matrices(eye_from_world, clip_from_eye, depth, size).map_err(|why| error(why.code(), why))
}

impl Viewer {
    /// Looks, and keeps the keys that are visible, `others` among them; all keys up to `count` where portals lead farther than a
    /// look follows them.
    pub(crate) fn see(
        &mut self,
        scene: &enfilade::Scene,
        others: impl IntoIterator<Item = u32>,
        count: u64,
        view: &View,
        layers: u32,
    ) -> Result<(), JsValue> {
        self.others.clear();
        self.others.extend(others.into_iter().map(u64::from));
        self.is_complete = true;
        self.is_mirrored = view.mirrored();
        let samples = self.viewers.len();
        for (number, viewer) in self.viewers.iter_mut().enumerate() {
            viewer.options.layers = layers;
            let set = if samples == 1 {
                viewer.look(scene, view)
            } else {
                let at = View::FOUR_SAMPLES[number];
                let view = view.at_sample(at).map_err(|why| error(why.code(), why))?;
                viewer.look(scene, &view)
            };
            self.is_complete &= set.complete();
            if number + 1 < samples {
                self.others.extend(set.items().iter().map(|item| item.key));
            } else {
                let all = if self.is_complete { 0..0 } else { 0..count };
                self.keys.update_with(set, self.others.iter().copied().chain(all));
            }
        }
        self.bits.fill(0);
        let words = self.keys.all().last().map_or(0, |&key| key as usize / 64 + 1);
        self.bits.resize(words.max(self.bits.len()), 0);
        for &key in self.keys.all() {
            self.bits[key as usize / 64] |= 1 << (key % 64);
        }
        self.lists.clear();
        for list in [self.keys.all(), self.keys.entered(), self.keys.left()] {
            self.lists.extend(list.iter().map(|&key| key as u32));
        }
        Ok(())
    }
}

/// Returns a matrix as four columns.
fn columns(what: &str, numbers: &[f64]) -> Result<[[f64; 4]; 4], JsValue> {
    check_length(what, numbers.len(), 16)?;
    Ok([0, 4, 8, 12].map(|first| [0, 1, 2, 3].map(|row| numbers[first + row])))
}
