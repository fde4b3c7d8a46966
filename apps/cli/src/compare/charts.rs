//! Draws bar charts with one bar per method, as inline SVG.

use crate::text::{bytes, count, short};
use anyhow::{Result, anyhow};
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Unit of the bars.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unit {
    Milliseconds,
    Bytes,
    Times,
}

/// One method's bar.
pub(super) struct Bar<'a> {
    pub(super) method: &'a str,
    /// Zero or more.
    pub(super) value: f64,
}

const WIDTH: u32 = 400;
/// Width of the names, left of the bars.
const NAMES: u32 = 118;
const ROW: u32 = 27;
/// Height of the axis labels, below the bars.
const AXIS: u32 = 30;
const INK: RGBColor = RGBColor(38, 43, 51);
const FAINT: RGBColor = RGBColor(118, 125, 137);
const GRID: RGBColor = RGBColor(228, 230, 234);
/// Ratio of the longest to the shortest bar above which the axis is logarithmic.
const WIDE_RANGE: f64 = 25.0;

/// Returns a chart as an `<svg>` element, and whether its axis is logarithmic (see [`WIDE_RANGE`]).
pub(super) fn bars(bars: &[Bar], unit: Unit) -> Result<(String, bool)> {
    let max = bars.iter().map(|bar| bar.value).fold(0.0, f64::max);
    let positive = bars.iter().map(|bar| bar.value).filter(|&value| value > 0.0);
    let min = positive.fold(max, f64::min);
    let logarithmic = max > WIDE_RANGE * min;
    let mut svg = String::new();
    if logarithmic {
        // Below the shortest bar, so that it has some length.
        let from = 10_f64.powf((0.7 * min).log10().floor());
        // Leave room for the label of the longest bar.
        let to = max * (max / from).powf(0.32);
        draw(&mut svg, bars, unit, (from..to).log_scale(), from)?;
    } else {
        let to = if max > 0.0 { 1.28 * max } else { 1.0 };
        draw(&mut svg, bars, unit, 0.0..to, 0.0)?;
    }
    Ok((svg, logarithmic))
}

fn draw<X>(svg: &mut String, bars: &[Bar], unit: Unit, axis: X, from: f64) -> Result<()>
where
    X: AsRangedCoord<Value = f64>,
    X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let failed = |error: &dyn std::fmt::Display| anyhow!("cannot draw a chart: {error}");
    let height = ROW * bars.len() as u32 + AXIS;
    let root = SVGBackend::with_string(svg, (WIDTH, height)).into_drawing_area();
    let mut chart = ChartBuilder::on(&root)
        .set_label_area_size(LabelAreaPosition::Left, NAMES)
        .set_label_area_size(LabelAreaPosition::Bottom, AXIS)
        .margin_right(18)
        .build_cartesian_2d(axis, 0.0..bars.len() as f64)
        .map_err(|error| failed(&error))?;
    chart
        .configure_mesh()
        .disable_y_mesh()
        .disable_y_axis()
        .x_labels(5)
        .x_label_formatter(&|value| tick(*value, unit))
        .x_label_style(text(13, &FAINT))
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(GRID)
        .draw()
        .map_err(|error| failed(&error))?;
    for (number, Bar { method, value }) in bars.iter().enumerate() {
        let middle = (bars.len() - number) as f64 - 0.5;
        let ends = [(from, middle - 0.34), (value.max(from), middle + 0.34)];
        let [r, g, b] = color(method);
        let name = EmptyElement::at((from, middle))
            + Text::new(
                (*method).to_owned(),
                (-9, 0),
                text(15, &INK).pos(Pos::new(HPos::Right, VPos::Center)),
            );
        let number = EmptyElement::at((value.max(from), middle))
            + Text::new(
                label(*value, unit),
                (7, 0),
                text(15, &INK).pos(Pos::new(HPos::Left, VPos::Center)),
            );
        chart
            .plotting_area()
            .draw(&Rectangle::new(ends, RGBColor(r, g, b).filled()))
            .and_then(|()| chart.plotting_area().draw(&name))
            .and_then(|()| chart.plotting_area().draw(&number))
            .map_err(|error| failed(&error))?;
    }
    root.present().map_err(|error| failed(&error))
}

fn text(size: u32, color: &RGBColor) -> TextStyle<'static> {
    // The style sheet of the page overrides the font.
    ("sans-serif", size).into_font().color(color)
}

