//! Parses option values, with messages that say what is expected.

use enfilade::{ChoiceGoal, Method, View};
pub(crate) use enfilade_bake::Shard;
use enfilade_draw::Show;
use glam::DVec3;

/// The methods selected by `--method`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Choice {
    /// Each sector uses the method that its file names.
    Own,
    /// One method for all sectors.
    One(Method),
    /// Every method, one after the other.
    All,
    /// Each sector uses the method that is cheapest there, measured first.
    Auto,
}

pub(crate) fn method(text: &str) -> Result<Choice, String> {
    match text {
        "all" => Ok(Choice::All),
        "auto" => Ok(Choice::Auto),
        _ => {
            let names = || {
                Method::ALL
                    .iter()
                    .map(|method| method.name())
                    .chain(["auto", "all"])
            };
            Method::by_name(text)
                .map(Choice::One)
                .ok_or_else(|| among(text, names()))
        }
    }
}

/// Returns the help of `--occluders`: the methods that select occluders, and their default numbers.
pub(crate) fn occluders_help() -> String {
    let defaults = Method::ALL
        .iter()
        .filter_map(|method| Some(format!("{} for {method}", method.occluders()?)));
    format!(
        "Select at most N large occluders per passage (portal path), for methods that select occluders; fewer cull \
         less [default: {}]",
        defaults.collect::<Vec<_>>().join(", ")
    )
}

/// Returns the help of `--cover-size`: the methods that take one.
pub(crate) fn cover_size_help() -> String {
    let able = Method::ALL.iter().filter(|method| method.takes_cover_size());
    format!(
        "Set the resolution of the covers (occlusion buffers) of {}; a lower one culls less, and is faster only if \
         much lower, if at all [default: the screen size]",
        able.map(|method| method.name()).collect::<Vec<_>>().join(", ")
    )
}

/// Returns the help of `--method`: all method names.
pub(crate) fn methods() -> String {
    format!(
        "Use this method: {} auto (the cheapest in each sector, measured first) or all",
        Method::ALL.map(|method| format!("{method},")).join(" ")
    )
}

/// Returns the help of an optional `--method`.
pub(crate) fn methods_or_own() -> String {
    format!(
        "{} [default: the method that the file names for each sector, else hierarchical-z]",
        methods()
    )
}

/// Returns the help of `--simd`: the levels of this machine.
pub(crate) fn simd_help() -> String {
    let levels: Vec<&str> = enfilade::simd_levels().collect();
    format!(
        "Use this SIMD level: {}; changes the times only [default: {}]",
        levels.join(", "),
        levels[0]
    )
}

pub(crate) fn aim(text: &str) -> Result<ChoiceGoal, String> {
    match text {
        "look" => Ok(ChoiceGoal::Look),
        "draw" => Ok(ChoiceGoal::Draw),
        _ => Err(among(text, ["look", "draw"].into_iter())),
    }
}

pub(crate) fn show(text: &str) -> Result<Show, String> {
    Show::by_name(text).ok_or_else(|| among(text, Show::ALL.iter().map(|show| show.name())))
}

/// Parses `X,Y,Z`, each finite.
pub(crate) fn point(text: &str) -> Result<[f32; 3], String> {
    let wants = "expected three numbers, such as 1,2.5,-3";
    let values = text.split(',').map(|value| {
        let number: f32 = value
            .trim()
            .parse()
            .map_err(|_| format!("`{value}` is not a number; {wants}"))?;
        if number.is_finite() {
            Ok(number)
        } else {
            Err(format!("`{value}` is not finite; {wants}"))
        }
    });
    let values = values.collect::<Result<Vec<f32>, String>>()?;
    <[f32; 3]>::try_from(values).map_err(|_| wants.to_owned())
}

/// Parses `WxH`, in pixels.
pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text
        .split_once(['x', 'X'])
        .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    let sides: [u64; 2] = sides.ok_or("expected width and height, such as 1280x720")?;
    if sides
        .iter()
        .any(|side| !(1..=u64::from(View::MAX_PIXELS)).contains(side))
    {
        return Err(format!("width and height must be from 1 to {}", View::MAX_PIXELS));
    }
    Ok(sides.map(|side| side as u32))
}

/// Parses a field of view, in degrees.
pub(crate) fn degrees(text: &str) -> Result<f32, String> {
    let angle: f32 = text
        .parse()
        .map_err(|_| "expected a number of degrees, such as 60")?;
    if angle > 0.0 && angle < 180.0 {
        Ok(angle)
    } else {
        Err("must be above 0 and below 180 degrees".to_owned())
    }
}

/// Parses the height of what a parallel view shows.
pub(crate) fn height(text: &str) -> Result<f64, String> {
    let height: f64 = text
        .parse()
        .map_err(|_| "expected a number of scene units, such as 20")?;
    if height > 0.0 && height.is_finite() {
        Ok(height)
    } else {
        Err("must be above 0 and finite".to_owned())
    }
}

