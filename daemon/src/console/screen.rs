//! A block of lines redrawn in place with plain ANSI: cursor up, clear to the end.
//!
//! No mode of the terminal is changed, so there is nothing to restore, even after SIGKILL.

use std::io::Write;

/// Draws on a terminal.
#[derive(Debug)]
pub struct Screen<W> {
    out: W,
    /// Lines drawn last, above the cursor.
    drawn: usize,
}

impl<W: Write> Screen<W> {
    /// Draws from where the cursor is.
    pub const fn new(out: W) -> Self {
        Self { out, drawn: 0 }
    }

    /// Prints `log`, which scrolls away, and below it the block, in place of the one before. Lines
    /// of the block are clipped to `width` columns, since a wrapped line would break the count.
    pub fn draw(&mut self, log: &[String], block: &[String], width: usize) {
        let mut text = self.back_to_start();
        for line in log {
            push_line(&mut text, line);
        }
        for line in block {
            push_line(&mut text, &clip(line, width));
        }
        self.drawn = block.len();
        self.write(&text);
    }

    /// Leaves the block where it is and prints the last log lines below it.
    pub fn finish(&mut self, log: &[String]) {
        let mut text = String::new();
        for line in log {
            push_line(&mut text, line);
        }
        self.drawn = 0;
        self.write(&text);
    }

    fn back_to_start(&self) -> String {
        match self.drawn {
            0 => String::new(),
            lines => format!("\x1b[{lines}A\r\x1b[J"),
        }
    }

    /// A terminal that went away does not stop the daemon.
    fn write(&mut self, text: &str) {
        let _ = self.out.write_all(text.as_bytes()).and_then(|()| self.out.flush());
    }
}

fn push_line(text: &mut String, line: &str) {
    text.push_str(line);
    text.push_str("\r\n");
}

/// The first `width` characters; each of the table's characters takes one column.
fn clip(line: &str, width: usize) -> String {
    line.chars().take(width).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(screen: Screen<Vec<u8>>) -> String {
        String::from_utf8(screen.out).unwrap()
    }

    #[test]
    fn the_second_block_takes_the_place_of_the_first_and_logs_stay_above() {
        let mut screen = Screen::new(Vec::new());
        let block = |text: &str| vec!["head".to_string(), text.to_string()];
        screen.draw(&[], &block("one"), 80);
        screen.draw(&["news".into()], &block("two"), 80);
        screen.finish(&["bye".into()]);
        assert_eq!(drawn(screen), "head\r\none\r\n\x1b[2A\r\x1b[Jnews\r\nhead\r\ntwo\r\nbye\r\n");
    }

    #[test]
    fn long_lines_are_clipped_by_characters() {
        let mut screen = Screen::new(Vec::new());
        screen.draw(&[], &["±±±±".to_string()], 3);
        assert_eq!(drawn(screen), "±±±\r\n");
    }
}