/// Returns the colour of a method, the same in every chart, table and page; grey for an unknown name.
pub(super) fn color(method: &str) -> [u8; 3] {
    let known = COLORS.iter().find(|(name, _)| *name == method);
    let [_, color @ ..] = known.map_or(0x8A_919C, |(_, color)| *color).to_be_bytes();
    color
}

/// Listed by name, so that methods keep their colours when others are added.
const COLORS: [(&str, u32); 16] = [
    ("painter-min", 0xE3_A008),
    ("painter-mean", 0xC9_6A22),
    ("bsp", 0x84_54D6),
    ("bsp-front", 0xC1_52A8),
    ("z-buffer", 0x3B_6FD4),
    ("s-buffer", 0x4F_9D2D),
    ("hierarchical-z", 0x16_9B8A),
    ("hierarchical-s", 0x9A_B52E),
    ("masked", 0x2B_A3D8),
    ("svbsp", 0xA9_3F63),
    ("mobsp", 0xD4_8FB9),
    ("floating-horizon", 0x94_624A),
    ("cell", 0x0F_6E84),
    ("pvs", 0x5A_4FCF),
    ("auto", 0xA0_8A5B),
    ("own", 0x8A_919C),
];

/// Formats the label of a bar, with its unit.
fn label(value: f64, unit: Unit) -> String {
    match unit {
        Unit::Bytes => bytes(value as u64),
        Unit::Times => format!("{}×", short(value)),
        Unit::Milliseconds => format!("{} ms", significant(value)),
    }
}

/// Formats an axis label. Milliseconds have no unit here; the title of the chart has it.
fn tick(value: f64, unit: Unit) -> String {
    let plain = |value: f64| {
        if value >= 1000.0 {
            count(value as u64)
        } else {
            // Removes rounding errors of powers of ten and sums of tenths.
            ((value * 1e6).round() / 1e6).to_string()
        }
    };
    match unit {
        Unit::Bytes if value == 0.0 => "0".to_owned(),
        Unit::Bytes => bytes((value + 0.5) as u64).replace(".0 ", " "),
        Unit::Times => format!("{}×", plain(value)),
        Unit::Milliseconds => plain(value),
    }
}

/// Formats three significant digits, as `0.0123`, `1.23`, `123` or `12,346`; milliseconds end at a tenth of a
/// microsecond.
fn significant(value: f64) -> String {
    match value {
        v if v >= 99.95 => count((v + 0.5) as u64),
        v if v >= 9.995 => format!("{v:.1}"),
        v if v >= 0.9995 => format!("{v:.2}"),
        v if v >= 0.09995 => format!("{v:.3}"),
        0.0 => "0".to_owned(),
        v => format!("{v:.4}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use enfilade::Method;

    fn chart(values: &[f64], unit: Unit) -> (String, bool) {
        let methods = ["z-buffer", "hierarchical-z", "own"];
        let bars: Vec<Bar> = values
            .iter()
            .zip(methods)
            .map(|(&value, method)| Bar { method, value })
            .collect();
        super::bars(&bars, unit).expect("it is drawn")
    }

    #[test]
    fn a_chart_names_its_methods_and_their_values() {
        let (svg, logarithmic) = chart(&[12.0, 34.56, 0.0], Unit::Milliseconds);
        assert!(!logarithmic);
        for word in ["<svg", "z-buffer", "hierarchical-z", "12.0 ms", "34.6 ms", "0 ms"] {
            assert!(svg.contains(word), "{word}: {svg}");
        }
        let [r, g, b] = color("z-buffer");
        assert!(svg.contains(&format!("#{r:02X}{g:02X}{b:02X}")), "{svg}");
    }

    #[test]
    fn values_that_span_decades_have_a_logarithmic_axis() {
        let (svg, logarithmic) = chart(&[0.002, 0.5, 800.0], Unit::Milliseconds);
        assert!(logarithmic);
        assert!(svg.contains("0.01") && svg.contains("800 ms"), "{svg}");
        assert!(chart(&[0.0, 1e9, 3e4], Unit::Bytes).1);
        for nothing in [&[0.0, 0.0][..], &[]] {
            assert!(!chart(nothing, Unit::Times).1);
        }
    }

    #[test]
    fn methods_differ_in_colour() {
        for (i, a) in Method::ALL.iter().enumerate() {
            for b in &Method::ALL[..i] {
                assert_ne!(color(a.name()), color(b.name()));
            }
        }
    }
}
