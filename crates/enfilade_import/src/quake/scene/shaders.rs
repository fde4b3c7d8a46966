//! The `.shader` files of a Quake 3 map: which surfaces are not opaque, or not where the map has them.
//!
//! Engines read them from `scripts`, beside `maps`. They are looked for there, and in the folder of the map. Texture names
//! without a shader are judged by the flags of the map alone.
//! Source: the *Quake III Arena Shader Manual*, id Software, 1999; the engine's `tr_shader.c`.
//! Cost: one pass over the text; only the shaders that the map names are kept.

use crate::budget::Budget;
use crate::warning::{WarningKind, Warnings};
use crate::{NonOccluder, read_regular_file};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// What the shaders say about the textures of a map, by name in lower case.
#[derive(Debug, Default)]
pub(super) struct Shaders {
    known: HashMap<String, Shader>,
    /// The files that were found.
    pub(super) files: Vec<PathBuf>,
}

/// What a shader says about its surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Shader {
    /// Why they hide nothing.
    pub(super) non_occluder: Option<NonOccluder>,
    /// `cull none` or `cull back`: seen from behind as well.
    pub(super) double_sided: bool,
    /// `deformVertexes`: not where the map has them.
    pub(super) moves: bool,
}

impl Shaders {
    /// Reads the files around a map in `folder`, as far as they are about `wanted`, names in lower case.
    pub(super) fn read(
        folder: &Path,
        wanted: &HashSet<String>,
        budget: &mut Budget,
        warnings: &mut Warnings,
    ) -> Shaders {
        let mut shaders = Shaders::default();
        let is_scripts = |path: &PathBuf| {
            let name = path.file_name();
            name.is_some_and(|name| name.eq_ignore_ascii_case("scripts"))
        };
        let around = [folder, &folder.join("..")].map(list);
        let scripts = around.into_iter().flatten().filter(is_scripts);
        for folder in std::iter::once(folder.to_owned()).chain(scripts) {
            let paths = list(&folder).into_iter();
            let is_shader = |path: &PathBuf| {
                let ending = path.extension();
                ending.is_some_and(|ending| ending.eq_ignore_ascii_case("shader"))
            };
            for path in paths.filter(is_shader).take(MOST_FILES) {
                match read_regular_file(&path, None, &|| "its shader files".to_owned(), budget) {
                    Ok(text) => shaders.add(&String::from_utf8_lossy(&text), wanted),
                    Err(why) => warnings.name(WarningKind::MaterialFiles, || {
                        format!("{}: {why}", path.file_name().unwrap_or_default().display())
                    }),
                }
                shaders.files.push(path);
            }
        }
        shaders
    }

    /// Returns what the shader of a texture says; nothing if it has none.
    pub(super) fn of(&self, name: &str) -> Shader {
        self.known.get(name).copied().unwrap_or_default()
    }

    /// Adds the shaders of a text. What any of several with one name says holds: which of them counts is up to the game.
    fn add(&mut self, text: &str, wanted: &HashSet<String>) {
        let mut lines = Tokens {
            rest: text.trim_start_matches('\u{feff}'),
        };
        let (mut depth, mut name) = (0_u32, String::new());
        while let Some(token) = lines.next_in_any_line() {
            match token {
                "{" => depth += 1,
                "}" => depth = depth.saturating_sub(1),
                _ if depth == 0 => name = token.to_ascii_lowercase(),
                keyword if wanted.contains(&name) => {
                    let shader = self.known.entry(name.clone()).or_default();
                    if !is_known(keyword) {
                        shader.non_occluder.get_or_insert(NonOccluder::MaterialUnread);
                    }
                    // Several directives may share a line.
                    let mut word = keyword;
                    loop {
                        let next = lines.next_in_line_before_brace();
                        shader.read(word, next.unwrap_or_default());
                        let Some(next) = next else { break };
                        word = next;
                    }
                }
                _ => lines.skip_line(),
            }
        }
    }
}

/// Returns the sorted paths in a folder; the empty folder, that of `a.bsp`, is the current one.
fn list(folder: &Path) -> Vec<PathBuf> {
    let current = Path::new(".");
    let folder = if folder.as_os_str().is_empty() {
        current
    } else {
        folder
    };
    let entries = folder.read_dir().into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    paths.sort();
    paths
}

