//! Everything that came since the last look.

/// Messages that came since the last call, oldest first, and what is missing among them.
#[derive(Clone, Debug)]
pub struct Batch<I> {
    pub(crate) messages: I,
    /// Messages missing by their sequence, or pushed out before they were read.
    pub lost: u64,
    /// Restarts of the publisher among or before these messages.
    pub restarts: u64,
    /// Messages that failed their checks and were left out.
    pub invalid: u64,
}

impl<I: Iterator> IntoIterator for Batch<I> {
    type Item = I::Item;
    type IntoIter = I;

    fn into_iter(self) -> I {
        self.messages
    }
}
