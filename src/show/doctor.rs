//! What a look at a machine came to, as text.

use serde::Serialize;
use strum::VariantArray;

use crate::Palette;
use crate::text::{MIN_WIDTH, columns, count, fit, hang};

/// All that was looked at.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Examination {
    /// The worst of all.
    pub verdict: Verdict,
    /// What was removed before, where that was asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub removed: Vec<String>,
    /// Each by itself, by group.
    pub checks: Vec<Check>,
}

/// How something is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Verdict {
    /// As a robot needs it.
    Ok,
    /// A robot runs, and may not run as well as it could.
    Warn,
    /// A robot does not run so.
    Error,
}

/// What a check is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, VariantArray)]
#[serde(rename_all = "snake_case")]
pub enum Topic {
    /// Where daemon and controllers meet.
    SharedMemory,
    /// Who may write where.
    Permissions,
    /// What the dead have left.
    Leftovers,
    /// Whether all are of one version.
    Versions,
    /// Time and who gets the processor.
    Clock,
    /// Open files.
    Descriptors,
    /// Kernel and service manager.
    System,
}

/// Something that was looked at.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Check {
    /// What it is about.
    pub topic: Topic,
    /// What was looked at.
    pub what: String,
    /// How it is.
    pub verdict: Verdict,
    /// What was found.
    pub found: String,
    /// What to do about it; none where nothing is to be done.
    pub todo: Option<String>,
}

impl Topic {
    fn title(self) -> &'static str {
        match self {
            Self::SharedMemory => "Shared memory",
            Self::Permissions => "Permissions",
            Self::Leftovers => "Leftovers",
            Self::Versions => "Versions",
            Self::Clock => "Clock",
            Self::Descriptors => "Descriptors",
            Self::System => "System",
        }
    }

    /// Something that is well.
    pub fn ok(self, what: impl Into<String>, found: impl Into<String>) -> Check {
        self.check(what, Verdict::Ok, found, None)
    }

    /// Something that could be better, and how.
    pub fn warn(self, what: impl Into<String>, found: impl Into<String>, todo: impl Into<String>) -> Check {
        self.check(what, Verdict::Warn, found, Some(todo.into()))
    }

    /// Something that is wrong, and what to do.
    pub fn error(self, what: impl Into<String>, found: impl Into<String>, todo: impl Into<String>) -> Check {
        self.check(what, Verdict::Error, found, Some(todo.into()))
    }

    fn check(self, what: impl Into<String>, verdict: Verdict, found: impl Into<String>, todo: Option<String>) -> Check {
        Check { topic: self, what: what.into(), verdict, found: found.into(), todo }
    }
}

impl Examination {
    /// All checks, by topic; what was removed before.
    pub fn new(mut checks: Vec<Check>, removed: Vec<String>) -> Self {
        checks.sort_by_key(|check| check.topic);
        let verdict = checks.iter().map(|check| check.verdict).max().unwrap_or(Verdict::Ok);
        Self { verdict, removed, checks }
    }

    /// A line for each check below its topic, what to do below it; each line with its end.
    pub fn text(&self, width: usize, palette: &Palette) -> String {
        let width = width.max(MIN_WIDTH);
        let mut text: String = self.removed.iter().map(|removed| hang("removed ", 8, removed, width)).collect();
        if !text.is_empty() {
            text.push('\n');
        }
        let widest = self.checks.iter().map(|check| columns(&check.what)).max().unwrap_or_default().min(width / 4);
        for topic in Topic::VARIANTS {
            let checks: Vec<_> = self.checks.iter().filter(|check| check.topic == *topic).collect();
            if checks.is_empty() {
                continue;
            }
            text += &format!("{}\n", Palette::paint(palette.strong, topic.title()));
            for check in checks {
                text += &check.text(widest, width, palette);
            }
            text.push('\n');
        }
        text + &self.sum(palette)
    }