/// Files of a folder that are read.
const MOST_FILES: usize = 4096;

/// Returns `true` for the directives of the game. Those of other engines may let light through.
fn is_known(keyword: &str) -> bool {
    const DIRECTIVES: [&str; 27] = [
        "alphafunc",
        "alphagen",
        "animmap",
        "blendfunc",
        "clampmap",
        "clamptime",
        "cull",
        "deformvertexes",
        "depthfunc",
        "depthwrite",
        "detail",
        "entitymergable",
        "fogparms",
        "light",
        "map",
        "nomipmap",
        "nomipmaps",
        "nopicmip",
        "polygonoffset",
        "rgbgen",
        "skyparms",
        "sort",
        "surfaceparm",
        "tcgen",
        "tcmod",
        "tesssize",
        "videomap",
    ];
    let keyword = keyword.to_ascii_lowercase();
    // Of the compiler and of the editor.
    ["q3map_", "qer_"]
        .iter()
        .any(|prefix| keyword.starts_with(prefix))
        || DIRECTIVES.contains(&&*keyword)
}

impl Shader {
    /// Reads a word of the shader or of one of its stages, and the word after it.
    fn read(&mut self, keyword: &str, value: &str) {
        let is = |word: &str| keyword.eq_ignore_ascii_case(word);
        let value_is = |words: &[&str]| words.iter().any(|word| value.eq_ignore_ascii_case(word));
        let why = if is("blendFunc") {
            NonOccluder::Blended
        } else if is("alphaFunc") {
            NonOccluder::AlphaTested
        } else if is("surfaceparm") && value_is(&["trans", "alphashadow", "lightfilter", "fog"]) {
            NonOccluder::Translucent
        } else if is("surfaceparm") && value_is(&["water", "slime", "lava"]) {
            NonOccluder::Liquid
        } else if is("surfaceparm") && value_is(&["nonsolid", "nodraw", "hint", "skip"]) {
            NonOccluder::NotSolid
        } else if is("skyparms") || is("surfaceparm") && value_is(&["sky"]) {
            NonOccluder::Sky
        } else if is("fogparms") || is("sort") && !value_is(&["opaque", "3"]) {
            NonOccluder::Translucent
        } else if is("deformVertexes") {
            self.moves = true;
            NonOccluder::Animated
        } else if is("cull") && value_is(&["none", "twosided", "disable", "back", "backside", "backsided"]) {
            self.double_sided = true;
            NonOccluder::DoubleSidedShader
        } else {
            return;
        };
        self.non_occluder.get_or_insert(why);
    }
}

/// The words of a shader file. Comments are `// …` and `/* … */`; braces are words of their own at the start of a line only, as for
/// engines.
struct Tokens<'t> {
    rest: &'t str,
}

