//! Numbers as bytes, little-endian, for what is put aside and taken up again.

/// Appends numbers.
#[derive(Debug, Default)]
pub(super) struct Writer {
    /// Everything so far.
    pub bytes: Vec<u8>,
}

impl Writer {
    pub(super) fn u64(&mut self, x: u64) {
        self.bytes.extend(x.to_le_bytes());
    }

    pub(super) fn u32(&mut self, x: u32) {
        self.bytes.extend(x.to_le_bytes());
    }

    pub(super) fn f64(&mut self, x: f64) {
        self.u64(x.to_bits());
    }
}

/// Takes numbers in the order in which they were appended; `None` where there are no more.
#[derive(Debug)]
pub(super) struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.rest.split_first_chunk::<N>()?;
        self.rest = rest;
        Some(*first)
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        self.take().map(u64::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    pub(super) fn f64(&mut self) -> Option<f64> {
        self.u64().map(f64::from_bits)
    }

    /// A number of things of which each takes at least `bytes`: no more than there can be.
    pub(super) fn count(&mut self, bytes: usize) -> Option<usize> {
        let count = usize::try_from(self.u64()?).ok()?;
        (count.checked_mul(bytes)? <= self.rest.len()).then_some(count)
    }

    /// Whether at least so many bytes are left.
    pub(super) fn holds(&self, bytes: usize) -> bool {
        self.rest.len() >= bytes
    }

    pub(super) fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }
}