/// Parses a positive number of pixels.
pub(crate) fn pixels(text: &str) -> Result<f32, String> {
    let pixels: f32 = text
        .parse()
        .map_err(|_| "expected a number of pixels, such as 1 or 0.5")?;
    if pixels > 0.0 && pixels.is_finite() {
        Ok(pixels)
    } else {
        Err("must be above 0".to_owned())
    }
}

/// Parses the number of samples per pixel, 1 or 4.
pub(crate) fn samples(text: &str) -> Result<u32, String> {
    match text {
        "1" => Ok(1),
        "4" => Ok(4),
        _ => Err("expected 1 or 4 samples per pixel".to_owned()),
    }
}

/// Parses the number of rays of ambient occlusion, 0 to 1024.
pub(crate) fn rays(text: &str) -> Result<u32, String> {
    let rays: Option<u32> = text.parse().ok();
    rays.filter(|&rays| rays <= 1024)
        .ok_or_else(|| "expected a number of rays from 0 to 1024, such as 32".to_owned())
}

/// Parses stops of exposure; each doubles the light.
pub(crate) fn stops(text: &str) -> Result<f32, String> {
    const MAX_STOPS: f32 = 30.0;
    let stops: Option<f32> = text.parse().ok();
    stops.filter(|stops| stops.abs() <= MAX_STOPS).ok_or_else(|| {
        format!("expected a number of stops from -{MAX_STOPS} to {MAX_STOPS}, such as 1 or -0.5")
    })
}

/// Parses seconds, 0 to 10⁹.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.0..=1e9).contains(seconds));
    seconds.ok_or_else(|| "expected a number of seconds, such as 600 or 0.5".to_owned())
}

/// Parses a length in metres, above 0 and at most 10⁶.
pub(crate) fn metres(text: &str) -> Result<f64, String> {
    let metres: Option<f64> = text.parse().ok();
    metres
        .filter(|metres| *metres > 0.0 && *metres <= 1e6)
        .ok_or_else(|| "expected a number of metres above 0, such as 0.1".to_owned())
}

/// Parses an up vector, `z`, `-y` or `X,Y,Z`; returns it with length 1.
pub(crate) fn up(text: &str) -> Result<[f32; 3], String> {
    let wants = || "expected x, y, z, -x, -y, -z or three numbers, such as 0,0,1".to_owned();
    let vector = match text.trim_start_matches('+') {
        "x" => [1.0, 0.0, 0.0],
        "y" => [0.0, 1.0, 0.0],
        "z" => [0.0, 0.0, 1.0],
        "-x" => [-1.0, 0.0, 0.0],
        "-y" => [0.0, -1.0, 0.0],
        "-z" => [0.0, 0.0, -1.0],
        _ => point(text).map_err(|_| wants())?,
    };
    let unit = DVec3::from(vector.map(f64::from)).try_normalize();
    unit.map(|unit| unit.as_vec3().to_array())
        .ok_or_else(|| "an up vector needs a length above 0, such as 0,0,1".to_owned())
}

/// Parses a unit of length: its name, or metres, above 0 and at most 10⁶.
pub(crate) fn unit(text: &str) -> Result<f64, String> {
    match text.to_ascii_lowercase().as_str() {
        "m" => Ok(1.0),
        "cm" => Ok(0.01),
        "mm" => Ok(0.001),
        "km" => Ok(1000.0),
        "in" => Ok(0.0254),
        "ft" => Ok(0.3048),
        _ => metres(text).map_err(|_| {
            "expected a number of metres above 0, such as 0.1, or m, cm, mm, ft or in".to_owned()
        }),
    }
}

/// Parses bytes, plain or with a unit: `2GB`, `500MB`, `1.5 GiB`.
pub(crate) fn bytes(text: &str) -> Result<u64, String> {
    let wants = || "expected a number of bytes, such as 2GB, 500MB, 1.5GiB or 1000000".to_owned();
    let units_at = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(units_at);
    let factor = match unit.to_ascii_lowercase().as_str() {
        "" | "b" => 1.0,
        "k" | "kb" => 1e3,
        "m" | "mb" => 1e6,
        "g" | "gb" => 1e9,
        "t" | "tb" => 1e12,
        "kib" => 1024.0,
        "mib" => 1024.0 * 1024.0,
        "gib" => 1024.0 * 1024.0 * 1024.0,
        _ => return Err(wants()),
    };
    let number: f64 = number.trim().parse().map_err(|_| wants())?;
    let bytes = number * factor;
    if (1.0..1e18).contains(&bytes) {
        Ok(bytes as u64)
    } else {
        Err(wants())
    }
}

/// Parses the number of random samples per pixel at which strict methods are checked, 1 to 64.
pub(crate) fn check(text: &str) -> Result<u32, String> {
    match text.parse::<u32>() {
        Ok(samples @ 1..=64) => Ok(samples),
        _ => Err("expected a number of random samples per pixel from 1 to 64, or nothing".to_owned()),
    }
}

