//! Run-time SIMD level: the best of this machine, or a lower one that the caller selects.

use fearless_simd::{Level, Simd};
use std::sync::atomic::{AtomicUsize, Ordering};
use thiserror::Error;

#[cfg(feature = "simd")]
pub(crate) use fearless_simd::dispatch;

/// Compiles a kernel for the level that the compiler targets, and no other.
#[cfg(not(feature = "simd"))]
macro_rules! dispatch {
    ($level:expr, $simd:pat => $op:expr) => {{
        let _: fearless_simd::Level = $level;
        let $simd = crate::simd::baseline();
        $op
    }};
}
#[cfg(not(feature = "simd"))]
pub(crate) use dispatch;

/// Returns the level that the compiler targets.
#[cfg(not(feature = "simd"))]
#[inline(always)]
pub(crate) fn baseline() -> impl Simd {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    let level = Level::baseline().as_sse2().expect("SSE2, part of the target");
    #[cfg(target_arch = "aarch64")]
    let level = Level::baseline().as_neon().expect("NEON, part of the target");
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    let level = Level::baseline()
        .as_wasm_simd128()
        .expect("simd128, part of the target");
    #[cfg(not(any(
        target_arch = "x86",
        target_arch = "x86_64",
        target_arch = "aarch64",
        all(target_arch = "wasm32", target_feature = "simd128")
    )))]
    let level = fearless_simd::Fallback::new();
    level
}

/// Evaluates a part of a long kernel, as a function of its own where the kernel as a whole is too much for the compiler: for
/// WebAssembly without `simd128`, whose scalar code LLVM did not finish in twenty minutes; and in debug builds, where nothing that
/// is inlined shares its stack slots, so that one frame took 3 MB with AVX2, and the threads of most programs have 2.
macro_rules! apart {
    ($simd:expr, $part:expr) => {
        crate::simd::call_apart(
            $simd,
            #[inline(always)]
            || $part,
        )
    };
}
pub(crate) use apart;

/// See [`apart!`].
#[inline(always)]
pub(crate) fn call_apart<S: Simd, R>(simd: S, part: impl FnOnce() -> R) -> R {
    #[inline(never)]
    fn outlined<R>(part: impl FnOnce() -> R) -> R {
        part()
    }
    let has_instructions = cfg!(any(
        target_arch = "x86",
        target_arch = "x86_64",
        target_arch = "aarch64",
        all(target_arch = "wasm32", target_feature = "simd128")
    ));
    if !has_instructions {
        outlined(part)
    } else if cfg!(debug_assertions) {
        simd.vectorize(part)
    } else {
        part()
    }
}

/// Why a SIMD level cannot be selected; returned by [`use_simd_level`].
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SimdLevelError {
    /// No SIMD level has this name.
    #[error("there is no SIMD level `{0}`; this machine has {there}", there = listed())]
    Unknown(String),
    /// The level exists on other machines only.
    #[error("this machine has no {0}; it has {there}", there = listed())]
    NotHere(&'static str),
}

/// The levels of all machines, best first within each architecture.
const NAMES: [&str; 7] = [
    "avx512",
    "avx2",
    "sse4.2",
    "sse2",
    "neon",
    "wasm-simd128",
    "scalar",
];

/// Index into [`here`] of the selected level; 0 is the best.
static CHOSEN: AtomicUsize = AtomicUsize::new(0);

/// Returns the name of the SIMD level in use, such as `"avx2"`. It affects speed only; results are bit-identical at all
/// levels.
pub fn simd_level() -> &'static str {
    name(level())
}

/// Returns the names of the SIMD levels that this machine supports, best first. The first is used unless
/// [`use_simd_level`] selects another.
pub fn simd_levels() -> impl Iterator<Item = &'static str> {
    here().map(name)
}

/// Selects a SIMD level for the whole process, for example to measure what a machine without AVX2 would achieve.
///
/// Call it once, before building scenes: structures that exist already keep the level they were built with.
///
/// # Errors
/// Returns a [`SimdLevelError`] if `wanted` is not one of [`simd_levels`].
pub fn use_simd_level(wanted: &str) -> Result<(), SimdLevelError> {
    if let Some(place) = simd_levels().position(|name| name == wanted) {
        // Relaxed: the index is all the shared state; no other memory is published with it.
        CHOSEN.store(place, Ordering::Relaxed);
        return Ok(());
    }
    let elsewhere = NAMES.into_iter().find(|&name| name == wanted);
    Err(elsewhere.map_or_else(
        || SimdLevelError::Unknown(wanted.to_owned()),
        SimdLevelError::NotHere,
    ))
}

/// Returns the level for kernels.
pub(crate) fn level() -> Level {
    let chosen = here().nth(CHOSEN.load(Ordering::Relaxed));
    chosen.unwrap_or_else(best)
}

/// Returns the best level of this machine for which there are kernels.
fn best() -> Level {
    if cfg!(feature = "simd") {
        Level::new()
    } else {
        Level::baseline()
    }
}

/// Returns the levels of this machine, best first, down to the level that the program was compiled for; lower levels
/// would change nothing.
fn here() -> impl Iterator<Item = Level> {
    let best = best();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    let lower = [
        best.as_avx2().map(Level::Avx2),
        best.as_sse4_2().map(Level::Sse4_2),
        best.as_sse2().map(Level::Sse2),
    ];
    // Other architectures have a single level, known at compile time.
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    let lower = [None::<Level>; 0];
    let lower = lower
        .into_iter()
        .flatten()
        .filter(move |&lower| name(lower) != name(best));
    let all = std::iter::once(best).chain(lower);
    let mut ended = false;
    all.take_while(move |&level| {
        let wanted = !ended;
        ended = name(level) == name(Level::baseline());
        wanted
    })
}

fn name(level: Level) -> &'static str {
    match level {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Level::Avx512(_) => "avx512",
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Level::Avx2(_) => "avx2",
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Level::Sse4_2(_) => "sse4.2",
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Level::Sse2(_) => "sse2",
        #[cfg(target_arch = "aarch64")]
        Level::Neon(_) => "neon",
        #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
        Level::WasmSimd128(_) => "wasm-simd128",
        _ => "scalar",
    }
}

fn listed() -> String {
    simd_levels().collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_a_level_and_each_is_there_once_with_a_known_name() {
        let names: Vec<&str> = simd_levels().collect();
        assert_eq!(names.first(), Some(&name(best())));
        assert_eq!(names.last(), Some(&name(Level::baseline())));
        let places = names
            .iter()
            .map(|wanted| NAMES.iter().position(|name| name == wanted));
        let places: Vec<usize> = places.map(|place| place.expect("level in NAMES")).collect();
        assert!(places.is_sorted_by(|a, b| a < b), "{names:?}");
    }

    #[test]
    fn what_is_not_there_is_refused_with_what_is() {
        let refused = |wanted| use_simd_level(wanted).expect_err("unsupported level").to_string();
        let best = simd_level();
        assert_eq!(
            refused("avx3"),
            format!("there is no SIMD level `avx3`; this machine has {}", listed())
        );
        let elsewhere = if cfg!(target_arch = "aarch64") {
            "avx2"
        } else {
            "neon"
        };
        assert_eq!(
            refused(elsewhere),
            format!("this machine has no {elsewhere}; it has {}", listed())
        );
        assert_eq!(simd_level(), best);
    }
}
