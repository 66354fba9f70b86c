//! One page without script, for light and dark.

use std::fmt::{self, Display, Write};

const STYLE: &str = include_str!("style.css");

/// Text that may hold anything, for the inside of an element or of an attribute in double quotes.
#[derive(Clone, Copy, Debug)]
pub struct Escaped<'a>(pub &'a str);

impl Display for Escaped<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for character in self.0.chars() {
            match character {
                '&' => out.write_str("&amp;")?,
                '<' => out.write_str("&lt;")?,
                '>' => out.write_str("&gt;")?,
                '"' => out.write_str("&quot;")?,
                '\'' => out.write_str("&#39;")?,
                // What XML does not allow at all.
                control if control.is_control() && !matches!(control, '\n' | '\t') => {
                    out.write_char('\u{fffd}')?;
                }
                other => out.write_char(other)?,
            }
        }
        Ok(())
    }
}

/// A whole page; the title is text, the body markup.
pub fn page(title: &str, body: &str) -> String {
    let title = Escaped(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n\
         <h1>{title}</h1>\n{body}</main>\n</body>\n</html>\n"
    )
}

/// A table of text; the first row is its head, the first column the rows' names.
pub fn table(rows: &[Vec<String>]) -> String {
    let mut markup = String::from("<table>\n");
    for (number, row) in rows.iter().enumerate() {
        let cell = if number == 0 { "th" } else { "td" };
        let cells: Vec<String> =
            row.iter().map(|text| format!("<{cell}>{}</{cell}>", Escaped(text))).collect();
        markup += "<tr>";
        markup += &cells.concat();
        markup += "</tr>\n";
    }
    markup + "</table>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_escapes_from_text() {
        let text = Escaped("<script a=\"b\" c='d'>&\u{1}\n").to_string();
        assert_eq!(text, "&lt;script a=&quot;b&quot; c=&#39;d&#39;&gt;&amp;\u{fffd}\n");
    }

    #[test]
    fn whatever_a_camera_is_called_it_stays_text() {
        let rows = [vec!["a".into(), "b".into()], vec!["<x>".into(), "\"1\" & 2\u{1}".into()]];
        let page = page("<t>", &table(&rows));
        assert!(page.contains("<title>&lt;t&gt;</title>"));
        assert!(page.contains("<tr><td>&lt;x&gt;</td><td>&quot;1&quot; &amp; 2\u{fffd}</td></tr>"));
        assert_eq!(page.matches("<tr>").count(), page.matches("</tr>").count());
        assert!(page.contains("prefers-color-scheme: dark"));
    }
}
