//! Tests of the documentation pages: links, file names, readers, line lengths, tables of parameters and options.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

#[cfg(feature = "ros")]
use crate::program::clearance;

/// Folders without pages of this project.
const NO_PAGES: [&str; 4] = ["target", "node_modules", "dist", "shared"];
/// Folders whose files pages name in code spans.
const FOLDERS: [&str; 11] = [
    "benches/",
    "config/",
    "crates/",
    "docs/",
    "examples/",
    "interfaces/",
    "launch_scripts/",
    "src/",
    "tests/",
    "urdf/",
    "view/",
];
/// Code spans that look like paths of this project and are none.
const NO_PATHS: [&str; 2] = ["src/clearance", "docs/decisions/NNNN-title.md"];
/// Pages that programs write.
const GENERATED: [&str; 2] = ["docs/benchmarks.md", "docs/node_benchmarks.md"];
const SUMMARY: &str = "docs/SUMMARY.md";
const LONGEST_README: usize = 150;
const LONGEST_LINE: usize = 120;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every page, by its path from the project's root.
fn pages() -> BTreeMap<PathBuf, String> {
    let mut found = BTreeMap::new();
    let mut folders = vec![root().to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir() {
                if !name.starts_with('.') && !NO_PAGES.contains(&name.as_str()) {
                    folders.push(path);
                }
            } else if path.extension().is_some_and(|extension| extension == "md") {
                let text = std::fs::read_to_string(&path).unwrap();
                found.insert(path.strip_prefix(root()).unwrap().to_path_buf(), text);
            }
        }
    }
    assert!(found.len() > 30, "only {} pages", found.len());
    found
}

/// The lines outside fenced code blocks, with their numbers from 1.
fn prose(text: &str) -> Vec<(usize, &str)> {
    let mut in_code = false;
    let mut lines = vec![];
    for (index, line) in text.lines().enumerate() {
        if line.trim_start().starts_with("```") {
            in_code = !in_code;
        } else if !in_code {
            lines.push((index + 1, line));
        }
    }
    lines
}

/// A line without its code spans.
fn without_code(line: &str) -> String {
    line.split('`').step_by(2).collect()
}

/// Targets of the links and pictures of a page, with the line of each.
fn links(text: &str) -> Vec<(usize, String)> {
    let target = |rest: &str| rest.split([')', ' ']).next().unwrap_or("").to_owned();
    prose(text)
        .into_iter()
        .flat_map(|(number, line)| {
            let line = without_code(line);
            line.split("](").skip(1).map(|rest| (number, target(rest))).collect::<Vec<_>>()
        })
        .collect()
}

/// The anchors of a page's headings, as GitHub and mdBook make them.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    let headings = prose(text).into_iter().filter(|(_, line)| line.starts_with('#'));
    headings
        .map(|(_, line)| {
            let title = line.trim_start_matches('#').trim().to_lowercase();
            let kept = title.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
            let anchor: String = kept.map(|c| if c == ' ' { '-' } else { c }).collect();
            let count = seen.entry(anchor.clone()).or_default();
            *count += 1;
            if *count == 1 { anchor } else { format!("{anchor}-{}", *count - 1) }
        })
        .collect()
}

/// A path without `.` and `..`.
fn normalized(path: &Path) -> PathBuf {
    let mut result = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => assert!(result.pop(), "{} leaves the project", path.display()),
            Component::CurDir => {}
            other => result.push(other),
        }
    }
    result
}

/// Why a link of a page leads nowhere.
fn broken(page: &Path, target: &str, pages: &BTreeMap<PathBuf, String>) -> Option<String> {
    if ["http://", "https://", "mailto:"].iter().any(|scheme| target.starts_with(scheme)) {
        return None;
    }
    let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
    let path = match file {
        "" => page.to_path_buf(),
        file => normalized(&page.parent().unwrap().join(file)),
    };
    if !root().join(&path).exists() {
        return Some(format!("{} does not exist", path.display()));
    }
    let known = || pages.get(&path).is_some_and(|text| anchors(text).contains(anchor));
    (!anchor.is_empty() && !known()).then(|| format!("{} has no heading #{anchor}", path.display()))
}

