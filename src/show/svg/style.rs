//! Colors and classes. Every color is written twice: plainly, for programs that turn pictures into print and know
//! neither variables nor `@` rules, and as a variable, for browsers and for whoever embeds the picture.

use std::fmt::Write;

/// The class of every picture, so that its rules stay its own where it is embedded in a page.
pub(super) const SCOPE: &str = "ambidex";

/// Name, on white, on dark.
const COLORS: &[(&str, &str, &str)] = &[
    ("paper", "#ffffff", "#0d1117"),
    ("ink", "#1f2328", "#e6edf3"),
    ("faint", "#57606a", "#9da7b3"),
    ("rule", "#d8dee4", "#30363d"),
    ("node", "#eef1f4", "#21262d"),
    ("waiting", "#fbe28a", "#c9a227"),
    ("waiting-edge", "#a67c00", "#e3c04a"),
    ("active", "#f28e2b", "#f0883e"),
    ("active-edge", "#a34f00", "#ffc08a"),
    ("on-active", "#1f2328", "#0d1117"),
    ("done", "#8e6bbf", "#8f6fc7"),
    ("done-edge", "#54348a", "#cdb8f0"),
    ("done-pale", "#e6dcf4", "#3a2b57"),
    ("failed", "#b3261e", "#ff7b72"),
    ("failed-pale", "#fbdfdc", "#57201c"),
    ("kept", "#d3e5f5", "#17395a"),
    ("kept-edge", "#1f6fae", "#6cb3f0"),
    ("channel", "#1a7f6b", "#4cc9b0"),
];

/// Class and declarations; a value behind `@` is a color.
const RULES: &[(&str, &str)] = &[
    ("paper", "fill:@paper"),
    ("text", "fill:@ink;font-size:10px"),
    ("title", "fill:@ink;font-size:14px;font-weight:bold"),
    ("head", "fill:@ink;font-size:11px;font-weight:bold"),
    ("note", "fill:@faint;font-size:9.5px"),
    ("small", "fill:@faint;font-size:9px"),
    ("inner", "fill:@ink;font-size:8.5px"),
    ("inner-active", "fill:@on-active;font-size:8.5px"),
    ("channel-name", "fill:@channel;font-size:8.5px"),
    ("end", "text-anchor:end"),
    ("middle", "text-anchor:middle"),
    ("rule", "stroke:@rule;stroke-width:1;fill:none"),
    ("line", "stroke:@faint;stroke-width:1;fill:none"),
    ("edge", "stroke:@faint;stroke-width:1;fill:none"),
    ("node", "fill:@node;stroke:@ink;stroke-width:1.2"),
    ("again", "fill:@node;stroke:@faint;stroke-width:1;stroke-dasharray:3 2"),
    ("leaf", "fill:@paper;stroke:@faint;stroke-width:1"),
    ("waiting", "fill:@waiting;stroke:@waiting-edge;stroke-width:0.5"),
    ("active", "fill:@active;stroke:@active-edge;stroke-width:0.8"),
    ("done", "fill:@done;stroke:@done-edge;stroke-width:0.5"),
    ("leaf-waiting", "fill:@paper;stroke:@waiting-edge;stroke-width:1;stroke-dasharray:3 2"),
    ("leaf-done", "fill:@done-pale;stroke:@done-edge;stroke-width:1"),
    ("leaf-skipped", "fill:@paper;stroke:@done-edge;stroke-width:1"),
    ("leaf-failed", "fill:@failed-pale;stroke:@failed;stroke-width:1"),
    ("kept-physical", "fill:@kept;stroke:@kept-edge;stroke-width:1"),
    ("kept-intention", "fill:@paper;stroke:@kept-edge;stroke-width:1;stroke-dasharray:3 2"),
    ("grid-line", "stroke:@rule;stroke-width:0.6;fill:none"),
    ("step", "stroke:@faint;stroke-width:0.7;fill:none;stroke-dasharray:1 3"),
    ("round", "stroke:@faint;stroke-width:0.8;fill:none"),
    ("free", "fill:@node"),
    ("channel", "stroke:@channel;stroke-width:2;fill:none"),
    ("obstacle", "fill:@rule;stroke:@faint;stroke-width:0.8"),
    ("surface", "fill:@node;stroke:@ink;stroke-width:1"),
    ("stand", "fill:@paper;stroke:@ink;stroke-width:1.2"),
    ("heading", "stroke:@ink;stroke-width:1.4;fill:none"),
    ("thing", "fill:@waiting;stroke:@waiting-edge;stroke-width:1"),
    ("reach", "stroke:@kept-edge;stroke-width:0.8;fill:none;stroke-dasharray:2 3"),
    ("robot", "fill:@kept;stroke:@kept-edge;stroke-width:1.2;fill-opacity:0.6"),
    ("start", "fill:none;stroke:@kept-edge;stroke-width:1;stroke-dasharray:4 3"),
    ("drive", "stroke:@channel;stroke-width:1.6;fill:none"),
    ("arrow", "fill:@channel"),
    ("number", "fill:@paper;stroke:@channel;stroke-width:1"),
    ("mark-waiting", "stroke:@waiting-edge;stroke-width:1.4;fill:none"),
    ("mark-active", "stroke:@active-edge;stroke-width:0.8;fill:@active"),
    ("mark-done", "stroke:@done-edge;stroke-width:1.6;fill:none"),
    ("mark-skipped", "stroke:@done-edge;stroke-width:1.2;fill:@paper"),
    ("mark-failed", "stroke:@failed;stroke-width:1.8;fill:none"),
    ("mark-reopened", "stroke:@waiting-edge;stroke-width:1.4;fill:none"),
    ("mark-runs-on", "stroke:@active-edge;stroke-width:0.8;fill:@active"),
];

