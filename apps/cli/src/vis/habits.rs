//! Accepts the options of other map compilers: with one hyphen, and by the names they have there.

use crate::out;
use std::ffi::OsString;

/// Options of other compilers, and their names here.
const RENAMED: [(&str, &str); 7] = [
    ("-noprogress", "--quiet"),
    ("-nopercent", "--quiet"),
    ("-noambient", "--no-ambient"),
    ("-noambientwater", "--no-ambient-water"),
    ("-noambientsky", "--no-ambient-sky"),
    ("-noambientslime", "--no-ambient-slime"),
    ("-noambientlava", "--no-ambient-lava"),
];

/// Options of other compilers that are ignored here.
const IGNORED: [&str; 6] = [
    "-v",
    "-verbose",
    "-nostate",
    "-nostats",
    "-lowpriority",
    "-saveprt",
];

/// Translates the options of other compilers in a `vis` command line to ours. Returns other command lines unchanged.
pub(crate) fn as_mappers_type(line: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let line: Vec<OsString> = line.collect();
    if line.get(1).is_none_or(|verb| verb != "vis") {
        return line;
    }
    let mut ours = Vec::with_capacity(line.len());
    let mut words = line.into_iter().peekable();
    while let Some(word) = words.next() {
        if let Some((_, name)) = RENAMED.iter().find(|&&(theirs, _)| word == theirs) {
            ours.push(name.into());
        } else if word == "-level" {
            // All levels of other compilers are upper bounds of the same result; ours corresponds to the highest.
            let is_number = |word: &OsString| word.to_str().is_some_and(|word| word.parse::<u32>().is_ok());
            if let Some(level) = words.next_if(is_number).filter(|level| level != "4") {
                out::note(format_args!(
                    "-level {}: ignored; vis always computes the highest level (use --fast for a quick one)",
                    level.display()
                ));
            }
        } else if IGNORED.iter().any(|&theirs| word == theirs) {
            out::note(format_args!("{}: ignored; it has no effect here", word.display()));
        } else if is_name_after_one_hyphen(&word) {
            let mut option = OsString::from("-");
            option.push(word);
            ours.push(option);
        } else {
            ours.push(word);
        }
    }
    ours
}

/// Whether a word is a long option with one hyphen, such as `-fast`. `-oFILE` is not: it means `-o FILE`.
fn is_name_after_one_hyphen(word: &OsString) -> bool {
    let name = word.to_str().and_then(|word| word.strip_prefix('-'));
    name.is_some_and(|name| {
        name.len() > 1 && name.starts_with(|first: char| first.is_ascii_lowercase() && first != 'o')
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn typed(line: &str) -> String {
        let words = line.split(' ').map(OsString::from);
        let ours = as_mappers_type(words).into_iter().map(|word| word.into_string());
        ours.collect::<Result<Vec<_>, _>>().expect("text").join(" ")
    }

    #[test]
    fn the_options_of_other_compilers_are_ours() {
        assert_eq!(
            typed("enfilade vis -level 4 -threads 2 -fast -noambientsky dm1 --json -"),
            "enfilade vis --threads 2 --fast --no-ambient-sky dm1 --json -"
        );
        assert_eq!(typed("enfilade vis -level dm1"), "enfilade vis dm1");
        assert_eq!(
            typed("enfilade vis -v -saveprt -noprogress dm1"),
            "enfilade vis --quiet dm1"
        );
        assert_eq!(
            typed("enfilade vis -visdist 100 -h -oout.bsp --quiet dm1"),
            "enfilade vis --visdist 100 -h -oout.bsp --quiet dm1"
        );
        assert_eq!(typed("enfilade look -fast"), "enfilade look -fast");
    }
}