fn nothing_found(found: &[String]) {
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

#[test]
fn every_link_leads_to_a_file_and_a_heading() {
    let pages = pages();
    let mut found = vec![];
    let mut count = 0;
    for (page, text) in &pages {
        for (line, target) in links(text) {
            count += 1;
            found.extend(
                broken(page, &target, &pages)
                    .map(|why| format!("{}:{line}: {target}: {why}", page.display())),
            );
        }
    }
    assert!(count > 100, "only {count} links");
    nothing_found(&found);
}

#[test]
fn a_planted_broken_link_is_found() {
    let pages = pages();
    let text = "[a](README.md) `[b](none.md)` [c](none.md)\n```\n[d](none.md)\n```\n[e](README.md#none) [f](README.md#tests)";
    let found = links(text);
    assert_eq!(found.len(), 4, "{found:?}");
    let broken: Vec<_> =
        found.iter().filter_map(|(_, target)| broken(Path::new("page.md"), target, &pages)).collect();
    assert_eq!(broken, ["none.md does not exist", "README.md has no heading #none"]);
}

#[test]
fn pages_of_the_book_link_to_the_book_alone() {
    let mut found = vec![];
    for (page, text) in pages() {
        for (line, target) in links(&text) {
            let path = target.split('#').next().unwrap_or("");
            let leaves = || !normalized(&page.parent().unwrap().join(path)).starts_with("docs");
            if page.starts_with("docs") && !target.contains("://") && leaves() {
                found.push(format!("{}:{line}: {target}: name the file in a code span", page.display()));
            }
        }
    }
    nothing_found(&found);
}

#[test]
fn files_that_pages_name_exist() {
    let mut found = vec![];
    let mut count = 0;
    for (page, text) in pages() {
        if page == Path::new("CHANGELOG.md") {
            continue; // it is about earlier versions
        }
        for (number, line) in prose(&text) {
            for span in line.split('`').skip(1).step_by(2) {
                let is_path = |c: char| c.is_alphanumeric() || "_-./".contains(c);
                let named =
                    FOLDERS.iter().any(|folder| span.starts_with(folder)) && span.chars().all(is_path);
                if named && !NO_PATHS.contains(&span) {
                    count += 1;
                    if !root().join(span).exists() {
                        found.push(format!("{}:{number}: {span} does not exist", page.display()));
                    }
                }
            }
        }
    }
    assert!(count > 50, "only {count} files");
    nothing_found(&found);
}

#[test]
fn the_book_lists_every_page_once() {
    let pages = pages();
    let mut listed: Vec<PathBuf> = links(&pages[Path::new(SUMMARY)])
        .into_iter()
        .map(|(_, target)| normalized(&Path::new("docs").join(target)))
        .collect();
    listed.sort();
    let there: Vec<PathBuf> =
        pages.into_keys().filter(|page| page.starts_with("docs") && page != Path::new(SUMMARY)).collect();
    assert_eq!(listed, there);
}

#[test]
fn every_page_of_the_book_names_its_readers_first() {
    let mut found = vec![];
    for (page, text) in pages() {
        if !page.starts_with("docs") || page == Path::new(SUMMARY) {
            continue;
        }
        let mut lines = text.lines().filter(|line| !line.is_empty());
        let title = lines.next().unwrap_or("");
        let readers = lines.next().unwrap_or("");
        if !title.starts_with("# ") || !readers.starts_with("For ") {
            found.push(format!("{}: {title:?}, {readers:?}", page.display()));
        }
    }
    nothing_found(&found);
}

#[test]
fn lines_are_short() {
    let mut found = vec![];
    for (page, text) in pages() {
        let is_exempt = |exempt: &&str| page == Path::new(exempt);
        if GENERATED.iter().chain([&SUMMARY]).any(is_exempt) {
            continue;
        }
        for (number, line) in prose(&text) {
            let length = line.chars().count();
            if length > LONGEST_LINE && !line.starts_with('|') {
                found.push(format!("{}:{number}: {length} characters", page.display()));
            }
        }
    }
    nothing_found(&found);
}

#[test]
fn the_readme_is_short() {
    let lines = pages()[Path::new("README.md")].lines().count();
    assert!(lines <= LONGEST_README, "{lines} lines");
}

#[test]
fn the_table_of_parameters_has_the_defaults_of_the_parameter_file() {
    let manual = std::fs::read_to_string(root().join("config/clearance.yaml")).unwrap();
    let declared: BTreeMap<&str, &str> = manual
        .lines()
        .filter(|line| line.starts_with("    ") && !line.trim_start().starts_with('#'))
        .filter_map(|line| line.trim().split_once(": "))
        .collect();
    assert!(declared.len() > 30, "{declared:?}");
    let page = &pages()[Path::new("docs/reference/parameters.md")];
    let rows = page.lines().filter_map(|line| line.strip_prefix("| `"));
    let listed: BTreeMap<&str, &str> = rows
        .filter_map(|row| {
            let (name, rest) = row.split_once("` | `")?;
            Some((name, rest.split_once('`')?.0))
        })
        .collect();
    assert_eq!(listed, declared);
}

/// Every command of the program.
#[cfg(feature = "ros")]
const COMMANDS: [&str; 13] = [
    "check", "motion", "recover", "plan", "acm", "spheres", "verify", "lint", "view", "bench", "node",
    "doctor", "replay",
];

/// The first word of each code span.
#[cfg(feature = "ros")]
fn words_in_code(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).filter_map(|span| span.split_whitespace().next()).collect()
}

/// Whether the help of a command has a line for an option.
#[cfg(feature = "ros")]
fn has_option(help: &str, option: &str) -> bool {
    help.lines().any(|line| {
        let line = line.trim_start();
        // a short form may stand before
        let long = line.split_once(", ").filter(|(short, _)| short.len() == 2).map_or(line, |(_, long)| long);
        long.split([' ', '[']).next() == Some(option)
    })
}

#[cfg(feature = "ros")]
#[test]
fn the_table_of_options_names_the_commands_that_have_them() {
    let help = |command| String::from_utf8_lossy(&clearance(&[command, "--help"]).stdout).into_owned();
    let helps = COMMANDS.map(|command| (command, help(command)));
    let page = &pages()[Path::new("docs/plan/states.md")];
    let (_, section) = page.split_once("## Options of several commands").unwrap();
    let table =
        section.lines().skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|'));
    let mut found = vec![];
    let mut count = 0;
    for row in table.filter(|row| row.starts_with("| `")) {
        let cells: Vec<&str> = row.split(" | ").collect();
        let (commands, exceptions) = cells[1].split_once(';').unwrap_or((cells[1], ""));
        let (named, exempt) = (words_in_code(commands), words_in_code(exceptions));
        for option in words_in_code(cells[0]) {
            for (command, help) in &helps {
                count += 1;
                let is_listed = named.contains(command) != commands.starts_with("all");
                if !exempt.contains(command) && is_listed != has_option(help, option) {
                    found.push(format!("{option}: {command} is listed: {is_listed}"));
                }
            }
        }
    }
    assert!(count > 200, "only {count}");
    nothing_found(&found);
}
