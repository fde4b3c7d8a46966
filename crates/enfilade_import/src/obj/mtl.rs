//! Parses MTL files: the material properties that are drawn.
//!
//! An invalid line never makes a scene unreadable: it is ignored, with a warning.

use super::text::{Line, Lines, number, quoted, with_line_ends, without_mark};
use crate::NonOccluder;
use crate::warning::{WarningKind, Warnings};

/// A material as in its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Entry {
    pub(super) name: String,
    /// `Kd`.
    pub(super) diffuse: Option<[f32; 3]>,
    /// `Ke`.
    pub(super) emission: Option<[f32; 3]>,
    /// `d`: opacity, 1 is opaque.
    pub(super) coverage: Option<f32>,
    /// `Tr`: transparency, 1 is invisible.
    pub(super) transparency: Option<f32>,
    /// `map_Kd`.
    pub(super) diffuse_map: Option<Map>,
    /// `map_Ke`.
    pub(super) emission_map: Option<Map>,
    /// `map_d`.
    pub(super) coverage_map: Option<Map>,
    /// Why it is not known to be opaque, whatever its numbers are: `d -halo`, a filter color, an `illum` of glass, an alpha map, or a
    /// line about opacity that cannot be read.
    pub(super) non_occluder: Option<NonOccluder>,
}

/// An image reference of a material.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    /// As in the file; may contain spaces, backslashes or a drive letter.
    pub(super) file: String,
    /// `-s`: scale of the texture coordinates.
    pub(super) scale: [f32; 2],
    /// `-o`: offset, added after scaling.
    pub(super) offset: [f32; 2],
    /// `-clamp`: clamps instead of repeating.
    pub(super) clamp: bool,
}

/// Keywords of specular and other shading, which is not drawn; ignored without a warning.
const LEFT_ASIDE: [&[u8]; 14] = [
    b"Ka",
    b"Ks",
    b"Ns",
    b"Ni",
    b"sharpness",
    b"Pr",
    b"Pm",
    b"Ps",
    b"Pc",
    b"Pcr",
    b"aniso",
    b"anisor",
    b"Km",
    b"map_aat",
];

/// Keywords, in lower case and without `map_`, that change only how an opaque surface is shaded. A material with another one that is
/// not read may let light through, or be elsewhere (`disp`), so it hides nothing.
const OF_SHADING: [&str; 24] = [
    "aat",
    "aniso",
    "anisor",
    "ao",
    "bump",
    "decal",
    "ka",
    "kd",
    "ke",
    "km",
    "kn",
    "ks",
    "ni",
    "norm",
    "normal",
    "ns",
    "orm",
    "pc",
    "pcr",
    "pm",
    "pr",
    "ps",
    "refl",
    "sharpness",
];

/// Parses the materials of a file; `file` is its name in warnings.
pub(super) fn parse(text: &[u8], file: &str, warnings: &mut Warnings) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    let text = with_line_ends(without_mark(text));
    for line in Lines::of(&text, 0) {
        if line.keyword().eq_ignore_ascii_case(b"newmtl") {
            // Where case counts, what follows is about the material before.
            if let Some(before) = entries.last_mut().filter(|_| line.keyword() != b"newmtl") {
                before.doubt(NonOccluder::MaterialUnread);
            }
            entries.push(Entry {
                name: line.rest().into_owned(),
                ..Entry::default()
            });
            continue;
        }
        if LEFT_ASIDE.contains(&line.keyword()) {
            continue;
        }
        let read = match entries.last_mut() {
            Some(entry) => entry.read(&line, &mut |what| {
                warnings.name(WarningKind::MaterialLines, || {
                    format!("{file} line {}: {what}", line.number)
                })
            }),
            None => None,
        };
        if read.is_none() {
            warnings.name(WarningKind::MaterialLines, || {
                format!("{file} line {}: {}", line.number, quoted(&line.text))
            });
        }
    }
    entries
}

