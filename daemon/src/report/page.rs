//! The page around tables and charts.

use super::svg::{Escaped, append};

/// The style of all reports, for light and dark and for print.
const STYLE: &str = include_str!("style.css");

/// A whole page. `body` is markup; the title is text.
pub fn page(title: &str, body: &str) -> String {
    let title = Escaped(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n{body}</main>\n\
         </body>\n</html>\n"
    )
}

/// A section with a heading; `id` is a plain word that links may name.
pub fn section(id: &str, heading: &str, body: &str) -> String {
    let heading = Escaped(heading);
    format!("<section id=\"{id}\">\n<h2>{heading}</h2>\n{body}</section>\n")
}

/// A figure: markup, and the markup of its caption.
pub fn figure(class: &str, content: &str, caption: &str) -> String {
    format!(
        "<figure>\n<div class=\"{class}\">\n{content}</div>\n<figcaption>{caption}</figcaption>\n\
         </figure>\n"
    )
}

/// A paragraph of markup.
pub fn paragraph(markup: &str) -> String {
    format!("<p>{markup}</p>\n")
}

/// A list of markup.
pub fn list(items: &[String]) -> String {
    let items: Vec<String> = items.iter().map(|item| format!("<li>{item}</li>\n")).collect();
    format!("<ul>\n{}</ul>\n", items.concat())
}

/// Pairs of a term and what it is, both markup.
pub fn definitions(pairs: &[(&str, String)]) -> String {
    let pairs: Vec<String> =
        pairs.iter().map(|(term, what)| format!("<dt>{term}</dt><dd>{what}</dd>\n")).collect();
    format!("<dl>\n{}</dl>\n", pairs.concat())
}

/// What a figure or table of the paper is, ours beside it, what differs and why; all markup.
pub fn beside(paper: &str, ours: &str, differs: &str, why: &str) -> String {
    let parts = [("The paper", paper), ("Ours", ours), ("What differs", differs), ("Why", why)];
    let cell = |(head, text): (&str, &str)| format!("<div><h4>{head}</h4><p>{text}</p></div>\n");
    format!("<div class=\"beside\">\n{}</div>\n", parts.map(cell).concat())
}

/// A legend for several charts: a key and what it stands for, both markup.
pub fn legend(entries: &[(String, String)]) -> String {
    let entry = |(key, what): &(String, String)| format!("<span>{key}{what}</span> ");
    let entries: String = entries.iter().map(entry).collect();
    format!("<p class=\"legend\">{entries}</p>\n")
}

/// A table that scrolls where it is too wide; head and rows are markup.
pub fn table(head: &str, rows: &str) -> String {
    format!(
        "<div class=\"scroll\">\n<table>\n<thead>\n{head}</thead>\n<tbody>\n{rows}</tbody>\n</table>\n\
         </div>\n"
    )
}

/// Cells of a table's row: `th` or `td` with attributes, each around markup.
pub fn cells(
    element: &str,
    attributes: &str,
    contents: impl IntoIterator<Item = impl AsRef<str>>,
) -> String {
    let mut row = String::new();
    for content in contents {
        let content = content.as_ref();
        append(&mut row, format_args!("<{element}{attributes}>{content}</{element}>"));
    }
    row
}

/// A chart with a name above it.
pub fn panel(name: &str, chart: &str) -> String {
    format!("<div>\n<p class=\"panel-name\">{name}</p>\n{chart}</div>\n")
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Panics where elements do not close in the order in which they were opened.
    pub(in crate::report) fn assert_balanced(markup: &str) {
        let mut open: Vec<&str> = Vec::new();
        let body = markup.split_once("</style>").map_or(markup, |(_, body)| body);
        let body = body.trim_start_matches("\n</head>").trim_end();
        let body = body.strip_suffix("</html>").unwrap_or(body);
        for tag in body.split('<').skip(1) {
            let (tag, _) = tag.split_once('>').expect("a tag ends");
            if let Some(name) = tag.strip_prefix('/') {
                assert_eq!(open.pop(), Some(name), "closed in the wrong order");
            } else if !tag.ends_with('/') && !tag.starts_with('!') {
                open.push(tag.split_whitespace().next().expect("a name"));
            }
        }
        assert_eq!(open, [""; 0], "not closed");
    }

    #[test]
    fn a_page_is_balanced_and_its_title_is_text() {
        let body = section("a", "1 < 2", &list(&[paragraph("x")]))
            + &beside("a", "b", "c", "d")
            + &legend(&[("k".into(), "w".into())])
            + &table("<tr><th>h</th></tr>", &format!("<tr>{}</tr>", cells("td", "", ["x", "y"])))
            + &panel("n", "chart");
        let page = page("<b>", &(body + &definitions(&[("a", "b".into())])));
        assert!(page.contains("<title>&lt;b&gt;</title>") && page.contains("<h2>1 &lt; 2</h2>"));
        assert_balanced(&page);
    }

    #[test]
    #[should_panic(expected = "wrong order")]
    fn what_is_not_balanced_is_noticed() {
        assert_balanced("<p><b></p></b>");
    }
}
