//! How far loading is, told while it goes on, and whether it is still wanted, asked.

/// Somebody ended the work before its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ended;

/// Whom work tells how far it is; they say whether it is to go on. A part of a larger piece of work tells its share of that.
#[derive(Clone, Copy)]
pub struct Progress<'a> {
    listener: &'a dyn Fn(f32) -> bool,
    begin: f32,
    span: f32,
}

impl<'a> Progress<'a> {
    /// Nobody listens, nobody ends it.
    pub const NONE: Progress<'static> = Progress { listener: &|_| true, begin: 0.0, span: 1.0 };

    /// `listener` hears shares from 0 to 1 and answers whether the work is to go on.
    pub fn new(listener: &'a dyn Fn(f32) -> bool) -> Self {
        Self { listener, begin: 0.0, span: 1.0 }
    }

    /// The part of this work from `begin` to `end`, both from 0 to 1, as work of its own.
    pub fn part(self, begin: f32, end: f32) -> Self {
        Self { begin: self.begin + self.span * begin, span: self.span * (end - begin), ..self }
    }

    /// This share of the work is done, 0 to 1.
    pub fn tell(self, share: f32) -> Result<(), Ended> {
        let is_wanted = (self.listener)(self.begin + self.span * share.clamp(0.0, 1.0));
        is_wanted.then_some(()).ok_or(Ended)
    }

    /// So many of all are done.
    pub fn tell_count(self, done: usize, total: usize) -> Result<(), Ended> {
        self.tell(done as f32 / total.max(1) as f32)
    }
}
