//! Work that takes longer than a moment: what it is, how far, how long yet, and whether it can be ended.

/// What can be ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// Loading of the file, mesh or light of this number.
    Loading(u64),
    /// The final view; the preview is shown instead.
    FinalView,
    /// A debug view or an explained pixel; the material is shown instead.
    Debug,
    /// Measuring lobes.
    Costs,
    /// Making small pictures.
    SmallPictures,
    /// A contact sheet or pack of the library.
    HandOut,
    /// Checking the library.
    Check,
    /// Comparing the library with an earlier release.
    Release,
    /// Drawing two materials and their difference.
    PictureDiff,
    /// Rendering a picture or a turntable into files.
    Export,
    /// Drawing what other programs see of the material.
    Measuring,
    /// Writing the material for other programs.
    Exchange,
}

/// One piece of work.
#[derive(Clone, Debug, PartialEq)]
pub struct Work {
    /// What is being done.
    pub text: String,
    /// How much of it is done, 0 to 1, if that is known.
    pub progress: Option<f32>,
    /// Seconds until it is done, if that is known.
    pub remaining: Option<f64>,
    /// How to end it, if it can be.
    pub ends: Option<Ends>,
}

impl Work {
    /// Work of which only the name is known.
    pub fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), progress: None, remaining: None, ends: None }
    }
}
