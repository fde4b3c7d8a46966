//! The viewer: one camera, and what it saw last.

use crate::scene::Scene;
use crate::{check_length, error};
use enfilade::{ClipDepth, Tightness, View, VisibleKeys};
use wasm_bindgen::prelude::*;

/// The camera of a page. Keep one for each camera: what it saw makes the next look cheaper.
#[wasm_bindgen]
#[derive(Default)]
pub struct Viewer {
    viewer: enfilade::Viewer,
    keys: VisibleKeys,
    /// One bit per key; little endian, so also in 32-bit words.
    bits: Vec<u64>,
    /// The lists of `keys`, one after the other, as 32-bit numbers.
    lists: Vec<u32>,
}

#[wasm_bindgen]
impl Viewer {
    /// Creates a viewer that has seen nothing.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Viewer {
        Viewer::default()
    }

    /// Determines what is visible. The matrices have 16 numbers each: their columns. `depth` is the depth range of clip
    /// space: 0 for -1 to 1 (WebGL), 1 for 0 to 1 (WebGPU), 2 for 1 to 0 (reversed).
    ///
    /// # Errors
    /// Returns `web/length`, or the code of a [`ViewError`](enfilade::ViewError): `view/parallel` for a parallel projection.
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
        self.see(
            scene.scene(),
            scene.always_visible().iter().copied(),
            Look {
                eye_from_world,
                clip_from_eye,
                depth,
                size: [width, height],
                layers,
            },
        )
    }

    /// How closely found objects are tested at the end: 0 by boxes, 1 by faces, 2 by faces at exact depths.
    #[wasm_bindgen(setter)]
    pub fn set_tightness(&mut self, tightness: u32) {
        self.viewer.options.tightness = match tightness {
            0 => Tightness::Boxes,
            1 => Tightness::Faces,
            _ => Tightness::Resolved,
        };
    }

    /// How far the renderer may move a vertex, in pixels, 0 to ½.
    #[wasm_bindgen(setter, js_name = marginPx)]
    pub fn set_margin_px(&mut self, margin: f32) {
        self.viewer.options.margin_px = margin;
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

/// The camera of a look, as JavaScript has it.
pub(crate) struct Look<'a> {
    pub(crate) eye_from_world: &'a [f64],
    pub(crate) clip_from_eye: &'a [f64],
    pub(crate) depth: u32,
    pub(crate) size: [u32; 2],
    pub(crate) layers: u32,
}

impl Viewer {
    /// Looks, and keeps the keys that are visible, `others` among them.
    pub(crate) fn see(
        &mut self,
        scene: &enfilade::Scene,
        others: impl IntoIterator<Item = u32>,
        look: Look,
    ) -> Result<(), JsValue> {
        let depth = match look.depth {
            0 => ClipDepth::MinusOneToOne,
            1 => ClipDepth::ZeroToOne,
            _ => ClipDepth::OneToZero,
        };
        let view = View::from_matrices(
            columns("the view matrix", look.eye_from_world)?,
            columns("the projection matrix", look.clip_from_eye)?,
            depth,
            look.size,
        )
        .map_err(|why| error(why.code(), why))?;
        self.viewer.options.layers = look.layers;
        let set = self.viewer.look(scene, &view);
        self.keys.update_with(set, others.into_iter().map(u64::from));
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