/// Parses `I/N`, a shard and the number of shards.
pub(crate) fn shard(text: &str) -> Result<Shard, String> {
    let numbers = text
        .split_once('/')
        .and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
    let (index, count) =
        numbers.ok_or("expected I/N, a shard and the number of shards, such as 0/4 to 3/4")?;
    Shard::new(index, count).ok_or_else(|| match count {
        0 => "there is no shard of 0; expected I/N, such as 0/4 to 3/4".to_owned(),
        _ => format!(
            "shards are counted from 0, so the last of {count} is {}/{count}",
            count - 1
        ),
    })
}

/// Parses a SIMD level that this machine supports.
pub(crate) fn simd(text: &str) -> Result<String, String> {
    if enfilade::simd_levels().any(|level| level == text) {
        Ok(text.to_owned())
    } else {
        Err(among(text, enfilade::simd_levels()))
    }
}

/// Returns the name that was probably meant, if one is similar.
pub(crate) fn nearest<'a>(mistyped: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let likeness = |name: &str| strsim::jaro_winkler(&mistyped.to_lowercase(), &name.to_lowercase());
    names
        .max_by(|a, b| likeness(a).total_cmp(&likeness(b)))
        .filter(|name| likeness(name) > 0.7)
}

/// Lists the available names, after the one that the mistyped name resembles most, if any.
pub(crate) fn among<'a>(mistyped: &str, names: impl Iterator<Item = &'a str>) -> String {
    const FEW: usize = 24;
    let names: Vec<&str> = names.collect();
    let nearest = nearest(mistyped, names.iter().copied());
    let suggestion = nearest.map_or(String::new(), |name| format!("did you mean {name}? "));
    let more = if names.len() > FEW {
        format!(" and {} more", names.len() - FEW)
    } else {
        String::new()
    };
    format!(
        "{suggestion}available: {}{more}",
        names[..names.len().min(FEW)].join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_right_is_read() {
        assert_eq!(point("1,2.5, -3"), Ok([1.0, 2.5, -3.0]));
        assert_eq!(size("1280x720"), Ok([1280, 720]));
        assert_eq!(degrees("60"), Ok(60.0));
        assert_eq!(
            ["2GB", "500MB", "1.5 kB", "12", "1KiB"].map(bytes),
            [2_000_000_000, 500_000_000, 1500, 12, 1024].map(Ok)
        );
        assert_eq!(
            ["all", "z-buffer"].map(method),
            [Ok(Choice::All), Ok(Choice::One(Method::ZBuffer))]
        );
        assert_eq!(
            ["z", "-y", "+x", "0,0,2", "-0,-3,0"].map(up),
            [
                [0.0, 0.0, 1.0],
                [0.0, -1.0, 0.0],
                [1.0, 0.0, 0.0],
                [0.0, 0.0, 1.0],
                [0.0, -1.0, 0.0]
            ]
            .map(Ok)
        );
        assert_eq!(
            ["m", "mm", "cm", "FT", "in", "0.5"].map(unit),
            [1.0, 0.001, 0.01, 0.3048, 0.0254, 0.5].map(Ok)
        );
        assert_eq!(check("1"), Ok(1));
        assert_eq!(shard("3/4").map(|shard| shard.to_string()).as_deref(), Ok("3/4"));
        let best = enfilade::simd_level();
        assert_eq!(simd(best).as_deref(), Ok(best));
    }

    #[test]
    fn what_is_wrong_is_refused_with_a_word_on_what_is_right() {
        let says = |result: Result<(), String>, word: &str| {
            let message = result.expect_err("invalid");
            assert!(message.contains(word), "`{message}` does not say `{word}`");
        };
        for text in ["1,2", "1,2,3,4", "1,,3", "NaN,0,0", "0,inf,0", ""] {
            says(point(text).map(drop), "such as 1,2.5,-3");
        }
        for text in ["0x0", "100000x100000", "12x99999999999999999"] {
            says(size(text).map(drop), "from 1 to 16384");
        }
        for text in ["w", "1,2", "", "nan,0,1"] {
            says(up(text).map(drop), "-z or three numbers");
        }
        says(up("0,0,0").map(drop), "above 0");
        for text in ["miles", "0", "-1", "inf", ""] {
            says(unit(text).map(drop), "a number of metres");
        }
        says(size("-1x5").map(drop), "such as 1280x720");
        says(size("12").map(drop), "such as 1280x720");
        says(degrees("180").map(drop), "below 180");
        says(degrees("NaN").map(drop), "below 180");
        for text in ["0", "-1", "GB", "3 parsecs", "NaN", "1e40"] {
            says(bytes(text).map(drop), "such as 2GB");
        }
        says(method("z-bufer").map(drop), "did you mean z-buffer?");
        says(method("quux").map(drop), "available: ");
        says(simd("avx3").map(drop), enfilade::simd_level());
        says(check("65").map(drop), "1 to 64");
        for text in ["4", "1/", "-1/4", "a/b", "1/4294967296"] {
            says(shard(text).map(drop), "such as 0/4 to 3/4");
        }
        says(shard("4/4").map(drop), "the last of 4 is 3/4");
        says(shard("0/0").map(drop), "no shard of 0");
        assert_eq!(check("16"), Ok(16));
    }
}
