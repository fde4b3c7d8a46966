//! Random access to the elements of an accessor.

/// Component type of an accessor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

/// Element format of an accessor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Kind {
    pub(super) component: Component,
    /// Components per element, 1 to 4, or 16.
    pub(super) parts: u8,
    /// Whether integers are normalized to 0 to 1, or −1 to 1 if signed.
    pub(super) normalized: bool,
}

/// The elements of an accessor.
pub(in crate::gltf) struct Elements<'b> {
    /// The bytes from the first element on, and the stride; `None` if all elements are zero.
    base: Option<(&'b [u8], usize)>,
    replacements: Option<Replacements<'b>>,
    kind: Kind,
}

/// Replacement values of a sparse accessor, sorted by element index.
pub(super) struct Replacements<'b> {
    pub(super) count: usize,
    pub(super) numbers: &'b [u8],
    pub(super) number_kind: Component,
    pub(super) values: &'b [u8],
}

impl Component {
    pub(super) fn of(component_type: u32) -> Option<Component> {
        match component_type {
            5120 => Some(Component::I8),
            5121 => Some(Component::U8),
            5122 => Some(Component::I16),
            5123 => Some(Component::U16),
            5125 => Some(Component::U32),
            5126 => Some(Component::F32),
            _ => None,
        }
    }

    /// Returns the component type if indices may have it.
    pub(super) fn of_index(component_type: u32) -> Option<Component> {
        Component::of(component_type)
            .filter(|component| matches!(component, Component::U8 | Component::U16 | Component::U32))
    }

    pub(super) fn bytes(self) -> u64 {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }
}

impl Kind {
    /// Returns the size of an element, in bytes.
    pub(super) fn bytes(self) -> u64 {
        self.component.bytes() * u64::from(self.parts)
    }
}

impl Replacements<'_> {
    /// Returns the element index of a replacement.
    pub(super) fn number(&self, at: usize) -> u32 {
        match self.number_kind {
            Component::U8 => u32::from(self.numbers[at]),
            Component::U16 => u32::from(u16::from_le_bytes(first(&self.numbers[2 * at..]))),
            _ => u32::from_le_bytes(first(&self.numbers[4 * at..])),
        }
    }

    /// Returns the replacement bytes of an element, if it is replaced.
    fn find(&self, index: usize, element_bytes: usize) -> Option<&[u8]> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = low + (high - low) / 2;
            match (self.number(middle) as usize).cmp(&index) {
                std::cmp::Ordering::Less => low = middle + 1,
                std::cmp::Ordering::Equal => return Some(&self.values[middle * element_bytes..]),
                std::cmp::Ordering::Greater => high = middle,
            }
        }
        None
    }
}

impl<'b> Elements<'b> {
    pub(super) fn new(
        base: Option<(&'b [u8], usize)>,
        replacements: Option<Replacements<'b>>,
        kind: Kind,
    ) -> Elements<'b> {
        Elements {
            base,
            replacements,
            kind,
        }
    }

    /// Returns the first components of an element; missing ones are 0. Normalized values are between −1 and 1.
    pub(in crate::gltf) fn floats<const N: usize>(&self, index: usize) -> [f32; N] {
        let bytes = self.at(index);
        let parts = usize::from(self.kind.parts);
        let each = |size: usize, number: fn(&[u8]) -> f32, one: f32| -> [f32; N] {
            std::array::from_fn(|part| match bytes {
                Some(bytes) if part < parts => {
                    let number = number(&bytes[part * size..]);
                    if self.kind.normalized {
                        (number / one).max(-1.0)
                    } else {
                        number
                    }
                }
                _ => 0.0,
            })
        };
        match self.kind.component {
            Component::I8 => each(1, |bytes| f32::from(i8::from_le_bytes(first(bytes))), 127.0),
            Component::U8 => each(1, |bytes| f32::from(bytes[0]), 255.0),
            Component::I16 => each(2, |bytes| f32::from(i16::from_le_bytes(first(bytes))), 32767.0),
            Component::U16 => each(2, |bytes| f32::from(u16::from_le_bytes(first(bytes))), 65535.0),
            // 32-bit integers are never normalized, because no use allows that.
            Component::U32 => each(4, |bytes| u32::from_le_bytes(first(bytes)) as f32, 1.0),
            Component::F32 => std::array::from_fn(|part| match bytes {
                Some(bytes) if part < parts => f32::from_le_bytes(first(&bytes[part * 4..])),
                _ => 0.0,
            }),
        }
    }

    /// Returns the first components of an element as joint indices; missing ones are 0.
    pub(in crate::gltf) fn joints(&self, index: usize) -> [u32; 4] {
        let Some(bytes) = self.at(index) else {
            return [0; 4];
        };
        std::array::from_fn(|part| match self.kind.component {
            Component::U8 => u32::from(bytes[part]),
            Component::U16 => u32::from(u16::from_le_bytes(first(&bytes[2 * part..]))),
            _ => u32::from_le_bytes(first(&bytes[4 * part..])),
        })
    }

    pub(super) fn u8(&self, index: usize) -> u32 {
        self.at(index).map_or(0, |bytes| u32::from(bytes[0]))
    }

    pub(super) fn u16(&self, index: usize) -> u32 {
        self.at(index)
            .map_or(0, |bytes| u32::from(u16::from_le_bytes(first(bytes))))
    }

    pub(super) fn u32(&self, index: usize) -> u32 {
        self.at(index).map_or(0, |bytes| u32::from_le_bytes(first(bytes)))
    }

    /// Returns the bytes from an element on; `None` if the element is zero.
    #[inline]
    fn at(&self, index: usize) -> Option<&[u8]> {
        let replaced = self
            .replacements
            .as_ref()
            .and_then(|replacements| replacements.find(index, self.kind.bytes() as usize));
        replaced.or_else(|| self.base.map(|(bytes, stride)| &bytes[index * stride..]))
    }
}

#[inline]
fn first<const SIZE: usize>(bytes: &[u8]) -> [u8; SIZE] {
    *bytes
        .first_chunk()
        .expect("elements are within their bytes, as checked by `StridedRange`")
}