impl Entry {
    /// Parses a line and passes ignored options to `left`; `None` if the line is invalid or unknown.
    fn read(&mut self, line: &Line, left: &mut dyn FnMut(&str)) -> Option<()> {
        match line.keyword() {
            b"Kd" => self.diffuse = Some(color(line)?),
            b"Ke" => self.emission = Some(color(line)?),
            keyword @ (b"d" | b"Tr") => {
                // Also `d -halo 0.3`, which depends on the angle.
                let Some(amount) = amount(line) else {
                    return self.doubt(NonOccluder::MaterialUnread);
                };
                let value = match keyword {
                    b"d" => &mut self.coverage,
                    _ => &mut self.transparency,
                };
                if value.replace(amount).is_some_and(|before| before != amount) {
                    return self.doubt(NonOccluder::MaterialUnread);
                }
            }
            // Light that passes through, but for none and for all, which some programs write for what is opaque.
            b"Tf" => {
                if !matches!(color(line), Some([1.0, 1.0, 1.0] | [0.0, 0.0, 0.0])) {
                    self.doubt(NonOccluder::Transmissive);
                }
            }
            b"illum" => {
                let model = line.words().next().and_then(number);
                let is_one_of = |models: &[f32]| model.is_some_and(|model| models.contains(&model));
                // Glass, refraction, and reflection on glass.
                if is_one_of(&[4.0, 6.0, 7.0, 9.0]) {
                    self.doubt(NonOccluder::Transmissive);
                // 10 is drawn as its shadows alone.
                } else if !is_one_of(&[0.0, 1.0, 2.0, 3.0, 5.0, 8.0]) {
                    return self.doubt(NonOccluder::MaterialUnread);
                }
            }
            b"map_Kd" | b"map_kd" => self.diffuse_map = Some(Map::read(line, left)?),
            b"map_Ke" | b"map_ke" => self.emission_map = Some(Map::read(line, left)?),
            b"map_d" | b"map_D" | b"map_Tr" | b"map_tr" => {
                self.doubt(NonOccluder::AlphaTested);
                self.coverage_map = Some(Map::read(line, left)?);
            }
            keyword => {
                let keyword = String::from_utf8_lossy(keyword).to_lowercase();
                let word = keyword.strip_prefix("map_").unwrap_or(&keyword);
                if !OF_SHADING.contains(&word) {
                    self.doubt(NonOccluder::MaterialUnread);
                }
                return None;
            }
        }
        Some(())
    }

    /// Returns why the surface hides nothing; `None` if it is opaque or a numeric opacity tells.
    pub(super) fn why_no_occluder(&self) -> Option<NonOccluder> {
        // Some programs write `Tr` with the meaning of `d`: 0 and 1 may both be opaque, what is between them is not.
        let is_between = self.transparency.is_some_and(|value| 0.0 < value && value < 1.0);
        let contradicts = is_between && self.coverage == Some(1.0);
        let contradicts = contradicts.then_some(NonOccluder::MaterialUnread);
        self.non_occluder.or(contradicts)
    }

    /// Returns the opacity: `d`, or else what `Tr` leaves.
    pub(super) fn opacity(&self) -> f32 {
        let by_transparency = self.transparency.map(|through| 1.0 - through);
        self.coverage.or(by_transparency).unwrap_or(1.0)
    }

    /// Returns `true` if the surface is certainly opaque.
    pub(super) fn hides(&self) -> bool {
        self.why_no_occluder().is_none() && self.opacity() == 1.0
    }

    /// Notes why it is not known to be opaque, and returns `None`.
    pub(super) fn doubt(&mut self, why: NonOccluder) -> Option<()> {
        self.non_occluder.get_or_insert(why);
        None
    }
}

/// Parses three non-negative numbers, or one for all three. `spectral` and `xyz` are not supported.
fn color(line: &Line) -> Option<[f32; 3]> {
    let values: Vec<f32> = line.words().take(3).map(number).collect::<Option<_>>()?;
    let color = match *values {
        [grey] => [grey; 3],
        [r, g, b] => [r, g, b],
        _ => return None,
    };
    color
        .iter()
        .all(|value| value.is_finite() && *value >= 0.0)
        .then_some(color)
}

