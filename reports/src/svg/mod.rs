//! Drawings as inline SVG, coloured by the page's style sheet. All text in them is escaped here.

mod axis;
mod diagram;
mod lanes;
mod limits;
mod marks;

pub(crate) use diagram::diagram;
pub(crate) use limits::limit_bar;

use crate::show::clean;
use std::fmt::Write;

/// SVG text that is being written.
#[derive(Debug, Default)]
struct Canvas(String);

impl Canvas {
    /// Appends markup made by this module.
    fn raw(&mut self, args: std::fmt::Arguments<'_>) {
        // Writing to a String cannot fail.
        let _ = self.0.write_fmt(args);
    }

    fn rect(&mut self, class: &str, x: f64, y: f64, width: f64, height: f64) {
        let (x, y, width, height) = (px(x), px(y), px(width.max(0.0)), px(height.max(0.0)));
        self.raw(format_args!(
            r#"<rect class="{class}" x="{x}" y="{y}" width="{width}" height="{height}"/>"#
        ));
    }

    fn line(&mut self, class: &str, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2]) {
        let (x1, y1, x2, y2) = (px(x1), px(y1), px(x2), px(y2));
        self.raw(format_args!(r#"<line class="{class}" x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}"/>"#));
    }

    /// Text with its base line at `y`; `class` decides where it is anchored.
    fn text(&mut self, class: &str, x: f64, y: f64, text: &str) {
        let (x, y, text) = (px(x), px(y), escape(text));
        self.raw(format_args!(r#"<text class="{class}" x="{x}" y="{y}">{text}</text>"#));
    }

    /// A path from `data`, if there is any.
    fn path(&mut self, class: &str, data: &str) {
        if !data.is_empty() {
            self.raw(format_args!(r#"<path class="{class}" d="{data}"/>"#));
        }
    }
}

/// Markup characters replaced, and what [`clean`] replaces.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in clean(text).chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            other => out.push(other),
        }
    }
    out
}

/// A coordinate with one decimal at most.
fn px(x: f64) -> String {
    let tenths = (x * 10.0).round();
    let tenths = if tenths.is_finite() { tenths as i64 } else { 0 };
    if tenths % 10 == 0 {
        (tenths / 10).to_string()
    } else {
        let sign = if tenths < 0 { "-" } else { "" };
        format!("{sign}{}.{}", tenths.abs() / 10, tenths.abs() % 10)
    }
}

/// How wide a text is in the small font of the drawings, roughly.
fn text_width(text: &str) -> f64 {
    6.3 * text.chars().count() as f64
}

/// The first characters that fit into `width`, with an ellipsis where some are left out.
fn fit(text: &str, width: f64) -> String {
    let room = (width / 6.3).max(0.0) as usize;
    if text.chars().count() <= room {
        return text.to_owned();
    }
    let mut short: String = text.chars().take(room.saturating_sub(1)).collect();
    short.push('…');
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_short() {
        assert_eq!([px(1.0), px(0.25), px(-0.26), px(f64::NAN)], ["1", "0.3", "-0.3", "0"]);
    }

    #[test]
    fn texts_cannot_leave_their_element() {
        assert_eq!(escape("<a href='\"'>&\u{0}"), "&lt;a href=&#39;&quot;&#39;&gt;&amp;\u{fffd}");
    }
}