impl<'t> Tokens<'t> {
    /// Returns the next word, on whatever line.
    fn next_in_any_line(&mut self) -> Option<&'t str> {
        loop {
            if let Some(word) = self.next_in_line() {
                return Some(word);
            }
            self.rest = self.rest.strip_prefix(['\n', '\r'])?;
        }
    }

    /// Returns the next word of the line.
    fn next_in_line(&mut self) -> Option<&'t str> {
        self.skip_space();
        if let Some(quoted) = self.rest.strip_prefix('"') {
            let end = quoted.find(['"', '\n']).unwrap_or(quoted.len());
            let (word, rest) = quoted.split_at(end);
            self.rest = rest.strip_prefix('"').unwrap_or(rest);
            return Some(word);
        }
        let brace = self.rest.starts_with(['{', '}']);
        let end = if brace {
            1
        } else {
            self.rest
                .find(|letter: char| letter.is_whitespace() || matches!(letter, '{' | '}' | '"'))
                .unwrap_or(self.rest.len())
        };
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        (!word.is_empty()).then_some(word)
    }

    /// Skips spaces and comments, but no end of a line that is not in a comment.
    fn skip_space(&mut self) {
        loop {
            self.rest = self
                .rest
                .trim_start_matches(|letter: char| letter.is_whitespace() && !matches!(letter, '\n' | '\r'));
            if self.rest.starts_with("//") {
                let end = self.rest.find(['\n', '\r']).unwrap_or(self.rest.len());
                self.rest = &self.rest[end..];
            } else if let Some(comment) = self.rest.strip_prefix("/*") {
                self.rest = comment.split_once("*/").map_or("", |(_, rest)| rest);
            } else {
                return;
            }
        }
    }

    /// Returns the next word of the line, if no brace is before it.
    fn next_in_line_before_brace(&mut self) -> Option<&'t str> {
        self.skip_space();
        if self.rest.starts_with(['{', '}']) {
            return None;
        }
        self.next_in_line()
    }

    /// Skips the rest of the line, but no brace.
    fn skip_line(&mut self) {
        while self.next_in_line_before_brace().is_some() {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Shader {
        let mut shaders = Shaders::default();
        shaders.add(text, &HashSet::from(["textures/a/b".to_owned()]));
        shaders.of("textures/a/b")
    }

    #[test]
    fn a_map_that_is_named_without_a_folder_has_its_shaders_beside_it() {
        // Tests run in the folder of their package.
        assert!(list(Path::new("")).contains(&PathBuf::from("./Cargo.toml")));
    }

    #[test]
    fn what_a_shader_says_counts_wherever_it_stands() {
        for (text, why) in [
            ("", None),
            ("textures/a/b\n{\n{\nmap a.tga\nrgbGen identity\n}\n}\n", None),
            ("textures/a/b { { map a.tga } }", None),
            (
                "textures/a/b\n{\n{\nmap a.tga\nblendFunc add\n}\n}\n",
                Some(NonOccluder::Blended),
            ),
            (
                "Textures/A/B\r\n{\r\n\t{\r\n\t\tBLENDFUNC GL_ONE GL_ONE\r\n}}",
                Some(NonOccluder::Blended),
            ),
            (
                "textures/a/b{{map a.tga\nalphaFunc GE128}}",
                Some(NonOccluder::AlphaTested),
            ),
            (
                "textures/a/b\n{\nsurfaceparm trans\n}",
                Some(NonOccluder::Translucent),
            ),
            ("textures/a/b\n{\nsurfaceparm metalsteps\n}", None),
            (
                "textures/a/b\n{\ncull none // seen from behind\n}",
                Some(NonOccluder::DoubleSidedShader),
            ),
            (
                "textures/a/b\n{\ncull \"back\"\n}",
                Some(NonOccluder::DoubleSidedShader),
            ),
            ("textures/a/b\n{\ncull front\n}", None),
            ("// textures/a/b\ntextures/c\n{\nblendFunc add\n}", None),
            ("textures/a/b\n{\n/* blendFunc add */\n// cull none\n}", None),
            (
                "textures/c\n{\n}\ntextures/a/b\n{\ndeformVertexes wave 1 sin 0 1 0 1\n}",
                Some(NonOccluder::Animated),
            ),
            (
                "textures/a/b\n{\n}\ntextures/a/b\n{\n{\nblendFunc filter",
                Some(NonOccluder::Blended),
            ),
            ("}}} textures/a/b {{{", None),
            (
                "\u{feff}textures/a/b\n{\ncull none\n}",
                Some(NonOccluder::DoubleSidedShader),
            ),
            (
                "textures/a/b { { map a.tga blendFunc add } }",
                Some(NonOccluder::Blended),
            ),
            (
                "textures/a/b\n{\nsurfaceparm nomarks cull none\n}",
                Some(NonOccluder::DoubleSidedShader),
            ),
            (
                "textures/a/b\n{\ndp_water 0.1 1.2\n}",
                Some(NonOccluder::MaterialUnread),
            ),
            (
                "textures/a/b\n{\nq3map_surfacelight 100\nqer_trans 0.5\nsort opaque\nsurfaceparm dust\n}",
                None,
            ),
        ] {
            assert_eq!(of(text).non_occluder, why, "{text:?}");
        }
        assert!(of("textures/a/b { cull none\n }").double_sided);
        assert!(of("textures/a/b { deformVertexes autosprite\n }").moves);
    }
}
