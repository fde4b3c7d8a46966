//! Looks for SIMD operations that are not inlined.
#![cfg(all(target_arch = "x86_64", target_os = "linux", not(debug_assertions)))]

/// Code that is not compiled for the SIMD level, as that of a closure may be, calls each operation instead of inlining
/// it: with one such closure, looks took up to 1.4 times as long.
#[test]
fn no_simd_operation_is_a_function_of_its_own() -> std::io::Result<()> {
    let program = std::fs::read(env!("CARGO_BIN_EXE_enfilade_micro"))?;
    let has = |symbol: String| {
        let mut all = program.windows(symbol.len());
        all.any(|bytes| bytes == symbol.as_bytes())
    };
    let [entered, called] = ["vectorize_avx2", "__fearless_simd_kernel"];
    // Symbols begin with the length of a name, and an underscore in newer ones.
    for between in ["", "_"] {
        let symbol = format!("{}{between}{called}", called.len());
        assert!(!has(symbol), "a SIMD operation is called");
    }
    let is_there = has(format!("{}{entered}", entered.len()));
    assert!(is_there, "a program without symbols shows nothing");
    Ok(())
}
