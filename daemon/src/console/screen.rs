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

    /// Prints `log`, which scrolls away, and below it the block, in place of the one before.
    ///
    /// The block is clipped to the terminal's columns and rows: a wrapped line would break the
    /// count, and the cursor cannot go back to a line that has scrolled away.
    pub fn draw(&mut self, log: &[String], block: &[String], (columns, rows): (usize, usize)) {
        let mut text = self.back_to_start();
        for line in log {
            push_line(&mut text, line);
        }
        // The cursor stands in the row below the block.
        let block = shorten(block, rows.saturating_sub(1));
        for line in &block {
            push_line(&mut text, &clip(line, columns));
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

/// The first lines, and where there are more, a line that says so instead of the last.
fn shorten(block: &[String], most: usize) -> Vec<String> {
    if block.len() <= most {
        return block.to_vec();
    }
    let shown = most.saturating_sub(1);
    let note = format!("({} more lines: make the terminal larger)", block.len() - shown);
    block[..shown].iter().cloned().chain([note]).collect()
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
        screen.draw(&[], &block("one"), (80, 24));
        screen.draw(&["news".into()], &block("two"), (80, 24));
        screen.finish(&["bye".into()]);
        assert_eq!(drawn(screen), "head\r\none\r\n\x1b[2A\r\x1b[Jnews\r\nhead\r\ntwo\r\nbye\r\n");
    }

    #[test]
    fn a_block_higher_than_the_terminal_is_cut_and_says_so() {
        let block: Vec<_> = (0..9).map(|n| n.to_string()).collect();
        let mut screen = Screen::new(Vec::new());
        screen.draw(&[], &block, (80, 5));
        screen.draw(&[], &block[..1], (80, 5));
        let cut = "0\r\n1\r\n2\r\n(6 more lines: make the terminal larger)\r\n";
        assert_eq!(drawn(screen), format!("{cut}\x1b[4A\r\x1b[J0\r\n"));
    }

    #[test]
    fn long_lines_are_clipped_by_characters() {
        let mut screen = Screen::new(Vec::new());
        screen.draw(&[], &["±±±±".to_string()], (3, 24));
        assert_eq!(drawn(screen), "±±±\r\n");
    }
}
