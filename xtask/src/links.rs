//! Links between rendered pages: whether each leads to a file, and to a place in it that exists.

use std::collections::{BTreeMap, HashSet};
use std::path::{Component, Path, PathBuf};

use anyhow::{Context, Result};

/// What following the links of a directory of pages found.
#[derive(Debug, Default)]
pub struct Found {
    /// Pages read.
    pub pages: usize,
    /// Links to pages and files beside them; those to other hosts are not followed.
    pub followed: usize,
    /// A line for each link that leads nowhere.
    pub broken: Vec<String>,
}

/// Follows every `href` and `src` of the pages below `directory`.
pub fn follow(directory: &Path) -> Result<Found> {
    Ok(followed(&pages(directory)?, |path| directory.join(path).is_file()))
}

/// Follows the links of `pages`, by their paths; `is_file` tells whether something else is there.
fn followed(pages: &BTreeMap<PathBuf, String>, is_file: impl Fn(&Path) -> bool) -> Found {
    let places: BTreeMap<&Path, HashSet<&str>> =
        pages.iter().map(|(path, text)| (path.as_path(), values(text, "id").collect())).collect();
    let mut found = Found { pages: pages.len(), ..Found::default() };
    for (page, text) in pages {
        for link in values(text, "href").chain(values(text, "src")).filter(|link| is_within(link)) {
            found.followed += 1;
            let (file, place) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { page.clone() } else { beside(page, file) };
            let is_there = match places.get(target.as_path()) {
                Some(ids) => place.is_empty() || ids.contains(place),
                // The top itself, which the page for wrong addresses names as its base.
                None => target.as_os_str().is_empty() || is_file(&target),
            };
            if !is_there {
                found.broken.push(format!("  {}: {link}", page.display()));
            }
        }
    }
    found
}

/// The pages below `directory`, by their paths from it.
fn pages(directory: &Path) -> Result<BTreeMap<PathBuf, String>> {
    let mut pages = BTreeMap::new();
    let mut open = vec![directory.to_path_buf()];
    while let Some(here) = open.pop() {
        let entries = std::fs::read_dir(&here).with_context(|| format!("cannot list {}", here.display()))?;
        for path in entries.flatten().map(|entry| entry.path()) {
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "html") {
                let text = std::fs::read_to_string(&path)
                    .with_context(|| format!("cannot read {}", path.display()))?;
                pages.insert(path.strip_prefix(directory)?.to_path_buf(), text);
            }
        }
    }
    Ok(pages)
}

/// The values of an attribute, in double quotes as mdBook writes them.
fn values<'a>(text: &'a str, attribute: &str) -> impl Iterator<Item = &'a str> {
    let begin = format!(" {attribute}=\"");
    text.match_indices(&begin)
        .map(|(at, found)| at + found.len())
        .filter_map(|start| text[start..].split('"').next())
        .collect::<Vec<_>>()
        .into_iter()
}

/// Whether a link stays among the pages: it names neither a scheme nor another host.
fn is_within(link: &str) -> bool {
    let scheme = link.split(['/', '#', '?']).next().is_some_and(|start| start.contains(':'));
    !scheme && !link.starts_with("//")
}

/// The path of `link` as a page at `page` means it, from the directory of all pages.
fn beside(page: &Path, link: &str) -> PathBuf {
    let mut path = if link.starts_with('/') { PathBuf::new() } else { page.with_file_name("") };
    for part in Path::new(link.trim_start_matches('/')).components() {
        match part {
            Component::ParentDir => drop(path.pop()),
            Component::Normal(name) => path.push(name),
            _ => {}
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_to_pages_and_places_that_are_not_there_are_found() {
        let one = r##"<h2 id="top"></h2><a href="in/two.html#deep"><img src="a.svg"><a href="#top">"##;
        let two = r##"<h2 id="deep"><a href="../one.html#no"><a href="../no.html"><a href="https://host/x"><a href="one.html">"##;
        let pages = [("one.html", one), ("in/two.html", two)];
        let pages = pages.map(|(path, text)| (PathBuf::from(path), text.to_owned())).into();
        let found = followed(&pages, |path| path == Path::new("a.svg"));
        assert_eq!((found.pages, found.followed), (2, 6));
        let broken = ["../one.html#no", "../no.html", "one.html"];
        assert_eq!(found.broken, broken.map(|link| format!("  in/two.html: {link}")));
    }
}