/// Parses a single number from 0 to 1.
fn amount(line: &Line) -> Option<f32> {
    let mut words = line.words();
    let value = number(words.next()?)?;
    ((0.0..=1.0).contains(&value) && words.next().is_none()).then_some(value)
}

impl Map {
    /// Parses `[-OPTION WORD …] FILE`.
    fn read(line: &Line, left: &mut dyn FnMut(&str)) -> Option<Map> {
        let rest = line.rest();
        let mut rest = &*rest;
        let mut map = Map {
            file: String::new(),
            scale: [1.0; 2],
            offset: [0.0; 2],
            clamp: false,
        };
        while let Some((option, after)) = first_word(rest).filter(|(word, _)| word.starts_with('-')) {
            let (values, file) = match option {
                // Up to three numbers; missing ones have their defaults.
                "-s" | "-o" | "-t" => numbers(after),
                "-mm" => skip(after, 2),
                "-blendu" | "-blendv" | "-cc" | "-clamp" | "-texres" | "-bm" | "-boost" | "-imfchan"
                | "-type" => skip(after, 1),
                // Not an option: a file name may begin with a hyphen.
                _ => break,
            };
            match (option, &*values) {
                ("-s", [u, v @ ..]) => map.scale = [*u, v.first().copied().unwrap_or(1.0)],
                ("-o", [u, v @ ..]) => map.offset = [*u, v.first().copied().unwrap_or(0.0)],
                ("-clamp", _) => map.clamp = first_word(after)?.0 == "on",
                _ => left(option),
            }
            rest = file;
        }
        map.file = rest.trim_matches('"').to_owned();
        (!map.file.is_empty()).then_some(map)
    }
}

/// Returns the first word and the rest, if there is a word.
fn first_word(text: &str) -> Option<(&str, &str)> {
    let text = text.trim_start();
    let end = text.find(char::is_whitespace).unwrap_or(text.len());
    (end > 0).then(|| (&text[..end], text[end..].trim_start()))
}

/// Returns up to three leading numbers, and the rest. The last word is never a number, because it is the file.
fn numbers(mut text: &str) -> (Vec<f32>, &str) {
    let mut values = Vec::new();
    while let Some((word, after)) = first_word(text).filter(|(_, after)| !after.is_empty()) {
        match number(word.as_bytes()) {
            Some(value) if value.is_finite() && values.len() < 3 => values.push(value),
            _ => break,
        }
        text = after;
    }
    (values, text)
}

