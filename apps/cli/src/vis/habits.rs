//! Options as mappers know them from other compilers: one hyphen, and the names that those have.

use crate::out;
use std::ffi::OsString;

/// Options of other compilers that have another name here.
const RENAMED: [(&str, &str); 7] = [
    ("-noprogress", "--quiet"),
    ("-nopercent", "--quiet"),
    ("-noambient", "--no-ambient"),
    ("-noambientwater", "--no-ambient-water"),
    ("-noambientsky", "--no-ambient-sky"),
    ("-noambientslime", "--no-ambient-slime"),
    ("-noambientlava", "--no-ambient-lava"),
];

/// Options of other compilers that change nothing here.
const NEEDLESS: [&str; 6] = [
    "-v",
    "-verbose",
    "-nostate",
    "-nostats",
    "-lowpriority",
    "-saveprt",
];

/// Returns a command line in which the options of other compilers are ours; one that is not for `vis` as it is.
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
            // All levels of other compilers bound the same answer; the highest is what is computed here.
            let is_number = |word: &OsString| word.to_str().is_some_and(|word| word.parse::<u32>().is_ok());
            if let Some(level) = words.next_if(is_number).filter(|level| level != "4") {
                out::note(format_args!(
                    "-level {}: there is one level here, the highest; --fast is the quick one",
                    level.display()
                ));
            }
        } else if NEEDLESS.iter().any(|&theirs| word == theirs) {
            out::note(format_args!(
                "{}: left out, it changes nothing here",
                word.display()
            ));
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

/// Whether a word is an option's name after one hyphen, such as `-fast`. `-oFILE` is `-o FILE`.
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
