//! What makes the files of two missions different.

use ambidex_model::{Source, SourceFile};

/// The first difference, with what the first has and what the second has; none where both are the same.
pub fn difference(first: &Source, second: &Source) -> Option<String> {
    if first.settings != second.settings {
        let written = |source: &Source| match source.settings.as_slice() {
            [] => "no --set".to_owned(),
            settings => {
                settings.iter().map(|(name, value)| format!("--set {name}={value}")).collect::<Vec<_>>().join(" ")
            }
        };
        return Some(format!("that has {}, this {}", written(first), written(second)));
    }
    let pairs = std::iter::zip(&first.files, &second.files);
    let of_text = pairs.into_iter().find_map(|(first, second)| between(first, second));
    of_text.or_else(|| {
        let longer = if first.files.len() > second.files.len() { first } else { second };
        let only = longer.files.get(first.files.len().min(second.files.len()))?;
        Some(format!("only one of them reads {}", only.path))
    })
}

/// The first line of a file that is different.
fn between(first: &SourceFile, second: &SourceFile) -> Option<String> {
    if first.text == second.text {
        return None;
    }
    let (mut ours, mut theirs) = (first.text.lines(), second.text.lines());
    for number in 1.. {
        let (one, other) = (ours.next(), theirs.next());
        if one != other {
            let told = |line: Option<&str>| line.map_or("nothing".to_owned(), |line| format!("`{}`", line.trim_end()));
            return Some(format!("{}:{number} was {} and is {}", second.path, told(one), told(other)));
        }
        if one.is_none() {
            break;
        }
    }
    Some(format!("{} ends its lines otherwise", second.path))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ambidex_model::SourceKind;

    fn source(texts: &[&str], settings: &[(&str, &str)]) -> Source {
        let file = |(index, text): (usize, &&str)| SourceFile {
            path: format!("{index}.yaml"),
            same_as: None,
            text: (*text).to_owned(),
        };
        Source {
            kind: SourceKind::Mission,
            mission: "0.yaml".into(),
            robot: None,
            settings: settings.iter().map(|(name, value)| ((*name).into(), (*value).into())).collect(),
            files: texts.iter().enumerate().map(file).collect(),
        }
    }

    #[test]
    fn the_first_difference_is_told() {
        let check = |first: &Source, second: &Source, said: Option<&str>| {
            assert_eq!(difference(first, second).as_deref(), said);
        };
        let plain = source(&["a\nb\n", "c\n"], &[]);
        check(&plain, &plain.clone(), None);
        check(&plain, &source(&["a\nx\n", "c\n"], &[]), Some("0.yaml:2 was `b` and is `x`"));
        check(&plain, &source(&["a\n", "c\n"], &[]), Some("0.yaml:2 was `b` and is nothing"));
        check(&plain, &source(&["a\nb", "c\n"], &[]), Some("0.yaml ends its lines otherwise"));
        check(&plain, &source(&["a\nb\n"], &[]), Some("only one of them reads 1.yaml"));
        let set = source(&["a\nb\n", "c\n"], &[("object", "cup")]);
        check(&plain, &set, Some("that has no --set, this --set object=cup"));
    }
}
