//! Which images a document needs, and how those that do not exist are computed. The caller does it: this crate opens no files.

use crate::exchange::plan::Job;

/// All images of a document.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// Files that are taken as they are.
    pub copies: Vec<Copy>,
    /// Images that have to be computed.
    pub jobs: Vec<Job>,
    /// What comes out different, in sentences for the user.
    pub notes: Vec<String>,
}

/// A file that a document uses, or keeps for the native copies in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Copy {
    /// Path as the material has it: a file, or an image of this program (`builtin:…`), which is written as PNG.
    pub path: String,
    /// Where the document expects it: a path relative to its folder.
    pub file: String,
    /// Whether a texture of the document uses it; if not, it is there for the native copy.
    pub is_used: bool,
}
