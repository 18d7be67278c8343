//! Reading what files of other formats said.

use super::{Reader, excerpt};
use crate::file::FileError;
use crate::file::tree::Node;
use crate::foreign::{ForeignError, MAX_FOREIGN_BYTES, MAX_FOREIGN_TEXTS};

impl Reader<'_> {
    /// Maps of texts by format. What is something else, or more than a material holds, is kept as what this version does not know.
    pub(super) fn foreign(&mut self, node: &Node) -> Result<(), FileError> {
        let Some(formats) = self.map(node) else {
            self.unknown_key("", node, "expected a map { … } of maps of texts");
            return Ok(());
        };
        self.expect_unique(&formats, "foreign")?;
        // Asking the material each time would take long where millions of texts stand.
        let (mut count, mut bytes) = (0, 0);
        for format in &formats.nodes {
            let Some(texts) = self.map(format).filter(|_| format.is_name) else {
                self.unknown_key("foreign", format, "expected a map { … } of texts");
                continue;
            };
            let above = format!("foreign.{}", excerpt(&format.key));
            self.expect_unique(&texts, &above)?;
            for node in &texts.nodes {
                let text = self.string(node).filter(|_| node.is_name).ok_or(ForeignError::NotJson);
                let length = text.as_ref().map_or(0, String::len);
                let result = match text {
                    Ok(_) if count >= MAX_FOREIGN_TEXTS || bytes + length > MAX_FOREIGN_BYTES => Err(ForeignError::TooMuch),
                    text => text.and_then(|text| self.material.set_foreign(&format.key, &node.key, Some(text))),
                };
                match result {
                    Ok(()) => (count, bytes) = (count + 1, bytes + length),
                    Err(error) => self.unknown_key(&above, node, &error.to_string()),
                }
            }
        }
        Ok(())
    }
}