    fn sum(&self, palette: &Palette) -> String {
        let of = |verdict| self.checks.iter().filter(|check| check.verdict == verdict).count();
        let (warnings, errors) = (of(Verdict::Warn), of(Verdict::Error));
        let sum = match (errors, warnings) {
            (0, 0) => "a robot can run here".to_owned(),
            (0, _) => format!("a robot can run here; {}", count(warnings, "warning")),
            (_, 0) => count(errors, "error"),
            (_, _) => format!("{}, {}", count(errors, "error"), count(warnings, "warning")),
        };
        format!("{}\n", Palette::paint(self.verdict.style(palette), sum))
    }
}

impl Verdict {
    fn style(self, palette: &Palette) -> anstyle::Style {
        match self {
            Self::Ok => palette.done,
            Self::Warn => palette.active,
            Self::Error => palette.failed,
        }
    }

    fn mark(self) -> char {
        match self {
            Self::Ok => '✓',
            Self::Warn => '!',
            Self::Error => '×',
        }
    }
}

impl Check {
    fn text(&self, widest: usize, width: usize, palette: &Palette) -> String {
        let mark = Palette::paint(self.verdict.style(palette), self.verdict.mark());
        let what = fit(&self.what, widest);
        let indent = widest + 6;
        let mut text = hang(&format!("  {mark} {what}  "), indent, &self.found, width);
        if let Some(todo) = &self.todo {
            let arrow = Palette::paint(palette.strong, '→');
            text += &hang(&format!("{}{arrow} ", " ".repeat(indent)), indent + 2, todo, width);
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn examined(checks: Vec<Check>) -> Examination {
        Examination::new(checks, Vec::new())
    }

    #[test]
    fn checks_stand_below_their_topics_with_what_to_do() {
        let todo = "`ambidex doctor --fix` removes it, and so does whatever runs next on this machine";
        let checks = vec![
            Topic::System.ok("kernel", "6.1"),
            Topic::Leftovers.warn("lab", "no process lives in it", todo),
            Topic::SharedMemory.error("mount", "there is no /dev/shm", "mount it"),
            Topic::SharedMemory.ok("writable", "files can be made there"),
        ];
        let text = Examination::new(checks, vec!["instance old".into()]).text(60, &Palette::plain());
        let expected = "\
removed instance old

Shared memory
  × mount     there is no /dev/shm
              → mount it
  ✓ writable  files can be made there

Leftovers
  ! lab       no process lives in it
              → `ambidex doctor --fix` removes it, and so
                does whatever runs next on this machine

System
  ✓ kernel    6.1

1 error, 1 warning
";
        assert_eq!(text, expected);
        assert!(text.lines().all(|line| columns(line) <= 60));
    }

    #[test]
    fn the_worst_is_the_verdict() {
        let ok = Topic::System.ok("kernel", "6.1");
        let warn = Topic::System.warn("memory", "little", "more");
        let check = |checks: Vec<Check>, verdict, sum: &str| {
            let examination = examined(checks);
            assert_eq!(examination.verdict, verdict);
            assert!(examination.text(80, &Palette::plain()).ends_with(sum), "{sum}");
        };
        check(vec![ok.clone()], Verdict::Ok, "\na robot can run here\n");
        check(vec![ok, warn.clone()], Verdict::Warn, "\na robot can run here; 1 warning\n");
        check(vec![warn, Topic::Clock.error("latency", "late", "less")], Verdict::Error, "\n1 error, 1 warning\n");
    }

    #[test]
    fn programs_read_words() {
        let told = serde_json::to_value(examined(vec![Topic::SharedMemory.warn("space", "little", "more")])).unwrap();
        let check = serde_json::json!({
            "topic": "shared_memory", "what": "space", "verdict": "WARN", "found": "little", "todo": "more",
        });
        assert_eq!(told, serde_json::json!({"verdict": "WARN", "checks": [check]}));
    }
}