/// Skips some words; returns no numbers, and the rest.
fn skip(text: &str, words: usize) -> (Vec<f32>, &str) {
    let after = (0..words).fold(text, |text, _| first_word(text).map_or("", |(_, after)| after));
    (Vec::new(), after)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (Vec<Entry>, Vec<String>) {
        let mut warnings = Warnings::default();
        let entries = parse(text.as_bytes(), "a.mtl", &mut warnings);
        (
            entries,
            warnings.into_list().iter().map(ToString::to_string).collect(),
        )
    }

    fn map(rest: &str) -> (Option<Map>, Vec<String>) {
        let (mut entries, warnings) = read(&format!("newmtl a\nmap_Kd {rest}"));
        (entries.remove(0).diffuse_map, warnings)
    }

    #[test]
    fn a_material_is_all_lines_up_to_the_next() {
        let text = "\u{feff}# b\r\nnewmtl dark oak \r\nKd 0.1 0.2 0.3\r\n\tKe 2 0 0\r\nd 0.5\r\nNs 10\r\nnewmtl b\nKd 1\nTr .25";
        let (entries, warnings) = read(text);
        assert_eq!(warnings, [""; 0]);
        assert_eq!(entries.len(), 2);
        assert_eq!((&*entries[0].name, &*entries[1].name), ("dark oak", "b"));
        assert_eq!(entries[0].diffuse, Some([0.1, 0.2, 0.3]));
        assert_eq!(entries[0].emission, Some([2.0, 0.0, 0.0]));
        assert_eq!((entries[0].coverage, entries[0].transparency), (Some(0.5), None));
        assert_eq!(entries[1].diffuse, Some([1.0; 3]));
        assert_eq!((entries[1].coverage, entries[1].transparency), (None, Some(0.25)));
    }

    #[test]
    fn lines_that_make_no_sense_are_named_and_left_out() {
        for line in [
            "Kd red",
            "Kd 1 1",
            "Kd nan 0 0",
            "Kd -1 0 0",
            "Kd",
            "Kd spectral a.rfl",
            "map_Kd",
            "map_Bump a.png",
            "NORM a.png",
        ] {
            let (entries, warnings) = read(&format!("newmtl a\n{line}"));
            let bare = Entry {
                name: "a".to_owned(),
                ..Entry::default()
            };
            assert_eq!(entries, [bare], "{line}");
            assert!(
                warnings[0].contains(&format!("a.mtl line 2: {line}")),
                "{warnings:?}"
            );
        }
        for line in [
            "d",
            "d -halo 0.5",
            "d red",
            "d 1.5",
            "D 0.5",
            "Tr 2",
            "Tr",
            "map_d",
            "map_opacity a.png",
            "Pt 0.9",
            "transparency 1",
            "d 1 -halo",
            "d 1 0.3",
            "d=0.3",
            "Kt 0.9",
            "refraction 0.9",
            "map_mask a.png",
            "disp a.png",
            "illum 10",
            "illum glass",
            "nonsense",
        ] {
            let (entries, warnings) = read(&format!("newmtl a\n{line}"));
            assert!(
                entries[0].non_occluder.is_some(),
                "{line}: what is not known to be opaque is not"
            );
            assert!(
                warnings[0].contains(&format!("a.mtl line 2: {line}")),
                "{warnings:?}"
            );
        }
        for (line, is_occluder) in [
            ("Tf 0.2 0.9 0.9", false),
            ("Tf spectral a.rfl", false),
            ("Tf 1 1 1", true),
            ("Tf 0 0 0", true),
            ("illum 2", true),
            ("illum 4", false),
            ("illum 6", false),
            ("illum 7", false),
            ("illum 9", false),
            ("map_d a.png", false),
        ] {
            let (entries, warnings) = read(&format!("newmtl a\n{line}"));
            assert_eq!(
                (entries[0].non_occluder.is_none(), warnings.len()),
                (is_occluder, 0),
                "{line}"
            );
        }
        let (entries, warnings) = read("Kd 1 1 1\n");
        assert!(
            entries.is_empty() && warnings[0].contains("a.mtl line 1: Kd 1 1 1"),
            "{warnings:?}"
        );
    }

    #[test]
    fn names_of_images_come_after_their_options() {
        let (wood, warnings) = map("-clamp on -s 2 3 1 -o 0.5 my wood.png");
        let expected = Map {
            file: "my wood.png".to_owned(),
            scale: [2.0, 3.0],
            offset: [0.5, 0.0],
            clamp: true,
        };
        assert_eq!((wood, warnings.len()), (Some(expected), 0));
        let file = |rest: &str| map(rest).0.map(|map| map.file);
        for (rest, name) in [
            ("..\\tex\\a b.png", "..\\tex\\a b.png"),
            ("\"a b.png\"", "a b.png"),
            ("-o 1 2 3 4.png", "4.png"),
            ("-s 1 1", "1"),
            ("-x.png", "-x.png"),
            ("-clamp off a.png", "a.png"),
            ("-bm 0.3 -mm 0 1 a.png", "a.png"),
        ] {
            assert_eq!(file(rest).as_deref(), Some(name), "{rest}");
        }
        let (_, warnings) = map("-bm 0.3 -t 1 1 1 a.png");
        assert!(
            warnings[0].ends_with("(a.mtl line 2: -bm, a.mtl line 2: -t)"),
            "{warnings:?}"
        );
        assert_eq!(file("-clamp on"), None);
    }
}
