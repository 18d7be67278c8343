//! Lines of usda with their indentation.

const INDENT: &str = "    ";

/// A text as it grows.
#[derive(Default)]
pub(super) struct Text {
    out: String,
    depth: usize,
}

impl Text {
    /// One line; an empty one has no indentation.
    pub fn line(&mut self, line: &str) {
        if !line.is_empty() {
            self.out.extend(std::iter::repeat_n(INDENT, self.depth));
            self.out += line;
        }
        self.out.push('\n');
    }

    /// A line that opens a block by itself, or with a round bracket behind `head`.
    pub fn open_round(&mut self, head: &str) {
        let line = if head.ends_with('{') { head.to_owned() } else { format!("{head}(") };
        self.line(&line);
        self.depth += 1;
    }

    /// A brace on its own line.
    pub fn open(&mut self) {
        self.line("{");
        self.depth += 1;
    }

    /// A prim without metadata, after an empty line.
    pub fn open_prim(&mut self, head: &str) {
        self.line("");
        self.line(head);
        self.open();
    }

    /// Closes a block with this bracket.
    pub fn close(&mut self, bracket: &str) {
        self.depth = self.depth.saturating_sub(1);
        self.line(bracket);
    }

    /// A shader with these lines.
    pub fn shader(&mut self, name: &str, lines: &[String]) {
        self.open_prim(&format!("def Shader \"{name}\""));
        for line in lines {
            self.line(line);
        }
        self.close("}");
    }

    /// The text.
    pub fn finish(self) -> String {
        self.out
    }
}