/// The style sheet that every picture carries.
pub(super) fn sheet() -> String {
    let variables = |pick: fn(&(&str, &str, &str)) -> String| COLORS.iter().map(pick).collect::<String>();
    let light = variables(|(name, light, _)| format!("--{name}:{light};"));
    let dark = variables(|(name, _, dark)| format!("--{name}:{dark};"));
    let mut css = String::from("\n");
    let _ = writeln!(css, ".{SCOPE}{{font-family:Helvetica,Arial,sans-serif}}");
    for (class, declarations) in RULES {
        let plain: Vec<String> = declarations.split(';').map(plain).collect();
        let _ = writeln!(css, ".{SCOPE} .{class}{{{}}}", plain.join(";"));
    }
    let _ = writeln!(css, "@supports (fill:var(--ink)){{");
    let _ = writeln!(css, ".{SCOPE}{{{light}}}");
    for (class, declarations) in RULES {
        let colors: Vec<String> = declarations.split(';').filter_map(variable).collect();
        if !colors.is_empty() {
            let _ = writeln!(css, ".{SCOPE} .{class}{{{}}}", colors.join(";"));
        }
    }
    let _ = writeln!(css, "}}\n@media (prefers-color-scheme:dark){{.{SCOPE}{{{dark}}}}}");
    css
}

/// A declaration with its color on white.
fn plain(written: &str) -> String {
    let Some((property, name)) = written.split_once(":@") else {
        return written.to_owned();
    };
    let color = COLORS.iter().find(|(known, ..)| *known == name);
    let (_, light, _) = color.unwrap_or_else(|| panic!("no color is called {name}"));
    format!("{property}:{light}")
}

/// A declaration of a color as its variable.
fn variable(written: &str) -> Option<String> {
    written.split_once(":@").map(|(property, name)| format!("{property}:var(--{name})"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance as WCAG 2 has it.
    fn luminance(color: &str) -> f64 {
        let part = |at: usize| f64::from(u8::from_str_radix(&color[at..at + 2], 16).unwrap()) / 255.0;
        let linear = |share: f64| if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) };
        0.2126 * linear(part(1)) + 0.7152 * linear(part(3)) + 0.0722 * linear(part(5))
    }

    /// At least this contrast between two colors, on white and on dark.
    fn check(one: &str, other: &str, least: f64) {
        let find = |name: &str| COLORS.iter().find(|(known, ..)| *known == name).unwrap();
        let (one, other) = (find(one), find(other));
        for (one, other) in [(one.1, other.1), (one.2, other.2)] {
            let (one, other) = (luminance(one), luminance(other));
            let contrast = (one.max(other) + 0.05) / (one.min(other) + 0.05);
            assert!(contrast >= least, "{contrast:.2} < {least}");
        }
    }

    #[test]
    fn text_stands_out_on_both_grounds() {
        for text in ["ink", "faint", "channel"] {
            check(text, "paper", 4.5);
        }
        check("on-active", "active", 4.5);
        for ground in ["node", "kept", "done-pale", "failed-pale"] {
            check("ink", ground, 4.5);
        }
    }

    #[test]
    fn shapes_stand_out_on_both_grounds() {
        for edge in ["waiting-edge", "active-edge", "done-edge", "failed", "kept-edge", "faint"] {
            check(edge, "paper", 3.0);
        }
    }

    #[test]
    fn every_color_stands_plainly_and_as_a_variable() {
        let css = sheet();
        let (plain, rest) = css.split_once("@supports").unwrap();
        assert!(plain.contains(".ambidex .text{fill:#1f2328;font-size:10px}"), "{css}");
        assert!(!plain.contains("var("), "{css}");
        assert!(rest.contains(".ambidex .text{fill:var(--ink)}"), "{css}");
        assert_eq!(css.matches('{').count(), css.matches('}').count());
    }
}
